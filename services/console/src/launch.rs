//! Carries a run out: as processes under a warden, or in lockstep in this one.

use crate::partition::PARTITIONS;
use crate::progress::Progress;
use crate::scenario_run::{Finished, LinkKind, ScenarioRun, frames_expected};
use crate::scratch::Scratch;
use crate::warden_process::{End, Heard, SILENCE, WardenProcess};
use runtime::RunConfig;
use runtime::lockstep::{self, Ending, LockstepBus};
use runtime::rundir::purge_debris;
use runtime::runner::Runner;
use runtime::statistics::PartitionRow;
use runtime::warden::Report;
use rustix::process::{Pid, Signal, kill_process};
use signal_hook::iterator::Signals;
use std::path::Path;
use std::time::Instant;

/// The frames of a turn in lockstep.
const LOCKSTEP_CHUNK: u64 = 25;
/// What the warden says too.
const STOPPED: &str = "stopped by a signal";

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
    let failed = |failure| End { rows: Vec::new(), deaths: Vec::new(), failure: Some(failure) };
    let End { rows, deaths, failure } = ended.unwrap_or_else(failed);
    Finished { rows, deaths, wall_s: started.elapsed().as_secs_f64(), link, failure }
}

fn in_lockstep(run: &RunConfig, progress: &Progress, scratch: &Scratch, mut signals: Signals) -> Result<End, String> {
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
    Ok(End { rows: runners.iter().map(PartitionRow::of).collect(), deaths: Vec::new(), failure })
}

fn as_processes(
    run: &RunConfig,
    images: Option<&Path>,
    progress: &Progress,
    scratch: &Scratch,
    signals: Signals,
) -> Result<End, String> {
    let mut warden = WardenProcess::start(run, images, scratch, &[])?;
    // A signal that came before waits in `signals`.
    forward(signals, warden.pid());
    loop {
        match warden.next(SILENCE) {
            Heard::Report(report) => show(&report, progress),
            Heard::Closed => return Ok(warden.end(scratch)),
            Heard::Nothing => {
                if let Some(silent) = warden.silence() {
                    progress.note(&format!("the warden has been silent for {:.1} s", silent.as_secs_f64()));
                }
            }
        }
    }
}

fn show(report: &Report, progress: &Progress) {
    match report {
        Report::Started { .. } | Report::End { .. } | Report::Beat { .. } | Report::Spawn { .. } => {}
        Report::Status { frame, mode } => progress.show(*frame, mode),
        Report::Death { partition, pid, cause, .. } => progress.note(&format!("{partition} (pid {pid}) died: {cause}")),
        Report::Restart { partition, restarts } => {
            progress.note(&format!("{partition} restarted (restart {restarts})"))
        }
        Report::Hang { partition } => progress.note(&format!("{partition} hangs: its execution counter stands still")),
        Report::Starved { partition } => progress.note(&format!("{partition} gets no processor: the computer is busy")),
        Report::Stall { waits, since_s } => {
            progress.note(&format!("no frame for {since_s:.1} s: {waits}; the services are made anew"))
        }
        Report::Window { partition, window } => progress.note(&format!("{partition}: CPU window: {window}")),
        Report::Health(act) => progress.note(&act.to_string()),
        Report::GivenUp { partition } => progress.note(&format!("{partition} was given up")),
    }
}

/// Ctrl-C and SIGTERM are the warden's business.
fn forward(mut signals: Signals, warden: Pid) {
    std::thread::spawn(move || {
        for _ in signals.forever() {
            let _ = kill_process(warden, Signal::TERM);
        }
    });
}
