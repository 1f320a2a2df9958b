//! Stored sequences of commands: a file with relative frames, checked as a whole before any of it
//! is sent; or the commands of a recording, to be repeated in their frames.

use super::{Sending, addressee, of_table};
use crate::attach::{self, Progress};
use crate::toml_file::TomlFile;
use crate::{Failure, tables};
use runtime::orders::{StoredCommand, check_content, datagram};
use runtime::table_store::{self, StoredTable};
use serde::Deserialize;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Duration;
use telemetry::{Opcode, PartitionId, Sample, TELECOMMAND, Telecommand};
use toml::Spanned;

/// Commands of one file: keys are numbered from a multiple of this.
const KEYS_OF_FILE: u64 = 1 << 16;
const CURE: &str = "see `obsid command --help` for a sequence file";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: u32,
    #[serde(default, rename = "command")]
    commands: Vec<Spanned<Row>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    frame: u32,
    order: String,
    to: Option<String>,
    file: Option<PathBuf>,
}

/// The commands of `file`, a stored sequence or a recording, for a run of `partitions`; of a
/// recording also the tables with which its run began.
///
/// # Errors
/// [`Failure::Input`] with file, line, what is wrong and the cure.
pub fn read(file: &Path, partitions: &[PartitionId]) -> Result<(Vec<StoredCommand>, Vec<StoredTable>), Failure> {
    if file.extension().is_some_and(|extension| extension == "mcap") {
        return of_recording(file);
    }
    let mut stored: Vec<StoredCommand> = commands(file, partitions)?
        .into_iter()
        .map(|(frame, command)| StoredCommand { frame: frame.into(), bytes: datagram(command) })
        .collect();
    stored.sort_by_key(|command| command.frame);
    Ok((stored, Vec::new()))
}

fn of_recording(file: &Path) -> Result<(Vec<StoredCommand>, Vec<StoredTable>), Failure> {
    let recorded = recording::read_mcap_topics(file, |topic| topic == TELECOMMAND.id).map_err(Failure::input)?;
    let mut found: Vec<(u64, Telecommand)> =
        recorded.of(TELECOMMAND).map(|(_, command)| (command.header.seq, *command)).collect();
    found.sort_by_key(|(seq, _)| *seq);
    found.dedup_by_key(|(seq, _)| *seq);
    let released = |(_, command): (u64, Telecommand)| {
        // What the port fills in is 0 in what is sent to it.
        let sent = Telecommand { header: telemetry::Header::at(0), frame: 0, effective_frame: 0, ..command };
        StoredCommand { frame: command.frame, bytes: datagram(sent) }
    };
    let tables = recorded.attachments().iter().find(|attachment| attachment.name == table_store::ATTACHMENT);
    let tables = tables.map(|attachment| table_store::from_json(&attachment.bytes)).unwrap_or_default();
    Ok((found.into_iter().map(released).collect(), tables))
}

/// Relative frame and command, in the order of the file.
fn commands(file: &Path, partitions: &[PartitionId]) -> Result<Vec<(u32, Telecommand)>, Failure> {
    let source = TomlFile::read(file, CURE)?;
    let parsed: File = source.parsed(|parsed: &File| parsed.format)?;
    let at = |span, message| source.at(span, message);
    // A sequence of the same text has the same keys: sent twice, it is executed once.
    let first_key = u64::from(telemetry::crc32(source.text.as_bytes())) * KEYS_OF_FILE + 1;
    let folder = file.parent().unwrap_or(Path::new("."));
    let mut all = Vec::new();
    for (row, index) in parsed.commands.iter().zip(0_u32..) {
        let command = command_of(row.get_ref(), folder).map_err(|failure| match failure {
            Failure::Usage(message) => at(row.span(), message),
            other => other,
        })?;
        check_content(&command, partitions, true).map_err(|(refusal, fault)| {
            let fault = fault.map(|fault| format!(": {fault}")).unwrap_or_default();
            at(row.span(), format!("{}: {refusal}{fault}", row.get_ref().order))
        })?;
        let (key, sequence) = (first_key + u64::from(index), index + 1);
        all.push((row.get_ref().frame, Telecommand { key, sequence, ..command }));
    }
    Ok(all)
}

