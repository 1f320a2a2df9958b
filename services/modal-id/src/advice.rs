//! Cautions about each mode beside its frequency and damping ([`IdentifiedMode`]).

use modal::advice::{Advice, advice, pulse_nulling};
use modal::methods::Estimate;
use serde::{Deserialize, Serialize};
use telemetry::{Actuators, IdentifiedMode};

/// Least share of the commanded impulse that points one way in a pulse.
const ONE_WAY_SHARE_MIN: f64 = 0.95;

/// The excitation so far, as far as it may be a single pulse.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Pulse {
    length_s: f64,
    /// Sums over the commands: force and torque by component, their sizes, and the squares of
    /// these.
    impulse: [f64; 6],
    size: f64,
    ended: bool,
    several: bool,
}

impl Pulse {
    /// Adds a command that is not zero.
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

    /// The excitation has ended: a command behind it begins another pulse.
    pub fn ended(&mut self) {
        self.ended = self.length_s > 0.0;
    }

    /// Length of the excitation [s] if it was a single pulse in one direction.
    pub fn length_s(&self) -> Option<f64> {
        let along = self.impulse.iter().map(|sum| sum * sum).sum::<f64>().sqrt();
        (self.length_s > 0.0 && !self.several && along > ONE_WAY_SHARE_MIN * self.size).then_some(self.length_s)
    }
}

/// Notes of each mode `found` in a record of `record_s`, excited by a pulse of `pulse_s`; `leaks`:
/// the residual is not the sensor noise.
pub fn note(modes: &mut [IdentifiedMode], found: &[Estimate], record_s: f64, pulse_s: Option<f64>, leaks: bool) {
    let mut said = advice(found, record_s, None);
    if let Some(pulse_s) = pulse_s {
        said.extend(found.iter().filter_map(|mode| pulse_nulling(mode.frequency_hz, pulse_s)));
    }
    for (mode, found) in modes.iter_mut().zip(found) {
        let is = |f: &f64| *f == found.frequency_hz;
        mode.input_leaks = u16::from(leaks);
        for advice in &said {
            match advice {
                Advice::PulseNulled { frequency_hz, .. } if is(frequency_hz) => mode.pulse_nulled = 1,
                Advice::RecordTooShort { frequency_hz, .. } if is(frequency_hz) => mode.record_short = 1,
                Advice::CloseModes { lower_hz, upper_hz, .. } if is(lower_hz) || is(upper_hz) => mode.close_modes = 1,
                _ => {}
            }
        }
    }
}
