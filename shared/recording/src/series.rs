//! Recordings of any plant: named scalar channels in SI, each with sample times of its own.
//!
//! Nothing ties the channels together: sensors of different rates, a camera that skips, a log that
//! is written on change. A table is the special case of one time column.

use crate::error::{Place, RecordingError};
use crate::units::si_unit;
use channels::{Channel, Recording};
use std::collections::BTreeMap;

/// Begins the note that says why a set of channels is no table.
pub(crate) const NOT_ONE_RATE: &str = "not one rate: ";

/// A recording of channels as a file gave it.
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesSet {
    /// Under the name of the file: channels in SI, times strictly increasing, values finite.
    pub recording: Recording,
    /// Units that the file gave, by channel, where they are not the channel's own.
    units_in_file: BTreeMap<String, String>,
    /// What the times count from \[s since 1970\]; 0: from where the file says.
    pub origin_s: i64,
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
    /// The error where one recording is needed.
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
    /// A recording without channels.
    #[must_use]
    pub fn new(file: &str) -> Self {
        let recording = Recording { name: file.into(), channels: Vec::new() };
        SeriesSet { recording, units_in_file: BTreeMap::new(), origin_s: 0, notes: Vec::new() }
    }

    /// Adds a channel in SI, and the unit in which the file gave it.
    pub fn push(&mut self, channel: Channel, unit_in_file: &str) {
        if unit_in_file != channel.unit && !unit_in_file.is_empty() {
            self.units_in_file.insert(channel.name.clone(), unit_in_file.into());
        }
        self.recording.channels.push(channel);
    }

    /// Unit in which the file gave a channel of this recording.
    #[must_use]
    pub fn unit_in_file<'s>(&'s self, channel: &'s Channel) -> &'s str {
        self.units_in_file.get(&channel.name).unwrap_or(&channel.unit)
    }
}

/// Whether every channel has a name that files can carry, a known SI unit, finite values and
/// increasing times.
///
/// # Errors
/// [`RecordingError::BadChannel`] for the first that has not.
pub fn check(recording: &Recording) -> Result<(), RecordingError> {
    for (i, channel) in recording.channels.iter().enumerate() {
        let bad = |(found, cure)| bad_channel(recording, channel, found, cure);
        if let Some(found) = bad_name(&channel.name) {
            return Err(bad((found.into(), "name it in plain words, without quotes and outer blanks")));
        }
        if recording.channels[..i].iter().any(|other| other.name == channel.name) {
            return Err(bad(("the name stands twice".into(), "give every channel its own name")));
        }
        check_unit(recording, channel)?;
        check_samples(channel).map_err(bad)?;
    }
    Ok(())
}

fn bad_channel(recording: &Recording, channel: &Channel, found: String, cure: &str) -> RecordingError {
    let (file, channel) = (recording.name.clone(), channel.name.clone());
    RecordingError::BadChannel { file, channel, found, cure: cure.into() }
}

/// The unit of a channel as the table of units has it.
pub(crate) fn check_unit(recording: &Recording, channel: &Channel) -> Result<&'static str, RecordingError> {
    si_unit(&channel.unit).ok_or_else(|| {
        let found = format!("`{}` is not an SI unit of the table of units", channel.unit);
        bad_channel(recording, channel, found, "give the values in SI, `-` for a number without unit")
    })
}

/// Calls `row` for every time at which a channel has a sample, in order: the time and, per channel,
/// its value.
pub(crate) fn for_each_time<E>(
    recording: &Recording,
    mut row: impl FnMut(f64, &[Option<f64>]) -> Result<(), E>,
) -> Result<(), E> {
    let channels = &recording.channels;
    let mut next = vec![0; channels.len()];
    let mut values = vec![None; channels.len()];
    loop {
        let heads = channels.iter().zip(&next).filter_map(|(channel, at)| channel.time_s.get(*at));
        let Some(time_s) = heads.copied().min_by(f64::total_cmp) else { return Ok(()) };
        for ((channel, at), value) in channels.iter().zip(&mut next).zip(&mut values) {
            let due = channel.time_s.get(*at).is_some_and(|head| *head == time_s);
            *value = due.then(|| channel.value[*at]);
            *at += usize::from(due);
        }
        row(time_s, &values)?;
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

fn check_samples(channel: &Channel) -> Result<(), (String, &'static str)> {
    let (times, values) = (&channel.time_s, &channel.value);
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