fn command_of(row: &Row, folder: &Path) -> Result<Telecommand, Failure> {
    let orders = [
        ("ping", Opcode::Ping),
        ("safe", Opcode::Safe),
        ("resume", Opcode::Resume),
        ("allow-capture", Opcode::AllowCapture),
        ("clear-counters", Opcode::ClearCounters),
        ("load-table", Opcode::LoadTable),
        ("activate-table", Opcode::ActivateTable),
    ];
    let Some((_, opcode)) = orders.iter().find(|(name, _)| *name == row.order) else {
        let names: Vec<&str> = orders.iter().map(|(name, _)| *name).collect();
        return Err(Failure::Usage(format!("order = '{}': one of {}", row.order, names.join(", "))));
    };
    if opcode.is_of_table() {
        let Some(file) = &row.file else {
            return Err(Failure::Usage(format!("{}: file = \"…\" is missing, the table's file", row.order)));
        };
        return Ok(of_table(*opcode, &tables::read_whole(&folder.join(file))?));
    }
    let to = row.to.as_deref().unwrap_or(if opcode.is_of_mode() { "supervisor" } else { "all" });
    Ok(Telecommand { opcode: opcode.code(), partition: addressee(to)?, ..Telecommand::zeroed_at(0) })
}

/// Says what a sequence would do.
pub(super) fn check(file: &Path, json: bool) -> Result<(), Failure> {
    let commands = commands(file, PartitionId::ALL)?;
    if json {
        let rows = commands.iter().map(|(frame, command)| {
            json!({ "frame": frame, "command": Opcode::from_code(command.opcode).map(Opcode::text), "key": command.key })
        });
        crate::print(&format!("{}\n", json!({ "commands": rows.collect::<Vec<_>>() })));
        return Ok(());
    }
    for (frame, command) in &commands {
        let opcode = Opcode::from_code(command.opcode).map_or("", Opcode::text);
        crate::print(&format!("frame {frame:<8} {opcode:<16} key {}\n", command.key));
    }
    Ok(())
}

/// Sends a sequence that was checked as a whole.
pub(super) fn send(file: &Path, to: &Sending) -> Result<(), Failure> {
    let dir = attach::living(to.run.clone())?;
    let run = dir.load().map_err(|error| Failure::Run(error.to_string()))?;
    let commands = commands(file, &run.partitions)?;
    let limit = Duration::try_from_secs_f64(to.timeout)
        .map_err(|error| Failure::Usage(format!("--timeout {}: {error}", to.timeout)))?;
    let mut accepted = Vec::new();
    for (frame, command) in commands {
        // One frame at least: accepted is enough, what follows need not wait for it.
        let delay_frames = to.delay_frames.saturating_add(frame).max(1);
        let command = Telecommand { delay_frames, ..command };
        attach::order(&dir, command, limit)?;
        accepted.push(command);
    }
    if to.json {
        let keys: Vec<u64> = accepted.iter().map(|command| command.key).collect();
        crate::print(&format!("{}\n", json!({ "accepted": accepted.len(), "keys": keys })));
    } else {
        accepted.into_iter().for_each(|command| super::show(to, (command, Progress::Accepted)));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(name: &str, text: &str) -> Result<Vec<StoredCommand>, String> {
        let path = std::env::temp_dir().join(format!("obsid-sequence-{name}-{}.toml", std::process::id()));
        std::fs::write(&path, text).unwrap();
        let read = read(&path, &[PartitionId::Supervisor, PartitionId::SloshId]).map(|(commands, _)| commands);
        std::fs::remove_file(&path).unwrap();
        read.map_err(|failure| match failure {
            Failure::Input(report) => report.to_string(),
            other => other.to_string(),
        })
    }

    #[test]
    fn a_sequence_is_refused_as_a_whole_with_the_line_of_what_is_wrong() {
        let good = "format = 1\n[[command]]\nframe = 9\norder = \"ping\"\n";
        assert_eq!(answer("good", good).unwrap().len(), 1);
        for (wrong, says) in [
            ("[[command]]\nframe = 1\norder = \"dance\"\n", "order = 'dance': one of ping"),
            ("[[command]]\nframe = 1\norder = \"safe\"\nto = \"slosh-id\"\n", "does not have that command"),
            ("[[command]]\nframe = 1\norder = \"ping\"\nto = \"modal-id\"\n", "no such partition in this run"),
            ("[[command]]\nframe = -1\norder = \"ping\"\n", "invalid value"),
            ("[[command]]\nframe = 1\norder = \"load-table\"\n", "file = "),
        ] {
            let refusal = answer("wrong", &format!("{good}{wrong}")).unwrap_err();
            assert!(refusal.contains(says) && refusal.contains(".toml:"), "{refusal}");
        }
    }

    #[test]
    fn commands_are_in_the_order_of_their_frames_and_the_same_text_has_the_same_keys() {
        let text = "format = 1\n[[command]]\nframe = 9\norder = \"safe\"\n[[command]]\nframe = 4\norder = \"ping\"\n";
        let (first, second) = (answer("one", text).unwrap(), answer("two", text).unwrap());
        assert_eq!(first, second);
        assert_eq!(first.iter().map(|command| command.frame).collect::<Vec<_>>(), [4, 9]);
    }
}
