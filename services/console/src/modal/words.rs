//! The answer in words.

use super::Outcome;
use crate::recordings;
use report::text::{short, with_sigma};
use std::fmt::Write;

pub(super) fn in_words(outcome: &Outcome, written: Option<&str>) -> String {
    let mut text = format!("{}\nmethod: {}; {}\n\n", outcome.record, outcome.method, outcome.kind);
    if outcome.modes.is_empty() {
        text.push_str("no modes found\n");
    } else {
        let _ = writeln!(text, "{:>4} {:>22} {:>22} {:>7}  nature", "mode", "frequency [Hz]", "damping [%]", "MPC");
    }
    for (k, mode) in outcome.modes.iter().enumerate() {
        let collinear = mode.phase_collinearity.map_or("-".into(), |mpc| format!("{mpc:.3}"));
        let frequency = estimate(Some(mode.frequency_hz), mode.frequency_sd);
        let damping = estimate(mode.damping.map(|z| 100.0 * z), mode.damping_sd.map(|z| 100.0 * z));
        let nature = outcome.as_it_is.in_table(k);
        let _ = writeln!(text, "{:>4} {frequency:>22} {damping:>22} {collinear:>7}  {nature}", k + 1);
    }
    let _ = writeln!(text, "\n± one standard deviation: {}", outcome.deviations);
    let frequencies_hz: Vec<f64> = outcome.modes.iter().map(|mode| mode.frequency_hz).collect();
    let examined = outcome.as_it_is.lines(&frequencies_hz);
    for line in examined.iter().chain(&outcome.advice).chain(&crate::notes::counted(&outcome.notes)) {
        text.push_str(&recordings::wrapped(line, "  "));
    }
    if let Some(compared) = &outcome.structure.compared {
        text.push_str(&compared.in_words(outcome));
    }
    if let Some(written) = written {
        let _ = writeln!(text, "report: {written}");
    }
    text
}

/// Value and standard deviation as far as they are known.
pub(super) fn estimate(value: Option<f64>, sigma: Option<f64>) -> String {
    match (value, sigma) {
        (None, _) => "-".into(),
        (Some(value), Some(sigma)) if sigma > 0.0 => {
            let (value, sigma) = with_sigma(value, sigma);
            format!("{value} ± {sigma}")
        }
        (Some(value), _) => short(value),
    }
}
