//! `obsid partition NAME`: one process of a run, started by the warden; `warden` is the parent of
//! all.

use crate::scratch::Held;
use crate::tell;
use runtime::process;
use runtime::warden::{self, Launcher, Report};
use runtime::{Connect, ConnectError, Partition, RunConfig};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use telemetry::PartitionId;

/// The one list of partitions.
pub const PARTITIONS: &[(PartitionId, Connect)] = &[
    (PartitionId::SensorSim, source),
    (PartitionId::InertialId, inertial_id::connect),
    (PartitionId::SloshId, slosh_id::connect),
    (PartitionId::ModalId, modal_id::connect),
    (PartitionId::Supervisor, supervisor::connect),
    (PartitionId::Recorder, recorder::connect),
    (PartitionId::Diagnosis, diagnosis::connect),
];

/// The partitions of a run: only where several partitions identify one craft can a model be
/// refused, and asked what it lacks.
pub fn of_run(flies_craft: bool) -> Vec<PartitionId> {
    let all = PARTITIONS.iter().map(|(id, _)| *id);
    all.filter(|id| flies_craft || *id != PartitionId::Diagnosis).collect()
}

/// Where samples come from: a simulation or a recording, or real sensors.
fn source(run: &RunConfig) -> Result<Box<dyn Partition>, ConnectError> {
    if run.feed.is_some() { sensor_gateway::connect(run) } else { sensor_sim::connect(run) }
}

/// One process of a run (started by the warden)
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid partition warden --config run.json --root /dev/shm       the parent of all partitions (`obsid run` starts it)
  obsid partition inertial-id --run /dev/shm/obsid-run --epoch 1 one partition (the warden starts it)
  obsid partition keeper --run /run/obsid/obsid-flight --scenario craft.toml --record flight.mcap
                                                                 a run whose partitions a service manager starts")]
pub struct Arguments {
    /// sensor-sim, inertial-id, slosh-id, modal-id, supervisor, recorder, diagnosis, warden, or
    /// keeper
    name: String,
    /// Folder of the run
    #[arg(long)]
    pub run: Option<PathBuf>,
    /// How often the partition was started before; "next": its starts are counted in its folder
    #[arg(long, default_value = "0")]
    epoch: String,
    /// What ended the life before: 0 none, 1 to 255 signal, 256 + exit code
    #[arg(long, default_value_t = 0)]
    cause: u32,
    /// Process id of the warden
    #[arg(long)]
    parent: Option<u32>,
    /// Warden only: the run's configuration (JSON)
    #[arg(long)]
    config: Option<PathBuf>,
    /// Warden only: where the run's folder is made
    #[arg(long)]
    root: Option<PathBuf>,
    /// Warden only: folder with the partitions' own binaries
    #[arg(long)]
    images: Option<PathBuf>,
    #[command(flatten)]
    pub kept: Kept,
}

/// Of the keeper alone.
#[derive(clap::Args)]
pub struct Kept {
    /// Keeper only: scenario file; without one the benchmark's
    #[arg(long)]
    pub scenario: Option<PathBuf>,
    /// Keeper only: where the recorder writes
    #[arg(long)]
    pub record: Option<PathBuf>,
    /// Keeper only: simulated over real time at most
    #[arg(long)]
    pub speed: Option<f64>,
    /// Keeper only: stored sequence of commands
    #[arg(long)]
    pub commands: Option<PathBuf>,
    /// Keeper only: folder that keeps activated parameter tables and the log of restarts
    #[arg(long)]
    pub keep: Option<PathBuf>,
}

impl Arguments {
    /// The process is no partition: it keeps the run's folder.
    pub fn are_of_keeper(&self) -> bool {
        self.name == "keeper"
    }
}

/// Runs the partition (or the warden) of this name until its run ends; exit code 2 for an unknown
/// name.
pub fn run(arguments: &Arguments) -> ExitCode {
    if arguments.name == "warden" {
        return warden(arguments);
    }
    let Some((id, connect)) = PARTITIONS.iter().find(|(id, _)| id.text() == arguments.name) else {
        let names: Vec<&str> = PARTITIONS.iter().map(|(id, _)| id.text()).collect();
        tell(&format!(
            "obsid: no partition is called '{}'; there are {}, warden and keeper",
            arguments.name,
            names.join(", ")
        ));
        return ExitCode::from(2);
    };
    let Some(folder) = &arguments.run else {
        tell(&format!("obsid: partition {id} needs --run FOLDER, the folder of a run that its warden has made"));
        return ExitCode::from(2);
    };
    let epoch = match process::epoch_of(&arguments.epoch, folder, *id) {
        Ok(epoch) => epoch,
        Err(wrong) => {
            tell(&format!("obsid: partition {id}: {wrong}"));
            return ExitCode::from(2);
        }
    };
    let life = runtime::life::Life { epoch, cause: arguments.cause, parent: arguments.parent };
    process::exit_code(*id, process::run(*id, *connect, folder, life))
}

fn warden(arguments: &Arguments) -> ExitCode {
    let Some(config) = &arguments.config else {
        tell("obsid: partition warden needs --config FILE");
        return ExitCode::from(2);
    };
    let root = arguments.root.clone().unwrap_or_else(|| PathBuf::from("/dev/shm"));
    let result = load(config).and_then(|(run, _held)| supervise(&run, &root, arguments.images.clone()));
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            tell(&format!("warden: {error}"));
            ExitCode::from(1)
        }
    }
}

/// The run's configuration, and the hold on the console's folder that it was left in.
fn load(path: &Path) -> std::io::Result<(RunConfig, Option<Held>)> {
    let wrong = |error: &dyn std::fmt::Display| std::io::Error::other(format!("{}: {error}", path.display()));
    let text = crate::plants::utf8_text(path).map_err(|(message, _)| std::io::Error::other(message))?;
    let run = serde_json::from_str(&text).map_err(|error| wrong(&error))?;
    Ok((run, Held::of_config(path)))
}

fn supervise(run: &RunConfig, root: &Path, images: Option<PathBuf>) -> std::io::Result<bool> {
    let launcher = Launcher { program: std::env::current_exe()?, images, is_fed: run.feed.is_some() };
    let mut lines = runtime::sys::LineWriter::default();
    let mut report = |report: &Report| {
        // Whoever started the warden may be gone or not reading: the run goes on.
        if let Ok(line) = serde_json::to_string(report) {
            lines.say(&line, matches!(report, Report::Status { .. }));
        }
    };
    warden::run(run, root, &launcher, &mut report)
}
