//! What a joint trajectory promises and what it asks: the bound of the parameters, and the peaks
//! that hardware limits.
//!
//! The figure of merit is the root mean square of the relative sigmas. Limits enter as the mean
//! square of their relative excess along the motion, so that the figure is smooth and a search may
//! start outside them; [`Assessment::peaks`] are what is finally checked, on a grid as fine as one
//! likes.

use estimation::cramer_rao::FisherInformation;
use nalgebra::{SVector, Vector2, Vector3};
use physics::excitation::{FourierTrajectory, JointReference};
use physics::free_floating::{PlanarArm, dynamics};
use physics::momentum::{ChannelSigma, MomentumSample, noisy_momentum_row, predict_base_rate};

/// Largest joint angle, joint rate, base rate, torque and displacement of the propellant: as
/// allowed, or as reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmLimits {
    pub joint_angle_rad: f64,
    pub joint_rate_rad_s: f64,
    pub base_rate_rad_s: f64,
    pub torque_n_m: f64,
    pub slosh_stroke_m: f64,
}

impl ArmLimits {
    /// In the order of the fields.
    pub fn values(&self) -> [f64; LIMITS] {
        [self.joint_angle_rad, self.joint_rate_rad_s, self.base_rate_rad_s, self.torque_n_m, self.slosh_stroke_m]
    }
}

/// How many things are limited.
pub const LIMITS: usize = 5;

/// Propellant that the motion must not throw against its tank: a mass on a spring in the plane of
/// the base, too light to act back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tank {
    /// Of the arm with its masses: the base's acceleration follows from them.
    pub arm: PlanarArm,
    /// From the base's centre of mass, base axes.
    pub position_m: [f64; 2],
    pub frequency_hz: f64,
    /// Below one.
    pub damping_ratio: f64,
}

/// Along one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assessment {
    /// Of each parameter over a record of [`Design::duration_s`], relative.
    pub relative_sigma: SVector<f64, 8>,
    pub peaks: ArmLimits,
    /// Mean square of the relative excess over each limit.
    pub excess: [f64; LIMITS],
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
    pub tank: Option<Tank>,
}

/// Instants looked at per period of the highest harmonic while searching.
const INSTANTS_PER_HARMONIC: usize = 20;
/// Weight of the excess.
const PENALTY: f64 = 1e4;
/// Periods after the record that begins at rest: where the motion would go on, the stroke settles.
const SETTLED_PERIODS: usize = 1;

/// Base and joints at one instant.
struct Motion {
    joints: JointReference,
    omega0_rad_s: f64,
    omega0_dot_rad_s2: f64,
    torque_n_m: [f64; 2],
}

impl Design {
    /// At as many instants as a search needs.
    pub fn assess<const H: usize>(&self, trajectory: &FourierTrajectory<H>) -> Option<Assessment> {
        self.assess_at(trajectory, INSTANTS_PER_HARMONIC * H)
    }

    /// `None`: the parameters are not physical, or some parameter leaves no trace. Cost: 0.5 µs per
    /// instant and harmonic.
    pub fn assess_at<const H: usize>(&self, trajectory: &FourierTrajectory<H>, instants: usize) -> Option<Assessment> {
        let (mut information, sigma) = (FisherInformation::<8>::default(), self.sigma.in_channel_order());
        let (mut peaks, mut excess) = ([0.0; LIMITS], [0.0; LIMITS]);
        let limits = self.limits.values();
        let mut note = |limit: usize, value: f64| {
            peaks[limit] = f64::max(peaks[limit], value.abs());
            let over = (value.abs() / limits[limit] - 1.0).max(0.0);
            excess[limit] += over * over / instants as f64;
        };
        // Each instant stands for so many samples of the record.
        let share = self.duration_s * self.rate_hz / instants as f64;
        for k in 0..instants {
            let motion = self.motion(trajectory, trajectory.period_s * k as f64 / instants as f64)?;
            let sample = MomentumSample {
                omega0_z_rad_s: motion.omega0_rad_s,
                joint_rate_rad_s: motion.joints.rate_rad_s,
                joint_angle_rad: motion.joints.angle_rad,
            };
            let row = noisy_momentum_row::<8>(&sample, self.h_nms, &sigma);
            information.push(&row.regressor, row.residual_variance(&self.alpha) / share);
            for joint in 0..2 {
                note(0, motion.joints.angle_rad[joint]);
                note(1, motion.joints.rate_rad_s[joint]);
                note(3, motion.torque_n_m[joint]);
            }
            note(2, motion.omega0_rad_s);
        }
        if let Some(tank) = &self.tank {
            self.slosh(trajectory, tank, instants, |stroke_m| note(4, stroke_m))?;
        }
        let relative_sigma = information.sigmas()?.component_div(&self.alpha).abs();
        let [joint_angle_rad, joint_rate_rad_s, base_rate_rad_s, torque_n_m, slosh_stroke_m] = peaks;
        let peaks = ArmLimits { joint_angle_rad, joint_rate_rad_s, base_rate_rad_s, torque_n_m, slosh_stroke_m };
        Some(Assessment { relative_sigma, peaks, excess })
    }

