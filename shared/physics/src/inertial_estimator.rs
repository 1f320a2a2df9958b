//! Momentum samples in, inertial parameters with an honest covariance out.
//!
//! Joins the momentum regressor with the errors-in-variables estimator and the consistency
//! statistics. The scale of every parameter is that of `h_cm`: a momentum wrong by 0.1 % makes all
//! of them wrong by 0.1 % and leaves no trace in the residual. `h_cm` is therefore an input with a
//! sigma, the sigma is carried into the covariance, and without a momentum the estimator cannot be
//! made.

use estimation::Innovation;
use estimation::consistency::{ChiSquareMean, Whiteness};
use estimation::weighted_least_squares::{BiasCompensatedLeastSquares, LeastSquaresError};
use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

use crate::momentum::{CHANNELS, ChannelSigma, MomentumSample, is_physically_consistent, noisy_momentum_row};

/// Weights and reference are refreshed after so many samples.
const ROWS_PER_REFRESH: u32 = 50;

/// Innovations count as statistics once the estimate's own uncertainty is below this share of the
/// sensor noise: before, the covariance itself is taken at poor parameters (with 0.2 the mean NIS
/// of 200 records is 1.08, not 1.00).
const SETTLED_SHARE: f64 = 0.05;

/// How the momentum and the sensors are known, and where to start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InertialSettings<const P: usize> {
    /// Angular momentum about the centre of mass of the whole system.
    pub h_nms: f64,
    pub sigma_h_nms: f64,
    pub sigma: ChannelSigma,
    pub prior_alpha: SVector<f64, P>,
    /// Prior standard deviation over prior value; 1000 is "a number to start from", information
    /// 1e-6/a².
    pub prior_relative_sd: f64,
}

impl<const P: usize> InertialSettings<P> {
    /// Standard deviations of the prior. A parameter expected at zero (a9 before capture) is
    /// uncertain on the scale of the others.
    pub fn prior_sd(&self) -> SVector<f64, P> {
        let scale = self.prior_alpha.norm() / libm::sqrt(P as f64);
        self.prior_alpha.map(|value| self.prior_relative_sd * value.abs().max(0.01 * scale))
    }
}

/// Why the momentum gives no parameters, or a sample was not used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InertialError {
    /// Momentum is zero or as uncertain as it is large: parameters have no scale. Spin up a wheel,
    /// or use torques.
    MomentumUnknown { h_nms: f64, sigma_h_nms: f64 },
    /// A sample contains NaN or infinity and was not used.
    SampleNotFinite,
    /// Rows carry more noise than signal in some direction; excite more or wait.
    NotExcited(LeastSquaresError),
}

/// Parameters, what they are worth, and whether the model explains the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertialEstimate<const P: usize> {
    pub alpha: SVector<f64, P>,
    /// Includes `(σ_h/h)² α α'`.
    pub covariance: SMatrix<f64, P, P>,
    /// Of the samples' noise alone.
    pub noise_covariance: SMatrix<f64, P, P>,
    pub rows: u64,
    /// Innovation squared over its variance, over the newer half of the record (between 1/2 and 3/4
    /// of the rows); one per degree of freedom when model and sigmas hold.
    pub nis: ChiSquareMean,
    pub whiteness: Whiteness,
    /// Positive definite in every posture, see [`is_physically_consistent`]. Do not fly an estimate
    /// that is not.
    pub consistent: bool,
}

/// Recursive estimator of the momentum parameters: eight before capture, nine mated. Fixed memory
/// (36 kB for eight).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InertialEstimator<const P: usize> {
    h_nms: f64,
    sigma_h_nms: f64,
    sigma: [f64; CHANNELS],
    least_squares: BiasCompensatedLeastSquares<P>,
    /// Of the newer half of the record, and of what will be the newer half when it has doubled.
    statistics: [InnovationStatistics; 2],
}

/// Mean NIS and whiteness from some row on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct InnovationStatistics {
    nis: ChiSquareMean,
    whiteness: Whiteness,
}

impl<const P: usize> InertialEstimator<P> {
    /// # Errors
    /// [`InertialError::MomentumUnknown`] when `σ_h` is not smaller than `|h|`.
    pub fn new(settings: &InertialSettings<P>) -> Result<Self, InertialError> {
        let (h_nms, sigma_h_nms) = (settings.h_nms, settings.sigma_h_nms);
        let known = h_nms.is_finite() && sigma_h_nms >= 0.0 && sigma_h_nms < h_nms.abs();
        if !known {
            return Err(InertialError::MomentumUnknown { h_nms, sigma_h_nms });
        }
        let sigma = settings.sigma.in_channel_order();
        assert!(sigma.iter().all(|value| *value >= 0.0));
        assert!(sigma.iter().any(|value| *value > 0.0));
        assert!(settings.prior_relative_sd > 0.0);
        let information = settings.prior_sd().map(|sd| 1.0 / (sd * sd));
        let least_squares = BiasCompensatedLeastSquares::new(settings.prior_alpha, information, ROWS_PER_REFRESH);
        Ok(Self { h_nms, sigma_h_nms, sigma, least_squares, statistics: Default::default() })
    }

