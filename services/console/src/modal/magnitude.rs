//! Modes of a magnitude spectrum: without phase there are no shapes, and the damping holds the
//! width of the window.

use super::{Arguments, FoundMode, Outcome};
use crate::Failure;
use discovery::features::{MeasuredMode, Spectrum as Magnitudes};
use recording::{Column, Spectrum};

const NO_PHASE: &str = "no phase: shapes and signs cannot be had, and damping has the width of the window in it";
/// Share of a frequency within which two peaks are one.
const SAME: f64 = 0.03;

pub(super) fn outcome(arguments: &Arguments, spectra: &[Spectrum]) -> Result<Outcome, Failure> {
    let wrong = |what: String| {
        Failure::Input(miette::miette!(
            help =
                "name one column with --channels; complex responses come in pairs of columns `NAME_real`, `NAME_imag`",
            "{what}"
        ))
    };
    let [spectrum] = spectra else { return Err(wrong("several magnitude spectra have no common modes yet".into())) };
    let columns = chosen(arguments, spectrum).map_err(wrong)?;
    let magnitudes = Magnitudes {
        name: spectrum.file.clone(),
        frequency_hz: spectrum.frequency_hz.clone(),
        magnitude: together(&columns),
    };
    let modes = magnitudes.modes();
    let mode = |mode: &MeasuredMode| FoundMode {
        frequency_hz: mode.frequency_hz,
        frequency_sd: Some(mode.sigma_hz),
        damping: Some(mode.damping_ratio).filter(|zeta| zeta.is_finite()),
        damping_sd: Some(mode.damping_sigma).filter(|sigma| sigma.is_finite()),
        shape: Vec::new(),
        shape_sd: Vec::new(),
        phase_collinearity: None,
    };
    let visible = magnitudes.frequency_hz.iter().zip(&magnitudes.magnitude).filter(|(f, x)| **f > 0.0 && **x > 0.0);
    Ok(Outcome {
        as_it_is: Default::default(),
        method: "peaks of the magnitude, each fitted as one resonance",
        kind: "resonances of all that moves together",
        verdict: None,
        deviations: "residual of each fit",
        channels: columns.iter().map(|column| column.name.clone()).collect(),
        record: record(&columns, magnitudes.frequency_hz.len()),
        modes: modes.iter().map(mode).collect(),
        rejected: Vec::new(),
        sweep: Vec::new(),
        spectrum: Some(visible.unzip()),
        synthesis: None,
        advice: core::iter::once(NO_PHASE.into()).chain(doubtful(&columns, &magnitudes, &modes)).collect(),
        drift: Vec::new(),
        tracks: Vec::new(),
        structure: super::Structure::default(),
        notes: spectrum.notes.clone(),
    })
}

/// The column asked for; without a choice the only one, or all where all are spectra of outputs in
/// one unit.
fn chosen<'a>(arguments: &Arguments, spectrum: &'a Spectrum) -> Result<Vec<&'a Column>, String> {
    let columns: Vec<&Column> = match &arguments.channels[..] {
        [] => spectrum.columns.iter().collect(),
        [name] => {
            let place = spectrum.column_named(name).ok_or_else(|| format!("no column '{name}'"))?;
            vec![&spectrum.columns[place]]
        }
        _ => return Err("several columns were asked for".into()),
    };
    if let Some(column) = columns.iter().find(|column| !column.kind.has_resonances()) {
        return Err(format!("'{}' is a {}: its peaks are no resonances", column.name, column.kind.words().0));
    }
    let outputs = columns.iter().all(|column| column.kind.is_of_output() && column.unit == columns[0].unit);
    if columns.len() == 1 || (outputs && !columns.is_empty()) {
        return Ok(columns);
    }
    let names: Vec<&str> = columns.iter().take(8).map(|column| column.name.as_str()).collect();
    let more = if columns.len() > 8 { ", …" } else { "" };
    Err(format!("{} has {} columns: {}{more}", spectrum.file, columns.len(), names.join(", ")))
}