    /// The base follows from the momentum, its acceleration and the torques from the equations of
    /// motion.
    fn motion<const H: usize>(&self, trajectory: &FourierTrajectory<H>, time_s: f64) -> Option<Motion> {
        let joints = trajectory.at(time_s);
        let omega0_rad_s = predict_base_rate(&self.alpha, self.h_nms, joints.angle_rad, joints.rate_rad_s)?;
        let rates = [omega0_rad_s, joints.rate_rad_s[0], joints.rate_rad_s[1]];
        let (mass, coriolis) = dynamics(&self.alpha, joints.angle_rad, rates);
        let [dd1, dd2] = joints.acceleration_rad_s2;
        // first row: no torque on the base
        let omega0_dot_rad_s2 = -(mass[(0, 1)] * dd1 + mass[(0, 2)] * dd2 + coriolis[0]) / mass[(0, 0)];
        let effort = mass * Vector3::new(omega0_dot_rad_s2, dd1, dd2) + coriolis;
        Some(Motion { joints, omega0_rad_s, omega0_dot_rad_s2, torque_n_m: [effort[1], effort[2]] })
    }

    /// Displacement of the propellant at each instant of a record that begins at rest, and of
    /// [`SETTLED_PERIODS`] after it.
    ///
    /// In axes that do not turn, `z̈ + 2 ζ Ω (ż − w ẑ×z) + Ω² z = −a`: neither Coriolis nor
    /// centrifugal terms, and the length of z is that of the displacement. Exact for the tank's
    /// acceleration held at its value midway between instants: stable however stiff the spring.
    fn slosh<const H: usize>(
        &self,
        trajectory: &FourierTrajectory<H>,
        tank: &Tank,
        instants: usize,
        mut note: impl FnMut(f64),
    ) -> Option<()> {
        let dt = trajectory.period_s / instants as f64;
        let free = FreeStep::new(tank, dt);
        let (mut z, mut v, mut attitude_rad) = (Vector2::zeros(), Vector2::zeros(), 0.0);
        for k in 0..(SETTLED_PERIODS + 1) * instants {
            let motion = self.motion(trajectory, dt * ((k % instants) as f64 + 0.5))?;
            attitude_rad += 0.5 * dt * motion.omega0_rad_s;
            let (sine, cosine) = libm::sincos(attitude_rad);
            attitude_rad += 0.5 * dt * motion.omega0_rad_s;
            let a = tank.acceleration(&motion);
            let pull = -Vector2::new(cosine * a[0] - sine * a[1], sine * a[0] + cosine * a[1])
                + across(&z) * (2.0 * free.decay_rate * motion.omega0_rad_s);
            (z, v) = free.step(&z, &v, &pull);
            note(z.norm());
        }
        Some(())
    }

    /// `log RMS(σ_i/α_i)` and the penalty of what exceeds its limit; to be minimised.
    pub fn cost(&self, assessment: &Assessment) -> f64 {
        libm::log(assessment.relative_rms()) + PENALTY * assessment.excess.iter().sum::<f64>()
    }

