//! Detection of contact from the data: the momentum of a free arm jumps when the rates belong to
//! another body.
//!
//! `h = Y_h α` is constant until a body touches the arm. Neither its level nor the model need be
//! right for that: the test is of the jump of `Y_h α` away from its own running mean
//! ([`JumpDetector`]), so a wrong momentum, a gyro bias or a scaled α is part of the baseline. What
//! the model's error can add is its change since the baseline: with `ȳ` the running mean of the
//! regressor it has the variance `(y − ȳ)ᵀ P (y − ȳ)`, which widens the slack.
//!
//! Any estimate serves, also one that was not accepted: its covariance says how much. Without one
//! the base rate itself is watched; an arm that moves turns the base too, so that test is for an
//! arm held still, as it is while the target is approached and grasped.
//!
//! A detector serves one mode: APPROACH_HOLD and CAPTURE each learn their own baseline, in their
//! first eight samples. Contact within these is not seen.

use estimation::cusum::{FalseAlarm, JumpDetector};
use nalgebra::{SMatrix, SVector};
use physics::momentum::{ChannelSigma, MomentumSample, momentum_regressor, noisy_momentum_row};
use serde::{Deserialize, Serialize};
use telemetry::Estimate;

/// One in a thousand modes of up to 1e5 samples.
pub const FALSE_ALARM: FalseAlarm = FalseAlarm { probability: 1e-3, samples: 1e5 };

/// Channels of unknown noise: the scatter of the data alone decides.
pub const NOISE_UNKNOWN: ChannelSigma =
    ChannelSigma { omega0_rad_s: 0.0, joint_rate_rad_s: [0.0; 2], joint_angle_rad: [0.0; 2] };

/// Contact, recognised.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Frame of the sample that passed the limit.
    pub frame: u64,
    /// Cumulative sum \[sigma\].
    pub statistic: f64,
    /// Limit that the statistic passed \[sigma\].
    pub limit: f64,
}

/// The model of the phase before capture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FreeArm {
    /// Eight inertial parameters of the arm [kg m²].
    pub alpha: SVector<f64, 8>,
    /// Their covariance [kg² m⁴].
    pub covariance: SMatrix<f64, 8, 8>,
}

impl FreeArm {
    /// `None` for an estimate that cannot predict: none made, physically impossible, not finite.
    pub fn of(estimate: &Estimate) -> Option<Self> {
        let arm = Self {
            alpha: SVector::from_fn(|i, _| estimate.values[i]),
            covariance: SMatrix::from_fn(|i, j| estimate.covariance[i][j]),
        };
        let finite = arm.alpha.iter().chain(arm.covariance.iter()).all(|number| number.is_finite());
        (estimate.status == 0 && estimate.consistent == 1 && estimate.count == 8 && finite).then_some(arm)
    }
}

/// Watches one mode for contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactDetector {
    arm: Option<FreeArm>,
    /// Running mean of the regressor, with the detector's gain.
    regressor: SVector<f64, 8>,
    jump: JumpDetector,
    skipped: u64,
    found: Option<Contact>,
}

impl ContactDetector {
    /// With the model, when there is one, else on the base rate alone.
    pub fn new(arm: Option<FreeArm>) -> Self {
        let (regressor, jump) = (SVector::zeros(), JumpDetector::new(FALSE_ALARM));
        Self { arm, regressor, jump, skipped: 0, found: None }
    }

    /// Contact, once it was recognised: it stays.
    pub fn contact(&self) -> Option<Contact> {
        self.found
    }

    /// Samples that were not finite and therefore not used.
    pub fn skipped(&self) -> u64 {
        self.skipped
    }

