//! Records of the benchmark's arm for the tests of this crate, in closed loop along trajectory B.
//!
//! The equations of motion are those of `physics`; the benchmarks hold the same estimators against
//! plants that are simulated.

use crate::seeded_noise::SeededNoise;
use nalgebra::SVector;
use physics::dynamic_equation::{ArmMotion, ArmSample, efforts};
use physics::excitation::{FourierTrajectory, JointReference, MomentumPlan};
use physics::free_floating::{PlanarArm, accelerations};
use physics::momentum::{ChannelSigma, MomentumSample, predict_base_rate};

pub const INTERVAL_S: f64 = 0.01;
pub const TORQUE_SIGMA_N_M: f64 = 0.1;
pub const H_NMS: f64 = 68.0;

/// The benchmark's arm, reading A of its table.
pub fn benchmark_arm() -> PlanarArm {
    PlanarArm {
        mass_kg: [400.0, 12.1, 11.7],
        inertia_com_kg_m2: [66.67, 17.27, 14.10],
        base_to_joint_m: [0.99, 0.99],
        joint_to_com_m: [1.9, 1.73],
        com_to_next_m: 0.168,
    }
}

/// Sensors of the benchmark at 100 Hz: 0.09 °/√h gyro, 1e-4 rad/s joint rates, 19-bit encoders.
pub fn benchmark_sigma() -> ChannelSigma {
    ChannelSigma { omega0_rad_s: 2.618e-4, joint_rate_rad_s: [1e-4; 2], joint_angle_rad: [1.25e-5; 2] }
}

pub const PLAN: MomentumPlan = MomentumPlan { h_nms: H_NMS, sigma_h_nms: 0.0, duration_s: 60.0, rate_hz: 100.0 };

/// (w0, th1, th2, d1, d2)
type State = SVector<f64, 5>;

fn rate<const P: usize>(alpha: &SVector<f64, P>, x: &State, torque: [f64; 2]) -> State {
    let a = accelerations(alpha, [x[1], x[2]], [x[0], x[3], x[4]], torque).expect("true parameters");
    State::from([a[0], x[3], x[4], a[1], a[2]])
}

fn stepped<const P: usize>(alpha: &SVector<f64, P>, x: &State, torque: [f64; 2]) -> State {
    let mut x = *x;
    for _ in 0..2 {
        let h = 0.5 * INTERVAL_S;
        let k1 = rate(alpha, &x, torque);
        let k2 = rate(alpha, &(x + k1 * (h / 2.0)), torque);
        let k3 = rate(alpha, &(x + k2 * (h / 2.0)), torque);
        let k4 = rate(alpha, &(x + k3 * h), torque);
        x += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
    }
    x
}

/// Torques that would move the arm along the command.
fn feed_forward<const P: usize>(alpha: &SVector<f64, P>, trajectory: &FourierTrajectory, time_s: f64) -> [f64; 2] {
    let sample = |t: f64| {
        let command = trajectory.at(t);
        let w0 = predict_base_rate(alpha, H_NMS, command.angle_rad, command.rate_rad_s).expect("true parameters");
        [w0, command.rate_rad_s[0], command.rate_rad_s[1]]
    };
    let (low, high) = (sample(time_s - 1e-4), sample(time_s + 1e-4));
    let motion = ArmMotion {
        joint_angle_rad: trajectory.at(time_s).angle_rad,
        rates_rad_s: sample(time_s),
        accelerations_rad_s2: core::array::from_fn(|i| (high[i] - low[i]) / 2e-4),
    };
    let found = efforts(alpha, &motion);
    [found[1], found[2]]
}

/// A record of `seconds`; `noise` scales every sensor's noise.
pub fn record<const P: usize>(
    alpha: &SVector<f64, P>,
    sigma: &ChannelSigma,
    seconds: u32,
    seed: u64,
    noise: f64,
) -> Vec<ArmSample> {
    let (trajectory, mut drawn) = (FourierTrajectory::trajectory_b(), SeededNoise::new(seed));
    let command: JointReference = trajectory.at(0.0);
    let w0 = predict_base_rate(alpha, H_NMS, command.angle_rad, command.rate_rad_s).expect("true parameters");
    let ([th1, th2], [d1, d2]) = (command.angle_rad, command.rate_rad_s);
    let mut x = State::from([w0, th1, th2, d1, d2]);
    let channel = [
        sigma.omega0_rad_s,
        sigma.joint_angle_rad[0],
        sigma.joint_angle_rad[1],
        sigma.joint_rate_rad_s[0],
        sigma.joint_rate_rad_s[1],
    ];
    let mut samples = Vec::new();
    for k in 0..seconds * 100 {
        let time_s = f64::from(k) * INTERVAL_S;
        let z = State::from_fn(|i, _| x[i] + noise * channel[i] * drawn.normal());
        let (command, forward) = (trajectory.at(time_s), feed_forward(alpha, &trajectory, time_s));
        let torque = core::array::from_fn(|i| {
            let (kp, kd) = [(600.0, 300.0), (250.0, 120.0)][i];
            0.9 * forward[i] + kp * (command.angle_rad[i] - z[1 + i]) + kd * (command.rate_rad_s[i] - z[3 + i])
        });
        samples.push(ArmSample {
            motion: MomentumSample {
                omega0_z_rad_s: z[0],
                joint_angle_rad: [z[1], z[2]],
                joint_rate_rad_s: [z[3], z[4]],
            },
            torque_n_m: core::array::from_fn(|i| torque[i] + noise * TORQUE_SIGMA_N_M * drawn.normal()),
        });
        x = stepped(alpha, &x, torque);
    }
    samples
}
