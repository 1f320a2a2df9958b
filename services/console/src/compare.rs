//! `obsid compare`: a recording and a simulation of it, channel by channel, without a plant.

mod page;

use crate::Failure;
use crate::intake::{self, IntakeArguments};
use crate::progress::Share;
use crate::recordings::{self, Loaded, ReportFile, wrapped};
use examination::compare::{ChannelComparison, Comparison, Verdict, compare};
use recording::Intake;
use report::text::{short, with_sigma};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;

/// Compare a recording with a simulation: fit, lag, scale, sign, offset, where and when they differ
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid compare flight.csv simulated.csv                per channel rms, fit, and what separates the two
  obsid compare flight.csv simulated.csv --out report   with figures in report/compare.html
  obsid compare flight.mcap sim.csv.gz --json           compare{channels[]{name, rms, fit_percent, ...}} as one object

Channels meet by name; times are those of the files. Differences are an answer, not a failure: the exit code is 0.")]
pub struct Arguments {
    /// What was measured: CSV, CSV.gz or MCAP
    real: PathBuf,
    /// What a simulation says, from whatever program
    simulated: PathBuf,
    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
    /// Write compare.html, one page with figures, to this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    intake: IntakeArguments,
}

/// Two recordings and what separates them.
struct Compared {
    real: Loaded,
    simulated: Loaded,
    result: Comparison,
}

/// # Errors
/// [`Failure::Input`] for recordings that cannot be read or have no channel in common,
/// [`Failure::Run`] when the report cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.intake.list {
        return intake::list(&[&arguments.real, &arguments.simulated], &arguments.intake, arguments.json);
    }
    let intake = arguments.intake.intake(None)?;
    let real = recordings::read(&arguments.real, &intake, None)?;
    // a simulation with names and a clock of its own needs nothing said
    let simulated = recordings::read(&arguments.simulated, &Intake::default(), None).or_else(|error| {
        if intake.is_empty() { Err(error) } else { recordings::read(&arguments.simulated, &intake, None) }
    })?;
    if real.len() != simulated.len() {
        return Err(Failure::Input(miette::miette!(
            help = "compare files with the same recordings in the same order, or split them where time starts again",
            "{} holds {} recording(s) one after another, {} holds {}",
            arguments.real.display(),
            real.len(),
            arguments.simulated.display(),
            simulated.len()
        )));
    }
    let out = arguments.out.as_deref().map(|folder| ReportFile::new(folder, "compare.html")).transpose()?;
    let bar = Share::new("compared");
    let count = real.len() as f64;
    let mut compared = Vec::new();
    for (k, (real, simulated)) in real.into_iter().zip(simulated).enumerate() {
        let result = compare(&real.recording, &simulated.recording);
        bar.show((k + 1) as f64 / count);
        if result.channels.is_empty() {
            bar.end();
            return Err(nothing_in_common(&real, &simulated));
        }
        compared.push(Compared { real, simulated, result });
    }
    bar.end();
    if let Some(out) = &out {
        out.write(&page::page(&compared, &again(arguments)))?;
    }
    let written = out.map(|out| out.path());
    crate::print(&if arguments.json {
        format!("{}\n", as_json(&compared, written.as_deref()))
    } else {
        in_words(&compared, written.as_deref())
    });
    Ok(())
}

/// The command that makes the page again.
fn again(arguments: &Arguments) -> String {
    let path = |path: &PathBuf| path.display().to_string();
    let mut words = vec!["obsid".into(), "compare".into(), path(&arguments.real), path(&arguments.simulated)];
    words.extend(arguments.intake.words());
    words.extend(arguments.out.iter().flat_map(|out| ["--out".into(), path(out)]));
    recordings::command_line(&words)
}

fn nothing_in_common(real: &Loaded, simulated: &Loaded) -> Failure {
    let names = |l: &Loaded| l.recording.channels.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    let (left, right) = (names(real), names(simulated));
    let pair = left.iter().find_map(|l| recordings::nearest(l, right.iter().map(String::as_str)).map(|r| (l, r)));
    let example = pair.map_or(String::new(), |(l, r)| format!(" (is '{r}' the simulated '{l}'?)"));
    Failure::Input(miette::miette!(
        help = format!("channels meet by name: give both files the same headers{example}"),
        "no common channel: {} has {}; {} has {}",
        real.recording.name,
        left.join(", "),
        simulated.recording.name,
        right.join(", ")
    ))
}

fn as_json(compared: &[Compared], report: Option<&str>) -> Value {
    let several = compared.len() > 1;
    let named = |c: &Compared, mut row: Value| {
        if several {
            row["recording"] = json!(c.real.recording.name);
        }
        row
    };
    let channels = compared.iter().flat_map(|c| c.result.channels.iter().map(|row| named(c, json!(row))));
    let unmatched = compared.iter().flat_map(|c| c.result.unmatched.iter().map(|row| named(c, json!(row))));
    let (channels, unmatched): (Vec<Value>, Vec<Value>) = (channels.collect(), unmatched.collect());
    let first = &compared[0];
    json!({ "compare": { "real": first.real.file, "simulated": first.simulated.file, "channels": channels, "unmatched": unmatched },
        "report": report })
}

fn percent(fit: Option<f64>) -> String {
    fit.map_or("–".into(), |fit| format!("{fit:.1}"))
}

