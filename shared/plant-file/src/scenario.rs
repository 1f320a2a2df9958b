//! A scenario: what is simulated or known, how it is excited, what the identified model is for.
//!
//! Files are TOML with `format = 1`; units are in the keys. Each experiment is simulated on a plant
//! of its own (`plant`, read by `sensor-sim` alone), and states what the estimators know
//! (`known`) and what they must reach (`need`). Or one craft flies all its arcs (`craft`).
//!
//! A run carries the text as it was written. Each partition reads it in `connect`, with the same
//! reader that checked it before the run: [`Scenario::read`].

mod arm;
mod capture;
mod craft;
mod impossible;
mod limits;
mod modal;
mod need;
mod plant_use;
mod read;
mod slosh;

pub use arm::{ArmExperiment, ArmKnown, ChaserSheet, SheetSigmas, TargetStatement, Trajectory};
pub use capture::CapturePlan;
pub use craft::{ArcError, ArcExperiment, ArcPlan, CraftPlan};
pub use modal::{AppendageKnown, ModalExperiment, ModalKnown};
pub use need::Need;
pub use plant_use::{ConfiguredPlant, PlantUse, PlantUseError};
pub use read::{Opened, Refusal, error_at, open};
pub use slosh::{Axis, SloshExperiment, SloshKnown};

use serde::Deserialize;

/// A scenario file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Version of this format.
    pub format: u32,
    pub name: String,
    #[serde(default = "default_frame_period")]
    pub frame_period_ms: u64,
    #[serde(default = "default_seed")]
    pub seed: u64,
    #[serde(default = "default_window")]
    pub window_frames: u64,
    #[serde(default)]
    pub modal: Option<ModalExperiment>,
    #[serde(default)]
    pub slosh: Option<SloshExperiment>,
    #[serde(default)]
    pub inertial: Option<ArmExperiment>,
    #[serde(default)]
    pub capture: CapturePlan,
    #[serde(default)]
    pub mated: Option<ArmExperiment>,
    /// One craft for all arcs, in the place of the experiments above.
    #[serde(default)]
    pub craft: Option<CraftPlan>,
}

const fn default_frame_period() -> u64 {
    10
}
const fn default_seed() -> u64 {
    1
}
const fn default_window() -> u64 {
    100
}

impl Scenario {
    /// Period of a frame \[ns\].
    #[must_use]
    pub fn period_ns(&self) -> u64 {
        self.frame_period_ms * 1_000_000
    }

    /// The plants of the experiments, by the experiment's name.
    pub fn plants_mut(&mut self) -> impl Iterator<Item = (&'static str, &mut PlantUse)> {
        let modal = self.modal.as_mut().and_then(|modal| modal.plant.as_mut());
        let slosh = self.slosh.as_mut().and_then(|slosh| slosh.plant.as_mut());
        let inertial = self.inertial.as_mut().and_then(|arm| arm.plant.as_mut());
        let mated = self.mated.as_mut().and_then(|arm| arm.plant.as_mut());
        let craft = self.craft.as_mut().map(|craft| &mut craft.plant);
        let all = [("modal", modal), ("slosh", slosh), ("inertial", inertial), ("mated", mated), ("craft", craft)];
        all.into_iter().filter_map(|(name, plant)| plant.map(|plant| (name, plant)))
    }

    /// Frames in `seconds`, rounded to the nearest.
    #[must_use]
    pub fn frames(&self, seconds: f64) -> u64 {
        (seconds * 1000.0 / self.frame_period_ms as f64).round() as u64
    }

    /// A simulated tank starts at rest unless the scenario says otherwise, also where the
    /// simulation was recorded; of any other nothing is known.
    pub fn assume_rest(&mut self, is_replay: bool) {
        if let Some(slosh) = &mut self.slosh {
            slosh.known.starts_at_rest.get_or_insert(!is_replay || slosh.plant.is_some());
        }
    }
}

#[cfg(test)]
mod tests;
