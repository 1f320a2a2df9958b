//! Dry friction whose sign turns sharply, in long recordings.

use super::*;

/// Its sign turns over 1e-3 rad/s, a fiftieth of what the screening looks at. Left smooth it leaves
/// a dip at low rates, which is Stribeck's. The recording has a beginning.
#[test]
fn dry_friction_of_a_sharp_sign_is_named_alone_in_a_long_recording() {
    let nominal = plant("drive_rig");
    let hidden = with_effect(&nominal, "joint_coulomb", "joint:drive", &[("force", 0.3)]);
    let found = diagnosed(&nominal, recording(&hidden, 11, 9.5));
    let names: Vec<&str> = found.effects.iter().map(|own| own.kind.as_str()).collect();
    assert_eq!((found.verdict, &names[..]), (Verdict::Named, &["joint_coulomb"][..]), "{}", found.reason);
    let force = &found.effects[0].parameters[0];
    assert!((force.value - 0.3).abs() < 4.0 * force.sigma, "{force:?}");
}
