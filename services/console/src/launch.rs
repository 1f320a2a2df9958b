//! Carries a run out: as processes under a warden, or in lockstep in this one.

use crate::partition::PARTITIONS;
use crate::progress::Progress;
use crate::{Failure, outcome};
use runtime::RunConfig;
use runtime::lockstep::{self, LockstepBus};
use runtime::runner::Runner;
use runtime::statistics::PartitionRow;
use rustix::process::{Pid, Signal, kill_process};
use serde::Deserialize;
use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

/// What carries the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum LinkKind {
    /// Processes over shared memory.
    Shm,
    /// One thread, partition after partition.
    Lockstep,
}

/// The frames of a turn in lockstep.
const LOCKSTEP_CHUNK: u64 = 25;

/// How a run went.
pub struct Finished {
    pub rows: Vec<PartitionRow>,
    pub wall_s: f64,
}

/// Where runs make their folder.
pub fn root() -> PathBuf {
    std::env::var_os("OBSID_ROOT").map_or_else(|| PathBuf::from("/dev/shm"), PathBuf::from)
}

/// Carries `run` out to its end.
///
/// # Errors
/// [`Failure::Run`] when it does not get there.
pub fn launch(run: &RunConfig, link: LinkKind, images: Option<&Path>) -> Result<Finished, Failure> {
    run.check_depths().map_err(Failure::Run)?;
    let started = Instant::now();
    let progress = Progress::new(outcome::frames_expected(run));
    let rows = match link {
        LinkKind::Shm => as_processes(run, images, &progress),
        LinkKind::Lockstep => in_lockstep(run, &progress),
    };
    progress.end();
    Ok(Finished { rows: rows?, wall_s: started.elapsed().as_secs_f64() })
}

fn in_lockstep(run: &RunConfig, progress: &Progress) -> Result<Vec<PartitionRow>, Failure> {
    let fail = |error: &dyn std::error::Error| Failure::Run(error.to_string());
    let bus = LockstepBus::default();
    let mut runners = Vec::new();
    for (_, connect) in PARTITIONS.iter().filter(|(id, _)| run.partitions.contains(id)) {
        let partition = connect(run).map_err(|error| fail(&error))?;
        runners.push(Runner::start(partition, bus.join(), run, 0, None).map_err(|error| fail(&error))?);
    }
    let mut turns = 0_u64;
    let chunk = |_| {
        turns += 1;
        if turns.is_multiple_of(600) {
            progress.show(turns / 6 * LOCKSTEP_CHUNK, "lockstep");
        }
        LOCKSTEP_CHUNK
    };
    lockstep::run_to_end(&mut runners, chunk).map_err(|error| fail(&error))?;
    Ok(runners.iter().map(PartitionRow::of).collect())
}

fn as_processes(run: &RunConfig, images: Option<&Path>, progress: &Progress) -> Result<Vec<PartitionRow>, Failure> {
    let io = |error: std::io::Error| Failure::Run(format!("warden: {error}"));
    let config = ConfigFile::write(run).map_err(io)?;
    let program = std::env::current_exe().map_err(io)?;
    let mut command = Command::new(program);
    command.args(["partition", "warden", "--config"]).arg(&config.0).arg("--root").arg(root());
    if let Some(images) = images {
        command.arg("--images").arg(images);
    }
    // A group of its own: the terminal's Ctrl-C reaches the console, which asks the warden to end in order.
    command.process_group(0).stdin(Stdio::null()).stdout(Stdio::piped());
    let mut warden = command.spawn().map_err(io)?;
    forward_signals(&warden).map_err(io)?;
    let reports = warden.stdout.take().ok_or_else(|| Failure::Run("warden: no pipe".into()))?;
    let mut end = None;
    for line in BufReader::new(reports).lines().map_while(Result::ok) {
        if let Some(Report::End { ok, reason, partitions }) = show(&line, progress) {
            end = Some(if ok { Ok(partitions) } else { Err(Failure::Run(reason)) });
        }
    }
    let status = warden.wait().map_err(io)?;
    end.unwrap_or_else(|| Err(Failure::Run(format!("the warden ended without a result ({status})"))))
}

/// The warden's lines, as far as the console reads them.
#[derive(Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Report {
    Started {},
    Status { frame: u64, mode: String },
    Death { partition: String, pid: u32, cause: String },
    Restart { partition: String, restarts: u32 },
    Hang { partition: String },
    GivenUp { partition: String },
    End { ok: bool, reason: String, partitions: Vec<PartitionRow> },
}

fn show(line: &str, progress: &Progress) -> Option<Report> {
    let report = serde_json::from_str(line).ok()?;
    match &report {
        Report::Started {} | Report::End { .. } => {}
        Report::Status { frame, mode } => progress.show(*frame, mode),
        Report::Death { partition, pid, cause } => progress.note(&format!("{partition} (pid {pid}) died: {cause}")),
        Report::Restart { partition, restarts } => {
            progress.note(&format!("{partition} restarted (restart {restarts})"))
        }
        Report::Hang { partition } => progress.note(&format!("{partition} hangs: its execution counter stands still")),
        Report::GivenUp { partition } => progress.note(&format!("{partition} was given up")),
    }
    Some(report)
}

/// Ctrl-C and SIGTERM are the warden's business.
fn forward_signals(warden: &Child) -> std::io::Result<()> {
    let pid = Pid::from_child(warden);
    let mut signals = signal_hook::iterator::Signals::new([signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM])?;
    std::thread::spawn(move || {
        for _ in signals.forever() {
            let _ = kill_process(pid, Signal::TERM);
        }
    });
    Ok(())
}

/// The run's configuration on its way to the warden; removed on drop.
struct ConfigFile(PathBuf);

impl ConfigFile {
    fn write(run: &RunConfig) -> std::io::Result<Self> {
        let path = scratch(&format!("obsid-config-{}.json", std::process::id()));
        std::fs::write(&path, serde_json::to_string(run).map_err(std::io::Error::other)?)?;
        Ok(ConfigFile(path))
    }
}

impl Drop for ConfigFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// A results file nobody asked for: removed when the outcome has been read.
pub struct ResultsFile {
    path: PathBuf,
    keep: bool,
}

impl ResultsFile {
    /// The file the user asked for, or one of our own; whether it can be written is found out before the run.
    ///
    /// # Errors
    /// [`Failure::Input`] when it cannot.
    pub fn new(asked: Option<&Path>) -> Result<Self, Failure> {
        let Some(path) = asked else {
            return Ok(ResultsFile {
                path: scratch(&format!("obsid-results-{}.mcap", std::process::id())),
                keep: false,
            });
        };
        // Nothing is cut here: a file of an earlier run stands until the new run begins.
        std::fs::OpenOptions::new().append(true).create(true).open(path).map_err(|error| {
            Failure::Input(miette::miette!(
                help = "--record takes the path of a file, in a folder that exists and may be written to",
                "{}: cannot be written: {error}",
                path.display()
            ))
        })?;
        Ok(ResultsFile { path: std::path::absolute(path).unwrap_or_else(|_| path.into()), keep: true })
    }
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for ResultsFile {
    fn drop(&mut self) {
        if !self.keep {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

fn scratch(name: &str) -> PathBuf {
    std::env::temp_dir().join(name)
}
