//! `obsid top`: a run that flies, as a table that renews itself; the run may have been started
//! anywhere by the same user.
//!
//! It reads what the run leaves in its folder and what the kernel says of its processes. It joins
//! no shared memory, so that it cannot disturb what it looks at.

use crate::{Failure, attach, interrupt};
use runtime::rundir::{self, RunDir};
use runtime::statistics::{LifeFigures, latest};
use runtime::usage::Usage;
use runtime::warden::Report;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Newest events that are shown.
const EVENTS: usize = 8;
/// Clears the terminal and goes to its first line (ECMA-48).
const CLEAR: &str = "\x1b[H\x1b[2J";
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Watch a run that flies: rates, latency, CPU, misses, modes, restarts, last events
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid top                     the newest run of this user, renewed every second
  obsid top --interval 0.5      twice a second
  obsid top --once              one table, for a script
  obsid top --once --json       one JSON object

Runs are looked for in OBSID_ROOT, or /dev/shm. The table ends with the run.")]
pub struct Arguments {
    /// Folder of the run; without it the newest one
    run: Option<PathBuf>,
    /// Between two tables
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0)]
    interval: f64,
    /// One table of the next interval
    #[arg(long)]
    once: bool,
    /// One JSON object on standard output
    #[arg(long, requires = "once")]
    json: bool,
}

/// Shows the run until it ends.
///
/// # Errors
/// [`Failure::Input`] when no run flies, [`Failure::Interrupted`].
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if !(arguments.interval > 0.0 && arguments.interval < 3600.0) {
        let help = "give a time above 0 and below 3600";
        return Err(Failure::Input(miette::miette!(help = help, "--interval {}", arguments.interval)));
    }
    let interrupted = interrupt::flag()?;
    let dir = attach::living(arguments.run.clone())?;
    let clear = std::io::stdout().is_terminal() && !arguments.once;
    let mut before = Look::at(&dir);
    loop {
        let began = Instant::now();
        while began.elapsed().as_secs_f64() < arguments.interval {
            std::thread::sleep(LOOK_EVERY);
            if interrupted.load(Ordering::Relaxed) {
                return Err(Failure::Interrupted);
            }
        }
        if !rundir::is_alive(dir.path()) {
            crate::tell("the run has ended");
            return Ok(());
        }
        let now = Look::at(&dir);
        let text = if arguments.json { format!("{}\n", now.json(&before)) } else { now.table(&dir, &before) };
        crate::print(&if clear { format!("{CLEAR}{text}") } else { text });
        if arguments.once {
            return Ok(());
        }
        before = now;
    }
}

/// What is known of a partition at a moment.
#[derive(Default)]
struct Seen {
    pid: Option<u32>,
    epoch: u32,
    figures: Option<LifeFigures>,
    usage: Usage,
}

/// A look at a run.
struct Look {
    at: Instant,
    frame: u64,
    mode: String,
    partitions: BTreeMap<&'static str, Seen>,
    events: Vec<String>,
}

impl Look {
    fn at(dir: &RunDir) -> Self {
        let status: Value = read(dir.status()).and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default();
        let log = read(dir.log()).unwrap_or_default();
        let reports: Vec<Report> = log.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
        let mut partitions: BTreeMap<&'static str, Seen> = BTreeMap::new();
        let of_run = dir.load().map_or_else(|_| crate::partition::of_run(false), |run| run.partitions);
        for id in &of_run {
            let mut seen = Seen { figures: latest(dir, *id), ..Seen::default() };
            for report in &reports {
                if let Report::Spawn { partition, pid, epoch, .. } = report
                    && partition == id.text()
                {
                    (seen.pid, seen.epoch) = (Some(*pid), *epoch);
                }
            }
            seen.usage = seen.pid.and_then(Usage::of).unwrap_or_default();
            partitions.insert(id.text(), seen);
        }
        let events: Vec<String> = reports.iter().filter_map(event).collect();
        Look {
            at: Instant::now(),
            frame: status["frame"].as_u64().unwrap_or(0),
            mode: status["mode"].as_str().unwrap_or("-").to_string(),
            partitions,
            events: events[events.len().saturating_sub(EVENTS)..].to_vec(),
        }
    }

