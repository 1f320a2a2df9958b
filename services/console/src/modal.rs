//! `obsid modal`: modes of anybody's recording, with what is known of each and what is not.
//!
//! A time record without inputs goes through the identifier that flies; with `--input` through
//! maximum likelihood. Complex frequency responses go through rational fractions, magnitudes alone
//! through their peaks. Every answer says whose modes it gives.

mod as_it_is;
mod csv_table;
mod magnitude;
mod page;
pub(crate) mod responses;
mod time;

use crate::Failure;
use crate::intake::{self, IntakeArguments};
use crate::recordings::{self, ReportFile};
use modal::c64;
use modal::drift::{Drift, Track};
use recording::{Imported, Spectrum};
use report::text::{short, with_sigma};
use serde_json::{Value, json};
use std::fmt::Write;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Modes of a recording: frequency, damping and shape with standard deviations, and what the record
/// cannot tell
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid modal slab.csv.gz --channels acceleration_z --from 5    one channel, the first seconds left out
  obsid modal panel.csv --input torque --out report             with a recorded input: maximum likelihood, modal.html
  obsid modal point_1.csv point_2.csv point_3.csv --json        frequency responses of one structure, as one object
  obsid modal beam.uff --csv modes.csv                          a universal file (dataset 58); the modes as a table
  obsid modal panel.csv --input torque --json > modes.json      what `obsid diagnose modes.json --plant FILE` asks for drift
  obsid modal run.mcap --orders 2..60                           order sweep up to 60")]
pub struct Arguments {
    /// CSV, CSV.gz, UFF or MCAP; several files of frequency responses are channels of one structure
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// A channel that drives the structure, held from sample to sample
    #[arg(long, value_name = "CHANNEL")]
    input: Option<String>,
    /// Response channels; all others but the input when not given
    #[arg(long, value_delimiter = ',', value_name = "NAME")]
    channels: Vec<String>,
    /// Model orders of the sweep
    #[arg(long, default_value = ORDERS, value_parser = orders)]
    orders: RangeInclusive<usize>,
    /// Leave out what lies before [s]
    #[arg(long, value_name = "SECONDS")]
    from: Option<f64>,
    /// Leave out what lies behind [s]
    #[arg(long, value_name = "SECONDS")]
    to: Option<f64>,
    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
    /// Write the modes to this file, a row for each
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write modal.html, one page with figures, to this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    intake: IntakeArguments,
}

/// Orders of the sweep by default.
const ORDERS: &str = "2..30";

fn orders(text: &str) -> Result<RangeInclusive<usize>, String> {
    let wrong = || format!("'{text}' is no range of orders; write 2..60");
    let (low, high) = text.split_once("..").ok_or_else(wrong)?;
    let low: usize = low.parse().map_err(|_| wrong())?;
    let high: usize = high.trim_start_matches('=').parse().map_err(|_| wrong())?;
    if low >= 1 && low <= high && high <= 200 { Ok(low..=high) } else { Err(wrong()) }
}

/// A mode that was found.
struct FoundMode {
    frequency_hz: f64,
    frequency_sd: Option<f64>,
    damping: Option<f64>,
    damping_sd: Option<f64>,
    /// Per channel, largest component 1; empty where there is no phase.
    shape: Vec<c64>,
    phase_collinearity: Option<f64>,
}

/// A pole of the order sweep.
#[derive(Clone, Copy)]
struct SweepPole {
    order: usize,
    frequency_hz: f64,
    damping_ratio: f64,
    stability: report::Stability,
}

/// A measured curve and what the modes make of it.
struct Synthesis {
    channel: String,
    unit: String,
    /// Time [s] or frequency [Hz].
    x: Vec<f64>,
    over_frequency: bool,
    measured: Vec<f64>,
    modelled: Vec<f64>,
}

