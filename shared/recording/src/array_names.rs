//! Structures of a list that state their names, and arrays that are times without saying so.

use crate::arrays::{Array, Arrays};
use std::collections::BTreeMap;

/// Keys that name a structure, the surer ones first.
const NAMES: [&str; 9] = ["name", "__name__", "label", "target", "channel", "signal", "sensor", "topic", "title"];
/// Seconds between 2001 and 2128.
const SINCE_1970_S: core::ops::Range<f64> = 1e9..5e9;

impl Arrays {
    /// Gives structures of lists (`run[0]`) the names that texts in them state, where no two are
    /// the same. An array that is alone in such a structure is the channel of that name.
    pub fn name_structures(&mut self) {
        let mut names: BTreeMap<String, (usize, String)> = BTreeMap::new();
        for (group, key, text) in &self.names {
            let Some(rank) = NAMES.iter().position(|name| key.eq_ignore_ascii_case(name)) else { continue };
            let Some(structure) = structure_around(group) else { continue };
            let better = names.get(structure).is_none_or(|(before, _)| rank < *before);
            if better && !text.trim().is_empty() {
                names.insert(structure.to_owned(), (rank, text.trim().to_owned()));
            }
        }
        let count = |text: &String| names.values().filter(|(_, other)| other == text).count();
        let distinct = names.iter().filter(|(_, (_, text))| count(text) == 1);
        let distinct: Vec<(String, String)> =
            distinct.map(|(group, (_, text))| (group.clone(), text.clone())).collect();
        for (group, name) in distinct {
            self.rename(&group, &name);
        }
    }

    fn rename(&mut self, structure: &str, name: &str) {
        let mut own: Vec<&mut Array> =
            self.arrays.iter_mut().filter(|array| array.group == structure && array.values.len() > 1).collect();
        if let [only] = &mut own[..]
            && only.columns() == 1
        {
            let list = structure.rsplit_once('[').map_or(structure, |(list, _)| list);
            only.group = list.rsplit_once('.').map_or("", |(around, _)| around).to_owned();
            only.name = name.to_owned();
            return;
        }
        for array in self.arrays.iter_mut().filter(|array| array.group == structure) {
            array.group = name.to_owned();
        }
        for (group, _) in self.notes.iter_mut().filter(|(group, _)| group == structure) {
            *group = name.to_owned();
        }
    }

    /// Finds the times of pairs without names, and of the keys by which rows are counted.
    pub fn find_times(&mut self) {
        for array in &mut self.arrays {
            if array.columns() == 2 && array.names.is_empty() {
                self.notes.extend(name_pairs(array).map(|note| (array.group.clone(), note)));
            } else if array.columns() == 1 && array.name == "index" && is_since_1970(&array.values) {
                array.name = "timestamp".into();
            }
        }
    }
}

/// Names the columns of pairs of which one is a clock that counts from 1970; gives what there is to
/// note.
fn name_pairs(array: &mut Array) -> Option<String> {
    if array.shape.first().is_none_or(|rows| *rows < array.values.len() / 2) || array.column_major {
        return None;
    }
    let column = |of: usize| array.values.iter().skip(of).step_by(2).copied().collect::<Vec<f64>>();
    let clocks: Vec<usize> = (0..2)
        .filter(|of| array.times == Some(*of) || (array.times.is_none() && is_since_1970(&column(*of))))
        .collect();
    let [clock] = clocks[..] else { return None };
    let mut names = vec!["value".to_owned(); 2];
    names[clock] = "time".into();
    array.names = names;
    Some(format!("`{}[{clock}]` is taken for the times: its numbers rise, and count from 1970", array.name))
}

/// Whether numbers rise and lie where seconds, or thousandths and less of them, since 1970 do.
fn is_since_1970(values: &[f64]) -> bool {
    let lies = |per_s: f64| values.iter().all(|value| SINCE_1970_S.contains(&(value / per_s)));
    values.len() > 1 && values.is_sorted_by(|a, b| a < b) && [1.0, 1e3, 1e6, 1e9].into_iter().any(lies)
}

/// The innermost structure of a list around, at most one structure away.
fn structure_around(group: &str) -> Option<&str> {
    if group.ends_with(']') {
        return Some(group);
    }
    group.rsplit_once('.').map(|(around, _)| around).filter(|around| around.ends_with(']'))
}
