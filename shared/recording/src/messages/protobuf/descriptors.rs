//! A protobuf schema as it lies: a `FileDescriptorSet`, itself a protobuf message.
//!
//! Why not `prost-reflect`? It panics on damaged descriptors (0.16.5).

use super::wire::{Payload, Wire};
use std::collections::HashMap;

/// Bytes of the full name of a message.
const FULL_NAME_MAX: usize = 256;
/// Messages of a schema.
const TYPES_MAX: usize = 10_000;

/// A message of the schema.
pub(super) struct Described<'a> {
    bytes: &'a [u8],
    /// Whether numbers that are 0 are left out of messages.
    is_implicit: bool,
    /// Whether it is the pair of key and value of a map.
    pub is_map_entry: bool,
}

/// A field of a message of the schema.
pub(super) struct DescribedField {
    pub number: u32,
    pub name: String,
    /// As `FieldDescriptorProto` numbers the types.
    pub kind: u64,
    /// Full name of the message inside.
    pub type_name: String,
    pub is_repeated: bool,
    pub is_zero_when_absent: bool,
}

/// The messages of a schema by their full names.
///
/// # Errors
/// Where the descriptors are damaged.
pub(super) fn descriptors(schema: &[u8]) -> Result<HashMap<String, Described<'_>>, String> {
    let mut found = HashMap::new();
    for file in all(schema, 1)? {
        let package = text(file, 2)?;
        let is_implicit = is_implicit(file)?;
        // Messages inside messages wait for their turn.
        let mut waiting: Vec<(String, &[u8])> = all(file, 4)?.map(|bytes| (package.clone(), bytes)).collect();
        while let Some((around, bytes)) = waiting.pop() {
            let own = text(bytes, 1)?;
            let name = if around.is_empty() { own } else { format!("{around}.{own}") };
            if name.len() > FULL_NAME_MAX || found.len() >= TYPES_MAX {
                return Err(format!("more than {TYPES_MAX} messages, or a name of more than {FULL_NAME_MAX} bytes"));
            }
            waiting.extend(all(bytes, 3)?.map(|inside| (name.clone(), inside)));
            let options = all(bytes, 7)?.last().unwrap_or_default();
            let is_map_entry = number(options, 7)?.is_some_and(|value| value != 0);
            found.insert(name, Described { bytes, is_implicit, is_map_entry });
        }
    }
    Ok(found)
}

/// proto3, or an edition whose file says so.
fn is_implicit(file: &[u8]) -> Result<bool, String> {
    let options = all(file, 8)?.last().unwrap_or_default();
    let features = all(options, 50)?.last().unwrap_or_default();
    Ok(text(file, 12)? == "proto3" || number(features, 1)? == Some(PRESENCE_IMPLICIT))
}

/// Of the values of the feature `field_presence`.
const PRESENCE_IMPLICIT: u64 = 2;
/// Of the values of `label`.
const LABEL_REPEATED: u64 = 3;

impl Described<'_> {
    /// The fields in the order of the schema.
    ///
    /// # Errors
    /// Where the descriptor is damaged.
    pub fn fields(&self) -> Result<Vec<DescribedField>, String> {
        all(self.bytes, 2)?.map(|bytes| self.field(bytes)).collect()
    }

    fn field(&self, bytes: &[u8]) -> Result<DescribedField, String> {
        let options = all(bytes, 8)?.last().unwrap_or_default();
        let features = all(options, 21)?.last().unwrap_or_default();
        let is_implicit = match number(features, 1)? {
            None | Some(0) => self.is_implicit,
            Some(presence) => presence == PRESENCE_IMPLICIT,
        };
        // A choice of fields, or `optional` in proto3: what is absent has no value.
        let is_optional = number(bytes, 9)?.is_some() || number(bytes, 17)?.is_some_and(|value| value != 0);
        let name = text(bytes, 1)?;
        let stated = number(bytes, 3)?.and_then(|value| u32::try_from(value).ok());
        Ok(DescribedField {
            number: stated.ok_or_else(|| format!("the field `{name}` has no number"))?,
            kind: number(bytes, 5)?.unwrap_or_default(),
            type_name: text(bytes, 6)?.trim_start_matches('.').to_string(),
            is_repeated: number(bytes, 4)? == Some(LABEL_REPEATED),
            is_zero_when_absent: is_implicit && !is_optional,
            name,
        })
    }
}

/// The bytes of every field `wanted` of a message, which is walked to its end first.
fn all(bytes: &[u8], wanted: u32) -> Result<impl Iterator<Item = &[u8]>, String> {
    let mut check = Wire::new(bytes);
    while check.field()?.is_some() {}
    let mut wire = Wire::new(bytes);
    Ok(core::iter::from_fn(move || wire.field().ok().flatten()).filter_map(move |field| match field {
        (number, Payload::Bytes(bytes)) if number == wanted => Some(bytes),
        _ => None,
    }))
}

/// The last text of the field `wanted`; empty when there is not any.
fn text(bytes: &[u8], wanted: u32) -> Result<String, String> {
    let bytes = all(bytes, wanted)?.last().unwrap_or_default();
    core::str::from_utf8(bytes).map(String::from).map_err(|_| "a name in the descriptors is not UTF-8".into())
}

/// The last number of the field `wanted`.
fn number(bytes: &[u8], wanted: u32) -> Result<Option<u64>, String> {
    let mut wire = Wire::new(bytes);
    let mut last = None;
    while let Some(field) = wire.field()? {
        match field {
            (number, Payload::Varint(value)) if number == wanted => last = Some(value),
            _ => {}
        }
    }
    Ok(last)
}
