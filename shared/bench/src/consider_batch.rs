//! The weighted momentum fit of a whole record, with both covariances: that of the noise and that
//! of the sensors' data sheet.
//!
//! In flight `arm_live` keeps the same sums sample by sample (`physics::consider`).

use crate::momentum_methods::{KnownMomentum, MomentumError};
use estimation::weighted_least_squares::{Estimate, LeastSquaresError};
use estimation::weighted_pass::WeightedPass;
use nalgebra::{SMatrix, SVector};
use physics::consider::{ConsiderSums, SensorSheet};
use physics::momentum::{ChannelSigma, MomentumSample, noisy_momentum_row};

/// An estimate with both covariances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConsideredEstimate<const P: usize> {
    /// Covariance of the noise.
    pub estimate: Estimate<P>,
    /// Of the sheet's systematic errors.
    pub consider: SMatrix<f64, P, P>,
}

impl<const P: usize> ConsideredEstimate<P> {
    /// What an interval must be built on.
    pub fn total(&self) -> SMatrix<f64, P, P> {
        self.estimate.covariance + self.consider
    }
}

/// The weighted fit at `reference` (a converged α) with the consider covariance of `sheet`.
///
/// # Errors
/// [`MomentumError::ScaleUnknown`], [`MomentumError::NotExcited`].
pub fn consider<const P: usize>(
    samples: &[MomentumSample],
    interval_s: f64,
    momentum: KnownMomentum,
    sigma: &ChannelSigma,
    sheet: &SensorSheet,
    reference: &SVector<f64, P>,
) -> Result<ConsideredEstimate<P>, MomentumError> {
    let (h_nms, channels) = (momentum.checked()?.h_nms, sigma.in_channel_order());
    let (mut pass, mut sums) = (WeightedPass::at(*reference), ConsiderSums::new(interval_s, &SVector::zeros()));
    for sample in samples {
        pass.push(&noisy_momentum_row::<P>(sample, h_nms, &channels));
        sums.push(sample, h_nms, sigma, reference);
    }
    let estimate = pass.estimate().map_err(MomentumError::NotExcited)?;
    let not_excited = LeastSquaresError::InformationNotPositive { rows: samples.len() as u64, weakest: 0.0 };
    let consider = sums.covariance(sheet, samples.len() as u64).ok_or(MomentumError::NotExcited(not_excited))?;
    Ok(ConsideredEstimate { estimate: momentum.scaled(estimate), consider })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;
    use crate::simulated_arm::{H_NMS, INTERVAL_S, benchmark_arm, benchmark_sigma, record};
    use estimation::consistency::nees;
    use physics::consider::channels_by_error;
    use physics::free_floating::PlanarArm;

    const SHEET: SensorSheet = SensorSheet {
        gyro_bias_rad_s: 5e-5,
        gyro_scale: 3e-4,
        joint_rate_scale: [3e-4; 2],
        joint_zero_rad: [3e-4; 2],
        latency_s: 1e-3,
    };
    const MOMENTUM: KnownMomentum = KnownMomentum { h_nms: H_NMS, sigma_h_nms: 0.0 };

    /// The record with errors drawn from the sheet.
    fn spoilt(samples: &[MomentumSample], noise: &mut SeededNoise) -> Vec<MomentumSample> {
        let drawn = SHEET.sigmas().map(|sigma| sigma * noise.normal());
        let spoil = |k: usize| {
            let (before, after) = (k.saturating_sub(5), (k + 5).min(samples.len() - 1));
            let change = samples[after].omega0_z_rad_s - samples[before].omega0_z_rad_s;
            let moved = channels_by_error(&samples[k], change / ((after - before) as f64 * INTERVAL_S)) * drawn;
            let mut sample = samples[k];
            sample.omega0_z_rad_s += moved[0];
            (0..2).for_each(|i| sample.joint_rate_rad_s[i] += moved[1 + i]);
            (0..2).for_each(|i| sample.joint_angle_rad[i] += moved[3 + i]);
            sample
        };
        (0..samples.len()).map(spoil).collect()
    }

    #[test]
    fn with_errors_of_the_sheet_drawn_at_random_the_total_covariance_is_honest_and_that_of_the_noise_is_not() {
        let truth = PlanarArm { base_to_joint_m: [0.99, 0.40], ..benchmark_arm() }.minimal_parameters();
        let (clean, sigma) = (record(&truth, &benchmark_sigma(), 60, 1, 0.0), benchmark_sigma());
        let clean: Vec<MomentumSample> = clean.iter().map(|sample| sample.motion).collect();
        let (mut alone, mut together, seeds) = (0.0, 0.0, 100);
        for seed in 0..seeds {
            let mut noise = SeededNoise::new(seed);
            let mut samples = spoilt(&clean, &mut noise);
            for sample in &mut samples {
                sample.omega0_z_rad_s += sigma.omega0_rad_s * noise.normal();
                (0..2).for_each(|i| sample.joint_rate_rad_s[i] += sigma.joint_rate_rad_s[i] * noise.normal());
                (0..2).for_each(|i| sample.joint_angle_rad[i] += sigma.joint_angle_rad[i] * noise.normal());
            }
            let found = consider(&samples, INTERVAL_S, MOMENTUM, &sigma, &SHEET, &truth).expect("excited");
            let error = found.estimate.alpha - truth;
            alone += nees(&error, &found.estimate.covariance).expect("positive") / seeds as f64;
            together += nees(&error, &found.total()).expect("positive") / seeds as f64;
        }
        // √(16/100) = 0.4, four of them.
        assert!((together - 8.0).abs() < 1.6, "{together}");
        assert!(alone > 80.0, "{alone}");
    }

    #[test]
    fn longer_records_shrink_the_noise_and_leave_what_the_sheet_may_do() {
        let truth = benchmark_arm().minimal_parameters();
        let clean: Vec<MomentumSample> =
            record(&truth, &benchmark_sigma(), 120, 1, 0.0).iter().map(|sample| sample.motion).collect();
        let of = |samples: &[MomentumSample]| {
            let found = consider(samples, INTERVAL_S, MOMENTUM, &benchmark_sigma(), &SHEET, &truth).expect("excited");
            (found.estimate.covariance.trace(), found.consider.trace())
        };
        let ((noise_1, sheet_1), (noise_2, sheet_2)) = (of(&clean[..6000]), of(&clean));
        assert!((noise_1 / noise_2 - 2.0).abs() < 0.05, "{}", noise_1 / noise_2); // two periods against four
        assert!((sheet_1 / sheet_2 - 1.0).abs() < 0.05, "{}", sheet_1 / sheet_2);
    }
}
