//! `obsid events`: what partitions reported, of a run that flies or of a recording.
//!
//! A run is read out of the ring files of its partitions, without joining it.

use crate::{Failure, attach, interrupt};
use clap::ValueEnum;
use runtime::events::read_log;
use runtime::resets::{self, Reset};
use runtime::rundir::{self, RunDir};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Duration;
use telemetry::{EVENT, Event, PartitionId, Severity, Stamps};

const LOOK_EVERY: Duration = Duration::from_millis(100);

/// Show what partitions reported: restarts, losses, late frames, commands, tables
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid events                                the newest run: what was reported, then what is, until it ends
  obsid events --once --json                  what was reported so far, as one JSON object
  obsid events flight.mcap                    of a recording
  obsid events --min-severity warning         no information
  obsid events --partition slosh-id --once    of one partition
  obsid events --resets /var/lib/obsid        restarts over all runs
  obsid events --list                         every event there is, with its arguments

Of each code a partition sends at most so many in a window (obsid tables list monitor); the others are counted, and the
next event, or a summary, says how many. Of a run that flies the newest 1024 events of each partition are kept.")]
pub struct Arguments {
    /// Folder of a run, or a recording (MCAP); without it the newest run
    source: Option<PathBuf>,
    /// Leaves out what is less grave
    #[arg(long, value_enum, default_value = "information")]
    min_severity: Gravity,
    /// Of this partition alone
    #[arg(long, value_name = "NAME")]
    partition: Option<String>,
    /// What was reported so far; does not wait for more
    #[arg(long)]
    once: bool,
    /// One JSON object on standard output, when the run ends or is no longer watched
    #[arg(long)]
    json: bool,
    /// Restarts over all runs that kept their log in this folder (obsid run --keep)
    #[arg(long, value_name = "DIR", conflicts_with_all = ["source", "once", "list"])]
    resets: Option<PathBuf>,
    /// Every code, with severity and arguments
    #[arg(long, conflicts_with_all = ["source", "once"])]
    list: bool,
}

/// Severities of the command line.
#[derive(Clone, Copy, ValueEnum)]
enum Gravity {
    Information,
    Warning,
    Alarm,
}

/// Shows events until the run ends.
///
/// # Errors
/// [`Failure::Input`] when no run flies or the recording cannot be read, [`Failure::Interrupted`].
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.list {
        crate::print(&crate::icd::event_list(arguments.json));
        return Ok(());
    }
    let mut filter = Filter::new(arguments)?;
    let (result, key) = match (&arguments.resets, &arguments.source) {
        (Some(folder), _) => {
            filter.print_resets(&resets::read(&resets::file(folder)));
            (Ok(()), "resets")
        }
        (None, Some(file)) if file.is_file() => (of_recording(file, &mut filter), "events"),
        (None, source) => (of_run(source.clone(), &mut filter, arguments.once), "events"),
    };
    // One object, also of what was known when it was interrupted.
    if arguments.json && matches!(result, Ok(()) | Err(Failure::Interrupted)) {
        crate::print(&format!("{}\n", json!({ key: filter.objects, "interrupted": result.is_err() })));
    }
    result
}

fn of_recording(file: &Path, filter: &mut Filter) -> Result<(), Failure> {
    let recorded = recording::read_mcap_topics(file, |topic| topic == EVENT.id).map_err(Failure::input)?;
    let mut all: Vec<(Stamps, Event)> = recorded.of(EVENT).map(|(stamps, event)| (*stamps, *event)).collect();
    all.sort_by_key(|(stamps, _)| stamps.sent_ns);
    filter.print(&all);
    Ok(())
}

