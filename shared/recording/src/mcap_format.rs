//! MCAP, the one recording format: every sample with its stamps, described by ROS 1 schemas.
//!
//! A message is the bytes of [`Stamps`] followed by those of the sample; log time = time of send,
//! publish time = time of measurement, sequence = low 32 bits of `seq`. Chunks are built in memory
//! and written whole (`disable_seeking`), so that a killed writer leaves complete chunks and at
//! most one cut record behind.

#[cfg(feature = "foreign")]
use crate::containers;
use crate::error::RecordingError;
#[cfg(feature = "foreign")]
use crate::foreign;
use crate::intake::Intake;
use crate::intake::join::applied;
use crate::intake::listing::ListedDataset;
use crate::mcap_read::{Entry, read_entries};
use crate::mcap_series::{read_imported, write_series_mcap};
use crate::run::RecordedRun;
use crate::schema::{schema_name, schema_text};
use crate::whole_file::replace;
use crate::{Format, Imported, file_name, listed};
use mcap::records::{MessageHeader, Metadata};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use telemetry::{Header, Stamps, TOPICS, TopicId};
use zerocopy::{FromBytes, IntoBytes};

/// The MCAP format.
pub struct Mcap;

impl Format for Mcap {
    fn name(&self) -> &'static str {
        "mcap"
    }

    fn sniff(&self, head: &[u8]) -> bool {
        // A file cut within the magic is still a truncated MCAP, not an unknown file.
        !head.is_empty()
            && (head.starts_with(mcap::MAGIC) || (head.len() < mcap::MAGIC.len() && mcap::MAGIC.starts_with(head)))
    }

    fn read(&self, path: &Path, intake: &Intake) -> Result<Imported, RecordingError> {
        // what is damaged beyond recognition is worded as obsid's own
        #[cfg(feature = "foreign")]
        if !foreign::is_own_mcap(path).unwrap_or(true) {
            return containers::read(foreign::mcap_datasets, path, intake).map_err(|error| of_damage(path, error));
        }
        applied(read_imported(path)?, intake)
    }

    fn list(&self, path: &Path, intake: &Intake) -> Result<Vec<ListedDataset>, RecordingError> {
        #[cfg(feature = "foreign")]
        if !foreign::is_own_mcap(path).unwrap_or(true) {
            return containers::list(foreign::mcap_datasets, path, intake);
        }
        #[cfg(not(feature = "foreign"))]
        let _ = intake;
        listed(read_imported(path)?)
    }

    fn write(&self, imported: &Imported, path: &Path) -> Result<(), RecordingError> {
        let not_writable = |what| RecordingError::NotWritable { file: file_name(path), format: self.name(), what };
        match imported {
            Imported::Run(run) => write_mcap(run, path),
            // The notes say by how much times were rounded; who wants them calls the function.
            Imported::Series(set) => write_series_mcap(&set.recording, path).map(|_| ()),
            Imported::Table(_) => Err(not_writable("a table")),
            Imported::Segments(_) => Err(not_writable("several recordings")),
            Imported::Spectrum(_) => Err(not_writable("a spectrum")),
        }
    }
}

/// The damage of a file that is cut before it says whose it is, rather than that nothing is in it.
#[cfg(feature = "foreign")]
fn of_damage(path: &Path, error: RecordingError) -> RecordingError {
    match (error, read_imported(path)) {
        (
            RecordingError::BadContainer { .. },
            Err(damage @ (RecordingError::McapTruncated { .. } | RecordingError::McapCorrupt { .. })),
        ) => damage,
        (error, _) => error,
    }
}

/// Writes a run as a complete file.
///
/// # Errors
/// The device's.
pub fn write_mcap(run: &RecordedRun, path: &Path) -> Result<(), RecordingError> {
    replace(path, |temporary| {
        let mut recorder = McapRecorder::create(temporary)?;
        recorder.path = path.into();
        for (name, values) in run.metadata() {
            recorder.metadata(name, values)?;
        }
        for attachment in run.attachments() {
            recorder.attach(&attachment.name, &attachment.media_type, &attachment.bytes)?;
        }
        for sample in run.samples() {
            recorder.write(sample.topic, sample.stamps, sample.payload)?;
        }
        recorder.finish()
    })
}

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

/// Writes samples to an MCAP file.
pub struct McapRecorder {
    path: PathBuf,
    writer: mcap::Writer<BufWriter<File>>,
    file: File,
    /// Channel of each topic, added with its first sample.
    channels: Vec<Option<u16>>,
    message: Vec<u8>,
}