/// Everything the answer consists of.
struct Outcome {
    as_it_is: as_it_is::AsItIs,
    method: &'static str,
    /// Whose modes these are.
    kind: &'static str,
    /// What the standard deviations are.
    deviations: &'static str,
    channels: Vec<String>,
    record: String,
    modes: Vec<FoundMode>,
    /// Poles left out, by reason.
    rejected: Vec<(String, usize)>,
    sweep: Vec<SweepPole>,
    /// Spectrum behind the stabilisation diagram.
    spectrum: Option<(Vec<f64>, Vec<f64>)>,
    synthesis: Option<Synthesis>,
    advice: Vec<String>,
    /// From the first half of the record to the second.
    drift: Vec<Drift>,
    /// The modes through the parts of the record.
    tracks: Vec<Track>,
    notes: Vec<String>,
    /// Whether a model with known input is right, and the test of its residuals.
    verdict: Option<Verdict>,
}

/// The verdict on a model with known input.
#[derive(Clone, Copy)]
struct Verdict {
    adequate: bool,
    residual: modal::adequacy::Residual,
}

/// # Errors
/// [`Failure::Input`] for what cannot be read or asked of the recording, [`Failure::Run`] for a
/// report that cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.intake.list {
        let files: Vec<_> = arguments.files.iter().map(PathBuf::as_path).collect();
        return intake::list(&files, &arguments.intake, arguments.json);
    }
    let out = arguments.out.as_deref().map(|folder| ReportFile::new(folder, "modal.html")).transpose()?;
    let outcome = outcome(arguments)?;
    if let Some(out) = &out {
        out.write(&page::page(&outcome, arguments, &again(arguments)))?;
    }
    if let Some(file) = &arguments.csv {
        std::fs::write(file, csv_table::table(&outcome))
            .map_err(|error| Failure::Run(format!("{}: {error}", file.display())))?;
    }
    let written = out.map(|out| out.path());
    let text = if arguments.json {
        format!("{}\n", as_json(arguments, &outcome, written.as_deref()))
    } else {
        in_words(&outcome, written.as_deref())
    };
    crate::print(&text);
    Ok(())
}

fn outcome(arguments: &Arguments) -> Result<Outcome, Failure> {
    let intake = arguments.intake.intake(None)?;
    let mut spectra: Vec<Spectrum> = Vec::new();
    for file in &arguments.files {
        match recording::read_with(file, &intake).map_err(Failure::input)? {
            Imported::Spectrum(spectrum) => spectra.push(spectrum),
            other if arguments.files.len() == 1 => return time::outcome(arguments, other),
            _ => {
                return Err(Failure::Input(miette::miette!(
                    help = "give time records one by one; several files are taken together only where all are spectra",
                    "{} is a time record among several files",
                    file.display()
                )));
            }
        }
    }
    if responses::are_complex(&spectra) {
        responses::outcome(arguments, &spectra)
    } else {
        magnitude::outcome(arguments, &spectra)
    }
}

/// The command that gives the same again.
fn again(arguments: &Arguments) -> String {
    let mut words = vec!["obsid".to_string(), "modal".into()];
    words.extend(arguments.files.iter().map(|file| file.display().to_string()));
    words.extend(arguments.intake.words());
    words.extend(arguments.input.iter().flat_map(|input| ["--input".into(), input.clone()]));
    if !arguments.channels.is_empty() {
        words.extend(["--channels".into(), arguments.channels.join(",")]);
    }
    words.extend(["--orders".into(), format!("{}..{}", arguments.orders.start(), arguments.orders.end())]);
    words.extend(arguments.from.iter().flat_map(|t| ["--from".into(), t.to_string()]));
    words.extend(arguments.to.iter().flat_map(|t| ["--to".into(), t.to_string()]));
    words.extend(arguments.csv.iter().flat_map(|file| ["--csv".into(), file.display().to_string()]));
    words.extend(arguments.out.iter().flat_map(|out| ["--out".into(), out.display().to_string()]));
    recordings::command_line(&words)
}

