//! Modes of a magnitude spectrum: without phase there are no shapes, and the damping holds the
//! width of the window.

use super::{Arguments, FoundMode, Outcome};
use crate::Failure;
use discovery::features::Spectrum as Magnitudes;
use recording::Spectrum;

pub(super) fn outcome(arguments: &Arguments, spectra: &[Spectrum]) -> Result<Outcome, Failure> {
    let wrong = |what: String| {
        Failure::Input(miette::miette!(
            help =
                "name one column with --channels; complex responses come in pairs of columns `NAME_real`, `NAME_imag`",
            "{what}"
        ))
    };
    let [spectrum] = spectra else { return Err(wrong("several magnitude spectra have no common modes yet".into())) };
    let column = match &arguments.channels[..] {
        [] if spectrum.columns.len() == 1 => 0,
        [name] => spectrum.column_named(name).ok_or_else(|| wrong(format!("no column '{name}'")))?,
        _ => return Err(wrong(format!("{} has {} columns", spectrum.file, spectrum.columns.len()))),
    };
    let magnitudes = Magnitudes {
        name: spectrum.file.clone(),
        frequency_hz: spectrum.frequency_hz.clone(),
        magnitude: spectrum.columns[column].values.iter().map(|x| x.abs()).collect(),
    };
    let modes = magnitudes.modes();
    let mode = |mode: &discovery::features::MeasuredMode| FoundMode {
        frequency_hz: mode.frequency_hz,
        frequency_sd: Some(mode.sigma_hz),
        damping: Some(mode.damping_ratio).filter(|zeta| zeta.is_finite()),
        damping_sd: Some(mode.damping_sigma).filter(|sigma| sigma.is_finite()),
        shape: Vec::new(),
        phase_collinearity: None,
    };
    let visible = magnitudes.frequency_hz.iter().zip(&magnitudes.magnitude).filter(|(f, x)| **f > 0.0 && **x > 0.0);
    Ok(Outcome {
        method: "peaks of the magnitude, each fitted as one resonance",
        kind: "resonances of all that moves together",
        deviations: "residual of each fit",
        channels: vec![spectrum.columns[column].name.clone()],
        record: format!("1 magnitude, {} lines", magnitudes.frequency_hz.len()),
        modes: modes.iter().map(mode).collect(),
        rejected: Vec::new(),
        sweep: Vec::new(),
        spectrum: Some(visible.unzip()),
        synthesis: None,
        advice: vec!["no phase: shapes and signs cannot be had, and damping has the width of the window in it".into()],
        drift: Vec::new(),
        tracks: Vec::new(),
        notes: spectrum.notes.clone(),
    })
}
