//! A recording as a table: one time column, one rate, named columns in SI.

use crate::function_kind::FunctionKind;
use crate::timing::Timing;

/// A column in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    pub name: String,
    /// SI unit of the values.
    pub unit: &'static str,
    /// Unit the file gave them in.
    pub unit_in_file: String,
    /// What it is, where the file says so.
    pub kind: FunctionKind,
    pub values: Vec<f64>,
}

impl Column {
    /// A column that is in SI already.
    #[must_use]
    pub fn si(name: &str, unit: &'static str, values: Vec<f64>) -> Self {
        Column { name: name.into(), unit, unit_in_file: unit.into(), kind: FunctionKind::Unknown, values }
    }

    /// Header text as it stands in the file.
    #[must_use]
    pub fn header(&self) -> String {
        if self.unit_in_file.is_empty() { self.name.clone() } else { format!("{} [{}]", self.name, self.unit_in_file) }
    }
}

/// An imported time record.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of the file, for messages.
    pub file: String,
    /// Strictly increasing.
    pub time_s: Vec<f64>,
    /// What the times count from \[s since 1970\]; 0: from where the file says.
    pub origin_s: i64,
    pub columns: Vec<Column>,
    pub timing: Timing,
    /// Repairs and doubts, for the reader of a report.
    pub notes: Vec<String>,
}

impl Table {
    /// Index of the column called `name`.
    #[must_use]
    pub fn column_named(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }
}
