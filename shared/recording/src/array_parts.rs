//! Arrays of one structure and one length: datasets in the making.

use crate::arrays::{Array, joined};
use crate::dataset::RawColumn;
use std::collections::BTreeMap;

/// Names of arrays that hold times or frequencies, in lower case.
const TIMES: [&str; 13] = [
    "t",
    "time",
    "times",
    "tout",
    "time_s",
    "time_us",
    "time_ms",
    "time_ns",
    "t_s",
    "timestamp",
    "timestamps",
    "time_stamp",
    "seconds",
];
const FREQUENCIES: [&str; 7] = ["f", "freq", "freqs", "frequency", "frequencies", "freq_hz", "f_hz"];

/// Arrays of one structure and one length.
pub(crate) struct Part {
    pub group: String,
    pub rows: usize,
    pub columns: Vec<RawColumn>,
    /// The column that the file says to be times.
    pub times: Option<usize>,
    /// Whose times it has, where it has none itself.
    pub lender: Option<String>,
}

impl Part {
    /// Whether times or frequencies lead the rows.
    pub fn has_axis(&self) -> bool {
        self.times.is_some() || self.columns.iter().any(|column| is_axis(&column.name))
    }

    fn time_column(&self) -> Option<usize> {
        self.times.or_else(|| self.columns.iter().position(|column| is_one_of(&column.name, &TIMES)))
    }
}

/// Whether an array with this name holds times or frequencies.
pub(crate) fn is_axis(name: &str) -> bool {
    is_one_of(name, &TIMES) || is_one_of(name, &FREQUENCIES)
}

fn is_one_of(name: &str, names: &[&str]) -> bool {
    let name = name.to_lowercase();
    names.contains(&name.as_str())
}

/// Parts in the order of the file, and where they are.
#[derive(Default)]
pub(crate) struct Parts {
    pub all: Vec<Part>,
    places: BTreeMap<(String, usize), usize>,
}

impl Parts {
    /// Adds the columns of an array.
    pub fn add(&mut self, array: Array, rows: usize, columns: usize) {
        let place = *self.places.entry((array.group.clone(), rows)).or_insert_with(|| {
            let group = array.group.clone();
            self.all.push(Part { group, rows, columns: Vec::new(), times: None, lender: None });
            self.all.len() - 1
        });
        let part = &mut self.all[place];
        if let Some(times) = array.time_column(columns).filter(|_| part.times.is_none()) {
            part.times = Some(part.columns.len() + times);
        }
        part.columns.extend(array.into_columns(rows, columns));
    }

    /// Place of the main part of every group: the one with times, else with most columns, else the
    /// longest.
    pub fn main(&self) -> BTreeMap<String, usize> {
        let mut main: BTreeMap<String, usize> = BTreeMap::new();
        let weight = |part: &Part| (part.time_column().is_some(), part.columns.len(), part.rows);
        for (place, part) in self.all.iter().enumerate() {
            let best = main.entry(part.group.clone()).or_insert(place);
            if weight(part) > weight(&self.all[*best]) {
                *best = place;
            }
        }
        main
    }

    /// Gives the times of a structure to a structure inside it that has none and has as many rows.
    pub fn lend_times(&mut self) {
        for place in 0..self.all.len() {
            let part = &self.all[place];
            if part.has_axis() {
                continue;
            }
            let lender = ancestors(&part.group).skip(1).find_map(|above| {
                let lender = &self.all[*self.places.get(&(above.to_string(), part.rows))?];
                let times = lender.columns[lender.time_column()?].clone();
                Some((joined(above, &times.name), times, lender.times.is_some()))
            });
            if let Some((name, times, is_time)) = lender {
                let part = &mut self.all[place];
                part.columns.insert(0, times);
                part.times = is_time.then_some(0);
                part.lender = Some(name);
            }
        }
    }
}

/// The group, then every group around it up to the top of the file.
pub(crate) fn ancestors(group: &str) -> impl Iterator<Item = &str> {
    std::iter::successors(Some(group), |group| {
        let group: &str = group;
        (!group.is_empty()).then(|| group.rsplit_once('.').map_or("", |(above, _)| above))
    })
}
