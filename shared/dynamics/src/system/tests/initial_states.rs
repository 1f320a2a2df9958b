//! States at the beginning.

use super::*;
use crate::description::{Initial, InitialValue};

fn value(coordinate: &str, position: f64, rate: f64) -> InitialValue {
    InitialValue { coordinate: coordinate.to_owned(), position: known(position), rate: known(rate) }
}

#[test]
fn a_floating_system_starts_with_the_momentum_asked_for_and_its_centre_of_mass_at_rest_in_the_origin() {
    for mut plant in [arm(Space::Planar), everything(false)] {
        let wanted = if plant.space == Space::Planar { [0.0, 0.0, 68.0] } else { [3.0, -7.0, 12.0] };
        plant.initial.momentum_com_n_m_s = Some(three(wanted));
        plant.initial.on_reference = true;
        plant.initial.values = vec![value("body:hub.rx", 0.4, 0.0), value("body:hub.rz", -0.9, 0.0)];
        plant.initial.values.retain(|_| plant.space == Space::Spatial);
        let system = System::new(&plant).unwrap();
        let x = system.initial_state(&plant.initial, &|name| Some((name.len() as f64 * 0.1, 0.3))).unwrap();
        let first = &system.joints[0].name;
        assert_eq!(x[index(&system, &format!("joint:{first}"))], first.len() as f64 * 0.1);
        assert_eq!(x[index(&system, &format!("joint:{first}.rate"))], 0.3);
        let u = vec![0.0; system.inputs().len()];
        let totals = system.totals(&mut Workspace::<f64>::new(&system), &x, &u);
        for (k, wanted) in wanted.into_iter().enumerate() {
            // rounding of sums of some hundred N m s, and kg m for the first moment
            assert!((totals.angular_momentum_com_n_m_s[k] - wanted).abs() < 1e-11, "{totals:?}");
            assert!(totals.linear_momentum_n_s[k].abs() < 1e-11);
            assert!(totals.com_m[k].abs() < 1e-14);
        }
    }
}

#[test]
fn values_go_to_the_coordinates_they_name() {
    let plant = everything(false);
    let system = System::new(&plant).unwrap();
    let initial = Initial {
        values: vec![
            value("body:hub.x", 1.0, 2.0),
            value("body:hub.rz", core::f64::consts::FRAC_PI_2, 0.3),
            value("joint:slide", 0.2, 0.5),
            value("tank:fuel.2", 0.01, -0.02),
            value("mode:twist", 0.03, 0.04),
            value("wheel:wheel2", 0.0, 7.0),
        ],
        ..Initial::default()
    };
    let x = system.initial_state(&initial, &|_| None).unwrap();
    let at = |name: &str| x[index(&system, name)];
    assert_eq!((at("body:hub.x"), at("joint:slide"), at("joint:slide.rate")), (1.0, 0.2, 0.5));
    assert_eq!((at("tank:fuel.2"), at("tank:fuel.2.rate"), at("tank:fuel")), (0.01, -0.02, 0.0));
    assert_eq!((at("mode:twist"), at("mode:twist.rate")), (0.03, 0.04));
    // wheel1 keeps the actuator's own initial speed
    assert_eq!((at("wheel:wheel1"), at("wheel:wheel2")), (60.0, 7.0));
    // turned by a right angle: inertial x is body −y
    assert!((at("body:hub.y.rate") + 2.0).abs() < 1e-15 && at("body:hub.x.rate").abs() < 1e-15);
    assert!((at("body:hub.qz") - core::f64::consts::FRAC_1_SQRT_2).abs() < 1e-15);
    assert_eq!(at("body:hub.rz.rate"), 0.3);
}

#[test]
fn what_cannot_begin_is_refused() {
    let system = System::new(&everything(false)).unwrap();
    let initial = Initial { values: vec![value("joint:elbow", 0.0, 0.0)], ..Initial::default() };
    let error = system.initial_state(&initial, &|_| None).unwrap_err();
    assert!(error.to_string().contains("joint:elbow"), "{error}");
    let mut fixed = arm(Space::Planar);
    fixed.bodies[0].joint.kind = JointKind::Fixed;
    let initial = Initial { momentum_com_n_m_s: Some(three([0.0; 3])), ..Initial::default() };
    let system = System::new(&fixed).unwrap();
    assert_eq!(system.initial_state(&initial, &|_| None), Err(crate::system::SystemError::NotFloating));
}

#[test]
fn names_that_do_not_exist_and_bodies_that_move_no_mass_are_refused() {
    let mut plant = arm(Space::Planar);
    plant.actuators[0] = torque_of("elbow");
    let text = |plant: &Plant| System::new(plant).err().expect("it must be refused").to_string();
    assert_eq!(text(&plant), "actuator 'elbow.torque' names joint 'elbow', which does not exist");
    let mut plant = arm(Space::Planar);
    (plant.bodies[2].mass_kg, plant.bodies[2].inertia_com_kg_m2) = (known(0.0), [known(0.0); 6]);
    assert!(text(&plant).starts_with("body 'link2'"), "{}", text(&plant));
    let mut plant = arm(Space::Planar);
    plant.bodies[1].joint.kind = JointKind::Revolute { axis: [1.0, 0.0, 0.0] };
    assert!(text(&plant).contains("link1"), "{}", text(&plant));
}

#[test]
fn the_values_of_a_state_make_that_state_again() {
    for plant in [arm(Space::Planar), arm(Space::Spatial), everything(false), everything(true)] {
        let system = System::new(&plant).unwrap();
        let free = plant.bodies.iter().filter(|body| body.joint.kind == JointKind::Free);
        let turns = free.flat_map(|body| ["rx", "ry", "rz"].map(|axis| format!("body:{}.{axis}", body.name)));
        let turned: Vec<InitialValue> = turns
            .filter(|name| plant.space == Space::Spatial || name.ends_with("rz"))
            .map(|name| value(&name, 0.3, -0.2))
            .collect();
        let initial = Initial { values: turned, ..Initial::default() };
        let references = |name: &str| Some((name.len() as f64 * 0.1, 0.3));
        let x = system.initial_state(&initial, &references).unwrap();
        let moved: Vec<f64> =
            x.iter().enumerate().map(|(k, x)| x + if *x == 0.0 { 0.01 * k as f64 } else { 0.0 }).collect();
        let values = system.initial_values(&moved);
        let again = system.initial_state(&Initial { values, ..Initial::default() }, &|_| None).unwrap();
        let layout = system.layout.positions() + system.layout.velocities();
        for (k, (a, b)) in again.iter().zip(&moved).enumerate().take(layout) {
            assert!((a - b).abs() < 1e-12, "{}: {a} {b}", system.states()[k].name);
        }
    }
}
