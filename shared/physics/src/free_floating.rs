//! Free-floating base with a two-link planar arm: eight minimal parameters before capture, and the
//! equations of motion, which hold with the ninth parameter after capture too.
//!
//! Notation of Papadopoulos: `l_i` inboard joint to centre of mass of link i, `r_i` centre of mass
//! to the next joint, `r_0` base centre of mass to joint 1, `L1 = l1 + r1`, `s1 = m1 l1 + m2 L1`,
//! `M` total mass.
//!
//! The eight parameters carry one nonlinear constraint, `a4 a7 = a5 a6` (both pairs are parallel to
//! `r0`); the Jacobian from the physical numbers has rank seven. Violated, it names an off-axis
//! link 2 or a joint-2 zero offset.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use serde::{Deserialize, Serialize};

/// Minimal parameters before capture.
pub type Alpha = SVector<f64, 8>;

/// Physical numbers of base (0) and links (1, 2).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanarArm {
    pub mass_kg: [f64; 3],
    /// About each body's centre of mass, axis z.
    pub inertia_com_kg_m2: [f64; 3],
    /// Base centre of mass to joint 1, in the base frame.
    pub base_to_joint_m: [f64; 2],
    /// `l_1`, `l_2`: inboard joint to centre of mass, along the link.
    pub joint_to_com_m: [f64; 2],
    /// `r_1`: centre of mass of link 1 to joint 2.
    pub com_to_next_m: f64,
}

impl PlanarArm {
    /// `a1 … a8` of page 1, section 1.2.
    pub fn minimal_parameters(&self) -> Alpha {
        let nine = crate::mated::minimal_parameters(self, [self.joint_to_com_m[1], 0.0]);
        nine.fixed_rows::<8>(0).into_owned()
    }
}

/// Signed violation of `a4 a7 = a5 a6` in its own standard deviations.
///
/// `None` when the covariance leaves the constraint without variance.
pub fn rank_one_violation_sigmas(alpha: &Alpha, covariance: &SMatrix<f64, 8, 8>) -> Option<f64> {
    let violation = alpha[3] * alpha[6] - alpha[4] * alpha[5];
    let gradient = Alpha::from([0.0, 0.0, 0.0, alpha[6], -alpha[5], -alpha[4], alpha[3], 0.0]);
    let variance = gradient.dot(&(covariance * gradient));
    (variance > 0.0).then(|| violation / libm::sqrt(variance))
}

/// Mass matrix `H` (w0dot, th1dd, th2dd) and Coriolis vector `C` of `H q̈ + C = [0, τ1, τ2]` (page
/// 1, section 1.2), eight or nine parameters (`mated`).
///
/// The row of the base is the derivative of the momentum: see
/// `tests::base_row_is_the_derivative_of_the_momentum`. Frames: rates (w0, d1, d2) about z, the
/// base's inertial, the joints' relative; kg m², N m. Assumes no external force or torque.
pub fn dynamics<const P: usize>(
    alpha: &SVector<f64, P>,
    joint_angle_rad: [f64; 2],
    rates_rad_s: [f64; 3],
) -> (Matrix3<f64>, Vector3<f64>) {
    const { assert!(P == 8 || P == 9) }
    let (c1, s1) = (libm::cos(joint_angle_rad[0]), libm::sin(joint_angle_rad[0]));
    let (c2, s2) = (libm::cos(joint_angle_rad[1]), libm::sin(joint_angle_rad[1]));
    let (c12, s12) = (c1 * c2 - s1 * s2, s1 * c2 + c1 * s2);
    let [a1, a2, a3, a4, a5, a6, a7, a8, a9] = core::array::from_fn(|i| if i < P { alpha[i] } else { 0.0 });
    let (d01, d02, d12) = (a4 * c1 + a5 * s1, a6 * c12 + a7 * s12, a8 * c2 + a9 * s2);
    let (e01, e02, e12) = (-a4 * s1 + a5 * c1, -a6 * s12 + a7 * c12, -a8 * s2 + a9 * c2);
    let (h22, h12, h11) = (a3, a3 + d12, a2 + a3 + 2.0 * d12);
    let (h02, h01) = (a3 + d02 + d12, h11 + d01 + d02);
    let h00 = a1 + a2 + a3 + 2.0 * (d01 + d02 + d12);
    let (w0, w1) = (rates_rad_s[0], rates_rad_s[0] + rates_rad_s[1]);
    let w2 = w1 + rates_rad_s[2];
    let (k0, k1, k2) = (e01 * w1 * w1 + e02 * w2 * w2, -e01 * w0 * w0 + e12 * w2 * w2, -e02 * w0 * w0 - e12 * w1 * w1);
    let mass = Matrix3::new(h00, h01, h02, h01, h11, h12, h02, h12, h22);
    (mass, Vector3::new(k0 + k1 + k2, k1 + k2, k2))
}

