//! Momentum and energy, at an instant and exactly: totals of a state that moves along its
//! derivative, in dual numbers.

use super::*;
use crate::system::Totals;

fn rate_of_totals(system: &System, x: &[f64], u: &[f64]) -> Totals<Dual> {
    let mut ws = Workspace::<Dual>::new(system);
    let u: Vec<Dual> = u.iter().map(|u| Dual::new(*u, 0.0)).collect();
    let at: Vec<f64> = u.iter().map(|u| u.value).collect();
    system.totals(&mut ws, &moving(system, x, &at), &u)
}

#[test]
fn internal_efforts_leave_both_momenta_of_a_floating_plant_with_everything_on_it() {
    let system = System::new(&everything(true)).unwrap();
    for seed in 0..64 {
        let x = random_state(&system, seed);
        let totals = rate_of_totals(&system, &x, &[3.0, -8.0, 0.7, -0.4]);
        let force = totals.linear_momentum_n_s.map(|p| p.derivative);
        let torque = totals.angular_momentum_origin_n_m_s.map(|h| h.derivative);
        // rounding of sums of forces of up to some hundred newton on arms of a few metres
        assert!(force.iter().chain(&torque).all(|f| f.abs() < 1e-10), "seed {seed}: {force:?} {torque:?}");
    }
}

#[test]
fn momentum_keeps_for_seconds_of_motion_with_everything_on_it() {
    let system = System::new(&everything(true)).unwrap();
    let mut x = random_state(&system, 4);
    let totals = |x: &[f64]| system.totals(&mut Workspace::<f64>::new(&system), x, &[0.0; 4]);
    let start = totals(&x);
    integrate(&system, &mut x, &[0.0; 4], 1e-3, 2000);
    let end = totals(&x);
    for k in 0..3 {
        // truncation of RK4: seen to fall by 16 with the step; scale some hundred N m s
        let drift = end.angular_momentum_origin_n_m_s[k] - start.angular_momentum_origin_n_m_s[k];
        assert!(drift.abs() < 1e-8, "{drift:e}");
        assert!((end.linear_momentum_n_s[k] - start.linear_momentum_n_s[k]).abs() < 1e-8);
    }
}

#[test]
fn without_dampers_energy_keeps_and_with_them_it_falls_by_what_they_take() {
    for damped in [false, true] {
        let system = System::new(&everything(damped)).unwrap();
        for seed in 0..64 {
            let x = random_state(&system, seed);
            let totals = rate_of_totals(&system, &x, &[0.0; 4]);
            let energy = totals.kinetic_energy_j + totals.potential_energy_j;
            assert!((totals.dissipated_w.value > 0.0) == damped);
            // rounding of powers of some kilowatt that cancel
            let error = energy.derivative + totals.dissipated_w.value;
            assert!(error.abs() < 1e-9, "seed {seed}, damped {damped}: {error:e}");
        }
    }
}

#[test]
fn efforts_of_joints_do_the_work_they_should() {
    let system = System::new(&everything(false)).unwrap();
    let x = random_state(&system, 11);
    let u = [3.0, -8.0, 0.7, -0.4];
    let totals = rate_of_totals(&system, &x, &u);
    let energy = totals.kinetic_energy_j.derivative + totals.potential_energy_j.derivative;
    let rate = |name: &str| x[index(&system, name)];
    // a wheel's torque is that on the body: its rotor feels the opposite
    let wheels = u[2] * rate("wheel:wheel1") + u[3] * rate("wheel:wheel2");
    let work = u[0] * rate("joint:hinge.rate") + u[1] * rate("joint:slide.rate") - wheels;
    assert!((energy - work).abs() < 1e-9, "{energy} {work}"); // as above
}

#[test]
fn weight_bends_panels_and_is_part_of_their_energy() {
    let mut plant = everything(false);
    plant.environment.gravity_m_s2 = three([1.0, -2.0, 3.0]);
    let system = System::new(&plant).unwrap();
    for seed in 0..16 {
        let totals = rate_of_totals(&system, &random_state(&system, seed), &[0.0; 4]);
        let change = totals.kinetic_energy_j.derivative + totals.potential_energy_j.derivative;
        assert!(change.abs() < 1e-9, "seed {seed}: {change:e}"); // rounding of powers of some kilowatt
    }
}

