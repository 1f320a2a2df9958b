//! A jump in a record ends its segment: the motion after it is related to the motion before it only
//! by the jump.
//!
//! A record of accelerations alone often begins with rest before the structure is struck. Hankel
//! columns that reach over the blow hold an input that is unknown to output-only identification. A
//! segment is opened where more than half of the next three Hankel columns' rows (3 × 2i) have more
//! than `POWER_RATIO` times the mean power of the segment so far, and more than half of the first
//! `BLOW_ROWS` too (power: squared distance from the segment's mean, over all channels). That is
//! ten standard deviations of all that was seen before, at once, and for longer than the columns
//! lost at the border. A wild sample, a footfall that dies out at once, or vibration of changing
//! strength does not do that.
//!
//! Assumes that rest lasts at least `BASELINE_ROWS` rows; a shorter one is too short to be known.
//! Fails on a decay less than 20 dB above the rest, or shorter than half of those rows: the border
//! is not worth its columns there.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::identifier::ModalIdentifier;

/// Hankel columns (2i rows each) over which a jump has to last.
const LASTING_COLUMNS: usize = 3;
/// Rows in which a blow is over.
const BLOW_ROWS: usize = 8;
/// Rows from which the power so far is known: to 25 % even with one channel.
const BASELINE_ROWS: u64 = 32;
/// Power of a jump over the power so far.
const POWER_RATIO: f64 = 100.0;

/// Gate in front of an identifier; rows wait in it until it is known whether a jump begins with
/// them.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct OnsetGate {
    rows: u64,
    /// Per channel, over the rows of this segment that went through.
    mean: Vec<f64>,
    squares: f64,
    /// Powers and values of the rows that wait.
    powers: VecDeque<f64>,
    values: VecDeque<f64>,
    /// The row that goes through.
    row: Vec<f64>,
}

impl OnsetGate {
    /// Takes a row; hands the identifier the rows of which it is known that no jump begins with
    /// them.
    pub fn push(&mut self, row: &[f64], identifier: &mut ModalIdentifier) {
        if row.iter().any(|y| !y.is_finite()) {
            self.end_segment(identifier);
            identifier.push(row);
            return;
        }
        let most = LASTING_COLUMNS * 2 * identifier.config().block_rows;
        if self.mean.is_empty() {
            self.take_memory(row.len(), most);
        }
        self.powers.push_back(row.iter().zip(&self.mean).map(|(y, mean)| (y - mean) * (y - mean)).sum());
        self.values.extend(row);
        if self.powers.len() < most {
            return;
        }
        if self.jumps() {
            self.turn(identifier);
        } else {
            self.release(identifier);
        }
    }

    /// Returns the waiting samples and clears the segment.
    pub fn end_segment(&mut self, identifier: &mut ModalIdentifier) {
        while !self.powers.is_empty() {
            self.release(identifier);
        }
        self.forget();
    }

    /// With the first row, for all that will ever wait.
    fn take_memory(&mut self, channels: usize, rows: usize) {
        self.mean = vec![0.0; channels];
        self.row.reserve_exact(channels);
        self.powers.reserve_exact(rows);
        // what waits, and the row that is on its way out
        self.values.reserve_exact((rows + 1) * channels);
    }

    /// Clears the sums of the segment; memory stays.
    fn forget(&mut self) {
        self.mean.fill(0.0);
        (self.rows, self.squares) = (0, 0.0);
    }

    /// Whether a jump begins with the oldest row that waits.
    fn jumps(&self) -> bool {
        let limit = POWER_RATIO * self.squares / self.rows as f64;
        let most = |rows: usize| 2 * self.powers.iter().take(rows).filter(|power| **power > limit).count() > rows;
        self.rows >= BASELINE_ROWS && self.powers[0] > limit && most(BLOW_ROWS) && most(self.powers.len())
    }

    /// The new segment begins with the strongest of the first rows, when the blow is over.
    fn turn(&mut self, identifier: &mut ModalIdentifier) {
        let mut strongest = 0;
        for (index, power) in self.powers.iter().enumerate().take(BLOW_ROWS) {
            if *power > self.powers[strongest] {
                strongest = index;
            }
        }
        identifier.open_segment();
        self.forget();
        let channels = self.mean.len();
        self.powers.drain(..strongest);
        self.values.drain(..strongest * channels);
        // Against the mean of a segment of which nothing is known.
        let rows = self.values.make_contiguous().chunks_exact(channels);
        for (power, row) in self.powers.iter_mut().zip(rows) {
            *power = row.iter().map(|y| y * y).sum();
        }
        // A segment without rows behind it is not judged: what waits in full length passes on.
        if strongest == 0 {
            self.release(identifier);
        }
    }

    fn release(&mut self, identifier: &mut ModalIdentifier) {
        self.powers.pop_front();
        self.row.clear();
        self.row.extend(self.values.drain(..self.mean.len()));
        self.rows += 1;
        for (y, mean) in self.row.iter().zip(&mut self.mean) {
            let before = y - *mean;
            *mean += before / self.rows as f64;
            self.squares += before * (y - *mean);
        }
        identifier.push(&self.row);
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
            // An ambient mode whose excitation swings over a factor of nine in power, a wild sample
            // and a footfall.
            let strength = 2.0 + libm::sin(n as f64 / 300.0);
            state = [1.94 * state[0] - 0.98 * state[1] + strength * noise.normal(), state[0]];
            let footfall = if (2500..2540).contains(&n) { 1e3 * noise.normal() } else { 0.0 };
            let wild = if n == 1500 { 1e4 } else { footfall };
            record.push([state[0] + wild, 0.5 * state[0] + noise.normal()]);
        }
        let (gated, plain) = (identify(&record, true), identify(&record, false));
        assert_eq!(printed(&gated.0), printed(&plain.0));
    }

    fn printed(identifier: &ModalIdentifier) -> String {
        format!("{identifier:?}")
    }
}
