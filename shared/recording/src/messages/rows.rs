//! Rows of one topic, message by message: numbers by name, arrays by element, times in nanoseconds.
//!
//! A column keeps its values and where they stand; gaps cost nothing until the dataset is made.
//! A message that is not read to its end leaves nothing behind.

use super::left_out::{LeftOut, Reason};
use crate::dataset::{Axis, RawColumn, RawDataset};
use crate::intake::clock;
use crate::intake::origin::{if_any, rest_of_seconds};
use crate::text::stamps::{Form, Stamp};
use std::collections::{HashMap, HashSet};

/// Nanoseconds in a second, for stamps.
pub(crate) const STAMPS_NS: u64 = 1_000_000_000;
/// Elements of an array that become columns.
pub(crate) const ELEMENTS_MAX: usize = 64;
const MESSAGE_COLUMNS_MAX: usize = 1024;
const PATH_MAX: usize = 512;
/// Cells of a dataset for every value that the messages hold.
const CELLS_PER_VALUE: usize = 8;

struct Column {
    name: String,
    unit: Option<&'static str>,
    values: Vec<f64>,
    /// First row and first value of every run of rows without a gap.
    runs: Vec<(usize, usize)>,
    next_row: usize,
    /// The arrays this column is an element of.
    arrays: Vec<usize>,
}

impl Column {
    fn push(&mut self, row: usize, value: f64) {
        // A second value of one field in one message.
        if row < self.next_row {
            return;
        }
        if row > self.next_row || self.runs.is_empty() {
            self.runs.push((row, self.values.len()));
        }
        self.values.push(value);
        self.next_row = row + 1;
    }

    fn dense(&self, rows: usize) -> Vec<f64> {
        let mut dense = vec![f64::NAN; rows];
        for (i, (row, from)) in self.runs.iter().enumerate() {
            let to = self.runs.get(i + 1).map_or(self.values.len(), |next| next.1);
            let run = &self.values[*from..to];
            dense[*row..row + run.len()].copy_from_slice(run);
        }
        dense
    }
}

struct Array {
    path: String,
    length: Option<usize>,
    varies: bool,
}

impl Array {
    fn reason(&self) -> Option<Reason> {
        match self.length {
            _ if self.varies => Some(Reason::VaryingArray),
            Some(length) if length > ELEMENTS_MAX => Some(Reason::LongArray),
            _ => None,
        }
    }
}

/// The rows of a topic.
#[derive(Default)]
pub(crate) struct Rows {
    columns: Vec<Column>,
    by_name: HashMap<String, usize>,
    arrays: Vec<Array>,
    array_by_path: HashMap<String, usize>,
    left_out: LeftOut,
    logged_ns: Vec<u64>,
    stamps_ns: Vec<Option<u64>>,
    stamp_name: String,
    unread: u64,
    first_unread: String,
    path: String,
    open_arrays: Vec<usize>,
    /// Where the next number is expected, as in the message before.
    cursor: usize,
    row: Vec<(usize, f64)>,
    row_arrays: Vec<(usize, usize)>,
    row_stamp: Option<u64>,
    /// A text with a date and a time states the time of its row.
    stamps_in_text: bool,
    /// Columns with numbers that were texts.
    of_texts: HashSet<usize>,
}

impl Rows {
    /// Rows whose times may be texts.
    pub fn with_stamps_in_text() -> Self {
        Rows { stamps_in_text: true, ..Rows::default() }
    }

    /// Takes the text at the current place for the time of the row, if it is a date and a time and
    /// the field is called as a clock is.
    pub fn stamp_in_text(&mut self, text: &str) -> bool {
        if !self.stamps_in_text || clock::rank(self.path.rsplit('.').next().unwrap_or_default()).is_none() {
            return false;
        }
        let form = Form::of([text].into_iter()).filter(|form| matches!(form, Form::DateTime(_)));
        let Some(ns) = form.and_then(|form| form.read(text)).and_then(Stamp::since_1970_ns) else { return false };
        let name = self.path.clone();
        self.stamp(&name, ns);
        true
    }

    /// Goes into the field `name`; gives what [`Rows::leave`] needs.
    pub fn enter(&mut self, name: &str) -> usize {
        let mark = self.path.len();
        if mark > 0 {
            self.path.push('.');
        }
        self.path.push_str(name);
        mark
    }

    /// Goes into an element of an array.
    pub fn enter_element(&mut self, index: usize) -> usize {
        let mark = self.path.len();
        self.path.push_str(&format!("[{index}]"));
        mark
    }

