//! What Arrow keeps of the columns of a Parquet file: a schema in the FlatBuffers format, written as
//! base64. Whatever cannot be read states nothing.

use crate::conventions::{Conventions, Stated};
use std::collections::BTreeMap;

/// Columns inside columns.
const DEPTH_MAX: usize = 16;
/// The type of a difference of times.
const DURATION: u8 = 18;

/// What is kept of one column.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Field {
    /// By its metadata.
    pub conventions: Conventions,
    /// The numbers are counts of so many a second.
    pub duration_per_s: Option<f64>,
}

/// What is kept by the name of the column, names of columns around it in front.
pub(crate) fn fields(base64: &str) -> BTreeMap<String, Field> {
    let message = decoded(base64);
    // A mark and a length stand in front of the message.
    let message = message.strip_prefix(&[0xff; 4]).and_then(|rest| rest.get(4..)).unwrap_or(&message);
    let mut fields = BTreeMap::new();
    for field in top(message).unwrap_or_default() {
        add(field, "", DEPTH_MAX, &mut fields);
    }
    fields
}

fn top(message: &[u8]) -> Option<Vec<Table<'_>>> {
    let root = Table { buffer: message, at: indirect(message, 0)? };
    Some(root.table(2)?.tables(1))
}

fn add(field: Table<'_>, prefix: &str, depth: usize, fields: &mut BTreeMap<String, Field>) {
    const COLUMNS_MAX: usize = 1 << 16;
    let Some(name) = field.text(0).filter(|_| depth > 0 && fields.len() < COLUMNS_MAX) else { return };
    let name = format!("{prefix}{name}");
    for child in field.tables(5) {
        add(child, &format!("{name}."), depth - 1, fields);
    }
    let pair = |pair: &Table<'_>| Some((pair.text(0)?, Stated::Text(pair.text(1)?)));
    let conventions = Conventions::of(field.tables(6).iter().filter_map(pair));
    let duration_per_s = (field.byte(2) == Some(DURATION)).then(|| counts_a_second(field));
    fields.insert(name, Field { conventions, duration_per_s });
}

/// Counts a second of a duration: thousandths where nothing is stated.
fn counts_a_second(field: Table<'_>) -> f64 {
    let unit = field.table(3).and_then(|duration| short(duration.buffer, duration.field(0)?));
    match unit {
        Some(0) => 1.0,
        Some(2) => 1e6,
        Some(3) => 1e9,
        _ => 1e3,
    }
}

/// A table of a FlatBuffer.
#[derive(Clone, Copy)]
struct Table<'a> {
    buffer: &'a [u8],
    at: usize,
}

impl<'a> Table<'a> {
    /// Place of a field.
    fn field(&self, number: usize) -> Option<usize> {
        let back = i32::from_le_bytes(self.buffer.get(self.at..self.at.checked_add(4)?)?.try_into().ok()?);
        let index = usize::try_from(i64::try_from(self.at).ok()? - i64::from(back)).ok()?;
        let entry = 4 + 2 * number;
        if usize::from(short(self.buffer, index)?) <= entry {
            return None;
        }
        let offset = usize::from(short(self.buffer, index.checked_add(entry)?)?);
        (offset > 0).then(|| self.at.checked_add(offset)).flatten()
    }

    fn byte(&self, number: usize) -> Option<u8> {
        self.buffer.get(self.field(number)?).copied()
    }

    fn table(&self, number: usize) -> Option<Table<'a>> {
        Some(Table { buffer: self.buffer, at: indirect(self.buffer, self.field(number)?)? })
    }

    fn tables(&self, number: usize) -> Vec<Table<'a>> {
        let Some(vector) = self.field(number).and_then(|at| indirect(self.buffer, at)) else { return Vec::new() };
        let length = word(self.buffer, vector).unwrap_or(0) as usize;
        let table = |place: usize| {
            let at = vector.checked_add(4)?.checked_add(place.checked_mul(4)?)?;
            Some(Table { buffer: self.buffer, at: indirect(self.buffer, at)? })
        };
        (0..length).map_while(table).collect()
    }

    fn text(&self, number: usize) -> Option<String> {
        let at = indirect(self.buffer, self.field(number)?)?;
        let from = at.checked_add(4)?;
        let text = self.buffer.get(from..from.checked_add(word(self.buffer, at)? as usize)?)?;
        Some(String::from_utf8_lossy(text).into_owned())
    }
}

fn word(buffer: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(buffer.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

fn short(buffer: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(buffer.get(at..at.checked_add(2)?)?.try_into().ok()?))
}

/// The place that the offset at `at` points to.
fn indirect(buffer: &[u8], at: usize) -> Option<usize> {
    at.checked_add(word(buffer, at)? as usize).filter(|to| *to < buffer.len())
}

fn decoded(base64: &str) -> Vec<u8> {
    let digit = |byte: u8| match byte {
        b'A'..=b'Z' => Some(byte - b'A'),
        b'a'..=b'z' => Some(byte - b'a' + 26),
        b'0'..=b'9' => Some(byte - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let digits: Vec<u8> = base64.bytes().map_while(digit).collect();
    let bytes = digits.chunks(4).flat_map(|four| {
        let value = four.iter().fold(0u32, |value, digit| value << 6 | u32::from(*digit)) << (6 * (4 - four.len()));
        let count = four.len() * 6 / 8;
        value.to_be_bytes().into_iter().skip(1).take(count)
    });
    bytes.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_decoded_with_and_without_an_end() {
        assert_eq!(decoded("b2JzaWQ="), b"obsid");
        assert_eq!(decoded("b2Jz"), b"obs");
        assert_eq!(decoded("!"), b"");
    }

    #[test]
    fn what_is_no_schema_states_no_units() {
        for text in ["", "AAAA", "/////wAAAAAQAAAA", "////////////////////"] {
            assert!(fields(text).is_empty(), "{text}");
        }
    }
}
