//! Reading MCAP: record by record, chunk by chunk, nothing believed before its CRC was computed.
//!
//! The records of the file level are walked here rather than by `mcap::LinearReader`, because an
//! operator wants the byte offset of the damage, and because lengths found in a damaged file must
//! be bounded by the file's size before memory is taken. Chunks are decompressed by `mcap` with
//! their CRC checked before a sample leaves them: a chunk is readable as a whole or not at all.
//!
//! Why not `mcap::parse_record` for attachments? It panics on a body of 32 to 35 bytes (0.26.0).

use crate::error::RecordingError;
use crate::file_name;
use crate::mcap_channels::{Carried, FileChannels};
use crate::run::Attachment;
use crate::schema::UNIT;
use crc32fast::Hasher;
use mcap::records::{MessageHeader, Metadata, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use telemetry::{Stamps, TOPICS, TopicId, crc32};
use zerocopy::FromBytes;

/// Bound on an uncompressed chunk; obsid writes 1 MiB, other programs up to some tens.
const CHUNK_MAX: usize = 256 << 20;
const RECORD_HEADER: usize = 9;
const STAMPS: usize = size_of::<Stamps>();

/// A sample before its stamps were believed.
pub(crate) struct RawSample<'a> {
    pub topic: TopicId,
    pub stamps: Stamps,
    pub payload: &'a [u8],
}

impl RawSample<'_> {
    /// Compares the CRC-32 of the payload with the recorded one.
    ///
    /// # Errors
    /// The sample whose payload differs, with both checksums.
    pub fn check_crc(&self, path: &Path) -> Result<(), RecordingError> {
        let computed = crc32(self.payload);
        if computed == self.stamps.crc32 {
            return Ok(());
        }
        let mut seq = [0; 8];
        seq.copy_from_slice(&self.payload[8..16]);
        Err(RecordingError::SampleCrc {
            file: file_name(path),
            topic: TOPICS[self.topic].name,
            seq: u64::from_le_bytes(seq),
            computed,
            stamped: self.stamps.crc32,
        })
    }
}

/// What a recording is made of.
pub(crate) enum Entry<'a> {
    Sample(RawSample<'a>),
    /// A scalar channel; its number is the file's and unique in it. May be said more than once.
    ScalarChannel {
        channel: u16,
        name: &'a str,
        unit: &'a str,
    },
    Scalar {
        channel: u16,
        t_ns: u64,
        value: f64,
    },
    Metadata(Metadata),
    Attachment(Attachment),
}

/// Why the walk ended before the end of a complete file.
#[derive(Debug)]
pub(crate) struct Damage {
    pub offset: u64,
    pub readable: u64,
    truncated: bool,
    reason: String,
}

impl Damage {
    /// The error for a file at `path`: truncated where it ends early, corrupt otherwise.
    pub fn into_error(self, path: &Path) -> RecordingError {
        let Damage { offset, readable, truncated, reason } = self;
        let file = file_name(path);
        if truncated {
            RecordingError::McapTruncated { file, offset, readable, reason }
        } else {
            RecordingError::McapCorrupt { file, offset, readable, reason }
        }
    }
}

/// A stop: damage (the walk ends, what was read stands) or an error that makes the whole file
/// unreadable.
enum Stop {
    Truncated(String),
    Corrupt(String),
    Error(RecordingError),
}

impl From<RecordingError> for Stop {
    fn from(error: RecordingError) -> Self {
        Stop::Error(error)
    }
}

impl From<mcap::McapError> for Stop {
    fn from(error: mcap::McapError) -> Self {
        Stop::Corrupt(error.to_string())
    }
}

