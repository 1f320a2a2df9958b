//! The channels of an MCAP file: telemetry of a run, scalars of a plant, or another program's.
//!
//! One foreign channel makes the file foreign: its samples are then not read, but its channels are
//! collected to the end, so that the error names them.

use crate::error::RecordingError;
use crate::schema::{SCALAR_NAME, schema_name};
use mcap::records::Channel;
use std::collections::BTreeMap;
use telemetry::{TOPICS, TopicId, topic_named};

/// What a channel carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Carried {
    Topic(TopicId),
    Scalar,
    Foreign,
}

struct Foreign {
    topic: String,
    encoding: String,
    schema: String,
}

/// Names of channels said in an error.
const CHANNELS_NAMED_MAX: usize = 12;

/// Channels and schemas by their numbers in the file.
#[derive(Default)]
pub(crate) struct FileChannels {
    schemas: BTreeMap<u16, (String, String)>,
    carried: BTreeMap<u16, Carried>,
    foreign: BTreeMap<u16, Foreign>,
    /// A compression of chunks that is not read.
    compression: Option<String>,
}

impl FileChannels {
    /// Keeps the name and encoding of a schema record.
    pub fn schema(&mut self, id: u16, name: String, encoding: String) {
        self.schemas.insert(id, (name, encoding));
    }

    /// Notes a compression of chunks that is not read, for the error of a file without readable
    /// samples.
    pub fn compressed_by(&mut self, compression: &str) {
        self.compression = Some(compression.into());
    }

    /// Keeps a channel record and decides by its schema and encodings what it carries.
    pub fn add(&mut self, channel: &Channel) -> Carried {
        let (schema, schema_encoding) = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
        let is_ros1 = channel.message_encoding == "ros1" && schema_encoding == "ros1msg";
        let topic = topic_named(&channel.topic).filter(|topic| schema == schema_name(&TOPICS[*topic]));
        let carried = match topic {
            Some(topic) if is_ros1 => Carried::Topic(topic),
            _ if is_ros1 && schema == SCALAR_NAME => Carried::Scalar,
            _ => {
                let encoding = format!("{}/{schema_encoding}", channel.message_encoding);
                self.foreign.insert(channel.id, Foreign { topic: channel.topic.clone(), encoding, schema });
                Carried::Foreign
            }
        };
        self.carried.insert(channel.id, carried);
        carried
    }

    /// `None` for a channel that no record has declared.
    pub fn carried(&self, id: u16) -> Option<Carried> {
        self.carried.get(&id).copied()
    }

    /// The samples of this file are not read: what is left to do is to name its channels.
    pub fn is_unreadable(&self) -> bool {
        !self.foreign.is_empty() || self.compression.is_some()
    }

    /// # Errors
    /// The error of a file whose samples are not read, with the channels seen so far.
    pub fn check(&self, file: String) -> Result<(), RecordingError> {
        if let Some(Foreign { topic, encoding, schema }) = self.foreign.values().next() {
            let (topic, encoding, schema) = (topic.clone(), encoding.clone(), schema.clone());
            return Err(RecordingError::ForeignMcap { file, topic, encoding, schema, channels: self.named() });
        }
        match &self.compression {
            Some(compression) => Err(RecordingError::UnknownFormat {
                file,
                found: format!("MCAP chunks compressed by `{compression}`"),
                cure: "compress with zstd: `mcap compress --compression zstd FILE -o OUT`".into(),
            }),
            None => Ok(()),
        }
    }

    fn named(&self) -> String {
        let foreign = self.foreign.values().map(|channel| format!("`{}` ({})", channel.topic, channel.schema));
        let known = self.carried.values().filter_map(|carried| match carried {
            Carried::Topic(topic) => Some(format!("`{}` of obsid", TOPICS[*topic].name)),
            Carried::Scalar => Some(format!("one of {SCALAR_NAME}")),
            Carried::Foreign => None,
        });
        let all: Vec<String> = foreign.chain(known).collect();
        let named = all[..all.len().min(CHANNELS_NAMED_MAX)].join(", ");
        if all.len() > CHANNELS_NAMED_MAX {
            format!("{named} and {} more", all.len() - CHANNELS_NAMED_MAX)
        } else {
            named
        }
    }
}
