//! PX4 logs (ULog): one dataset for each topic and instance.
//!
//! `timestamp` holds the times, in whole microseconds. Where a topic has several instances their
//! datasets are called `topic_0`, `topic_1`. A log that is cut or damaged is read as far as its
//! messages are whole, and the datasets say so.

use crate::bytes::{self, bad};
use crate::dataset::{Axis, RawColumn, RawDataset, Wanted};
use crate::error::RecordingError;
use crate::file_name;
use crate::ulog_formats::{Formats, Layout};
use crate::ulog_messages::Messages;
use crate::ulog_units::unit;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The wanted datasets of a PX4 log.
///
/// # Errors
/// The device's; what is no PX4 log, or one without data.
pub fn datasets(path: &Path, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    let content = bytes::whole(path)?;
    datasets_of(&file_name(path), &content, wanted)
}

/// Fields of all topics that are read.
const COLUMNS_OF_LOG_MAX: usize = 200_000;

/// A topic and its instance.
type Key = (String, u8);

/// What is known of a log before its data are read.
#[derive(Default)]
struct Contents {
    formats: Formats,
    /// In the order in which they were added.
    topics: Vec<Key>,
    /// The instances of every topic.
    instances: BTreeMap<String, BTreeSet<u8>>,
    dropouts: u64,
    dropped_ms: u64,
    has_data: bool,
}

/// The rows of one topic.
struct Topic {
    layout: Layout,
    columns: Vec<Vec<f64>>,
    too_short: usize,
}

fn datasets_of(file: &str, log: &[u8], wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    let mut messages = Messages::open(file, log)?;
    let contents = survey(&mut messages);
    if contents.topics.is_empty() || !contents.has_data {
        let found = "no topic with data is in the log";
        return Err(bad(file, "the whole file", found, "log the topics again: the file holds its header only"));
    }
    let mut topics: BTreeMap<Key, Topic> = BTreeMap::new();
    let (mut named, mut left_out, mut fields) = (Vec::new(), Vec::new(), 0);
    for key in &contents.topics {
        let name = contents.name(key);
        if !wanted(&name) {
            continue;
        }
        match contents.formats.layout(&key.0) {
            Ok(layout) if fields + layout.fields.len() <= COLUMNS_OF_LOG_MAX => {
                fields += layout.fields.len();
                let columns = vec![Vec::new(); layout.fields.len()];
                topics.insert(key.clone(), Topic { layout, columns, too_short: 0 });
                named.push((name, key.clone()));
            }
            Ok(_) => {
                left_out.push(format!("`{name}` (more than {COLUMNS_OF_LOG_MAX} fields are in the topics before)"))
            }
            Err(reason) => left_out.push(format!("`{name}` ({reason})")),
        }
    }
    let notes = notes(&contents, &messages, &left_out);
    read(Messages::open(file, log)?, &mut topics);
    let dataset = |(name, key): (String, Key)| topics.remove(&key).map(|topic| topic.dataset(name, &key.0, &notes));
    let datasets = named.into_iter().filter_map(dataset);
    // A topic that was added and never written has no rows.
    Ok(datasets.filter(|dataset| dataset.rows() > 0).collect())
}

/// Definitions, topics and dropouts.
fn survey(messages: &mut Messages<'_>) -> Contents {
    let mut contents = Contents::default();
    for message in messages {
        match message.kind {
            b'F' => contents.formats.define(&String::from_utf8_lossy(message.data)),
            b'A' => {
                if let Some((_, key)) = added(message.data)
                    && contents.instances.entry(key.0.clone()).or_default().insert(key.1)
                {
                    contents.topics.push(key);
                }
            }
            b'O' => {
                contents.dropouts += 1;
                let duration = message.data.get(..2).map_or(0, |bytes| u16::from_le_bytes([bytes[0], bytes[1]]));
                contents.dropped_ms += u64::from(duration);
            }
            b'D' => contents.has_data = true,
            _ => {}
        }
    }
    contents
}

/// Number and name of a topic that is added.
fn added(data: &[u8]) -> Option<(u16, Key)> {
    let [instance, low, high, name @ ..] = data else { return None };
    Some((u16::from_le_bytes([*low, *high]), (String::from_utf8_lossy(name).into_owned(), *instance)))
}

impl Contents {
    fn name(&self, (topic, instance): &Key) -> String {
        let has_others = self.instances.get(topic).is_some_and(|instances| instances.len() > 1);
        if has_others || *instance > 0 { format!("{topic}_{instance}") } else { topic.clone() }
    }
}

fn notes(contents: &Contents, messages: &Messages<'_>, left_out: &[String]) -> Vec<String> {
    const TOPICS_NAMED_MAX: usize = 20;
    let mut notes = Vec::new();
    if !left_out.is_empty() {
        let named = left_out.iter().take(TOPICS_NAMED_MAX).cloned().collect::<Vec<_>>().join(", ");
        let more = match left_out.len().saturating_sub(TOPICS_NAMED_MAX) {
            0 => String::new(),
            count => format!(" and {count} more"),
        };
        notes.push(format!("left out: {named}{more}"));
    }
    if contents.dropouts > 0 {
        let (count, duration_s) = (contents.dropouts, contents.dropped_ms as f64 / 1e3);
        notes.push(format!("the logger dropped out {count} time(s), {duration_s} s in all: data are missing there"));
    }
    if let Some((from, to)) = messages.passed_over.first() {
        let more = match messages.passed_over.len() {
            1 => String::new(),
            count => format!(", and at {} more place(s)", count - 1),
        };
        notes.push(format!(
            "bytes {from} to {to} are no whole message, the log is cut or damaged there and they are left out{more}"
        ));
    }
    notes
}

fn read(messages: Messages<'_>, topics: &mut BTreeMap<Key, Topic>) {
    let mut numbers: BTreeMap<u16, Key> = BTreeMap::new();
    for message in messages {
        match (message.kind, message.data) {
            (b'A', data) => {
                if let Some((number, key)) = added(data) {
                    numbers.insert(number, key);
                }
            }
            (b'D', [low, high, row @ ..]) => {
                let key = numbers.get(&u16::from_le_bytes([*low, *high]));
                if let Some(topic) = key.and_then(|key| topics.get_mut(key)) {
                    topic.push(row);
                }
            }
            _ => {}
        }
    }
}

impl Topic {
    fn push(&mut self, row: &[u8]) {
        if row.len() < self.layout.needed {
            self.too_short += 1;
            return;
        }
        for (field, column) in self.layout.fields.iter().zip(&mut self.columns) {
            column.push(field.number.value(&row[field.offset..], false));
        }
    }

    fn dataset(self, name: String, topic: &str, notes: &[String]) -> RawDataset {
        let mut notes = notes.to_vec();
        if self.too_short > 0 {
            notes.push(format!("{} message(s) shorter than their definition are left out", self.too_short));
        }
        if !self.layout.texts.is_empty() {
            notes.push(format!("left out: `{}` (text)", self.layout.texts.join("`, `")));
        }
        let fields = self.layout.fields;
        let times = fields.iter().position(|field| field.name == "timestamp");
        let column = |(field, values): (crate::ulog_formats::Field, Vec<f64>)| RawColumn {
            unit: unit(topic, &field.name).map(String::from),
            name: field.name,
            values,
            rest: Vec::new(),
        };
        let columns = fields.into_iter().zip(self.columns).map(column).collect();
        RawDataset { name, columns, axis: times.map_or(Axis::Unknown, Axis::Time), notes }
    }
}

#[cfg(test)]
mod tests;
