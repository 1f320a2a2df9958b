//! Angular momentum of a planar base with a two-link arm, linear in eight (or nine) minimal
//! parameters.
//!
//! `Y_h α = h_cm` holds for the momentum about the centre of mass of the whole system, whatever the
//! joint torques do. With `w1 = w0 + d1`, `w2 = w1 + d2`:
//!
//! `Y_h = [w0, w1, w2, (2w0+d1)c1, (2w0+d1)s1, (2w0+d1+d2)c12, (2w0+d1+d2)s12, (2w0+2d1+d2)c2, (2w0+2d1+d2)s2]`
//!
//! The ninth column is needed when the centre of mass of link 2 lies off its axis (a grasped
//! target); with `α₉ = 0` the eight-parameter model is nested, so one generic `P` serves both. Any
//! other `P` does not compile.
//!
//! Channel order is **(w0, d1, d2, th1, th2)** everywhere in this crate. Swapped sigmas leave the
//! estimate looking fine and show only in NIS, see
//! `inertial_estimator::tests::swapped_channel_sigmas_are_caught_by_nis_only`.
//!
//! Frames: planar, rates about z of the inertial frame (base) and relative to the inboard body
//! (joints).

use estimation::weighted_least_squares::NoisyRow;
use libm::{hypot, sincos};
use nalgebra::{Matrix3, SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// Number of noisy channels of one sample.
pub const CHANNELS: usize = 5;

/// What gyro and joint encoders say at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MomentumSample {
    /// Inertial angular rate of the base about z [rad/s].
    pub omega0_z_rad_s: f64,
    pub joint_rate_rad_s: [f64; 2],
    pub joint_angle_rad: [f64; 2],
}

impl MomentumSample {
    /// Whether rates and angles are free of NaN and infinity.
    pub fn is_finite(&self) -> bool {
        let [a, b] = self.joint_rate_rad_s;
        let [c, d] = self.joint_angle_rad;
        [self.omega0_z_rad_s, a, b, c, d].iter().all(|value| value.is_finite())
    }
}

/// White standard deviation of each channel of a [`MomentumSample`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelSigma {
    pub omega0_rad_s: f64,
    pub joint_rate_rad_s: [f64; 2],
    pub joint_angle_rad: [f64; 2],
}

impl ChannelSigma {
    /// From data sheets: angle random walk of the gyro [°/√h] averaged over `interval_s`, joint
    /// sensors per sample.
    pub fn from_data_sheet(
        gyro_arw_deg_sqrt_h: f64,
        interval_s: f64,
        joint_rate_sigma_rad_s: f64,
        joint_angle_sigma_rad: f64,
    ) -> Self {
        const SQRT_HOUR_S: f64 = 60.0;
        let arw_rad_sqrt_s = gyro_arw_deg_sqrt_h * core::f64::consts::PI / 180.0 / SQRT_HOUR_S;
        Self {
            omega0_rad_s: arw_rad_sqrt_s / libm::sqrt(interval_s),
            joint_rate_rad_s: [joint_rate_sigma_rad_s; 2],
            joint_angle_rad: [joint_angle_sigma_rad; 2],
        }
    }

    /// In channel order (w0, d1, d2, th1, th2).
    pub fn in_channel_order(&self) -> [f64; CHANNELS] {
        let ([d1, d2], [th1, th2]) = (self.joint_rate_rad_s, self.joint_angle_rad);
        [self.omega0_rad_s, d1, d2, th1, th2]
    }
}

/// Of base and link 1, base and link 2, and both links: the sum of their rates, sine and cosine of
/// the angle between them.
fn pairs(sample: &MomentumSample) -> [(f64, f64, f64); 3] {
    let (w0, [d1, d2], [th1, th2]) = (sample.omega0_z_rad_s, sample.joint_rate_rad_s, sample.joint_angle_rad);
    let ((s1, c1), (s2, c2)) = (sincos(th1), sincos(th2));
    let (c12, s12) = (c1 * c2 - s1 * s2, s1 * c2 + c1 * s2);
    [(2.0 * w0 + d1, s1, c1), (2.0 * w0 + d1 + d2, s12, c12), (2.0 * w0 + 2.0 * d1 + d2, s2, c2)]
}

/// Row `Y_h` with `Y_h α = h_cm` (benchmark page 1, section 1.2).
pub fn momentum_regressor<const P: usize>(sample: &MomentumSample) -> SVector<f64, P> {
    const { assert!(P == 8 || P == 9) }
    let (w0, [d1, d2]) = (sample.omega0_z_rad_s, sample.joint_rate_rad_s);
    let [(u1, s1, c1), (u12, s12, c12), (u2, s2, c2)] = pairs(sample);
    let columns = [w0, w0 + d1, w0 + d1 + d2, u1 * c1, u1 * s1, u12 * c12, u12 * s12, u2 * c2, u2 * s2];
    SVector::from_fn(|i, _| columns[i])
}

