//! Free swing of a single pendulum: friction left out.

use crate::desk::{candidates, diagnosed, folder, part, read, rig};

#[test]
fn dry_and_quadratic_friction_are_named_together_and_predict_as_well_as_the_best_physical_model() {
    let Some(folder) = folder("multiarm_pendulum") else { return };
    let whole = &read(&folder, "single_free_swing.csv.gz")[0];
    // 100 Hz, 1.27 Hz of swing: as the documentation's own fits
    let (first, last) = (part(whole, 0.05, 40.05, 10), part(whole, 40.05, 54.9, 10));
    let found = diagnosed("single pendulum", &rig("single_pendulum"), &[first], &[last]);
    let named: Vec<&str> = found.effects.iter().map(|effect| effect.kind.as_str()).collect();
    assert!(named.contains(&"joint_coulomb"), "{named:?}");
    // quadratic drag by any of its names: about one pivot they are the same
    let all = candidates(&found);
    assert!(all.iter().any(|kind| kind == "joint_quadratic_damping"), "{all:?}");
    assert!(!named.contains(&"joint_viscous"), "{named:?}");
    // the documentation's best model with physical signs: 92.2 %
    assert!(found.held_out.channels[0].fit_percent_after >= 92.2);
}
