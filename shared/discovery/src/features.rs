//! Diagnosis from features: where a recording is a spectrum, frequency responses or a list of modes, the modes are the evidence.
//!
//! Modes with standard errors (a list, or the peaks of a spectrum) are brought together with the plant's, by frequency and where there are
//! shapes by these, and leave the residuals `ln f_measured − ln f_plant`, `ln ζ_measured − ln ζ_plant` and the components of the
//! plant's shape across the measured one. Every change that a plant offers (an appendage's common stiffness or damping, one mode's, a
//! root that gives, a mass forgotten at a point, the catalogue's structures and linear forces) predicts residuals of all kinds; each
//! is fitted, and they compete by BIC in one likelihood, on equal terms. Up to three are adopted in turn and fitted together. What was
//! adopted is asked to predict the upper modes from the lower ones. Changes that predict the same features are said to be not separable.
//!
//! How a plant file describes such a structure: `deploy/plants/rigs/cantilever.toml`. A sigma on a mode's frequency or damping is what its model
//! is trusted to, mode by mode; without one the size of the discrepancy is estimated, one for frequencies, one for damping ratios (5 %
//! at least), one for shapes.
//!
//! Not here: amplitudes of responses (a residue's size needs the input's place, which a list of modes does not hold), and whatever depends on how
//! strong the motion was, which the parts of a record show ([`ModeTrack`]).

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

/// Levels and bounds.
#[derive(Clone, Copy, Debug)]
pub struct FeatureOptions {
    /// Probability of any finding where nothing is missing.
    pub alpha: f64,
    /// Modes from which a change is fitted when it has to predict the others; `None`: the lower half, three at least.
    pub fitted_modes: Option<usize>,
}

impl Default for FeatureOptions {
    fn default() -> Self {
        Self { alpha: 0.01, fitted_modes: None }
    }
}

/// Diagnosis of a plant from a spectrum's magnitude. Damping is evidence where a peak is wide against the lines.
pub fn diagnose_spectrum(plant: &Plant, spectrum: &Spectrum, options: &FeatureOptions) -> Diagnosis {
    let (found, narrow) = spectrum.modes_with_own_damping();
    if found.is_empty() {
        let reason = format!("spectrum '{}' has no peak that stands above its floor", spectrum.name);
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

/// Diagnosis of a plant from modes measured in any way.
pub fn diagnose_modes(plant: &Plant, name: &str, measured: &[MeasuredMode], options: &FeatureOptions) -> Diagnosis {
    match Comparison::new(plant, name, measured) {
        Ok(comparison) => comparison.conclude(options),
        Err(reason) => Diagnosis::cannot_decide(reason),
    }
}

/// As [`diagnose_modes`], with the same modes over parts of their record: what is not constant over them is reported beside.
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
