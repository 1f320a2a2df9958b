//! The encoding of protobuf: tags, variable-length integers, words and strings of bytes.

use super::types::Kind;

/// The bytes of one field.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Payload<'a> {
    Varint(u64),
    Word32([u8; 4]),
    Word64([u8; 8]),
    Bytes(&'a [u8]),
}

/// Bytes that are read from front to back.
pub(crate) struct Wire<'a> {
    rest: &'a [u8],
}

const ENDS_EARLY: &str = "it ends inside a field";
/// Ten groups of 7 bits hold 64.
const VARINT_BYTES_MAX: usize = 10;

impl<'a> Wire<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Wire { rest: bytes }
    }

    fn varint(&mut self) -> Result<u64, String> {
        let mut value = 0;
        for (index, byte) in self.rest.iter().take(VARINT_BYTES_MAX).enumerate() {
            value |= u64::from(byte & 0x7f) << (7 * index);
            if byte & 0x80 == 0 {
                self.rest = &self.rest[index + 1..];
                return Ok(value);
            }
        }
        Err(ENDS_EARLY.into())
    }

    fn word<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (word, rest) = self.rest.split_first_chunk().ok_or(ENDS_EARLY)?;
        self.rest = rest;
        Ok(*word)
    }

    fn payload(&mut self, wire_type: u64) -> Result<Payload<'a>, String> {
        match wire_type {
            0 => self.varint().map(Payload::Varint),
            1 => self.word().map(Payload::Word64),
            2 => {
                let length = usize::try_from(self.varint()?).map_err(|_| ENDS_EARLY)?;
                let (bytes, rest) = self.rest.split_at_checked(length).ok_or(ENDS_EARLY)?;
                self.rest = rest;
                Ok(Payload::Bytes(bytes))
            }
            5 => self.word().map(Payload::Word32),
            3 | 4 => Err("groups are not read".into()),
            other => Err(format!("wire type {other} does not exist")),
        }
    }

    /// Number and bytes of the next field; `None` at the end.
    pub fn field(&mut self) -> Result<Option<(u32, Payload<'a>)>, String> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        let tag = self.varint()?;
        let number = u32::try_from(tag >> 3).map_err(|_| "a field number beyond 32 bits")?;
        Ok(Some((number, self.payload(tag & 7)?)))
    }

    /// The next element of a packed field of numbers.
    pub fn packed(&mut self, kind: Kind) -> Result<Option<Payload<'a>>, String> {
        if self.rest.is_empty() { Ok(None) } else { self.payload(kind.wire_type()).map(Some) }
    }
}

/// Seconds and nanoseconds of a `Timestamp` or `Duration`.
pub(crate) fn time(bytes: &[u8]) -> Result<(i64, i32), String> {
    let (mut seconds, mut nanoseconds) = (0, 0);
    let mut wire = Wire::new(bytes);
    while let Some(field) = wire.field()? {
        match field {
            (1, Payload::Varint(value)) => seconds = value as i64,
            (2, Payload::Varint(value)) => nanoseconds = value as i32,
            _ => {}
        }
    }
    Ok((seconds, nanoseconds))
}
