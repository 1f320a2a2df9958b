//! Protobuf messages: bytes walked as they lie, by the descriptors of the schema.
//!
//! A number that a proto3 message does not state is 0; a message or an optional field that is not
//! there has no value. Repeated fields are arrays.

mod descriptors;
mod types;
mod wire;

use super::left_out::Reason;
use super::rows::{ELEMENTS_MAX, Rows, STAMPS_NS};
use types::{Field, Kind, Type, types};
use wire::{Payload, Wire};

/// Messages inside messages.
const MESSAGE_DEPTH_MAX: usize = 32;
/// Fields of a message: some, and some for every byte.
const PROTOBUF_STEPS: (usize, usize) = (4096, 16);

/// The message types of a schema.
pub(crate) struct Messages {
    types: Vec<Type>,
}

impl Messages {
    /// Reads `descriptors`, a `FileDescriptorSet`, and finds the message `name` in it.
    ///
    /// # Errors
    /// What of the descriptors is not understood.
    pub fn new(name: &str, descriptors: &[u8]) -> Result<Self, String> {
        Ok(Messages { types: types(name, descriptors)? })
    }

    /// Puts the numbers of a message into the open row.
    ///
    /// # Errors
    /// Where the bytes do not fit the descriptors.
    pub fn decode(&self, message: &[u8], rows: &mut Rows) -> Result<(), String> {
        let steps = PROTOBUF_STEPS.0 + message.len().saturating_mul(PROTOBUF_STEPS.1);
        Walk { types: &self.types, rows, steps }.message(0, message, 0)
    }
}

/// What a message holds of one field.
#[derive(Clone, Default)]
struct Found<'a> {
    last: Option<Payload<'a>>,
    /// The first ones of a repeated field.
    first: Vec<Payload<'a>>,
    count: usize,
}

struct Walk<'m, 'r> {
    types: &'m [Type],
    rows: &'r mut Rows,
    steps: usize,
}

impl<'m> Walk<'m, '_> {
    fn steps(&mut self, count: usize) -> Result<(), String> {
        self.steps = self.steps.checked_sub(count).ok_or("it holds more fields than bytes")?;
        Ok(())
    }

    fn message(&mut self, index: usize, bytes: &[u8], depth: usize) -> Result<(), String> {
        if depth > MESSAGE_DEPTH_MAX {
            return Err(format!("more than {MESSAGE_DEPTH_MAX} messages inside each other"));
        }
        let types: &'m [Type] = self.types;
        let fields = &types.get(index).ok_or("the descriptors are not complete")?.fields;
        self.steps(fields.len())?;
        let found = found(fields, bytes)?;
        for (field, found) in fields.iter().zip(&found) {
            let mark = self.rows.enter(&field.name);
            if field.is_repeated {
                self.repeated(field, found, depth)?;
            } else if let Some(payload) = found.last {
                self.value(field, payload, depth)?;
            } else if field.is_zero_when_absent && field.kind.is_number() {
                self.rows.number(0.0, None);
            }
            self.rows.leave(mark);
        }
        Ok(())
    }

    fn value(&mut self, field: &Field, payload: Payload<'_>, depth: usize) -> Result<(), String> {
        match (field.kind, payload) {
            (Kind::Text, _) => self.rows.leave_out(Reason::Text),
            (Kind::Bytes, _) => self.rows.leave_out(Reason::Bytes),
            (Kind::Map, _) => self.rows.leave_out(Reason::Map),
            (Kind::Message(index), Payload::Bytes(bytes)) => self.message(index, bytes, depth + 1)?,
            (Kind::Time | Kind::Duration, Payload::Bytes(bytes)) => self.time(field, bytes, depth)?,
            (kind, payload) => {
                let number = kind.number(payload).ok_or_else(|| format!("`{}` is not of its type", field.name))?;
                self.rows.number(number, None);
            }
        }
        Ok(())
    }

    /// The first time of the whole message called `timestamp` or `stamp` is that of the row.
    fn time(&mut self, field: &Field, bytes: &[u8], depth: usize) -> Result<(), String> {
        let (seconds, nanoseconds) = wire::time(bytes)?;
        let is_stamp = depth == 0 && field.kind == Kind::Time && matches!(field.name.as_str(), "timestamp" | "stamp");
        if is_stamp {
            let whole = u64::try_from(seconds).unwrap_or(0).saturating_mul(STAMPS_NS);
            self.rows.stamp(&field.name, whole.saturating_add(u64::try_from(nanoseconds).unwrap_or(0)));
        } else {
            self.rows.number(seconds as f64 + f64::from(nanoseconds) / STAMPS_NS as f64, Some("s"));
        }
        Ok(())
    }

    fn repeated(&mut self, field: &Field, found: &Found<'_>, depth: usize) -> Result<(), String> {
        let without_columns = match field.kind {
            Kind::Text => Some(Reason::Text),
            Kind::Bytes => Some(Reason::Bytes),
            Kind::Map => Some(Reason::Map),
            _ => None,
        };
        if let Some(reason) = without_columns {
            if found.count > 0 {
                self.rows.leave_out(reason);
            }
            return Ok(());
        }
        if !self.rows.open_array() {
            return Ok(());
        }
        if found.count <= ELEMENTS_MAX {
            for (index, payload) in found.first.iter().enumerate() {
                self.steps(1)?;
                let mark = self.rows.enter_element(index);
                self.value(field, *payload, depth)?;
                self.rows.leave(mark);
            }
        }
        self.rows.close_array(found.count);
        Ok(())
    }
}

/// All fields of a message, in the order of `fields`; what they do not describe is passed over.
fn found<'a>(fields: &[Field], bytes: &'a [u8]) -> Result<Vec<Found<'a>>, String> {
    let mut all = vec![Found::default(); fields.len()];
    let mut wire = Wire::new(bytes);
    while let Some((number, payload)) = wire.field()? {
        let Ok(index) = fields.binary_search_by_key(&number, |field| field.number) else { continue };
        let (field, found) = (&fields[index], &mut all[index]);
        match payload {
            Payload::Bytes(packed) if field.is_repeated && field.kind.is_number() => {
                let mut wire = Wire::new(packed);
                while let Some(element) = wire.packed(field.kind)? {
                    found.add(element);
                }
            }
            payload if field.is_repeated => found.add(payload),
            payload => found.last = Some(payload),
        }
    }
    Ok(all)
}

impl<'a> Found<'a> {
    fn add(&mut self, payload: Payload<'a>) {
        if self.first.len() < ELEMENTS_MAX {
            self.first.push(payload);
        }
        self.count += 1;
    }
}
