//! The elements of one list of a file of JSON: numbers, texts that are numbers or dates, rows of
//! them, objects.

use super::json::{Node, Units};
use super::json_file::{Found, Place};
use super::rows::Rows;
use crate::array_texts::TextArray;
use crate::arrays::{Array, joined};
use crate::intake::origin::split;
use crate::text::stamps::Form;
use crate::texts::{Cell, Texts, cell, seconds_of};
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

/// Columns of which is known what they are.
const UNNAMED_MAX: usize = 64;
const NUMBER: u8 = 1;
const DATE: u8 = 2;
const TEXT: u8 = 4;

/// The elements of a list so far.
#[derive(Default)]
pub(super) struct List {
    /// Numbers, those of inner lists one after another.
    values: Vec<f64>,
    /// What they do not hold; empty: nothing.
    rest: Vec<f64>,
    /// Elements of every inner list; `None` where they differ.
    width: Option<usize>,
    /// Kinds of value at each place of an inner list.
    kinds: Vec<u8>,
    form: Option<Form>,
    /// The texts of a list of nothing else.
    texts: Texts,
    /// Rows, where the elements are objects.
    rows: Option<Rows>,
    /// The objects are structures.
    structures: bool,
    /// Keys of the elements, where they have some.
    pub keys: Texts,
    pub count: usize,
    scalars: usize,
    lists: usize,
}

/// Whether a column is no column of numbers, or of dates.
fn is_text(kind: u8) -> bool {
    kind & TEXT > 0 || kind.count_ones() > 1
}

impl List {
    /// A number at the place `column` of an inner list, or of the list itself.
    fn number(&mut self, column: usize, value: f64, rest: f64, kind: u8) {
        if rest != 0.0 {
            self.rest.resize(self.values.len(), 0.0);
            self.rest.push(rest);
        } else if !self.rest.is_empty() {
            self.rest.push(0.0);
        }
        self.values.push(value);
        if column < UNNAMED_MAX {
            self.kinds.resize(self.kinds.len().max(column + 1), 0);
            self.kinds[column] |= kind;
        }
    }

    fn text(&mut self, column: usize, text: &str) {
        match cell(text, &mut self.form) {
            Cell::Number(value) => self.number(column, value, 0.0, NUMBER),
            Cell::Date(ns) => {
                let (seconds, rest) = seconds_of(ns.into());
                self.number(column, seconds, rest, DATE);
            }
            Cell::Missing => self.number(column, f64::NAN, 0.0, 0),
            Cell::Text => self.number(column, f64::NAN, 0.0, TEXT),
        }
    }

    /// Puts what the list is where `path` is.
    pub fn end(mut self, path: String, found: &mut Found) {
        if let Some(rows) = self.rows {
            found.tables.push((path, rows));
            return;
        }
        if self.structures && self.objects() == self.count {
            return;
        }
        let (group, name) = path.rsplit_once('.').unwrap_or(("", &path));
        let (group, name) = (group.to_owned(), if name.is_empty() { "array" } else { name }.to_owned());
        let is_text = self.kinds.first().is_some_and(|kind| kind & TEXT > 0);
        if self.scalars == self.count && is_text && self.texts.count() == self.count {
            found.arrays.texts.push(TextArray { group, name, texts: self.texts });
        } else if let Some(width) = self.even_width() {
            self.add_index(&group, &name, found);
            found.arrays.arrays.push(self.into_array(group, name, width));
        } else {
            found.arrays.leave_out(joined(&group, &name), "no array of numbers");
        }
    }

    fn objects(&self) -> usize {
        self.count - self.scalars - self.lists
    }

    /// Numbers of every row; `None` where the elements are no rows of numbers.
    fn even_width(&self) -> Option<usize> {
        let width = if self.lists > 0 { self.width? } else { 1 };
        let is_one_kind = self.objects() == 0 && (self.lists == 0 || self.scalars == 0);
        // an inner list for each column: a value in one place says nothing of it
        let lies = self.lists > 0 && self.count < width && self.kinds.iter().any(|kind| *kind > NUMBER);
        let has_column = self.kinds.iter().any(|kind| !is_text(*kind)) || width > self.kinds.len();
        (is_one_kind && width > 0 && self.count > 0 && !lies && has_column).then_some(width)
    }

    fn into_array(self, group: String, name: String, width: usize) -> Array {
        let places = |wanted: fn(u8) -> bool| -> Vec<usize> {
            self.kinds.iter().enumerate().filter(|(_, kind)| wanted(**kind)).map(|(at, _)| at).collect()
        };
        let times = places(|kind| kind == DATE).first().copied();
        let texts = places(is_text);
        let is_time = width == 1 && times.is_some();
        let unit = is_time.then(|| "s".to_owned());
        let shape = vec![self.count, width];
        let (values, rest) = (self.values, self.rest);
        Array { group, name, unit, shape, times, texts, is_time, values, rest, ..Array::default() }
    }

