//! One case: drawn, simulated, sealed.

mod draw;
mod search;

use crate::disturb::NoiseKind;
use crate::hidden::Hidden;
use channels::Recording;
use dynamics::description::Plant;
use serde::{Deserialize, Serialize};

pub use draw::{case, control};

#[cfg(test)]
mod tests;

/// Class of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    Null,
    Single,
    Pair,
    /// The kind of the effect and its kin are removed from the tool's catalogue.
    LeftOut,
    /// A nominal parameter absorbs 30 % or more of the effect's energy, with a bias of two of its
    /// sigmas or more.
    Masked,
}

/// A nominal parameter that the effect biases.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BiasedParameter {
    pub name: String,
    pub truth: f64,
    pub shift_sigma: f64,
}

/// The sealed part of a case: known only after the answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    pub case: u64,
    pub class: Class,
    pub plant: String,
    pub closed_loop: bool,
    pub noise: NoiseKind,
    pub effects: Vec<Hidden>,
    pub without: Vec<String>,
    pub planned_d: f64,
    /// Of each effect alone.
    pub d: Vec<f64>,
    pub held_out_d: f64,
    pub kappa: f64,
    /// Largest |cosine| with another entry of the bench's menu, and which.
    pub rho: f64,
    pub rival: String,
    #[serde(rename = "astray")]
    pub biased: Option<BiasedParameter>,
    /// Channel and time [s, s] of an effect that has a time.
    pub window: Option<(String, [f64; 2])>,
    /// Parameters of the true plant that have a prior.
    pub numbers: Vec<(String, f64)>,
    /// BLAKE3 of the recordings.
    pub recordings: Vec<String>,
    /// Entries of the catalogue times sites of this plant.
    pub candidates: usize,
}

/// The input of the tool.
pub struct Exam {
    pub plant: Plant,
    pub recording: Recording,
    /// Another experiment with the same machine.
    pub held_out: Option<(Plant, Recording)>,
    pub without: Vec<String>,
}

/// A case with its truth as bytes, and their digest.
pub struct Sealed {
    pub exam: Exam,
    pub truth: Vec<u8>,
    pub digest: String,
}

/// BLAKE3 in hexadecimal.
#[must_use]
pub fn digest(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

fn recording_digest(recording: &Recording) -> String {
    let mut hasher = blake3::Hasher::new();
    for channel in &recording.channels {
        hasher.update(channel.name.as_bytes());
        for x in channel.time_s.iter().chain(&channel.value) {
            hasher.update(&x.to_le_bytes());
        }
    }
    hasher.finalize().to_hex().to_string()
}
