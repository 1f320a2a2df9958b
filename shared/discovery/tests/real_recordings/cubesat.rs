//! CubeSat on a turning bed, its wheel switched on twice, no input recorded.

use crate::desk::{diagnosed, folder, part, read, rig};

#[test]
fn one_step_is_diagnosed_and_the_other_held_out() {
    let Some(folder) = folder("cubesat_adcs") else { return };
    let whole = &read(&folder, "step_response.csv")[0];
    let (first, last) = (part(whole, 0.0, 45.0, 1), part(whole, 45.0, 100.0, 1));
    let _found = diagnosed("cubesat step", &rig("cubesat_gyro_step"), &[first], &[last]);
}

#[test]
fn both_steps_are_diagnosed() {
    let Some(folder) = folder("cubesat_adcs") else { return };
    let whole = &read(&folder, "step_response.csv")[0];
    let _found = diagnosed("cubesat, both steps", &rig("cubesat_gyro_step"), core::slice::from_ref(whole), &[]);
}
