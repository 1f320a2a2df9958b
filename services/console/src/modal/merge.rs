//! How setups were merged, as the answer states it.

use super::structural_arguments::MergeBy;
use modal::setups::{Merged, Setup};
use serde_json::{Value, json};

/// The setups, and how they were merged.
pub(super) struct Merge {
    pub by: MergeBy,
    pub references: Vec<String>,
    pub files: Vec<String>,
    pub records: Vec<String>,
    pub setups: Vec<Setup>,
    pub merged: Merged,
}

impl Merge {
    /// `setups[]`.
    pub(super) fn setups(&self) -> Value {
        let all = self.setups.iter().enumerate().map(|(j, setup)| {
            let modes: Vec<Value> = setup.modes.iter().map(|mode| json!({ "frequency_hz": mode.frequency_hz,
                "frequency_sd": mode.sigma_frequency_hz, "damping": mode.damping_ratio, "damping_sd": mode.sigma_damping })).collect();
            json!({ "file": self.files[j], "record": self.records[j], "channels": setup.channels, "modes": modes })
        });
        all.collect()
    }

    /// `merge`: how, and how well the setups agree.
    pub(super) fn as_json(&self) -> Value {
        let modes = self.merged.modes.iter().map(|mode| {
            json!({ "frequency_hz": mode.frequency_hz, "frequency_spread": mode.frequency_spread,
                "damping_spread": mode.damping_spread, "reference_difference_sd": mode.reference_difference,
                "reference_limit_sd": mode.reference_limit,
                "found_in": mode.found_in.iter().map(|found| found.map(|k| k + 1)).collect::<Vec<_>>() })
        });
        let by = if self.by == MergeBy::Poser { "poser" } else { "preger" };
        json!({ "by": by, "references": self.references, "modes": modes.collect::<Vec<_>>() })
    }
}
