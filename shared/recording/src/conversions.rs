//! One form of a recording as another: any time record as channels, channels of one rate as a
//! table.

use crate::Imported;
use crate::error::RecordingError;
use crate::run::RecordedRun;
use crate::run_series;
use crate::series::{NOT_ONE_RATE, SeriesSet, check, check_unit};
use crate::spectrum::Spectrum;
use crate::table::{Column, Table};
use channels::{Channel, Recording};

/// The recording as channels: the columns of a table; of a run, every number its source measured
/// (`imu.omega_bi_b.z [rad/s]`, `joints.angle.1 [rad]`, names and units from the telemetry's
/// fields).
///
/// # Errors
/// A spectrum, a file of several recordings ([`segments`] takes it), a run without samples of a
/// source.
pub fn series(imported: Imported) -> Result<SeriesSet, RecordingError> {
    match imported {
        Imported::Table(table) => Ok(of_table(table)),
        Imported::Run(run) => of_run(&run),
        Imported::Series(set) => Ok(set),
        Imported::Segments(segments) => Err(segments.refusal()),
        Imported::Spectrum(spectrum) => Err(Spectrum::refusal(&spectrum.file)),
    }
}

/// The recordings of a file, one for most: as [`series`], and those of a file in which time starts
/// again.
///
/// # Errors
/// As [`series`].
pub fn segments(imported: Imported) -> Result<Vec<SeriesSet>, RecordingError> {
    match imported {
        Imported::Segments(segments) => Ok(segments.parts),
        one => series(one).map(|set| vec![set]),
    }
}

fn of_table(mut table: Table) -> SeriesSet {
    let mut set = SeriesSet::new(&table.file);
    (set.notes, set.origin_s) = (table.notes, table.origin_s);
    let last = table.columns.len().saturating_sub(1);
    for (at, Column { name, unit, unit_in_file, values, .. }) in table.columns.into_iter().enumerate() {
        // no copy of the times beside those of the channels
        let time_s = if at == last { core::mem::take(&mut table.time_s) } else { table.time_s.clone() };
        set.push(Channel::new(&name, unit, time_s, values), &unit_in_file);
    }
    set
}

fn of_run(run: &RecordedRun) -> Result<SeriesSet, RecordingError> {
    let mut set = SeriesSet::new(run.file());
    set.recording.channels = run_series::channels(run);
    if set.recording.channels.is_empty() {
        return Err(RecordingError::NoMeasurements { file: set.recording.name });
    }
    check(&set.recording)?;
    Ok(set)
}

impl SeriesSet {
    /// The channels as a table of one rate, for methods that need one.
    ///
    /// # Errors
    /// [`RecordingError::NeedsOneRate`] when the channels have times of their own or the sampling
    /// is uneven.
    pub fn table(&self) -> Result<Table, RecordingError> {
        let Recording { name: file, channels } = &self.recording;
        let time_s = channels.first().map(|first| first.time_s.clone()).unwrap_or_default();
        let noted = self.notes.iter().find_map(|note| note.strip_prefix(NOT_ONE_RATE));
        let refuse = |reason: String| {
            let reason = noted.map_or(reason, String::from);
            RecordingError::NeedsOneRate { file: file.clone(), reason }
        };
        if let Some(other) = channels.iter().find(|channel| channel.time_s != time_s) {
            let first = &channels[0].name;
            return Err(refuse(format!("channels `{first}` and `{}` were sampled at different times", other.name)));
        }
        let column = |channel: &Channel| {
            let unit = check_unit(&self.recording, channel)?;
            let (name, unit_in_file) = (channel.name.clone(), self.unit_in_file(channel).to_owned());
            Ok(Column { unit_in_file, ..Column::si(&name, unit, channel.value.clone()) })
        };
        let columns = channels.iter().map(column).collect::<Result<_, RecordingError>>()?;
        let mut table = match Table::from_columns(file, time_s, columns) {
            Err(error) if error.is_uneven_sampling() => return Err(refuse(error.without_file(file))),
            table => table?,
        };
        table.origin_s = self.origin_s;
        table.notes.splice(0..0, self.notes.iter().cloned());
        Ok(table)
    }
}
