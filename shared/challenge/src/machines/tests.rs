use super::machine;
use crate::bench::{BENCHES, kept};
use crate::equations::{Extra, Numbers, Vector};
use crate::random::Draw;
use dynamics::system::{System, Workspace};

/// Positions, then velocities, in the order of the machine, as the plant's state. The free hub of
/// the tank tells its velocity in body axes.
fn state_of(name: &str, n: usize, q: &Vector, v: &Vector) -> (Vec<f64>, Vec<f64>) {
    if name != "tank_planar" {
        return (q.as_slice()[..n].to_vec(), v.as_slice()[..n].to_vec());
    }
    let (sin, cos) = (libm::sin(q[2]), libm::cos(q[2]));
    let body = [cos * v[0] + sin * v[1], -sin * v[0] + cos * v[1]];
    (vec![q[0], q[1], q[2], q[3]], vec![v[2], body[0], body[1], v[3]])
}

#[test]
fn closed_forms_move_like_the_plants_they_stand_for() {
    for bench in BENCHES {
        let plant = kept(bench);
        let system = System::new(&plant).unwrap();
        let mut workspace = Workspace::new(&system);
        let equations = machine(bench.plant, &Numbers::of(&plant), Extra::default());
        let n = equations.dof();
        for trial in 0..20 {
            let mut draw = Draw::new(1, trial, bench.plant);
            let mut q = Vector::zeros();
            let mut v = Vector::zeros();
            for i in 0..n {
                (q[i], v[i]) = (draw.uniform(-0.5, 0.5), draw.uniform(-0.5, 0.5));
            }
            let u: Vec<f64> = (0..plant.actuators.len()).map(|_| draw.uniform(-1.0, 1.0)).collect();
            let a = equations.mass(&q).cholesky().unwrap().solve(&equations.force(&q, &v, &u));
            let (position, velocity) = state_of(bench.plant, n, &q, &v);
            let x: Vec<f64> = position.into_iter().chain(velocity).collect();
            assert_eq!(x.len(), system.states().len(), "{}", bench.plant);
            let mut x_dot = vec![0.0; x.len()];
            system.derivative(&mut workspace, 0.0, &x, &u, &mut x_dot);
            // the tank's in body axes: R' turned away, less the turn of the axes
            let mine = match bench.plant {
                "tank_planar" => {
                    let (sin, cos) = (libm::sin(q[2]), libm::cos(q[2]));
                    let body = [cos * v[0] + sin * v[1], -sin * v[0] + cos * v[1]];
                    vec![
                        a[2],
                        cos * a[0] + sin * a[1] + v[2] * body[1],
                        -sin * a[0] + cos * a[1] - v[2] * body[0],
                        a[3],
                    ]
                }
                _ => a.as_slice()[..n].to_vec(),
            };
            let size = mine.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
            for (i, (ours, theirs)) in mine.iter().zip(&x_dot[n..]).enumerate() {
                // rounding of a dozen terms
                assert!((ours - theirs).abs() < 1e-12 * size, "{} {i}: {ours} {theirs}", bench.plant);
            }
            let mut y = vec![0.0; plant.sensors.len()];
            let mut readings = y.clone();
            equations.read(&q, &v, &a, &mut y);
            if bench.plant != "tank_planar" {
                system.read(&mut workspace, 0.0, &x, &u, &mut readings);
                for (ours, theirs) in y.iter().zip(&readings) {
                    assert!((ours - theirs).abs() < 1e-12 * size, "{}: {ours} {theirs}", bench.plant);
                }
            }
        }
    }
}
