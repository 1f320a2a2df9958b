//! Message types of a protobuf schema, each with its fields by number.

use super::wire::Payload;
use prost_reflect::{Cardinality, DescriptorPool, FieldDescriptor, Kind as Described, MessageDescriptor};
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
    pub unit: Option<&'static str>,
}

/// The fields of a message, by number.
#[derive(Clone, Debug)]
pub(crate) struct Type {
    pub fields: Vec<Field>,
}

/// The type of the message `name`, and behind it all types inside it.
///
/// # Errors
/// What of the descriptors is not understood.
pub(crate) fn types(name: &str, descriptors: &[u8]) -> Result<Vec<Type>, String> {
    let pool = DescriptorPool::decode(descriptors).map_err(|error| format!("the descriptors are damaged: {error}"))?;
    let root = pool.get_message_by_name(name).ok_or("the descriptors do not hold the message")?;
    let mut known = HashMap::from([(root.full_name().to_string(), 0)]);
    let mut waiting = vec![root];
    let mut types = Vec::new();
    while let Some(message) = waiting.get(types.len()).cloned() {
        let mut fields: Vec<Field> =
            message.fields().map(|field| described(&field, &mut known, &mut waiting)).collect();
        fields.sort_by_key(|field| field.number);
        types.push(Type { fields });
    }
    Ok(types)
}

fn described(
    field: &FieldDescriptor,
    known: &mut HashMap<String, usize>,
    waiting: &mut Vec<MessageDescriptor>,
) -> Field {
    let kind = match field.kind() {
        _ if field.is_map() => Kind::Map,
        Described::Double => Kind::Double,
        Described::Float => Kind::Float,
        Described::Int64 => Kind::Signed,
        Described::Int32 | Described::Enum(_) => Kind::Signed32,
        Described::Uint32 | Described::Uint64 => Kind::Unsigned,
        Described::Sint32 | Described::Sint64 => Kind::ZigZag,
        Described::Fixed32 => Kind::Fixed32,
        Described::Fixed64 => Kind::Fixed64,
        Described::Sfixed32 => Kind::SignedFixed32,
        Described::Sfixed64 => Kind::SignedFixed64,
        Described::Bool => Kind::Bool,
        Described::String => Kind::Text,
        Described::Bytes => Kind::Bytes,
        Described::Message(message) => match message.full_name() {
            "google.protobuf.Timestamp" => Kind::Time,
            "google.protobuf.Duration" => Kind::Duration,
            name => Kind::Message(*known.entry(name.to_string()).or_insert_with(|| {
                waiting.push(message.clone());
                waiting.len() - 1
            })),
        },
    };
    Field {
        number: field.number(),
        name: field.name().to_string(),
        kind,
        is_repeated: field.cardinality() == Cardinality::Repeated,
        is_zero_when_absent: !field.supports_presence(),
        unit: None,
    }
}
