//! What the hub-free modes say of the parts: modes with the hub held fast, and the inertia about
//! the hub's axis.
//!
//! Four numbers are measured (frequency and damping of two hub-free modes). An appendage whose
//! couplings and ratio of locked frequencies are those of its geometry has four unknowns (one
//! stiffness for both locked frequencies, two damping ratios, the inertia), so the map is solved by
//! Newton and the covariance carried through its slope. The size of the excitation is no part of
//! it: torque, momentum and scale of the sensors may be wrong by any factor.
//!
//! A body that floats is the same with its translation eliminated: inertia and couplings about its
//! centre of mass, and the modes with the rotation alone held fast.

use super::{Appendage, Mode};
use nalgebra::{Matrix4, Vector4};

const PARTS_ITERATIONS_MAX: usize = 30;
/// Measured modes farther than this from the nominal ones, relative, are others.
const SAME_MODE: f64 = 0.3;

/// Frequency of the first locked mode, locked damping ratios, inertia of hub and undeformed
/// appendage.
pub type Parts = Vector4<f64>;

impl Appendage {
    /// The same geometry with other parts.
    pub fn with_parts(&self, parts: &Parts) -> Self {
        let mut appendage = *self;
        let stiffer = parts[0] / self.locked[0].frequency_hz;
        for (mode, zeta) in appendage.locked.iter_mut().zip([parts[1], parts[2]]) {
            mode.frequency_hz *= stiffer;
            mode.damping_ratio = zeta;
        }
        appendage.inertia_kg_m2 = parts[3];
        appendage
    }

    /// f1, zeta1, f2, zeta2 with the hub free.
    fn free(&self, parts: &Parts) -> Option<Vector4<f64>> {
        let [a, b] = self.with_parts(parts).hub_free_modes()?;
        Some(Vector4::new(a.frequency_hz, a.damping_ratio, b.frequency_hz, b.damping_ratio))
    }

    fn slope(&self, parts: &Parts) -> Option<Matrix4<f64>> {
        let mut slope = Matrix4::zeros();
        for k in 0..4 {
            let step = 1e-5 * parts[k];
            let mut moved = [*parts, *parts];
            moved[0][k] += step;
            moved[1][k] -= step;
            slope.set_column(k, &((self.free(&moved[0])? - self.free(&moved[1])?) / (2.0 * step)));
        }
        Some(slope)
    }

    /// The parts that have the hub-free modes `f1, zeta1, f2, zeta2`, and their covariance: Newton
    /// from the nominal ones.
    ///
    /// `None` where no inertia carries such modes, or Newton does not settle in 30 steps. Cost: 9
    /// closed forms a step.
    pub fn parts(&self, modes: &Vector4<f64>, covariance: &Matrix4<f64>) -> Option<(Parts, Matrix4<f64>)> {
        let [a, b] = self.locked;
        let mut parts = Vector4::new(a.frequency_hz, a.damping_ratio, b.damping_ratio, self.inertia_kg_m2);
        for _ in 0..PARTS_ITERATIONS_MAX {
            let inverse = self.slope(&parts)?.try_inverse()?;
            let step = inverse * (modes - self.free(&parts)?);
            parts += step;
            // the next step would be its square
            if step.component_div(&parts).amax() < 1e-10 {
                return Some((parts, inverse * covariance * inverse.transpose()));
            }
        }
        None
    }

    /// Inertia about the axis and its standard deviation, from any number of measured modes with
    /// the covariance of each pair `[[ff, fz], [fz, zz]]`: those nearest to the nominal hub-free
    /// ones are taken.
    ///
    /// The modes depend on coupling over root inertia alone, so couplings known to a common
    /// relative sigma `s` add `2 s J` to it. `None` where a mode of the two was not found within 30
    /// %, or the parts have no solution.
    pub fn inertia(&self, measured: &[(Mode, [[f64; 2]; 2])], coupling_relative_sd: f64) -> Option<(f64, f64)> {
        let nominal = self.hub_free_modes()?;
        let (mut modes, mut covariance) = (Vector4::zeros(), Matrix4::zeros());
        let mut taken = [usize::MAX; 2];
        for (k, expected) in nominal.iter().enumerate() {
            let apart = |mode: &Mode| (mode.frequency_hz / expected.frequency_hz - 1.0).abs();
            let nearest = measured.iter().enumerate().min_by(|a, b| apart(&a.1.0).total_cmp(&apart(&b.1.0)));
            let (index, (mode, pair)) = nearest.filter(|(_, (mode, _))| apart(mode) < SAME_MODE)?;
            taken[k] = index;
            (modes[2 * k], modes[2 * k + 1]) = (mode.frequency_hz, mode.damping_ratio);
            for (r, row) in pair.iter().enumerate() {
                for (c, value) in row.iter().enumerate() {
                    covariance[(2 * k + r, 2 * k + c)] = *value;
                }
            }
        }
        if taken[0] == taken[1] {
            return None;
        }
        let (parts, covariance) = self.parts(&modes, &covariance)?;
        let variance = covariance[(3, 3)];
        let of_coupling = 2.0 * coupling_relative_sd * parts[3];
        let sigma = libm::sqrt(variance + of_coupling * of_coupling);
        (parts[3] > 0.0 && sigma > 0.0 && sigma.is_finite()).then_some((parts[3], sigma))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::BEAM as NOMINAL;
    use super::*;

    #[test]
    fn the_parts_come_back_from_the_modes_of_the_whole() {
        let truth = Vector4::new(1.07, 0.011, 0.004, 150.0);
        let modes = NOMINAL.free(&truth).expect("a heavy hub");
        let found = NOMINAL.parts(&modes, &Matrix4::identity()).expect("it settles").0;
        assert!((found - truth).component_div(&truth).amax() < 1e-9, "{found} {truth}"); // Newton ends within 1e-10
    }

    #[test]
    fn the_inertia_is_that_of_the_two_nominal_modes_among_others_and_none_without_them() {
        let truth = Vector4::new(1.01, 0.005, 0.008, 170.0);
        let [a, b] = NOMINAL.with_parts(&truth).hub_free_modes().expect("a heavy hub");
        let pair = [[1e-10, 0.0], [0.0, 1e-10]];
        let other = Mode { frequency_hz: 17.0, damping_ratio: 0.01 };
        let (inertia, sigma) = NOMINAL.inertia(&[(a, pair), (b, pair), (other, pair)], 0.0).expect("both are there");
        assert!((inertia - 170.0).abs() < 1e-6 && sigma > 0.0 && sigma < 0.1, "{inertia} {sigma}");
        assert_eq!(NOMINAL.inertia(&[(a, pair), (other, pair)], 0.0), None);
        assert_eq!(NOMINAL.inertia(&[(a, pair)], 0.0), None);
    }

    #[test]
    fn couplings_that_are_wrong_by_their_sigma_move_the_inertia_by_what_is_added_for_them() {
        let [a, b] = NOMINAL.hub_free_modes().expect("a heavy hub");
        let pair = [[0.0; 2]; 2];
        let wrong = Appendage { coupling: NOMINAL.coupling.map(|c| 1.01 * c), ..NOMINAL };
        let (inertia, sigma) = wrong.inertia(&[(a, pair), (b, pair)], 0.01).expect("both are there");
        // J goes with the coupling's square: 2.01 % against the 2 % of the first order.
        assert!((inertia - 1.0201 * NOMINAL.inertia_kg_m2).abs() < 1e-6, "{inertia}");
        assert!((sigma / (0.02 * inertia) - 1.0).abs() < 1e-9, "{sigma}");
    }
}
