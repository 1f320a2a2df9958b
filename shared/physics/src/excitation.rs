//! Joint trajectories that excite, and the bound an experiment along them promises before it is
//! flown.

use estimation::cramer_rao::FisherInformation;
use nalgebra::SVector;
use serde::{Deserialize, Serialize};

use crate::momentum::{ChannelSigma, MomentumSample, noisy_momentum_row, predict_base_rate};

/// Harmonics of one joint.
pub const HARMONICS: usize = 5;

/// `θ(t) = q0 + Σ_k [a_k sin(k w t) − b_k cos(k w t)] / (k w)`, so that
/// `θ̇ = Σ_k a_k cos(k w t) + b_k sin(k w t)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourierJoint<const H: usize = HARMONICS> {
    pub offset_rad: f64,
    pub cosine_rate_rad_s: [f64; H],
    pub sine_rate_rad_s: [f64; H],
}

/// Reference motion of both joints with one base period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourierTrajectory<const H: usize = HARMONICS> {
    pub period_s: f64,
    pub joints: [FourierJoint<H>; 2],
}

/// Angles, rates and accelerations of both joints at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointReference {
    pub angle_rad: [f64; 2],
    pub rate_rad_s: [f64; 2],
    pub acceleration_rad_s2: [f64; 2],
}

impl<const H: usize> FourierTrajectory<H> {
    /// Angle, rate and acceleration of both joints at `time_s` \[s\].
    pub fn at(&self, time_s: f64) -> JointReference {
        let mut reference = JointReference::default();
        for (i, joint) in self.joints.iter().enumerate() {
            reference.angle_rad[i] = joint.offset_rad;
            for k in 0..H {
                let omega = (k + 1) as f64 * 2.0 * core::f64::consts::PI / self.period_s;
                let (sine, cosine) = libm::sincos(omega * time_s);
                let (a, b) = (joint.cosine_rate_rad_s[k], joint.sine_rate_rad_s[k]);
                reference.angle_rad[i] += (a * sine - b * cosine) / omega;
                reference.rate_rad_s[i] += a * cosine + b * sine;
                reference.acceleration_rad_s2[i] += omega * (b * cosine - a * sine);
            }
        }
        reference
    }
}

impl FourierTrajectory {
    /// Trajectory B of benchmark problem 1 (benchmark page 1, section 2): both joints within 0.35
    /// rad/s, 30 s period.
    pub fn trajectory_b() -> Self {
        Self {
            period_s: 30.0,
            joints: [
                FourierJoint {
                    offset_rad: 0.8277,
                    cosine_rate_rad_s: [-0.36, 0.0061, -0.0068, -0.0033, 0.0323],
                    sine_rate_rad_s: [0.0042, 0.032, 0.0134, -0.0239, -0.0163],
                },
                FourierJoint {
                    offset_rad: -1.8193,
                    cosine_rate_rad_s: [-0.0128, -0.1301, -0.0935, 0.1354, -0.176],
                    sine_rate_rad_s: [-0.0972, -0.0953, 0.0463, 0.139, 0.065],
                },
            ],
        }
    }
}

/// Standard deviation each parameter should reach: Cramér–Rao bound with the base moving as `h`
/// demands.
///
/// `I = Σ y y'/s²(α)`, and `(σ_h/h)² α_i²` on top, because a wrong `h` scales every parameter
/// alike. `None` when `alpha` has no positive inertia on the way, or the trajectory leaves a
/// parameter without trace. Cost O(P²) per sample of the planned record.
pub fn predicted_sigma<const P: usize>(
    alpha: &SVector<f64, P>,
    trajectory: &FourierTrajectory,
    plan: &MomentumPlan,
    sigma: &ChannelSigma,
) -> Option<SVector<f64, P>> {
    let mut information = FisherInformation::<P>::default();
    let sigma = sigma.in_channel_order();
    let samples = libm::floor(plan.duration_s * plan.rate_hz) as u64;
    for k in 0..samples {
        let reference = trajectory.at(k as f64 / plan.rate_hz);
        let omega0 = predict_base_rate(alpha, plan.h_nms, reference.angle_rad, reference.rate_rad_s)?;
        let sample = MomentumSample {
            omega0_z_rad_s: omega0,
            joint_rate_rad_s: reference.rate_rad_s,
            joint_angle_rad: reference.angle_rad,
        };
        let row = noisy_momentum_row::<P>(&sample, plan.h_nms, &sigma);
        information.push(&row.regressor, row.residual_variance(alpha));
    }
    let scale_variance = (plan.sigma_h_nms / plan.h_nms) * (plan.sigma_h_nms / plan.h_nms);
    let bound = information.bound()?.diagonal();
    Some(bound.zip_map(alpha, |variance, value| libm::sqrt(variance + scale_variance * value * value)))
}

