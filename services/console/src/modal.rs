//! `obsid modal`: modes of anybody's recording, with what is known of each and what is not.
//!
//! A time record without inputs goes through the identifier that flies; with `--input` through
//! maximum likelihood. Complex frequency responses go through rational fractions, magnitudes alone
//! through their peaks. Every answer says whose modes it gives.

mod arguments;
mod as_it_is;
mod csv_table;
mod degree_of_freedom;
mod geometry;
mod hand;
mod json;
mod magnitude;
mod merge;
mod page;
mod preparation;
mod reference;
pub(crate) mod responses;
mod setups;
mod singular;
mod structural_arguments;
mod structure;
mod structure_page;
mod time;
mod uff_export;
mod words;

use crate::Failure;
use crate::intake;
use crate::recordings::ReportFile;
use modal::c64;
use modal::drift::{Drift, Track};
use recording::{Imported, Spectrum};
use std::path::PathBuf;
use structure::Structure;

pub use arguments::Arguments;

/// A mode that was found.
#[derive(Default)]
struct FoundMode {
    frequency_hz: f64,
    frequency_sd: Option<f64>,
    damping: Option<f64>,
    damping_sd: Option<f64>,
    /// Per channel, largest component 1; empty where there is no phase.
    shape: Vec<c64>,
    /// Of real and imaginary parts; empty where not known.
    shape_sd: Vec<c64>,
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
#[derive(Default)]
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
    structure: Structure,
    notes: Vec<String>,
    /// Whether a model with known input is right, and the test of its residuals.
    verdict: Option<Verdict>,
}

impl Outcome {
    /// Leaves out the other modes, and what is said of each of them.
    fn keep_modes(&mut self, keep: impl Fn(&FoundMode) -> bool) {
        let kept: Vec<bool> = self.modes.iter().map(keep).collect();
        let mut of_mode = kept.iter();
        self.modes.retain(|_| *of_mode.next().unwrap_or(&true));
        let mut of_nature = kept.iter();
        self.as_it_is.natures.retain(|_| *of_nature.next().unwrap_or(&true));
    }
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
    let mut outcome = outcome(arguments)?;
    structure::complete(arguments, &mut outcome)?;
    if let Some(out) = &out {
        out.write(&page::page(&outcome, arguments, &arguments::again(arguments)))?;
    }
    if let Some(file) = &arguments.csv {
        std::fs::write(file, csv_table::table(&outcome))
            .map_err(|error| Failure::Run(format!("{}: {error}", file.display())))?;
    }
    let written = out.map(|out| out.path());
    let text = if arguments.json {
        format!("{}\n", json::as_json(arguments, &outcome, written.as_deref()))
    } else {
        words::in_words(&outcome, written.as_deref())
    };
    crate::print(&text);
    Ok(())
}

fn outcome(arguments: &Arguments) -> Result<Outcome, Failure> {
    let mut outcome = of_files(arguments)?;
    if let Some((low, high)) = arguments.band {
        let highest = outcome.spectrum.as_ref().and_then(|(hz, _)| hz.last());
        if let Some(highest) = highest.filter(|highest| low >= **highest) {
            return Err(Failure::Input(miette::miette!(
                help = "give a band below it, or a record of a higher rate",
                "--band {low}..{high}: the record ends at {highest:.6} Hz"
            )));
        }
        outcome.keep_modes(|mode| (low..=high).contains(&mode.frequency_hz));
    }
    Ok(outcome)
}

fn of_files(arguments: &Arguments) -> Result<Outcome, Failure> {
    if !arguments.structural.setup.is_empty() {
        return setups::outcome(arguments);
    }
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
    if let Some(option) = arguments.structural.of_time_only() {
        return Err(Failure::Input(miette::miette!(
            help = "leave it out, or give the time record",
            "{option} is for time records; {} holds spectra",
            arguments.files[0].display()
        )));
    }
    if responses::are_complex(&spectra) {
        responses::outcome(arguments, &spectra)
    } else {
        magnitude::outcome(arguments, &spectra)
    }
}
