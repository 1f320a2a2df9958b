//! Carries a run out: as processes under a warden, or in lockstep in this one.

use crate::partition::PARTITIONS;
use crate::progress::Progress;
use crate::scenario_run::{Finished, LinkKind, ScenarioRun, frames_expected};
use crate::scratch::Scratch;
use runtime::RunConfig;
use runtime::lockstep::{self, Ending, LockstepBus};
use runtime::rundir::purge_debris;
use runtime::runner::Runner;
use runtime::statistics::PartitionRow;
use runtime::warden::Report;
use rustix::process::{Pid, Signal, kill_process};
use signal_hook::iterator::Signals;
use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The frames of a turn in lockstep.
const LOCKSTEP_CHUNK: u64 = 25;
/// What the warden says too.
const STOPPED: &str = "stopped by a signal";
/// Time for a dead warden's children, which the kernel kills with it, to be gone.
const ORPHANS_GRACE: Duration = Duration::from_millis(200);

/// Rows as far as they are known, and why the run did not get to its end.
type Ended = (Vec<PartitionRow>, Option<String>);

/// What `signals` tells from here on until the end of the process is this module's business.
///
/// # Errors
/// When the handlers cannot be set.
pub fn take_signals() -> std::io::Result<Signals> {
    Signals::new([signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM])
}

/// Carries `run` out, to its end or as far as it gets.
pub fn launch(
    run: &ScenarioRun,
    link: LinkKind,
    images: Option<&Path>,
    scratch: &Scratch,
    signals: Signals,
) -> Finished {
    let started = Instant::now();
    let progress = Progress::new(frames_expected(run));
    let ended = match link {
        LinkKind::Shm => as_processes(&run.config, images, &progress, scratch, signals),
        LinkKind::Lockstep => in_lockstep(&run.config, &progress, scratch, signals),
    };
    progress.end();
    let (rows, failure) = ended.unwrap_or_else(|failure| (Vec::new(), Some(failure)));
    Finished { rows, wall_s: started.elapsed().as_secs_f64(), link, failure }
}

fn in_lockstep(run: &RunConfig, progress: &Progress, scratch: &Scratch, mut signals: Signals) -> Result<Ended, String> {
    // No warden will.
    purge_debris(scratch.root());
    let bus = LockstepBus::default();
    let mut runners = Vec::new();
    for (_, connect) in PARTITIONS.iter().filter(|(id, _)| run.partitions.contains(id)) {
        let partition = connect(run).map_err(|error| error.to_string())?;
        runners.push(Runner::start(partition, bus.join(), run, 0, None).map_err(|error| error.to_string())?);
    }
    let mut turns = 0_u64;
    let chunk = |_| {
        turns += 1;
        if turns.is_multiple_of(600) {
            progress.show(turns / 6 * LOCKSTEP_CHUNK, "lockstep");
        }
        LOCKSTEP_CHUNK
    };
    let failure = match lockstep::run_to_end(&mut runners, chunk, || signals.pending().next().is_some()) {
        Ok(Ending::Complete) => None,
        Ok(Ending::Stopped) => Some(STOPPED.to_string()),
        Err(error) => Some(error.to_string()),
    };
    Ok((runners.iter().map(PartitionRow::of).collect(), failure))
}

fn as_processes(
    run: &RunConfig,
    images: Option<&Path>,
    progress: &Progress,
    scratch: &Scratch,
    signals: Signals,
) -> Result<Ended, String> {
    let io = |error: std::io::Error| format!("warden: {error}");
    let config = scratch.leave_config(run).map_err(io)?;
    let program = std::env::current_exe().map_err(io)?;
    let mut command = Command::new(program);
    command.args(["partition", "warden", "--config"]).arg(config).arg("--root").arg(scratch.root());
    if let Some(images) = images {
        command.arg("--images").arg(images);
    }
    // A group of its own: the terminal's Ctrl-C reaches the console, which asks the warden to end
    // in order.
    command.process_group(0).stdin(Stdio::null()).stdout(Stdio::piped());
    let mut warden = command.spawn().map_err(io)?;
    // A signal that came before waits in `signals`.
    forward(signals, Pid::from_child(&warden));
    let reports = warden.stdout.take().ok_or("warden: no pipe")?;
    let mut end = None;
    for line in BufReader::new(reports).lines().map_while(Result::ok) {
        if let Some(Report::End { ok, reason, partitions }) = show(&line, progress) {
            end = Some((partitions, (!ok).then_some(reason)));
        }
    }
    let status = warden.wait().map_err(io)?;
    if let Some(end) = end {
        return Ok(end);
    }
    std::thread::sleep(ORPHANS_GRACE);
    purge_debris(scratch.root());
    Err(format!("the warden ended without a result ({status})"))
}

fn show(line: &str, progress: &Progress) -> Option<Report> {
    let report = serde_json::from_str(line).ok()?;
    match &report {
        Report::Started { .. } | Report::End { .. } => {}
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
fn forward(mut signals: Signals, warden: Pid) {
    std::thread::spawn(move || {
        for _ in signals.forever() {
            let _ = kill_process(warden, Signal::TERM);
        }
    });
}