/// Columns `∂Y_h/∂channel` in the order (w0, d1, d2, th1, th2).
pub fn channel_jacobian<const P: usize>(sample: &MomentumSample) -> SMatrix<f64, P, CHANNELS> {
    const { assert!(P == 8 || P == 9) }
    let [(u1, s1, c1), (u12, s12, c12), (u2, s2, c2)] = pairs(sample);
    let (x1, y1) = (-u1 * s1, u1 * c1);
    let (x12, y12) = (-u12 * s12, u12 * c12);
    let rows = [
        [1.0, 0.0, 0.0, 0.0, 0.0],
        [1.0, 1.0, 0.0, 0.0, 0.0],
        [1.0, 1.0, 1.0, 0.0, 0.0],
        [2.0 * c1, c1, 0.0, x1, 0.0],
        [2.0 * s1, s1, 0.0, y1, 0.0],
        [2.0 * c12, c12, c12, x12, x12],
        [2.0 * s12, s12, s12, y12, y12],
        [2.0 * c2, 2.0 * c2, c2, 0.0, -u2 * s2],
        [2.0 * s2, 2.0 * s2, s2, 0.0, u2 * c2],
    ];
    SMatrix::from_fn(|i, j| rows[i][j])
}

/// The row of a noisy sample, ready for `BiasCompensatedLeastSquares`; `h_nms` is exact for one
/// sample (its uncertainty is common to all and therefore belongs to the report, not to the row).
pub fn noisy_momentum_row<const P: usize>(
    sample: &MomentumSample,
    h_nms: f64,
    sigma: &[f64; CHANNELS],
) -> NoisyRow<P, CHANNELS> {
    let mut noise = channel_jacobian::<P>(sample);
    for (mut column, sigma) in noise.column_iter_mut().zip(sigma) {
        column *= *sigma;
    }
    NoisyRow { regressor: momentum_regressor(sample), observed: h_nms, observed_variance: 0.0, noise }
}

/// `h_cm = Y_h α` [N m s].
pub fn momentum<const P: usize>(alpha: &SVector<f64, P>, sample: &MomentumSample) -> f64 {
    momentum_regressor::<P>(sample).dot(alpha)
}

/// Inertia of base plus arm about z that the base rate sees, `∂h/∂w0` [kg m²].
pub fn locked_inertia_kg_m2<const P: usize>(alpha: &SVector<f64, P>, joint_angle_rad: [f64; 2]) -> f64 {
    momentum(alpha, &MomentumSample { omega0_z_rad_s: 1.0, joint_rate_rad_s: [0.0; 2], joint_angle_rad })
}

/// Base rate that momentum conservation demands: `w0 = (h − N α) / (D α)`, `N` the row at `w0 = 0`,
/// `D = ∂Y_h/∂w0`.
///
/// `None` when `D α ≤ 0`: such parameters have no positive inertia in this posture.
pub fn predict_base_rate<const P: usize>(
    alpha: &SVector<f64, P>,
    h_nms: f64,
    joint_angle_rad: [f64; 2],
    joint_rate_rad_s: [f64; 2],
) -> Option<f64> {
    let still = momentum(alpha, &MomentumSample { omega0_z_rad_s: 0.0, joint_rate_rad_s, joint_angle_rad });
    let inertia = locked_inertia_kg_m2(alpha, joint_angle_rad);
    (inertia > 0.0).then(|| (h_nms - still) / inertia)
}

