//! Modes of complex frequency responses, columns in pairs `…_real`, `…_imag`.

use super::structure::wants_singular_values;
use super::{Arguments, FoundMode, Outcome, Structure, SweepPole, Synthesis};
use crate::Failure;
use modal::c64;
use modal::frequency_responses::{ResponseFit, identify};
use modal::mac::modal_phase_collinearity;
use recording::Spectrum;
use report::Stability;
use std::ops::RangeInclusive;

const DAMPING_MAX: f64 = 0.25;

/// Columns that belong together: (name, real, imaginary); a coherence with an imaginary part is no
/// such pair.
fn pairs(spectrum: &Spectrum) -> Vec<(String, usize, usize)> {
    let columns = spectrum.columns.iter().enumerate();
    let pair = |(real, column): (usize, &recording::Column)| {
        let name = column.name.strip_suffix("_real").filter(|_| column.kind.is_response())?;
        let imaginary = spectrum.column_named(&format!("{name}_imag"))?;
        Some((name.to_string(), real, imaginary))
    };
    columns.filter_map(pair).collect()
}

/// Whether all of them hold pairs of columns that are complex responses.
pub(crate) fn are_complex(spectra: &[Spectrum]) -> bool {
    !spectra.is_empty() && spectra.iter().all(|spectrum| !pairs(spectrum).is_empty())
}

/// Frequency responses of one structure, and the modes found in them.
pub(crate) struct Identified {
    /// Of the channels: `FILE:NAME`.
    pub names: Vec<String>,
    unit: String,
    frequency_hz: Vec<f64>,
    responses: Vec<Vec<c64>>,
    pub fit: ResponseFit,
}

pub(super) fn outcome(arguments: &Arguments, spectra: &[Spectrum]) -> Result<Outcome, Failure> {
    let found = identified(spectra, arguments.orders.clone())?;
    let singular_values = wants_singular_values(arguments)
        .then(|| super::singular::of_channels(&found.names, &found.frequency_hz, &found.responses))
        .flatten();
    let structure = Structure { singular_values, ..Structure::default() };
    Ok(Outcome { structure, ..described(found, spectra) })
}

/// Modes of complex responses, all files together.
///
/// # Errors
/// [`Failure::Input`] where the files do not have the same lines, or where no order of the fraction
/// fits them.
pub(crate) fn identified(spectra: &[Spectrum], orders: RangeInclusive<usize>) -> Result<Identified, Failure> {
    let first = &spectra[0];
    if let Some(other) = spectra.iter().find(|other| other.frequency_hz != first.frequency_hz) {
        return Err(Failure::Input(miette::miette!(
            help = "responses of one structure need the same frequency lines: export them alike",
            "{} and {} have different lines",
            first.file,
            other.file
        )));
    }
    // At 0 Hz a response has no phase and often an offset.
    let lines: Vec<usize> = (0..first.frequency_hz.len()).filter(|line| first.frequency_hz[*line] > 0.0).collect();
    let frequency_hz: Vec<f64> = lines.iter().map(|line| first.frequency_hz[*line]).collect();
    let (mut names, mut responses, mut unit) = (Vec::new(), Vec::new(), String::new());
    for spectrum in spectra {
        for (name, real, imaginary) in pairs(spectrum) {
            let column = |k: usize, line: usize| spectrum.columns[k].values[line];
            responses.push(
                lines.iter().map(|line| c64::new(column(real, *line), column(imaginary, *line))).collect::<Vec<_>>(),
            );
            let stem = std::path::Path::new(&spectrum.file).file_stem().map(|s| s.to_string_lossy().into_owned());
            names.push(stem.map_or(name.clone(), |stem| format!("{stem}:{name}")));
            unit = spectrum.columns[real].unit.into();
        }
    }
    let fit = identify(&frequency_hz, &responses, orders, DAMPING_MAX)
        .map_err(|error| Failure::Input(miette::miette!(help = "give more lines, or a smaller --orders", "{error}")))?;
    Ok(Identified { names, unit, frequency_hz, responses, fit })
}

/// What the residual says of the lines.
fn said(fit: &ResponseFit) -> Option<String> {
    if let Some(window) = fit.window {
        return Some(format!(
            "the residuals of neighbouring lines are correlated as {window} windows make them: the width of the \
             window and its leakage are part of the model"
        ));
    }
    (fit.correlated_lines > 0).then(|| {
        format!(
            "the residuals are correlated over {} lines (zero padding, a window, or what the model lacks): the \
             standard deviations are wider by it; a window that was applied is in the damping",
            fit.correlated_lines
        )
    })
}

fn described(identified: Identified, spectra: &[Spectrum]) -> Outcome {
    let Identified { names: channels, unit, frequency_hz, responses, fit } = identified;
    let size = |values: &[c64]| -> Vec<f64> { values.iter().map(|x| x.norm_sqr().sqrt()).collect() };
    let mean: Vec<f64> =
        (0..frequency_hz.len()).map(|line| responses.iter().map(|r| r[line].norm_sqr()).sum::<f64>().sqrt()).collect();
    let refused = fit.poles.iter().filter(|(.., accepted)| !accepted).count();
    let sweep = fit.poles.iter().map(|(order, pole, accepted)| {
        let omega = pole.norm_sqr().sqrt();
        SweepPole {
            order: *order,
            frequency_hz: omega / core::f64::consts::TAU,
            damping_ratio: -pole.re / omega,
            stability: if *accepted { Stability::All } else { Stability::New },
        }
    });
    let mode = |mode: &modal::frequency_responses::ResponseMode| FoundMode {
        frequency_hz: mode.frequency_hz,
        frequency_sd: Some(mode.frequency_sd),
        damping: Some(mode.damping_ratio),
        damping_sd: Some(mode.damping_sd),
        phase_collinearity: Some(modal_phase_collinearity(&mode.mode_shape)),
        shape: mode.mode_shape.clone(),
        shape_sd: mode.shape_sd.clone(),
    };
    Outcome {
        as_it_is: Default::default(),
        method: "rational fraction polynomials, order by what they split; weighted least squares from there",
        kind: "modes of the structure between the input of the responses and the sensors",
        verdict: None,
        deviations: "residual of the fit",
        record: format!("{} responses, {} lines, order {}", channels.len(), frequency_hz.len(), fit.order),
        modes: fit.modes.iter().map(mode).collect(),
        rejected: vec![
            ("order splits a mode, or gives one that does not decay".into(), refused),
            ("damping within three deviations of zero".into(), fit.unresolved.len()),
        ],
        sweep: sweep.filter(|pole| pole.damping_ratio > 0.0 && pole.damping_ratio < DAMPING_MAX).collect(),
        synthesis: Some(Synthesis {
            channel: channels[0].clone(),
            unit,
            measured: size(&responses[0]),
            modelled: size(&fit.synthesised[0]),
            x: frequency_hz.clone(),
            over_frequency: true,
        }),
        spectrum: Some((frequency_hz, mean)),
        channels,
        advice: said(&fit).into_iter().collect(),
        drift: Vec::new(),
        tracks: Vec::new(),
        structure: Structure::default(),
        notes: spectra.iter().flat_map(|spectrum| spectrum.notes.clone()).collect(),
    }
}
