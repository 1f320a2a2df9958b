//! What must not depend on where, how turned, and in how many dimensions the system is described.

use super::*;

fn floating_arm(seed: u64, internals: usize) -> (Model, State) {
    let mut draw = Draw::new(seed);
    let mut links = vec![Link {
        position_m: Vector3::zeros(),
        rotation: Matrix3::identity(),
        ..draw.link(None, JointKind::FreeSpatial)
    }];
    for i in 0..3 {
        let axis = draw.unit();
        links.push(draw.link(Some(i), JointKind::Revolute { axis }));
    }
    let internals: Vec<_> = (0..internals).map(|i| draw.internal(i)).collect();
    let model = Model::new(&links, &internals, Vector3::zeros()).unwrap();
    let state = draw.state(&model);
    (model, state)
}

#[test]
fn translating_and_turning_the_world_changes_no_acceleration_in_body_axes() {
    for seed in 0..20 {
        let (model, state) = floating_arm(seed, 2);
        let here = accelerations(&model, &state, &state.wrench);
        let mut elsewhere = state;
        for (k, shift) in [120.0, -70.0, 33.0].into_iter().enumerate() {
            elsewhere.q[k] += shift;
        }
        let other: Vec<f64> = Draw::new(seed + 7).position(&model)[3..7].to_vec();
        elsewhere.q[3..7].copy_from_slice(&other);
        let there = accelerations(&model, &elsewhere, &elsewhere.wrench);
        assert!(difference(&here, &there) <= 1e-12 * norm(&here)); // rounding × condition of M
    }
}

#[test]
fn length_of_the_quaternion_is_of_no_consequence() {
    let (model, mut state) = floating_arm(3, 1);
    let unit = accelerations(&model, &state, &[]);
    state.q[3..7].iter_mut().for_each(|x| *x *= 1.7);
    assert!(difference(&unit, &accelerations(&model, &state, &[])) <= 1e-13 * norm(&unit));
}

#[test]
fn a_uniform_velocity_changes_no_acceleration_of_rigid_bodies() {
    let (model, state) = floating_arm(4, 0);
    let mut data = Data::new(&model);
    let mut a = vec![0.0; model.v_len()];
    let mut felt = |v: &[f64]| {
        forward_dynamics(&model, &mut data, &state.q, v, &state.tau, &[], &mut a);
        (data.specific_force(2, [0.1, 0.2, 0.3]), a[6..].to_vec())
    };
    let mut faster = state.v.clone();
    for (k, shift) in [50.0, -20.0, 70.0].into_iter().enumerate() {
        faster[3 + k] += shift;
    }
    let (at_rest, moving) = (felt(&state.v), felt(&faster));
    // rounding: the linear velocity enters no equation of rigid bodies
    assert!(difference(&at_rest.0, &moving.0) <= 1e-13 * norm(&at_rest.0));
    assert!(difference(&at_rest.1, &moving.1) <= 1e-13 * norm(&at_rest.1));
}

fn planar_tree(seed: u64, base: JointKind) -> Model {
    let mut draw = Draw::new(seed);
    let flat = |link: Link| Link {
        position_m: Vector3::new(link.position_m.x, link.position_m.y, 0.0),
        rotation: Rotation3::from_axis_angle(&Vector3::z_axis(), link.position_m.z).into_inner(),
        com_m: Vector3::new(link.com_m.x, link.com_m.y, 0.0),
        inertia_com_kg_m2: Matrix3::from_diagonal(&link.inertia_com_kg_m2.diagonal()),
        ..link
    };
    let mut links = vec![flat(draw.link(None, base))];
    (links[0].position_m, links[0].rotation) = (Vector3::zeros(), Matrix3::identity());
    for i in 0..3 {
        let joint = if i == 1 {
            JointKind::Prismatic { axis: Vector3::y() }
        } else {
            JointKind::Revolute { axis: Vector3::z() }
        };
        links.push(flat(draw.link(Some(i), joint)));
    }
    Model::new(&links, &[], Vector3::new(0.3, -0.8, 0.0)).unwrap()
}

#[test]
fn a_planar_base_moves_like_a_spatial_one_that_is_kept_in_the_plane() {
    for seed in 0..20 {
        let (planar, spatial) = (planar_tree(seed, JointKind::FreePlanar), planar_tree(seed, JointKind::FreeSpatial));
        let mut draw = Draw::new(seed + 500);
        let (q, v, tau) = (draw.numbers(6), draw.numbers(6), draw.numbers(6));
        let state = State { q: q.clone(), v: v.clone(), tau: tau.clone(), a: vec![], wrench: vec![] };
        let flat = accelerations(&planar, &state, &[]);
        let (sin, cos) = libm::sincos(q[2] / 2.0);
        let spread = |x: &[f64]| [&[0.0, 0.0, x[0], x[1], x[2], 0.0][..], &x[3..]].concat();
        let state = State {
            q: [&[q[0], q[1], 0.0, cos, 0.0, 0.0, sin][..], &q[3..]].concat(),
            v: spread(&v),
            tau: spread(&tau),
            a: vec![],
            wrench: vec![],
        };
        let space = accelerations(&spatial, &state, &[]);
        assert!(difference(&spread(&flat), &space) <= 1e-12 * norm(&flat)); // rounding × condition of M
    }
}

