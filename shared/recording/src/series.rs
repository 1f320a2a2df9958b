//! Recordings of any plant: named scalar channels in SI, each with sample times of its own.
//!
//! Nothing ties the channels together: sensors of different rates, a camera that skips, a log that is written on
//! change. A table is the special case of one time column.

use crate::error::{Place, RecordingError};
use crate::units::unit_named;

/// Begins the note that says why a set of channels is no table.
pub(crate) const NOT_ONE_RATE: &str = "not one rate: ";

/// One channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    pub name: String,
    /// SI unit of the values.
    pub unit: &'static str,
    /// Unit the file gave them in.
    pub unit_in_file: String,
    /// Times of the samples [s], strictly increasing.
    pub time_s: Vec<f64>,
    /// One finite value per time.
    pub values: Vec<f64>,
}

impl Series {
    /// A channel that is in SI already.
    #[must_use]
    pub fn si(name: &str, unit: &'static str, time_s: Vec<f64>, values: Vec<f64>) -> Self {
        Series { name: name.into(), unit, unit_in_file: unit.into(), time_s, values }
    }
}

/// A recording of channels.
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesSet {
    /// Name of the file, for messages.
    pub file: String,
    pub channels: Vec<Series>,
    /// Repairs and doubts, for the reader of a report.
    pub notes: Vec<String>,
}

/// Several recordings in one file: time starts again between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Segments {
    /// Name of the file, for messages.
    pub file: String,
    /// The recordings, each with its own lines in the name.
    pub parts: Vec<SeriesSet>,
    /// Where part `i + 1` begins.
    pub restarts: Vec<Restart>,
}

/// A place at which time starts again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Restart {
    pub line: u64,
    pub before_s: f64,
    pub after_s: f64,
}

impl Segments {
    /// The refusal where one recording is needed.
    pub(crate) fn refusal(&self) -> RecordingError {
        let Restart { line, before_s, after_s } = self.restarts[0];
        restarted(&self.file, line, before_s, after_s)
    }
}

/// Time that starts again at `line`.
pub(crate) fn restarted(file: &str, line: u64, before: f64, value: f64) -> RecordingError {
    let cure = format!("the file holds several recordings one after another: split it before line {line}");
    let place = Box::new(Place { file: file.into(), line, column: 1, name: "time [s]".into() });
    RecordingError::TimeBackwards { place, before, value, cure }
}

impl SeriesSet {
    #[must_use]
    pub fn channel_named(&self, name: &str) -> Option<&Series> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// Whether every channel has a name that files can carry, a known SI unit, finite values and increasing times.
    ///
    /// # Errors
    /// [`RecordingError::BadChannel`] for the first that has not.
    pub fn check(&self) -> Result<(), RecordingError> {
        for (i, channel) in self.channels.iter().enumerate() {
            let bad = |found: String, cure: &str| RecordingError::BadChannel {
                file: self.file.clone(),
                channel: channel.name.clone(),
                found,
                cure: cure.into(),
            };
            if let Some(found) = bad_name(&channel.name) {
                return Err(bad(found.into(), "name it in plain words, without quotes and outer blanks"));
            }
            if self.channels[..i].iter().any(|other| other.name == channel.name) {
                return Err(bad("the name stands twice".into(), "give every channel its own name"));
            }
            if unit_named(channel.unit).is_none_or(|unit| unit.si != channel.unit || unit.symbol != channel.unit) {
                let found = format!("`{}` is not an SI unit of the table of units", channel.unit);
                return Err(bad(found, "give the values in SI, `-` for a number without unit"));
            }
            check_samples(channel).map_err(|(found, cure)| bad(found, cure))?;
        }
        Ok(())
    }

    /// Calls `row` for every time at which a channel has a sample, in order: the time and, per channel, its value.
    pub(crate) fn for_each_time<E>(&self, mut row: impl FnMut(f64, &[Option<f64>]) -> Result<(), E>) -> Result<(), E> {
        let mut next = vec![0; self.channels.len()];
        let mut values = vec![None; self.channels.len()];
        loop {
            let heads = self.channels.iter().zip(&next).filter_map(|(channel, at)| channel.time_s.get(*at));
            let Some(time_s) = heads.copied().min_by(f64::total_cmp) else { return Ok(()) };
            for ((channel, at), value) in self.channels.iter().zip(&mut next).zip(&mut values) {
                let due = channel.time_s.get(*at).is_some_and(|head| *head == time_s);
                *value = due.then(|| channel.values[*at]);
                *at += usize::from(due);
            }
            row(time_s, &values)?;
        }
    }
}

/// What is wrong with a name, if anything: it must come back from a CSV header as it went in.
fn bad_name(name: &str) -> Option<&'static str> {
    if name.is_empty() {
        Some("the name is empty")
    } else if name == "time" {
        Some("`time` is the name of the time column")
    } else if name != name.trim() || name.starts_with('\u{feff}') {
        Some("the name begins or ends with a blank")
    } else if name.contains(|c: char| c == '"' || c.is_control()) {
        Some("the name has a quote or a control character in it")
    } else {
        None
    }
}

fn check_samples(channel: &Series) -> Result<(), (String, &'static str)> {
    let (times, values) = (&channel.time_s, &channel.values);
    if times.len() != values.len() {
        let found = format!("{} times and {} values", times.len(), values.len());
        return Err((found, "give one value per time"));
    }
    if let Some(i) = (0..times.len()).find(|i| !(times[*i].is_finite() && values[*i].is_finite())) {
        let found = format!("sample {} is {} at {} s: not finite", i + 1, values[i], times[i]);
        return Err((found, "leave the sample out: a channel need not have one at every time"));
    }
    if let Some(i) = (1..times.len()).find(|i| times[*i] <= times[*i - 1]) {
        let found = format!("sample {}: time {} s is followed by {} s", i + 1, times[i - 1], times[i]);
        return Err((found, "sort the samples by time, one value per time"));
    }
    Ok(())
}
