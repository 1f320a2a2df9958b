//! Frequency and damping over the parts of a record: constants of a linear structure, clocks of one that is not.
//!
//! A fit of the whole record hides what changes along it: damping that grows with amplitude moves the fitted damping by tens of
//! per cent and leaves the residuals almost white. The same record in parts shows it with ten standard deviations, and the sign
//! says what it is. Evidence, not a verdict: wear, temperature and a payload that moves drift too.

use crate::mac::modal_assurance_criterion;
use crate::maximum_likelihood::{Model, fit};
use crate::methods::{Estimate, estimates};
use crate::record::Record;
use faer::c64;
use std::ops::Range;

/// Standard deviations from which a change is worth a word: two halves, two numbers for each of ten modes, once in a thousand
/// linear records.
pub const WORTH_A_WORD_SIGMA: f64 = 4.0;
/// Shapes less alike than this are not of one mode.
const SAME_SHAPE: f64 = 0.8;

/// A mode in an earlier and in a later part of the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// In the earlier part.
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    /// Later minus earlier.
    pub frequency_change_hz: f64,
    pub damping_change: f64,
    /// Changes in units of their standard deviations.
    pub frequency_z: f64,
    pub damping_z: f64,
}

impl Drift {
    /// Whether the linear, constant model of this mode is in doubt.
    #[must_use]
    pub fn stands_out(&self) -> bool {
        self.frequency_z.abs() > WORTH_A_WORD_SIGMA || self.damping_z.abs() > WORTH_A_WORD_SIGMA
    }
}

impl std::fmt::Display for Drift {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { frequency_hz, damping_ratio, .. } = self;
        let (changed, percent, z, suspect) = if self.damping_z.abs() > self.frequency_z.abs() {
            let suspect = "damping that depends on amplitude, or friction";
            ("damping", 100.0 * self.damping_change / damping_ratio, self.damping_z, suspect)
        } else {
            let suspect = "stiffness that depends on amplitude, or mass or temperature that changes";
            ("frequency", 100.0 * self.frequency_change_hz / frequency_hz, self.frequency_z, suspect)
        };
        write!(
            f,
            "drift: the {changed} of {frequency_hz:.3} Hz changes by {percent:+.2} % from the first half of the record to the second ({:.0} standard deviations); {suspect}",
            z.abs()
        )
    }
}

/// Modes found in two parts, each paired with the nearest of like shape; those without deviations are left out.
#[must_use]
pub fn between(earlier: &[Estimate], later: &[Estimate]) -> Vec<Drift> {
    let of = |before: &Estimate| {
        let apart = |after: &&Estimate| (after.frequency_hz - before.frequency_hz).abs();
        let width = |after: &&Estimate| {
            3.0 * before.damping_ratio.max(after.damping_ratio) * before.frequency_hz
                + WORTH_A_WORD_SIGMA
                    * before
                        .deviation
                        .map_or(0.0, |d| d.frequency_hz)
                        .hypot(after.deviation.map_or(0.0, |d| d.frequency_hz))
        };
        let alike = |after: &&Estimate| {
            modal_assurance_criterion(&before.mode_shape, &after.mode_shape) > SAME_SHAPE && apart(after) < width(after)
        };
        let after = later.iter().filter(alike).min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        let (a, b) = (before.deviation?, after.deviation?);
        let (frequency_change_hz, damping_change) =
            (after.frequency_hz - before.frequency_hz, after.damping_ratio - before.damping_ratio);
        Some(Drift {
            frequency_hz: before.frequency_hz,
            damping_ratio: before.damping_ratio,
            frequency_change_hz,
            damping_change,
            frequency_z: frequency_change_hz / libm::hypot(a.frequency_hz, b.frequency_hz),
            damping_z: damping_change / libm::hypot(a.damping_ratio, b.damping_ratio),
        })
    };
    earlier.iter().filter_map(of).collect()
}

/// Drift of the modes at `poles` (of the whole record) between the halves of a record, each fitted by maximum likelihood.
///
/// The second half begins in motion; so does the first unless `model` says otherwise. Empty where a half cannot be fitted.
///
/// Cost: two fits of half the length.
#[must_use]
pub fn of_halves(record: &Record, model: Model, poles: &[c64]) -> Vec<Drift> {
    let middle = record.samples() / 2;
    let of = |part: Range<usize>, model: Model| fit(&record.part(part), model, poles).ok().filter(|fit| fit.converged);
    let moving = Model { initial_motion: true, ..model };
    match (of(0..middle, model), of(middle..record.samples(), moving)) {
        (Some(earlier), Some(later)) => between(&estimates(&earlier), &estimates(&later)),
        _ => Vec::new(),
    }
}
