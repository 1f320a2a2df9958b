//! A recording as a table: one time column, one rate, named columns in SI.

use crate::error::RecordingError;
use crate::rows::{Axis, Rows};
use crate::timing::Timing;

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

    /// Index of the column called `name`.
    #[must_use]
    pub fn column_named(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }
}
