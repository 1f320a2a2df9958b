//! Rows of a text recording in the order of the file, and what their times make of them.
//!
//! Every cell there and one rate: a [`Table`]. A cell left empty, or an uneven sampling: channels
//! with sample times of their own ([`SeriesSet`]). Time that starts again: [`Segments`]. A
//! frequency axis: a [`Spectrum`]. Stamps that are coarser than an even clock, or those of packets,
//! give way to that clock. Time that runs back into the record and two values of one channel at one
//! time are rejected.

use crate::error::{Place, RecordingError};
use crate::intake::plan::Plan;
use crate::series::restarted;
use crate::table::Column;
use crate::timing::{in_words, is_unsteady};
use channels::{EvenClock, Stamps};

mod events;
mod finish;
mod newest_first;
mod wraps;

use wraps::Wraps;

/// What the first column counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Axis {
    Time,
    Frequency,
}

/// Takes rows and applies the policy for a bad first column.
pub(crate) struct Rows {
    file: String,
    axis: Axis,
    source: Vec<Column>,
    /// Header text of the first column, where it is not the axis' own.
    first_header: Option<String>,
    /// Positions of the columns in the file, the first column's first; empty: in their order.
    positions: Vec<usize>,
    first: Vec<f64>,
    /// Per column; NaN where the cell is empty, which no cell of a file can say.
    values: Vec<Vec<f64>>,
    lines: Vec<u64>,
    /// Row at which each recording of the file begins.
    starts: Vec<usize>,
    duplicates: u64,
    /// Rows with the time of the row before that add nothing to it.
    repeated: Vec<usize>,
    /// The first of them that contradicts the row before.
    conflict: Option<RecordingError>,
    /// What times count from [s since 1970]; 0: from where the file says.
    pub origin_s: i64,
    /// What the clock has begun again.
    wraps: Wraps,
    /// The newest row stands first.
    newest_first: bool,
    /// The first cell of each column that is a text: its place and the text.
    pub texts: Vec<(Box<Place>, String)>,
}

impl Rows {
    /// No rows yet of `columns` over `axis`; `file` is named in errors.
    pub fn new(file: &str, axis: Axis, columns: Vec<Column>) -> Self {
        let values = columns.iter().map(|_| Vec::new()).collect();
        Rows {
            file: file.into(),
            axis,
            source: columns,
            first_header: None,
            positions: Vec::new(),
            first: Vec::new(),
            values,
            lines: Vec::new(),
            starts: vec![0],
            duplicates: 0,
            repeated: Vec::new(),
            conflict: None,
            origin_s: 0,
            wraps: Wraps::default(),
            newest_first: false,
            texts: Vec::new(),
        }
    }

    /// Rows by the clock of a plan, which may begin again.
    pub fn with_clock_of(self, plan: &Plan) -> Self {
        Rows { wraps: Wraps::of(plan), ..self }
    }

    /// Rows of columns that stand elsewhere in the file: header text of the first and positions.
    pub fn with_places(self, first_header: String, positions: Vec<usize>) -> Self {
        Rows { first_header: Some(first_header), positions, ..self }
    }

    /// Rows so far.
    pub fn count(&self) -> usize {
        self.first.len()
    }

    /// Drops the columns of a time record that have neither a sample nor a unit, unless all are
    /// such; gives their names. A unit makes a channel that was silent.
    pub fn leave_out_empty(&mut self) -> Vec<String> {
        let has_sample = |values: &Vec<f64>| values.iter().any(|value| !value.is_nan());
        let is_channel = |(column, values): (&Column, &Vec<f64>)| !column.unit_in_file.is_empty() || has_sample(values);
        let filled: Vec<bool> = self.source.iter().zip(&self.values).map(is_channel).collect();
        if self.axis == Axis::Frequency || filled.iter().all(|filled| !filled) {
            return Vec::new();
        }
        let empty = self.source.iter().zip(&filled).filter(|(_, filled)| !**filled);
        let names = empty.map(|(column, _)| format!("`{}` (empty)", column.name)).collect();
        self.keep_columns(&filled);
        names
    }

