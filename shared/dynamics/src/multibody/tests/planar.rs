//! The planar kernels against the general ones, on random trees in the plane.

use super::*;

/// A tree in the plane: a free or fixed root, then revolute (either sense), prismatic and fixed
/// joints on random parents.
fn plane_tree(draw: &mut Draw, gravity: Vector3<f64>) -> Model {
    let flat = |v: Vector3<f64>| Vector3::new(v.x, v.y, 0.0);
    let mut links = Vec::new();
    for i in 0..7usize {
        let (sense, angle, parent) = (draw.number(), draw.number(), draw.index(i.max(1)));
        let joint = match (i, draw.index(4)) {
            (0, 0 | 1) => JointKind::FreePlanar,
            (0, _) => JointKind::Fixed,
            (_, 0 | 1) => JointKind::Revolute { axis: Vector3::z() * sense.signum() },
            (_, 2) => JointKind::Prismatic { axis: flat(draw.vector()).normalize() },
            _ => JointKind::Fixed,
        };
        let (sin, cos) = libm::sincos(3.0 * angle);
        links.push(Link {
            parent: (i > 0).then_some(parent),
            joint,
            position_m: flat(draw.vector()),
            rotation: Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0),
            mass_kg: 1.0 + libm::fabs(sense),
            com_m: flat(draw.vector()),
            inertia_com_kg_m2: Matrix3::new(1.1, 0.2, 0.0, 0.2, 0.9, 0.0, 0.0, 0.0, 1.0 + libm::fabs(angle)),
            armature: if matches!(joint, JointKind::Revolute { .. }) { 0.3 } else { 0.0 },
        });
    }
    let along = flat(draw.vector()) * 0.2;
    let internals = [
        InternalCoordinate { link: 3, mass: 0.4, coupling: [0.0, 0.0, 0.1, along.x, along.y, 0.0] },
        InternalCoordinate { link: 0, mass: 0.2, coupling: [0.0, 0.0, 0.2, 0.0, 0.0, 0.0] },
    ];
    Model::new(&links, &internals, gravity).unwrap()
}

/// All that can be read after a call.
fn everything(model: &Model, data: &Data<f64>) -> Vec<f64> {
    let point = [0.3, -0.2, 0.1];
    let of_link = |link: usize| {
        let (origin, rotation) = data.link_pose(link);
        let mut all: Vec<f64> = origin.into_iter().chain(rotation.into_iter().flatten()).collect();
        all.extend(data.link_velocity(link));
        all.extend(data.link_acceleration(link));
        all.extend(data.joint_wrench(link));
        all.extend(data.specific_force(link, point));
        all
    };
    (0..model.links_len()).flat_map(of_link).collect()
}

#[test]
fn the_planar_kernels_agree_with_the_general_ones_on_every_plane_tree() {
    for seed in 0..200 {
        let mut draw = Draw::new(seed);
        let model = plane_tree(&mut draw, GRAVITY + Vector3::new(0.7, -0.4, 0.0));
        assert!(model.plane);
        let mut general = model.clone();
        general.plane = false;
        let (n, links) = (model.v_len(), model.links_len());
        let (q, v, tau) = (draw.numbers(model.q_len()), draw.numbers(n), draw.numbers(n));
        // reactions leave the plane where something pushes out of it
        let wrench: Vec<[f64; 6]> = (0..links).map(|_| core::array::from_fn(|k| draw.numbers(k + 1)[k])).collect();
        let shift = draw.numbers(1);
        let given: Vec<bool> =
            (0..n).map(|k| k >= model.joint_v_len(0) && (seed as usize + k).is_multiple_of(3)).collect();
        let run = |model: &Model, prescribed: bool, carries: bool| {
            let (mut data, mut tau, mut a) = (Data::new(model), tau.clone(), tau.clone());
            if carries {
                data.set_internal_positions(model, &shift);
                data.set_added_mass(2, 0.7, [0.1, -0.3, 0.0]);
            }
            if prescribed {
                forward_dynamics_prescribed(model, &mut data, &q, &v, &given, &mut tau, &wrench, &mut a);
            } else {
                forward_dynamics(model, &mut data, &q, &v, &tau, &wrench, &mut a);
            }
            let mut all = everything(model, &data);
            all.extend(a.iter().chain(&tau));
            inverse_dynamics(model, &mut data, &q, &v, &a, &wrench, &mut tau);
            all.extend(everything(model, &data).iter().chain(&tau));
            all
        };
        for (prescribed, carries) in [(false, false), (true, false), (false, true), (true, true)] {
            let (plane, space) = (run(&model, prescribed, carries), run(&general, prescribed, carries));
            // rounding × condition of the trees, up to some hundreds
            let error = difference(&plane, &space) / norm(&space);
            assert!(error < 1e-12, "seed {seed}, prescribed {prescribed}, carries {carries}: {error:e}");
        }
    }
}

