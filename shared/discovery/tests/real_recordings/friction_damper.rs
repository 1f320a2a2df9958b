//! Friction damper with backlash under imposed displacement: two records jointly, three held out.

use crate::desk::{diagnosed, folder, part, read, rig};
use channels::Recording;

#[test]
fn a_law_with_memory_is_named_from_two_records_and_explains_more_than_half_of_three_others() {
    let Some(folder) = folder("brfd_friction_backlash") else { return };
    // 512 Hz
    let take = |file: &str| -> Recording { part(&read(&folder, file)[0], 0.0, 1e9, 2) };
    let fitted = [take("sine_0.5Hz_1in_30lb.csv"), take("sine_1Hz_0.5in_30lb.csv")];
    let held_out = [take("sine_1Hz_1in_30lb.csv"), take("sine_2Hz_0.5in_30lb.csv"), take("sine_0.5Hz_0.5in_30lb.csv")];
    let found = diagnosed("friction damper", &rig("friction_damper"), &fitted, &held_out);
    let memory = ["joint_lugre", "joint_bouc_wen"];
    let law = found.effects.iter().find(|effect| memory.contains(&effect.kind.as_str()));
    let law = law.unwrap_or_else(|| panic!("{:?}", found.effects));
    let force = law.parameters.iter().find(|p| p.name == "force").expect("free");
    assert!(force.value > 4.0 * force.sigma, "{force:?}");
    assert!(found.held_out.channels[0].fit_percent_after > 50.0, "{:?}", found.held_out.channels);
}
