//! The parameters read off plants against the published ones, and against those of the chain of
//! Jacobians.

use super::*;
use simulation::oracle::arm_parameters::{ArmParameters, Target};

const MATED: Target = Target { mass_kg: 150.0, com_from_grasp_m: [0.60, 0.15], inertia_com_kg_m2: 40.0 };

fn deployed(name: &str) -> Plant {
    let path = format!("{}/../../deploy/plants/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    plant_file::parse(name, &std::fs::read_to_string(path).unwrap()).unwrap().plant
}

fn changed(name: &str, changes: &[(&str, f64)]) -> Plant {
    let mut plant = deployed(name);
    changes.iter().for_each(|(name, value)| plant.set_parameter(name, *value).unwrap());
    plant
}

#[test]
fn parameters_of_both_arms_are_the_published_ones() {
    let before = minimal_parameters(&deployed("free_floating_arm")).unwrap();
    let table = [110.7028, 105.7339, 48.1502, 44.0904, 44.0904, 18.9133, 18.9133, 39.6048];
    // half a unit of the last printed digit
    assert!(table.iter().zip(before).all(|(a, b)| (a - b).abs() <= 0.5001e-4), "{before:?}");
    let after = minimal_parameters(&deployed("mated")).unwrap();
    let table = [304.162, 529.887, 755.776, 246.645, 246.645, 288.091, 257.035, 570.753, -32.516];
    assert!(table.iter().zip(after).all(|(a, b)| (a - b).abs() <= 0.5001e-3), "{after:?}");
}

#[test]
fn parameters_of_skewed_arms_are_those_of_the_chain_of_jacobians() {
    let arm = ArmParameters { r0_m: [1.06, 0.28], ..ArmParameters::paper_table_ii() };
    let skewed = [
        ("shoulder.position.x", 0.99),
        ("shoulder.position.y", 0.40),
        ("hub.com.x", -0.07),
        ("hub.com.y", 0.12),
        ("shoulder.rotor_inertia", 3.0),
    ];
    let aside = Target { com_from_grasp_m: [-1.0, 1.5], ..MATED };
    let off_axis = [&skewed[..], &[("target.com.x", -1.0), ("target.com.y", 1.5)]].concat();
    for (plant, arm) in
        [(changed("free_floating_arm", &skewed), arm), (changed("mated", &off_axis), arm.with_target(aside))]
    {
        let (found, expected) = (minimal_parameters(&plant).unwrap(), arm.mated_inertial_parameters_truth());
        let largest = expected.iter().fold(0.0, |most: f64, a| most.max(a.abs()));
        // rounding
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-13 * largest), "{found:?} {expected:?}");
    }
}

#[test]
fn a_hidden_error_of_a_mass_is_part_of_the_truth_and_a_flexible_joint_is_not() {
    let with = |text: &str| {
        let mut plant = deployed("free_floating_arm");
        plant.effects.push(plant_file::parse_effect(&plant, text).unwrap());
        plant
    };
    let arm = ArmParameters::paper_table_ii();
    let heavier = ArmParameters { link_mass_kg: [arm.link_mass_kg[0], 1.1 * arm.link_mass_kg[1]], ..arm };
    let flexible = "joint_flexibility@joint:shoulder compliance=1e-4";
    for (text, expected) in [("mass_error@body:link_2 error=0.1", heavier), (flexible, arm)] {
        let (found, expected) = (minimal_parameters(&with(text)).unwrap(), expected.mated_inertial_parameters_truth());
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-11), "{text}: {found:?}"); // rounding
    }
    let added = System::new(&with(flexible)).unwrap();
    assert!(added.model().v_len() > DOF, "the flexible joint must add a coordinate");
}

#[test]
fn other_plants_have_no_such_parameters() {
    for name in ["tank_1d", "hub_appendage", "study_case", "double_pendulum"] {
        assert_eq!(minimal_parameters(&deployed(name)), None, "{name}");
    }
}