/// How a channel differs, in words.
const fn verdict_words(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Identical => "identical",
        Verdict::OnlyNoise => "only noise differs",
        Verdict::Lag => "differs by a lag",
        Verdict::Scale => "differs by a gain",
        Verdict::Sign => "has the opposite sign",
        Verdict::Offset => "differs by an offset",
        Verdict::Band => "differs in a frequency band",
        Verdict::Window => "differs in a time window",
        Verdict::Unexplained => "differs for no single reason",
        Verdict::Unrelated => "unrelated",
        Verdict::Constant => "the recorded channel is constant",
        Verdict::Units => "units of different quantities",
        Verdict::NoCommonTime => "no common time",
        Verdict::TooShort => "too short to compare",
    }
}

fn in_words(compared: &[Compared], report: Option<&str>) -> String {
    let mut text = String::new();
    for Compared { real, simulated, result } in compared {
        let _ = writeln!(text, "real       {}: {}", real.recording.name, real.in_words());
        let _ = writeln!(text, "simulated  {}: {}", simulated.recording.name, simulated.in_words());
        let notes: Vec<String> = real.notes.iter().chain(&simulated.notes).cloned().collect();
        for note in crate::notes::counted(&notes) {
            text.push_str(&wrapped(&format!("note: {note}"), "  "));
        }
        let _ =
            writeln!(text, "\n{:<26} {:>8} {:>12} {:<9} {:>8}  verdict", "channel", "samples", "rms", "unit", "fit %");
        for c in &result.channels {
            let _ = writeln!(
                text,
                "{:<26} {:>8} {:>12} {:<9} {:>8}  {}",
                c.name,
                c.samples,
                short(c.rms),
                c.unit,
                percent(c.fit_percent),
                verdict_words(c.verdict)
            );
        }
        result.channels.iter().for_each(|c| text.push_str(&details(c)));
        for lonely in &result.unmatched {
            let near = if lonely.nearest.is_empty() {
                String::new()
            } else {
                format!(" (nearest there: {})", lonely.nearest.join(", "))
            };
            let other = if lonely.side == "real" { "simulated" } else { "real" };
            let _ = writeln!(text, "\nonly {}: {}; not in the {other} recording{near}", lonely.side, lonely.name);
        }
        text.push('\n');
    }
    if let Some(report) = report {
        let _ = writeln!(text, "report {report}");
    }
    text
}

/// What is behind a row of the table.
fn details(c: &ChannelComparison) -> String {
    let mut text = format!("\n{}\n{}", c.name, wrapped(&c.conclusion, "  "));
    let stamps = |text: &mut String| {
        text.push_str(&wrapped(&format!("stamps   {}", c.resampling), "  "));
    };
    if !c.verdict.compared() {
        return text;
    }
    if matches!(c.verdict, Verdict::Constant | Verdict::Identical) {
        stamps(&mut text);
        return text;
    }
    for alternative in alternatives(c) {
        let Alternative { what, value, sigma, unit, fit } = alternative;
        let number = sigma.map_or_else(
            || short(value),
            |sigma| {
                let (value, sigma) = with_sigma(value, sigma);
                format!("{value} ± {sigma}")
            },
        );
        let _ = writeln!(text, "  {what:<8} {:<26} fit {:>6} % with it alone", format!("{number}{unit}"), percent(fit));
    }
    for w in &c.windows {
        let share = short(100.0 * w.share);
        let _ = writeln!(
            text,
            "  window   {} to {} s: rms {} {}, {share} % of the squared difference, {}",
            short(w.start_s),
            short(w.end_s),
            short(w.rms),
            c.unit,
            examination::doctor::probability(w.p)
        );
    }
    for b in &c.bands {
        let _ = writeln!(
            text,
            "  band     {} to {} Hz: rms {} {}, {} dB above the noise, {}",
            short(b.low_hz),
            short(b.high_hz),
            short(b.rms),
            c.unit,
            short(b.above_db),
            examination::doctor::probability(b.p)
        );
    }
    for k in &c.coherence {
        let _ = writeln!(
            text,
            "  follows  {} from {} to {} Hz: coherence {:.2} (chance {:.2}), {} % of the squared difference",
            k.channel,
            short(k.low_hz),
            short(k.high_hz),
            k.coherence,
            k.level,
            short(100.0 * k.share)
        );
    }
    stamps(&mut text);
    text
}

/// One simple explanation, tried alone.
struct Alternative {
    what: &'static str,
    value: f64,
    sigma: Option<f64>,
    unit: String,
    fit: Option<f64>,
}

fn alternatives(c: &ChannelComparison) -> Vec<Alternative> {
    let usable = |sigma: f64| Some(sigma).filter(|s| s.is_finite());
    let mut all = vec![
        Alternative {
            what: "lag",
            value: 1e3 * c.lag_s,
            sigma: usable(1e3 * c.lag_sigma_s),
            unit: " ms".into(),
            fit: c.lag_fit_percent,
        },
        Alternative {
            what: "scale",
            value: c.scale,
            sigma: usable(c.scale_sigma),
            unit: String::new(),
            fit: c.scale_fit_percent,
        },
        Alternative {
            what: "offset",
            value: c.offset,
            sigma: usable(c.offset_sigma),
            unit: format!(" {}", c.unit),
            fit: c.offset_fit_percent,
        },
    ];
    if c.sign < 0.0 {
        all.push(Alternative {
            what: "sign",
            value: c.sign,
            sigma: None,
            unit: String::new(),
            fit: c.sign_fit_percent,
        });
    }
    all
}
