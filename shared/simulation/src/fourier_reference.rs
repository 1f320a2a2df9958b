//! Periodic joint references: finite Fourier series in the joint rates, five harmonics.
//!
//! ```text
//! q_i(t) = q0_i + Σ_k [a_ik sin(k ω t) − b_ik cos(k ω t)] / (k ω),   ω = 2π / period,   k = 1..5
//! ```
//!
//! (Swevers et al., IEEE Trans. Robotics and Automation 13(5), 1997.) The coefficients are those of
//! the benchmark's optimised experiments: least geometric-mean parameter variance under limits of
//! joint angle, joint rate, base rate and torque.

use core::f64::consts::TAU;

/// Reference motion of two joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourierReference {
    pub q0_rad: [f64; 2],
    /// Cosine amplitudes of the joint rates, harmonics 1..5.
    pub a_rad_s: [[f64; 5]; 2],
    /// Sine amplitudes of the joint rates, harmonics 1..5.
    pub b_rad_s: [[f64; 5]; 2],
    pub period_s: f64,
}

/// Joint angles, rates and accelerations wanted at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointTarget {
    pub angle_rad: [f64; 2],
    pub rate_rad_s: [f64; 2],
    pub acceleration_rad_s2: [f64; 2],
}

impl FourierReference {
    /// Trajectory B, the primary experiment before capture: 30 s, |rate| ≤ 0.35 rad/s, |base rate|
    /// ≤ 0.40 rad/s,
    /// |torque| ≤ 20 Nm at h = 68 Nms.
    pub const fn trajectory_b() -> Self {
        Self {
            q0_rad: [0.8277, -1.8193],
            a_rad_s: [[-0.36, 0.0061, -0.0068, -0.0033, 0.0323], [-0.0128, -0.1301, -0.0935, 0.1354, -0.176]],
            b_rad_s: [[0.0042, 0.032, 0.0134, -0.0239, -0.0163], [-0.0972, -0.0953, 0.0463, 0.139, 0.065]],
            period_s: 30.0,
        }
    }

    /// Trajectory E1: 30 s, |rate| ≤ 0.40 rad/s, base rate free up to 0.75 rad/s.
    pub const fn trajectory_e1() -> Self {
        Self {
            q0_rad: [-1.7911, 0.5753],
            a_rad_s: [[0.1138, -0.3093, -0.0598, -0.0737, -0.0498], [0.0204, -0.0066, -0.0271, -0.0009, -0.0333]],
            b_rad_s: [[0.0759, -0.0631, -0.1023, -0.0026, -0.0163], [-0.4275, 0.0157, -0.0287, 0.0175, 0.0055]],
            period_s: 30.0,
        }
    }

    /// The experiment after capture: 60 s, designed for |rate| ≤ 0.15 rad/s and |base rate| ≤ 0.25
    /// rad/s by penalties; its joint rates peak at 0.154 rad/s.
    pub const fn mated() -> Self {
        Self {
            q0_rad: [-0.9671, -0.0507],
            a_rad_s: [[-0.019, 0.0298, -0.0152, 0.0309, -0.0086], [0.0398, -0.0012, 0.0267, 0.0004, 0.0117]],
            b_rad_s: [[-0.0177, -0.0002, 0.1353, 0.0158, 0.0037], [-0.1777, 0.0001, -0.0353, -0.0011, -0.0052]],
            period_s: 60.0,
        }
    }

    /// Where the joints should be at `t_s`.
    pub fn at(&self, t_s: f64) -> JointTarget {
        let omega = TAU / self.period_s;
        let mut target = JointTarget { angle_rad: self.q0_rad, rate_rad_s: [0.0; 2], acceleration_rad_s2: [0.0; 2] };
        for k in 0..5 {
            let omega_k = (k + 1) as f64 * omega;
            let (sin, cos) = libm::sincos(omega_k * t_s);
            for joint in 0..2 {
                let (a, b) = (self.a_rad_s[joint][k], self.b_rad_s[joint][k]);
                target.angle_rad[joint] += (a * sin - b * cos) / omega_k;
                target.rate_rad_s[joint] += a * cos + b * sin;
                target.acceleration_rad_s2[joint] += omega_k * (b * cos - a * sin);
            }
        }
        target
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [FourierReference; 3] =
        [FourierReference::trajectory_b(), FourierReference::trajectory_e1(), FourierReference::mated()];

    #[test]
    fn rates_and_accelerations_are_the_derivatives_of_the_angles() {
        let h = 1e-4;
        for reference in ALL {
            for step in 0..200 {
                let t = 0.3 * f64::from(step);
                let (before, at, after) = (reference.at(t - h), reference.at(t), reference.at(t + h));
                for j in 0..2 {
                    // central difference: truncation h²/6 · 1 rad/s³ = 2e-9, rounding ε/h = 2e-12
                    let rate = (after.angle_rad[j] - before.angle_rad[j]) / (2.0 * h);
                    let acceleration = (after.rate_rad_s[j] - before.rate_rad_s[j]) / (2.0 * h);
                    assert!((rate - at.rate_rad_s[j]).abs() < 1e-8);
                    assert!((acceleration - at.acceleration_rad_s2[j]).abs() < 1e-8);
                }
            }
        }
    }

    #[test]
    fn motion_repeats_after_one_period() {
        for reference in ALL {
            let (a, b) = (reference.at(1.7), reference.at(1.7 + reference.period_s));
            assert!((0..2).all(|j| (a.angle_rad[j] - b.angle_rad[j]).abs() < 1e-13));
        }
    }
}
