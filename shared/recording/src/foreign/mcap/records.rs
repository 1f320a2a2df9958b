//! The records of an MCAP file, one by one. A chunk that is damaged is left out; behind a record
//! that is cut nothing is read.

use super::super::damaged::Damaged;
use super::super::input::Input;
use crate::error::RecordingError;
use crate::file_name;
use core::ops::ControlFlow;
use mcap::records::{Record, op};
use std::path::Path;
use telemetry::crc32;

/// A record that says something about samples.
pub(super) enum Item<'a> {
    Header { library: String },
    Schema { id: u16, name: String, encoding: String, text: &'a [u8] },
    Channel { id: u16, topic: String, schema_id: u16, encoding: String },
    Message { channel: u16, logged_ns: u64, data: &'a [u8] },
}

type Visitor<'v> = &'v mut dyn FnMut(Item<'_>) -> ControlFlow<()>;

/// Opcode and length.
const RECORD_HEADER: usize = 9;

/// Visits the records of a file until the visitor breaks; gives notes on what is missing.
///
/// # Errors
/// A file that is no MCAP; the device's.
pub(super) fn walk(path: &Path, visit: Visitor<'_>) -> Result<Vec<String>, RecordingError> {
    let mut input = Input::open(path)?;
    if input.take(mcap::MAGIC.len() as u64)?.as_deref() != Some(mcap::MAGIC) {
        return Err(RecordingError::BadContainer {
            file: file_name(path),
            place: "byte 0".into(),
            found: "the file does not begin as an MCAP file does".into(),
            cure: "check the path, or copy the file again".into(),
        });
    }
    let mut walk = Walk { damaged: Damaged::new(input.size), visit };
    let mut notes = Vec::new();
    let mut crc = crc32fast::Hasher::new();
    crc.update(mcap::MAGIC);
    loop {
        let start = input.offset;
        let cut = |notes: &mut Vec<String>, size| {
            notes.push(format!("the file is cut at byte {start} of {size}: what lies before it is read"));
        };
        let Some(head) = input.take(RECORD_HEADER as u64)? else {
            cut(&mut notes, input.size);
            break;
        };
        let (opcode, length) = opcode_and_length(&head);
        if opcode == op::FOOTER {
            break;
        }
        let Some(body) = input.take(length)? else {
            cut(&mut notes, input.size);
            break;
        };
        if opcode == op::DATA_END {
            let stored = body.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
            if stored != 0 && stored != crc.clone().finalize() {
                notes.push("the data do not have the CRC that the file states: numbers may be damaged".into());
            }
        }
        crc.update(&head);
        crc.update(&body);
        if walk.top(opcode, &body, start).is_break() {
            break;
        }
    }
    notes.extend(walk.damaged.note());
    Ok(notes)
}

fn opcode_and_length(head: &[u8]) -> (u8, u64) {
    let mut length = [0; RECORD_HEADER - 1];
    length.copy_from_slice(&head[1..RECORD_HEADER]);
    (head[0], u64::from_le_bytes(length))
}

/// Attachments and indexes say nothing about samples that the data do not say.
fn is_read(opcode: u8) -> bool {
    matches!(opcode, op::HEADER | op::SCHEMA | op::CHANNEL | op::MESSAGE)
}

struct Walk<'v> {
    damaged: Damaged,
    visit: Visitor<'v>,
}

impl Walk<'_> {
    fn top(&mut self, opcode: u8, body: &[u8], offset: u64) -> ControlFlow<()> {
        if opcode == op::CHUNK { self.chunk(body, offset) } else { self.record(opcode, body, offset) }
    }

    fn chunk(&mut self, body: &[u8], offset: u64) -> ControlFlow<()> {
        let (header, data) = match mcap::parse_record(op::CHUNK, body) {
            Ok(Record::Chunk { header, data }) => (header, data),
            Ok(_) => return ControlFlow::Continue(()),
            Err(error) => {
                self.damaged.add(offset, &error.to_string());
                return ControlFlow::Continue(());
            }
        };
        let content = match self.damaged.budget.unpack(&header.compression, &data, header.uncompressed_size) {
            Ok(content) => content,
            Err(reason) => {
                self.damaged.add(offset, &reason);
                return ControlFlow::Continue(());
            }
        };
        if header.uncompressed_crc != 0 && header.uncompressed_crc != crc32(&content) {
            self.damaged.add(offset, "the chunk does not have the CRC it states");
            return ControlFlow::Continue(());
        }
        self.content(&content, offset)
    }

    fn content(&mut self, mut rest: &[u8], offset: u64) -> ControlFlow<()> {
        while let Some((head, behind)) = rest.split_at_checked(RECORD_HEADER) {
            let (opcode, length) = opcode_and_length(head);
            let split = usize::try_from(length).ok().and_then(|length| behind.split_at_checked(length));
            let Some((body, behind)) = split else { break };
            self.record(opcode, body, offset)?;
            rest = behind;
        }
        if !rest.is_empty() {
            self.damaged.add(offset, "the chunk ends inside a record");
        }
        ControlFlow::Continue(())
    }

    fn record(&mut self, opcode: u8, body: &[u8], offset: u64) -> ControlFlow<()> {
        if !is_read(opcode) {
            return ControlFlow::Continue(());
        }
        match mcap::parse_record(opcode, body) {
            Ok(Record::Header(header)) => (self.visit)(Item::Header { library: header.library }),
            Ok(Record::Schema { header, data }) => {
                (self.visit)(Item::Schema { id: header.id, name: header.name, encoding: header.encoding, text: &data })
            }
            Ok(Record::Channel(channel)) => (self.visit)(Item::Channel {
                id: channel.id,
                topic: channel.topic,
                schema_id: channel.schema_id,
                encoding: channel.message_encoding,
            }),
            Ok(Record::Message { header, data }) => {
                (self.visit)(Item::Message { channel: header.channel_id, logged_ns: header.log_time, data: &data })
            }
            Ok(_) => ControlFlow::Continue(()),
            Err(error) => {
                self.damaged.add(offset, &error.to_string());
                ControlFlow::Continue(())
            }
        }
    }
}
