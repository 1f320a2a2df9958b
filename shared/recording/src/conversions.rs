//! One form of a recording as another: any time record as channels, channels of one rate as a table.

use crate::Imported;
use crate::error::RecordingError;
use crate::run::RecordedRun;
use crate::run_series;
use crate::series::{NOT_ONE_RATE, Series, SeriesSet};
use crate::spectrum::Spectrum;
use crate::table::{Column, Table};

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
}