    /// Adds the keys of the elements beside them, once for all lists of one structure.
    fn add_index(&mut self, group: &str, name: &str, found: &mut Found) {
        let keys = std::mem::take(&mut self.keys);
        if keys.count() != self.count || self.count < 2 {
            return;
        }
        let (values, rest, is_time) = match keys.finish() {
            crate::texts::Found::Numbers(values) => (values, Vec::new(), false),
            crate::texts::Found::Dates(values, rest) => (values, rest, true),
            crate::texts::Found::Text => return,
        };
        if values.iter().enumerate().all(|(k, value)| *value == k as f64) {
            return;
        }
        let is_index = |array: &&Array| array.group == group && array.name == "index";
        if let Some(index) = found.arrays.arrays.iter().find(is_index) {
            if index.values != values {
                let note =
                    format!("the rows of `{}` have other keys than those of the column before it", joined(group, name));
                found.arrays.notes.push((group.to_owned(), note));
            }
            return;
        }
        let unit = is_time.then(|| "s".to_owned());
        let (group, name, shape) = (group.to_owned(), "index".to_owned(), vec![values.len()]);
        found.arrays.arrays.push(Array { group, name, unit, shape, is_time, values, rest, ..Array::default() });
    }
}

/// The next element of a list, called `path` where it is a structure.
pub(super) struct Element<'l, 'f> {
    pub list: &'l mut List,
    pub found: &'f mut Found,
    pub path: &'l str,
    /// Its key, where it has one.
    pub key: Option<&'l str>,
}

impl<'de> DeserializeSeed<'de> for Element<'_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        if let Some(key) = self.key {
            self.list.keys.push(key);
        }
        deserializer.deserialize_any(self)
    }
}

impl Element<'_, '_> {
    fn scalar(self, value: f64, rest: f64, kind: u8) {
        self.list.scalars += 1;
        self.list.count += 1;
        self.list.number(0, value, rest, kind);
    }
}

impl<'de> Visitor<'de> for Element<'_, '_> {
    type Value = ();

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("JSON")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<(), A::Error> {
        let row = self.list.count;
        self.list.count += 1;
        if self.list.rows.is_none() && !self.list.structures {
            self.list.structures = self.found.next_holds_structures();
        }
        if self.list.structures {
            let path = match self.key {
                Some(key) => joined(self.path, key),
                None => format!("{}[{row}]", self.path),
            };
            return Place { found: self.found, path }.visit_map(map);
        }
        let rows = self.list.rows.get_or_insert_with(Rows::with_stamps_in_text);
        if let Some(key) = self.key.filter(|key| key.parse::<usize>() != Ok(row)) {
            index(rows, key);
        }
        Node(rows, &Units::new()).visit_map(map)?;
        rows.commit(row as u64);
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<(), A::Error> {
        let mut width = 0;
        while elements.next_element_seed(Inner { list: &mut *self.list, column: width })?.is_some() {
            width += 1;
        }
        let first = self.list.lists == 0;
        self.list.width = if first { Some(width) } else { self.list.width.filter(|before| *before == width) };
        self.list.lists += 1;
        self.list.count += 1;
        Ok(())
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<(), E> {
        self.scalar(value, 0.0, NUMBER);
        Ok(())
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<(), E> {
        let (value, rest) = split(value.into());
        self.scalar(value, rest, NUMBER);
        Ok(())
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<(), E> {
        let (value, rest) = split(value.into());
        self.scalar(value, rest, NUMBER);
        Ok(())
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<(), E> {
        self.scalar(f64::from(u8::from(value)), 0.0, NUMBER);
        Ok(())
    }

    /// `null`: no sample.
    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.scalar(f64::NAN, 0.0, 0);
        Ok(())
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<(), E> {
        self.list.scalars += 1;
        self.list.count += 1;
        self.list.texts.push(text);
        self.list.text(0, text);
        Ok(())
    }
}

/// The key of a row as a column of it, or as its time.
fn index(rows: &mut Rows, key: &str) {
    match cell(key, &mut None) {
        Cell::Number(value) => {
            let mark = rows.enter(if value > 1e9 { "timestamp" } else { "index" });
            rows.number(value, None);
            rows.leave(mark);
        }
        Cell::Date(ns) => rows.stamp("index", ns.unsigned_abs()),
        Cell::Missing | Cell::Text => {}
    }
}

/// An element of an inner list.
struct Inner<'l> {
    list: &'l mut List,
    column: usize,
}

impl<'de> DeserializeSeed<'de> for Inner<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Inner<'_> {
    type Value = ();

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("JSON")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        self.list.number(self.column, f64::NAN, 0.0, TEXT);
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<(), A::Error> {
        while elements.next_element::<IgnoredAny>()?.is_some() {}
        self.list.number(self.column, f64::NAN, 0.0, TEXT);
        Ok(())
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<(), E> {
        self.list.number(self.column, value, 0.0, NUMBER);
        Ok(())
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<(), E> {
        let (value, rest) = split(value.into());
        self.list.number(self.column, value, rest, NUMBER);
        Ok(())
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<(), E> {
        let (value, rest) = split(value.into());
        self.list.number(self.column, value, rest, NUMBER);
        Ok(())
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<(), E> {
        self.visit_f64(f64::from(u8::from(value)))
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.list.number(self.column, f64::NAN, 0.0, 0);
        Ok(())
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<(), E> {
        self.list.text(self.column, text);
        Ok(())
    }
}