/// Accelerations (w0dot, th1dd, th2dd) under joint torques; `None` when the parameters are not
/// physical.
pub fn accelerations<const P: usize>(
    alpha: &SVector<f64, P>,
    joint_angle_rad: [f64; 2],
    rates_rad_s: [f64; 3],
    torque_n_m: [f64; 2],
) -> Option<Vector3<f64>> {
    let (mass, coriolis) = dynamics(alpha, joint_angle_rad, rates_rad_s);
    Some(mass.cholesky()?.solve(&(Vector3::new(0.0, torque_n_m[0], torque_n_m[1]) - coriolis)))
}

#[cfg(test)]
impl Default for PlanarArm {
    /// The benchmark's arm, reading A of its table.
    fn default() -> Self {
        Self {
            mass_kg: [400.0, 12.1, 11.7],
            inertia_com_kg_m2: [66.67, 17.27, 14.10],
            base_to_joint_m: [0.99, 0.99],
            joint_to_com_m: [1.9, 1.73],
            com_to_next_m: 0.168,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::momentum::{MomentumSample, momentum};
    use crate::seeded_noise::SeededNoise;

    #[test]
    fn base_row_is_the_derivative_of_the_momentum() {
        let mut noise = SeededNoise::new(1);
        let arm = PlanarArm { base_to_joint_m: [0.99, 0.40], ..Default::default() };
        let alpha = crate::mated::minimal_parameters(&arm, [1.73, 0.8]); // a9 as large as a8 / 2
        for _ in 0..100 {
            let mut draw = |scale: f64| scale * noise.normal();
            let (th, w, b) =
                ([draw(2.0), draw(2.0)], [draw(0.3), draw(0.3), draw(0.3)], [draw(1.0), draw(1.0), draw(1.0)]);
            let (mass, coriolis) = dynamics(&alpha, th, w);
            let rate = (mass.row(0) * Vector3::from(b))[0] + coriolis[0];
            let at = |t: f64| {
                momentum(
                    &alpha,
                    &MomentumSample {
                        omega0_z_rad_s: w[0] + b[0] * t,
                        joint_rate_rad_s: [w[1] + b[1] * t, w[2] + b[2] * t],
                        joint_angle_rad: [th[0] + w[1] * t, th[1] + w[2] * t],
                    },
                )
            };
            let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((rate - difference).abs() < 1e-6, "{rate} {difference}"); // 1e-10 truncation × 10³, rounding 1e-8
        }
    }

    #[test]
    fn energy_is_conserved_without_torque() {
        let alpha = PlanarArm::default().minimal_parameters();
        let energy = |th: [f64; 2], w: Vector3<f64>| 0.5 * w.dot(&(dynamics(&alpha, th, w.into()).0 * w));
        let rate = |x: &SVector<f64, 5>| {
            let a = accelerations(&alpha, [x[0], x[1]], [x[2], x[3], x[4]], [0.0; 2]).expect("physical");
            SVector::<f64, 5>::from([x[3], x[4], a[0], a[1], a[2]])
        };
        let mut x = SVector::<f64, 5>::from([0.4, -1.1, 0.2, 0.3, -0.5]);
        let start = energy([x[0], x[1]], Vector3::new(x[2], x[3], x[4]));
        for _ in 0..1000 {
            let h = 0.01;
            let k1 = rate(&x);
            let k2 = rate(&(x + k1 * (h / 2.0)));
            let k3 = rate(&(x + k2 * (h / 2.0)));
            let k4 = rate(&(x + k3 * h));
            x += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
        }
        let end = energy([x[0], x[1]], Vector3::new(x[2], x[3], x[4]));
        assert!((end / start - 1.0).abs() < 1e-8, "{}", end / start - 1.0); // RK4 truncation h⁴
    }

    #[test]
    fn benchmark_parameters_equal_the_printed_ones() {
        let printed = [110.7028, 105.7339, 48.1502, 44.0904, 44.0904, 18.9133, 18.9133, 39.6048];
        let alpha = PlanarArm::default().minimal_parameters();
        for (value, print) in alpha.iter().zip(printed) {
            assert!((value - print).abs() < 1e-3, "{alpha}");
        }
    }

    #[test]
    fn rank_one_constraint_holds_for_every_arm_with_its_mass_on_the_axis() {
        let mut noise = SeededNoise::new(2);
        for _ in 0..50 {
            let arm = PlanarArm { base_to_joint_m: [noise.normal(), noise.normal()], ..Default::default() };
            let alpha = arm.minimal_parameters();
            assert!(rank_one_violation_sigmas(&alpha, &SMatrix::identity()).expect("variance").abs() < 1e-13);
        }
    }
}
