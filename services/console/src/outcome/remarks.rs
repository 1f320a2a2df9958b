//! What is said of a parameter beside its value: what the record did to its prior, what the sensor sheet may have done to it, and
//! whether it shows a target.

use nalgebra::SMatrix;
use physics::mated::{MatedAlpha, off_axis_sigmas};
use runtime::scenario::{ArmKnown, SheetSigmas};
use telemetry::{Domain, EXCITATION_AT, Estimate, Phase, STANDINGS_AT};

/// The parameter that is zero while link 2 holds nothing off its axis.
const OFF_AXIS_AT: usize = 8;

/// What `slosh-id` says of number i; nothing without a prior.
pub(super) fn slosh_standing(estimate: &Estimate, i: usize) -> Option<&'static str> {
    match *estimate.auxiliary.get(STANDINGS_AT + i)? as u32 {
        1 => Some("identified"),
        2 => Some("prior kept"),
        3 => Some("not excited"),
        _ => None,
    }
}

/// What `inertial-id` says of number i; nothing without a prior.
pub(super) fn arm_standing(known: &ArmKnown, estimate: &Estimate, i: usize) -> Option<&'static str> {
    known.prior_relative_sd?;
    let digits = estimate.auxiliary[EXCITATION_AT] as u64;
    ["identified", "prior kept", "not excited"].get((digits >> (2 * i) & 0b11) as usize).copied()
}

/// NaN: not known (yet); nothing where the sheet states no error.
pub(super) fn consider_sigma(known: &ArmKnown, estimate: &Estimate, i: usize) -> Option<f64> {
    estimate.auxiliary.get(i).copied().filter(|_| known.sheet != SheetSigmas::default())
}

/// Of the parameter that shows a target, in sigmas of noise and sheet together; nothing where the sheet's part is not known, or the
/// number is its prior's. An error of the momentum scales all numbers and moves no zero: its part `(σ_h / h)² α α'` of the covariance
/// is taken out.
pub(super) fn off_axis(known: &ArmKnown, estimate: &Estimate, i: usize) -> Option<f64> {
    let is_mated = estimate.domain == Domain::Inertial.code() && estimate.phase == Phase::Mated.code();
    let is_prior =
        known.prior_relative_sd.is_some() && arm_standing(known, estimate, OFF_AXIS_AT) != Some("identified");
    let sheet = estimate.auxiliary[OFF_AXIS_AT];
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
