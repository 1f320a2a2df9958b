//! The free-floating arm in closed loop with its sensors: the truth of BP1, before and after
//! capture.
//!
//! Every period: the sensors are read, a PD law on the noisy joint measurements plus 0.9 of the
//! inverse-dynamics torque of the reference gives a command, the command is held while the chain
//! moves.
//!
//! Why closed loop: the torque an estimator sees is then correlated with the joint noise, as on a
//! real arm; estimators that are only right for open-loop data fail here as they would in flight.

use crate::fourier_reference::{FourierReference, JointTarget};
use crate::oracle::arm_parameters::{ArmChain, ArmParameters};
use crate::oracle::chain::{Invariants, Motion};
use crate::oracle::sensor::Channel;
use crate::sensor::random_walk_sample_sigma;
use dynamics::noise::Stream;
use nalgebra::SVector;
use serde::{Deserialize, Serialize};

const PROPORTIONAL_NM_RAD: [f64; 2] = [600.0, 250.0];
const DERIVATIVE_NMS_RAD: [f64; 2] = [300.0, 120.0];
/// The controller's model is deliberately 10 % off.
const FEED_FORWARD_SHARE: f64 = 0.9;
/// Longest integration step; at 5 ms the momentum drifts by 1e-10 Nms in 60 s.
const INTEGRATION_STEP_S_MAX: f64 = 0.005;

/// Noise of the arm's sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmNoise {
    /// Angle random walk of the gyro [rad/√s]; one sample has standard deviation `ARW / √period`.
    pub gyro_arw_rad_sqrt_s: f64,
    pub joint_angle_sigma_rad: f64,
    /// Quantisation step of the joint encoders; 0 = none.
    pub joint_angle_lsb_rad: f64,
    pub joint_rate_sigma_rad_s: f64,
    pub joint_torque_sigma_nm: f64,
}

impl Default for ArmNoise {
    /// The benchmark's: gyro 0.09 °/√h, 19-bit encoders with 12 µrad, rates 0.1 mrad/s, torques 0.1
    /// Nm.
    fn default() -> Self {
        Self {
            gyro_arw_rad_sqrt_s: 0.09 / 60.0 * core::f64::consts::PI / 180.0,
            joint_angle_sigma_rad: 1.2e-5,
            joint_angle_lsb_rad: core::f64::consts::TAU / f64::from(1 << 19),
            joint_rate_sigma_rad_s: 1e-4,
            joint_torque_sigma_nm: 0.1,
        }
    }
}

impl ArmNoise {
    /// Perfect sensors.
    pub const fn none() -> Self {
        Self {
            gyro_arw_rad_sqrt_s: 0.0,
            joint_angle_sigma_rad: 0.0,
            joint_angle_lsb_rad: 0.0,
            joint_rate_sigma_rad_s: 0.0,
            joint_torque_sigma_nm: 0.0,
        }
    }
}

/// What the sensors say at `t_k`; the torque is the one held on `[t_k, t_k + period)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmMeasurement {
    pub omega0_z_rad_s: f64,
    pub joint_angle_rad: [f64; 2],
    pub joint_rate_rad_s: [f64; 2],
    pub joint_torque_nm: [f64; 2],
}

/// Everything that changes: with the configuration it determines the future.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmState {
    /// Base x, y [m], attitude and joint angles [rad]; their rates.
    pub motion: Motion<5>,
    /// Number of steps taken; time is `sample × period`.
    pub sample: u64,
    /// Number of excited steps taken; the reference stands at `excited_sample × period`.
    pub excited_sample: u64,
}

/// The noise-free counterpart of a measurement, and what no sensor sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmTruth {
    pub omega0_z_rad_s: f64,
    pub joint_angle_rad: [f64; 2],
    pub joint_rate_rad_s: [f64; 2],
    pub reference: JointTarget,
    pub invariants: Invariants,
}

#[derive(Clone, Debug)]
struct Sensors {
    gyro: Channel,
    joint_angle: [Channel; 2],
    joint_rate: [Channel; 2],
    joint_torque: [Channel; 2],
}

/// The simulator.
#[derive(Clone, Debug)]
pub struct FreeFloatingArm {
    chain: ArmChain,
    reference: FourierReference,
    sensors: Sensors,
    h_cm_nms: f64,
    period_s: f64,
    state: ArmState,
}

impl FreeFloatingArm {
    /// Arm on its reference at t = 0 (angles and rates), its system centre of mass at rest in the
    /// origin, its system angular momentum `h_cm_nms`. Noise streams are named
    /// `{stream_prefix}.gyro.z`, `{stream_prefix}.joint1.angle`, ….
    pub fn new(
        parameters: &ArmParameters,
        reference: FourierReference,
        noise: &ArmNoise,
        h_cm_nms: f64,
        period_s: f64,
        seed: u64,
        stream_prefix: &str,
    ) -> Self {
        assert!(period_s > 0.0 && period_s.is_finite());
        let chain = parameters.chain();
        let motion = motion_on(&chain, &reference.at(0.0), h_cm_nms);
        Self {
            chain,
            reference,
            sensors: Sensors::new(noise, period_s, seed, stream_prefix),
            h_cm_nms,
            period_s,
            state: ArmState { motion, sample: 0, excited_sample: 0 },
        }
    }

