//! The records of a ROS 1 bag: a header of `name=value` fields, then data. Chunks hold records.

use super::super::damaged::Damaged;
use super::super::input::Input;
use crate::error::RecordingError;
use crate::file_name;
use crate::messages::STAMPS_NS;
use std::path::Path;

/// A record that says something about samples.
pub(super) enum Item<'a> {
    Connection { id: u32, topic: &'a str, kind: &'a str, definition: &'a [u8] },
    Message { connection: u32, logged_ns: u64, data: &'a [u8] },
}

type Visitor<'v> = &'v mut dyn FnMut(Item<'_>);

const BAG_MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// Field `op` of records that are read.
const OP_MESSAGE: u8 = 2;
const OP_CHUNK: u8 = 5;
const OP_CONNECTION: u8 = 7;

/// Visits the records of a bag; gives notes on what is missing.
///
/// # Errors
/// A file that is no bag; the device's.
pub(super) fn walk(path: &Path, visit: Visitor<'_>) -> Result<Vec<String>, RecordingError> {
    let mut input = Input::open(path)?;
    if input.take(BAG_MAGIC.len() as u64)?.as_deref() != Some(BAG_MAGIC) {
        return Err(RecordingError::BadContainer {
            file: file_name(path),
            place: "byte 0".into(),
            found: "the file does not begin with `#ROSBAG V2.0`".into(),
            cure: "older bags are brought to this version by `rosbag fix`".into(),
        });
    }
    let mut walk = Walk { damaged: Damaged::new(input.size), visit };
    let mut notes = Vec::new();
    while input.left() > 0 {
        let start = input.offset;
        let Some((head, data)) = record(&mut input)? else {
            notes.push(format!("the bag is cut at byte {start} of {}: what lies before it is read", input.size));
            break;
        };
        if op(&head) == Some(OP_CHUNK) {
            walk.chunk(&head, &data, start);
        } else {
            walk.record(&head, &data, start);
        }
    }
    notes.extend(walk.damaged.note());
    Ok(notes)
}

type HeadAndData = (Vec<u8>, Vec<u8>);

/// Header and data of the next record; `None` when it is cut.
fn record(input: &mut Input<'_>) -> Result<Option<HeadAndData>, RecordingError> {
    let Some(head) = part(input)? else { return Ok(None) };
    Ok(part(input)?.map(|data| (head, data)))
}

fn part(input: &mut Input<'_>) -> Result<Option<Vec<u8>>, RecordingError> {
    match input.take(4)?.as_deref().and_then(word) {
        Some(length) => input.take(u64::from(length)),
        None => Ok(None),
    }
}

fn word(bytes: &[u8]) -> Option<u32> {
    bytes.first_chunk().map(|bytes| u32::from_le_bytes(*bytes))
}

/// Splits a part with its length in front from what lies behind.
fn split(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let length = usize::try_from(word(bytes)?).ok()?;
    bytes[4..].split_at_checked(length)
}

/// The value of the field `name` of a header.
fn field<'a>(mut head: &'a [u8], name: &str) -> Option<&'a [u8]> {
    while let Some((field, behind)) = split(head) {
        if let Some(value) = field.strip_prefix(name.as_bytes()).and_then(|rest| rest.strip_prefix(b"=")) {
            return Some(value);
        }
        head = behind;
    }
    None
}

fn op(head: &[u8]) -> Option<u8> {
    field(head, "op").and_then(|value| value.first().copied())
}

fn text<'a>(head: &'a [u8], name: &str) -> Option<&'a str> {
    core::str::from_utf8(field(head, name)?).ok()
}

struct Walk<'v> {
    damaged: Damaged,
    visit: Visitor<'v>,
}

impl Walk<'_> {
    fn chunk(&mut self, head: &[u8], data: &[u8], offset: u64) {
        let (Some(compression), Some(size)) = (text(head, "compression"), field(head, "size").and_then(word)) else {
            return self.damaged.add(offset, "a chunk without compression and size");
        };
        match self.damaged.budget.unpack(compression, data, u64::from(size)) {
            Ok(content) => self.content(&content, offset),
            Err(reason) => self.damaged.add(offset, &reason),
        }
    }

    fn content(&mut self, mut rest: &[u8], offset: u64) {
        while !rest.is_empty() {
            let Some((head, data, behind)) =
                split(rest).and_then(|(head, rest)| split(rest).map(|(data, behind)| (head, data, behind)))
            else {
                return self.damaged.add(offset, "the chunk ends inside a record");
            };
            self.record(head, data, offset);
            rest = behind;
        }
    }

    fn record(&mut self, head: &[u8], data: &[u8], offset: u64) {
        match op(head) {
            Some(OP_MESSAGE) => match message(head, data) {
                Some(item) => (self.visit)(item),
                None => self.damaged.add(offset, "a message without connection and time"),
            },
            Some(OP_CONNECTION) => match connection(head, data) {
                Some(item) => (self.visit)(item),
                None => self.damaged.add(offset, "a connection without number, topic, type and definition"),
            },
            Some(_) => {}
            None => self.damaged.add(offset, "a record without `op`"),
        }
    }
}

fn message<'a>(head: &[u8], data: &'a [u8]) -> Option<Item<'a>> {
    let time = field(head, "time")?;
    let (seconds, nanoseconds) = (word(time)?, word(time.get(4..)?)?);
    let logged_ns = u64::from(seconds) * STAMPS_NS + u64::from(nanoseconds);
    Some(Item::Message { connection: word(field(head, "conn")?)?, logged_ns, data })
}

fn connection<'a>(head: &'a [u8], data: &'a [u8]) -> Option<Item<'a>> {
    let topic = text(head, "topic").or_else(|| text(data, "topic"))?;
    Some(Item::Connection {
        id: word(field(head, "conn")?)?,
        topic,
        kind: text(data, "type")?,
        definition: field(data, "message_definition")?,
    })
}
