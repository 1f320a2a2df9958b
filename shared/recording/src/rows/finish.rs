//! What rows make: a table, channels with sample times of their own, several recordings, a
//! spectrum.

use super::{Axis, Rows};
use crate::Imported;
use crate::error::{Place, RecordingError};
use crate::series::{NOT_ONE_RATE, Restart, Segments, SeriesSet, restarted};
use crate::spectrum::Spectrum;
use crate::table::{Column, Table};
use crate::timing::{Timing, check_extent, examine};
use channels::Channel;
use core::ops::Range;

impl Rows {
    /// The rows as whatever they are.
    pub fn finish(mut self) -> Result<Imported, RecordingError> {
        let clock = self.settle_clock()?;
        if self.axis == Axis::Frequency {
            return self.into_spectrum().map(Imported::Spectrum);
        }
        if self.starts.len() > 1 {
            let mut segments = self.into_segments()?;
            segments.parts.iter_mut().for_each(|part| part.notes.extend(clock.clone()));
            return Ok(Imported::Segments(segments));
        }
        let reason = match self.first_empty() {
            Some(place) => {
                check_extent(&self.file, &self.first, &self.lines)?;
                self.without_sample(&place)
            }
            None => match examine(&self.file, &self.first, &self.lines, self.duplicates) {
                Err(error) if error.is_uneven_sampling() => error.without_file(&self.file),
                timing => return timing.map(|timing| Imported::Table(self.into_table(timing, clock))),
            },
        };
        let mut notes = vec![format!("{NOT_ONE_RATE}{reason}")];
        notes.extend(clock);
        if self.duplicates > 0 {
            notes.push(format!("{} row(s) stood twice and were dropped once", self.duplicates));
        }
        let mut set = self.set(&self.file, 0..self.count());
        set.notes = notes;
        Ok(Imported::Series(set))
    }

    /// The rows as a table, or the reason why they do not make one.
    pub fn finish_table(mut self) -> Result<Table, RecordingError> {
        let clock = self.settle_clock()?;
        if self.axis == Axis::Frequency {
            return Err(Spectrum::refusal(&self.file));
        }
        if let Some(&start) = self.starts.get(1) {
            return Err(restarted(&self.file, self.lines[start], self.first[start - 1], self.first[start]));
        }
        if let Some(place) = self.first_empty() {
            let value = self.text_at(&place).unwrap_or_default().to_owned();
            return Err(RecordingError::NotANumber { place, value });
        }
        let timing = examine(&self.file, &self.first, &self.lines, self.duplicates)?;
        Ok(self.into_table(timing, clock))
    }

    fn first_empty(&self) -> Option<Box<Place>> {
        let empty = |values: &Vec<f64>| values.iter().position(|value| value.is_nan());
        let (row, column) = self.values.iter().enumerate().filter_map(|(i, values)| Some((empty(values)?, i))).min()?;
        Some(self.place(self.lines[row], column + 1))
    }

    /// Why a cell is no sample, without the file.
    fn without_sample(&self, place: &Place) -> String {
        match self.text_at(place) {
            Some(text) => format!("{}: `{text}` is not a number", place.within_file()),
            None => format!("{} is empty", place.within_file()),
        }
    }

    /// The first text of its column, where it stands here.
    fn text_at(&self, place: &Place) -> Option<&str> {
        let is_here = |of: &Place| (of.line, of.column) == (place.line, place.column);
        self.texts.iter().find(|(of, _)| is_here(of)).map(|(_, text)| &**text)
    }

    fn into_table(self, timing: Timing, clock: Option<String>) -> Table {
        let columns = self.source.into_iter().zip(self.values).map(|(column, values)| Column { values, ..column });
        let notes = clock.into_iter().chain(timing.repairs()).collect();
        let (time_s, columns) = (self.first, columns.collect());
        Table { file: self.file, time_s, origin_s: self.origin_s, columns, timing, notes }
    }

    fn into_spectrum(self) -> Result<Spectrum, RecordingError> {
        if self.count() < 2 {
            let line = self.lines.last().copied().unwrap_or(1);
            return Err(RecordingError::TooFewRows { file: self.file, line, rows: self.first.len() });
        }
        let columns = self.source.into_iter().zip(self.values).map(|(column, values)| Column { values, ..column });
        Ok(Spectrum { file: self.file, frequency_hz: self.first, columns: columns.collect(), notes: Vec::new() })
    }

    fn into_segments(self) -> Result<Segments, RecordingError> {
        let mut segments = Segments { file: self.file.clone(), parts: Vec::new(), restarts: Vec::new() };
        for (i, &start) in self.starts.iter().enumerate() {
            let rows = start..self.starts.get(i + 1).copied().unwrap_or(self.count());
            let (first, last) = (self.lines[start], self.lines[rows.end - 1]);
            if i > 0 {
                let (before_s, after_s) = (self.first[start - 1], self.first[start]);
                if rows.len() < 2 {
                    return Err(restarted(&self.file, first, before_s, after_s));
                }
                segments.restarts.push(Restart { line: first, before_s, after_s });
            }
            check_extent(&self.file, &self.first[rows.clone()], &self.lines[rows.clone()])?;
            let file = format!("{} (lines {first} to {last})", self.file);
            segments.parts.push(self.set(&file, rows));
        }
        Ok(segments)
    }

    /// The cells of some rows that are not empty, by column.
    fn set(&self, name: &str, rows: Range<usize>) -> SeriesSet {
        let mut set = SeriesSet::new(name);
        set.origin_s = self.origin_s;
        for (column, values) in self.source.iter().zip(&self.values) {
            let (times, values) = (&self.first[rows.clone()], &values[rows.clone()]);
            let given = times.iter().zip(values).filter(|(_, value)| !value.is_nan());
            let (time_s, value) = given.map(|(time, value)| (*time, *value)).unzip();
            set.push(Channel::new(&column.name, column.unit, time_s, value), &column.unit_in_file);
        }
        set
    }
}

impl Table {
    /// A table from columns in memory, under the same rules as one from a file; row `i` counts as
    /// line `i + 2`.
    ///
    /// # Errors
    /// As for a file: time that does not increase, values that are not finite, more than one rate.
    pub fn from_columns(file: &str, time_s: Vec<f64>, columns: Vec<Column>) -> Result<Self, RecordingError> {
        let empty = columns.iter().map(|column| Column { values: Vec::new(), ..column.clone() });
        let mut rows = Rows::new(file, Axis::Time, empty.collect());
        let mut row = Vec::new();
        for (i, time) in time_s.iter().enumerate() {
            row.clear();
            row.push(*time);
            row.extend(columns.iter().map(|column| column.values.get(i).copied().unwrap_or(f64::NAN)));
            rows.push_full(i as u64 + 2, &row)?;
        }
        rows.finish_table()
    }
}