impl McapRecorder {
    /// Starts a new file, replacing an old one.
    ///
    /// # Errors
    /// The device's.
    pub fn create(path: &Path) -> Result<Self, RecordingError> {
        let io = |source| RecordingError::Io { file: file_name(path), action: "create", reason: source };
        let file = File::create(path).map_err(io)?;
        let handle = file.try_clone().map_err(io)?;
        let writer = write_options()
            .create(BufWriter::with_capacity(1 << 16, file))
            .map_err(|error| write_error(path, error))?;
        Ok(McapRecorder {
            path: path.into(),
            writer,
            file: handle,
            channels: vec![None; TOPICS.len()],
            message: Vec::new(),
        })
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
        recorder.file.sync_all().map_err(io("write"))?;
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
        let channel_id = self.channel(topic)?;
        let (header, _) = Header::read_from_prefix(payload).expect("every sample begins with a header");
        self.message.clear();
        self.message.extend_from_slice(stamps.as_bytes());
        self.message.extend_from_slice(payload);
        let header = MessageHeader {
            channel_id,
            sequence: header.seq as u32,
            log_time: stamps.sent_ns,
            publish_time: header.t_meas_ns,
        };
        self.writer.write_to_known_channel(&header, &self.message).map_err(|error| write_error(&self.path, error))
    }

    fn channel(&mut self, topic: TopicId) -> Result<u16, RecordingError> {
        if let Some(channel) = self.channels[topic] {
            return Ok(channel);
        }
        let info = &TOPICS[topic];
        let facts = BTreeMap::from([("layout".to_string(), format!("{:#010x}", info.layout))]);
        let added = self
            .writer
            .add_schema(&schema_name(info), "ros1msg", schema_text(info).as_bytes())
            .and_then(|schema| self.writer.add_channel(schema, info.name, "ros1", &facts));
        let channel = added.map_err(|error| write_error(&self.path, error))?;
        self.channels[topic] = Some(channel);
        Ok(channel)
    }

    /// Writes a metadata record: names and values.
    ///
    /// # Errors
    /// The device's.
    pub fn metadata(&mut self, name: &str, values: &BTreeMap<String, String>) -> Result<(), RecordingError> {
        let record = Metadata { name: name.into(), metadata: values.clone() };
        self.writer.write_metadata(&record).map_err(|error| write_error(&self.path, error))
    }

    /// Puts a file into the recording.
    ///
    /// # Errors
    /// The device's.
    pub fn attach(&mut self, name: &str, media_type: &str, bytes: &[u8]) -> Result<(), RecordingError> {
        let data = Cow::Borrowed(bytes);
        // Times 0: the same run gives the same attachment whenever it is recorded.
        let attachment =
            mcap::Attachment { log_time: 0, create_time: 0, name: name.into(), media_type: media_type.into(), data };
        self.writer.attach(&attachment).map_err(|error| write_error(&self.path, error))
    }

    /// Completes the chunk and hands everything to the operating system: a writer killed after this
    /// loses nothing of it.
    ///
    /// # Errors
    /// The device's.
    pub fn flush(&mut self) -> Result<(), RecordingError> {
        self.writer.flush().map_err(|error| write_error(&self.path, error))
    }

    /// Writes the summary and closes the file, on the device when this returns.
    ///
    /// # Errors
    /// The device's.
    pub fn finish(mut self) -> Result<(), RecordingError> {
        self.writer.finish().map_err(|error| write_error(&self.path, error))?;
        let io = |source| RecordingError::Io { file: file_name(&self.path), action: "write", reason: source };
        self.writer.into_inner().flush().map_err(io)?;
        self.file.sync_all().map_err(io)
    }
}

/// Chunks are compressed by one thread and written whole: the same samples give the same bytes.
pub(crate) fn write_options() -> mcap::WriteOptions {
    mcap::WriteOptions::new()
        .profile("ros1")
        .library(concat!("obsid ", env!("CARGO_PKG_VERSION")))
        .disable_seeking(true)
        .compression(Some(mcap::Compression::Zstd))
        .compression_level(1)
        .compression_threads(0)
}

pub(crate) fn write_error(path: &Path, error: mcap::McapError) -> RecordingError {
    let source = match error {
        mcap::McapError::Io(source) => source,
        other => std::io::Error::other(other.to_string()),
    };
    RecordingError::Io { file: file_name(path), action: "write", reason: source }
}
