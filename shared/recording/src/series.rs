//! Recordings of any plant: named scalar channels in SI, each with sample times of its own.
//!
//! Nothing ties the channels together: sensors of different rates, a camera that skips, a log that is written on
//! change. A table is the special case of one time column; [`series`] turns any time record into channels and
//! [`SeriesSet::table`] goes back where all channels share one rate.

use crate::error::{Place, RecordingError};
use crate::rows::NOT_ONE_RATE;
use crate::run::RecordedRun;
use crate::spectrum::Spectrum;
use crate::table::{Column, Table};
use crate::units::unit_named;
use crate::{Imported, run_series};

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

/// The recording as channels: the columns of a table; of a run, every number its source measured (`imu.omega_bi_b.z
/// [rad/s]`, `joints.angle.1 [rad]`, names and units from the telemetry's fields).
///
/// # Errors
/// A spectrum, a file of several recordings ([`segments`] takes it), a run without samples of a source.
pub fn series(imported: Imported) -> Result<SeriesSet, RecordingError> {
    match imported {
        Imported::Table(table) => Ok(of_table(table)),
        Imported::Run(run) => of_run(&run),
        Imported::Series(set) => Ok(set),
        Imported::Segments(segments) => Err(segments.refusal()),
        Imported::Spectrum(spectrum) => Err(Spectrum::refusal(&spectrum.file)),
    }
}

/// The recordings of a file, one for most: as [`series`], and those of a file in which time starts again.
///
/// # Errors
/// As [`series`].
pub fn segments(imported: Imported) -> Result<Vec<SeriesSet>, RecordingError> {
    match imported {
        Imported::Segments(segments) => Ok(segments.parts),
        one => series(one).map(|set| vec![set]),
    }
}

fn of_table(table: Table) -> SeriesSet {
    let Table { file, time_s, columns, notes, .. } = table;
    let channels = columns.into_iter().map(|Column { name, unit, unit_in_file, values }| Series {
        name,
        unit,
        unit_in_file,
        time_s: time_s.clone(),
        values,
    });
    SeriesSet { file, channels: channels.collect(), notes }
}

fn of_run(run: &RecordedRun) -> Result<SeriesSet, RecordingError> {
    let set = SeriesSet { file: run.file().into(), channels: run_series::channels(run), notes: Vec::new() };
    if set.channels.is_empty() {
        return Err(RecordingError::NoMeasurements { file: set.file });
    }
    set.check()?;
    Ok(set)
}

impl SeriesSet {
    #[must_use]
    pub fn channel_named(&self, name: &str) -> Option<&Series> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// The channels as a table of one rate, for methods that need one.
    ///
    /// # Errors
    /// [`RecordingError::NeedsOneRate`] when the channels have times of their own or the sampling is uneven.
    pub fn table(&self) -> Result<Table, RecordingError> {
        let time_s = self.channels.first().map(|first| first.time_s.clone()).unwrap_or_default();
        let noted = self.notes.iter().find_map(|note| note.strip_prefix(NOT_ONE_RATE));
        let refuse = |reason: String| {
            let reason = noted.map_or(reason, String::from);
            RecordingError::NeedsOneRate { file: self.file.clone(), reason }
        };
        if let Some(other) = self.channels.iter().find(|channel| channel.time_s != time_s) {
            let first = &self.channels[0].name;
            return Err(refuse(format!("channels `{first}` and `{}` were sampled at different times", other.name)));
        }
        let columns = self.channels.iter().map(|channel| Column {
            name: channel.name.clone(),
            unit: channel.unit,
            unit_in_file: channel.unit_in_file.clone(),
            values: channel.values.clone(),
        });
        let mut table = match Table::from_columns(&self.file, time_s, columns.collect()) {
            Err(error) if error.is_uneven_sampling() => return Err(refuse(error.without_file(&self.file))),
            table => table?,
        };
        table.notes.splice(0..0, self.notes.iter().cloned());
        Ok(table)
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
