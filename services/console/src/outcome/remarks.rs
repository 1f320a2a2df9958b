//! What is said of a parameter beside its value: what the record did to its prior, what the
//! sensors' data sheet may have done to it, and whether it shows a target.

use nalgebra::SMatrix;
use physics::mated::{MatedAlpha, off_axis_sigmas};
use plant_file::scenario::{ArmKnown, SheetSigmas};
use telemetry::{Estimate, Identifiability, InertialEstimate, Phase};

/// The parameter that is zero while link 2 holds nothing off its axis.
const OFF_AXIS_AT: usize = 8;

/// What an estimator says of number i; nothing without a prior.
pub(super) fn identifiability(estimate: &Estimate, i: usize) -> Option<&'static str> {
    let found = Identifiability::from_code(*estimate.identifiability.get(i)?)?;
    (found != Identifiability::NoPrior).then_some(found.text())
}

/// What `inertial-id` says of number i; nothing where no prior is stated: it then starts from one
/// that holds nothing.
pub(super) fn arm_identifiability(known: &ArmKnown, estimate: &Estimate, i: usize) -> Option<&'static str> {
    known.prior_relative_sd.and(identifiability(estimate, i))
}

/// NaN: not known (yet); `None` where the data sheet states no error.
pub(super) fn consider_sigma(known: &ArmKnown, sample: &InertialEstimate, i: usize) -> Option<f64> {
    sample.consider_sigma_kg_m2.get(i).copied().filter(|_| known.sheet != SheetSigmas::default())
}

/// Of the parameter that shows a target, in sigmas of noise and data sheet together; `None` where
/// the part of the data sheet is not known, or the number is its prior's. An error of the momentum
/// scales all numbers and moves no zero: its part `(σ_h / h)² α α'` of the covariance is taken out.
pub(super) fn off_axis(known: &ArmKnown, sample: &InertialEstimate, i: usize) -> Option<f64> {
    let estimate = &sample.estimate;
    let is_mated = estimate.phase == Phase::Mated.code();
    let is_prior = known.prior_relative_sd.is_some()
        && arm_identifiability(known, estimate, OFF_AXIS_AT) != Some(Identifiability::Identified.text());
    let sheet = sample.consider_sigma_kg_m2[OFF_AXIS_AT];
    if i != OFF_AXIS_AT || !is_mated || is_prior {
        return None;
    }
    let alpha = MatedAlpha::from_fn(|i, _| estimate.values[i]);
    let scale = if known.h_cm_sigma_nms > 0.0 { known.h_cm_sigma_nms / known.h_cm_nms } else { 0.0 };
    let mut covariance = SMatrix::<f64, 9, 9>::from_fn(|i, j| estimate.covariance[i][j]);
    covariance -= alpha * alpha.transpose() * (scale * scale);
    covariance[(OFF_AXIS_AT, OFF_AXIS_AT)] += sheet * sheet; // NaN: no variance, nothing is said
    off_axis_sigmas(&alpha, &covariance)
}

#[cfg(test)]
mod tests;
