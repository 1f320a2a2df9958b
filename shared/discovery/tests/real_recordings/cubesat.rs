//! CubeSat on a turning bed, its wheel switched on twice, no input recorded.

use crate::desk::{diagnosed, folder, part, read, rig};
use identification::held_out::Status;

#[test]
fn friction_of_the_bearing_is_found_in_one_step_and_the_other_confirms_it_better_than_the_documented_drag() {
    let Some(folder) = folder("cubesat_adcs") else { return };
    let whole = &read(&folder, "step_response.csv")[0];
    let (first, last) = (part(whole, 0.0, 45.0, 1), part(whole, 45.0, 100.0, 1));
    let found = diagnosed("cubesat step", &rig("cubesat_gyro_step"), &[first], &[last]);
    let confirmed = found.effects.iter().filter(|effect| effect.status == Status::Confirmed);
    assert!(confirmed.clone().any(|effect| effect.site == "joint:bearing"), "{}", found.reason);
    // an asymmetry has either sign
    let mut signed = confirmed.filter(|effect| effect.kind != "joint_asymmetric_friction");
    assert!(signed.all(|effect| effect.parameters.iter().all(|p| p.name != "force" || p.value > 0.0)));
    // the documentation's bearing drag: 96.05 %
    assert!(found.held_out.channels[0].fit_percent_after >= 96.05, "{:?}", found.held_out.channels);
}

#[test]
fn both_steps_together_show_the_friction_of_the_bearing() {
    let Some(folder) = folder("cubesat_adcs") else { return };
    let whole = &read(&folder, "step_response.csv")[0];
    let found = diagnosed("cubesat, both steps", &rig("cubesat_gyro_step"), core::slice::from_ref(whole), &[]);
    let friction = found.effects.iter().find(|effect| effect.site == "joint:bearing");
    let friction = friction.unwrap_or_else(|| panic!("{:?} {}", found.verdict, found.reason));
    assert!(
        friction.probability > 0.0 && friction.parameters.iter().all(|p| p.value.is_finite() && p.sigma > 0.0),
        "{friction:?}"
    );
}
