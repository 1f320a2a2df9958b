//! Rows in the order of a list whose newest entry stands first.

use super::{Axis, Rows};
use crate::error::RecordingError;
use crate::series::restarted;

impl Rows {
    /// Whether a time goes back as all before it did, from the second row on.
    pub(super) fn is_newest_first(&self, value: f64) -> bool {
        let goes_back = self.first.last().is_some_and(|before| value < *before);
        self.axis == Axis::Time && goes_back && (self.newest_first || self.first.len() == 1)
    }

    /// The error of a time that rises behind rows with the newest first; of a single step back the
    /// one that went back is at fault.
    pub(super) fn rises(&self, line: u64, before: f64, value: f64) -> RecordingError {
        if self.count() == 2 {
            return restarted(&self.file, self.lines[1], self.first[0], self.first[1]);
        }
        let cure =
            format!("the rows above have the newest first: sort them by time, or split the file before line {line}");
        RecordingError::TimeBackwards { place: self.place(line, 0), before, value, cure }
    }

    /// Puts the oldest row first. Gives a note on what was done.
    pub(super) fn oldest_first(&mut self) -> Option<String> {
        if !core::mem::take(&mut self.newest_first) {
            return None;
        }
        let last = self.count().saturating_sub(1);
        self.first.reverse();
        self.lines.reverse();
        self.values.iter_mut().for_each(|values| values.reverse());
        self.repeated.iter_mut().for_each(|row| *row = last - *row);
        self.repeated.reverse();
        Some("the newest row stands first: the rows were put in the order of their times".into())
    }
}
