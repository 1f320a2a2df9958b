//! ROS 1 bags (`#ROSBAG V2.0`): read from front to back, so that none needs an index.

mod records;

use super::topics::Topics;
use crate::dataset::{RawDataset, Wanted};
use crate::error::RecordingError;
use crate::file_name;
use crate::messages::{Decoder, Schema};
use records::{Item, walk};
use std::collections::HashMap;
use std::path::Path;

/// The datasets of the bag at `path`, by name.
///
/// # Errors
/// See [`super::bag_datasets`].
pub(super) fn datasets(path: &Path, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    let mut topics = Topics::new(wanted);
    let mut connections: HashMap<u32, Option<(usize, Decoder)>> = HashMap::new();
    let mut lost: u64 = 0;
    let mut notes = walk(path, &mut |item| match item {
        Item::Connection { id, topic, kind, definition } => {
            connections.entry(id).or_insert_with(|| {
                let topic = topics.topic(topic)?;
                let schema = Schema { name: kind, encoding: "ros1msg", text: definition };
                Some((topic, Decoder::new("ros1", &schema)))
            });
        }
        Item::Message { connection, logged_ns, data } => match connections.get(&connection) {
            Some(Some((topic, decoder))) => topics.message(*topic, decoder, logged_ns, data),
            Some(None) => {}
            None => lost += 1,
        },
    })?;
    if lost > 0 {
        notes.push(format!("{lost} messages are left out: the bag does not describe their connections"));
    }
    topics.into_datasets(&file_name(path), &notes)
}
