//! What the numbers of a mode do not say by themselves, as bits beside its identity: `auxiliary[6 + k] = 16 identity + bits`.
//!
//! Bit 0: a pulse of this length leaves the mode at rest; 1: the record is too short for its damping; 2: another mode lies within
//! its bandwidth; 3: the residual of the decay is not the sensor noise, an unknown input leaks in or a mode is missing.

use modal::advice::{Advice, advice, pulse_nulling};
use modal::methods::Estimate;
use serde::{Deserialize, Serialize};
use telemetry::Actuators;

const PULSE_NULLED: u32 = 1;
const RECORD_TOO_SHORT: u32 = 2;
const CLOSE_MODES: u32 = 4;
const INPUT_LEAKS: u32 = 8;
/// Identities stand above the bits.
pub const IDENTITY_UNIT: u32 = 16;
/// Part of the commanded impulse that points one way: what is less is no pulse.
const ONE_WAY: f64 = 0.95;

/// The excitation so far, as far as it may be a single pulse.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Pulse {
    length_s: f64,
    /// Sums over the commands: force and torque by component, their sizes, and the squares of these.
    impulse: [f64; 6],
    size: f64,
    ended: bool,
    several: bool,
}

impl Pulse {
    pub fn excited(&mut self, command: &Actuators) {
        self.several |= self.ended;
        self.length_s += command.interval_s;
        let components = command.force_b_n.iter().chain(&command.torque_b_nm);
        let mut square = 0.0;
        for (sum, value) in self.impulse.iter_mut().zip(components) {
            *sum += value;
            square += value * value;
        }
        self.size += square.sqrt();
    }

    pub fn ended(&mut self) {
        self.ended = self.length_s > 0.0;
    }

    /// Length of the one pulse that there was.
    pub fn length_s(&self) -> Option<f64> {
        let along = self.impulse.iter().map(|sum| sum * sum).sum::<f64>().sqrt();
        (self.length_s > 0.0 && !self.several && along > ONE_WAY * self.size).then_some(self.length_s)
    }
}

/// The bits of each mode.
pub fn bits(found: &[Estimate], record_s: f64, pulse_s: Option<f64>, leaks: bool) -> Vec<u32> {
    let mut said = advice(found, record_s, None);
    if let Some(pulse_s) = pulse_s {
        said.extend(found.iter().filter_map(|mode| pulse_nulling(mode.frequency_hz, pulse_s)));
    }
    let of_mode = |mode: &Estimate| {
        let is = |f: &f64| *f == mode.frequency_hz;
        said.iter().fold(if leaks { INPUT_LEAKS } else { 0 }, |bits, advice| {
            bits | match advice {
                Advice::PulseNulled { frequency_hz, .. } if is(frequency_hz) => PULSE_NULLED,
                Advice::RecordTooShort { frequency_hz, .. } if is(frequency_hz) => RECORD_TOO_SHORT,
                Advice::CloseModes { lower_hz, upper_hz, .. } if is(lower_hz) || is(upper_hz) => CLOSE_MODES,
                _ => 0,
            }
        })
    };
    found.iter().map(of_mode).collect()
}
