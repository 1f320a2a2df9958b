//! A recorded run in memory: samples in the order of the file, metadata, attachments.

use crate::error::RecordingError;
use crate::file_name;
use crate::mcap_read::{Entry, read_entries};
use std::collections::BTreeMap;
use std::path::Path;
use telemetry::{Sample, Stamps, TOPICS, Topic, TopicId};
use zerocopy::IntoBytes;

/// One sample as it was recorded.
#[derive(Clone, Copy, Debug)]
pub struct RecordedSample<'a> {
    pub topic: TopicId,
    pub stamps: &'a Stamps,
    /// Bytes of the sample, aligned to 8.
    pub payload: &'a [u8],
}

impl<'a> RecordedSample<'a> {
    /// The sample as its type; `None` for another topic.
    #[must_use]
    pub fn get<T: Sample>(&self, topic: Topic<T>) -> Option<&'a T> {
        if self.topic == topic.id { T::ref_from_bytes(self.payload).ok() } else { None }
    }
}

/// A file that travels inside a recording, e.g. the scenario.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attachment {
    pub name: String,
    pub media_type: String,
    pub bytes: Vec<u8>,
}

struct Index {
    topic: TopicId,
    stamps: Stamps,
    /// First word of the payload in the arena.
    start: usize,
}

/// A recorded run.
#[derive(Default)]
pub struct RecordedRun {
    file: String,
    index: Vec<Index>,
    /// Payloads one after the other; words keep them aligned without unsafe code.
    arena: Vec<u64>,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
    attachments: Vec<Attachment>,
}

impl core::fmt::Debug for RecordedRun {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "RecordedRun({}, {} samples)", self.file, self.index.len())
    }
}

impl RecordedRun {
    /// An empty run, to be filled in memory.
    #[must_use]
    pub fn new(file: &str) -> Self {
        RecordedRun { file: file.into(), ..Self::default() }
    }

    /// Name of the file, for messages.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Samples of all topics together.
    #[must_use]
    pub fn len(&self) -> usize {
        self.index.len()
    }

    /// Whether the run holds no sample of any topic.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.index.is_empty()
    }

    /// Records by name, each a map of names to values.
    #[must_use]
    pub fn metadata(&self) -> &BTreeMap<String, BTreeMap<String, String>> {
        &self.metadata
    }

    /// Files attached to the recording, in their order.
    #[must_use]
    pub fn attachments(&self) -> &[Attachment] {
        &self.attachments
    }

    /// All samples in the order of the file.
    pub fn samples(&self) -> impl Iterator<Item = RecordedSample<'_>> {
        self.index.iter().map(|entry| {
            let words = TOPICS[entry.topic].size / 8;
            let payload = self.arena[entry.start..entry.start + words].as_bytes();
            RecordedSample { topic: entry.topic, stamps: &entry.stamps, payload }
        })
    }

    /// The samples of one topic.
    pub fn of<T: Sample>(&self, topic: Topic<T>) -> impl Iterator<Item = (&Stamps, &T)> {
        self.samples().filter_map(move |sample| Some((sample.stamps, sample.get(topic)?)))
    }

    /// Appends a sample.
    ///
    /// # Errors
    /// [`RecordingError::SampleSize`].
    pub fn push(&mut self, topic: TopicId, stamps: &Stamps, payload: &[u8]) -> Result<(), RecordingError> {
        let size = TOPICS[topic].size;
        if payload.len() != size {
            let topic = TOPICS[topic].name.into();
            return Err(RecordingError::SampleSize { topic, found: payload.len(), expected: size });
        }
        let start = self.arena.len();
        self.arena.resize(start + size / 8, 0);
        self.arena[start..].as_mut_bytes().copy_from_slice(payload);
        self.index.push(Index { topic, stamps: *stamps, start });
        Ok(())
    }

    /// Takes what the file at `path` is made of, of its samples the topics asked for.
    pub(crate) fn take(
        &mut self,
        path: &Path,
        entry: Entry<'_>,
        keep: &dyn Fn(TopicId) -> bool,
    ) -> Result<(), RecordingError> {
        match entry {
            Entry::Sample(sample) => {
                sample.check_crc(path)?;
                if keep(sample.topic) { self.push(sample.topic, &sample.stamps, sample.payload) } else { Ok(()) }
            }
            Entry::Metadata(metadata) => {
                self.metadata.entry(metadata.name).or_default().extend(metadata.metadata);
                Ok(())
            }
            Entry::Attachment(attachment) => {
                self.attachments.push(attachment);
                Ok(())
            }
            Entry::ScalarChannel { name, .. } => {
                Err(RecordingError::NotARun { file: file_name(path), channel: name.into() })
            }
            // A channel stands before its samples and was rejected.
            Entry::Scalar { .. } => Ok(()),
        }
    }
}

/// Reads a complete MCAP file of obsid.
///
/// # Errors
/// A truncated or corrupt file (with byte offset and the number of readable samples), a file of
/// another program, a file of a build with other layouts, a sample whose CRC does not fit.
pub fn read_mcap(path: &Path) -> Result<RecordedRun, RecordingError> {
    read_mcap_topics(path, |_| true)
}

/// As [`read_mcap`], keeping only the topics asked for: the way to read a long run in little
/// memory.
///
/// # Errors
/// As [`read_mcap`]; topics that are left out are checked all the same.
pub fn read_mcap_topics(path: &Path, keep: impl Fn(TopicId) -> bool) -> Result<RecordedRun, RecordingError> {
    let mut run = RecordedRun::new(&file_name(path));
    let damage = read_entries(path, &mut |entry| run.take(path, entry, &keep))?;
    match damage {
        None => Ok(run),
        Some(damage) => Err(damage.into_error(path)),
    }
}
