//! Recordings of rosbag2: an SQLite database of topics and messages, or the folder around it.

mod database;

use super::mcap;
use super::topics::Topics;
use crate::dataset::{RawDataset, Wanted};
use crate::error::RecordingError;
use crate::file_name;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// The datasets of the database, or of all databases and MCAP files of the folder, at `path`.
///
/// # Errors
/// See [`super::rosbag2_datasets`].
pub(super) fn datasets(path: &Path, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    let mut topics = Topics::new(wanted);
    let mut notes = Vec::new();
    if path.is_dir() {
        for part in parts(path)? {
            let found = match part.extension() {
                Some(extension) if extension == "mcap" => mcap::collect(&part, &mut topics)?,
                _ => database::collect(&part, &mut topics)?,
            };
            let name = part.file_name().unwrap_or(OsStr::new("")).to_string_lossy().into_owned();
            notes.extend(found.into_iter().map(|note| format!("{name}: {note}")));
        }
    } else {
        notes = database::collect(path, &mut topics)?;
    }
    topics.into_datasets(&file_name(path), &notes)
}

/// The files of a folder that hold messages, by name.
fn parts(folder: &Path) -> Result<Vec<PathBuf>, RecordingError> {
    let io = |source| RecordingError::Io { file: file_name(folder), action: "read", reason: source };
    let mut parts = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        if path.extension().is_some_and(|extension| extension == "db3" || extension == "mcap") {
            parts.push(path);
        }
    }
    parts.sort();
    if parts.is_empty() {
        return Err(RecordingError::BadContainer {
            file: file_name(folder),
            place: "the folder".into(),
            found: "it holds no file `*.db3` or `*.mcap`".into(),
            cure: "give a recording of rosbag2; unpack compressed ones (`*.zstd`) first".into(),
        });
    }
    Ok(parts)
}