    /// Name, frames a second, processor share [%] since `before`.
    fn rates(&self, before: &Self) -> Vec<(&'static str, f64, f64)> {
        let passed_s = self.at.duration_since(before.at).as_secs_f64().max(1e-3);
        let frames = |seen: &Seen| seen.figures.as_ref().map_or(0, |figures| figures.frames) as f64;
        let of = |(name, now): (&&'static str, &Seen)| {
            let old = before.partitions.get(*name);
            let rate = (frames(now) - old.map_or(0.0, frames)) / passed_s;
            let same = old.is_some_and(|old| old.pid == now.pid);
            let run_s = now.usage.run_s - old.filter(|_| same).map_or(0.0, |old| old.usage.run_s);
            // A process that has just died has no time any more.
            (*name, rate.max(0.0), (100.0 * run_s / passed_s).max(0.0))
        };
        self.partitions.iter().map(of).collect()
    }

    fn table(&self, dir: &RunDir, before: &Self) -> String {
        let mut text = format!("{}  frame {}  {}\n\n", dir.path().display(), self.frame, self.mode);
        let _ = writeln!(
            text,
            "{:<12} {:>8} {:>10} {:>9} {:>7} {:>10} {:>10} {:>10} {:>7} {:>8} {:>7}",
            "partition",
            "pid",
            "frame",
            "frames/s",
            "CPU %",
            "p50 [us]",
            "p99 [us]",
            "frame max",
            "misses",
            "restarts",
            "lost"
        );
        for (name, rate, cpu) in self.rates(before) {
            let seen = &self.partitions[name];
            let figures = seen.figures.clone().unwrap_or_default();
            let times = &figures.times;
            let _ = writeln!(
                text,
                "{name:<12} {:>8} {:>10} {rate:>9.0} {cpu:>7.1} {:>10.0} {:>10.0} {:>10.0} {:>7} {:>8} {:>7}",
                seen.pid.map_or("-".into(), |pid| pid.to_string()),
                figures.frames,
                times.latency.percentile_us(0.5),
                times.latency.percentile_us(0.99),
                times.frame.max_us(),
                times.deadline_misses,
                seen.epoch,
                figures.counters.lost,
            );
        }
        text.push_str("\nlast events\n");
        for event in &self.events {
            let _ = writeln!(text, "  {event}");
        }
        text
    }

    fn json(&self, before: &Self) -> Value {
        let partition = |(name, rate, cpu): (&'static str, f64, f64)| {
            let seen = &self.partitions[name];
            let figures = seen.figures.clone().unwrap_or_default();
            json!({
                "name": name, "pid": seen.pid, "restarts": seen.epoch, "frames": figures.frames,
                "frames_per_s": rate, "cpu_percent": cpu,
                "latency_us_p50": figures.times.latency.percentile_us(0.5),
                "latency_us_p99": figures.times.latency.percentile_us(0.99),
                "frame_us_max": figures.times.frame.max_us(), "deadline_misses": figures.times.deadline_misses,
                "lost": figures.counters.lost,
            })
        };
        json!({
            "frame": self.frame, "mode": self.mode, "events": self.events,
            "partitions": self.rates(before).into_iter().map(partition).collect::<Vec<_>>(),
        })
    }
}

fn read(path: PathBuf) -> Option<String> {
    std::fs::read_to_string(path).ok()
}

/// What an operator wants to know.
fn event(report: &Report) -> Option<String> {
    match report {
        Report::Death { partition, pid, cause, .. } => Some(format!("{partition} (pid {pid}) died: {cause}")),
        Report::Restart { partition, restarts } => Some(format!("{partition} restarted (restart {restarts})")),
        Report::Hang { partition } => Some(format!("{partition} hangs")),
        Report::Starved { partition } => Some(format!("{partition} gets no processor")),
        Report::Stall { waits, since_s } => Some(format!("no frame for {since_s:.1} s: {waits}")),
        Report::Window { partition, window } => Some(format!("{partition}: CPU window: {window}")),
        Report::Health(act) => Some(act.to_string()),
        Report::GivenUp { partition } => Some(format!("{partition} was given up")),
        Report::Spawn { partition, pid, epoch: 0, .. } => Some(format!("{partition} started (pid {pid})")),
        _ => None,
    }
}