    /// By how much each limit is exceeded at its worst instant, relative; zero inside.
    pub fn violations(&self, assessment: &Assessment) -> [f64; LIMITS] {
        let (peaks, limits) = (assessment.peaks.values(), self.limits.values());
        core::array::from_fn(|i| (peaks[i] / limits[i] - 1.0).max(0.0))
    }

    /// The same design with every limit tightened to this share of itself.
    #[must_use]
    pub fn tightened(&self, share: f64) -> Self {
        let [joint_angle_rad, joint_rate_rad_s, base_rate_rad_s, torque_n_m, slosh_stroke_m] =
            self.limits.values().map(|limit| share * limit);
        let limits = ArmLimits { joint_angle_rad, joint_rate_rad_s, base_rate_rad_s, torque_n_m, slosh_stroke_m };
        Self { limits, ..*self }
    }
}

impl Assessment {
    /// Root mean square of the relative sigmas.
    pub fn relative_rms(&self) -> f64 {
        libm::sqrt(self.relative_sigma.norm_squared() / 8.0)
    }
}

/// `ẑ × x`
fn across(x: &Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-x[1], x[0])
}

/// One step of a damped oscillator under a constant pull, in closed form.
struct FreeStep {
    omega_squared: f64,
    decay_rate: f64,
    /// `e^{−ζΩt} cos ω_d t` and `e^{−ζΩt} sin ω_d t / ω_d`.
    cosine: f64,
    sine: f64,
}

impl FreeStep {
    fn new(tank: &Tank, dt_s: f64) -> Self {
        assert!(tank.damping_ratio < 1.0);
        let omega = tank.omega_rad_s();
        let decay_rate = tank.damping_ratio * omega;
        let damped = omega * libm::sqrt(1.0 - tank.damping_ratio * tank.damping_ratio);
        let (sine, cosine) = libm::sincos(damped * dt_s);
        let left = libm::exp(-decay_rate * dt_s);
        Self { omega_squared: omega * omega, decay_rate, cosine: left * cosine, sine: left * sine / damped }
    }

    fn step(&self, z: &Vector2<f64>, v: &Vector2<f64>, pull: &Vector2<f64>) -> (Vector2<f64>, Vector2<f64>) {
        let rest = pull / self.omega_squared;
        let away = z - rest;
        (
            rest + away * self.cosine + (v + away * self.decay_rate) * self.sine,
            v * self.cosine - (away * self.omega_squared + v * self.decay_rate) * self.sine,
        )
    }
}

impl Tank {
    fn omega_rad_s(&self) -> f64 {
        2.0 * core::f64::consts::PI * self.frequency_hz
    }

    /// Inertial acceleration of the tank in base axes: the centre of mass of the whole rests, so
    /// that the base's is at `−[(m1 + m2) r0 + (m1 l1 + m2 L1) e1 + m2 l2 e12] / M`.
    fn acceleration(&self, motion: &Motion) -> Vector2<f64> {
        let PlanarArm { mass_kg: [m0, m1, m2], base_to_joint_m, joint_to_com_m: [l1, l2], com_to_next_m, .. } =
            self.arm;
        let mass = m0 + m1 + m2;
        let ([th1, th2], [d1, d2]) = (motion.joints.angle_rad, motion.joints.rate_rad_s);
        let [dd1, dd2] = motion.joints.acceleration_rad_s2;
        let (w, w_dot) = (motion.omega0_rad_s, motion.omega0_dot_rad_s2);
        let fixed = Vector2::from(self.position_m) - Vector2::from(base_to_joint_m) * ((m1 + m2) / mass);
        let mut acceleration = across(&fixed) * w_dot - fixed * (w * w);
        let links = [
            ((m1 * l1 + m2 * (l1 + com_to_next_m)) / mass, th1, w + d1, w_dot + dd1),
            (m2 * l2 / mass, th1 + th2, w + d1 + d2, w_dot + dd1 + dd2),
        ];
        for (arm_m, angle_rad, rate, rate_dot) in links {
            let (sine, cosine) = libm::sincos(angle_rad);
            let along = Vector2::new(cosine, sine) * -arm_m;
            acceleration += across(&along) * rate_dot - along * (rate * rate);
        }
        acceleration
    }
}

#[cfg(test)]
mod tests;