    /// Takes one sample; the innovation is momentum known minus momentum predicted [N m s].
    ///
    /// # Errors
    /// [`InertialError::SampleNotFinite`]; the state is untouched then.
    pub fn push(&mut self, sample: &MomentumSample) -> Result<Innovation, InertialError> {
        if !sample.is_finite() {
            return Err(InertialError::SampleNotFinite);
        }
        let row = noisy_momentum_row::<P>(sample, self.h_nms, &self.sigma);
        let innovation = self.least_squares.update(&row);
        if self.least_squares.rows().is_power_of_two() {
            // A one-pass estimate that still moves says nothing of the model: the first half of a
            // record is forgotten.
            self.statistics = [self.statistics[1], InnovationStatistics::default()];
        }
        if self.settled(&innovation) {
            let normalised = innovation.normalised();
            for statistics in &mut self.statistics {
                statistics.nis.push(normalised * normalised, 1);
                statistics.whiteness.push(normalised);
            }
        }
        Ok(innovation)
    }

    /// Whether the estimate that gave this innovation moves by little against the noise of one
    /// sample.
    pub fn settled(&self, innovation: &Innovation) -> bool {
        innovation.uncertainty_over_noise() < SETTLED_SHARE
    }

    /// The parameters as they are between refreshes: what weights and innovations are taken at.
    pub fn reference(&self) -> &SVector<f64, P> {
        &self.least_squares.reference().alpha
    }

