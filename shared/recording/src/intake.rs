//! What the reader of a recording is told beside the file: which column is the clock, which dataset
//! is meant, which channel is which and in what unit.
//!
//! What the file says is used. What the file does not say, the user says once: on the command line
//! ([`Intake::time_column`], [`Intake::channels`]) or in a map file ([`Intake::read_map`]).
//! What cannot be used is left out and named.
//!
//! A map is TOML: `[channels]` with lines `rate = "rate_z [deg/s]"` or
//! `rate = { name = "rate_z", scale = -1, unit = "deg/s" }`, left the user's own name, right the name
//! in the file; above them `time = "stamp:us"` and `dataset = "imu"` where they are needed.

mod assignment;
pub(crate) mod clock;
pub(crate) mod join;
pub(crate) mod listing;
mod map_file;
pub(crate) mod names;
pub(crate) mod plan;

pub use assignment::{Assignment, Origin};
pub use clock::TimeColumn;
pub use listing::{ListedChannel, ListedDataset};
pub use map_file::example as map_example;

use crate::error::RecordingError;
use std::path::Path;

/// What is said about a file beside the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Intake {
    /// The column of times and its unit, where the file does not say.
    pub time_column: Option<TimeColumn>,
    /// The dataset, topic or message that is meant, where the file holds several.
    pub dataset: Option<String>,
    /// Own names, units and scales of channels.
    pub channels: Vec<Assignment>,
}

impl Intake {
    /// Nothing is said: the file speaks for itself.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Intake::default()
    }

    /// Adds what a map file says; what is said already stands.
    ///
    /// # Errors
    /// TOML that does not parse, an unknown key, an unknown unit: with file, line, value and cure.
    pub fn read_map(&mut self, path: &Path) -> Result<(), RecordingError> {
        map_file::read(self, path)
    }

    /// The assignment of the channel that the file calls one of `theirs`.
    pub(crate) fn assignment_of(&self, theirs: &[&str]) -> Option<&Assignment> {
        let exact = self.channels.iter().find(|of| theirs.contains(&of.theirs.as_str()));
        let alike = |of: &&Assignment| theirs.iter().any(|name| name.eq_ignore_ascii_case(&of.theirs));
        exact.or_else(|| self.channels.iter().find(alike))
    }
}
