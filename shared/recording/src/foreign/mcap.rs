//! MCAP files of any program: with and without chunks, index and summary.

mod records;

use super::topics::Topics;
use crate::dataset::{RawDataset, Wanted};
use crate::error::RecordingError;
use crate::file_name;
use crate::messages::{Decoder, Schema};
use core::ops::ControlFlow;
use records::{Item, walk};
use std::collections::HashMap;
use std::path::Path;

/// The datasets of the file at `path`, by name.
///
/// # Errors
/// See [`super::mcap_datasets`].
pub(super) fn datasets(path: &Path, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    let mut topics = Topics::new(wanted);
    let notes = collect(path, &mut topics)?;
    topics.into_datasets(&file_name(path), &notes)
}

/// A schema as the file holds it.
struct OwnedSchema {
    name: String,
    encoding: String,
    text: Vec<u8>,
}

/// Adds the messages of the file at `path` to `topics`; gives notes on what is missing.
///
/// # Errors
/// A file that is no MCAP; the device's.
pub(super) fn collect(path: &Path, topics: &mut Topics<'_>) -> Result<Vec<String>, RecordingError> {
    let mut schemas: HashMap<u16, OwnedSchema> = HashMap::new();
    let mut channels: HashMap<u16, Option<(usize, Decoder)>> = HashMap::new();
    let mut lost: u64 = 0;
    let mut notes = walk(path, &mut |item| {
        match item {
            Item::Header { .. } => {}
            Item::Schema { id, name, encoding, text } => {
                schemas.entry(id).or_insert_with(|| OwnedSchema { name, encoding, text: text.to_vec() });
            }
            Item::Channel { id, topic, schema_id, encoding } => {
                channels.entry(id).or_insert_with(|| {
                    let topic = topics.topic(&topic)?;
                    Some((topic, decoder(&encoding, schemas.get(&schema_id))))
                });
            }
            Item::Message { channel, logged_ns, data } => match channels.get(&channel) {
                Some(Some((topic, decoder))) => topics.message(*topic, decoder, logged_ns, data),
                Some(None) => {}
                None => lost += 1,
            },
        }
        ControlFlow::Continue(())
    })?;
    if lost > 0 {
        notes.push(format!("{lost} messages are left out: the file does not describe their channels"));
    }
    Ok(notes)
}

fn decoder(encoding: &str, schema: Option<&OwnedSchema>) -> Decoder {
    let (name, described, text) =
        schema.map_or(("", "", [].as_slice()), |schema| (&schema.name, &schema.encoding, &schema.text));
    Decoder::new(encoding, &Schema { name, encoding: described, text })
}

/// Libraries and packages of messages that obsid itself writes.
const OWN_LIBRARY: &str = "obsid ";
const OWN_PACKAGES: [&str; 2] = ["obsid/", "obsid_msgs/"];

/// Whether obsid recorded the file at `path`: the header says so, or the first schema, where
/// another program has copied the file.
///
/// # Errors
/// A file that is no MCAP; the device's.
pub(super) fn is_own(path: &Path) -> Result<bool, RecordingError> {
    let mut is_own = false;
    walk(path, &mut |item| match item {
        Item::Header { library } if library.starts_with(OWN_LIBRARY) => {
            is_own = true;
            ControlFlow::Break(())
        }
        Item::Schema { name, .. } => {
            is_own = OWN_PACKAGES.iter().any(|package| name.starts_with(package));
            ControlFlow::Break(())
        }
        Item::Channel { .. } => ControlFlow::Break(()),
        Item::Header { .. } | Item::Message { .. } => ControlFlow::Continue(()),
    })?;
    Ok(is_own)
}