/// Root of the sum of the squares, which shows every mode that one of the outputs shows.
fn together(columns: &[&Column]) -> Vec<f64> {
    match columns {
        [one] => one.values.iter().map(|x| x.abs()).collect(),
        several => {
            let sum = |line: usize| several.iter().map(|column| column.values[line] * column.values[line]).sum::<f64>();
            (0..several.first().map_or(0, |first| first.values.len())).map(|line| sum(line).sqrt()).collect()
        }
    }
}

/// Peaks of the power of outputs that are no modes by their magnitude, for the reader to judge: one
/// of many lines may be a mode with high damping, one of a single line is noise.
fn doubtful(columns: &[&Column], magnitudes: &Magnitudes, modes: &[MeasuredMode]) -> Option<String> {
    columns.iter().all(|column| column.kind.is_of_output()).then_some(())?;
    let power = Magnitudes { magnitude: magnitudes.magnitude.iter().map(|x| x * x).collect(), ..magnitudes.clone() };
    let is_mode = |f: f64| modes.iter().any(|mode| (mode.frequency_hz - f).abs() < SAME * f);
    let peaks: Vec<f64> = power.modes().iter().map(|peak| peak.frequency_hz).filter(|f| !is_mode(*f)).collect();
    let listed: Vec<String> = peaks.iter().take(8).map(|f| format!("{f:.4}")).collect();
    let more = if peaks.len() > 8 { ", …" } else { "" };
    (!peaks.is_empty()).then(|| {
        format!(
            "peaks that do not stand out enough to be told from noise: {}{more} Hz; a mode with high damping may be \
             among them: give frequency responses or the time record",
            listed.join(", ")
        )
    })
}

fn record(columns: &[&Column], lines: usize) -> String {
    match columns.len() {
        1 => format!("1 magnitude, {lines} lines"),
        several => format!("root of the sum of the squares of {several} magnitudes, {lines} lines"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use recording::FunctionKind;

    fn spectrum(columns: &[(&str, FunctionKind)]) -> Spectrum {
        let column = |(name, kind): &(&str, FunctionKind)| {
            let values = (0..400).map(|line| if line == 200 { 3.0 } else { 4.0 }).collect();
            Column { kind: *kind, ..Column::si(name, "m/s^2", values) }
        };
        let frequency_hz = (0..400).map(f64::from).collect();
        let columns = columns.iter().map(column).collect();
        Spectrum { file: "test.uff".into(), frequency_hz, columns, notes: Vec::new() }
    }

    fn asked(spectrum: &Spectrum, channels: &[&str]) -> Result<Outcome, String> {
        let channels = channels.iter().map(|name| (*name).to_string()).collect();
        let arguments = Arguments { channels, ..Arguments::of(&["test.uff"]) };
        outcome(&arguments, core::slice::from_ref(spectrum)).map_err(|failure| format!("{failure:?}"))
    }

    #[test]
    fn densities_of_several_outputs_are_taken_together_and_one_where_it_is_named() {
        let density = FunctionKind::PowerSpectralDensity;
        let two = spectrum(&[("a", density), ("b", density)]);
        let together = asked(&two, &[]).unwrap();
        assert_eq!(together.channels, ["a", "b"]);
        let (_, size) = together.spectrum.unwrap();
        assert!((size[0] - 32.0_f64.sqrt()).abs() < 1e-15 && (size[199] - 18.0_f64.sqrt()).abs() < 1e-15);
        assert_eq!(asked(&two, &["b"]).unwrap().channels, ["b"]);
    }

    #[test]
    fn columns_that_are_no_spectra_of_outputs_are_chosen_by_name_and_coherences_not_at_all() {
        let mixed = spectrum(&[("a", FunctionKind::Unknown), ("b", FunctionKind::Coherence)]);
        assert!(
            asked(&mixed, &["b"]).err().unwrap().contains("'b' is a coherence function: its peaks are no resonances")
        );
        assert_eq!(asked(&mixed, &["a"]).unwrap().channels, ["a"]);
        let unknown = spectrum(&[("a", FunctionKind::Unknown), ("b", FunctionKind::Unknown)]);
        assert!(asked(&unknown, &[]).err().unwrap().contains("test.uff has 2 columns: a, b"));
    }
}