    /// Goes back to where `mark` was given.
    pub fn leave(&mut self, mark: usize) {
        self.path.truncate(mark);
    }

    /// The number at the current place.
    pub fn number(&mut self, value: f64, unit: Option<&'static str>) {
        self.number_in(value, |_| unit);
    }

    /// The number at the current place, in the unit that `unit` gives for its name.
    pub fn number_in(&mut self, value: f64, unit: impl Fn(&str) -> Option<&'static str>) {
        let expected = self.columns.get(self.cursor).is_some_and(|column| column.name == self.path);
        let index = match (expected, self.by_name.get(&self.path)) {
            (true, _) => self.cursor,
            (false, Some(index)) => *index,
            (false, None) if self.columns.len() < MESSAGE_COLUMNS_MAX && self.path.len() <= PATH_MAX => {
                self.add_column(unit(&self.path))
            }
            (false, None) => return self.left_out.add(Reason::Excess, &self.path),
        };
        self.cursor = index + 1;
        self.row.push((index, value));
    }

    /// As [`Rows::number_in`], of a text that is a number.
    pub fn number_of_text(&mut self, value: f64, unit: impl Fn(&str) -> Option<&'static str>) {
        self.number_in(value, unit);
        let last = self.row.last().map(|(index, _)| *index);
        self.of_texts.extend(last.filter(|index| self.columns[*index].name == self.path));
    }

    fn add_column(&mut self, unit: Option<&'static str>) -> usize {
        let index = self.columns.len();
        self.by_name.insert(self.path.clone(), index);
        self.columns.push(Column {
            name: self.path.clone(),
            unit,
            values: Vec::new(),
            runs: Vec::new(),
            next_row: 0,
            arrays: self.open_arrays.clone(),
        });
        index
    }

    /// Opens the array at the current place; `false` when its elements give no columns.
    pub fn open_array(&mut self) -> bool {
        let known = match self.array_by_path.get(&self.path) {
            Some(index) => *index,
            None if self.arrays.len() < MESSAGE_COLUMNS_MAX && self.path.len() <= PATH_MAX => {
                self.array_by_path.insert(self.path.clone(), self.arrays.len());
                self.arrays.push(Array { path: self.path.clone(), length: None, varies: false });
                self.arrays.len() - 1
            }
            None => {
                self.left_out.add(Reason::Excess, &self.path);
                return false;
            }
        };
        if self.arrays[known].reason().is_some() {
            return false;
        }
        self.open_arrays.push(known);
        true
    }

    /// Closes the array that was opened, of `length` elements.
    pub fn close_array(&mut self, length: usize) {
        if let Some(array) = self.open_arrays.pop() {
            self.row_arrays.push((array, length));
        }
    }

    /// Names the field at the current place as left out.
    pub fn leave_out(&mut self, reason: Reason) {
        self.left_out.add(reason, &self.path);
    }

    /// The time that the message itself states.
    pub fn stamp(&mut self, name: &str, stamp_ns: u64) {
        if self.stamp_name != name {
            self.stamp_name = name.into();
        }
        self.row_stamp = Some(stamp_ns);
    }

    /// Ends a message that was read, logged at `logged_ns`.
    pub fn commit(&mut self, logged_ns: u64) {
        let row = self.logged_ns.len();
        for (column, value) in self.row.drain(..) {
            self.columns[column].push(row, value);
        }
        for (array, length) in self.row_arrays.drain(..) {
            let array = &mut self.arrays[array];
            array.varies |= *array.length.get_or_insert(length) != length;
        }
        self.logged_ns.push(logged_ns);
        self.stamps_ns.push(self.row_stamp);
        self.begin();
    }

    /// Ends a message that was not read.
    pub fn reject(&mut self, reason: String) {
        if self.unread == 0 {
            self.first_unread = reason;
        }
        self.unread += 1;
        self.begin();
    }

    fn begin(&mut self) {
        self.path.clear();
        self.open_arrays.clear();
        self.row.clear();
        self.row_arrays.clear();
        self.row_stamp = None;
        self.cursor = 0;
    }

    /// Whether no message was seen at all.
    pub fn is_empty(&self) -> bool {
        self.logged_ns.is_empty() && self.unread == 0
    }