type Visitor<'v> = &'v mut dyn FnMut(Entry<'_>) -> Result<(), RecordingError>;

/// Walks a file; `Ok(Some(damage))` when it ends early or is corrupt behind the entries that were
/// visited.
pub(crate) fn read_entries(path: &Path, visit: Visitor<'_>) -> Result<Option<Damage>, RecordingError> {
    let io = |action| move |source| RecordingError::Io { file: file_name(path), action, reason: source };
    let file = File::open(path).map_err(io("open"))?;
    let size = file.metadata().map_err(io("read"))?.len();
    let mut walk = Walk {
        path,
        input: BufReader::with_capacity(1 << 16, file),
        offset: 0,
        size,
        crc: Hasher::new(),
        channels: FileChannels::default(),
        readable: 0,
    };
    let damage =
        |walk: &Walk<'_>, offset, truncated, reason| Damage { offset, readable: walk.readable, truncated, reason };
    loop {
        let start = walk.offset;
        let step = walk.step(visit);
        if !matches!(step, Ok(true)) {
            walk.channels.check(file_name(path))?;
        }
        match step {
            Ok(true) => {}
            Ok(false) => return Ok(None),
            Err(Stop::Truncated(reason)) => return Ok(Some(damage(&walk, start, true, reason))),
            Err(Stop::Corrupt(reason)) => return Ok(Some(damage(&walk, start, false, reason))),
            Err(Stop::Error(error)) => return Err(error),
        }
    }
}

struct Walk<'p> {
    path: &'p Path,
    input: BufReader<File>,
    offset: u64,
    size: u64,
    /// Over the data section, then over the summary section.
    crc: Hasher,
    channels: FileChannels,
    readable: u64,
}