    /// Reads the sensors, commands the joints, moves on by one period.
    ///
    /// `excited = false` freezes the reference where it stands and asks for zero joint rate.
    ///
    /// Cost: 10 integrations' worth of mass matrices, no allocation.
    pub fn step(&mut self, excited: bool) -> ArmMeasurement {
        let target = self.target(excited);
        let mut measurement = self.sensors.read(&self.state);
        let torque_nm = self.command(&target, &measurement);
        for (j, torque) in torque_nm.into_iter().enumerate() {
            measurement.joint_torque_nm[j] = self.sensors.joint_torque[j].measure(torque, self.state.sample);
        }
        let force = SVector::<f64, 5>::from([0.0, 0.0, 0.0, torque_nm[0], torque_nm[1]]);
        let substeps = libm::ceil(self.period_s / INTEGRATION_STEP_S_MAX - 1e-9).max(1.0);
        for _ in 0..substeps as u32 {
            self.chain.advance(&mut self.state.motion, &force, self.period_s / substeps);
        }
        self.state.sample += 1;
        self.state.excited_sample += u64::from(excited);
        measurement
    }

    /// The changing part, for a checkpoint.
    pub fn state(&self) -> ArmState {
        self.state
    }

    /// Continues from a checkpoint of an arm built with the same configuration.
    pub fn restore(&mut self, state: ArmState) {
        self.state = state;
    }

    /// Noise-free values at the present instant, i.e. of the sample the next `step` will measure.
    pub fn truth(&self) -> ArmTruth {
        let motion = &self.state.motion;
        ArmTruth {
            omega0_z_rad_s: motion.q_dot[2],
            joint_angle_rad: [motion.q[3], motion.q[4]],
            joint_rate_rad_s: [motion.q_dot[3], motion.q_dot[4]],
            reference: self.reference.at(self.state.excited_sample as f64 * self.period_s),
            invariants: self.chain.invariants(motion),
        }
    }

    fn target(&self, excited: bool) -> JointTarget {
        let moving = self.reference.at(self.state.excited_sample as f64 * self.period_s);
        if excited {
            moving
        } else {
            JointTarget { angle_rad: moving.angle_rad, rate_rad_s: [0.0; 2], acceleration_rad_s2: [0.0; 2] }
        }
    }

    fn command(&self, target: &JointTarget, measured: &ArmMeasurement) -> [f64; 2] {
        let on_reference = motion_on(&self.chain, target, self.h_cm_nms);
        let [acceleration_1, acceleration_2] = target.acceleration_rad_s2;
        let wanted = SVector::<f64, 5>::from([0.0, 0.0, 0.0, acceleration_1, acceleration_2]);
        let feed_forward = self.chain.inverse_dynamics(&on_reference, wanted);
        core::array::from_fn(|j| {
            PROPORTIONAL_NM_RAD[j] * (target.angle_rad[j] - measured.joint_angle_rad[j])
                + DERIVATIVE_NMS_RAD[j] * (target.rate_rad_s[j] - measured.joint_rate_rad_s[j])
                + FEED_FORWARD_SHARE * feed_forward[3 + j]
        })
    }
}

/// The chain with its joints on target, base attitude zero, CM at rest in the origin, angular
/// momentum `h_nms`.
fn motion_on(chain: &ArmChain, target: &JointTarget, h_nms: f64) -> Motion<5> {
    let ([angle_1, angle_2], [rate_1, rate_2]) = (target.angle_rad, target.rate_rad_s);
    let mut motion = Motion {
        q: SVector::from([0.0, 0.0, 0.0, angle_1, angle_2]),
        q_dot: SVector::from([0.0, 0.0, 0.0, rate_1, rate_2]),
    };
    let com = chain.invariants(&motion).com_from_base_m;
    (motion.q[0], motion.q[1]) = (-com[0], -com[1]);
    chain.set_base_velocity_from_momentum(&mut motion, h_nms);
    motion
}

impl Sensors {
    fn new(noise: &ArmNoise, period_s: f64, seed: u64, prefix: &str) -> Self {
        let stream = |name: &str| Stream::new(seed, &format!("{prefix}.{name}"));
        let angle = |name| Channel::quantised(stream(name), noise.joint_angle_sigma_rad, noise.joint_angle_lsb_rad);
        let rate = |name| Channel::white(stream(name), noise.joint_rate_sigma_rad_s);
        let torque = |name| Channel::white(stream(name), noise.joint_torque_sigma_nm);
        let gyro_sigma = random_walk_sample_sigma(noise.gyro_arw_rad_sqrt_s, period_s);
        Self {
            gyro: Channel::white(stream("gyro.z"), gyro_sigma),
            joint_angle: [angle("joint1.angle"), angle("joint2.angle")],
            joint_rate: [rate("joint1.rate"), rate("joint2.rate")],
            joint_torque: [torque("joint1.torque"), torque("joint2.torque")],
        }
    }

    /// All but the torque, which is not yet commanded.
    fn read(&self, state: &ArmState) -> ArmMeasurement {
        let (q, q_dot, sample) = (&state.motion.q, &state.motion.q_dot, state.sample);
        ArmMeasurement {
            omega0_z_rad_s: self.gyro.measure(q_dot[2], sample),
            joint_angle_rad: core::array::from_fn(|j| self.joint_angle[j].measure(q[3 + j], sample)),
            joint_rate_rad_s: core::array::from_fn(|j| self.joint_rate[j].measure(q_dot[3 + j], sample)),
            joint_torque_nm: [0.0; 2],
        }
    }
}

#[cfg(test)]
mod tests;
