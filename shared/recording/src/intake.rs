//! What the reader of a recording is told beside the file: which column is the clock, which dataset
//! is meant, which channel is which and in what unit.
//!
//! What the file says is used. What the file does not say, the user says once: on the command line
//! ([`Intake::time_column`], [`Intake::channels`]) or in a map file ([`Intake::read_map`]).
//! What cannot be used is left out and named.
//!
//! A map is TOML: `[channels]` with lines `rate = "rate_z [deg/s]"` or
//! `rate = { name = "rate_z", scale = -1, unit = "deg/s" }`, left the user's own name, right the
//! name in the file; above them `time = "stamp:us"` and `dataset = "imu"` where they are needed.

mod assignment;
pub(crate) mod clock;
pub(crate) mod day_counts;
pub(crate) mod guessed_unit;
pub(crate) mod join;
pub(crate) mod listing;
mod map_file;
pub(crate) mod names;
pub(crate) mod origin;
pub(crate) mod plan;
pub(crate) mod quantities;
pub(crate) mod second_clock;
pub(crate) mod stamps;
pub(crate) mod times;

pub use assignment::{Assignment, Origin};
pub use clock::TimeColumn;
pub use listing::{ListedChannel, ListedDataset};
pub use map_file::example as map_example;
pub(crate) use map_file::names_no_channel;

use crate::error::RecordingError;

/// What is said about a file beside the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Intake {
    /// The column of times and its unit, where the file does not say.
    pub time_column: Option<TimeColumn>,
    /// The dataset, topic or message that is meant, where the file holds several.
    pub dataset: Option<String>,
    /// Own names, units and scales of channels.
    pub channels: Vec<Assignment>,
    /// Channels may have clocks of their own: what the reader of the recording can take, not what
    /// is said of the file. Time histories of different clocks are then read together.
    pub clocks_of_their_own: bool,
}

impl Intake {
    /// Nothing is said: the file speaks for itself.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let clocks_of_their_own = self.clocks_of_their_own;
        *self == Intake { clocks_of_their_own, ..Intake::default() }
    }

    /// Adds what the text of a map says, `file` being its name in messages; what is said already
    /// stands.
    ///
    /// # Errors
    /// TOML that does not parse, an unknown key, an unknown unit: with file, line, value and cure.
    pub fn read_map(&mut self, file: &str, text: &str) -> Result<(), RecordingError> {
        map_file::read_text(self, file, text)
    }

    /// The text of a map that says the same.
    #[must_use]
    pub fn to_map_text(&self) -> String {
        let quoted = |text: &str| toml::Value::String(text.into()).to_string();
        let mut text = String::new();
        if let Some(TimeColumn { name, unit }) = &self.time_column {
            let unit = unit.map_or(String::new(), |unit| format!(":{:e}s", unit.to_si(1.0)));
            text.push_str(&format!("time = {}\n", quoted(&format!("{name}{unit}"))));
        }
        text.extend(self.dataset.iter().map(|name| format!("dataset = {}\n", quoted(name))));
        if !self.channels.is_empty() {
            text.push_str("[channels]\n");
        }
        for of in &self.channels {
            let unit = of.unit.map_or(String::new(), |_| format!(", unit = {}", quoted(&of.unit_text)));
            let (own, theirs, scale) = (quoted(&of.own), quoted(&of.theirs), of.scale);
            text.push_str(&format!("{own} = {{ name = {theirs}{unit}, scale = {scale:e} }}\n"));
        }
        text
    }

    /// Says the same, and leaves the channels their names of the file.
    #[must_use]
    pub fn with_names_of_the_file(mut self) -> Self {
        self.channels.iter_mut().for_each(|of| of.own.clone_from(&of.theirs));
        self
    }
}
