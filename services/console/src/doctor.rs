//! `obsid doctor`: what is wrong with recordings, before any model is held against them.

mod page;

use crate::intake::{self, IntakeArguments};
use crate::progress::Share;
use crate::recordings::{self, Loaded, ReportFile, wrapped};
use crate::{Failure, interrupt, plants};
use discovery::against_plant::examine_for;
use dynamics::description::Plant;
use examination::doctor::{Check, Finding, Severity, examine_with};
use identification::work::Watch;
use report::text::{short, with_sigma};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;

/// Examine recordings: rate, gaps, lag, units, signs, derived channels, excitation, segments
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid doctor rig.csv                                what is wrong, with numbers, evidence and cure
  obsid doctor rig.csv --plant rig.toml --out report  what does not fit the plant, too; figures in report/doctor.html
  obsid doctor day1.csv.gz day2.mcap --json           doctor[]{check, channel, value, unit, evidence, cure} as one object

Findings are an answer, not a failure: the exit code is 0. An interruption prints those of the recordings examined so far, with exit
code 130.")]
pub struct Arguments {
    /// CSV and its kin, MCAP, universal files, …; a file in which time starts again is several
    /// recordings
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// Its actuators are inputs, its sensors outputs; what it needs and the recording does not hold
    /// is a fault
    #[arg(long, value_name = "FILE")]
    plant: Option<PathBuf>,
    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
    /// Write doctor.html, one page with figures, to this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    intake: IntakeArguments,
}

/// A recording and what was found in it.
struct Examined {
    loaded: Loaded,
    findings: Vec<Finding>,
}

/// # Errors
/// [`Failure::Input`] for a recording or a plant that cannot be read, [`Failure::Run`] when the
/// report cannot be written, [`Failure::Interrupted`] once what is known so far was printed.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let plant = arguments.plant.as_deref().map(plants::read).transpose()?;
    if arguments.intake.list {
        let files: Vec<_> = arguments.recordings.iter().map(PathBuf::as_path).collect();
        return intake::list(&files, &arguments.intake, arguments.json);
    }
    let intake = arguments.intake.intake(plant.as_ref())?;
    let mut loaded = Vec::new();
    for path in &arguments.recordings {
        loaded.extend(recordings::read(path, &intake, plant.as_ref())?);
    }
    let out = arguments.out.as_deref().map(|folder| ReportFile::new(folder, "doctor.html")).transpose()?;
    let watch = Watch::stopped_by(interrupt::flag()?);
    let examined = examine_all(loaded, plant.as_ref(), &watch);
    let interrupted = watch.is_stopped();
    if let Some(out) = &out {
        out.write(&page::page(&examined, &again(arguments)))?;
    }
    let written = out.map(|out| out.path());
    crate::print(&if arguments.json {
        format!("{}\n", as_json(&examined, written.as_deref(), interrupted))
    } else {
        let first = if interrupted { "interrupted: what is known so far\n" } else { "" };
        format!("{first}{}", in_words(&examined, written.as_deref()))
    });
    if interrupted { Err(Failure::Interrupted) } else { Ok(()) }
}

/// An interruption leaves the rest of the recordings out.
fn examine_all(loaded: Vec<Loaded>, plant: Option<&Plant>, watch: &Watch) -> Vec<Examined> {
    let size = |l: &Loaded| l.recording.channels.iter().map(|c| c.value.len()).sum::<usize>() as f64;
    let (all, mut done) = (loaded.iter().map(size).sum::<f64>().max(1.0), 0.0);
    let bar = Share::new("examined");
    let examined = loaded
        .into_iter()
        .take_while(|_| !watch.is_stopped())
        .map(|loaded| {
            let own = size(&loaded);
            let progress = &mut |part: f64| bar.show((done + part * own) / all);
            let findings = match plant {
                Some(plant) => examine_for(&loaded.recording, plant, watch, progress),
                None => examine_with(&loaded.recording, progress),
            };
            done += own;
            Examined { loaded, findings }
        })
        .collect();
    bar.end();
    examined
}

/// The command that makes the page again.
fn again(arguments: &Arguments) -> String {
    let mut words = vec!["obsid".to_owned(), "doctor".to_owned()];
    words.extend(arguments.recordings.iter().map(|path| path.display().to_string()));
    words.extend(arguments.intake.words());
    for (flag, value) in [("--plant", &arguments.plant), ("--out", &arguments.out)] {
        words.extend(value.iter().flat_map(|value| [flag.to_owned(), value.display().to_string()]));
    }
    recordings::command_line(&words)
}

fn as_json(examined: &[Examined], report: Option<&str>, interrupted: bool) -> Value {
    let finding = |of: &Examined, f: &Finding| {
        json!({ "recording": of.loaded.recording.name, "check": f.check, "severity": f.severity, "channel": f.channel,
            "others": f.others, "value": f.value, "sigma": f.sigma, "unit": f.unit, "evidence": f.evidence, "cure": f.cure })
    };
    let findings: Vec<Value> = examined.iter().flat_map(|e| e.findings.iter().map(|f| finding(e, f))).collect();
    let recordings: Vec<Value> = examined.iter().map(recording_as_json).collect();
    json!({ "recordings": recordings, "doctor": findings, "report": report, "interrupted": interrupted })
}