    /// Drops the columns that are not to be kept.
    pub fn keep_columns(&mut self, which: &[bool]) {
        let kept = |column: usize| which[column];
        retain(&mut self.source, &kept);
        retain(&mut self.values, &kept);
        if let Some((first, mut others)) = self.positions.split_first().map(|(first, others)| (*first, others.to_vec()))
        {
            retain(&mut others, &kept);
            self.positions = core::iter::once(first).chain(others).collect();
        }
    }

    fn place(&self, line: u64, column: usize) -> Box<Place> {
        let name = match (column, self.axis, &self.first_header) {
            (0, _, Some(header)) => header.clone(),
            (0, Axis::Time, None) => "time [s]".into(),
            (0, Axis::Frequency, None) => "frequency [Hz]".into(),
            (column, ..) => self.source[column - 1].header(),
        };
        let at = self.positions.get(column).copied().unwrap_or(column);
        Box::new(Place { file: self.file.clone(), line, column: at + 1, name: crate::text::printable(&name) })
    }

    /// One row in SI without empty cells.
    pub fn push_full(&mut self, line: u64, row: &[f64]) -> Result<(), RecordingError> {
        match row.iter().position(|value| value.is_nan()) {
            Some(bad) => Err(self.not_finite(line, row, bad)),
            None => self.push(line, row),
        }
    }

    fn not_finite(&self, line: u64, row: &[f64], bad: usize) -> RecordingError {
        RecordingError::NotFinite { place: self.place(line, bad), value: row[bad].to_string() }
    }

    /// One row in SI: time or frequency, then the columns, NaN where a cell is empty.
    pub fn push(&mut self, line: u64, row: &[f64]) -> Result<(), RecordingError> {
        if let Some(bad) = row.iter().position(|value| value.is_infinite()) {
            return Err(self.not_finite(line, row, bad));
        }
        if self.axis == Axis::Time && !self.newest_first {
            let start = self.starts[self.starts.len() - 1];
            let shift_s = self.wraps.shift_s(line, row[0], &self.first[start..]);
            if shift_s != 0.0 {
                let mut shifted = row.to_vec();
                shifted[0] += shift_s;
                return self.push_in_order(line, &shifted);
            }
        }
        self.push_in_order(line, row)
    }

    fn push_in_order(&mut self, line: u64, row: &[f64]) -> Result<(), RecordingError> {
        if self.is_newest_first(row[0]) {
            self.newest_first = true;
            self.add(line, row);
            return Ok(());
        }
        match (self.axis, self.first.last().copied()) {
            (Axis::Time, Some(before)) if self.newest_first && row[0] > before => {
                return Err(self.rises(line, before, row[0]));
            }
            (Axis::Frequency, before) => self.check_frequency(line, before, row[0])?,
            (Axis::Time, Some(before)) if row[0] == before => {
                self.same_time(line, row);
                return Ok(());
            }
            (Axis::Time, Some(before)) if row[0] < before => self.time_back(line, before, row[0])?,
            (Axis::Time, _) => {}
        }
        self.add(line, row);
        Ok(())
    }

    /// Way that the times go, forth and back [s].
    pub fn way_s(&self) -> f64 {
        self.first.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum()
    }

    fn add(&mut self, line: u64, row: &[f64]) {
        self.first.push(row[0]);
        self.lines.push(line);
        for (values, value) in self.values.iter_mut().zip(&row[1..]) {
            values.push(*value);
        }
    }

    fn check_frequency(&self, line: u64, before: Option<f64>, value: f64) -> Result<(), RecordingError> {
        match before {
            Some(before) if value <= before => {
                Err(RecordingError::FrequencyOrder { place: self.place(line, 0), before, value })
            }
            None if value < 0.0 => Err(RecordingError::FrequencyNegative { place: self.place(line, 0), value }),
            _ => Ok(()),
        }
    }

