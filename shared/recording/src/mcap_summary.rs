//! The end of an MCAP file: what is where in it, and how much of each.
//!
//! The indexes of chunks are read from the file itself when it ends: a recording of days takes no
//! memory for them.

use crate::mcap_records::{RECORD_HEADER, Records};
use mcap::records::op;
use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::FileExt;

/// Records of this many bytes are written at a time.
const PIECE: usize = 1 << 16;
/// Of a record, what [`ChunkAt`] is read from: the header and all fields of a chunk but its
/// records.
const HEAD: usize = RECORD_HEADER + 64;
/// Fields of a chunk before the name of its compression, which a count stands before.
const CHUNK_FIELDS: usize = 3 * size_of::<u64>() + size_of::<u32>();

/// Groups of records that were made while the file was written, in the order of the summary.
#[derive(Default)]
pub(crate) struct Groups {
    pub schemas: Records,
    pub channels: Records,
    pub statistics: Records,
    pub attachments: Records,
    pub metadata: Records,
}

/// A chunk and the indexes behind it, as the file has them.
struct ChunkAt {
    start: u64,
    bytes: u64,
    head: [u8; HEAD],
    indexes: Vec<(u16, u64)>,
    index_bytes: u64,
}

impl ChunkAt {
    fn append_to(&self, records: &mut Records) {
        let u64_at = |at: usize| {
            let mut bytes = [0; size_of::<u64>()];
            bytes.copy_from_slice(&self.head[at..at + size_of::<u64>()]);
            u64::from_le_bytes(bytes)
        };
        let fields = RECORD_HEADER;
        let name = fields + CHUNK_FIELDS;
        let name_end = name + size_of::<u32>() + usize::from(self.head[name]);
        records.record(op::CHUNK_INDEX, |index| {
            index.u64(u64_at(fields));
            index.u64(u64_at(fields + 8));
            index.u64(self.start);
            index.u64(self.bytes);
            index.by_channel(self.indexes.iter().copied());
            index.u64(self.index_bytes);
            index.bytes(&self.head[name..name_end]);
            index.u64(u64_at(name_end));
            index.u64(u64_at(fields + 16));
        });
    }
}

/// Hands an index of every chunk before byte `end` to `sink`, in the order of the file.
fn for_each_chunk(file: &File, end: u64, mut sink: impl FnMut(&ChunkAt) -> io::Result<()>) -> io::Result<()> {
    let mut chunk: Option<ChunkAt> = None;
    let mut at = mcap::MAGIC.len() as u64;
    while at < end {
        let mut head = [0; HEAD];
        let whole = end - at;
        file.read_exact_at(&mut head[..HEAD.min(whole as usize)], at)?;
        let mut length = [0; size_of::<u64>()];
        length.copy_from_slice(&head[1..RECORD_HEADER]);
        let bytes = RECORD_HEADER as u64 + u64::from_le_bytes(length);
        match (head[0], &mut chunk) {
            (op::MESSAGE_INDEX, Some(chunk)) => {
                chunk.indexes.push((u16::from_le_bytes([head[RECORD_HEADER], head[RECORD_HEADER + 1]]), at));
                chunk.index_bytes += bytes;
            }
            (opcode, known) => {
                known.take().map_or(Ok(()), |known| sink(&known))?;
                let found = ChunkAt { start: at, bytes, head, indexes: Vec::new(), index_bytes: 0 };
                chunk = (opcode == op::CHUNK).then_some(found);
            }
        }
        at += bytes;
    }
    chunk.map_or(Ok(()), |known| sink(&known))
}

/// Bytes on their way to the end of the file.
struct End<'a> {
    file: &'a File,
    at: u64,
    crc: crc32fast::Hasher,
}

impl End<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.crc.update(bytes);
        self.at += bytes.len() as u64;
        self.file.write_all(bytes)
    }
}

/// Writes everything behind the data, which ends at byte `end` and has the checksum `data_crc`.
pub(crate) fn write_summary(mut file: &File, end: u64, data_crc: u32, groups: &Groups) -> io::Result<()> {
    let mut records = Records::default();
    records.record(op::DATA_END, |record| record.u32(data_crc));
    file.write_all(records.as_bytes())?;
    let start = end + records.len() as u64;
    let mut summary = End { file, at: start, crc: crc32fast::Hasher::new() };
    let mut offsets = Records::default();
    let mut group_of = |opcode, begin: u64, at: u64| {
        if at > begin {
            offsets.record(op::SUMMARY_OFFSET, |offset| {
                offset.u8(opcode);
                offset.u64(begin);
                offset.u64(at - begin);
            });
        }
    };
    for (opcode, group) in
        [(op::SCHEMA, &groups.schemas), (op::CHANNEL, &groups.channels), (op::STATISTICS, &groups.statistics)]
    {
        let begin = summary.at;
        summary.write(group.as_bytes())?;
        group_of(opcode, begin, summary.at);
    }
    let begin = summary.at;
    records.clear();
    for_each_chunk(file, end, |chunk| {
        chunk.append_to(&mut records);
        if records.len() < PIECE {
            return Ok(());
        }
        summary.write(records.as_bytes())?;
        records.clear();
        Ok(())
    })?;
    summary.write(records.as_bytes())?;
    group_of(op::CHUNK_INDEX, begin, summary.at);
    for (opcode, group) in [(op::ATTACHMENT_INDEX, &groups.attachments), (op::METADATA_INDEX, &groups.metadata)] {
        let begin = summary.at;
        summary.write(group.as_bytes())?;
        group_of(opcode, begin, summary.at);
    }
    let offsets_start = summary.at;
    // The checksum covers the footer up to itself.
    offsets.u8(op::FOOTER);
    offsets.u64((2 * size_of::<u64>() + size_of::<u32>()) as u64);
    offsets.u64(start);
    offsets.u64(offsets_start);
    summary.write(offsets.as_bytes())?;
    let crc = summary.crc.clone().finalize();
    summary.write(&crc.to_le_bytes())?;
    summary.write(mcap::MAGIC)
}
