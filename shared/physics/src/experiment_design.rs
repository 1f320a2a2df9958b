//! What a joint trajectory promises and what it asks: the bound of the parameters, and the peaks that hardware limits.
//!
//! The figure of merit is the root mean square of the relative sigmas; limits enter as the square of their relative violation, so that the
//! figure is smooth and a search may start outside them.

use crate::dynamic_equation::{ArmMotion, efforts};
use crate::excitation::FourierTrajectory;
use crate::momentum::{ChannelSigma, MomentumSample, noisy_momentum_row, predict_base_rate};
use estimation::cramer_rao::FisherInformation;
use nalgebra::SVector;

/// What joints and base must not exceed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmLimits {
    pub joint_angle_rad: f64,
    pub joint_rate_rad_s: f64,
    pub base_rate_rad_s: f64,
    pub torque_n_m: f64,
}

/// Along one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assessment {
    /// Of each parameter over a record of [`Design::duration_s`], relative.
    pub relative_sigma: SVector<f64, 8>,
    /// Largest joint angle, joint rate, base rate, torque.
    pub peaks: ArmLimits,
}

/// Arm, sensors and record the trajectory is designed for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Design {
    pub alpha: SVector<f64, 8>,
    pub h_nms: f64,
    pub sigma: ChannelSigma,
    /// Of the sensors.
    pub rate_hz: f64,
    /// Whole periods.
    pub duration_s: f64,
    pub limits: ArmLimits,
}

/// Instants of a period that are looked at: 25 per period of the fifth harmonic.
const INSTANTS: usize = 125;
/// Weight of violated limits.
const PENALTY: f64 = 5.0;

impl Design {
    /// `None`: the parameters are not physical, or some parameter leaves no trace. Cost: 250 µs.
    pub fn assess(&self, trajectory: &FourierTrajectory) -> Option<Assessment> {
        let (mut information, sigma) = (FisherInformation::<8>::default(), self.sigma.in_channel_order());
        let mut peaks =
            ArmLimits { joint_angle_rad: 0.0, joint_rate_rad_s: 0.0, base_rate_rad_s: 0.0, torque_n_m: 0.0 };
        // Each instant stands for so many samples of the record.
        let share = self.duration_s * self.rate_hz / INSTANTS as f64;
        for k in 0..INSTANTS {
            let motion = self.motion(trajectory, trajectory.period_s * k as f64 / INSTANTS as f64)?;
            let [omega0_z_rad_s, rate_1, rate_2] = motion.rates_rad_s;
            let sample = MomentumSample {
                omega0_z_rad_s,
                joint_rate_rad_s: [rate_1, rate_2],
                joint_angle_rad: motion.joint_angle_rad,
            };
            let row = noisy_momentum_row::<8>(&sample, self.h_nms, &sigma);
            information.push(&row.regressor, row.residual_variance(&self.alpha) / share);
            let torque = efforts(&self.alpha, &motion);
            let larger = |peak: &mut f64, values: [f64; 2]| *peak = peak.max(values[0].abs()).max(values[1].abs());
            larger(&mut peaks.joint_angle_rad, motion.joint_angle_rad);
            larger(&mut peaks.joint_rate_rad_s, [rate_1, rate_2]);
            larger(&mut peaks.base_rate_rad_s, [omega0_z_rad_s; 2]);
            larger(&mut peaks.torque_n_m, [torque[1], torque[2]]);
        }
        let relative_sigma = information.sigmas()?.component_div(&self.alpha).abs();
        Some(Assessment { relative_sigma, peaks })
    }

    fn motion(&self, trajectory: &FourierTrajectory, time_s: f64) -> Option<ArmMotion> {
        const STEP_S: f64 = 1e-3; // slowest period 6 s: truncation 1e-7
        let rates = |time_s: f64| {
            let reference = trajectory.at(time_s);
            let w0 = predict_base_rate(&self.alpha, self.h_nms, reference.angle_rad, reference.rate_rad_s)?;
            Some([w0, reference.rate_rad_s[0], reference.rate_rad_s[1]])
        };
        let (low, high) = (rates(time_s - STEP_S)?, rates(time_s + STEP_S)?);
        Some(ArmMotion {
            joint_angle_rad: trajectory.at(time_s).angle_rad,
            rates_rad_s: rates(time_s)?,
            accelerations_rad_s2: core::array::from_fn(|i| (high[i] - low[i]) / (2.0 * STEP_S)),
        })
    }

    /// `log RMS(σ_i/α_i) + 5 Σ violation²`; to be minimised.
    pub fn cost(&self, assessment: &Assessment) -> f64 {
        let rms = libm::sqrt(assessment.relative_sigma.norm_squared() / 8.0);
        libm::log(rms) + PENALTY * self.violations(assessment).iter().map(|over| over * over).sum::<f64>()
    }

    /// By how much each limit is exceeded, relative; zero inside.
    pub fn violations(&self, assessment: &Assessment) -> [f64; 4] {
        let (peaks, limits) = (&assessment.peaks, &self.limits);
        let over = |peak: f64, limit: f64| (peak / limit - 1.0).max(0.0);
        [
            over(peaks.joint_angle_rad, limits.joint_angle_rad),
            over(peaks.joint_rate_rad_s, limits.joint_rate_rad_s),
            over(peaks.base_rate_rad_s, limits.base_rate_rad_s),
            over(peaks.torque_n_m, limits.torque_n_m),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::predicted_sigma;
    use crate::excitation::tests::{PLAN, benchmark_sigma};
    use crate::free_floating::PlanarArm;

    fn design() -> Design {
        Design {
            alpha: PlanarArm::default().minimal_parameters(),
            h_nms: 68.0,
            sigma: benchmark_sigma(),
            rate_hz: 100.0,
            duration_s: 60.0,
            limits: ArmLimits {
                joint_angle_rad: 2.64, // the trajectory reaches 2.633
                joint_rate_rad_s: 0.355,
                base_rate_rad_s: 0.405,
                torque_n_m: 20.0,
            },
        }
    }

    #[test]
    fn coarse_instants_promise_what_every_sample_would() {
        let (design, trajectory) = (design(), FourierTrajectory::trajectory_b());
        let coarse = design.assess(&trajectory).expect("exciting").relative_sigma;
        let fine = predicted_sigma(&design.alpha, &trajectory, &PLAN, &benchmark_sigma()).expect("exciting");
        for i in 0..8 {
            assert!((coarse[i] / (fine[i] / design.alpha[i]) - 1.0).abs() < 1e-3); // a rectangle rule over a whole period
        }
    }

    #[test]
    fn peaks_of_trajectory_b_are_the_printed_ones_and_a_tighter_limit_is_violated() {
        let mut design = design();
        let found = design.assess(&FourierTrajectory::trajectory_b()).expect("exciting");
        assert!(
            (found.peaks.joint_rate_rad_s - 0.354).abs() < 2e-3 && (found.peaks.base_rate_rad_s - 0.403).abs() < 2e-3
        );
        assert!((found.peaks.torque_n_m - 17.6).abs() < 0.5); // printed with the feedback's part
        assert_eq!(design.violations(&found), [0.0; 4]);
        let inside = design.cost(&found);
        design.limits.torque_n_m = 10.0;
        assert!(design.cost(&found) > inside + 1.0);
    }
}
