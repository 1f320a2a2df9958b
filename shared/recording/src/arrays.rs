//! Arrays without a table around them, as MATLAB, NumPy and HDF5 store them, put into datasets.
//!
//! Arrays of one structure and one length are one dataset. The dataset of a structure's main length
//! has the name of the structure, empty for what is in none; a dataset of another length N is
//! called `length_N` behind it. The main length is that of the array of times, else that of most
//! columns, else the longest. A matrix has a column `name[k]` for each step of its shorter
//! dimension; the texts of a list beside it that is as long name them, or state their units.

use crate::array_parts::{Parts, ancestors};
use crate::array_texts::TextArray;
use crate::bytes;
use crate::dataset::{Axis, RawColumn, RawDataset, Wanted};
use crate::error::RecordingError;
use crate::intake::origin::if_any;
use std::collections::{BTreeMap, BTreeSet};

/// A matrix with more columns is no set of channels.
const MATRIX_COLUMNS_MAX: usize = 64;
/// Names of a scalar that is a rate \[Hz\] and of one that is an interval \[s\], in small letters
/// without signs between them.
const RATES: [&str; 10] = [
    "fs",
    "sfreq",
    "srate",
    "samplerate",
    "sampleratehz",
    "samplingrate",
    "samplingratehz",
    "samplefrequency",
    "samplingfrequency",
    "samplingfreq",
];
const INTERVALS: [&str; 7] =
    ["dt", "deltat", "sampletime", "sampleperiod", "samplingperiod", "sampleinterval", "samplinginterval"];
/// An array of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Array {
    /// Names of the structures around it with points between; empty at the top of the file.
    pub group: String,
    pub name: String,
    pub unit: Option<String>,
    /// Names and units of the columns of a matrix, where the file states them.
    pub names: Vec<String>,
    pub units: Vec<String>,
    /// Lists of texts that the file keeps with the array.
    pub lists: Vec<(String, Vec<String>)>,
    pub shape: Vec<usize>,
    /// The first index changes fastest, as in MATLAB and Fortran.
    pub column_major: bool,
    /// The file says that these are times \[s\].
    pub is_time: bool,
    /// Column of a matrix that holds times \[s\].
    pub times: Option<usize>,
    /// Columns of a matrix that are texts.
    pub texts: Vec<usize>,
    pub values: Vec<f64>,
    /// What an `f64` does not hold of each value; empty: nothing.
    pub rest: Vec<f64>,
}

impl Array {
    /// Name with the group in front.
    pub fn full_name(&self) -> String {
        joined(&self.group, &self.name)
    }

    fn is_scalar(&self) -> bool {
        self.values.len() == 1
    }

    /// Rows and columns, the longer dimension as rows; none where more than two dimensions are
    /// longer than 1.
    fn rows_and_columns(&self) -> Option<(usize, usize)> {
        let mut long = self.shape.iter().copied().filter(|length| *length != 1);
        let (first, second) = (long.next().unwrap_or(1), long.next().unwrap_or(1));
        long.next().is_none().then_some((first.max(second), first.min(second)))
    }

    /// Columns of a matrix.
    pub fn columns(&self) -> usize {
        self.rows_and_columns().map_or(0, |(_, columns)| columns)
    }

    /// The columns of an array with so many rows and columns.
    pub fn into_columns(self, rows: usize, columns: usize) -> Vec<RawColumn> {
        if columns == 1 {
            return vec![RawColumn { name: self.name, unit: self.unit, values: self.values, rest: self.rest }];
        }
        let first = self.shape.iter().copied().find(|length| *length != 1).unwrap_or(1);
        // One column after another where rows change fastest.
        let rows_are_first = first == rows;
        let contiguous = rows_are_first == self.column_major;
        let at = |row: usize, column: usize| if contiguous { column * rows + row } else { row * columns + column };
        let of = |values: &[f64], column: usize| -> Vec<f64> {
            if values.is_empty() { Vec::new() } else { (0..rows).map(|row| values[at(row, column)]).collect() }
        };
        let column = |column: usize| RawColumn {
            name: self.names.get(column).cloned().unwrap_or_else(|| format!("{}[{column}]", self.name)),
            unit: self.unit_of(column),
            values: of(&self.values, column),
            rest: if_any(of(&self.rest, column)),
        };
        (0..columns).filter(|column| !self.texts.contains(column)).map(column).collect()
    }