/// The recording, each channel with what was found of its samples, null where nothing was.
fn recording_as_json(examined: &Examined) -> Value {
    let Examined { loaded, findings } = examined;
    let mut value = loaded.as_json();
    let channels = value["channels"].as_array_mut().into_iter().flatten();
    for (of, channel) in channels.zip(&loaded.recording.channels) {
        let found = |check: Check| findings.iter().find(|f| f.check == check && f.channel == channel.name);
        let share = |level: f64| share_at(&channel.value, level);
        of["held_rate_hz"] = json!(found(Check::Held).map(|f| f.value));
        of["delay_s"] = json!(found(Check::Delay).map(|f| f.value));
        of["delay_sigma_s"] = json!(found(Check::Delay).and_then(|f| f.sigma));
        of["clipped"] = json!(found(Check::Saturation).map(|f| json!({ "level": f.value, "share": share(f.value) })));
    }
    value
}

/// Share of the values that stand at a level.
fn share_at(values: &[f64], level: f64) -> f64 {
    values.iter().filter(|value| **value == level).count() as f64 / values.len().max(1) as f64
}

/// The findings of a recording, worst first; those of one check with one cure together.
fn grouped(findings: &[Finding]) -> Vec<Vec<&Finding>> {
    let mut ranked: Vec<&Finding> = findings.iter().collect();
    ranked.sort_by_key(|finding| core::cmp::Reverse(finding.severity));
    let mut groups: Vec<Vec<&Finding>> = Vec::new();
    for finding in ranked {
        let like = |g: &Vec<&Finding>| {
            (g[0].check, g[0].severity, g[0].cure.as_str()) == (finding.check, finding.severity, finding.cure.as_str())
        };
        match groups.iter().position(like) {
            Some(group) => groups[group].push(finding),
            None => groups.push(vec![finding]),
        }
    }
    groups
}

/// The channel and the others concerned, the first four by name.
pub fn channels_of(finding: &Finding) -> String {
    let all: Vec<&str> = core::iter::once(&finding.channel).chain(&finding.others).map(String::as_str).collect();
    let named = all.iter().filter(|name| !name.is_empty()).take(4).copied().collect::<Vec<_>>().join(", ");
    if all.len() > 4 { format!("{named}, … ({} channels)", all.len()) } else { named }
}

/// A name of the library as words: `clock_skew` is "clock skew".
pub fn words_of(name: impl serde::Serialize) -> String {
    serde_json::to_value(name).ok().and_then(|v| v.as_str().map(|s| s.replace('_', " "))).unwrap_or_default()
}

/// Value, standard deviation and unit of a finding, rounded to what the deviation supports.
pub fn value_of(finding: &Finding) -> String {
    let unit = if finding.unit == "-" { String::new() } else { format!(" {}", finding.unit) };
    match finding.sigma {
        Some(sigma) => {
            let (value, sigma) = with_sigma(finding.value, sigma);
            format!("{value} ± {sigma}{unit}")
        }
        None => format!("{}{unit}", short(finding.value)),
    }
}

fn in_words(examined: &[Examined], report: Option<&str>) -> String {
    let mut text = String::new();
    for Examined { loaded, findings } in examined {
        let _ = writeln!(text, "{}: {}", loaded.recording.name, loaded.in_words());
        for note in crate::notes::counted(&loaded.notes) {
            text.push_str(&wrapped(&format!("note: {note}"), "  "));
        }
        if findings.is_empty() {
            text.push_str("  nothing found\n");
        }
        for group in grouped(findings) {
            let _ = writeln!(text, "\n  {:<8} {}", words_of(group[0].severity), words_of(group[0].check));
            for finding in &group {
                let _ = writeln!(text, "           {}: {}", channels_of(finding), value_of(finding));
                text.push_str(&wrapped(&finding.evidence, "             "));
            }
            text.push_str(&wrapped(&format!("cure: {}", group[0].cure), "           "));
        }
        text.push('\n');
    }
    let _ = writeln!(text, "{}", summary(examined));
    if let Some(report) = report {
        let _ = writeln!(text, "report {report}");
    }
    text
}

/// Counts by severity, and what they mean.
fn summary(examined: &[Examined]) -> String {
    let count = |severity| examined.iter().flat_map(|e| &e.findings).filter(|f| f.severity == severity).count();
    let (faults, warnings, notes) = (count(Severity::Fault), count(Severity::Warning), count(Severity::Note));
    let number = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    let counted = format!("{}, {}, {}", number(faults, "fault"), number(warnings, "warning"), number(notes, "note"));
    let means = match (faults, warnings) {
        (0, 0) => "the data can be used as they are",
        (0, _) => "the data can be used; allow for the warnings, or estimates are biased or weaker than they look",
        _ => "cure the faults first: fitted on data like these, a model explains the fault",
    };
    format!("{counted}: {means}")
}
