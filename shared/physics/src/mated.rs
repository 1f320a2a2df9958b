//! Base, two-link arm and a rigid target on link 2: nine minimal parameters.
//!
//! A rigid grasp makes link 2 and the target one body whose centre of mass `l2' = (lx, ly)` lies
//! off the link's axis; the ninth column of the momentum regressor carries `ly`. Without a target
//! `α₉ = 0`, so its t-value is the automatic "mated, or off axis?" test. After capture `h` is not
//! the chaser's `h`: the target brings its own.

use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

use crate::free_floating::PlanarArm;

/// Minimal parameters after capture.
pub type MatedAlpha = SVector<f64, 9>;

/// A rigid target held at the tip of link 2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    pub mass_kg: f64,
    /// About the target's centre of mass, axis z.
    pub inertia_com_kg_m2: f64,
    /// Grasp point to the target's centre of mass, in the frame of link 2.
    pub grasp_to_com_m: [f64; 2],
}

/// `a1 … a9` of an arm whose link 2 has its centre of mass at `joint2_to_com_m` (page 1, sections
/// 1.2 and 6).
pub fn minimal_parameters(arm: &PlanarArm, joint2_to_com_m: [f64; 2]) -> MatedAlpha {
    let [m0, m1, m2] = arm.mass_kg;
    let [i0, i1, i2] = arm.inertia_com_kg_m2;
    let [r0x, r0y] = arm.base_to_joint_m;
    let (l1, r1) = (arm.joint_to_com_m[0], arm.com_to_next_m);
    let [lx, ly] = joint2_to_com_m;
    let (m, big_l1) = (m0 + m1 + m2, l1 + r1);
    let s1 = m1 * l1 + m2 * big_l1;
    let k = m0 * m2 / m;
    let big_k = m2 * (m0 * big_l1 + m1 * r1) / m;
    SVector::from([
        i0 + m0 * (m1 + m2) / m * (r0x * r0x + r0y * r0y),
        i1 + m1 * l1 * l1 + m2 * big_l1 * big_l1 - s1 * s1 / m,
        i2 + m2 * (m0 + m1) / m * (lx * lx + ly * ly),
        m0 * s1 / m * r0x,
        m0 * s1 / m * r0y,
        k * (r0x * lx + r0y * ly),
        k * (r0y * lx - r0x * ly),
        big_k * lx,
        -big_k * ly,
    ])
}

/// The nine parameters of chaser and target; `grasp_m` is joint 2 to the grasp point, along link 2
/// (`l2 + r2`).
pub fn mated_parameters(arm: &PlanarArm, grasp_m: f64, target: &Target) -> MatedAlpha {
    let (m2, mt) = (arm.mass_kg[2], target.mass_kg);
    let (l2, mass) = (arm.joint_to_com_m[1], m2 + mt);
    let com_t = [grasp_m + target.grasp_to_com_m[0], target.grasp_to_com_m[1]];
    let com = [(m2 * l2 + mt * com_t[0]) / mass, mt * com_t[1] / mass];
    let square = |x: f64, y: f64| (x - com[0]) * (x - com[0]) + (y - com[1]) * (y - com[1]);
    let mut joined = *arm;
    joined.mass_kg[2] = mass;
    joined.inertia_com_kg_m2[2] += m2 * square(l2, 0.0) + target.inertia_com_kg_m2 + mt * square(com_t[0], com_t[1]);
    minimal_parameters(&joined, com)
}

/// Beyond so many sigmas of `α₉` the centre of mass of link 2 is off its axis: a target is held, or
/// joint 2 has a zero offset.
pub const OFF_AXIS_SIGMAS: f64 = 5.0;

/// `α₉` in its own standard deviations; `None` when it has none. Beyond [`OFF_AXIS_SIGMAS`]: mated
/// (or off axis, which the momentum cannot tell apart before capture).
pub fn off_axis_sigmas(alpha: &MatedAlpha, covariance: &SMatrix<f64, 9, 9>) -> Option<f64> {
    let variance = covariance[(8, 8)];
    (variance > 0.0).then(|| alpha[8] / libm::sqrt(variance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn example_target_gives_the_printed_parameters() {
        let target = Target { mass_kg: 150.0, inertia_com_kg_m2: 40.0, grasp_to_com_m: [0.60, 0.15] };
        let printed = [304.162, 529.887, 755.776, 246.645, 246.645, 288.091, 257.035, 570.753, -32.516];
        let alpha = mated_parameters(&PlanarArm::default(), 1.898, &target);
        for (value, print) in alpha.iter().zip(printed) {
            assert!((value - print).abs() < 1e-2, "{alpha}");
        }
    }

    #[test]
    fn a_target_of_no_mass_changes_nothing() {
        let arm = PlanarArm::default();
        let target = Target { mass_kg: 0.0, inertia_com_kg_m2: 0.0, grasp_to_com_m: [0.6, 0.15] };
        let (with, without) = (mated_parameters(&arm, 1.898, &target), arm.minimal_parameters());
        assert!((with.fixed_rows::<8>(0) - without).norm() < 1e-12);
        assert_eq!(with[8], 0.0);
    }
}
