//! Writes samples of a run to an MCAP file, in memory that is taken when the file is made.
//!
//! Chunks are built in memory and written whole, so that a killed writer leaves complete chunks and
//! at most one cut record behind. The records are those that `mcap::Writer` makes, byte for byte (a
//! test compares); that one takes memory for every chunk, and grows with every chunk.

use crate::error::RecordingError;
use crate::file_name;
use crate::mcap_chunk::Chunk;
use crate::mcap_read::{Entry, read_entries};
use crate::mcap_records::Records;
use crate::mcap_summary::{Groups, write_summary};
use crate::schema::{schema_name, schema_text};
use mcap::records::{MessageHeader, op};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use telemetry::{Header, Stamps, TOPICS, TopicId, TopicInfo};
use zerocopy::{FromBytes, IntoBytes};

pub(crate) const PROFILE: &str = "ros1";
pub(crate) const LIBRARY: &str = concat!("obsid ", env!("CARGO_PKG_VERSION"));

/// What [`McapRecorder::recover`] found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recovered {
    pub kept: u64,
    /// Readable samples that `keep` did not want.
    pub dropped: u64,
    /// Readable samples whose CRC did not fit, left out.
    pub bad: u64,
    /// Byte at which the old file ended early; `None` when it was complete.
    pub damaged_at: Option<u64>,
}

/// A topic in the file.
struct Channel {
    schema: Records,
    channel: Records,
    /// Messages written; the records above stand before the first one.
    messages: u64,
}

impl Channel {
    fn new(topic: TopicId, info: &TopicInfo) -> Self {
        let id = channel_of(topic);
        let (mut schema, mut channel) = (Records::default(), Records::default());
        schema.record(op::SCHEMA, |schema| {
            schema.u16(id);
            schema.text(&schema_name(info));
            schema.text("ros1msg");
            schema.text(&schema_text(info));
        });
        channel.record(op::CHANNEL, |channel| {
            channel.u16(id);
            channel.u16(id);
            channel.text(info.name);
            channel.text("ros1");
            channel.texts(&BTreeMap::from([("layout".to_string(), format!("{:#010x}", info.layout))]));
        });
        Channel { schema, channel, messages: 0 }
    }
}

/// Number of a topic's channel and schema; schema 0 would be none.
fn channel_of(topic: TopicId) -> u16 {
    topic as u16 + 1
}

/// The file, its length and checksum so far.
struct Data {
    file: File,
    length: u64,
    crc: crc32fast::Hasher,
    /// A write failed: the file may end within a record, and nothing may stand behind it.
    failed: bool,
}

impl Data {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        if self.failed {
            return Err(io::Error::other("an earlier write has failed"));
        }
        self.file.write_all(bytes).inspect_err(|_| self.failed = true)?;
        self.crc.update(bytes);
        self.length += bytes.len() as u64;
        Ok(())
    }
}

/// Writes samples to an MCAP file.
pub struct McapRecorder {
    pub(crate) path: PathBuf,
    data: Data,
    chunk: Chunk,
    chunks: u32,
    /// By topic.
    channels: Vec<Channel>,
    /// Log times of the first and the last message.
    first_last: Option<(u64, u64)>,
    /// Records that stand outside of chunks.
    record: Records,
    attachments: (u32, Records),
    metadata: (u32, Records),
}

impl McapRecorder {
    /// Starts a new file, replacing an old one.
    ///
    /// # Errors
    /// The device's.
    pub fn create(path: &Path) -> Result<Self, RecordingError> {
        Self::begin(path).map_err(|reason| RecordingError::Io { file: file_name(path), action: "create", reason })
    }

    fn begin(path: &Path) -> io::Result<Self> {
        // Read when it ends, for the indexes of its chunks.
        let file = File::options().read(true).write(true).create(true).truncate(true).open(path)?;
        let channels: Vec<Channel> = TOPICS.iter().enumerate().map(|(id, info)| Channel::new(id, info)).collect();
        let declared = channels.iter().map(|channel| channel.schema.len() + channel.channel.len()).sum();
        let sizes = TOPICS.iter().map(|info| size_of::<Stamps>() + info.size);
        let message_bytes = (sizes.clone().min().unwrap_or(1), sizes.max().unwrap_or(1));
        let mut recorder = McapRecorder {
            path: path.into(),
            data: Data { file, length: 0, crc: crc32fast::Hasher::new(), failed: false },
            chunk: Chunk::new(message_bytes, TOPICS.len() as u16, declared)?,
            chunks: 0,
            channels,
            first_last: None,
            record: Records::default(),
            attachments: Default::default(),
            metadata: Default::default(),
        };
        recorder.data.write(mcap::MAGIC)?;
        recorder.record.record(op::HEADER, |header| {
            header.text(PROFILE);
            header.text(LIBRARY);
        });
        recorder.data.write(recorder.record.as_bytes())?;
        Ok(recorder)
    }

