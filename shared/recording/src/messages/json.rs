//! Messages in JSON: numbers and truth values of nested objects and arrays, without a tree in
//! memory.

use super::definition::unit_in_brackets;
use super::json_tokens::with_nulls;
use super::left_out::Reason;
use super::rows::{ELEMENTS_MAX, Rows};
use crate::texts::number;
use crate::units::unit_named;
use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::Value;
use std::collections::HashMap;

/// Bytes of a schema that is searched for units.
const SCHEMA_MAX: usize = 1 << 20;

/// Units by the path of the field, elements of arrays as `[]`.
pub(crate) type Units = HashMap<String, &'static str>;

/// The units that a JSON schema states: a key `unit`, or brackets in a description.
pub(crate) fn units(schema: &[u8]) -> Units {
    let mut units = Units::new();
    if schema.len() <= SCHEMA_MAX
        && let Ok(schema) = serde_json::from_slice(schema)
    {
        property(&schema, "", &mut units);
    }
    units
}

fn property(schema: &Value, path: &str, units: &mut Units) {
    let stated = schema.get("unit").and_then(Value::as_str).and_then(unit_named).map(|unit| unit.symbol);
    let described = || schema.get("description").and_then(Value::as_str).and_then(unit_in_brackets);
    if let Some(unit) = stated.or_else(described) {
        units.insert(path.into(), unit);
    }
    if let Some(items) = schema.get("items") {
        property(items, &format!("{path}[]"), units);
    }
    let properties = schema.get("properties").and_then(Value::as_object);
    for (name, inside) in properties.into_iter().flatten() {
        let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        property(inside, &path, units);
    }
}

/// The unit of the field at `path`, or of the array it is an element of.
fn unit_at(units: &Units, path: &str) -> Option<&'static str> {
    if units.is_empty() {
        return None;
    }
    let mut general = String::new();
    for part in path.split_inclusive('[') {
        general.push_str(part.trim_start_matches(|c: char| c.is_ascii_digit()));
    }
    let array = general.strip_suffix("[]");
    units.get(&general).or_else(|| units.get(array?)).copied()
}

/// Puts the numbers of a message into the open row.
///
/// # Errors
/// Where the text stops being JSON.
pub(crate) fn decode(units: &Units, message: &[u8], rows: &mut Rows) -> Result<(), String> {
    let message = with_nulls(message);
    let mut text = serde_json::Deserializer::from_slice(&message);
    Node(rows, units).deserialize(&mut text).and_then(|()| text.end()).map_err(|error| error.to_string())
}

/// A value of a message, with the units of its schema.
pub(super) struct Node<'r>(pub &'r mut Rows, pub &'r Units);

impl Node<'_> {
    fn number(self, value: f64) {
        self.0.number_in(value, |path| unit_at(self.1, path));
    }
}

impl<'de> DeserializeSeed<'de> for Node<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Node<'_> {
    type Value = ();

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("JSON")
    }

    fn visit_bool<E>(self, value: bool) -> Result<(), E> {
        self.number(f64::from(u8::from(value)));
        Ok(())
    }

    fn visit_i64<E>(self, value: i64) -> Result<(), E> {
        self.number(value as f64);
        Ok(())
    }

    fn visit_u64<E>(self, value: u64) -> Result<(), E> {
        self.number(value as f64);
        Ok(())
    }

    fn visit_f64<E>(self, value: f64) -> Result<(), E> {
        self.number(value);
        Ok(())
    }

    fn visit_str<E>(self, text: &str) -> Result<(), E> {
        if self.0.stamp_in_text(text) {
            return Ok(());
        }
        match number(text) {
            Some(value) if value.is_nan() => {}
            Some(value) => self.0.number_of_text(value, |path| unit_at(self.1, path)),
            None => self.0.leave_out(Reason::Text),
        }
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(mark) = map.next_key_seed(Key(self.0))? {
            map.next_value_seed(Node(self.0, self.1))?;
            self.0.leave(mark);
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<(), A::Error> {
        let open = self.0.open_array();
        let mut length = 0;
        loop {
            let more = if open && length < ELEMENTS_MAX {
                let mark = self.0.enter_element(length);
                let element = elements.next_element_seed(Node(self.0, self.1))?;
                self.0.leave(mark);
                element.is_some()
            } else {
                elements.next_element::<IgnoredAny>()?.is_some()
            };
            if !more {
                break;
            }
            length += 1;
        }
        if open {
            self.0.close_array(length);
        }
        Ok(())
    }
}

/// Goes into the field that a key names.
struct Key<'r>(&'r mut Rows);

impl<'de> DeserializeSeed<'de> for Key<'_> {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl Visitor<'_> for Key<'_> {
    type Value = usize;

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("a key")
    }

    fn visit_str<E>(self, key: &str) -> Result<usize, E> {
        Ok(self.0.enter(key))
    }
}
