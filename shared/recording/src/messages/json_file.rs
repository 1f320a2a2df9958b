//! Files of JSON: an object on each line, an array of objects, arrays of numbers by name, nested.
//!
//! Read without a tree in memory. Objects of one array are the rows of a dataset, called as the
//! array is, or structures ([`super::json_survey`]); arrays of numbers are those of
//! [`crate::arrays`]. An object whose keys are numbers or dates is an array that they count. A text
//! that is a number is that number; one that is a date and a time gives the time of its row, where
//! its name is one of a clock.

use super::json::{Units, decode};
use super::json_list::{Element, List};
use super::json_survey::{is_index, structures};
use super::json_tokens::with_nulls;
use super::rows::Rows;
use crate::array_texts::TextArray;
use crate::arrays::{Array, Arrays, joined};
use crate::bytes;
use crate::conventions::is_unit;
use crate::dataset::{RawDataset, Wanted};
use crate::error::RecordingError;
use crate::file_name;
use crate::texts::Texts;
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::borrow::Cow;
use std::path::Path;

/// What some programs write in front of a text.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Whether a file begins as an object does, or an array of objects or arrays.
pub(crate) fn is_json(head: &[u8]) -> bool {
    let text = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head);
    let mut rest = text.trim_ascii_start().iter().filter(|byte| !byte.is_ascii_whitespace());
    match (rest.next(), rest.next()) {
        (Some(b'{'), second) => matches!(second, Some(b'"' | b'}')),
        (Some(b'['), second) => matches!(second, Some(b'{' | b'[')) || text.trim_ascii_start().starts_with(b"[\n"),
        _ => false,
    }
}

/// The wanted datasets of a file.
///
/// # Errors
/// The device's; text that is no JSON, with its line and column; no numbers.
pub fn datasets(path: &Path, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    let (file, content) = (file_name(path), content(path)?);
    let first = content.split(|byte| *byte == b'\n').find(|line| !line.trim_ascii().is_empty()).unwrap_or(&content);
    let line_is_object = first.trim_ascii().starts_with(b"{") && serde_json::from_slice::<IgnoredAny>(first).is_ok();
    if line_is_object && first.len() < content.trim_ascii().len() {
        return Ok(lines(&content).into_iter().filter(|dataset| wanted(&dataset.name)).collect());
    }
    let mut found = found_in(&content).map_err(|error| {
        let place = format!("line {}, column {}", error.line(), error.column());
        bytes::bad(&file, place, error.to_string(), bytes::COPY)
    })?;
    let tables = std::mem::take(&mut found.tables);
    let mut all: Vec<RawDataset> = tables.into_iter().map(|(name, rows)| rows.into_table(name)).collect();
    let has_array = found.arrays.arrays.iter().any(|array| array.values.len() > 1);
    if all.iter().any(|dataset| !dataset.columns.is_empty()) || has_array {
        // lists of objects without numbers describe the others
        all.retain(|dataset| !dataset.columns.is_empty());
    }
    if all.is_empty() || has_array {
        all.extend(found.arrays.into_datasets(&file, &|_| true)?);
    }
    all.retain(|dataset| wanted(&dataset.name));
    Ok(all)
}

/// The text of a file, `null` in place of what is no number.
fn content(path: &Path) -> Result<Vec<u8>, RecordingError> {
    let mut content = bytes::whole(path)?;
    if content.starts_with(BYTE_ORDER_MARK) {
        content.drain(..BYTE_ORDER_MARK.len());
    }
    let replaced = match with_nulls(&content) {
        Cow::Owned(replaced) => Some(replaced),
        Cow::Borrowed(_) => None,
    };
    Ok(replaced.unwrap_or(content))
}

fn found_in(content: &[u8]) -> serde_json::Result<Found> {
    let mut found = Found { structures: structures(content)?.into_iter(), ..Found::default() };
    let mut text = serde_json::Deserializer::from_slice(content);
    Place { found: &mut found, path: String::new() }.deserialize(&mut text)?;
    text.end()?;
    Ok(found)
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
pub(super) struct Found {
    pub arrays: Arrays,
    /// Arrays of objects by their path.
    pub tables: Vec<(String, Rows)>,
    /// Whether the next array of objects holds structures.
    structures: std::vec::IntoIter<bool>,
}

impl Found {
    /// Whether the array of objects that begins here holds structures.
    pub fn next_holds_structures(&mut self) -> bool {
        self.structures.next().unwrap_or(false)
    }

    fn add_text(&mut self, path: &str, text: &str) {
        let (group, name) = path.rsplit_once('.').unwrap_or(("", path));
        let (group, name) = (group.to_owned(), name.to_owned());
        if is_unit(&name) || is_unit(group.rsplit('.').next().unwrap_or_default()) {
            let mut texts = Texts::default();
            texts.push(text);
            self.arrays.texts.push(TextArray { group, name, texts });
        } else {
            self.arrays.names.push((group, name, text.to_owned()));
        }
    }

    fn add(&mut self, path: &str, shape: Vec<usize>, values: Vec<f64>) {
        let (group, name) = path.rsplit_once('.').unwrap_or(("", path));
        let name = if name.is_empty() { "array" } else { name };
        self.arrays.arrays.push(Array { group: group.into(), name: name.into(), shape, values, ..Array::default() });
    }
}

/// A value somewhere in the file.
pub(super) struct Place<'f> {
    pub found: &'f mut Found,
    /// Names with points between.
    pub path: String,
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
        let mut list: Option<List> = None;
        let mut is_first = true;
        while let Some(key) = map.next_key::<String>()? {
            if std::mem::take(&mut is_first) && is_index(&key) {
                list = Some(List::default());
            }
            match &mut list {
                Some(list) => {
                    let (found, path) = (&mut *self.found, &self.path);
                    map.next_value_seed(Element { list, found, path, key: Some(&key) })?;
                }
                None => map.next_value_seed(Place { found: self.found, path: joined(&self.path, &key) })?,
            }
        }
        if let Some(list) = list {
            list.end(self.path, self.found);
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<(), A::Error> {
        let mut list = List::default();
        let path = &self.path;
        while elements.next_element_seed(Element { list: &mut list, found: self.found, path, key: None })?.is_some() {}
        list.end(self.path, self.found);
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

    fn visit_str<E: Error>(self, text: &str) -> Result<(), E> {
        self.found.add_text(&self.path, text);
        Ok(())
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        Ok(())
    }
}