fn of_run(source: Option<PathBuf>, filter: &mut Filter, once: bool) -> Result<(), Failure> {
    let interrupted = interrupt::flag()?;
    let dir = attach::living(source)?;
    let mut shown = BTreeMap::new();
    loop {
        // Before the look, so that the last events of a run that ends are seen.
        let alive = rundir::is_alive(dir.path());
        filter.print(&fresh(&dir, &mut shown));
        if once || !alive {
            return Ok(());
        }
        if interrupted.load(Ordering::Relaxed) {
            return Err(Failure::Interrupted);
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

/// What no earlier look has seen, in the order in which it was sent.
fn fresh(dir: &RunDir, shown: &mut BTreeMap<PartitionId, (u32, u64)>) -> Vec<(Stamps, Event)> {
    let mut all = Vec::new();
    for &id in PartitionId::ALL {
        let last = shown.entry(id).or_default();
        for (stamps, event) in read_log(&dir.events(id)) {
            let place = (stamps.epoch, event.header.seq);
            if place > *last {
                *last = place;
                all.push((stamps, event));
            }
        }
    }
    all.sort_by_key(|(stamps, _)| stamps.sent_ns);
    all
}

struct Filter {
    least: Severity,
    partition: Option<PartitionId>,
    json: bool,
    /// What passed, for one object at the end.
    objects: Vec<Value>,
}

impl Filter {
    fn new(arguments: &Arguments) -> Result<Self, Failure> {
        let least = match arguments.min_severity {
            Gravity::Information => Severity::Information,
            Gravity::Warning => Severity::Warning,
            Gravity::Alarm => Severity::Alarm,
        };
        let named = |name: &String| attach::partition(name);
        let partition = arguments.partition.as_ref().map(named).transpose()?;
        Ok(Filter { least, partition, json: arguments.json, objects: Vec::new() })
    }

    fn show(&mut self, text: impl FnOnce() -> String, object: impl FnOnce() -> Value) {
        if self.json {
            self.objects.push(object());
        } else {
            crate::print(&format!("{}\n", text()));
        }
    }

    fn print_resets(&mut self, all: &[Reset]) {
        let partition = self.partition;
        for reset in all.iter().filter(|reset| partition.is_none_or(|id| id == reset.partition)) {
            let Reset { number, unix_ns, partition, epoch, cause } = *reset;
            let time = utc(unix_ns);
            let text = || {
                let cause = match cause {
                    0 => "unknown".to_string(),
                    1..=255 => format!("signal {cause}"),
                    _ => format!("exit code {}", cause - 256),
                };
                format!("{number:>6}  {time}  {partition:<12} restart {epoch}: {cause}")
            };
            let object = || json!({ "number": number, "time": time, "partition": partition.text(), "epoch": epoch, "cause": cause });
            self.show(text, object);
        }
    }

    fn print(&mut self, events: &[(Stamps, Event)]) {
        let (least, partition) = (self.least, self.partition);
        let wanted =
            |event: &Event| event.known_severity() >= least && partition.is_none_or(|id| id.code() == event.partition);
        for (stamps, event) in events.iter().filter(|(_, event)| wanted(event)) {
            self.show(|| text(stamps, event), || object(stamps, event));
        }
    }
}

/// `2026-11-27T01:09:51.250Z`.
fn utc(unix_ns: u64) -> String {
    jiff::Timestamp::from_nanosecond(unix_ns.into()).map_or_else(|_| format!("{unix_ns} ns"), |at| format!("{at:.3}"))
}

fn name_of(event: &Event) -> String {
    PartitionId::from_code(event.partition).map_or(event.partition.to_string(), |id| id.text().into())
}

fn text(stamps: &Stamps, event: &Event) -> String {
    let (t_s, severity) = (stamps.sent_ns as f64 * 1e-9, event.known_severity());
    format!("{t_s:>14.3} s  frame {:<8} {:<12} {severity:<11} {event}", event.frame, name_of(event))
}

fn object(stamps: &Stamps, event: &Event) -> Value {
    let infos = event.known_code().map_or(&[][..], telemetry::EventCode::arguments);
    let used = event.argument.iter().take(event.count.into());
    let arguments: serde_json::Map<String, Value> =
        infos.iter().zip(used).map(|(info, value)| (info.name.to_string(), json!(value))).collect();
    json!({
        "sent_s": stamps.sent_ns as f64 * 1e-9, "epoch": stamps.epoch, "frame": event.frame,
        "partition": name_of(event), "severity": event.known_severity().text(), "code": event.code,
        "event": event.known_code().map(telemetry::EventCode::text), "arguments": arguments,
        "squelched": event.squelched, "text": event.to_string(),
    })
}