    fn unit_of(&self, column: usize) -> Option<String> {
        if self.times == Some(column) {
            return Some("s".into());
        }
        self.units.get(column).cloned().or_else(|| self.unit.clone())
    }

    /// Place of the column of times among those that are no texts.
    pub fn time_column(&self, columns: usize) -> Option<usize> {
        if columns == 1 {
            return self.is_time.then_some(0);
        }
        let times = self.times?;
        Some(times - self.texts.iter().filter(|text| **text < times).count())
    }
}

/// `group.name`, or `name` at the top.
pub(crate) fn joined(group: &str, name: &str) -> String {
    if group.is_empty() { name.into() } else { format!("{group}.{name}") }
}

/// The arrays of a file, and the names of what is not read.
#[derive(Debug, Default)]
pub(crate) struct Arrays {
    pub arrays: Vec<Array>,
    pub texts: Vec<TextArray>,
    /// Structure, name and text of every text that is alone.
    pub names: Vec<(String, String, String)>,
    /// Full name and reason.
    pub left_out: Vec<(String, String)>,
    /// Structure and what there is to note about it.
    pub notes: Vec<(String, String)>,
}

impl Arrays {
    /// Keeps the name of something that is not read.
    pub fn leave_out(&mut self, name: impl Into<String>, reason: impl Into<String>) {
        self.left_out.push((name.into(), reason.into()));
    }

    /// The datasets of `file` that are wanted.
    ///
    /// # Errors
    /// There is no array of two numbers or more.
    pub fn into_datasets(mut self, file: &str, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
        self.read_texts();
        self.name_structures();
        self.find_times();
        let (mut parts, scalars) = self.parts();
        let main = parts.main();
        parts.lend_times();
        let intervals = self.intervals(&parts, &main, scalars);
        let mut left_out = self.left_out_by_place(&main);
        if parts.all.is_empty() {
            let mut found = String::from("no array of two numbers or more is in the file");
            if let Some(note) = note(&left_out.remove(&0).unwrap_or_default()) {
                found = format!("{found}; {note}");
            }
            return Err(bytes::bad(file, "the whole file", found, "save the channels as numeric arrays of one length"));
        }
        let mut datasets = Vec::new();
        for (place, part) in parts.all.into_iter().enumerate() {
            let mut notes = Vec::new();
            let mut axis = part.times.map_or(Axis::Unknown, Axis::Time);
            if let Some(lender) = &part.lender {
                notes.push(format!("the times are those of `{lender}`"));
            }
            if let Some((interval_s, name)) = intervals.get(&place) {
                axis = Axis::Uniform { start_s: 0.0, interval_s: *interval_s };
                notes.push(format!(
                    "times are counted from 0 s with the interval of {interval_s} s that `{name}` states"
                ));
            }
            notes.extend(note(&left_out.remove(&place).unwrap_or_default()));
            let is_main = main.get(&part.group) == Some(&place);
            if is_main {
                notes.extend(self.notes.iter().filter(|(group, _)| *group == part.group).map(|(_, note)| note.clone()));
            }
            let of_length = format!("length_{}", part.rows);
            let name = if is_main { part.group } else { joined(&part.group, &of_length) };
            datasets.push(RawDataset { name, columns: part.columns, axis, notes });
        }
        datasets.retain(|dataset| wanted(&dataset.name));
        Ok(datasets)
    }