    /// # Errors
    /// [`InertialError::NotExcited`] when the samples do not determine the parameters.
    pub fn estimate(&self) -> Result<InertialEstimate<P>, InertialError> {
        let estimate = self.least_squares.estimate().map_err(InertialError::NotExcited)?;
        let alpha = estimate.alpha;
        let scale_sd = self.sigma_h_nms / self.h_nms;
        let covariance = estimate.covariance + alpha * alpha.transpose() * (scale_sd * scale_sd);
        Ok(InertialEstimate {
            alpha,
            covariance,
            noise_covariance: estimate.covariance,
            rows: self.least_squares.rows(),
            nis: self.statistics[0].nis,
            whiteness: self.statistics[0].whiteness,
            consistent: is_physically_consistent(&alpha),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::predicted_sigma;
    use crate::excitation::tests::{PLAN, benchmark_sigma, trajectory_b};
    use crate::free_floating::{Alpha, PlanarArm};
    use crate::momentum::predict_base_rate;
    use crate::seeded_noise::SeededNoise;
    use estimation::consistency::nees;
    use std::println;
    use std::vec::Vec;

    /// Noise-free samples of trajectory B; the oracle of the momentum is `momentum::tests`, from
    /// bodies.
    fn clean_samples(alpha: &Alpha, seconds: u32) -> Vec<MomentumSample> {
        let trajectory = trajectory_b();
        (0..seconds * 100)
            .map(|k| {
                let reference = trajectory.at(f64::from(k) * 0.01);
                let omega0_z_rad_s =
                    predict_base_rate(alpha, 68.0, reference.angle_rad, reference.rate_rad_s).expect("true parameters");
                MomentumSample {
                    omega0_z_rad_s,
                    joint_rate_rad_s: reference.rate_rad_s,
                    joint_angle_rad: reference.angle_rad,
                }
            })
            .collect()
    }

    fn noisy(clean: &MomentumSample, sigma: &ChannelSigma, noise: &mut SeededNoise) -> MomentumSample {
        let lsb = 2.0 * core::f64::consts::PI / 524_288.0;
        let mut measured = *clean;
        measured.omega0_z_rad_s += sigma.omega0_rad_s * noise.normal();
        for joint in 0..2 {
            measured.joint_rate_rad_s[joint] += sigma.joint_rate_rad_s[joint] * noise.normal();
            let angle = measured.joint_angle_rad[joint] + 1.2e-5 * noise.normal();
            measured.joint_angle_rad[joint] = libm::round(angle / lsb) * lsb;
        }
        measured
    }

    fn settings(truth: &Alpha, start: f64) -> InertialSettings<8> {
        InertialSettings {
            h_nms: 68.0,
            sigma_h_nms: 0.0,
            sigma: benchmark_sigma(),
            prior_alpha: truth * start,
            prior_relative_sd: 1000.0,
        }
    }

    fn run(clean: &[MomentumSample], settings: &InertialSettings<8>, seed: u64) -> InertialEstimator<8> {
        let (mut noise, mut estimator) = (SeededNoise::new(seed), InertialEstimator::new(settings).expect("h known"));
        for sample in clean {
            estimator.push(&noisy(sample, &benchmark_sigma(), &mut noise)).expect("finite");
        }
        estimator
    }

    #[test]
    fn one_pass_from_55_percent_reaches_the_bound_with_an_honest_covariance() {
        let truth = PlanarArm::default().minimal_parameters();
        let clean = clean_samples(&truth, 60);
        let bound = predicted_sigma(&truth, &trajectory_b(), &PLAN, &benchmark_sigma()).expect("exciting");
        const SEEDS: u64 = 200;
        let (mut squares, mut statistic, mut covered) = (Alpha::zeros(), ChiSquareMean::default(), 0);
        let mut nis = (0.0, 0.0_f64, 0.0_f64);
        for seed in 0..SEEDS {
            let estimate = run(&clean, &settings(&truth, 0.55), seed).estimate().expect("excited");
            let error = estimate.alpha - truth;
            squares += error.component_mul(&error);
            statistic.push(nees(&error, &estimate.covariance).expect("positive"), 8);
            covered += (0..8).filter(|i| error[*i].abs() < 1.96 * estimate.covariance[(*i, *i)].sqrt()).count();
            nis.0 += estimate.nis.per_degree().expect("settled") / SEEDS as f64;
            nis.1 = nis.1.max(estimate.nis.z_score().expect("settled").abs());
            nis.2 = nis.2.max(estimate.whiteness.worst_z_score());
            assert!(estimate.consistent);
        }
        let ratio = squares.zip_map(&bound, |square, sd| (square / SEEDS as f64).sqrt() / sd);
        let mean = libm::exp(ratio.map(libm::log).sum() / 8.0);
        let (nees, coverage) = (statistic.mean().expect("200"), covered as f64 / (8 * SEEDS) as f64);
        println!(
            "RMSE/CRLB {ratio:.3?} geometric mean {mean:.3}; NEES {nees:.2}; coverage {coverage:.3}; NIS {nis:.4?}"
        );
        // 200 seeds: each ratio spreads by 5 %, their geometric mean by about 2 %, NEES by
        // √(16/200) = 0.28.
        assert!(mean < 1.06, "{mean}");
        assert!(ratio.max() < 1.2, "{ratio}");
        assert!(nees > 7.2 && nees < 8.8, "{nees}");
        assert!(coverage > 0.935 && coverage < 0.965, "{coverage}");
        assert!(nis.0 > 0.99 && nis.0 < 1.01, "{nis:?}");
        assert!(nis.1 < 5.0 && nis.2 < 5.0, "{nis:?}"); // worst of 200 and of 600 z-scores
    }

    #[test]
    fn weights_fixed_at_a_poor_start_cost_a_third_of_the_accuracy_and_late_weights_nothing() {
        let truth = PlanarArm::default().minimal_parameters();
        let (clean, sigma) = (clean_samples(&truth, 60), benchmark_sigma().in_channel_order());
        let start = truth * 0.55;
        let squared_error_sum = |late_blocks: usize| {
            let mut sum = 0.0;
            for seed in 0..40 {
                let mut noise = SeededNoise::new(seed);
                let information = start.map(|value| 1e-6 / (value * value));
                let mut one_pass =
                    BiasCompensatedLeastSquares::new(start, information, 50).with_late_blocks(late_blocks);
                for sample in &clean {
                    let measured = noisy(sample, &benchmark_sigma(), &mut noise);
                    one_pass.update(&noisy_momentum_row::<8>(&measured, 68.0, &sigma));
                }
                let error = one_pass.estimate().expect("excited").alpha - truth;
                sum += error.component_div(&truth).norm_squared();
            }
            sum
        };
        let ratio = libm::sqrt(squared_error_sum(0) / squared_error_sum(32));
        println!("RMS error, weights at once over late weights: {ratio:.3}");
        assert!(ratio > 1.2, "{ratio}"); // measured 1.5 with 200 seeds; same noise in both, so the ratio spreads little
    }

    #[test]
    fn swapped_channel_sigmas_are_caught_by_nis_only() {
        let truth = PlanarArm::default().minimal_parameters();
        let mut swapped = settings(&truth, 1.0);
        swapped.sigma.joint_rate_rad_s = [1.25e-5; 2];
        swapped.sigma.omega0_rad_s = 1e-4;
        swapped.sigma.joint_angle_rad = [2.618e-4, 1e-4];
        let estimate = run(&clean_samples(&truth, 60), &swapped, 1).estimate().expect("excited");
        let worst = (estimate.alpha - truth).component_div(&truth).abs().max();
        assert!(worst < 1e-3, "{worst}"); // looks fine
        assert!(estimate.nis.z_score().expect("settled") > 50.0); // is not
    }

    #[test]
    fn noise_free_samples_return_the_truth_from_far_starts() {
        let truth = PlanarArm { base_to_joint_m: [0.99, 0.40], ..Default::default() }.minimal_parameters();
        for start in [0.2, 1.8] {
            let mut estimator = InertialEstimator::new(&InertialSettings {
                sigma: ChannelSigma { omega0_rad_s: 1e-9, joint_rate_rad_s: [0.0; 2], joint_angle_rad: [0.0; 2] },
                ..settings(&truth, start)
            })
            .expect("h known");
            for sample in clean_samples(&truth, 30) {
                estimator.push(&sample).expect("finite");
            }
            let alpha = estimator.estimate().expect("excited").alpha;
            assert!((alpha - truth).norm() < 1e-8 * truth.norm()); // rounding × squared condition 7.5² of the rows
        }
    }

    #[test]
    fn momentum_error_scales_every_parameter_alike_and_is_carried_by_sigma_h() {
        let truth = PlanarArm::default().minimal_parameters();
        let wrong = InertialSettings { h_nms: 68.0 * 1.001, sigma_h_nms: 0.068, ..settings(&truth, 0.55) };
        let clean = clean_samples(&truth, 60);
        let (right, wrong) = (run(&clean, &settings(&truth, 0.55), 3), run(&clean, &wrong, 3));
        let (right, wrong) = (right.estimate().expect("excited"), wrong.estimate().expect("excited"));
        for i in 0..8 {
            assert!((wrong.alpha[i] / right.alpha[i] - 1.001).abs() < 1e-6); // weights and prior differ slightly
            assert!(wrong.covariance[(i, i)].sqrt() / truth[i] > 0.999e-3);
        }
    }

    #[test]
    fn unknown_momentum_and_broken_samples_are_refused() {
        let truth = PlanarArm::default().minimal_parameters();
        for (h_nms, sigma_h_nms) in [(0.0, 0.0), (1.0, 2.0), (f64::NAN, 0.0)] {
            let unknown = InertialSettings { h_nms, sigma_h_nms, ..settings(&truth, 1.0) };
            assert!(matches!(InertialEstimator::new(&unknown), Err(InertialError::MomentumUnknown { .. })));
        }
        let mut estimator = InertialEstimator::new(&settings(&truth, 1.0)).expect("h known");
        let before = estimator.clone();
        let broken = MomentumSample { omega0_z_rad_s: f64::NAN, ..Default::default() };
        assert_eq!(estimator.push(&broken), Err(InertialError::SampleNotFinite));
        assert_eq!(estimator, before);
    }

    #[test]
    fn an_arm_at_rest_leaves_the_prior_uncertainty_in_place() {
        let truth = PlanarArm::default().minimal_parameters();
        let still = clean_samples(&truth, 1)[0];
        let estimator = run(&std::vec![still; 3000], &settings(&truth, 0.55), 4);
        // Refused or useless, never confident: one posture fixes one combination of eight.
        if let Ok(estimate) = estimator.estimate() {
            assert!(estimate.covariance.diagonal().map(f64::sqrt).component_div(&truth).max() > 10.0);
        }
    }

    #[test]
    fn a_checkpoint_continues_bit_for_bit() {
        let truth = PlanarArm::default().minimal_parameters();
        let mut original = run(&clean_samples(&truth, 20), &settings(&truth, 0.55), 5);
        let bytes = postcard::to_stdvec(&original).expect("plain numbers");
        println!("checkpoint {} bytes", bytes.len());
        let mut restored: InertialEstimator<8> = postcard::from_bytes(&bytes).expect("own bytes");
        for sample in clean_samples(&truth, 5) {
            assert_eq!(original.push(&sample), restored.push(&sample));
        }
        assert_eq!(original, restored);
    }

    #[test]
    fn ninth_parameter_stays_insignificant_without_a_target() {
        let eight = PlanarArm::default().minimal_parameters();
        let (mut prior, mut noise) = (SVector::<f64, 9>::zeros(), SeededNoise::new(6));
        prior.fixed_rows_mut::<8>(0).copy_from(&(eight * 0.55));
        let nine = InertialSettings::<9> {
            h_nms: 68.0,
            sigma_h_nms: 0.0,
            sigma: benchmark_sigma(),
            prior_alpha: prior,
            prior_relative_sd: 1000.0,
        };
        let mut estimator = InertialEstimator::new(&nine).expect("h known");
        for sample in clean_samples(&eight, 60) {
            estimator.push(&noisy(&sample, &benchmark_sigma(), &mut noise)).expect("finite");
        }
        let estimate = estimator.estimate().expect("excited");
        assert!(estimate.alpha[8].abs() < 4.0 * estimate.covariance[(8, 8)].sqrt());
        assert!(estimate.covariance[(8, 8)].sqrt() < 0.1); // kg m²: it is determined, not merely unconstrained
    }
}
