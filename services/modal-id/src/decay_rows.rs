//! Rows of a free decay on which its modes are tested: the beginning in full, then ever sparser.
//!
//! The first [`FULL_ROWS`] rows are kept, then [`OCTAVE_ROWS`] of each doubling of the segment's
//! length. A decay is strongest at its beginning and slow modes need its whole length: rows spaced
//! so show a mode of any period at any sample rate, in memory that grows with the logarithm of the
//! length and ends at [`ROWS_MAX`].
//!
//! Why not the newest rows? They hold the sensor noise into which the decay has died away, and any
//! model fits noise.

use serde::{Deserialize, Serialize};

/// Rows kept from the beginning of the segment.
const FULL_ROWS: usize = 256;
/// Rows kept of each doubling of the segment's length behind them.
const OCTAVE_ROWS: usize = 128;
/// Reached after 2²² rows, more than an hour at 1 kHz.
const ROWS_MAX: usize = FULL_ROWS + 14 * OCTAVE_ROWS;

/// Number of the row (from the segment's first) that is kept as the `index`-th.
fn number_of(index: usize) -> usize {
    match index.checked_sub(FULL_ROWS) {
        None => index,
        Some(behind) => (FULL_ROWS + 2 * (behind % OCTAVE_ROWS)) << (behind / OCTAVE_ROWS),
    }
}

/// The rows of the first segment that is long enough.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct DecayRows {
    /// Rows of one value per channel, one after the other.
    values: Vec<f64>,
    kept: usize,
    /// Rows of the segment so far.
    seen: usize,
    last_t_ns: u64,
    complete: bool,
}

impl DecayRows {
    /// Takes the memory for rows of `channels` values.
    pub fn new(channels: usize) -> Self {
        Self { values: Vec::with_capacity(ROWS_MAX * channels), ..Self::default() }
    }

    /// A segment begins. It replaces the one before unless that one had [`FULL_ROWS`] rows.
    pub fn begin_segment(&mut self) {
        if self.kept >= FULL_ROWS {
            self.complete = true;
        } else {
            self.values.clear();
            (self.kept, self.seen, self.last_t_ns) = (0, 0, 0);
        }
    }

    /// Takes the next row of the segment, one value per channel, at time `t_ns`; keeps it if it is
    /// on the grid and there is room.
    pub fn push(&mut self, row: &[f64], t_ns: u64) {
        if self.complete || self.kept == ROWS_MAX {
            return;
        }
        if self.seen == number_of(self.kept) {
            self.values.extend_from_slice(row);
            self.kept += 1;
            self.last_t_ns = t_ns;
        }
        self.seen += 1;
    }

    /// The rows kept, one after the other, each with one value per channel in the unit of the
    /// record.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Rows kept.
    pub fn len(&self) -> usize {
        self.kept
    }

    /// Time of the last row kept.
    pub fn last_t_ns(&self) -> u64 {
        self.last_t_ns
    }

    /// Time of the `index`-th row kept behind the segment's first.
    pub fn time_s(index: usize, rate_hz: f64) -> f64 {
        number_of(index) as f64 / rate_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_kept_are_the_rows_whose_numbers_are_told_and_reach_over_the_whole_segment() {
        for length in [1, 255, 256, 257, 800, 12_000, 60_000] {
            let mut rows = DecayRows::default();
            (0..length).for_each(|n| rows.push(&[n as f64, -(n as f64)], n as u64));
            for (index, row) in rows.values().chunks_exact(2).enumerate() {
                assert_eq!(row[0], 1e3 * DecayRows::time_s(index, 1e3), "row {index} of {length}");
            }
            assert!(rows.len() <= ROWS_MAX && rows.values().len() == 2 * rows.len());
            // The last row kept is at most one spacing of its octave (1/128 of the length so far)
            // from the end.
            assert!(rows.last_t_ns() as f64 >= (length - 1) as f64 * (1.0 - 1.0 / 64.0) - 1.0, "{length}");
        }
    }

    #[test]
    fn memory_is_bounded_and_a_long_first_segment_stays() {
        let mut rows = DecayRows::default();
        (0..5_000_000).for_each(|n| rows.push(&[1.0], n));
        assert_eq!(rows.len(), ROWS_MAX);
        rows.begin_segment();
        rows.push(&[7.0], 1);
        assert!(rows.len() == ROWS_MAX && rows.values().iter().all(|value| *value == 1.0));
        let mut short = DecayRows::default();
        (0..10).for_each(|n| short.push(&[1.0], n));
        short.begin_segment();
        short.push(&[7.0], 1);
        assert_eq!(short.values(), [7.0]);
    }
}
