//! The topics of a recording while its messages come in.

use crate::dataset::{RawDataset, Wanted};
use crate::error::RecordingError;
use crate::messages::{Decoder, Rows};
use std::collections::BTreeMap;

/// Topics by name, each with its rows.
pub(super) struct Topics<'w> {
    wanted: &'w Wanted<'w>,
    /// `None` for a topic that is not wanted.
    by_name: BTreeMap<String, Option<usize>>,
    list: Vec<Topic>,
}

#[derive(Default)]
struct Topic {
    rows: Rows,
    /// Why its messages are not read.
    unreadable: Option<String>,
}

impl<'w> Topics<'w> {
    /// No topics yet; of those to come, the `wanted` ones are kept.
    pub fn new(wanted: &'w Wanted<'w>) -> Self {
        Topics { wanted, by_name: BTreeMap::new(), list: Vec::new() }
    }

    /// The number of the topic `name`; `None` when it is not wanted.
    pub fn topic(&mut self, name: &str) -> Option<usize> {
        if let Some(known) = self.by_name.get(name) {
            return *known;
        }
        let index = (self.wanted)(name).then(|| {
            self.list.push(Topic::default());
            self.list.len() - 1
        });
        self.by_name.insert(name.into(), index);
        index
    }

    /// A message of a topic, logged at `logged_ns`.
    pub fn message(&mut self, topic: usize, decoder: &Decoder, logged_ns: u64, message: &[u8]) {
        let Topic { rows, unreadable } = &mut self.list[topic];
        if let Decoder::Unreadable(reason) = decoder {
            unreadable.get_or_insert_with(|| reason.clone());
            return rows.commit(logged_ns);
        }
        match decoder.decode(message, rows) {
            Ok(()) => rows.commit(logged_ns),
            Err(reason) => rows.reject(reason),
        }
    }

    /// The datasets of all topics with messages; `notes` are on the whole file and stand in each.
    ///
    /// # Errors
    /// [`RecordingError::BadContainer`] when messages of no topic are understood, or when there is
    /// no message and a note says why.
    pub fn into_datasets(self, file: &str, notes: &[String]) -> Result<Vec<RawDataset>, RecordingError> {
        let Topics { by_name, mut list, .. } = self;
        let is_wanted = by_name.is_empty() || by_name.values().any(Option::is_some);
        let mut datasets = Vec::new();
        let mut fault = None;
        for (name, index) in by_name {
            let Some(Topic { rows, unreadable }) = index.map(|index| core::mem::take(&mut list[index])) else {
                continue;
            };
            if rows.is_empty() {
                continue;
            }
            let mut dataset = rows.into_dataset(name);
            dataset.notes.splice(0..0, unreadable.map(|reason| format!("no field is read: {reason}")));
            if let (1, None, Some(reason)) = (dataset.columns.len(), &fault, dataset.notes.first()) {
                fault = Some((format!("topic `{}`", dataset.name), reason.clone()));
            }
            dataset.notes.extend_from_slice(notes);
            datasets.push(dataset);
        }
        let nothing = datasets.iter().all(|dataset| dataset.columns.len() < 2);
        let fault = fault.or_else(|| (!notes.is_empty()).then(|| ("the file".to_string(), notes.join("; "))));
        match fault {
            Some((place, found)) if nothing && is_wanted => Err(RecordingError::BadContainer {
                file: file.into(),
                place,
                found,
                cure: "record the topic in JSON, ROS 1, ROS 2 or protobuf messages, or copy the file again when it is \
                       damaged; else export the topic as CSV with a `time [s]` column"
                    .into(),
            }),
            _ => Ok(datasets),
        }
    }
}
