//! Texts beside arrays: names of the columns of a matrix, units, dates.

use crate::arrays::{Array, Arrays, joined};
use crate::conventions::is_unit;
use crate::texts::{Found, Texts};
use std::collections::BTreeSet;

/// An array of texts of a file.
#[derive(Debug, Default)]
pub(crate) struct TextArray {
    /// As of an [`Array`].
    pub group: String,
    pub name: String,
    pub texts: Texts,
}

impl Arrays {
    /// Names columns and states units by the texts beside them; texts that are dates or numbers
    /// become arrays. Other texts are left out.
    pub fn read_texts(&mut self) {
        let mut texts = std::mem::take(&mut self.texts);
        for TextArray { group, name, texts } in &texts {
            if let [text] = &texts.first[..] {
                self.names.push((group.clone(), name.clone(), text.clone()));
            }
        }
        self.arrays.iter_mut().for_each(take_lists);
        texts.retain(|text| !(self.name_columns(text) || self.state_unit(text)));
        for TextArray { group, name, texts } in texts {
            let rows = texts.first.len();
            let (values, rest, is_time) = match texts.finish() {
                Found::Numbers(values) if rows > 1 => (values, Vec::new(), false),
                Found::Dates(values, rest) if rows > 1 => (values, rest, true),
                _ => {
                    self.leave_out(joined(&group, &name), "text");
                    continue;
                }
            };
            let unit = is_time.then(|| "s".to_owned());
            let shape = vec![values.len()];
            self.arrays.push(Array { group, name, unit, shape, is_time, values, rest, ..Array::default() });
        }
    }

    /// Gives the texts to the one matrix beside them that has as many columns.
    fn name_columns(&mut self, list: &TextArray) -> bool {
        let texts = &list.texts.first;
        let is_units = is_unit(&list.name);
        let distinct: BTreeSet<&String> = texts.iter().collect();
        if texts.len() < 2 || !(is_units || distinct.len() == texts.len()) {
            return false;
        }
        let is_theirs = |array: &&mut Array| {
            array.group == list.group && array.columns() == texts.len() && (is_units || array.names.is_empty())
        };
        let mut matrices = self.arrays.iter_mut().filter(is_theirs);
        let (Some(matrix), None) = (matrices.next(), matrices.next()) else { return false };
        if is_units {
            matrix.units.clone_from(texts)
        } else {
            matrix.names.clone_from(texts)
        }
        true
    }

    /// Gives a unit to the array that it is of: the one of its name in the structure around it, or
    /// the only one beside it that holds no times.
    fn state_unit(&mut self, text: &TextArray) -> bool {
        let [unit] = &text.texts.first[..] else { return false };
        let (around, own) = text.group.rsplit_once('.').unwrap_or(("", &text.group));
        if is_unit(own) {
            let named = |array: &&mut Array| array.group == around && array.name == text.name;
            return state(self.arrays.iter_mut().filter(named), unit);
        }
        if !is_unit(&text.name) {
            return false;
        }
        let beside = |array: &&mut Array| {
            array.group == text.group && array.values.len() > 1 && !crate::array_parts::is_axis(&array.name)
        };
        state(self.arrays.iter_mut().filter(beside), unit)
    }
}

/// Names the columns of a matrix by the texts that are kept with it.
fn take_lists(array: &mut Array) {
    let columns = array.columns();
    for (name, texts) in std::mem::take(&mut array.lists).into_iter().filter(|(_, texts)| texts.len() == columns) {
        let distinct: BTreeSet<&String> = texts.iter().collect();
        if is_unit(&name) {
            array.units = texts;
        } else if distinct.len() == columns && array.names.is_empty() {
            array.names = texts;
        }
    }
}

/// States the unit of the one array of `arrays`.
fn state<'a>(mut arrays: impl Iterator<Item = &'a mut Array>, unit: &str) -> bool {
    let (Some(array), None) = (arrays.next(), arrays.next()) else { return false };
    array.unit.get_or_insert_with(|| unit.to_owned());
    true
}
