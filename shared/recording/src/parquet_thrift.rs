//! The structures of a Parquet file: Thrift's compact protocol.

use crate::bytes::{Bytes, COPY};
use crate::error::RecordingError;
use std::collections::BTreeMap;

/// Structures and lists inside each other.
const THRIFT_DEPTH_MAX: usize = 24;

/// A value of any type.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Truth(bool),
    Whole(i64),
    /// A text, or bytes that are no text.
    Text(Vec<u8>),
    List(Vec<Value>),
    /// By number of the field.
    Structure(BTreeMap<i16, Value>),
    /// A number with a fraction, a map: nothing that is needed.
    Other,
}

impl Value {
    /// A field of a structure.
    pub fn get(&self, field: i16) -> Option<&Value> {
        if let Value::Structure(fields) = self { fields.get(&field) } else { None }
    }

    /// A whole number in a field.
    pub fn whole(&self, field: i16) -> Option<i64> {
        if let Some(Value::Whole(value)) = self.get(field) { Some(*value) } else { None }
    }

    /// A length or a place in a field.
    pub fn size(&self, field: i16) -> Option<usize> {
        self.whole(field).and_then(|value| usize::try_from(value).ok())
    }

    /// A truth in a field.
    pub fn truth(&self, field: i16) -> Option<bool> {
        if let Some(Value::Truth(value)) = self.get(field) { Some(*value) } else { None }
    }

    /// A text in a field.
    pub fn text(&self, field: i16) -> Option<String> {
        let Some(Value::Text(bytes)) = self.get(field) else { return None };
        Some(String::from_utf8_lossy(bytes).into_owned())
    }

    /// The values of a list in a field; none where the field is not there.
    pub fn list(&self, field: i16) -> &[Value] {
        if let Some(Value::List(list)) = self.get(field) { list } else { &[] }
    }
}

/// A number of seven bits a byte, the lowest first.
///
/// # Errors
/// It does not end.
pub(crate) fn variable_length(bytes: &mut Bytes<'_>) -> Result<u64, RecordingError> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let byte = bytes.u8("a number")?;
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Ok(value);
        }
    }
    Err(bytes.error("a number has more than 64 bits", COPY))
}

/// A number with a sign: 0, -1, 1, -2 are stored as 0, 1, 2, 3.
///
/// # Errors
/// It does not end.
pub(crate) fn zigzag(bytes: &mut Bytes<'_>) -> Result<i64, RecordingError> {
    let value = variable_length(bytes)?;
    Ok((value >> 1) as i64 ^ -((value & 1) as i64))
}

/// The structure that begins here.
///
/// # Errors
/// The bytes are no structure.
pub(crate) fn structure(bytes: &mut Bytes<'_>) -> Result<Value, RecordingError> {
    structure_within(bytes, THRIFT_DEPTH_MAX)
}

fn structure_within(bytes: &mut Bytes<'_>, depth: usize) -> Result<Value, RecordingError> {
    if depth == 0 {
        return Err(bytes.error(format!("more than {THRIFT_DEPTH_MAX} structures are in each other"), COPY));
    }
    let mut fields = BTreeMap::new();
    let mut number = 0i16;
    loop {
        let head = bytes.u8("a field")?;
        if head == 0 {
            return Ok(Value::Structure(fields));
        }
        number = match head >> 4 {
            0 => zigzag(bytes)? as i16,
            step => number.wrapping_add(i16::from(step)),
        };
        let value = match head & 0x0f {
            1 => Value::Truth(true),
            2 => Value::Truth(false),
            kind => value(bytes, kind, depth)?,
        };
        fields.insert(number, value);
    }
}

fn value(bytes: &mut Bytes<'_>, kind: u8, depth: usize) -> Result<Value, RecordingError> {
    Ok(match kind {
        1 | 2 => Value::Truth(bytes.u8("a truth")? == 1),
        3 => Value::Whole(i64::from(bytes.u8("a byte")? as i8)),
        4..=6 => Value::Whole(zigzag(bytes)?),
        7 => {
            bytes.take(8, "a number")?;
            Value::Other
        }
        8 => {
            let length = length(bytes)?;
            Value::Text(bytes.take(length, "a text")?.to_vec())
        }
        9 | 10 => list(bytes, depth - 1)?,
        11 => map(bytes, depth - 1)?,
        12 => structure_within(bytes, depth - 1)?,
        other => return Err(bytes.error(format!("type {other} of a field is not known"), COPY)),
    })
}

/// A length is no more than the bytes that are left: every value has one at least.
fn length(bytes: &mut Bytes<'_>) -> Result<usize, RecordingError> {
    let length = variable_length(bytes)?;
    let left = bytes.left();
    let fits = usize::try_from(length).ok().filter(|length| *length <= left);
    fits.ok_or_else(|| bytes.error(format!("a length of {length} is stated, {left} bytes are there"), COPY))
}

fn list(bytes: &mut Bytes<'_>, depth: usize) -> Result<Value, RecordingError> {
    if depth == 0 {
        return Err(bytes.error(format!("more than {THRIFT_DEPTH_MAX} lists are in each other"), COPY));
    }
    let head = bytes.u8("a list")?;
    let count = if head >> 4 == 15 { length(bytes)? } else { usize::from(head >> 4) };
    (0..count).map(|_| value(bytes, head & 0x0f, depth)).collect::<Result<_, _>>().map(Value::List)
}

fn map(bytes: &mut Bytes<'_>, depth: usize) -> Result<Value, RecordingError> {
    if depth == 0 {
        return Err(bytes.error(format!("more than {THRIFT_DEPTH_MAX} maps are in each other"), COPY));
    }
    let count = length(bytes)?;
    if count > 0 {
        let kinds = bytes.u8("a map")?;
        for _ in 0..count {
            value(bytes, kinds >> 4, depth)?;
            value(bytes, kinds & 0x0f, depth)?;
        }
    }
    Ok(Value::Other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_texts_and_lists_are_read_by_field() {
        // 1: -1 (i32), 3: "ab", 4: [true, false], 20: {1: 300 (i64)}.
        let data = [0x15, 1, 0x28, 2, b'a', b'b', 0x19, 0x21, 1, 2, 0x0c, 40, 0x16, 0xd8, 4, 0, 0];
        let read = structure(&mut Bytes::new("file", "", &data)).unwrap();
        assert_eq!((read.whole(1), read.text(3)), (Some(-1), Some("ab".to_string())));
        assert_eq!(read.list(4), [Value::Truth(true), Value::Truth(false)]);
        assert_eq!(read.get(20).unwrap().whole(1), Some(300));
        assert_eq!(read.size(1), None);
    }

    #[test]
    fn lists_longer_than_the_bytes_and_structures_without_end_are_errors() {
        for data in [&[0x19, 0xf5, 0xff, 0xff, 0x7f][..], &[0x1c; 60], &[0x15], &[0x15, 0xff], &[0x1f, 0]] {
            assert!(structure(&mut Bytes::new("file", "", data)).is_err(), "{data:?}");
        }
    }
}