    /// Continues a recording whose writer was killed: copies the samples that are readable and that
    /// `keep` wants to a new file, puts it in the place of the old one, and goes on writing behind
    /// them. The old file stays untouched until the new one is complete on the device, so that
    /// recovering can itself be killed.
    ///
    /// # Errors
    /// The device's; a file of another program or of a build with other layouts.
    pub fn recover(
        path: &Path,
        mut keep: impl FnMut(TopicId, &Stamps, &[u8]) -> bool,
    ) -> Result<(Self, Recovered), RecordingError> {
        let mut temporary = path.as_os_str().to_owned();
        temporary.push(".recovering");
        let temporary = PathBuf::from(temporary);
        let mut recorder = Self::create(&temporary)?;
        let mut found = Recovered { kept: 0, dropped: 0, bad: 0, damaged_at: None };
        let damage = read_entries(path, &mut |entry| match entry {
            Entry::Sample(sample) if sample.check_crc(path).is_err() => {
                found.bad += 1;
                Ok(())
            }
            Entry::Sample(sample) if keep(sample.topic, &sample.stamps, sample.payload) => {
                found.kept += 1;
                recorder.write(sample.topic, &sample.stamps, sample.payload)
            }
            Entry::Sample(_) => {
                found.dropped += 1;
                Ok(())
            }
            Entry::Metadata(metadata) => recorder.metadata(&metadata.name, &metadata.metadata),
            Entry::Attachment(old) => recorder.attach(&old.name, &old.media_type, &old.bytes),
            Entry::ScalarChannel { name, .. } => {
                Err(RecordingError::NotARun { file: file_name(path), channel: name.into() })
            }
            // A channel stands before its samples and was rejected.
            Entry::Scalar { .. } => Ok(()),
        });
        let damage = damage.inspect_err(|_| {
            // The old file is whole; only the copy goes.
            let _ = std::fs::remove_file(&temporary);
        })?;
        found.damaged_at = damage.map(|damage| damage.offset);
        recorder.flush()?;
        let io = |action| move |source| RecordingError::Io { file: file_name(path), action, reason: source };
        recorder.data.file.sync_all().map_err(io("write"))?;
        std::fs::rename(&temporary, path).map_err(io("replace"))?;
        recorder.path = path.into();
        Ok((recorder, found))
    }

    /// Appends a sample; it is on its way to the file with the next full chunk or
    /// [`McapRecorder::flush`].
    ///
    /// # Errors
    /// A payload that is not of the topic's size; the device's.
    pub fn write(&mut self, topic: TopicId, stamps: &Stamps, payload: &[u8]) -> Result<(), RecordingError> {
        let info = &TOPICS[topic];
        if payload.len() != info.size {
            let topic = info.name.into();
            return Err(RecordingError::SampleSize { topic, found: payload.len(), expected: info.size });
        }
        let channel = &mut self.channels[topic];
        if channel.messages == 0 {
            self.chunk.add(channel.schema.as_bytes());
            self.chunk.add(channel.channel.as_bytes());
        }
        channel.messages += 1;
        if self.chunk.is_full() {
            self.flush()?;
        }
        let (header, _) = Header::read_from_prefix(payload).expect("every sample begins with a header");
        let sent_ns = stamps.sent_ns;
        let (first, last) = self.first_last.unwrap_or((sent_ns, sent_ns));
        self.first_last = Some((first.min(sent_ns), last.max(sent_ns)));
        let header = MessageHeader {
            channel_id: channel_of(topic),
            sequence: header.seq as u32,
            log_time: sent_ns,
            publish_time: header.t_meas_ns,
        };
        self.chunk.message(&header, [stamps.as_bytes(), payload]);
        Ok(())
    }

    /// Writes a metadata record: names and values.
    ///
    /// # Errors
    /// The device's.
    pub fn metadata(&mut self, name: &str, values: &BTreeMap<String, String>) -> Result<(), RecordingError> {
        self.flush()?;
        self.record.clear();
        self.record.record(op::METADATA, |metadata| {
            metadata.text(name);
            metadata.texts(values);
        });
        let (count, indexes) = &mut self.metadata;
        *count += 1;
        indexes.record(op::METADATA_INDEX, |index| {
            index.u64(self.data.length);
            index.u64(self.record.len() as u64);
            index.text(name);
        });
        self.data.write(self.record.as_bytes()).map_err(|reason| self.not_written(reason))
    }