    /// The arrays by group and length, in the order of the file; scalars apart.
    fn parts(&mut self) -> (Parts, Vec<Array>) {
        let mut parts = Parts::default();
        let mut scalars = Vec::new();
        for array in std::mem::take(&mut self.arrays) {
            if array.is_scalar() {
                scalars.push(array);
                continue;
            }
            let reason = match array.rows_and_columns() {
                _ if array.values.is_empty() => "empty".to_string(),
                None => format!("{} dimensions", array.shape.len()),
                Some((rows, columns)) if columns > MATRIX_COLUMNS_MAX => format!("a matrix of {rows} x {columns}"),
                Some((rows, columns)) if rows.checked_mul(columns) != Some(array.values.len()) => {
                    format!("{} numbers for {rows} x {columns}", array.values.len())
                }
                Some((rows, columns)) => {
                    parts.add(array, rows, columns);
                    continue;
                }
            };
            self.leave_out(array.full_name(), reason);
        }
        (parts, scalars)
    }

    /// Intervals \[s\] by place of the part, with the name of the scalar that states them; other
    /// scalars are left out.
    fn intervals(
        &mut self,
        parts: &Parts,
        main: &BTreeMap<String, usize>,
        scalars: Vec<Array>,
    ) -> BTreeMap<usize, (f64, String)> {
        let mut stated: BTreeMap<&str, (f64, String)> = BTreeMap::new();
        for scalar in &scalars {
            if let Some(interval_s) = interval(scalar) {
                stated.entry(&scalar.group).or_insert_with(|| (interval_s, scalar.full_name()));
            }
        }
        let mut used = BTreeMap::new();
        for (group, place) in main {
            let found = ancestors(group).find_map(|group| stated.get(group));
            if let Some(found) = found.filter(|_| !parts.all[*place].has_axis()) {
                used.insert(*place, found.clone());
            }
        }
        let names: BTreeSet<String> = used.values().map(|(_, name)| name.clone()).collect();
        for scalar in scalars.iter().map(Array::full_name).filter(|name| !names.contains(name)) {
            self.leave_out(scalar, "one number");
        }
        used
    }

    /// What was left out of a structure with a dataset goes to that dataset, the rest to the first.
    fn left_out_by_place(&self, main: &BTreeMap<String, usize>) -> BTreeMap<usize, Vec<&(String, String)>> {
        let mut places: BTreeMap<usize, Vec<&(String, String)>> = BTreeMap::new();
        for left_out in &self.left_out {
            let group = left_out.0.rsplit_once('.').map_or("", |(group, _)| group);
            places.entry(main.get(group).copied().unwrap_or(0)).or_default().push(left_out);
        }
        places
    }
}

fn note(left_out: &[&(String, String)]) -> Option<String> {
    const ARRAYS_NAMED_MAX: usize = 40;
    let named = left_out.iter().take(ARRAYS_NAMED_MAX).map(|(name, reason)| format!("`{name}` ({reason})"));
    let mut text = named.collect::<Vec<_>>().join(", ");
    if left_out.len() > ARRAYS_NAMED_MAX {
        text = format!("{text} and {} more", left_out.len() - ARRAYS_NAMED_MAX);
    }
    (!text.is_empty()).then(|| format!("left out: {text}"))
}

/// Whether a scalar with this name may state the interval of the rows.
pub(crate) fn is_rate_or_interval(name: &str) -> bool {
    states_rate(name) || states_interval(name)
}

fn states_rate(name: &str) -> bool {
    RATES.contains(&plain(name).as_str())
}

/// `ts` in small letters is a time stamp.
fn states_interval(name: &str) -> bool {
    name == "Ts" || INTERVALS.contains(&plain(name).as_str())
}

fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// The interval that a scalar states \[s\].
fn interval(scalar: &Array) -> Option<f64> {
    let value = *scalar.values.first()?;
    let interval_s = if states_rate(&scalar.name) {
        1.0 / value
    } else if states_interval(&scalar.name) {
        value
    } else {
        return None;
    };
    (interval_s.is_finite() && interval_s > 0.0).then_some(interval_s)
}

#[cfg(test)]
mod tests;
