//! What a file holds before anything is chosen from it: datasets of columns as they were written.

/// A column as the file gives it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawColumn {
    /// Own name: without the dataset's, without the unit.
    pub name: String,
    /// Text of the unit, where the file states one.
    pub unit: Option<String>,
    /// One value a row, in the unit of the file; NaN where there is no sample.
    pub values: Vec<f64>,
    /// What an `f64` does not hold of each value, in the same unit: of whole numbers beyond 2^53.
    /// Empty: nothing.
    pub rest: Vec<f64>,
}

/// What leads the rows of a dataset.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Axis {
    /// The format does not say: the column of times is found by name or named by the user.
    #[default]
    Unknown,
    /// This column holds times, in its unit (s where the column states none).
    Time(usize),
    /// This column holds frequencies \[Hz\].
    Frequency(usize),
    /// Rows follow each other at a constant interval.
    Uniform { start_s: f64, interval_s: f64 },
}

/// Rows recorded together: a table, a topic, the messages of one kind, arrays of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawDataset {
    /// Name inside the file; empty where a file holds one dataset without a name.
    pub name: String,
    pub columns: Vec<RawColumn>,
    pub axis: Axis,
    /// What was left out or repaired, and why.
    pub notes: Vec<String>,
}

impl RawDataset {
    /// Rows of the longest column.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.columns.iter().map(|column| column.values.len()).max().unwrap_or(0)
    }
}

/// Which datasets of a file are wanted, by name.
pub type Wanted<'a> = dyn Fn(&str) -> bool + 'a;