    /// Puts a file into the recording.
    ///
    /// # Errors
    /// The device's.
    pub fn attach(&mut self, name: &str, media_type: &str, bytes: &[u8]) -> Result<(), RecordingError> {
        self.flush()?;
        self.record.clear();
        self.record.record(op::ATTACHMENT, |attachment| {
            let start = attachment.len();
            // Times of logging and creation 0: the same run gives the same attachment whenever it
            // is recorded.
            attachment.u64(0);
            attachment.u64(0);
            attachment.text(name);
            attachment.text(media_type);
            attachment.counted_u64(|attachment| attachment.bytes(bytes));
            attachment.u32(crc32fast::hash(&attachment.as_bytes()[start..]));
        });
        let (count, indexes) = &mut self.attachments;
        *count += 1;
        indexes.record(op::ATTACHMENT_INDEX, |index| {
            index.u64(self.data.length);
            index.u64(self.record.len() as u64);
            index.u64(0);
            index.u64(0);
            index.u64(bytes.len() as u64);
            index.text(name);
            index.text(media_type);
        });
        self.data.write(self.record.as_bytes()).map_err(|reason| self.not_written(reason))
    }

    /// Completes the chunk and hands everything to the operating system: a writer killed after this
    /// loses nothing of it.
    ///
    /// # Errors
    /// The device's.
    pub fn flush(&mut self) -> Result<(), RecordingError> {
        let written = self.chunk.complete().and_then(|chunk| {
            self.chunks += u32::from(!chunk.is_empty());
            self.data.write(chunk)
        });
        written.map_err(|reason| self.not_written(reason))
    }

    /// Writes the summary and closes the file, on the device when this returns. A recorder that is
    /// dropped without leaves its file as a killed one does.
    ///
    /// # Errors
    /// The device's.
    pub fn finish(mut self) -> Result<(), RecordingError> {
        self.flush()?;
        let groups = self.groups();
        let crc = self.data.crc.clone().finalize();
        let written = write_summary(&self.data.file, self.data.length, crc, &groups);
        written.and_then(|()| self.data.file.sync_all()).map_err(|reason| self.not_written(reason))
    }

    fn groups(&mut self) -> Groups {
        let used = || self.channels.iter().enumerate().filter(|(_, channel)| channel.messages > 0);
        let counts = used().map(|(topic, channel)| (channel_of(topic), channel.messages));
        let (first, last) = self.first_last.unwrap_or_default();
        let mut groups = Groups::default();
        for (_, channel) in used() {
            groups.schemas.bytes(channel.schema.as_bytes());
            groups.channels.bytes(channel.channel.as_bytes());
        }
        groups.statistics.record(op::STATISTICS, |statistics| {
            statistics.u64(counts.clone().map(|(_, messages)| messages).sum());
            statistics.u16(used().count() as u16);
            statistics.u32(used().count() as u32);
            statistics.u32(self.attachments.0);
            statistics.u32(self.metadata.0);
            statistics.u32(self.chunks);
            statistics.u64(first);
            statistics.u64(last);
            statistics.by_channel(counts.clone());
        });
        groups.attachments = core::mem::take(&mut self.attachments.1);
        groups.metadata = core::mem::take(&mut self.metadata.1);
        groups
    }

    fn not_written(&self, reason: io::Error) -> RecordingError {
        RecordingError::Io { file: file_name(&self.path), action: "write", reason }
    }
}

#[cfg(test)]
mod tests {
    use super::Data;

    #[test]
    fn nothing_is_written_behind_a_write_that_has_failed() {
        let path = std::env::temp_dir().join(format!("obsid-failed-{}.mcap", std::process::id()));
        std::fs::write(&path, "").unwrap();
        let read_only = std::fs::File::open(&path).unwrap();
        let mut data = Data { file: read_only, length: 0, crc: crc32fast::Hasher::new(), failed: false };
        assert!(data.write(b"refused").is_err());
        data.file = std::fs::File::create(&path).unwrap();
        assert_eq!(data.write(b"behind").unwrap_err().to_string(), "an earlier write has failed");
        assert_eq!((std::fs::read(&path).unwrap().len(), data.length), (0, 0));
        std::fs::remove_file(&path).unwrap();
    }
}
