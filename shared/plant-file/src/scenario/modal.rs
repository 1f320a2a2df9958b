//! The modal experiment, and what is known of hub and appendage.

use super::{Need, PlantUse};
use serde::Deserialize;

/// Modal experiment: torque pulse, then free decay (BP3A); or an operational record.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModalExperiment {
    pub duration_s: f64,
    #[serde(default)]
    pub torque_nm: f64,
    #[serde(default)]
    pub pulse_s: f64,
    #[serde(default)]
    pub plant: Option<PlantUse>,
    #[serde(default)]
    pub known: ModalKnown,
    #[serde(default)]
    pub need: Need,
}

/// Prior knowledge of the modal estimator.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ModalKnown {
    /// White noise of one accelerometer sample.
    pub accelerometer_sigma_m_s2: f64,
    /// Nominal sample rate; 0: taken from the data.
    pub rate_hz: f64,
    /// Modes expected before the experiment, from which its outcome is predicted: `[f_hz, zeta]`.
    pub expected: Vec<[f64; 2]>,
    /// Typical amplitude of the decay, for the same prediction.
    pub expected_amplitude_m_s2: f64,
    /// Band of interest.
    pub band_hz: Option<[f64; 2]>,
    /// Channels used, all when empty (numbered from 1).
    pub channels: Vec<usize>,
    /// Hub and appendage by analysis: with it the inertia about the hub's axis follows from the
    /// modes.
    pub appendage: Option<AppendageKnown>,
}

/// A hub with one flexible appendage, about its axis; of a body that floats, about its centre of
/// mass with the translation free.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AppendageKnown {
    /// Of the whole with the appendage undeformed, as the mass-property sheet says, and the sheet's
    /// relative sigma (0: none is stated).
    pub inertia_kg_m2: f64,
    #[serde(default)]
    pub inertia_relative_sd: f64,
    /// Momentum of each unit mode about the axis, and the relative sigma that they share.
    pub coupling_sqrt_kg_m: [f64; 2],
    #[serde(default)]
    pub coupling_relative_sd: f64,
    /// Modes with the rotation held fast, `[f_hz, zeta]`: their ratio is that of the geometry, the
    /// rest is found.
    pub locked: [[f64; 2]; 2],
    /// Joint angles of the arm during the modal experiment, if that is the body which the arm's
    /// experiment weighs: the two
    /// inertias are then compared. Without it they are of separate bodies.
    #[serde(default)]
    pub arm_angle_rad: Option<[f64; 2]>,
}

impl ModalKnown {
    /// Channels used of `available`, numbered from 0; empty when a stated one does not exist.
    pub fn channels_of(&self, available: usize) -> impl Iterator<Item = usize> {
        let exist = self.channels.iter().all(|channel| (1..=available).contains(channel));
        let count = match self.channels.len() {
            0 => available,
            stated if exist => stated,
            _ => 0,
        };
        (0..count).map(|place| self.channels.get(place).map_or(place, |channel| channel - 1))
    }
}

impl Default for ModalKnown {
    fn default() -> Self {
        ModalKnown {
            accelerometer_sigma_m_s2: 3.10e-4,
            rate_hz: 0.0,
            expected: Vec::new(),
            expected_amplitude_m_s2: 0.0,
            band_hz: None,
            channels: Vec::new(),
            appendage: None,
        }
    }
}