impl Walk<'_> {
    /// Takes `length` bytes; their number is checked against the file before memory is taken.
    fn take(&mut self, length: u64, what: &str) -> Result<Vec<u8>, Stop> {
        let left = self.size - self.offset;
        if length > left {
            return Err(Stop::Truncated(format!("{what} needs {length} bytes, {left} are left")));
        }
        let mut bytes = vec![0; usize::try_from(length).map_err(|_| Stop::Corrupt(format!("{what} is too long")))?];
        self.input.read_exact(&mut bytes).map_err(|source| RecordingError::Io {
            file: file_name(self.path),
            action: "read",
            reason: source,
        })?;
        self.offset += length;
        Ok(bytes)
    }

    /// One record of the file level; `false` behind the end of a complete file.
    fn step(&mut self, visit: Visitor<'_>) -> Result<bool, Stop> {
        if self.offset == 0 {
            let magic = self.take(mcap::MAGIC.len() as u64, "the magic")?;
            if magic != mcap::MAGIC {
                return Err(Stop::Corrupt("the magic bytes are wrong".into()));
            }
            self.crc.update(&magic);
            return Ok(true);
        }
        if self.offset == self.size {
            return Err(Stop::Truncated("the end record is missing: the writer was stopped".into()));
        }
        let head = self.take(RECORD_HEADER as u64, "a record header")?;
        let mut length = [0; 8];
        length.copy_from_slice(&head[1..]);
        let length = u64::from_le_bytes(length);
        if head[0] == op::CHUNK && self.channels.is_unreadable() {
            return self.skip(length).map(|()| true);
        }
        let body = self.take(length, "a record")?;
        match head[0] {
            op::FOOTER if self.channels.is_unreadable() => return Ok(false),
            op::DATA_END if self.channels.is_unreadable() => {}
            op::FOOTER => return self.footer(&head, &body).map(|()| false),
            op::DATA_END => self.data_end(&head, &body)?,
            opcode => {
                self.crc.update(&head);
                self.crc.update(&body);
                match opcode {
                    op::CHUNK => self.chunk(&head, &body, visit)?,
                    _ => self.record(opcode, &body, visit)?,
                }
            }
        }
        Ok(true)
    }

    fn skip(&mut self, length: u64) -> Result<(), Stop> {
        let left = self.size - self.offset;
        let (true, Ok(step)) = (length <= left, i64::try_from(length)) else {
            return Err(Stop::Truncated(format!("a chunk needs {length} bytes, {left} are left")));
        };
        self.input.seek_relative(step).map_err(|source| RecordingError::Io {
            file: file_name(self.path),
            action: "read",
            reason: source,
        })?;
        self.offset += length;
        Ok(())
    }

    fn data_end(&mut self, head: &[u8], body: &[u8]) -> Result<(), Stop> {
        let computed = core::mem::take(&mut self.crc).finalize();
        let stored = body.first_chunk().map(|bytes| u32::from_le_bytes(*bytes));
        match stored {
            None => return Err(Stop::Corrupt("the end of the data carries no CRC".into())),
            Some(stored) if stored != 0 && stored != computed => {
                return Err(Stop::Corrupt(format!("CRC of the data is {computed:#010x}, stored {stored:#010x}")));
            }
            // The summary begins behind this record.
            Some(_) => debug_assert_eq!(head[0], op::DATA_END),
        }
        Ok(())
    }

    fn footer(&mut self, head: &[u8], body: &[u8]) -> Result<(), Stop> {
        let Some((covered, stored)) = body.split_at_checked(16) else {
            return Err(Stop::Corrupt("the footer is too short".into()));
        };
        self.crc.update(head);
        self.crc.update(covered);
        let computed = core::mem::take(&mut self.crc).finalize();
        let stored = stored.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
        if stored != 0 && stored != computed {
            return Err(Stop::Corrupt(format!("CRC of the summary is {computed:#010x}, stored {stored:#010x}")));
        }
        if self.take(mcap::MAGIC.len() as u64, "the closing magic")? != mcap::MAGIC {
            return Err(Stop::Corrupt("the closing magic bytes are wrong".into()));
        }
        match self.size - self.offset {
            0 => Ok(()),
            more => Err(Stop::Corrupt(format!("{more} bytes behind the end"))),
        }
    }

    fn chunk(&mut self, head: &[u8], body: &[u8], visit: Visitor<'_>) -> Result<(), Stop> {
        let Record::Chunk { header, data } = mcap::parse_record(op::CHUNK, body)? else {
            return Err(Stop::Corrupt("a chunk is none".into()));
        };
        match header.compression.as_str() {
            "" => {
                let computed = crc32(&data);
                if header.uncompressed_crc != 0 && header.uncompressed_crc != computed {
                    return Err(Stop::Corrupt(format!("chunk CRC is {computed:#010x}")));
                }
                self.plain_chunk(&data, visit)
            }
            "zstd" => self.zstd_chunk(head, body, visit),
            other => {
                self.channels.compressed_by(other);
                Ok(())
            }
        }
    }

    fn plain_chunk(&mut self, mut data: &[u8], visit: Visitor<'_>) -> Result<(), Stop> {
        while let Some((head, rest)) = data.split_at_checked(RECORD_HEADER) {
            let mut length = [0; 8];
            length.copy_from_slice(&head[1..]);
            let length = usize::try_from(u64::from_le_bytes(length)).unwrap_or(usize::MAX);
            let Some((body, behind)) = rest.split_at_checked(length) else { break };
            self.record(head[0], body, visit)?;
            data = behind;
        }
        if data.is_empty() { Ok(()) } else { Err(Stop::Corrupt("a chunk ends inside a record".into())) }
    }

    fn zstd_chunk(&mut self, head: &[u8], body: &[u8], visit: Visitor<'_>) -> Result<(), Stop> {
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(CHUNK_MAX);
        let mut reader = LinearReader::new_with_options(options);
        let mut source = head.chain(body);
        while let Some(event) = reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(need) => {
                    // A request beyond the chunk is a damaged length; the reader sees the end
                    // instead.
                    let need = need.min(head.len() + body.len());
                    let got = source.read(reader.insert(need)).map_err(|error| Stop::Corrupt(error.to_string()))?;
                    reader.notify_read(got);
                }
                LinearReadEvent::Record { opcode, data } => self.record(opcode, data, visit)?,
            }
        }
        Ok(())
    }

    /// A record inside or outside a chunk. Indexes and statistics repeat what the data say and are
    /// not needed.
    fn record(&mut self, opcode: u8, body: &[u8], visit: Visitor<'_>) -> Result<(), Stop> {
        match opcode {
            op::ATTACHMENT => Ok(visit(Entry::Attachment(parse_attachment(body)?))?),
            op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA => match mcap::parse_record(opcode, body)? {
                Record::Schema { header, .. } => {
                    self.channels.schema(header.id, header.name, header.encoding);
                    Ok(())
                }
                Record::Channel(channel) => self.channel(&channel, visit),
                Record::Message { header, data } => self.message(&header, &data, visit),
                Record::Metadata(metadata) => Ok(visit(Entry::Metadata(metadata))?),
                _ => Err(Stop::Corrupt("a record is not of its kind".into())),
            },
            _ => Ok(()),
        }
    }

    fn channel(&mut self, channel: &mcap::records::Channel, visit: Visitor<'_>) -> Result<(), Stop> {
        if self.channels.add(channel) == Carried::Scalar {
            let name = channel.topic.strip_prefix('/').unwrap_or(&channel.topic);
            let unit = channel.metadata.get(UNIT).map_or("", String::as_str);
            visit(Entry::ScalarChannel { channel: channel.id, name, unit })?;
        }
        Ok(())
    }

    fn message(&mut self, header: &MessageHeader, data: &[u8], visit: Visitor<'_>) -> Result<(), Stop> {
        if self.channels.is_unreadable() {
            return Ok(());
        }
        let channel = header.channel_id;
        match self.channels.carried(channel) {
            Some(Carried::Topic(topic)) => self.sample(topic, data, visit)?,
            Some(Carried::Foreign) => return Ok(()),
            Some(Carried::Scalar) => {
                let value: [u8; 8] = data
                    .try_into()
                    .map_err(|_| Stop::Corrupt(format!("a message of a scalar channel with {} bytes", data.len())))?;
                visit(Entry::Scalar { channel, t_ns: header.publish_time, value: f64::from_le_bytes(value) })?;
            }
            None => return Err(Stop::Corrupt(format!("a message of the unknown channel {channel}"))),
        }
        self.readable += 1;
        Ok(())
    }

    fn sample(&self, topic: TopicId, data: &[u8], visit: Visitor<'_>) -> Result<(), Stop> {
        let info = &TOPICS[topic];
        let short = || Stop::Corrupt(format!("a message of `{}` with {} bytes", info.name, data.len()));
        let (stamps, payload) = data.split_at_checked(STAMPS).ok_or_else(short)?;
        let stamps = Stamps::read_from_bytes(stamps).map_err(|_| short())?;
        let recorded = payload.first_chunk().map(|bytes| u32::from_le_bytes(*bytes)).ok_or_else(short)?;
        if recorded != info.layout {
            return Err(Stop::Error(RecordingError::LayoutMismatch {
                file: file_name(self.path),
                topic: info.name.into(),
                recorded,
                build: info.layout,
            }));
        }
        if payload.len() != info.size {
            return Err(short());
        }
        Ok(visit(Entry::Sample(RawSample { topic, stamps, payload }))?)
    }
}

/// Log time, create time, name, media type, data, each with its length, then a CRC-32 of all that.
fn parse_attachment(body: &[u8]) -> Result<Attachment, Stop> {
    fn split<'a>(rest: &mut &'a [u8], length: usize) -> Option<&'a [u8]> {
        let (first, behind) = rest.split_at_checked(length)?;
        *rest = behind;
        Some(first)
    }
    fn text(rest: &mut &[u8]) -> Option<String> {
        let length = u32::from_le_bytes(*split(rest, 4)?.first_chunk()?);
        String::from_utf8(split(rest, length as usize)?.to_vec()).ok()
    }
    let parse = || {
        let mut rest = body;
        split(&mut rest, 16)?;
        let name = text(&mut rest)?;
        let media_type = text(&mut rest)?;
        let length = u64::from_le_bytes(*split(&mut rest, 8)?.first_chunk()?);
        let bytes = split(&mut rest, usize::try_from(length).ok()?)?.to_vec();
        let crc = u32::from_le_bytes(rest.try_into().ok()?);
        (crc == 0 || crc == crc32(&body[..body.len() - 4])).then_some(Attachment { name, media_type, bytes })
    };
    parse().ok_or_else(|| Stop::Corrupt("an attachment is damaged".into()))
}
