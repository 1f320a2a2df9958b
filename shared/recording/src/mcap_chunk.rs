//! A chunk of an MCAP file: messages, compressed together, and the index of each channel behind
//! them.
//!
//! All memory is taken in [`Chunk::new`] and serves every chunk of the file, zstd's context too:
//! a recorder that flies takes none. The size of a chunk is not given to zstd in advance, so that
//! its context has one size for all of them.

use crate::mcap_records::Records;
use mcap::records::{MessageHeader, op};
use std::io;
use zstd::stream::raw::{Encoder, InBuffer, Operation, OutBuffer};
use zstd::zstd_safe::compress_bound;

/// A chunk ends with the first message beyond.
const BYTES: usize = 1 << 20;
const COMPRESSION: &str = "zstd";
const LEVEL: i32 = 1;
/// Opcode, length and fields of a chunk before its records, and those of an index.
const HEADER_BYTES: usize = 64;
const INDEX_BYTES: usize = 16;

/// One message of the chunk.
struct Indexed {
    channel: u16,
    log_time: u64,
    /// From the beginning of the records, before compression.
    offset: u64,
}

/// What was written since the last chunk was completed.
pub(crate) struct Chunk {
    records: Records,
    messages: Vec<Indexed>,
    /// Of the messages' log times.
    first_last: Option<(u64, u64)>,
    /// Greatest number of a channel.
    channels: u16,
    encoder: Encoder<'static>,
    /// The last chunk as it stands in the file.
    whole: Records,
}

impl Chunk {
    /// With room for messages of `message_bytes` (smallest, largest; stamps included) on
    /// `channels`, whose schema and channel records have `declared_bytes` together.
    pub fn new(message_bytes: (usize, usize), channels: u16, declared_bytes: usize) -> io::Result<Self> {
        let records = BYTES + HEADER_BYTES + message_bytes.1 + declared_bytes;
        let mut encoder = Encoder::new(LEVEL)?;
        // zstd takes its memory with the first byte that it compresses
        compress(&mut encoder, &[0], &mut [0; HEADER_BYTES])?;
        let messages = records / message_bytes.0;
        let indexes = messages * INDEX_BYTES + usize::from(channels) * INDEX_BYTES;
        Ok(Chunk {
            records: Records::with_capacity(records),
            messages: Vec::with_capacity(messages),
            first_last: None,
            channels,
            encoder,
            whole: Records::with_capacity(HEADER_BYTES + compress_bound(records) + indexes),
        })
    }

    /// The next message belongs in another chunk.
    pub fn is_full(&self) -> bool {
        self.records.len() > BYTES
    }

    /// Adds records as they are.
    pub fn add(&mut self, records: &[u8]) {
        self.records.bytes(records);
    }

    pub fn message(&mut self, header: &MessageHeader, data: [&[u8]; 2]) {
        let (channel, log_time) = (header.channel_id, header.log_time);
        let (first, last) = self.first_last.unwrap_or((log_time, log_time));
        self.first_last = Some((first.min(log_time), last.max(log_time)));
        self.messages.push(Indexed { channel, log_time, offset: self.records.len() as u64 });
        self.records.record(op::MESSAGE, |record| {
            record.u16(channel);
            record.u32(header.sequence);
            record.u64(log_time);
            record.u64(header.publish_time);
            data.into_iter().for_each(|part| record.bytes(part));
        });
    }

    /// Chunk and indexes for the file; the next chunk begins. Nothing where nothing was added.
    pub fn complete(&mut self) -> io::Result<&[u8]> {
        self.whole.clear();
        if self.records.len() == 0 {
            return Ok(self.whole.as_bytes());
        }
        let (records, encoder) = (self.records.as_bytes(), &mut self.encoder);
        let (first, last) = self.first_last.take().unwrap_or_default();
        let mut compressed = Ok(());
        self.whole.record(op::CHUNK, |chunk| {
            chunk.u64(first);
            chunk.u64(last);
            chunk.u64(records.len() as u64);
            chunk.u32(crc32fast::hash(records));
            chunk.text(COMPRESSION);
            chunk.counted_u64(|chunk| {
                compressed = chunk.fill(compress_bound(records.len()), |room| compress(encoder, records, room));
            });
        });
        compressed?;
        for channel in 0..=self.channels {
            let own = self.messages.iter().filter(|message| message.channel == channel);
            let count = own.clone().count();
            if count == 0 {
                continue;
            }
            self.whole.record(op::MESSAGE_INDEX, |index| {
                index.u16(channel);
                index.u32((count * 2 * size_of::<u64>()) as u32);
                own.for_each(|message| {
                    index.u64(message.log_time);
                    index.u64(message.offset);
                });
            });
        }
        self.records.clear();
        self.messages.clear();
        Ok(self.whole.as_bytes())
    }
}

/// One frame of zstd; `room` is as large as the worst case. Returns its length.
fn compress(encoder: &mut Encoder<'static>, records: &[u8], room: &mut [u8]) -> io::Result<usize> {
    let bytes = room.len();
    let (mut input, mut output) = (InBuffer::around(records), OutBuffer::around(room));
    encoder.reinit()?;
    while input.pos() < records.len() {
        encoder.run(&mut input, &mut output)?;
    }
    while encoder.finish(&mut output, true)? > 0 {
        if output.pos() == bytes {
            return Err(io::Error::other("a compressed chunk is larger than zstd's bound"));
        }
    }
    Ok(output.pos())
}
