//! Internal coordinates against the bodies they stand for.

use super::*;

fn block(mass_kg: f64, joint: JointKind, parent: Option<usize>) -> Link {
    Link {
        parent,
        joint,
        position_m: Vector3::zeros(),
        rotation: Matrix3::identity(),
        mass_kg,
        com_m: Vector3::new(0.1, -0.2, 0.3),
        inertia_com_kg_m2: Matrix3::from_diagonal(&Vector3::new(3.0, 4.0, 5.0)) * mass_kg,
        armature: 0.0,
    }
}

#[test]
fn a_reaction_wheel_as_internal_coordinate_is_an_axisymmetric_body_on_a_revolute_joint() {
    for seed in 0..20 {
        let mut draw = Draw::new(seed);
        let (axis, at) = (draw.unit(), draw.vector());
        let hub = block(20.0, JointKind::FreeSpatial, None);
        let (j_axis, j_across, m_w) = (0.3, 0.2, 2.0);
        let wheel_inertia = Matrix3::identity() * j_across + axis * axis.transpose() * (j_axis - j_across);
        let wheel = Link {
            position_m: at,
            com_m: Vector3::zeros(),
            mass_kg: m_w,
            inertia_com_kg_m2: wheel_inertia,
            ..block(1.0, JointKind::Revolute { axis }, Some(0))
        };
        let two_bodies = Model::new(&[hub.clone(), wheel.clone()], &[], GRAVITY).unwrap();

        // hub with the wheel locked to it
        let locked = Link { joint: JointKind::Fixed, ..wheel };
        let d = axis * j_axis;
        let internal = InternalCoordinate { link: 0, mass: j_axis, coupling: [d.x, d.y, d.z, 0.0, 0.0, 0.0] };
        let one_body = Model::new(&[hub, locked], &[internal], GRAVITY).unwrap();

        let mut q = one_body.neutral_position();
        let neutral = q.clone();
        integrate_position(&one_body, &neutral, &draw.numbers(7), 1.0, &mut q);
        let mut q_two = q.clone();
        q_two.push(1.3); // the wheel's angle is of no consequence
        let (v, tau) = (draw.numbers(7), draw.numbers(7));
        let run = |model: &Model, q: &[f64]| {
            let state = State { q: q.to_vec(), v: v.clone(), a: vec![], tau: tau.clone(), wrench: vec![] };
            let h = momentum(model, &mut Data::new(model), q, &v);
            (accelerations(model, &state, &[]), h, kinetic_energy(model, &mut Data::new(model), q, &v))
        };
        let (a, h, energy) = run(&one_body, &q);
        let (a_two, h_two, energy_two) = run(&two_bodies, &q_two);
        assert!(difference(&a, &a_two) <= 1e-13 * norm(&a) * 100.0, "{a:?} {a_two:?}"); // rounding × condition 1e2
        assert!(difference(&h.angular_about_origin, &h_two.angular_about_origin) <= 1e-13 * 50.0);
        assert!((energy - energy_two).abs() <= 1e-13 * energy);
    }
}

#[test]
fn on_one_axis_a_mode_is_a_mass_on_a_spring() {
    let x = Vector3::x();
    let (m_hub, m_s, k) = (40.0, 7.0, 25.0);
    let along_x =
        |mass, parent| Link { com_m: Vector3::zeros(), ..block(mass, JointKind::Prismatic { axis: x }, parent) };
    let gravity = Vector3::new(-1.5, 0.0, 0.0);
    let two_bodies = Model::new(&[along_x(m_hub, None), along_x(m_s, Some(0))], &[], gravity).unwrap();
    let mode = InternalCoordinate { link: 0, mass: m_s, coupling: [0.0, 0.0, 0.0, m_s, 0.0, 0.0] };
    let one_body = Model::new(&[along_x(m_hub + m_s, None)], &[mode], gravity).unwrap();
    for seed in 0..20 {
        let mut draw = Draw::new(seed);
        let (position, stretch, v, force) = (draw.number(), draw.number(), draw.numbers(2), 10.0 * draw.number());
        let state = |q: Vec<f64>| State { q, v: v.clone(), a: vec![], tau: vec![force, -k * stretch], wrench: vec![] };
        let a = accelerations(&one_body, &state(vec![position]), &[]);
        let a_two = accelerations(&two_bodies, &state(vec![position, stretch]), &[]);
        assert!(difference(&a, &a_two) <= 1e-14 * norm(&a)); // rounding
    }
}

#[test]
fn gravity_makes_a_mode_sag_by_its_participation_over_its_stiffness() {
    let d = [0.0, 0.1, 0.0, 0.5, -0.3, 2.0];
    let mode = InternalCoordinate { link: 0, mass: 1.0, coupling: d };
    let model = Model::new(&[block(30.0, JointKind::Fixed, None)], &[mode], GRAVITY).unwrap();
    let (stiffness, sag) = (40.0, (d[3] * GRAVITY.x + d[4] * GRAVITY.y + d[5] * GRAVITY.z) / 40.0);
    let state = State { q: vec![], v: vec![0.0], a: vec![], tau: vec![-stiffness * sag], wrench: vec![] };
    assert!(accelerations(&model, &state, &[])[0].abs() <= 1e-14 * GRAVITY.norm()); // rounding
}
