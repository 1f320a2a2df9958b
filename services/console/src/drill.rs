//! `obsid drill`: faults into real runs, and whether anything of the results shows them.

mod injector;
mod plan;
mod tally;

use crate::outcome::recorded_results;
use crate::scenario_run::ScenarioRun;
use crate::scratch::Scratch;
use crate::{Failure, interrupt, launch, run, scenario_file};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use injector::Flown;
use plan::{Kind, Random, RunPlan};
use runtime::config::{Fault, KillPoint};
use runtime::statistics::PartitionRow;
use serde_json::json;
use std::fmt::Write as _;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tally::{ByFault, Tally, Verdict};
use telemetry::TOPICS;

/// Share of the cores that may be busy before the drill for times to count.
const IDLE_LOAD_PER_CORE: f64 = 0.3;

/// Where standard error is no terminal, what the drill has come to is said so often.
const SAY_EVERY: Duration = Duration::from_secs(60);

/// Inject faults into real runs and compare the results with the undisturbed ones
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid drill                                   100 kills and every kind of fault
  obsid drill --kills 1000 --seed 7 --json      more kills, another seed, result as one JSON object
  obsid drill --faults kill,young --minutes 60  an hour of two kinds of kills
  obsid drill --faults list                     the kinds of faults

Exit code 1 when a requirement is not met: equal digests, nothing lost without being declared, nothing torn, no run
wedged or failed, nothing left behind, the warden's log equal to the injector's; on a computer that is otherwise idle
also the times of detection and recovery. Times of strikes are drawn from the seed; what a process does at that
moment is not. An interrupted drill reports what it has come to.")]
pub struct Arguments {
    /// Scenario file; without one the benchmark's short one (deploy/scenarios/short.toml, built in)
    scenario: Option<PathBuf>,
    /// Runs are flown until so many processes were killed
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..))]
    kills: u64,
    /// Of the plan: who is struck when, by what
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Runs are flown for so long, however many kills there were
    #[arg(long, value_name = "M")]
    minutes: Option<f64>,
    /// Kinds of faults, separated by commas; `list` prints them
    #[arg(long, value_name = "LIST", value_parser = kinds)]
    faults: Option<Kinds>,
    /// Simulated over real time at most
    #[arg(long, value_name = "N", default_value_t = 20.0)]
    speed: f64,
    /// One JSON object on standard output, all else on standard error
    #[arg(long)]
    json: bool,
}

/// The kinds that were chosen; none: the list was asked for.
#[derive(Clone, Debug)]
struct Kinds(Vec<Kind>);

fn kinds(text: &str) -> Result<Kinds, String> {
    if text == "list" {
        return Ok(Kinds(Vec::new()));
    }
    let of = |word: &str| {
        let all: Vec<&str> = Kind::ALL.iter().map(|(_, word, _)| *word).collect();
        Kind::named(word).ok_or_else(|| format!("'{word}': one of {}, or list", all.join(", ")))
    };
    text.split(',').map(of).collect::<Result<_, _>>().map(Kinds)
}

/// Flies runs with faults until enough processes were killed, and says what came of it.
///
/// # Errors
/// [`Failure::Run`] when a requirement is not met, [`Failure::Input`] for a scenario that cannot be
/// flown, [`Failure::Interrupted`].
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.faults.as_ref().is_some_and(|kinds| kinds.0.is_empty()) {
        Kind::ALL.iter().for_each(|(_, word, what)| crate::print(&format!("{word:<12} {what}\n")));
        return Ok(());
    }
    let every: Vec<Kind> = Kind::ALL.iter().map(|(kind, ..)| *kind).collect();
    let kinds = arguments.faults.as_ref().map_or(every, |kinds| kinds.0.clone());
    let interrupted = interrupt::flag()?;
    let opened = match &arguments.scenario {
        Some(path) => scenario_file::read(path)?,
        None => scenario_file::short_scenario()?,
    };
    let mut scenario = run::config(opened, &run::Common::default(), None)?;
    scenario.config.speed = Some(arguments.speed);
    let idle = load_per_core() < IDLE_LOAD_PER_CORE;
    let reference = Reference::fly(&scenario)?;
    let mut drill = Drill {
        arguments,
        scenario,
        reference,
        all: Tally { is_sum: true, ..Tally::default() },
        by: ByFault::new(),
        runs: 0,
    };
    drill.campaign(&kinds, &interrupted)?;
    let interrupted = interrupted.load(Ordering::Relaxed);
    drill.report(idle, interrupted)?;
    if interrupted { Err(Failure::Interrupted) } else { Ok(()) }
}

/// Of one minute, over the number of cores.
fn load_per_core() -> f64 {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let load: f64 = text.split(' ').next().and_then(|word| word.parse().ok()).unwrap_or(0.0);
    load / std::thread::available_parallelism().map_or(1.0, |cores| usize::from(cores) as f64)
}

