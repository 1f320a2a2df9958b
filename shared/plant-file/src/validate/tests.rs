use super::validate;
use dynamics::description::*;

fn two_bodies() -> Plant {
    let known = Quantity::known;
    let joint = |name: &str, kind: JointKind| Joint {
        name: name.to_owned(),
        kind,
        position_m: [known(0.0); 3],
        orientation: Orientation::default(),
        viscous_friction: known(0.0),
        rotor_inertia: known(0.0),
        stiffness: known(0.0),
        rest: known(0.0),
    };
    let body = |name: &str, parent: Option<&str>, kind: JointKind| Body {
        name: name.to_owned(),
        parent: parent.map(str::to_owned),
        joint: joint(&format!("{name}_joint"), kind),
        mass_kg: known(1.0),
        com_m: [known(0.0); 3],
        inertia_com_kg_m2: [known(1.0), known(1.0), known(1.0), known(0.0), known(0.0), known(0.0)],
    };
    let bodies = vec![
        body("hub", None, JointKind::Free),
        body("arm", Some("hub"), JointKind::Revolute { axis: [0.0, 0.0, 1.0] }),
    ];
    Plant { name: "two".into(), space: Space::Spatial, bodies, ..Plant::default() }
}

#[test]
fn a_possible_plant_has_no_fault() {
    assert_eq!(validate(&two_bodies()), []);
}

#[test]
fn plants_built_in_code_are_checked_like_files() {
    type Break = fn(&mut Plant);
    let break_it: [(Break, &str, &str); 7] = [
        (|p| p.bodies[1].mass_kg.value = -1.0, "mass", "negative"),
        (|p| p.bodies[1].mass_kg.value = f64::NAN, "mass", "finite"),
        (|p| p.bodies[0].mass_kg.sigma = Some(0.0), "mass", "standard deviation"),
        (
            |p| p.bodies[1].inertia_com_kg_m2[1].value = 2.5,
            "inertia",
            "about y violates the triangle inequality: 2.5 > 1 + 1",
        ),
        (|p| p.bodies.swap(0, 1), "parent", "before its parent"),
        (|p| p.bodies[1].joint.kind = JointKind::Revolute { axis: [0.0, 0.0, 2.0] }, "joint.axis", "length 2"),
        (|p| p.bodies[0].name = "a b".into(), "name", "cannot name"),
    ];
    for (change, key, word) in break_it {
        let mut plant = two_bodies();
        change(&mut plant);
        let faults = validate(&plant);
        let found = faults
            .iter()
            .any(|fault| fault.place.section == "body" && fault.place.key == key && fault.message.contains(word));
        assert!(found, "{key}, {word}: {faults:?}");
    }
}

#[test]
fn only_a_body_that_carries_another_may_be_without_mass() {
    let without = |i: usize| {
        let mut plant = two_bodies();
        plant.bodies[i].mass_kg = Quantity::known(0.0);
        plant.bodies[i].inertia_com_kg_m2 = [Quantity::known(0.0); 6];
        validate(&plant).len()
    };
    assert!(without(1) > 0, "nothing hangs on it");
    assert!(without(0) > 0, "a hub that floats without mass");
    let mut between = two_bodies();
    between.bodies[0].joint.kind = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
    between.bodies[0].mass_kg = Quantity::known(0.0);
    between.bodies[0].inertia_com_kg_m2 = [Quantity::known(0.0); 6];
    between.bodies[1].joint.kind = JointKind::Revolute { axis: [1.0, 0.0, 0.0] };
    assert_eq!(validate(&between), [], "a massless link between two joints");
}

#[test]
fn every_parameter_has_a_name_of_its_own_and_setting_it_changes_it_alone() {
    for name in ["study_case", "study_case_spatial", "hub_appendage_closed_loop", "tank_pendulum", "drive_rig"] {
        let path = format!("{}/../../deploy/plants/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let plant = crate::parse(name, &std::fs::read_to_string(path).unwrap()).unwrap().plant;
        let before = plant.parameters();
        for (i, parameter) in before.iter().enumerate() {
            assert!(
                !before[..i].iter().any(|earlier| earlier.name == parameter.name),
                "{name}: {} twice",
                parameter.name
            );
            assert!(crate::units::parse(&parameter.unit).is_ok(), "{name}: {} [{}]", parameter.name, parameter.unit);
        }
        for (i, parameter) in before.iter().enumerate().step_by(7) {
            let mut changed = plant.clone();
            changed.set_parameter(&parameter.name, parameter.value + 1.0).unwrap();
            for (k, (after, before)) in changed.parameters().iter().zip(&before).enumerate() {
                assert_eq!(after.value, before.value + f64::from(u8::from(k == i)), "{}", before.name);
            }
        }
    }
}

#[test]
fn parameters_have_the_names_of_the_file() {
    let text = include_str!("../../../../deploy/plants/study_case.toml");
    let mut plant = crate::parse("study_case", text).unwrap().plant;
    plant.add_effect("joint_coulomb", &"joint:shoulder".parse().unwrap(), &[("force", 0.1)]).unwrap();
    plant.add_effect("joint_coulomb", &"joint:shoulder".parse().unwrap(), &[("force", 0.2)]).unwrap();
    let all = plant.parameters();
    let find = |name: &str| all.iter().find(|p| p.name == name).unwrap_or_else(|| panic!("no {name}"));
    for (name, unit, value) in [
        ("hub.mass", "kg", 980.0),
        ("link_1.com.x", "m", 1.02),
        ("hub.inertia.zz", "kg*m^2", 520.0),
        ("shoulder.friction", "N*m*s/rad", 0.4),
        ("fuel.stiffness.y", "N/m", 0.16),
        ("bending_1.frequency", "Hz", 1.0),
        ("bending_1.rotation.z", "sqrt(kg)*m", 10.97),
        ("bending_2.shape.tip.x", "1/sqrt(kg)", -0.632),
        ("panel.tip.y", "m", -5.8),
        ("gyro.bias", "rad/s", 0.0),
        ("imu.clock_offset", "s", 0.0),
        ("shoulder_loop.kp", "N*m/rad", 600.0),
        ("effect.joint_coulomb@joint:shoulder.force", "N*m", 0.1),
        ("effect.joint_coulomb@joint:shoulder#2.force", "N*m", 0.2),
    ] {
        assert_eq!((find(name).unit.as_str(), find(name).value), (unit, value), "{name}");
    }
    for name in ["hub.com.z", "hub.inertia.xx", "bending_1.rotation.x", "bending_1.translation.z"] {
        assert!(!all.iter().any(|p| p.name == name), "a plane has no {name}");
    }
    let Err(ParameterError::Unknown { nearest, .. }) = plant.set_parameter("hub.mas", 1.0) else { panic!() };
    assert_eq!(nearest.as_deref(), Some("hub.mass"));
    assert!(plant.set_parameter("hub.mass", f64::NAN).is_err());
}

#[test]
fn a_sensor_at_a_point_moves_with_the_point() {
    let text = include_str!("../../../../deploy/plants/study_case.toml");
    let mut plant = crate::parse("study_case", text).unwrap().plant;
    plant.set_parameter("panel.tip.y", -6.0).unwrap();
    let SensorKind::Accelerometer { position_m, .. } = &plant.sensor("panel_tip").unwrap().kind else { panic!() };
    assert_eq!(position_m[1].value, -6.0);
}
