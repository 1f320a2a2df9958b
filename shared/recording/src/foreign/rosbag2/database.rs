//! The tables of a rosbag2 database: `topics`, `messages` and, in newer ones,
//! `message_definitions`.
//!
//! Only tables are read, and only such whose cells are stored: a view could compute without end.

use super::super::topics::Topics;
use crate::error::RecordingError;
use crate::file_name;
use crate::messages::{Decoder, Schema};
use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags, Row};
use std::collections::HashMap;
use std::path::Path;

/// Type and text of a message, with the encoding of the text.
struct Definition {
    encoding: String,
    text: Vec<u8>,
}

/// Adds the messages of the database at `path` to `topics`; gives notes on what is missing.
///
/// # Errors
/// A file that is no database of rosbag2; the device's.
pub(super) fn collect(path: &Path, topics: &mut Topics<'_>) -> Result<Vec<String>, RecordingError> {
    let bad = |place: &str, found: String| RecordingError::BadContainer {
        file: file_name(path),
        place: place.into(),
        found,
        cure: "give a database of rosbag2 that is whole (its tables are `topics` and `messages`)".into(),
    };
    // SQLite says of a file that is not there only that it cannot open it.
    std::fs::File::open(path).map_err(|source| RecordingError::Io {
        file: file_name(path),
        action: "open",
        reason: source,
    })?;
    let database = open(path).map_err(|error| bad("the file", error.to_string()))?;
    for table in ["topics", "messages"] {
        is_table(&database, table)
            .map_err(|error| bad("the schema", error.to_string()))?
            .then_some(())
            .ok_or_else(|| bad("the schema", format!("there is no table `{table}`")))?;
    }
    let definitions = definitions(&database).unwrap_or_default();
    let channels =
        channels(&database, topics, &definitions).map_err(|error| bad("table `topics`", error.to_string()))?;
    Ok(messages(&database, topics, &channels))
}

/// Without a journal beside it the file is read as it lies, also on a device that is not writable:
/// SQLite then makes no files of its own.
fn open(path: &Path) -> rusqlite::Result<Connection> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let has_journal = ["-wal", "-journal"].iter().any(|ending| {
        let mut journal = path.as_os_str().to_owned();
        journal.push(ending);
        Path::new(&journal).exists()
    });
    match path.to_str() {
        Some(name) if !has_journal && !name.starts_with("//") => {
            let name = name.replace('%', "%25").replace('?', "%3f").replace('#', "%23");
            Connection::open_with_flags(format!("file:{name}?immutable=1"), flags | OpenFlags::SQLITE_OPEN_URI)
        }
        _ => Connection::open_with_flags(path, flags),
    }
}

/// Whether `name` is a table of stored cells.
fn is_table(database: &Connection, name: &str) -> rusqlite::Result<bool> {
    let mut query = database.prepare("SELECT sql FROM sqlite_schema WHERE type = 'table' AND name = ?1")?;
    let mut rows = query.query([name])?;
    let Some(row) = rows.next()? else { return Ok(false) };
    let sql = text(row, 0).to_uppercase();
    Ok(!sql.contains("VIRTUAL") && !sql.contains("GENERATED") && !sql.split_whitespace().any(|word| word == "AS"))
}

fn text(row: &Row<'_>, column: usize) -> String {
    String::from_utf8_lossy(bytes(row, column)).into_owned()
}

fn bytes<'r>(row: &'r Row<'_>, column: usize) -> &'r [u8] {
    match row.get_ref(column) {
        Ok(ValueRef::Text(bytes) | ValueRef::Blob(bytes)) => bytes,
        _ => &[],
    }
}

fn definitions(database: &Connection) -> rusqlite::Result<HashMap<String, Definition>> {
    let mut definitions = HashMap::new();
    if !is_table(database, "message_definitions")? {
        return Ok(definitions);
    }
    let mut query =
        database.prepare("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions")?;
    let mut rows = query.query([])?;
    while let Some(row) = rows.next()? {
        let definition = Definition { encoding: text(row, 1), text: bytes(row, 2).to_vec() };
        definitions.entry(text(row, 0)).or_insert(definition);
    }
    Ok(definitions)
}

type Channels = HashMap<i64, Option<(usize, Decoder)>>;

fn channels(
    database: &Connection,
    topics: &mut Topics<'_>,
    definitions: &HashMap<String, Definition>,
) -> rusqlite::Result<Channels> {
    let mut channels = Channels::new();
    let mut query = database.prepare("SELECT id, name, type, serialization_format FROM topics")?;
    let mut rows = query.query([])?;
    while let Some(row) = rows.next()? {
        let (name, kind, format) = (text(row, 1), text(row, 2), text(row, 3));
        let channel = topics.topic(&name).map(|topic| {
            let stored = definitions.get(&kind).filter(|definition| !definition.text.is_empty());
            let (encoding, text) =
                stored.map_or(("", [].as_slice()), |stored| (stored.encoding.as_str(), &stored.text));
            (topic, Decoder::new(&format, &Schema { name: &kind, encoding, text }))
        });
        channels.insert(row.get(0)?, channel);
    }
    Ok(channels)
}

fn messages(database: &Connection, topics: &mut Topics<'_>, channels: &Channels) -> Vec<String> {
    let (mut read, mut lost) = (0_u64, 0_u64);
    let mut visit = || -> rusqlite::Result<()> {
        let mut query = database.prepare("SELECT topic_id, timestamp, data FROM messages")?;
        let mut rows = query.query([])?;
        while let Some(row) = rows.next()? {
            read += 1;
            let (Ok(id), Ok(time)) = (row.get::<_, i64>(0), row.get::<_, i64>(1)) else {
                lost += 1;
                continue;
            };
            match (channels.get(&id), u64::try_from(time)) {
                (Some(Some((topic, decoder))), Ok(logged_ns)) => {
                    topics.message(*topic, decoder, logged_ns, bytes(row, 2));
                }
                (Some(None), _) => {}
                _ => lost += 1,
            }
        }
        Ok(())
    };
    let ended = visit();
    let mut notes = Vec::new();
    if let Err(error) = ended {
        notes.push(format!("the database is damaged behind {read} messages: {error}"));
    }
    if lost > 0 {
        notes.push(format!("{lost} messages are left out: they are of no topic or have no time"));
    }
    notes
}
