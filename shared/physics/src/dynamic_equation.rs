//! Dynamic equation of a free-floating base with two links, linear in the eight (or nine) minimal
//! parameters: `Y_τ α = [0, τ1, τ2]`.
//!
//! The rows for torques alone have rank seven: `a1` stands in the base's row only. Dropping that
//! row because "its right-hand side is zero anyway" makes the problem singular, see
//! `tests::without_the_row_of_the_base_a1_is_lost`.
//!
//! Frames: planar, base rate about z of inertial space, joints relative to the inboard body. Units:
//! rad, N m, kg m². Assumes no external force or torque.

use crate::momentum::MomentumSample;
use libm::sincos;
use nalgebra::{SMatrix, Vector3};
use serde::{Deserialize, Serialize};

/// What gyro, joint encoders and torque sensors say in one control period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ArmSample {
    /// At the beginning of the period.
    pub motion: MomentumSample,
    /// Held through the period.
    pub torque_n_m: [f64; 2],
}

impl ArmSample {
    /// Whether motion and torques are free of NaN and infinity.
    pub fn is_finite(&self) -> bool {
        self.motion.is_finite() && self.torque_n_m.iter().all(|value| value.is_finite())
    }
}

/// Angles, rates and accelerations of base and arm at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ArmMotion {
    pub joint_angle_rad: [f64; 2],
    /// (w0, d1, d2).
    pub rates_rad_s: [f64; 3],
    /// (w0dot, th1dd, th2dd).
    pub accelerations_rad_s2: [f64; 3],
}

/// `Y_τ` (3 × P) with `Y_τ α = [0, τ1, τ2]`; rows `(E0 + E1 + E2; E1 + E2; E2)` (page 1, section
/// 1.2).
///
/// With `b1 = w0dot + th1dd`, `b2 = b1 + th2dd`, `w1 = w0 + d1`, `w2 = w1 + d2`, each pair of
/// bodies i < j brings two columns: `D_ij = p cos φ + q sin φ` puts `D_ij b_j + D_ij' w_j²` into
/// row `E_i` and `D_ij b_i − D_ij' w_i²` into row `E_j`. The ninth (`P = 9`, after capture) is the
/// sine of the pair (1, 2).
pub fn torque_regressor<const P: usize>(motion: &ArmMotion) -> SMatrix<f64, 3, P> {
    const { assert!(P == 8 || P == 9) }
    let ([th1, th2], [w0, d1, d2], [b0, dd1, dd2]) =
        (motion.joint_angle_rad, motion.rates_rad_s, motion.accelerations_rad_s2);
    let ((s1, c1), (s2, c2)) = (sincos(th1), sincos(th2));
    let (c12, s12) = (c1 * c2 - s1 * s2, s1 * c2 + c1 * s2);
    let (w1, b1) = (w0 + d1, b0 + dd1);
    let (w2, b2) = (w1 + d2, b1 + dd2);
    // Squares of the rates.
    let (q0, q1, q2) = (w0 * w0, w1 * w1, w2 * w2);
    let columns = [
        [b0, 0.0, 0.0],
        [0.0, b1, 0.0],
        [0.0, 0.0, b2],
        [c1 * b1 - s1 * q1, c1 * b0 + s1 * q0, 0.0],
        [s1 * b1 + c1 * q1, s1 * b0 - c1 * q0, 0.0],
        [c12 * b2 - s12 * q2, 0.0, c12 * b0 + s12 * q0],
        [s12 * b2 + c12 * q2, 0.0, s12 * b0 - c12 * q0],
        [0.0, c2 * b2 - s2 * q2, c2 * b1 + s2 * q1],
        [0.0, s2 * b2 + c2 * q2, s2 * b1 - c2 * q1],
    ];
    SMatrix::from_fn(|row, column| columns[column][row..].iter().sum())
}

/// `Y_τ α` [N m]: what base and joints must be given for this motion; the first number is zero when
/// nothing external acts.
pub fn efforts<const P: usize>(alpha: &nalgebra::SVector<f64, P>, motion: &ArmMotion) -> Vector3<f64> {
    torque_regressor::<P>(motion) * alpha
}