    /// Rows in the order of time, named columns, and notes on what is missing.
    pub fn into_dataset(mut self, name: String) -> RawDataset {
        let count = self.logged_ns.len();
        let order = self.order();
        let mut notes = Vec::new();
        let time = self.time(order.as_deref(), &mut notes);
        let kept = self.kept_columns(count);
        let mut columns = vec![time];
        for column in kept.into_iter().map(|index| &self.columns[index]) {
            let dense = column.dense(count);
            let values = match &order {
                Some(order) => order.iter().map(|row| dense[*row]).collect(),
                None => dense,
            };
            let (name, unit) = (column.name.clone(), column.unit.map(String::from));
            columns.push(RawColumn { name, unit, values, rest: Vec::new() });
        }
        notes.extend(self.left_out.note());
        if self.unread > 0 {
            notes.push(format!("{} messages are not read; the first: {}", self.unread, self.first_unread));
        }
        RawDataset { name, columns, axis: Axis::Time(0), notes }
    }

    /// Rows in the order in which they were committed; their times are those that they state, if
    /// any.
    pub fn into_table(self, name: String) -> RawDataset {
        let stated = !self.stamp_name.is_empty() && self.stamps_ns.iter().all(Option::is_some);
        let mut dataset = self.into_dataset(name);
        if !stated {
            dataset.columns.remove(0);
            dataset.axis = Axis::Unknown;
        }
        dataset
    }

    /// The rows by time of logging, where they do not lie so.
    fn order(&self) -> Option<Vec<usize>> {
        if self.logged_ns.is_sorted() {
            return None;
        }
        let mut order: Vec<usize> = (0..self.logged_ns.len()).collect();
        order.sort_by_key(|row| self.logged_ns[*row]);
        Some(order)
    }

    fn time(&self, order: Option<&[usize]>, notes: &mut Vec<String>) -> RawColumn {
        let at = |row: usize| order.map_or(row, |order| order[row]);
        let rows = self.logged_ns.len();
        let mut name = self.stamp_name.clone();
        let mut times: Vec<u64> = (0..rows).map_while(|row| self.stamps_ns[at(row)].filter(|ns| *ns > 0)).collect();
        let reason = if times.len() < rows {
            Some("missing or 0")
        } else {
            (!times.is_sorted_by(|a, b| a < b)).then_some("not increasing")
        };
        if let Some(reason) = reason {
            if !name.is_empty() {
                notes.push(format!("time is the time of logging: `{name}` is {reason} in some messages"));
            }
            name = "log_time".into();
            times = (0..rows).map(|row| self.logged_ns[at(row)]).collect();
        } else if name.is_empty() {
            name = "log_time".into();
        }
        while self.by_name.contains_key(&name) {
            name.push('_');
        }
        let values: Vec<f64> = times.iter().map(|ns| seconds(*ns)).collect();
        let rest = |(seconds, ns): (&f64, &u64)| rest_of_seconds(*seconds, i128::from(*ns), i128::from(STAMPS_NS));
        let rest = if_any(values.iter().zip(&times).map(rest).collect());
        RawColumn { name, unit: Some("s".into()), values, rest }
    }

    /// Columns that become columns of the dataset; the others are named as left out.
    fn kept_columns(&mut self, rows: usize) -> Vec<usize> {
        for array in &self.arrays {
            if let Some(reason) = array.reason() {
                self.left_out.add(reason, &array.path);
            }
        }
        let in_array = |column: &Column| column.arrays.iter().any(|array| self.arrays[*array].reason().is_some());
        // a field of texts of which some are numbers
        let is_text = |index: &usize| {
            self.of_texts.contains(index) && self.left_out.has(Reason::Text, &self.columns[*index].name)
        };
        let mut kept: Vec<usize> = (0..self.columns.len())
            .filter(|index| !self.columns[*index].values.is_empty() && !in_array(&self.columns[*index]))
            .filter(|index| !is_text(index))
            .collect();
        let mut values: usize = kept.iter().map(|index| self.columns[*index].values.len()).sum();
        let mut by_values = kept.clone();
        by_values.sort_by_key(|index| self.columns[*index].values.len());
        for index in by_values {
            if kept.len().saturating_mul(rows) <= values.saturating_mul(CELLS_PER_VALUE) {
                break;
            }
            values -= self.columns[index].values.len();
            kept.retain(|other| *other != index);
            self.left_out.add(Reason::Sparse, &self.columns[index].name);
        }
        kept
    }
}

/// Whole seconds and the rest are exact; their sum is rounded once.
pub(crate) fn seconds(ns: u64) -> f64 {
    (ns / STAMPS_NS) as f64 + (ns % STAMPS_NS) as f64 / STAMPS_NS as f64
}
