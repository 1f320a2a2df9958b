//! Momentum and energy along trajectories without external work.

use super::*;

/// Work space of classical Runge–Kutta on (q, v).
struct Rk4 {
    data: Data<f64>,
    zero: Vec<f64>,
}

impl Rk4 {
    fn new(model: &Model) -> Self {
        Self { data: Data::new(model), zero: vec![0.0; model.v_len()] }
    }

    fn rate(&mut self, model: &Model, q: &[f64], v: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (mut q_dot, mut v_dot) = (vec![0.0; q.len()], vec![0.0; v.len()]);
        position_rate(model, q, v, &mut q_dot);
        forward_dynamics(model, &mut self.data, q, v, &self.zero, &[], &mut v_dot);
        (q_dot, v_dot)
    }

    fn step(&mut self, model: &Model, q: &mut [f64], v: &mut [f64], dt: f64) {
        let add = |x: &[f64], k: &[f64], h: f64| x.iter().zip(k).map(|(x, k)| x + h * k).collect::<Vec<_>>();
        let k1 = self.rate(model, q, v);
        let k2 = self.rate(model, &add(q, &k1.0, dt / 2.0), &add(v, &k1.1, dt / 2.0));
        let k3 = self.rate(model, &add(q, &k2.0, dt / 2.0), &add(v, &k2.1, dt / 2.0));
        let k4 = self.rate(model, &add(q, &k3.0, dt), &add(v, &k3.1, dt));
        let advance = |x: &mut [f64], k1: &[f64], k2: &[f64], k3: &[f64], k4: &[f64]| {
            for (i, x) in x.iter_mut().enumerate() {
                *x += dt / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
            }
        };
        advance(q, &k1.0, &k2.0, &k3.0, &k4.0);
        advance(v, &k1.1, &k2.1, &k3.1, &k4.1);
    }
}

/// Angular momentum about the origin, linear momentum, energy.
fn invariants(model: &Model, q: &[f64], v: &[f64]) -> [f64; 7] {
    let mut data = Data::new(model);
    let h = momentum(model, &mut data, q, v);
    let energy = kinetic_energy(model, &mut data, q, v) + potential_energy(model, &mut data, q, v);
    let [a, b, c] = h.angular_about_origin;
    let [d, e, f] = h.linear;
    [a, b, c, d, e, f, energy]
}

/// Change of each invariant, relative to its own size at the start, after one second in `steps`
/// steps.
fn drift(model: &Model, state: &State, steps: u32) -> [f64; 7] {
    let (mut q, mut v) = (state.q.clone(), state.v.clone());
    let mut rk4 = Rk4::new(model);
    for _ in 0..steps {
        rk4.step(model, &mut q, &mut v, 1.0 / f64::from(steps));
    }
    let (start, end) = (invariants(model, &state.q, &state.v), invariants(model, &q, &v));
    core::array::from_fn(|i| (end[i] - start[i]).abs() / (1.0 + norm(&start)))
}

/// Free-floating trees whose joints carry no rotor (a rotor's momentum is not counted) and rest on
/// one root.
fn floating(seed: u64, internals: bool) -> (Model, State) {
    let mut draw = Draw::new(seed);
    let mut links = vec![draw.link(None, JointKind::FreeSpatial)];
    for i in 0..4 {
        let axis = draw.unit();
        let joint = if i == 2 { JointKind::Prismatic { axis } } else { JointKind::Revolute { axis } };
        let parent = Some(draw.index(links.len()));
        let mut link = draw.link(parent, joint);
        link.armature = 0.0;
        links.push(link);
    }
    let internals: Vec<_> = (0..if internals { 3 } else { 0 }).map(|i| draw.internal(i)).collect();
    let model = Model::new(&links, &internals, Vector3::zeros()).unwrap();
    let state = draw.state(&model);
    (model, state)
}

#[test]
fn momentum_and_energy_of_free_floating_trees_drift_to_fourth_order_and_fall_to_rounding() {
    for internals in [false, true] {
        let mut orders = Vec::new();
        for seed in 0..6 {
            let (model, state) = floating(seed, internals);
            let (coarse, fine) = (drift(&model, &state, 64), drift(&model, &state, 128));
            let total = |drift: &[f64; 7]| norm(drift);
            orders.push((total(&coarse) / total(&fine)).log2());
            let smallest = total(&drift(&model, &state, 4096));
            assert!(smallest < 2e-13, "seed {seed}: {smallest:e}"); // rounding of 4096 steps
        }
        orders.sort_by(f64::total_cmp);
        // the invariants of RK4 drift to its order 4, one better where the leading term happens to
        // cancel
        assert!(orders.iter().all(|p| (3.8..=5.3).contains(p)), "{orders:?}");
    }
}

#[test]
fn trajectories_converge_with_order_four() {
    for seed in 0..4 {
        let (model, state) = floating(seed, true);
        let run = |steps: u32| {
            let (mut q, mut v) = (state.q.clone(), state.v.clone());
            let mut rk4 = Rk4::new(&model);
            for _ in 0..steps {
                rk4.step(&model, &mut q, &mut v, 1.0 / f64::from(steps));
            }
            [q, v].concat()
        };
        let (a, b, c) = (run(64), run(128), run(256));
        let order = (difference(&a, &b) / difference(&b, &c)).log2();
        assert!((3.9..=4.1).contains(&order), "seed {seed}: {order}");
    }
}

#[test]
fn energy_is_conserved_under_gravity_on_every_kind_of_root() {
    for (seed, root) in roots().into_iter().enumerate() {
        let mut draw = Draw::new(50 + seed as u64);
        let mut model = draw.tree(root, GRAVITY);
        model.internals.clear();
        let state = draw.state(&model);
        let state = State { v: state.v[..model.v_len()].to_vec(), ..state };
        let energy = drift(&model, &state, 8192)[6];
        assert!(energy < 1e-11, "{root:?}: {energy:e}"); // truncation at 0.1 ms, fourth order
    }
}

#[test]
fn free_fall_moves_the_centre_of_mass_with_gravity_alone() {
    for seed in 0..5 {
        let mut draw = Draw::new(80 + seed);
        let mut links = vec![draw.link(None, JointKind::FreeSpatial)];
        let axis = draw.unit();
        links.push(draw.link(Some(0), JointKind::Revolute { axis }));
        let model = Model::new(&links, &[], GRAVITY).unwrap();
        let mut state = draw.state(&model);
        state.tau[..6].fill(0.0); // nothing outside pushes
        let a = accelerations(&model, &state, &[]);
        // d(momentum)/dt by dual numbers along the motion
        let mut q_dot = vec![0.0; model.q_len()];
        position_rate(&model, &state.q, &state.v, &mut q_dot);
        let moving = |x: &[f64], rate: &[f64]| x.iter().zip(rate).map(|(x, r)| Dual::new(*x, *r)).collect::<Vec<_>>();
        let (q, v) = (moving(&state.q, &q_dot), moving(&state.v, &a));
        let h = momentum(&model, &mut Data::new(&model), &q, &v);
        for k in 0..3 {
            assert!((h.linear[k].derivative - h.mass * GRAVITY[k]).abs() <= 1e-11 * h.mass * GRAVITY.norm());
            assert!(h.angular_about_com[k].derivative.abs() <= 1e-11 * h.mass * GRAVITY.norm());
            assert!((h.com[k].derivative * h.mass - h.linear[k].value).abs() <= 1e-12 * h.mass);
        }
    }
}
