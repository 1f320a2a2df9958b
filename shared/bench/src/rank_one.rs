//! The constraint `a4 a7 = a5 a6` that the eight parameters of an arm with its masses on the axes
//! obey.
//!
//! Both pairs are parallel to `r0`, so eight numbers carry seven degrees of freedom. Imposed, the
//! constraint cuts the error of the least known of the four by 2.7 (trajectory B); violated in
//! sigmas, it names an off-axis link 2 or a joint-2 zero offset.

use estimation::weighted_least_squares::Estimate;
use physics::free_floating::Alpha;

/// The step below which the projection has settled, relative to the constraint's own size.
const PROJECTION_SETTLED: f64 = 1e-12;
const PROJECTION_STEPS_MAX: usize = 6;

/// The constrained maximum of the normal density `estimate`: `min |α − α°|²` in the metric of its
/// information, `a4 a7 = a5 a6`.
///
/// Gauss–Newton: `α ← α° − P g (g' P g)⁻¹ (c(α) + g'(α° − α))`, `g = ∂c/∂α`; the covariance loses
/// `P g g' P / (g' P g)` and becomes singular along g, as it must. `None` when the covariance
/// leaves the constraint without variance, or six steps did not settle.
pub fn constrain(estimate: &Estimate<8>) -> Option<Estimate<8>> {
    let (origin, covariance) = (estimate.alpha, estimate.covariance);
    let mut alpha = origin;
    for _ in 0..PROJECTION_STEPS_MAX {
        let gradient = Alpha::from([0.0, 0.0, 0.0, alpha[6], -alpha[5], -alpha[4], alpha[3], 0.0]);
        let across = covariance * gradient;
        let variance = gradient.dot(&across);
        if variance.is_nan() || variance <= 0.0 {
            return None;
        }
        let violation = alpha[3] * alpha[6] - alpha[4] * alpha[5] + gradient.dot(&(origin - alpha));
        let next = origin - across * (violation / variance);
        let moved = (next - alpha).norm();
        alpha = next;
        if moved <= PROJECTION_SETTLED * alpha.norm() {
            return Some(Estimate { alpha, covariance: covariance - across * across.transpose() / variance });
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;
    use crate::simulated_arm::benchmark_arm;
    use nalgebra::SMatrix;
    use physics::free_floating::{PlanarArm, rank_one_violation_sigmas};

    fn drawn(seed: u64) -> (Alpha, Estimate<8>) {
        let mut noise = SeededNoise::new(seed);
        let truth = PlanarArm { base_to_joint_m: [0.99, 0.40], ..benchmark_arm() }.minimal_parameters();
        let root = SMatrix::<f64, 8, 8>::from_fn(|_, _| 0.02 * noise.normal());
        let drawn = Alpha::from_fn(|_, _| noise.normal());
        (truth, Estimate { alpha: truth + root * drawn, covariance: root * root.transpose() })
    }

    #[test]
    fn the_projection_obeys_the_constraint_and_is_nearest_in_the_metric_of_the_information() {
        for seed in 0..20 {
            let (_, estimate) = drawn(seed);
            let found = constrain(&estimate).expect("variance");
            assert!((found.alpha[3] * found.alpha[6] - found.alpha[4] * found.alpha[5]).abs() < 1e-9);
            // Stationary: the step to the estimate lies along P g.
            let a = found.alpha;
            let across = estimate.covariance * Alpha::from([0.0, 0.0, 0.0, a[6], -a[5], -a[4], a[3], 0.0]);
            let step = estimate.alpha - a;
            let along = across * (step.dot(&across) / across.norm_squared());
            assert!((step - along).norm() < 1e-9 * (1e-9 + step.norm()) + 1e-11);
        }
    }

    #[test]
    fn error_over_the_covariance_has_seven_degrees_of_freedom() {
        let mut sum = 0.0;
        for seed in 0..400 {
            let (truth, estimate) = drawn(seed);
            let found = constrain(&estimate).expect("variance");
            let inverse = found.covariance.pseudo_inverse(1e-12).expect("settles");
            let error = found.alpha - truth;
            sum += error.dot(&(inverse * error)) / 400.0;
            let violated = rank_one_violation_sigmas(&found.alpha, &estimate.covariance).expect("variance");
            assert!(violated.abs() < 1e-6);
        }
        assert!((sum - 7.0).abs() < 4.0 * (14.0_f64 / 400.0).sqrt(), "{sum}");
    }
}
