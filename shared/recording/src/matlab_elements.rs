//! The elements of a MATLAB file: a type, a length, and bytes, filled up to a multiple of eight.

use crate::bytes::{Bytes, COPY, expanded};
use crate::error::RecordingError;
use crate::numbers::Number;
use flate2::read::ZlibDecoder;
use std::io::Read;

/// A variable, a cell or a field.
pub(crate) const MATRIX: u32 = 14;
/// A variable in a zlib stream.
pub(crate) const COMPRESSED: u32 = 15;
const ALIGNMENT: usize = 8;

/// One element.
pub(crate) struct Element<'a> {
    pub kind: u32,
    /// Place of its type among the bytes around it.
    pub at: usize,
    pub data: Bytes<'a>,
}

impl Element<'_> {
    /// How the numbers are stored; a type that is no number has none.
    pub fn number(&self) -> Option<Number> {
        match self.kind {
            1 => Number::whole(1, true),
            2 => Number::whole(1, false),
            3 => Number::whole(2, true),
            4 => Number::whole(2, false),
            5 => Number::whole(4, true),
            6 => Number::whole(4, false),
            7 => Number::float(4),
            9 => Number::float(8),
            12 => Number::whole(8, true),
            13 => Number::whole(8, false),
            _ => None,
        }
    }

    /// All numbers.
    ///
    /// # Errors
    /// The type has no numbers.
    pub fn numbers(mut self) -> Result<Vec<f64>, RecordingError> {
        let number = self.number();
        let number = number.ok_or_else(|| self.data.error(format!("type {} has no numbers", self.kind), COPY))?;
        let (left, big_endian) = (self.data.left(), self.data.big_endian);
        Ok(number.values(self.data.take(left, "the numbers")?, big_endian))
    }

    /// The bytes as text, up to the first zero.
    pub fn text(mut self) -> Result<String, RecordingError> {
        let left = self.data.left();
        let bytes = self.data.take(left, "a text")?;
        let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
        Ok(String::from_utf8_lossy(&bytes[..end]).into_owned())
    }
}

/// The next element.
///
/// # Errors
/// The bytes end before.
pub(crate) fn next<'a>(bytes: &mut Bytes<'a>) -> Result<Element<'a>, RecordingError> {
    let at = bytes.at();
    let kind = bytes.u32("an element")?;
    if kind >> 16 != 0 {
        // Up to four bytes stand beside type and length.
        let data = bytes.split(((kind >> 16) as usize).min(4), "an element")?;
        bytes.go_to(at + ALIGNMENT);
        return Ok(Element { kind: kind & 0xffff, at, data });
    }
    let length = bytes.u32("an element")? as usize;
    let data = bytes.split(length, "an element")?;
    if kind != COMPRESSED {
        bytes.go_to(bytes.at().next_multiple_of(ALIGNMENT));
    }
    Ok(Element { kind, at, data })
}

/// The bytes of a compressed element; `budget` is what all of them together may still have.
///
/// # Errors
/// A damaged stream, and one that states more bytes than the budget or has others than it states.
pub(crate) fn inflated(element: Element<'_>, budget: &mut usize) -> Result<Vec<u8>, RecordingError> {
    let mut data = element.data;
    let (left, big_endian) = (data.left(), data.big_endian);
    let place = data.clone();
    let packed = data.take(left, "a variable")?;
    let damaged = |reason: std::io::Error| place.error(format!("the variable cannot be expanded: {reason}"), COPY);
    let mut head = [0; ALIGNMENT];
    let mut stream = ZlibDecoder::new(packed);
    stream.read_exact(&mut head).map_err(damaged)?;
    let size = Number::Unsigned(4).value(&head[4..], big_endian) as usize;
    if size > *budget {
        return Err(place.error(format!("the variable states {size} bytes, absurd for this file"), COPY));
    }
    *budget -= size;
    let mut expanded = expanded(stream, size + ALIGNMENT).map_err(damaged)?;
    expanded.splice(0..0, head);
    Ok(expanded)
}
