//! A jump in a record ends its segment: what follows is related to what the structure did before only by the jump.
//!
//! A record of accelerations alone often begins with rest before the structure is struck. Hankel columns that reach over
//! the blow hold an input that output-only identification knows nothing of. A segment is opened where, within
//! [`WINDOW_ROWS`] rows, more than half have more than [`POWER_RATIO`] times the mean power of the segment so far (power:
//! squared distance from the segment's mean, over all channels). Vibration of changing strength does not do that: ten
//! standard deviations of all that was seen before, at once and sustained. A single wild sample does not either.
//!
//! Assumes that rest lasts at least [`BASELINE_ROWS`] rows; a shorter one is too short to matter or to be known.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::identifier::ModalIdentifier;

/// Rows that wait until it is known whether a jump begins with them.
const WINDOW_ROWS: usize = 8;
/// Rows from which the power so far is known: to 25 % even with one channel.
const BASELINE_ROWS: u64 = 32;
/// Power of a jump over the power so far.
const POWER_RATIO: f64 = 100.0;

/// Gate in front of an identifier.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct OnsetGate {
    rows: u64,
    /// Per channel, over the rows of this segment that went through.
    mean: Vec<f64>,
    squares: f64,
    /// Powers and values of the rows that wait.
    powers: VecDeque<f64>,
    values: VecDeque<f64>,
}

impl OnsetGate {
    /// Takes a row; hands the identifier the rows of which it is known that no jump begins with them.
    pub fn push(&mut self, row: &[f64], identifier: &mut ModalIdentifier) {
        if row.iter().any(|y| !y.is_finite()) {
            self.end_segment(identifier);
            identifier.push(row);
            return;
        }
        if self.mean.is_empty() {
            self.mean = vec![0.0; row.len()];
        }
        self.powers.push_back(row.iter().zip(&self.mean).map(|(y, mean)| (y - mean) * (y - mean)).sum());
        self.values.extend(row);
        if self.powers.len() < WINDOW_ROWS {
            return;
        }
        if self.jumps() {
            self.turn(identifier);
        } else {
            self.release(identifier);
        }
    }

    /// Hands over what waits and forgets the segment.
    pub fn end_segment(&mut self, identifier: &mut ModalIdentifier) {
        while !self.powers.is_empty() {
            self.release(identifier);
        }
        *self = Self::default();
    }

    fn is_strong(&self, power: f64) -> bool {
        power > POWER_RATIO * self.squares / self.rows as f64
    }

    fn jumps(&self) -> bool {
        let strong = self.powers.iter().filter(|&&power| self.is_strong(power)).count();
        self.rows >= BASELINE_ROWS && 2 * strong > WINDOW_ROWS
    }

    /// Rows before the jump belong to the old segment; the new one begins with the strongest row, when the blow is over.
    fn turn(&mut self, identifier: &mut ModalIdentifier) {
        let channels = self.mean.len();
        let first = self.powers.iter().position(|&power| self.is_strong(power)).unwrap_or(0);
        let mut strongest = first;
        for (index, power) in self.powers.iter().enumerate() {
            if *power > self.powers[strongest] {
                strongest = index;
            }
        }
        for _ in 0..first {
            self.release(identifier);
        }
        identifier.open_segment();
        let behind: Vec<f64> = self.values.range((strongest - first) * channels..).copied().collect();
        *self = Self::default();
        // At most as many rows as waited: too few to be judged again.
        behind.chunks_exact(channels).for_each(|row| self.push(row, identifier));
    }

    fn release(&mut self, identifier: &mut ModalIdentifier) {
        let channels = self.mean.len();
        if self.powers.pop_front().is_none() {
            return;
        }
        let row: Vec<f64> = self.values.drain(..channels).collect();
        self.rows += 1;
        for (y, mean) in row.iter().zip(&mut self.mean) {
            let before = y - *mean;
            *mean += before / self.rows as f64;
            self.squares += before * (y - *mean);
        }
        identifier.push(&row);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identifier::Config;
    use crate::test_noise::Noise;

    const MODE: (f64, f64) = (6.5, 0.01);

    /// Rest with bias and noise, then a free decay of one mode on two channels, 200 Hz.
    fn struck(rest: usize, rows: usize) -> Vec<[f64; 2]> {
        let mut noise = Noise::new(5);
        let omega = 2.0 * std::f64::consts::PI * MODE.0;
        let mut record = Vec::new();
        for n in 0..rows {
            let t = (n as f64 - rest as f64) / 200.0;
            let decay = if n < rest { 0.0 } else { libm::exp(-MODE.1 * omega * t) * libm::cos(omega * t) };
            record.push([0.2 * decay + 9.8 + 1e-3 * noise.normal(), 0.1 * decay + 1e-3 * noise.normal()]);
        }
        record
    }

    fn identify(record: &[[f64; 2]], gated: bool) -> (ModalIdentifier, Vec<crate::Mode>) {
        let (mut identifier, mut gate) = (ModalIdentifier::new(Config::new(2, 200.0)), OnsetGate::default());
        for row in record {
            if gated { gate.push(row, &mut identifier) } else { identifier.push(row) }
        }
        gate.end_segment(&mut identifier);
        let modes = identifier.identify().unwrap();
        (identifier, modes)
    }

    #[test]
    fn rest_before_the_blow_leaves_the_decay_as_it_is() {
        for rest in [50, 200, 600] {
            let (_, modes) = identify(&struck(rest, rest + 1000), true);
            assert_eq!(modes.len(), 1, "rest {rest}: {modes:?}");
            let z = [
                (modes[0].frequency_hz - MODE.0) / modes[0].sigma_frequency_hz,
                (modes[0].damping_ratio - MODE.1) / modes[0].sigma_damping,
            ];
            assert!(z.iter().all(|z| z.abs() < 4.0), "rest {rest}: {z:?} {modes:?}");
        }
    }

    #[test]
    fn a_record_that_does_not_jump_passes_unchanged() {
        let mut noise = Noise::new(9);
        let (mut state, mut record) = ([0.0, 0.0], Vec::new());
        for n in 0..4000 {
            // An ambient mode whose excitation swings over a factor of nine in power, and one wild sample.
            let strength = 2.0 + libm::sin(n as f64 / 300.0);
            state = [1.94 * state[0] - 0.98 * state[1] + strength * noise.normal(), state[0]];
            let wild = if n == 1500 { 1e4 } else { 0.0 };
            record.push([state[0] + wild, 0.5 * state[0] + noise.normal()]);
        }
        let (gated, plain) = (identify(&record, true), identify(&record, false));
        assert_eq!(printed(&gated.0), printed(&plain.0));
    }

    fn printed(identifier: &ModalIdentifier) -> String {
        format!("{identifier:?}")
    }
}
