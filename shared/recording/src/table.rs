//! A recording as a table: one time column, one rate, named columns in SI.

use crate::error::{Place, RecordingError};
use crate::timing::{Timing, examine};

/// A column in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    pub name: String,
    /// SI unit of the values.
    pub unit: &'static str,
    /// Unit the file gave them in.
    pub unit_in_file: String,
    pub values: Vec<f64>,
}

impl Column {
    /// A column that is in SI already.
    #[must_use]
    pub fn si(name: &str, unit: &'static str, values: Vec<f64>) -> Self {
        Column { name: name.into(), unit, unit_in_file: unit.into(), values }
    }

    /// Header text as it stands in the file.
    #[must_use]
    pub fn header(&self) -> String {
        format!("{} [{}]", self.name, self.unit_in_file)
    }
}

/// An imported time record.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of the file, for messages.
    pub file: String,
    /// Strictly increasing.
    pub time_s: Vec<f64>,
    pub columns: Vec<Column>,
    pub timing: Timing,
    /// Repairs and doubts, for the reader of a report.
    pub notes: Vec<String>,
}

impl Table {
    /// A table from columns in memory, under the same rules as one from a file; row `i` counts as line `i + 2`.
    ///
    /// # Errors
    /// As for a file: time that does not increase, values that are not finite, more than one rate.
    pub fn from_columns(file: &str, time_s: Vec<f64>, columns: Vec<Column>) -> Result<Self, RecordingError> {
        let mut builder = TableBuilder::new(file, columns);
        let mut row = Vec::new();
        for (i, time) in time_s.iter().enumerate() {
            row.clear();
            row.push(*time);
            for column in &builder.source {
                row.push(column.values.get(i).copied().unwrap_or(f64::NAN));
            }
            builder.push(i as u64 + 2, &row)?;
        }
        builder.finish()
    }

    /// Index of the column called `name`.
    #[must_use]
    pub fn column_named(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }
}

/// Takes rows in the order of the file and applies the policy for bad time.
pub(crate) struct TableBuilder {
    file: String,
    source: Vec<Column>,
    time_s: Vec<f64>,
    values: Vec<Vec<f64>>,
    lines: Vec<u64>,
    duplicates: u64,
}

impl TableBuilder {
    pub fn new(file: &str, columns: Vec<Column>) -> Self {
        let values = columns.iter().map(|_| Vec::new()).collect();
        TableBuilder {
            file: file.into(),
            source: columns,
            time_s: Vec::new(),
            values,
            lines: Vec::new(),
            duplicates: 0,
        }
    }

    pub fn rows(&self) -> usize {
        self.time_s.len()
    }

    fn place(&self, line: u64, column: usize) -> Box<Place> {
        let name = if column == 0 { "time [s]".into() } else { self.source[column - 1].header() };
        Box::new(Place { file: self.file.clone(), line, column: column + 1, name })
    }

    /// One row in SI: time, then the columns.
    pub fn push(&mut self, line: u64, row: &[f64]) -> Result<(), RecordingError> {
        if let Some(bad) = row.iter().position(|value| !value.is_finite()) {
            return Err(RecordingError::NotFinite { place: self.place(line, bad), value: row[bad].to_string() });
        }
        if let Some(&before) = self.time_s.last() {
            if row[0] < before {
                return Err(self.backwards(line, before, row[0]));
            }
            if row[0] == before {
                return self.same_time(line, row);
            }
        }
        self.time_s.push(row[0]);
        self.lines.push(line);
        for (values, value) in self.values.iter_mut().zip(&row[1..]) {
            values.push(*value);
        }
        Ok(())
    }

    fn backwards(&self, line: u64, before: f64, value: f64) -> RecordingError {
        let cure = if value <= self.time_s[0] {
            format!("the file holds several recordings one after another: split it before line {line}")
        } else {
            format!("sort the rows by time, or split the file before line {line}")
        };
        RecordingError::TimeBackwards { place: self.place(line, 0), before, value, cure }
    }

    /// The same row again is dropped and counted; another row at the same time is a contradiction.
    fn same_time(&mut self, line: u64, row: &[f64]) -> Result<(), RecordingError> {
        let last = self.time_s.len() - 1;
        for (i, value) in row[1..].iter().enumerate() {
            let first = self.values[i][last];
            if first != *value {
                return Err(RecordingError::TimeConflict {
                    place: self.place(line, i + 1),
                    value: row[0],
                    differs: self.source[i].header(),
                    first,
                    second: *value,
                });
            }
        }
        self.duplicates += 1;
        Ok(())
    }

    pub fn finish(self) -> Result<Table, RecordingError> {
        let timing = examine(&self.file, &self.time_s, &self.lines, self.duplicates)?;
        let columns = self.source.into_iter().zip(self.values).map(|(column, values)| Column { values, ..column });
        let notes = timing.repairs();
        Ok(Table { file: self.file, time_s: self.time_s, columns: columns.collect(), timing, notes })
    }
}