/// The undisturbed run, in lockstep.
struct Reference {
    digest: String,
    rows: Vec<PartitionRow>,
    frames: u64,
}

impl Reference {
    fn fly(scenario: &ScenarioRun) -> Result<Self, Failure> {
        let scratch = Scratch::new()?;
        let mut run = ScenarioRun { config: scenario.config.clone(), scenario: scenario.scenario.clone() };
        run.config.record = scratch.file("reference.mcap");
        let signals = launch::take_signals().map_err(|error| Failure::Run(format!("signals: {error}")))?;
        let lockstep = crate::scenario_run::LinkKind::Lockstep;
        let finished = launch::launch(&run, lockstep, None, &scratch, signals);
        if let Some(reason) = finished.failure {
            return Err(Failure::Run(format!("the undisturbed run failed: {reason}")));
        }
        let (_, digest) = recorded_results(&run.config.record, false).map_err(Failure::input)?;
        let frames = finished.rows.iter().map(|row| row.frames).max().unwrap_or(0);
        Ok(Reference { digest, rows: finished.rows, frames })
    }
}

struct Drill<'a> {
    arguments: &'a Arguments,
    scenario: ScenarioRun,
    reference: Reference,
    all: Tally,
    by: ByFault,
    runs: u64,
}

impl Drill<'_> {
    fn campaign(&mut self, kinds: &[Kind], interrupted: &AtomicBool) -> Result<(), Failure> {
        let (started, bar) = (Instant::now(), bar(self.arguments.kills));
        let mut said = Instant::now();
        let period_s = self.scenario.config.period_ns as f64 * 1e-9;
        let flight_us = (self.reference.frames as f64 * period_s / self.arguments.speed * 1e6) as u64;
        let is_over = |drill: &Self| match self.arguments.minutes {
            Some(minutes) => started.elapsed().as_secs_f64() > 60.0 * minutes,
            // Every kind at least once: they are what the drill is for.
            None => drill.all.kills >= drill.arguments.kills && drill.runs >= kinds.len() as u64,
        };
        while !is_over(self) && !interrupted.load(Ordering::Relaxed) {
            let plan = plan::plan(self.arguments.seed, self.runs, kinds, flight_us.max(1));
            bar.set_message(format!("run {}: {}", self.runs + 1, plan.kind.word()));
            self.fly(&plan, interrupted)?;
            bar.set_position(self.all.kills);
            if bar.is_hidden() && said.elapsed() >= SAY_EVERY {
                said = Instant::now();
                crate::tell(&self.so_far(started.elapsed()));
            }
        }
        bar.finish_and_clear();
        Ok(())
    }

    fn so_far(&self, elapsed: Duration) -> String {
        let (minutes, all) = (elapsed.as_secs() / 60, &self.all);
        let faults = all.digests_differing + all.undeclared_lost + all.torn + all.wedged + all.leaks + all.failed;
        format!("drill: {minutes} min, {} runs, {} kills, {faults} times a result shows a fault", self.runs, all.kills)
    }

    fn fly(&mut self, plan: &RunPlan, interrupted: &AtomicBool) -> Result<(), Failure> {
        let scratch = if plan.kind == Kind::Shm { Scratch::at(&std::env::temp_dir())? } else { Scratch::new()? };
        let mut config = self.scenario.config.clone();
        config.record = scratch.file("results.mcap");
        config.faults = self.own_faults(plan);
        if plan.kind == Kind::Disk {
            config.record_all = true;
            config.results = Some(core::mem::replace(&mut config.record, "/dev/full".into()));
        }
        let results = config.results.clone().unwrap_or_else(|| config.record.clone());
        let flown = injector::fly(&config, plan, &scratch, interrupted).map_err(Failure::Run)?;
        self.runs += 1;
        if flown.interrupted {
            return Ok(());
        }
        let verdict = self.judge(plan.kind, &flown, &results);
        self.all.add(plan.kind, &flown, &verdict);
        self.by.entry(plan.kind).or_default().add(plan.kind, &flown, &verdict);
        Ok(())
    }

    /// Faults that partitions inject into themselves.
    fn own_faults(&self, plan: &RunPlan) -> Vec<Fault> {
        let frame_of = |permille: u64| self.reference.frames * permille / 1000;
        let mut faults: Vec<Fault> = plan
            .own
            .iter()
            .map(|&(kind, partition, permille, number)| {
                let frame = frame_of(permille);
                match kind {
                    Kind::Crash => Fault::Crash { partition, frame },
                    Kind::Checkpoint => Fault::Tear { partition, frame, permille: number as u32 },
                    _ => {
                        let point = KillPoint::NAMES[number as usize % KillPoint::NAMES.len()].1;
                        Fault::Kill { partition, frame, point }
                    }
                }
            })
            .collect();
        if plan.kind == Kind::Corrupt {
            let mut random = Random(self.arguments.seed ^ self.runs);
            faults.extend(
                (0..TOPICS.len())
                    .map(|topic| Fault::Corrupt { frame: frame_of(random.below(900)), topic: Some(topic) }),
            );
        }
        faults
    }

    fn judge(&self, kind: Kind, flown: &Flown, results: &std::path::Path) -> Verdict {
        let rows = &flown.end.rows;
        let losses = crate::outcome::Loss::all(rows);
        let digest = recorded_results(results, false).map(|(_, digest)| digest);
        let is_whole = flown.end.failure.is_none() && losses.is_empty();
        let undeclared = |row: &PartitionRow| {
            let whole = self.reference.rows.iter().find(|whole| whole.name == row.name);
            whole.map_or(0, |whole| whole.frames.saturating_sub(row.frames))
        };
        // What the drill itself damages is to be rejected; nobody else may damage a sample.
        let damages = matches!(kind, Kind::Corrupt | Kind::Rogue);
        Verdict {
            digest_differs: is_whole && digest.as_ref().ok() != Some(&self.reference.digest),
            undeclared_lost: if is_whole { rows.iter().map(undeclared).sum() } else { 0 },
            torn: if damages { 0 } else { rows.iter().map(|row| row.bad).sum() },
            failure: flown.end.failure.clone().filter(|_| !flown.wedged),
            declared: losses.iter().map(ToString::to_string).collect(),
        }
    }

    fn report(&self, idle: bool, interrupted: bool) -> Result<(), Failure> {
        let requirements = self.all.requirements(idle);
        let unmet: Vec<String> =
            requirements.iter().filter(|(.., met)| !met).map(|(name, value, _)| format!("{name} {value}")).collect();
        if self.arguments.json {
            let mut object = self.all.json();
            object["seed"] = json!(self.arguments.seed);
            object["idle"] = json!(idle);
            object["interrupted"] = json!(interrupted);
            object["by_fault"] = self.by.iter().map(|(kind, tally)| by_fault(*kind, tally)).collect();
            object["requirements"] = requirements
                .iter()
                .map(|(name, value, met)| json!({ "name": name, "measured": value, "met": met }))
                .collect();
            object["met"] = json!(unmet.is_empty());
            crate::print(&format!("{object}\n"));
        } else {
            crate::print(&self.table(idle));
        }
        if unmet.is_empty() { Ok(()) } else { Err(Failure::Run(format!("requirements not met: {}", unmet.join(", ")))) }
    }

    fn table(&self, idle: bool) -> String {
        let mut text = format!(
            "{:<12} {:>5} {:>6} {:>6} {:>8} {:>6} {:>5} {:>6} {:>6} {:>6}  {:>10} {:>10} {:>10}\n",
            "fault",
            "runs",
            "kills",
            "struck",
            "differ",
            "lost",
            "torn",
            "wedged",
            "leaks",
            "failed",
            "detect p99",
            "recover p50",
            "p99 [ms]"
        );
        let rows = self.by.iter().map(|(kind, tally)| (kind.word(), tally)).chain([("all", &self.all)]);
        for (name, tally) in rows {
            let ms =
                |values: &[f64], p| tally::order_statistic(values, p).map_or("-".into(), |value| format!("{value:.2}"));
            let _ = writeln!(
                text,
                "{name:<12} {:>5} {:>6} {:>6} {:>8} {:>6} {:>5} {:>6} {:>6} {:>6}  {:>10} {:>10} {:>10}",
                tally.runs,
                tally.kills,
                tally.struck,
                tally.digests_differing,
                tally.undeclared_lost,
                tally.torn,
                tally.wedged,
                tally.leaks,
                tally.failed,
                ms(&tally.detect_ms, 0.99),
                ms(&tally.recover_ms, 0.50),
                ms(&tally.recover_ms, 0.99),
            );
        }
        let (cuts, hangs) = (self.all.cuts, self.all.hang_ms.len());
        let _ = writeln!(text, "\n{cuts} cuts of checkpoints read, {} taken for whole", self.all.cuts_taken);
        if let Some(p99) = tally::order_statistic(&self.all.hang_ms, 0.99) {
            let _ = writeln!(text, "{hangs} hangs found, p99 {p99:.0} ms after the last sign of life");
        }
        for reason in &self.all.reasons {
            let _ = writeln!(text, "  {reason}");
        }
        if !idle {
            text.push_str("the computer was busy before the drill: times are reported, not judged\n");
        }
        text
    }
}

fn by_fault(kind: Kind, tally: &Tally) -> serde_json::Value {
    let mut object = tally.json();
    object["fault"] = json!(kind.word());
    object
}

/// Kills so far; hidden where standard error is no terminal.
fn bar(kills: u64) -> ProgressBar {
    let target =
        if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(kills), target);
    let style = ProgressStyle::with_template("{elapsed_precise} [{bar:30}] {pos}/{len} kills, {msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
