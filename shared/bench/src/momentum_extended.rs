//! Momentum with more unknowns than the arm: gyro latency and external torque, or an unknown
//! momentum.
//!
//! - **Latency and drift.** A gyro late by δ reads `w0 − δ ẇ0`, an external torque lets the
//!   momentum grow as `h + T t`: `[Y_h, ẇ0 (D α), −t] [α; δ; T] = h`, `D α = ∂h/∂w0`. Both columns
//!   are cheap (the bound of the eight rises by 5–40 %), left out they cost twenty times the bound:
//!   5 ms is the largest practical error there is.
//! - **Wheel modulation.** With a wheel of known momentum `h_w(t)` the total is `Y_h α + h_w = h`,
//!   h unknown: `[Y_h, −1] [α; h] = −h_w(t)` is no longer homogeneous and gives α absolutely.

use crate::momentum_methods::{KnownMomentum, MomentumError};
use estimation::weighted_least_squares::{Estimate, NoisyRow};
use estimation::weighted_pass::WeightedPass;
use nalgebra::{SMatrix, SVector};
use physics::momentum::{CHANNELS, ChannelSigma, MomentumSample, locked_inertia_kg_m2, noisy_momentum_row};

/// Samples on either side of the line whose slope is `ẇ0`: ±0.1 s at 100 Hz. Its noise, 1e-3
/// rad/s², is 1 % of the motion's.
pub const SLOPE_SAMPLES: usize = 10;
const EXTENDED_PASSES: usize = 4;

/// Index of the gyro latency \[s\] in the estimate of [`with_latency_and_drift`].
pub const LATENCY: usize = 8;
/// Index of the external torque [N m] in the same estimate.
pub const EXTERNAL_TORQUE: usize = 9;

/// A row with `E` columns more, free of noise of their own.
fn widened<const P: usize, const A: usize>(row: &NoisyRow<P, CHANNELS>, extra: &[f64]) -> NoisyRow<A, CHANNELS> {
    NoisyRow {
        regressor: SVector::from_fn(|i, _| if i < P { row.regressor[i] } else { extra[i - P] }),
        observed: row.observed,
        observed_variance: row.observed_variance,
        noise: SMatrix::from_fn(|i, j| if i < P { row.noise[(i, j)] } else { 0.0 }),
    }
}

/// Slope of the base rate at sample k: least squares line through its neighbours; `None` at the
/// ends.
fn base_acceleration(samples: &[MomentumSample], k: usize, interval_s: f64) -> Option<f64> {
    let reach = SLOPE_SAMPLES;
    if k < reach || k + reach >= samples.len() {
        return None;
    }
    let (mut sum, mut norm) = (0.0, 0.0);
    for j in 1..=reach {
        let offset = j as f64;
        sum += offset * (samples[k + j].omega0_z_rad_s - samples[k - j].omega0_z_rad_s);
        norm += 2.0 * offset * offset;
    }
    Some(sum / (norm * interval_s))
}

