//! The slosh experiment, and what is known of hub and tank.

use super::{Need, PlantUse};
use serde::Deserialize;

/// Slosh experiment on one axis (BP2, 1-D).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SloshExperiment {
    pub duration_s: f64,
    #[serde(default)]
    pub force_amplitude_n: f64,
    #[serde(default)]
    pub force_frequency_hz: f64,
    #[serde(default)]
    pub plant: Option<PlantUse>,
    pub known: SloshKnown,
    #[serde(default)]
    pub need: Need,
}

/// Prior knowledge of the slosh estimator.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SloshKnown {
    /// Mass of hub without slosh mass.
    pub m_0_kg: f64,
    /// Axis of force and acceleration.
    #[serde(default)]
    pub axis: Axis,
    #[serde(default = "default_vrw")]
    pub accelerometer_vrw_m_s_sqrt_h: f64,
    #[serde(default = "default_slosh_interval")]
    pub interval_s: f64,
    /// Tank expected before the experiment, `[m_s, k_s, c_s]`: its outcome is predicted from it.
    #[serde(default)]
    pub expected: Option<[f64; 3]>,
    /// Standard deviations of `expected`: it is then a prior, and the estimate says what the record
    /// did to each number.
    #[serde(default)]
    pub expected_sigma: Option<[f64; 3]>,
    /// The slosh mass is at rest when the experiment begins. Unless stated: yes in a simulation,
    /// which starts so; not
    /// known in a recording.
    #[serde(default)]
    pub starts_at_rest: Option<bool>,
}

/// Body axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    #[default]
    X,
    Y,
    Z,
}

impl Axis {
    /// Place of the axis in a vector: 0, 1 or 2.
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }
}

const fn default_vrw() -> f64 {
    0.008
}
const fn default_slosh_interval() -> f64 {
    0.1
}