    /// A time at or before the beginning begins another recording; one within the record is a
    /// mistake.
    fn time_back(&mut self, line: u64, before: f64, value: f64) -> Result<(), RecordingError> {
        let start = self.starts[self.starts.len() - 1];
        if value > self.first[start] {
            let cure = format!("sort the rows by time, or split the file before line {line}");
            return Err(RecordingError::TimeBackwards { place: self.place(line, 0), before, value, cure });
        }
        if self.count() - start < 2 {
            return Err(restarted(&self.file, line, before, value));
        }
        self.starts.push(self.count());
        Ok(())
    }

    /// A row at the time of the one before fills its empty cells. The same row again, and another
    /// value at the same time, wait for the clock to tell what they are.
    fn same_time(&mut self, line: u64, row: &[f64]) {
        let last = self.count() - 1;
        let before: Vec<f64> = self.values.iter().map(|values| values[last]).collect();
        let other = |i: &usize| !before[*i].is_nan() && !row[i + 1].is_nan() && before[*i] != row[i + 1];
        let conflict = (0..before.len()).find(other);
        if conflict.is_none() && (0..before.len()).any(|i| before[i].is_nan() && !row[i + 1].is_nan()) {
            for (values, value) in self.values.iter_mut().zip(&row[1..]).filter(|(_, value)| !value.is_nan()) {
                values[last] = *value;
            }
            return;
        }
        if let (Some(i), None) = (conflict, &self.conflict) {
            self.conflict = Some(RecordingError::TimeConflict {
                place: self.place(line, i + 1),
                value: row[0],
                differs: self.source[i].header(),
                first: before[i],
                second: row[i + 1],
            });
        }
        self.repeated.push(self.count());
        self.add(line, row);
    }

    /// Puts the rows on the even clock behind their stamps, where these are coarser than it or wait
    /// for a packet; else drops rows that stand twice. Gives a note on what was done.
    ///
    /// # Errors
    /// Two values at one time that no even clock tells apart.
    fn settle_clock(&mut self) -> Result<Option<String>, RecordingError> {
        if self.axis == Axis::Frequency {
            return Ok(None);
        }
        let one = self.starts.len() == 1;
        let order = self.oldest_first().or_else(|| self.wraps.note());
        let joined = |clock: Option<String>| match (order, clock) {
            (Some(order), Some(clock)) => Some(format!("{order}; {clock}")),
            (order, clock) => order.or(clock),
        };
        if self.conflict.is_none() {
            self.drop_repeated();
        }
        let wrong = one && (self.conflict.is_some() || is_unsteady(&self.first));
        match wrong.then(|| EvenClock::of(&self.first)).flatten().filter(|clock| clock.stamps != Stamps::Right) {
            Some(clock) => {
                let as_timed = self.first.iter_mut().enumerate();
                as_timed.for_each(|(i, time)| *time = clock.time_s(i));
                Ok(joined(Some(in_words(&clock))))
            }
            None if self.has_events() => Ok(joined(Some(self.behind_events()))),
            None => self.conflict.take().map_or(Ok(joined(None)), Err),
        }
    }

    fn drop_repeated(&mut self) {
        let repeated = core::mem::take(&mut self.repeated);
        self.duplicates += repeated.len() as u64;
        self.drop_rows(&repeated);
    }

    /// Drops rows, given in their order.
    fn drop_rows(&mut self, gone: &[usize]) {
        if gone.is_empty() {
            return;
        }
        for start in &mut self.starts {
            *start -= gone.partition_point(|row| row < start);
        }
        let kept = |row: usize| gone.binary_search(&row).is_err();
        retain(&mut self.first, &kept);
        retain(&mut self.lines, &kept);
        self.values.iter_mut().for_each(|values| retain(values, &kept));
    }
}

/// Keeps the entries of some rows.
fn retain<T>(of_rows: &mut Vec<T>, kept: &dyn Fn(usize) -> bool) {
    let mut row = 0;
    of_rows.retain(|_| {
        row += 1;
        kept(row - 1)
    });
}
