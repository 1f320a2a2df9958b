//! CubeSat on a turning bed, its wheel switched on twice, no input recorded.

use crate::desk::{diagnosed, folder, read, rig};

#[test]
fn both_steps_together_show_the_friction_of_the_bearing() {
    let Some(folder) = folder("cubesat_adcs") else { return };
    let whole = &read(&folder, "step_response.csv")[0];
    let found = diagnosed("cubesat, both steps", &rig("cubesat_gyro_step"), whole);
    let friction = found.effects.iter().find(|effect| effect.site == "joint:bearing");
    let friction = friction.unwrap_or_else(|| panic!("{:?} {}", found.verdict, found.reason));
    assert!(
        friction.probability > 0.0 && friction.parameters.iter().all(|p| p.value.is_finite() && p.sigma > 0.0),
        "{friction:?}"
    );
}
