//! `obsid bridge`: starts `obsid-bridge`, a program of its own.

use crate::Failure;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

const PROGRAM: &str = "obsid-bridge";

/// Carry results, events and commands between the runs of two computers
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid bridge --listen tcp/10.0.0.1:7447 --run /run/obsid/obsid-flight        the run here, for another computer
  obsid bridge --connect tcp/10.0.0.1:7447 --mirror /run/obsid-far/obsid-far   that run, as a run of this computer
  obsid events --once /run/obsid-far/obsid-far                                 what its partitions reported
  obsid command ping all --run /run/obsid-far/obsid-far                        commands it
Both computers may give both --run and --mirror. Samples keep number and content of their producer. Over a line that
loses, delays, repeats or is cut every sample comes once and in order, or its number is declared lost: on standard
error and in losses.jsonl of the mirror. Nothing is encrypted and nobody is asked who he is: use a line of your own.
Endpoints are tcp/ADDRESS:PORT or udp/ADDRESS:PORT.")]
#[command(group = clap::ArgGroup::new("end").required(true).args(["listen", "connect"]))]
pub struct Arguments {
    /// Endpoint of this computer, where the other one connects
    #[arg(long, value_name = "ENDPOINT")]
    listen: Option<String>,
    /// Endpoint of the other computer
    #[arg(long, value_name = "ENDPOINT")]
    connect: Option<String>,
    /// Folder of a run that flies here: its samples are sent
    #[arg(long, value_name = "FOLDER", required_unless_present = "mirror")]
    run: Option<PathBuf>,
    /// Folder that is made for the other computer's run
    #[arg(long, value_name = "FOLDER")]
    mirror: Option<PathBuf>,
    /// What is sent, separated by commas; without it results and events
    #[arg(long, value_name = "TOPICS")]
    topics: Option<String>,
    /// Samples of one producer and topic that wait for an acknowledgement; older ones are given up
    #[arg(long, value_name = "SAMPLES")]
    room: Option<usize>,
}

/// Becomes `obsid-bridge`.
///
/// # Errors
/// [`Failure::Run`] where that program is missing.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let beside = std::env::current_exe().ok().and_then(|own| own.parent().map(|folder| folder.join(PROGRAM)));
    let program = beside.filter(|path| path.is_file()).unwrap_or_else(|| PROGRAM.into());
    let path = |path: &PathBuf| path.display().to_string();
    let pairs = [
        ("--listen", arguments.listen.clone()),
        ("--connect", arguments.connect.clone()),
        ("--run", arguments.run.as_ref().map(path)),
        ("--mirror", arguments.mirror.as_ref().map(path)),
        ("--topics", arguments.topics.clone()),
        ("--room", arguments.room.map(|room| room.to_string())),
    ];
    let given = pairs.into_iter().filter_map(|(name, value)| value.map(|value| [name.to_string(), value]));
    let error = Command::new(&program).args(given.flatten()).exec();
    Err(missing(&program, &error))
}

fn missing(program: &Path, error: &std::io::Error) -> Failure {
    Failure::Run(format!(
        "{}: {error}; it is built by itself, beside obsid: cargo build --release --manifest-path \
         services/bridge/Cargo.toml --target-dir target",
        program.display()
    ))
}
