//! `obsid command`: commands to a run that flies, one at a time or as a stored sequence.

mod sequence;

pub use sequence::read as read_sequence;

use crate::attach::{self, Progress};
use crate::{Failure, tables};
use clap::Subcommand;
use serde_json::json;
use std::path::PathBuf;
use std::time::Duration;
use telemetry::{EVERY_PARTITION, Opcode, PartitionId, Sample, Telecommand};

/// Command a run that flies: ping, mode, counters, stored sequences
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid command ping slosh-id                  does it answer? (prints the frame in which it did)
  obsid command ping all --json                every partition, as one JSON object
  obsid command safe                           the mode table makes safe
  obsid command resume                         out of SAFE, on with the plan
  obsid command allow-capture                  capture without accepted models
  obsid command ping slosh-id --delay-frames 500
  obsid command check campaign.toml            a stored sequence, checked and not sent
  obsid command sequence campaign.toml         checked as a whole, then sent
Tables are loaded and activated by `obsid tables`. A run begins with a sequence by `obsid run --commands FILE`, which
also takes a recording: its commands are repeated in their frames.

A sequence file:  format = 1
                  [[command]]
                  frame = 500          # after the first command could be released
                  order = \"safe\"       # ping, safe, resume, allow-capture, clear-counters, load-table, activate-table
                  to = \"supervisor\"    # or \"all\"
                  # file = \"guards.toml\" with load-table and activate-table: see `obsid tables --help`

A command is accepted once it is in a checkpoint, takes effect one pacing window later, and is in the recording. One
with the key of an earlier one is executed once. Exit code 1 when it is refused; the reason is said.")]
pub struct Arguments {
    #[command(subcommand)]
    order: Order,
    #[command(flatten)]
    to: Sending,
}

/// Where and how a command is sent.
#[derive(clap::Args)]
pub struct Sending {
    /// Folder of the run; without it the newest one
    #[arg(long, value_name = "FOLDER", global = true)]
    pub run: Option<PathBuf>,
    /// Idempotence key, from 1; without it a new one
    #[arg(long, value_name = "N", global = true)]
    pub key: Option<u64>,
    /// Not released before so many frames have passed
    #[arg(long, value_name = "N", default_value_t = 0, global = true)]
    pub delay_frames: u32,
    /// Longest wait for an answer
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, global = true)]
    pub timeout: f64,
    /// One JSON object on standard output
    #[arg(long, global = true)]
    pub json: bool,
}

/// What is ordered.
#[derive(Subcommand)]
enum Order {
    /// A partition answers with the key
    Ping {
        /// Partition, or all
        partition: String,
    },
    /// The mode table makes safe
    Safe,
    /// Out of SAFE, on with the plan
    Resume,
    /// Capture without accepted models
    AllowCapture,
    /// Counters of events and commands begin anew
    ClearCounters {
        /// Partition, or all
        partition: String,
    },
    /// Check a stored sequence and send it
    Sequence {
        /// Stored sequence (TOML)
        file: PathBuf,
    },
    /// Check a stored sequence, and send nothing
    Check {
        /// Stored sequence (TOML)
        file: PathBuf,
    },
}

/// Sends and shows the answer.
///
/// # Errors
/// [`Failure::Input`] when no run flies or a file cannot be used, [`Failure::Run`] when a command
/// is refused or not answered.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let own = PartitionId::Supervisor.code();
    let (opcode, partition) = match &arguments.order {
        Order::Check { file } => return sequence::check(file, arguments.to.json),
        Order::Sequence { file } => return sequence::send(file, &arguments.to),
        Order::Ping { partition } => (Opcode::Ping, addressee(partition)?),
        Order::ClearCounters { partition } => (Opcode::ClearCounters, addressee(partition)?),
        Order::Safe => (Opcode::Safe, own),
        Order::Resume => (Opcode::Resume, own),
        Order::AllowCapture => (Opcode::AllowCapture, own),
    };
    let command = Telecommand { opcode: opcode.code(), partition, ..Telecommand::zeroed_at(0) };
    show(&arguments.to, send(&arguments.to, command)?);
    Ok(())
}

/// The code of a partition, or of all.
///
/// # Errors
/// [`Failure::Usage`] with the names that there are.
pub fn addressee(name: &str) -> Result<u16, Failure> {
    if name == "all" { Ok(EVERY_PARTITION) } else { attach::partition(name).map(PartitionId::code) }
}

/// Fills in key and delay, sends, and waits for the answer.
///
/// # Errors
/// As [`attach::order`]; [`Failure::Input`] when no run flies.
pub fn send(to: &Sending, command: Telecommand) -> Result<(Telecommand, Progress), Failure> {
    let dir = attach::living(to.run.clone())?;
    let limit = Duration::try_from_secs_f64(to.timeout)
        .map_err(|error| Failure::Usage(format!("--timeout {}: {error}", to.timeout)))?;
    let key = to.key.unwrap_or_else(attach::fresh_key);
    let command = Telecommand { key, delay_frames: to.delay_frames, ..command };
    attach::order(&dir, command, limit).map(|progress| (command, progress))
}

/// Prints the answer.
pub fn show(to: &Sending, (command, progress): (Telecommand, Progress)) {
    let opcode = Opcode::from_code(command.opcode).map_or("", Opcode::text);
    let (word, frame) = match progress {
        Progress::Accepted => ("accepted", None),
        Progress::Executed { frame } => ("executed", Some(frame)),
    };
    if to.json {
        let object = json!({ "command": opcode, "key": command.key, "state": word, "frame": frame });
        return crate::print(&format!("{object}\n"));
    }
    let place = frame.map(|frame| format!(" in frame {frame}")).unwrap_or_default();
    crate::print(&format!("{opcode}: {word}{place} (key {})\n", command.key));
}

/// Reads a table file for a command.
pub(crate) fn of_table(opcode: Opcode, table: &tables::TableFile) -> Telecommand {
    let mut command = Telecommand {
        opcode: opcode.code(),
        partition: table.partition.code(),
        table: table.table.code(),
        version: table.version,
        ..Telecommand::zeroed_at(0)
    };
    if opcode == Opcode::LoadTable {
        command.count = table.values.len() as u32;
        command.values[..table.values.len()].copy_from_slice(&table.values);
    }
    command
}
