//! Files of JSON: an object on each line, an array of objects, arrays of numbers by name, nested.
//!
//! Read without a tree in memory. Objects of one array are the rows of a dataset, called as the
//! array is; arrays of numbers are those of [`crate::arrays`]. A text that is a date and a time
//! gives the time of its row, where its name is one of a clock.

use super::json::{Node, Units, decode};
use super::rows::Rows;
use crate::arrays::{Array, Arrays};
use crate::bytes;
use crate::dataset::{RawDataset, Wanted};
use crate::error::RecordingError;
use crate::file_name;
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::path::Path;

/// First bytes of a file that holds objects.
pub(crate) const BEGINNINGS: &[&[u8]] = &[b"{\"", b"{ \"", b"{\n", b"{\r\n", b"[{", b"[ {", b"[\n", b"[\r\n", b"[["];

/// The wanted datasets of a file.
///
/// # Errors
/// The device's; text that is no JSON, with its line and column; no numbers.
pub fn datasets(path: &Path, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    let (file, content) = (file_name(path), bytes::whole(path)?);
    let first = content.split(|byte| *byte == b'\n').find(|line| !line.trim_ascii().is_empty()).unwrap_or(&content);
    let line_is_object = first.trim_ascii().starts_with(b"{") && serde_json::from_slice::<IgnoredAny>(first).is_ok();
    if line_is_object && first.len() < content.trim_ascii().len() {
        return Ok(lines(&content).into_iter().filter(|dataset| wanted(&dataset.name)).collect());
    }
    let mut found = Found::default();
    let mut text = serde_json::Deserializer::from_slice(&content);
    let read = Place { found: &mut found, path: String::new() }.deserialize(&mut text).and_then(|()| text.end());
    read.map_err(|error| {
        let place = format!("line {}, column {}", error.line(), error.column());
        bytes::bad(&file, place, error.to_string(), bytes::COPY)
    })?;
    let mut all: Vec<RawDataset> = found.tables.into_iter().map(|(name, rows)| rows.into_table(name)).collect();
    let has_array = found.arrays.arrays.iter().any(|array| array.values.len() > 1);
    if all.is_empty() || has_array {
        all.extend(found.arrays.into_datasets(&file, &|_| true)?);
    }
    all.retain(|dataset| wanted(&dataset.name));
    Ok(all)
}

/// One row a line.
fn lines(content: &[u8]) -> Vec<RawDataset> {
    let mut rows = Rows::with_stamps_in_text();
    for (k, line) in content.split(|byte| *byte == b'\n').enumerate().filter(|(_, line)| !line.trim_ascii().is_empty())
    {
        match decode(&Units::new(), line, &mut rows) {
            Ok(()) => rows.commit(k as u64),
            Err(error) => rows.reject(format!("line {}: {error}", k + 1)),
        }
    }
    vec![rows.into_table(String::new())]
}

/// What a file holds.
#[derive(Default)]
struct Found {
    arrays: Arrays,
    /// Arrays of objects by their path.
    tables: Vec<(String, Rows)>,
}

impl Found {
    fn add(&mut self, path: &str, shape: Vec<usize>, values: Vec<f64>) {
        let (group, name) = path.rsplit_once('.').unwrap_or(("", path));
        let name = if name.is_empty() { "array" } else { name };
        self.arrays.arrays.push(Array { group: group.into(), name: name.into(), shape, values, ..Array::default() });
    }
}

/// A value somewhere in the file.
struct Place<'f> {
    found: &'f mut Found,
    /// Names with points between.
    path: String,
}

impl<'de> DeserializeSeed<'de> for Place<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Place<'_> {
    type Value = ();

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("JSON")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            let path = crate::arrays::joined(&self.path, &key);
            map.next_value_seed(Place { found: self.found, path })?;
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<(), A::Error> {
        let mut list = List::default();
        while elements.next_element_seed(Element(&mut list))?.is_some() {
            list.count += 1;
        }
        let List { numbers, rows, count, others } = list;
        if let Some(rows) = rows {
            self.found.tables.push((self.path, rows));
        } else if others > 0 || count == 0 || !numbers.len().is_multiple_of(count) {
            self.found.arrays.leave_out(self.path, "no array of numbers");
        } else {
            self.found.add(&self.path, vec![count, numbers.len() / count], numbers);
        }
        Ok(())
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<(), E> {
        self.found.add(&self.path, Vec::new(), vec![value]);
        Ok(())
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<(), E> {
        self.visit_f64(value as f64)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<(), E> {
        self.visit_f64(value as f64)
    }

    fn visit_bool<E: Error>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E: Error>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        Ok(())
    }
}

/// The elements of an array.
#[derive(Default)]
struct List {
    /// Numbers, those of inner arrays one after another.
    numbers: Vec<f64>,
    /// Rows, where the elements are objects.
    rows: Option<Rows>,
    count: usize,
    /// Elements that are none of these.
    others: usize,
}

struct Element<'l>(&'l mut List);

impl<'de> DeserializeSeed<'de> for Element<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Element<'_> {
    type Value = ();

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("JSON")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<(), A::Error> {
        let row = self.0.count as u64;
        let rows = self.0.rows.get_or_insert_with(Rows::with_stamps_in_text);
        Node(rows, &Units::new()).visit_map(map)?;
        rows.commit(row);
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<(), A::Error> {
        while elements.next_element_seed(Element(self.0))?.is_some() {}
        Ok(())
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<(), E> {
        self.0.numbers.push(value);
        Ok(())
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<(), E> {
        self.visit_f64(value as f64)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<(), E> {
        self.visit_f64(value as f64)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<(), E> {
        self.visit_f64(f64::from(u8::from(value)))
    }

    /// `null`: no sample.
    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.visit_f64(f64::NAN)
    }

    fn visit_str<E: Error>(self, _: &str) -> Result<(), E> {
        self.0.others += 1;
        Ok(())
    }
}