#[test]
fn planar_arm_is_the_chain_of_jacobians() {
    use nalgebra::SVector;
    use simulation::oracle::arm_parameters::ArmParameters;
    use simulation::oracle::chain::Motion;
    let arm = ArmParameters::paper_table_ii();
    let model = table_ii_arm();
    for seed in 0..50 {
        let mut draw = Draw::new(seed);
        let (q, v): (Vec<f64>, Vec<f64>) = (draw.numbers(5), draw.numbers(5));
        let mut q_dot = vec![0.0; 5];
        position_rate(&model, &q, &v, &mut q_dot);
        let state =
            State { q: q.clone(), v: v.clone(), tau: vec![0.0, 0.0, 0.0, 3.0, -2.0], a: vec![], wrench: vec![] };
        let a = accelerations(&model, &state, &[]);
        let motion = Motion { q: SVector::from_column_slice(&q), q_dot: SVector::from_column_slice(&q_dot) };
        let (mass, bias) = arm.chain().mass_and_bias(&motion);
        let force = SVector::<f64, 5>::from([0.0, 0.0, 0.0, 3.0, -2.0]);
        let q_ddot = mass.lu().solve(&(force - bias)).unwrap();
        for (found, expected) in [a[0], a[3], a[4]].into_iter().zip([q_ddot[2], q_ddot[3], q_ddot[4]]) {
            assert!((found - expected).abs() <= 1e-12 * q_ddot.norm().max(norm(&v))); // rounding × condition of M
        }
    }
}

/// Table II of the benchmark, planar.
pub(super) fn table_ii_arm() -> Model {
    use simulation::oracle::arm_parameters::ArmParameters;
    let arm = ArmParameters::paper_table_ii();
    let link = |parent, joint, at: [f64; 2], mass_kg, com: f64, inertia: f64| Link {
        parent,
        joint,
        position_m: Vector3::new(at[0], at[1], 0.0),
        rotation: Matrix3::identity(),
        mass_kg,
        com_m: Vector3::new(com, 0.0, 0.0),
        inertia_com_kg_m2: Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, inertia)),
        armature: 0.0,
    };
    let z = JointKind::Revolute { axis: Vector3::z() };
    let reach = arm.l_m[0] + arm.r_m[0];
    let [m1, m2] = arm.link_mass_kg;
    let [i1, i2] = arm.link_inertia_com_kg_m2;
    let links = [
        link(None, JointKind::FreePlanar, [0.0; 2], arm.base_mass_kg, 0.0, arm.base_inertia_com_kg_m2),
        link(Some(0), z, arm.r0_m, m1, arm.l_m[0], i1),
        link(Some(1), z, [reach, 0.0], m2, arm.l_m[1], i2),
    ];
    Model::new(&links, &[], Vector3::zeros()).unwrap()
}

#[test]
fn constant_velocity_for_a_time_is_twice_half_the_time() {
    for (model, state) in random_trees() {
        let (mut whole, mut half, mut twice) = (state.q.clone(), state.q.clone(), state.q.clone());
        integrate_position(&model, &state.q, &state.v, 1.4, &mut whole);
        integrate_position(&model, &state.q, &state.v, 0.7, &mut half);
        integrate_position(&model, &half, &state.v, 0.7, &mut twice);
        assert!(difference(&whole, &twice) <= 1e-14 * 10.0 * norm(&whole)); // rounding; short turns by series, long by sin
    }
}

#[test]
fn rate_of_position_is_the_derivative_of_the_step() {
    for (model, state) in random_trees() {
        let lift = |x: &[f64]| x.iter().map(|x| Dual::constant(*x)).collect::<Vec<_>>();
        let mut moved = lift(&state.q);
        integrate_position(&model, &lift(&state.q), &lift(&state.v), Dual::variable(0.0), &mut moved);
        let mut rate = vec![0.0; model.q_len()];
        position_rate(&model, &state.q, &state.v, &mut rate);
        let step: Vec<f64> = moved.iter().map(|x| x.derivative).collect();
        assert!(difference(&rate, &step) <= 1e-14 * 10.0 * norm(&rate)); // rounding
    }
}