fn as_json(arguments: &Arguments, outcome: &Outcome, written: Option<&str>) -> Value {
    let shape = |mode: &FoundMode| -> Vec<Value> {
        let of = |(name, psi): (&String, &c64)| json!({ "channel": name, "re": psi.re, "im": psi.im });
        outcome.channels.iter().zip(&mode.shape).map(of).collect()
    };
    let mode = |(k, mode): (usize, &FoundMode)| {
        let mut object = json!({ "frequency_hz": mode.frequency_hz, "frequency_sd": mode.frequency_sd, "damping": mode.damping,
            "damping_sd": mode.damping_sd, "shape": shape(mode), "mpc": mode.phase_collinearity, "kind": outcome.kind,
            "sd_basis": mode.frequency_sd.map(|_| outcome.deviations) });
        outcome.as_it_is.describe(k, &mut object);
        object
    };
    let rejected: Vec<Value> =
        outcome.rejected.iter().map(|(reason, poles)| json!({ "reason": reason, "poles": poles })).collect();
    let drift = |drift: &Drift| {
        json!({ "frequency_hz": drift.frequency_hz, "frequency_change_hz": drift.frequency_change_hz, "frequency_z": drift.frequency_z,
            "damping": drift.damping_ratio, "damping_change": drift.damping_change, "damping_z": drift.damping_z })
    };
    let track = |track: &Track| {
        let parts = track.points.iter().map(|p| {
            json!({ "begin_s": p.begin_s, "end_s": p.end_s, "amplitude": p.amplitude, "frequency_hz": p.frequency_hz,
                "frequency_sd": p.frequency_sd, "damping": p.damping_ratio, "damping_sd": p.damping_sd })
        });
        json!({ "frequency_hz": track.frequency_hz, "damping": track.damping_ratio, "parts": parts.collect::<Vec<_>>() })
    };
    let residual = |verdict: Verdict| {
        let modal::adequacy::Residual { white, lag1, statistic, degrees, p } = verdict.residual;
        json!({ "white": white, "lag1": lag1, "statistic": statistic, "degrees": degrees, "p": p })
    };
    json!({ "files": arguments.files.iter().map(|f| f.display().to_string()).collect::<Vec<_>>(),
        "method": outcome.method, "kind": outcome.kind, "standard_deviations": outcome.deviations,
        "channels": outcome.channels, "modes": outcome.modes.iter().enumerate().map(mode).collect::<Vec<_>>(),
        "examination": outcome.as_it_is.examination(),
        "model_adequate": outcome.verdict.map(|verdict| verdict.adequate), "residual": outcome.verdict.map(residual),
        "rejected": rejected, "drift": outcome.drift.iter().map(drift).collect::<Vec<_>>(), "tracks": outcome.tracks.iter().map(track).collect::<Vec<_>>(), "advice": outcome.advice, "notes": outcome.notes, "report": written })
}

fn in_words(outcome: &Outcome, written: Option<&str>) -> String {
    let mut text = format!("{}\nmethod: {}; {}\n\n", outcome.record, outcome.method, outcome.kind);
    if outcome.modes.is_empty() {
        text.push_str("no modes found\n");
    } else {
        let _ =
            writeln!(text, "{:>4} {:>22} {:>22} {:>7}  {}", "mode", "frequency [Hz]", "damping [%]", "MPC", "nature");
    }
    for (k, mode) in outcome.modes.iter().enumerate() {
        let collinear = mode.phase_collinearity.map_or("-".into(), |mpc| format!("{mpc:.3}"));
        let frequency = estimate(Some(mode.frequency_hz), mode.frequency_sd);
        let damping = estimate(mode.damping.map(|z| 100.0 * z), mode.damping_sd.map(|z| 100.0 * z));
        let _ = writeln!(
            text,
            "{:>4} {frequency:>22} {damping:>22} {collinear:>7}  {}",
            k + 1,
            outcome.as_it_is.in_table(k)
        );
    }
    let _ = writeln!(text, "\n± one standard deviation: {}", outcome.deviations);
    let frequencies_hz: Vec<f64> = outcome.modes.iter().map(|mode| mode.frequency_hz).collect();
    for line in outcome
        .as_it_is
        .lines(&frequencies_hz)
        .iter()
        .chain(&outcome.advice)
        .chain(&crate::notes::counted(&outcome.notes))
    {
        text.push_str(&recordings::wrapped(line, "  "));
    }
    if let Some(written) = written {
        let _ = writeln!(text, "report: {written}");
    }
    text
}

/// Value and standard deviation as far as they are known.
fn estimate(value: Option<f64>, sigma: Option<f64>) -> String {
    match (value, sigma) {
        (None, _) => "-".into(),
        (Some(value), Some(sigma)) if sigma > 0.0 => {
            let (value, sigma) = with_sigma(value, sigma);
            format!("{value} ± {sigma}")
        }
        (Some(value), _) => short(value),
    }
}