/// Necessary for bodies of positive mass and inertia: the worst posture of the coupling matrix
/// stays positive definite, `P(α) = [[a1, |a45|, |a67|], [·, a2, |a89|], [·, ·, a3]] ≻ 0` (page 1,
/// section 7; sufficiency is not proven).
pub fn is_physically_consistent<const P: usize>(alpha: &SVector<f64, P>) -> bool {
    const { assert!(P == 8 || P == 9) }
    let ninth = if P == 9 { alpha[8] } else { 0.0 };
    let (b, c, f) = (hypot(alpha[3], alpha[4]), hypot(alpha[5], alpha[6]), hypot(alpha[7], ninth));
    Matrix3::new(alpha[0], b, c, b, alpha[1], f, c, f, alpha[2]).cholesky().is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;
    use libm::{cos, sin};

    fn random_sample(noise: &mut SeededNoise) -> MomentumSample {
        let mut draw = |scale: f64| scale * noise.normal();
        MomentumSample {
            omega0_z_rad_s: draw(0.3),
            joint_rate_rad_s: [draw(0.3), draw(0.3)],
            joint_angle_rad: [draw(2.0), draw(2.0)],
        }
    }

    /// Angular momentum about the system's centre of mass from positions and velocities of three
    /// point-like bodies with spin: no mass matrix, no minimal parameters. Link 2 carries its
    /// centre of mass at (l2x, l2y).
    fn momentum_from_bodies(arm: &crate::free_floating::PlanarArm, l2y_m: f64, sample: &MomentumSample) -> f64 {
        let [d1, d2] = sample.joint_rate_rad_s;
        let [th1, th2] = sample.joint_angle_rad;
        let th0 = 0.37; // any attitude: h does not depend on it
        let (p0, p1, p2) = (th0, th0 + th1, th0 + th1 + th2);
        let (w0, w1, w2) = {
            let w0 = sample.omega0_z_rad_s;
            (w0, w0 + d1, w0 + d1 + d2)
        };
        let turn = |v: [f64; 2], p: f64| [v[0] * cos(p) - v[1] * sin(p), v[0] * sin(p) + v[1] * cos(p)];
        let add = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        let cross_z = |w: f64, v: [f64; 2]| [-w * v[1], w * v[0]];
        let r0 = turn(arm.base_to_joint_m, p0);
        let (l1, e1) = (turn([arm.joint_to_com_m[0], 0.0], p1), turn([arm.com_to_next_m, 0.0], p1));
        let l2 = turn([arm.joint_to_com_m[1], l2y_m], p2);
        let x = [[0.0, 0.0], add(r0, l1), add(add(add(r0, l1), e1), l2)];
        let v1 = add(cross_z(w0, r0), cross_z(w1, l1));
        let v = [[0.0, 0.0], v1, add(add(v1, cross_z(w1, e1)), cross_z(w2, l2))];
        let total: f64 = arm.mass_kg.iter().sum();
        let mean = |a: &[[f64; 2]; 3], i: usize| (0..3).map(|b| arm.mass_kg[b] * a[b][i]).sum::<f64>() / total;
        let (xc, vc) = ([mean(&x, 0), mean(&x, 1)], [mean(&v, 0), mean(&v, 1)]);
        (0..3)
            .map(|b| {
                let (dx, dy) = (x[b][0] - xc[0], x[b][1] - xc[1]);
                let (ux, uy) = (v[b][0] - vc[0], v[b][1] - vc[1]);
                arm.inertia_com_kg_m2[b] * [w0, w1, w2][b] + arm.mass_kg[b] * (dx * uy - dy * ux)
            })
            .sum()
    }

    #[test]
    fn momentum_regressor_reproduces_the_momentum_of_the_bodies() {
        let mut noise = SeededNoise::new(1);
        // r0x ≠ r0y: with equal ones a swap of a4 and a5 would pass.
        let arm = crate::free_floating::PlanarArm { base_to_joint_m: [0.99, 0.40], ..Default::default() };
        let alpha = arm.minimal_parameters();
        for _ in 0..200 {
            let sample = random_sample(&mut noise);
            let terms = momentum_regressor::<8>(&sample).component_mul(&alpha);
            let error = terms.sum() - momentum_from_bodies(&arm, 0.0, &sample);
            assert!(error.abs() < 1e-13 * terms.abs().sum()); // rounding of the sum
        }
    }

    #[test]
    fn ninth_column_carries_a_centre_of_mass_off_the_axis() {
        let mut noise = SeededNoise::new(2);
        let arm = crate::free_floating::PlanarArm { base_to_joint_m: [0.99, 0.40], ..Default::default() };
        let alpha = crate::mated::minimal_parameters(&arm, [arm.joint_to_com_m[1], 0.31]);
        for _ in 0..200 {
            let sample = random_sample(&mut noise);
            let terms = momentum_regressor::<9>(&sample).component_mul(&alpha);
            let error = terms.sum() - momentum_from_bodies(&arm, 0.31, &sample);
            assert!(error.abs() < 1e-13 * terms.abs().sum());
        }
    }

    #[test]
    fn channel_jacobian_is_the_derivative_of_the_regressor() {
        let mut noise = SeededNoise::new(3);
        let step = 1e-5; // central difference: truncation 1e-10, rounding 1e-11
        for _ in 0..50 {
            let sample = random_sample(&mut noise);
            let jacobian = channel_jacobian::<9>(&sample);
            for channel in 0..CHANNELS {
                let moved = |sign: f64| {
                    let mut moved = sample;
                    match channel {
                        0 => moved.omega0_z_rad_s += sign * step,
                        1 | 2 => moved.joint_rate_rad_s[channel - 1] += sign * step,
                        _ => moved.joint_angle_rad[channel - 3] += sign * step,
                    }
                    momentum_regressor::<9>(&moved)
                };
                let difference = (moved(1.0) - moved(-1.0)) / (2.0 * step);
                assert!((difference - jacobian.column(channel)).norm() < 1e-8, "channel {channel}");
            }
        }
    }

    #[test]
    fn predicted_base_rate_restores_the_momentum() {
        let mut noise = SeededNoise::new(4);
        let alpha = crate::free_floating::PlanarArm::default().minimal_parameters();
        for _ in 0..50 {
            let mut sample = random_sample(&mut noise);
            sample.omega0_z_rad_s = predict_base_rate(&alpha, 68.0, sample.joint_angle_rad, sample.joint_rate_rad_s)
                .expect("true parameters");
            assert!((momentum(&alpha, &sample) - 68.0).abs() < 1e-11);
        }
    }

    #[test]
    fn truth_is_consistent_and_too_strong_a_coupling_is_not() {
        let mut alpha = crate::free_floating::PlanarArm::default().minimal_parameters();
        assert!(is_physically_consistent(&alpha));
        alpha[7] = 2.0 * (alpha[1] * alpha[2]).sqrt();
        assert!(!is_physically_consistent(&alpha));
    }
}