#[test]
fn what_leaves_the_plane_is_left_to_the_general_kernels() {
    let planar = |change: &dyn Fn(&mut Link)| {
        let mut link = Link {
            parent: None,
            joint: JointKind::Revolute { axis: Vector3::z() },
            position_m: Vector3::zeros(),
            rotation: Matrix3::identity(),
            mass_kg: 1.0,
            com_m: Vector3::x(),
            inertia_com_kg_m2: Matrix3::identity(),
            armature: 0.0,
        };
        change(&mut link);
        Model::new(&[link], &[], GRAVITY).unwrap().plane
    };
    assert!(planar(&|_| {}));
    assert!(!planar(&|link| link.com_m.z = 0.1));
    assert!(!planar(&|link| link.position_m.z = 0.1));
    assert!(!planar(&|link| link.joint = JointKind::Revolute { axis: Vector3::x() }));
    assert!(!planar(&|link| link.joint = JointKind::Prismatic { axis: Vector3::z() }));
    assert!(!planar(&|link| link.rotation = Matrix3::new(1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0)));
    assert!(!planar(&|link| (link.inertia_com_kg_m2[(0, 2)], link.inertia_com_kg_m2[(2, 0)]) = (0.1, 0.1)));
}

#[test]
fn a_floating_base_takes_the_momentum_that_is_asked_for() {
    for seed in 0..50 {
        let mut draw = Draw::new(seed);
        for model in [six_joint_arm(JointKind::FreeSpatial, Vector3::zeros()), super::invariance::table_ii_arm()] {
            let state = draw.state(&model);
            let (mut data, mut v) = (Data::new(&model), state.v.clone());
            let mut wanted = [3.0, -2.0, 5.0];
            if model.plane {
                (wanted[0], wanted[1]) = (0.0, 0.0);
            }
            assert!(float_at_momentum(&model, &mut data, &state.q, &mut v, wanted));
            let kept = model.joint_v_len(0);
            assert_eq!(v[kept..], state.v[kept..]);
            let after = momentum_after_kinematics(&model, &data, &v);
            let found = momentum(&model, &mut Data::new(&model), &state.q, &v);
            let axes = nalgebra::Matrix3::from(data.link_pose(0).1).transpose();
            let expected: [f64; 3] = (axes * Vector3::from(wanted)).into();
            // rounding of sums as large as mass × reach × rate
            let scale = 1e-14 * model.mass_kg() * 100.0;
            assert!(difference(&found.linear, &[0.0; 3]) < scale, "{:?}", found.linear);
            assert!(
                difference(&found.angular_about_com, &expected) < scale,
                "{:?} {expected:?}",
                found.angular_about_com
            );
            assert!(difference(&after.angular_about_com, &found.angular_about_com) < scale);
        }
    }
}

#[test]
#[should_panic(expected = "constant inertias only")]
fn analytic_derivatives_refuse_what_a_link_carries() {
    let model = super::invariance::table_ii_arm();
    let state = Draw::new(1).state(&model);
    let mut data = Data::new(&model);
    data.set_added_mass(1, 0.5, [0.0; 3]);
    let (mut by_q, mut by_v) = (DMatrix::zeros(5, 5), DMatrix::zeros(5, 5));
    inverse_dynamics_derivatives(&model, &mut data, &state.q, &state.v, &state.a, &mut by_q, &mut by_v);
}

#[test]
#[should_panic(expected = "constant inertias only")]
fn regressors_refuse_what_a_link_carries() {
    let model = super::invariance::table_ii_arm();
    let state = Draw::new(1).state(&model);
    let mut data = Data::new(&model);
    data.set_added_mass(1, 0.5, [0.0; 3]);
    inverse_dynamics_regressor(&model, &mut data, &state.q, &state.v, &state.a, &mut DMatrix::zeros(5, 30));
}
