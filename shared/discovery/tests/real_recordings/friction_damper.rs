//! Friction damper with backlash under imposed displacement: two records jointly, three held out.

use crate::desk::{diagnosed, folder, part, read, rig};
use discovery::series::Recording;

#[test]
fn two_records_are_diagnosed_and_three_held_out() {
    let Some(folder) = folder("brfd_friction_backlash") else { return };
    // 512 Hz
    let take = |file: &str| -> Recording { part(&read(&folder, file)[0], 0.0, 1e9, 2) };
    let fitted = [take("sine_0.5Hz_1in_30lb.csv"), take("sine_1Hz_0.5in_30lb.csv")];
    let held_out = [take("sine_1Hz_1in_30lb.csv"), take("sine_2Hz_0.5in_30lb.csv"), take("sine_0.5Hz_0.5in_30lb.csv")];
    let _found = diagnosed("friction damper", &rig("friction_damper"), &fitted, &held_out);
}
