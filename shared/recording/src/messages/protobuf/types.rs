//! Message types of a protobuf schema, each with its fields by number.

use super::descriptors::{DescribedField, descriptors};
use super::wire::Payload;
use std::collections::HashMap;

/// What a field holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Double,
    Float,
    Signed,
    Signed32,
    Unsigned,
    ZigZag,
    Bool,
    Fixed32,
    Fixed64,
    SignedFixed32,
    SignedFixed64,
    Text,
    Bytes,
    Map,
    Time,
    Duration,
    /// The number of a type.
    Message(usize),
}

impl Kind {
    pub fn is_number(self) -> bool {
        !matches!(self, Kind::Text | Kind::Bytes | Kind::Map | Kind::Time | Kind::Duration | Kind::Message(_))
    }

    /// The wire type of a number.
    pub fn wire_type(self) -> u64 {
        match self {
            Kind::Double | Kind::Fixed64 | Kind::SignedFixed64 => 1,
            Kind::Float | Kind::Fixed32 | Kind::SignedFixed32 => 5,
            Kind::Text | Kind::Bytes | Kind::Map | Kind::Time | Kind::Duration | Kind::Message(_) => 2,
            Kind::Signed | Kind::Signed32 | Kind::Unsigned | Kind::ZigZag | Kind::Bool => 0,
        }
    }

    /// The number that `payload` is; `None` when it is of another wire type.
    pub fn number(self, payload: Payload<'_>) -> Option<f64> {
        Some(match (self, payload) {
            (Kind::Double, Payload::Word64(word)) => f64::from_le_bytes(word),
            (Kind::Float, Payload::Word32(word)) => f64::from(f32::from_le_bytes(word)),
            (Kind::Signed, Payload::Varint(value)) => value as i64 as f64,
            // Negative ones are extended to 64 bits; the low 32 bits are the value.
            (Kind::Signed32, Payload::Varint(value)) => f64::from(value as i32),
            (Kind::Unsigned, Payload::Varint(value)) => value as f64,
            (Kind::ZigZag, Payload::Varint(value)) => ((value >> 1) as i64 ^ -((value & 1) as i64)) as f64,
            (Kind::Bool, Payload::Varint(value)) => f64::from(u8::from(value != 0)),
            (Kind::Fixed32, Payload::Word32(word)) => f64::from(u32::from_le_bytes(word)),
            (Kind::Fixed64, Payload::Word64(word)) => u64::from_le_bytes(word) as f64,
            (Kind::SignedFixed32, Payload::Word32(word)) => f64::from(i32::from_le_bytes(word)),
            (Kind::SignedFixed64, Payload::Word64(word)) => i64::from_le_bytes(word) as f64,
            _ => return None,
        })
    }
}

/// A field of a message.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    pub number: u32,
    pub name: String,
    pub kind: Kind,
    pub is_repeated: bool,
    /// Whether the message leaves it out when it is 0.
    pub is_zero_when_absent: bool,
}

/// The fields of a message, by number.
#[derive(Clone, Debug)]
pub(crate) struct Type {
    pub fields: Vec<Field>,
}

/// Fields of all types of a schema.
const FIELDS_MAX: usize = 1 << 16;

/// The type of the message `name`, and behind it all types inside it.
///
/// # Errors
/// What of the descriptors is not understood.
pub(crate) fn types(name: &str, schema: &[u8]) -> Result<Vec<Type>, String> {
    let described = descriptors(schema)?;
    let mut known = HashMap::from([(name.to_string(), 0)]);
    let mut waiting = vec![name.to_string()];
    let mut types: Vec<Type> = Vec::new();
    let mut count = 0;
    while let Some(name) = waiting.get(types.len()) {
        let message = described.get(name).ok_or_else(|| format!("the descriptors do not hold the message `{name}`"))?;
        let mut fields = Vec::new();
        for field in message.fields()? {
            let kind = match field.kind {
                FIELD_MESSAGE => inside(&field, &mut known, &mut waiting, |name| {
                    described.get(name).is_some_and(|message| message.is_map_entry)
                }),
                number => plain(number)?,
            };
            let is_zero_when_absent = field.is_zero_when_absent;
            let (number, name, is_repeated) = (field.number, field.name, field.is_repeated);
            fields.push(Field { number, name, kind, is_repeated, is_zero_when_absent });
        }
        count += fields.len();
        if count > FIELDS_MAX {
            return Err(format!("more than {FIELDS_MAX} fields"));
        }
        fields.sort_by_key(|field| field.number);
        types.push(Type { fields });
    }
    Ok(types)
}

/// The number of messages among the types of `FieldDescriptorProto`.
const FIELD_MESSAGE: u64 = 11;

/// The other types of `FieldDescriptorProto`.
fn plain(number: u64) -> Result<Kind, String> {
    Ok(match number {
        1 => Kind::Double,
        2 => Kind::Float,
        3 => Kind::Signed,
        4 | 13 => Kind::Unsigned,
        5 | 14 => Kind::Signed32,
        6 => Kind::Fixed64,
        7 => Kind::Fixed32,
        8 => Kind::Bool,
        9 => Kind::Text,
        12 => Kind::Bytes,
        15 => Kind::SignedFixed32,
        16 => Kind::SignedFixed64,
        17 | 18 => Kind::ZigZag,
        10 => return Err("groups are not read".into()),
        other => return Err(format!("a field of type {other}, which does not exist")),
    })
}

fn inside(
    field: &DescribedField,
    known: &mut HashMap<String, usize>,
    waiting: &mut Vec<String>,
    is_map_entry: impl Fn(&str) -> bool,
) -> Kind {
    match field.type_name.as_str() {
        "google.protobuf.Timestamp" => Kind::Time,
        "google.protobuf.Duration" => Kind::Duration,
        name if is_map_entry(name) => Kind::Map,
        name => Kind::Message(*known.entry(name.to_string()).or_insert_with(|| {
            waiting.push(name.to_string());
            waiting.len() - 1
        })),
    }
}