#[test]
fn weight_is_part_of_the_energy_of_a_pendulum_on_a_cart() {
    let mut plant = Plant { space: Space::Planar, ..Plant::default() };
    plant.environment.gravity_m_s2 = three([0.0, -9.81, 0.0]);
    let rail = joint("rail", JointKind::Prismatic { axis: [1.0, 0.0, 0.0] }, [0.0; 3]);
    plant.bodies = vec![body("cart", None, rail, 5.0, [0.0; 3], [0.0; 3])];
    plant.tanks = vec![pendulum_tank("bob", "cart", [0.0, 0.1, 0.0], 2.0, [0.0, -1.0, 0.0], 0.7, 0.0)];
    let system = System::new(&plant).unwrap();
    for seed in 0..16 {
        let totals = rate_of_totals(&system, &random_state(&system, seed), &[]);
        let change = totals.kinetic_energy_j.derivative + totals.potential_energy_j.derivative;
        assert!(change.abs() < 1e-13 * 20.0, "{change:e}"); // rounding of powers of 20 W
    }
    // small swings with the cart held by its mass: ω² = g/L (1 + m/M)
    let modes = system.modes(&mut Workspace::new(&system), 0.0, &[0.0; 4], &[]);
    let expected = (9.81f64 / 0.7 * (1.0 + 2.0 / 5.0)).sqrt() / core::f64::consts::TAU;
    assert_eq!((modes.modes.len(), modes.zeros), (1, 2));
    assert!((modes.modes[0].frequency_hz / expected - 1.0).abs() < 1e-12, "{modes:?}"); // rounding of an eigenvalue
    assert_eq!(modes.modes[0].label, "tank:bob");
}

/// A uniform velocity of everything changes nothing that is felt inside, with bending panels as
/// without.
#[test]
fn joints_tanks_and_modes_do_not_feel_a_uniform_velocity() {
    let system = System::new(&everything(true)).unwrap();
    let mut x = random_state(&system, 8);
    let still = rates(&system, &x, &[0.0; 4]);
    let first = index(&system, "body:hub.x.rate");
    let boost = crate::system::geometry::turn_back(
        &{
            let mut ws = Workspace::<f64>::new(&system);
            system.place(&mut ws, &x, &[0.0; 4]);
            ws.data.link_pose(0).1
        },
        [30.0, -20.0, 10.0],
    );
    (0..3).for_each(|k| x[first + k] += boost[k]);
    let moved = rates(&system, &x, &[0.0; 4]);
    for k in (first + 3..x.len()).chain(first - 3..first) {
        // rounding beside 40 m/s times rad/s and the coupling's gain
        assert!((moved[k] - still[k]).abs() < 1e-11, "{}: {} {}", system.states()[k].name, moved[k], still[k]);
    }
}

#[test]
fn gravity_gradient_turns_the_whole_as_its_inertia_says_and_pushes_nothing() {
    let mut plant = everything(false);
    plant.appendages.clear(); // the tide does not know modes
    let n = 0.0011;
    let orbit = crate::description::GravityGradient { orbit_rate_rad_s: known(n), phase_rad: known(0.4) };
    plant.environment.gravity_gradient = Some(orbit);
    let system = System::new(&plant).unwrap();
    let x = random_state(&system, 5);
    let totals = rate_of_totals(&system, &x, &[0.0; 4]);
    let torque = totals.angular_momentum_com_n_m_s.map(|h| h.derivative);
    let expected = gradient_torque(&system, &x, n, 0.4);
    for k in 0..3 {
        // rounding beside internal forces of 100 N and arms of metres; the torque itself is 1e-4 N
        // m
        assert!((torque[k] - expected[k]).abs() < 1e-10, "{torque:?} {expected:?}");
        assert!(totals.linear_momentum_n_s[k].derivative.abs() < 1e-10);
    }
    assert!(expected.iter().any(|t| t.abs() > 1e-5), "{expected:?}");
}

/// `3 n² r × I r` from the second moments of all links about the centre of mass.
fn gradient_torque(system: &System, x: &[f64], n: f64, phase: f64) -> [f64; 3] {
    use nalgebra::{Matrix3, Vector3};
    let mut ws = Workspace::<f64>::new(system);
    let com = Vector3::from(system.totals(&mut ws, x, &[0.0; 4]).com_m);
    let mut inertia = Matrix3::zeros();
    for (i, link) in system.model.links.iter().enumerate() {
        let (origin, rows) = ws.data.link_pose(i);
        let rotation = Matrix3::from_fn(|i, j| rows[i][j]);
        let own = Matrix3::from(system.inertia_com[i]);
        let offset = Vector3::from(origin) + rotation * Vector3::from(link.com.array()) - com;
        let steiner = Matrix3::identity() * offset.norm_squared() - offset * offset.transpose();
        inertia += rotation * own * rotation.transpose() + steiner * link.mass;
    }
    let r = Vector3::new(libm::cos(phase), libm::sin(phase), 0.0);
    (r.cross(&(inertia * r)) * (3.0 * n * n)).into()
}