    /// Takes one sample of `frame` and the noise of its channels ([`NOISE_UNKNOWN`] where it is
    /// unknown); `Some` in the sample that gives the contact away, once.
    pub fn push(&mut self, frame: u64, sample: &MomentumSample, sigma: &ChannelSigma) -> Option<Contact> {
        if !sample.is_finite() {
            self.skipped += 1;
            return None;
        }
        let (value, noise_sigma, drift_sigma) = match &self.arm {
            None => (sample.omega0_z_rad_s, sigma.omega0_rad_s, 0.0),
            Some(arm) => {
                let row = noisy_momentum_row::<8>(sample, 0.0, &sigma.in_channel_order());
                let regressor = momentum_regressor::<8>(sample);
                let moved = regressor - self.regressor;
                self.regressor += moved * self.jump.gain();
                let drift_variance = moved.dot(&(arm.covariance * moved));
                let noise_variance = row.residual_variance(&arm.alpha);
                (regressor.dot(&arm.alpha), noise_variance.max(0.0).sqrt(), drift_variance.max(0.0).sqrt())
            }
        };
        let statistic = self.jump.push(value, noise_sigma, drift_sigma)?;
        if self.found.is_some() || statistic <= self.jump.limit() {
            return None;
        }
        self.found = Some(Contact { frame, statistic, limit: self.jump.limit() });
        self.found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;
    use physics::momentum::predict_base_rate;

    /// Benchmark page 1, sections 1.2 (before capture) and 6 (150 kg target).
    const ALPHA: [f64; 8] = [110.7028, 105.7339, 48.1502, 44.0904, 44.0904, 18.9133, 18.9133, 39.6048];
    const MATED: [f64; 9] = [304.162, 529.887, 755.776, 246.645, 246.645, 288.091, 257.035, 570.753, -32.516];
    const H_NMS: f64 = 68.0;
    const SIGMA: ChannelSigma =
        ChannelSigma { omega0_rad_s: 2.618e-4, joint_rate_rad_s: [1e-4; 2], joint_angle_rad: [1.25e-5; 2] };

    /// A model that is wrong by one draw of its own covariance: `relative` of each parameter.
    fn estimated_arm(noise: &mut SeededNoise, relative: f64) -> FreeArm {
        let alpha = SVector::from_fn(|i, _| ALPHA[i] * (1.0 + relative * noise.normal()));
        let covariance = SMatrix::from_diagonal(&SVector::from(ALPHA).map(|a| (relative * a) * (relative * a)));
        FreeArm { alpha, covariance }
    }

    /// Sample at 100 Hz of the arm moving slowly, the base turning as the momentum `h_nms` of
    /// `alpha` demands.
    fn moving<const P: usize>(alpha: &[f64; P], h_nms: f64, k: u64, noise: &mut SeededNoise) -> MomentumSample {
        let t = k as f64 * 0.01;
        let angle = [0.5 * libm::sin(0.2 * t), -1.2 + 0.4 * libm::cos(0.25 * t)];
        let rate = [0.1 * libm::cos(0.2 * t), -0.1 * libm::sin(0.25 * t)];
        measured(alpha, h_nms, angle, rate, noise)
    }

    /// The same with the arm held.
    fn held<const P: usize>(alpha: &[f64; P], noise: &mut SeededNoise) -> MomentumSample {
        measured(alpha, H_NMS, [0.8277, -1.8193], [0.0; 2], noise)
    }

    fn measured<const P: usize>(
        alpha: &[f64; P],
        h_nms: f64,
        angle: [f64; 2],
        rate: [f64; 2],
        noise: &mut SeededNoise,
    ) -> MomentumSample {
        let base = predict_base_rate(&SVector::from(*alpha), h_nms, angle, rate).expect("positive inertia");
        MomentumSample {
            omega0_z_rad_s: base + SIGMA.omega0_rad_s * noise.normal(),
            joint_rate_rad_s: rate.map(|value| value + 1e-4 * noise.normal()),
            joint_angle_rad: angle.map(|value| value + 1.25e-5 * noise.normal()),
        }
    }

    #[test]
    fn noise_alone_is_never_taken_for_contact_whatever_the_momentum_and_the_model() {
        // 40 runs at 1e-3 each: one of them alarms in 4 % of such suites, were the seeds drawn
        // anew. The model is good to 0.01 % (60 s of excitation) or not accepted: 20 % off. The
        // momentum differs from the one it was fitted with.
        for (relative, h_nms) in [(1e-4, H_NMS), (1e-4, 1.003 * H_NMS), (1e-4, 0.5 * H_NMS), (0.2, H_NMS)] {
            for seed in 0..10 {
                let mut noise = SeededNoise::new(seed);
                let mut detector = ContactDetector::new(Some(estimated_arm(&mut noise, relative)));
                for k in 0..20_000 {
                    let found = detector.push(k, &moving(&ALPHA, h_nms, k, &mut noise), &SIGMA);
                    assert_eq!(found, None, "seed {seed}, {relative}, {h_nms}");
                }
            }
        }
    }

    #[test]
    fn a_momentum_that_drifts_by_an_external_torque_is_no_contact() {
        // 0.01 N m (gravity gradient, solar pressure on large wings) for 200 s: 2 N m s of 68 in
        // all, 0.01 N m s a second against a noise of 0.1 N m s.
        let mut noise = SeededNoise::new(3);
        let mut detector = ContactDetector::new(Some(estimated_arm(&mut noise, 1e-4)));
        for k in 0..20_000 {
            let h_nms = H_NMS + 1e-4 * k as f64;
            assert_eq!(detector.push(k, &moving(&ALPHA, h_nms, k, &mut noise), &SIGMA), None, "sample {k}");
        }
    }

    #[test]
    fn a_target_of_150_kg_is_felt_at_once() {
        // The stack turns as h' demands of a'; from the chaser's momentum unchanged to a target
        // that brings some.
        for (relative, h_mated_nms) in [(1e-4, 68.0), (1e-4, 30.0), (1e-4, 150.0), (0.02, 68.0)] {
            for seed in 0..20 {
                let mut noise = SeededNoise::new(seed);
                let mut detector = ContactDetector::new(Some(estimated_arm(&mut noise, relative)));
                let contact_at = 100 + seed * 137;
                let found = (0..contact_at + 50).find_map(|k| {
                    let sample = if k < contact_at {
                        moving(&ALPHA, H_NMS, k, &mut noise)
                    } else {
                        moving(&MATED, h_mated_nms, k, &mut noise)
                    };
                    detector.push(k, &sample, &SIGMA)
                });
                let contact = found.expect("felt within 50 samples of 10 ms");
                // A jump of hundreds of sigmas.
                assert!((contact_at..=contact_at + 1).contains(&contact.frame), "seed {seed}: {contact:?}");
                assert_eq!(detector.contact(), Some(contact));
            }
        }
    }

    #[test]
    fn without_any_model_the_base_rate_gives_the_grasp_away_and_nothing_before() {
        for (seed, sigma) in (0..20).zip([SIGMA, NOISE_UNKNOWN].into_iter().cycle()) {
            let (mut noise, mut detector) = (SeededNoise::new(seed), ContactDetector::new(None));
            for k in 0..2000 {
                assert_eq!(detector.push(k, &held(&ALPHA, &mut noise), &sigma), None, "seed {seed}");
            }
            let contact = (2000..2010).find_map(|k| detector.push(k, &held(&MATED, &mut noise), &sigma));
            assert_eq!(contact.expect("the stack turns slower").frame, 2000, "seed {seed}");
        }
    }

    #[test]
    fn an_estimate_that_predicts_nothing_is_no_model() {
        let good = || {
            let mut estimate = Estimate::default();
            (estimate.count, estimate.consistent) = (8, 1);
            estimate.values[..8].copy_from_slice(&ALPHA);
            estimate
        };
        assert!(FreeArm::of(&good()).is_some());
        let breaks: [fn(&mut Estimate); 5] = [
            |e| e.status = 2,
            |e| e.consistent = 0,
            |e| e.count = 9,
            |e| e.values[3] = f64::NAN,
            |e| e.covariance[1][2] = f64::INFINITY,
        ];
        for (index, broken) in breaks.into_iter().enumerate() {
            let mut estimate = good();
            broken(&mut estimate);
            assert_eq!(FreeArm::of(&estimate), None, "case {index}");
        }
    }

    #[test]
    fn a_sample_that_is_not_finite_is_counted_and_changes_nothing() {
        let mut noise = SeededNoise::new(1);
        let mut detector = ContactDetector::new(Some(estimated_arm(&mut noise, 1e-4)));
        let mut broken = moving(&ALPHA, H_NMS, 0, &mut noise);
        broken.omega0_z_rad_s = f64::NAN;
        let before = detector.clone();
        assert_eq!(detector.push(0, &broken, &SIGMA), None);
        assert_eq!(detector, ContactDetector { skipped: 1, ..before });
        assert_eq!(detector.skipped(), 1);
    }

    #[test]
    fn a_restored_detector_goes_on_as_the_one_that_was_saved() {
        let mut noise = SeededNoise::new(7);
        let mut detector = ContactDetector::new(Some(estimated_arm(&mut noise, 1e-4)));
        for k in 0..500 {
            let sample = moving(&ALPHA, H_NMS + 0.1 * (k / 300) as f64, k, &mut noise);
            let bytes = postcard::to_allocvec(&detector).unwrap();
            let mut restored: ContactDetector = postcard::from_bytes(&bytes).unwrap();
            assert_eq!(detector.push(k, &sample, &SIGMA), restored.push(k, &sample, &SIGMA));
            assert_eq!(detector, restored);
        }
    }
}
