//! Diagnosis from features: where a recording is a spectrum, frequency responses or a list of
//! modes, the modes are the evidence.
//!
//! Modes with standard errors (a list, or the peaks of a spectrum) are paired with the plant's, by
//! frequency and, where they exist, by shapes. The residuals are `ln f_measured − ln f_plant`,
//! `ln ζ_measured − ln ζ_plant` and the components of the plant's shape across the measured one.
//! Every change that a plant offers (an appendage's common stiffness or damping, one mode's, a
//! compliant root, a mass unmodelled at a point, the catalogue's structures and linear forces)
//! predicts residuals of all kinds; each is fitted, and they compete by BIC in one likelihood. Up
//! to three are adopted in turn and fitted together. The adopted changes are tested by predicting
//! the upper modes from the lower ones. Changes that predict the same features are reported as not
//! separable.
//!
//! Example of a plant file for such a structure: `deploy/plants/rigs/cantilever.toml`. A sigma on a
//! mode's frequency or damping is the trust in its model, mode by mode; without one the size of the
//! discrepancy is estimated, one for frequencies, one for damping ratios (5 % at least), one for
//! shapes.
//!
//! Not here: amplitudes of responses (a residue needs the input's place, which a list of modes does
//! not hold), and dependence on the amplitude of the motion, which the parts of a record show
//! ([`ModeTrack`]).

mod changes;
mod comparison;
mod drift;
mod frame;
mod likelihood;
mod linear_laws;
mod matching;
mod peaks;
mod plant_modes;
mod report;
mod search;
mod shapes;
mod upper_modes;

pub use drift::{ModeInPart, ModeTrack};
pub use peaks::{MeasuredMode, ShapeComponent, Spectrum};

use crate::diagnose::Diagnosis;
use comparison::Comparison;
use dynamics::description::Plant;

/// Level and bounds of a diagnosis from features.
#[derive(Clone, Copy, Debug)]
pub struct FeatureOptions {
    /// Probability of any finding where nothing is missing.
    pub alpha: f64,
    /// Number of lower modes that a change is fitted to before it has to predict the others;
    /// `None`: the lower half, three at least.
    pub fitted_modes: Option<usize>,
}

impl Default for FeatureOptions {
    fn default() -> Self {
        Self { alpha: 0.01, fitted_modes: None }
    }
}

/// Diagnosis of `plant` from the magnitude of a spectrum. Damping is evidence where a peak is wide
/// against the spacing of the lines.
///
/// A spectrum without a peak, or a plant without modes, gives
/// [`Verdict::CannotDecide`](crate::diagnose::Verdict::CannotDecide) with the reason. Cost: some 50
/// linearisations of the plant for each change.
pub fn diagnose_spectrum(plant: &Plant, spectrum: &Spectrum, options: &FeatureOptions) -> Diagnosis {
    let (found, narrow) = spectrum.modes_with_own_damping();
    if found.is_empty() {
        let reason = format!("spectrum '{}' has no peak above its floor", spectrum.name);
        return Diagnosis::cannot_decide(reason);
    }
    let mut diagnosis = diagnose_modes(plant, &spectrum.name, &found, options);
    if narrow > 0 {
        diagnosis.notes.push(format!(
            "{narrow} of {} peaks are as narrow as the lines: their width is the window's, and no evidence of damping",
            found.len()
        ));
    }
    diagnosis
}

/// Diagnosis of `plant` from measured modes, whatever their source; `name` stands in the reasons.
/// Cost as [`diagnose_spectrum`] without the peaks.
pub fn diagnose_modes(plant: &Plant, name: &str, measured: &[MeasuredMode], options: &FeatureOptions) -> Diagnosis {
    match Comparison::new(plant, name, measured) {
        Ok(comparison) => comparison.conclude(options),
        Err(reason) => Diagnosis::cannot_decide(reason),
    }
}

/// As [`diagnose_modes`], with the same modes over parts of their record: parameters that are not
/// constant over the parts are reported as well.
pub fn diagnose_tracked_modes(
    plant: &Plant,
    name: &str,
    measured: &[MeasuredMode],
    tracks: &[ModeTrack],
    options: &FeatureOptions,
) -> Diagnosis {
    let mut diagnosis = diagnose_modes(plant, name, measured, options);
    drift::add_drifts(&mut diagnosis, tracks, options.alpha);
    diagnosis
}

#[cfg(test)]
mod tests;