/// A planned record of momentum samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MomentumPlan {
    pub h_nms: f64,
    pub sigma_h_nms: f64,
    pub duration_s: f64,
    pub rate_hz: f64,
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::free_floating::PlanarArm;

    pub fn trajectory_b() -> FourierTrajectory {
        FourierTrajectory::trajectory_b()
    }

    /// Sensors of the benchmark at 100 Hz: 0.09 °/√h gyro, 1e-4 rad/s joint rates, 19-bit encoders.
    pub fn benchmark_sigma() -> ChannelSigma {
        ChannelSigma { omega0_rad_s: 2.618e-4, joint_rate_rad_s: [1e-4; 2], joint_angle_rad: [1.25e-5; 2] }
    }

    pub const PLAN: MomentumPlan = MomentumPlan { h_nms: 68.0, sigma_h_nms: 0.0, duration_s: 60.0, rate_hz: 100.0 };

    #[test]
    fn rate_is_the_derivative_of_the_angle_and_acceleration_that_of_the_rate() {
        let trajectory = trajectory_b();
        for k in 0..50 {
            let t = 0.7 * f64::from(k);
            let (next, last) = (trajectory.at(t + 1e-5), trajectory.at(t - 1e-5));
            for joint in 0..2 {
                let difference = (next.angle_rad[joint] - last.angle_rad[joint]) / 2e-5;
                assert!((difference - trajectory.at(t).rate_rad_s[joint]).abs() < 1e-9); // truncation 1e-10
                let difference = (next.rate_rad_s[joint] - last.rate_rad_s[joint]) / 2e-5;
                assert!((difference - trajectory.at(t).acceleration_rad_s2[joint]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn bound_along_trajectory_b_equals_the_independent_prototype() {
        let printed = [0.0052, 0.0075, 0.0092, 0.0136, 0.0128, 0.0230, 0.0229, 0.0146];
        let alpha = PlanarArm::default().minimal_parameters();
        let sigma = predicted_sigma(&alpha, &trajectory_b(), &PLAN, &benchmark_sigma()).expect("exciting");
        for i in 0..8 {
            let percent = 100.0 * sigma[i] / alpha[i];
            assert!((percent / printed[i] - 1.0).abs() < 0.02, "a{}: {percent}", i + 1); // printed to 4 decimals; tracking error
        }
    }

    #[test]
    fn doubling_the_record_shrinks_the_bound_by_root_two() {
        let alpha = PlanarArm::default().minimal_parameters();
        let twice = MomentumPlan { duration_s: 120.0, ..PLAN };
        let one = predicted_sigma(&alpha, &trajectory_b(), &PLAN, &benchmark_sigma()).expect("exciting");
        let two = predicted_sigma(&alpha, &trajectory_b(), &twice, &benchmark_sigma()).expect("exciting");
        for i in 0..8 {
            assert!((one[i] / two[i] / 2.0_f64.sqrt() - 1.0).abs() < 1e-9); // whole periods: exact but for rounding
        }
    }

    #[test]
    fn arm_at_rest_has_no_bound() {
        let mut still = trajectory_b();
        for joint in &mut still.joints {
            joint.cosine_rate_rad_s = [0.0; 5];
            joint.sine_rate_rad_s = [0.0; 5];
        }
        let alpha = PlanarArm::default().minimal_parameters();
        assert_eq!(predicted_sigma(&alpha, &still, &PLAN, &benchmark_sigma()), None);
    }
}