/// Eight parameters, gyro latency and external torque together, with `χ²/N` of the residuals; time
/// counts from the first sample.
///
/// # Errors
/// [`MomentumError::ScaleUnknown`], [`MomentumError::NotExcited`].
pub fn with_latency_and_drift(
    samples: &[MomentumSample],
    interval_s: f64,
    momentum: KnownMomentum,
    sigma: &ChannelSigma,
    start: &SVector<f64, 8>,
) -> Result<(Estimate<10>, f64), MomentumError> {
    let (h_nms, channels) = (momentum.checked()?.h_nms, sigma.in_channel_order());
    let mut alpha = SVector::<f64, 10>::zeros();
    alpha.fixed_rows_mut::<8>(0).copy_from(start);
    let mut outcome = None;
    for _ in 0..EXTENDED_PASSES {
        let arm: SVector<f64, 8> = alpha.fixed_rows::<8>(0).into_owned();
        let mut pass = WeightedPass::at(alpha);
        for (k, sample) in samples.iter().enumerate() {
            let Some(acceleration) = base_acceleration(samples, k, interval_s) else { continue };
            let late = acceleration * locked_inertia_kg_m2(&arm, sample.joint_angle_rad);
            let row = noisy_momentum_row::<8>(sample, h_nms, &channels);
            pass.push(&widened::<8, 10>(&row, &[late, -(k as f64) * interval_s]));
        }
        let estimate = pass.estimate().map_err(MomentumError::NotExcited)?;
        alpha = estimate.alpha;
        outcome = Some((estimate, pass.chi_square_per_row(&alpha)));
    }
    let (mut estimate, chi_square) = outcome.expect("there is at least one pass");
    // an error of the momentum scales the parameters and the torque, not the latency
    let mut moved = estimate.alpha * (momentum.sigma_h_nms / h_nms);
    moved[LATENCY] = 0.0;
    estimate.covariance += moved * moved.transpose();
    Ok((estimate, chi_square))
}

/// `P` parameters and, last, the total momentum, from a wheel whose momentum is `wheel_nms(k)` at
/// sample k; `A = P + 1`.
///
/// # Errors
/// [`MomentumError::WheelUnmoved`]: the wheel's momentum does not vary by enough to show the scale;
/// [`MomentumError::NotExcited`]: the arm did not move.
pub fn with_wheel_modulation<const P: usize, const A: usize>(
    samples: &[MomentumSample],
    wheel_nms: impl Fn(usize) -> f64,
    sigma: &ChannelSigma,
    start: &SVector<f64, P>,
) -> Result<(Estimate<A>, f64), MomentumError> {
    const { assert!(A == P + 1) }
    let channels = sigma.in_channel_order();
    wheel_shows(samples, &wheel_nms, &channels, start)?;
    let mut alpha = SVector::<f64, A>::from_fn(|i, _| if i < P { start[i] } else { 0.0 });
    let mut outcome = None;
    for count in 0..2 * EXTENDED_PASSES {
        let mut pass = if count < EXTENDED_PASSES { WeightedPass::at(alpha) } else { WeightedPass::likely_at(alpha) };
        for (k, sample) in samples.iter().enumerate() {
            let row = noisy_momentum_row::<P>(sample, -wheel_nms(k), &channels);
            pass.push(&widened::<P, A>(&row, &[-1.0]));
        }
        let estimate = pass.estimate().map_err(MomentumError::NotExcited)?;
        alpha = estimate.alpha;
        outcome = Some((estimate, pass.chi_square_per_row(&alpha)));
    }
    Ok(outcome.expect("there is at least one pass"))
}

/// The scale is determined by the wheel's variation over the noise of the mean, `s/√N`: below five
/// of these it is not known to a fifth.
fn wheel_shows<const P: usize>(
    samples: &[MomentumSample],
    wheel_nms: &impl Fn(usize) -> f64,
    channels: &[f64; CHANNELS],
    start: &SVector<f64, P>,
) -> Result<(), MomentumError> {
    const TIMES: f64 = 5.0;
    let n = samples.len().max(1) as f64;
    let mean = (0..samples.len()).map(wheel_nms).sum::<f64>() / n;
    let square = |k| (wheel_nms(k) - mean) * (wheel_nms(k) - mean);
    let wheel_rms_nms = libm::sqrt((0..samples.len()).map(square).sum::<f64>() / n);
    let of_row = |sample| noisy_momentum_row::<P>(sample, 0.0, channels).residual_variance(start);
    let noise = libm::sqrt(samples.iter().map(of_row).sum::<f64>() / n);
    let needed_nms = TIMES * noise / libm::sqrt(n);
    let shows = wheel_rms_nms > needed_nms;
    if shows { Ok(()) } else { Err(MomentumError::WheelUnmoved { wheel_rms_nms, needed_nms }) }
}

#[cfg(test)]
mod tests;