/// The dynamic equation in integrable form, `[0, τ1, τ2] = d/dt(momentum α) − gradient α`: no
/// acceleration is needed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagrangeForm<const P: usize> {
    /// `∂T/∂(w0, d1, d2)`; the first row is the momentum regressor.
    pub momentum: SMatrix<f64, 3, P>,
    /// `∂T/∂(th0, th1, th2)`; the first row is zero, for the kinetic energy does not depend on the
    /// attitude.
    pub gradient: SMatrix<f64, 3, P>,
}

/// Lagrange's form of [`torque_regressor`] from angles and rates alone.
///
/// With `T = ½ w' D w` in absolute rates and `D_ij` as there: body i brings `D_ij w_j` to the
/// momentum, the pair (i, j) `D_ij' w_i w_j` to the gradient of every joint between the two.
pub fn lagrange_form<const P: usize>(sample: &MomentumSample) -> LagrangeForm<P> {
    const { assert!(P == 8 || P == 9) }
    let (w0, [d1, d2], [th1, th2]) = (sample.omega0_z_rad_s, sample.joint_rate_rad_s, sample.joint_angle_rad);
    let ((s1, c1), (s2, c2)) = (sincos(th1), sincos(th2));
    let (c12, s12) = (c1 * c2 - s1 * s2, s1 * c2 + c1 * s2);
    let (w1, w2) = (w0 + d1, w0 + d1 + d2);
    let bodies = [
        [w0, 0.0, 0.0],
        [0.0, w1, 0.0],
        [0.0, 0.0, w2],
        [c1 * w1, c1 * w0, 0.0],
        [s1 * w1, s1 * w0, 0.0],
        [c12 * w2, 0.0, c12 * w0],
        [s12 * w2, 0.0, s12 * w0],
        [0.0, c2 * w2, c2 * w1],
        [0.0, s2 * w2, s2 * w1],
    ];
    let (q01, q02, q12) = (w0 * w1, w0 * w2, w1 * w2);
    let pairs = [
        [0.0; 2],
        [0.0; 2],
        [0.0; 2],
        [-s1 * q01, 0.0],
        [c1 * q01, 0.0],
        [-s12 * q02; 2],
        [c12 * q02; 2],
        [0.0, -s2 * q12],
        [0.0, c2 * q12],
    ];
    LagrangeForm {
        momentum: SMatrix::from_fn(|row, column| bodies[column][row..].iter().sum()),
        gradient: SMatrix::from_fn(|row, column| if row == 0 { 0.0 } else { pairs[column][row - 1] }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_floating::{PlanarArm, accelerations, dynamics};
    use crate::mated::minimal_parameters;
    use crate::momentum::{MomentumSample, momentum_regressor};
    use crate::seeded_noise::SeededNoise;

    fn random_motion(noise: &mut SeededNoise) -> ArmMotion {
        let mut draw = |scale: f64| scale * noise.normal();
        ArmMotion {
            joint_angle_rad: [draw(2.0), draw(2.0)],
            rates_rad_s: [draw(1.0), draw(1.0), draw(1.0)],
            accelerations_rad_s2: [draw(1.0), draw(1.0), draw(1.0)],
        }
    }

    fn skewed() -> PlanarArm {
        PlanarArm { base_to_joint_m: [0.99, 0.40], ..Default::default() }
    }

    #[test]
    fn torque_regressor_times_parameters_is_mass_matrix_times_acceleration_and_coriolis() {
        let mut noise = SeededNoise::new(11);
        let nine = minimal_parameters(&skewed(), [1.73, 0.9]);
        for _ in 0..500 {
            let motion = random_motion(&mut noise);
            let (mass, coriolis) = dynamics(&nine, motion.joint_angle_rad, motion.rates_rad_s);
            let acceleration = Vector3::from(motion.accelerations_rad_s2);
            let regressor = torque_regressor::<9>(&motion);
            let scale = regressor.abs() * nine.abs(); // a sum near zero keeps the rounding of its terms
            let error = regressor * nine - (mass * acceleration + coriolis);
            assert!((0..3).all(|row| error[row].abs() < 1e-14 * scale[row]), "{error} {scale}");
        }
    }

    #[test]
    fn eight_columns_are_the_first_of_nine() {
        let mut noise = SeededNoise::new(12);
        let motion = random_motion(&mut noise);
        let (eight, nine) = (torque_regressor::<8>(&motion), torque_regressor::<9>(&motion));
        assert_eq!(eight, nine.fixed_columns::<8>(0).into_owned());
    }

    /// `d/dt Y_h` by central differences along the motion: the base's row without any mass matrix.
    #[test]
    fn row_of_the_base_is_the_derivative_of_the_momentum_regressor() {
        let mut noise = SeededNoise::new(13);
        for _ in 0..100 {
            let motion = random_motion(&mut noise);
            let ([th1, th2], [w0, d1, d2], [b0, dd1, dd2]) =
                (motion.joint_angle_rad, motion.rates_rad_s, motion.accelerations_rad_s2);
            let at = |t: f64| {
                momentum_regressor::<9>(&MomentumSample {
                    omega0_z_rad_s: w0 + b0 * t,
                    joint_rate_rad_s: [d1 + dd1 * t, d2 + dd2 * t],
                    joint_angle_rad: [th1 + t * (d1 + 0.5 * t * dd1), th2 + t * (d2 + 0.5 * t * dd2)],
                })
            };
            let step = 1e-4; // fourth order: truncation 1e-16 × fifth derivative 1e3, rounding 1e-16/1e-4
            let slope = ((at(step) - at(-step)) * 8.0 - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step);
            let row = torque_regressor::<9>(&motion).row(0).transpose();
            assert!((slope - row).amax() < 1e-9, "{}", (slope - row).amax());
        }
    }

    #[test]
    fn lagrange_form_differentiated_is_the_torque_regressor() {
        let mut noise = SeededNoise::new(16);
        for _ in 0..100 {
            let motion = random_motion(&mut noise);
            let ([th1, th2], [w0, d1, d2], [b0, dd1, dd2]) =
                (motion.joint_angle_rad, motion.rates_rad_s, motion.accelerations_rad_s2);
            let at = |t: f64| {
                lagrange_form::<9>(&MomentumSample {
                    omega0_z_rad_s: w0 + b0 * t,
                    joint_rate_rad_s: [d1 + dd1 * t, d2 + dd2 * t],
                    joint_angle_rad: [th1 + t * (d1 + 0.5 * t * dd1), th2 + t * (d2 + 0.5 * t * dd2)],
                })
            };
            let step = 1e-4; // as above
            let slope = ((at(step).momentum - at(-step).momentum) * 8.0
                - (at(2.0 * step).momentum - at(-2.0 * step).momentum))
                / (12.0 * step);
            let error = slope - at(0.0).gradient - torque_regressor::<9>(&motion);
            assert!(error.amax() < 1e-9, "{}", error.amax());
        }
    }

    #[test]
    fn torques_put_into_the_equations_of_motion_come_out_of_the_regressor() {
        let mut noise = SeededNoise::new(14);
        let nine = minimal_parameters(&skewed(), [1.73, 0.9]);
        for _ in 0..100 {
            let mut motion = random_motion(&mut noise);
            let torque = [20.0 * noise.normal(), 20.0 * noise.normal()];
            let found = accelerations(&nine, motion.joint_angle_rad, motion.rates_rad_s, torque).expect("physical");
            motion.accelerations_rad_s2 = found.into();
            let scale = (torque_regressor::<9>(&motion).abs() * nine.abs()).max();
            let error = efforts(&nine, &motion) - Vector3::new(0.0, torque[0], torque[1]);
            assert!(error.amax() < 1e-12 * scale, "{error}"); // rounding × condition of the mass matrix, 1e2
        }
    }

    #[test]
    fn without_the_row_of_the_base_a1_is_lost() {
        let mut noise = SeededNoise::new(15);
        let (mut all, mut joints) = (SMatrix::<f64, 8, 8>::zeros(), SMatrix::<f64, 8, 8>::zeros());
        for _ in 0..200 {
            let rows = torque_regressor::<8>(&random_motion(&mut noise));
            all += rows.transpose() * rows;
            joints += rows.fixed_rows::<2>(1).transpose() * rows.fixed_rows::<2>(1);
        }
        let rank = |gram: &SMatrix<f64, 8, 8>| {
            gram.symmetric_eigenvalues().iter().filter(|x| **x > 1e-9 * gram.trace()).count()
        };
        assert_eq!((rank(&all), rank(&joints)), (8, 7));
        assert_eq!(joints.column(0).amax(), 0.0);
    }
}
