//! Quantiles of the normal and the χ² law, and the bands and limits that follow from them.

use core::f64::consts::{FRAC_1_SQRT_2, PI};

/// Quantile of the unit normal: Acklam's rational approximation (1.2e-9) and one step of Halley's,
/// to rounding.
///
/// Both tails are equally exact, because the lower one is computed: small probabilities keep their
/// digits, those near one do not.
pub fn normal_quantile(probability: f64) -> f64 {
    assert!(probability > 0.0);
    assert!(probability < 1.0);
    if probability > 0.5 {
        return -normal_quantile(1.0 - probability);
    }
    let z = acklam(probability);
    // Below 1e-290 the density is not a normal number any more, and the step would be noise.
    if probability < 1e-290 {
        return z;
    }
    let error = 0.5 * libm::erfc(-z * FRAC_1_SQRT_2) - probability;
    let step = error * libm::sqrt(2.0 * PI) * libm::exp(0.5 * z * z);
    z - step / (1.0 + 0.5 * z * step)
}

/// Probability that a standard normal variable is at least `|z|` in magnitude.
pub fn normal_two_sided_tail(z: f64) -> f64 {
    libm::erfc(z.abs() * FRAC_1_SQRT_2)
}

/// Of a probability up to one half.
fn acklam(probability: f64) -> f64 {
    const A: [f64; 6] = [
        -3.969683028665376e1,
        2.209460984245205e2,
        -2.759285104469687e2,
        1.383_577_518_672_69e2,
        -3.066479806614716e1,
        2.506628277459239,
    ];
    const B: [f64; 5] =
        [-5.447609879822406e1, 1.615858368580409e2, -1.556989798598866e2, 6.680131188771972e1, -1.328068155288572e1];
    const C: [f64; 6] = [
        -7.784894002430293e-3,
        -3.223964580411365e-1,
        -2.400758277161838,
        -2.549732539343734,
        4.374664141464968,
        2.938163982698783,
    ];
    const D: [f64; 4] = [7.784695709041462e-3, 3.224671290700398e-1, 2.445134137142996, 3.754408661907416];
    const TAIL: f64 = 0.02425;
    if probability < TAIL {
        let q = libm::sqrt(-2.0 * libm::log(probability));
        return horner(&C, q) / (horner(&D, q) * q + 1.0);
    }
    let q = probability - 0.5;
    let r = q * q;
    horner(&A, r) * q / (horner(&B, r) * r + 1.0)
}

fn horner(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// Quantile of χ² with `degrees` of freedom: exact for one, Wilson and Hilferty's approximation for
/// more.
///
/// Bounds of the relative error, from so many degrees on, at the tails that flight requires:
///
/// | degrees | upper 1e-3 to 3.3e-4 | upper 1e-4 to 6e-9 | lower 5e-4 |
/// |---|---|---|---|
/// | 3 | 2.6 % | 11 % | 100 % |
/// | 10 | 0.9 % | 3.8 % | 9 % |
/// | 100 | 0.06 % | 0.27 % | 0.11 % |
/// | 1000 | 2.2e-5 | 1.2e-4 | 2.5e-5 |
///
/// There it errs outwards, upper quantiles high and lower ones low: consistent data are rejected no
/// more often than stated.
pub fn chi_square_quantile(probability: f64, degrees: f64) -> f64 {
    assert!(degrees > 0.0);
    if degrees == 1.0 {
        let z = normal_quantile((1.0 + probability) / 2.0);
        return z * z;
    }
    let v = 2.0 / (9.0 * degrees);
    let root = (1.0 - v + normal_quantile(probability) * libm::sqrt(v)).max(0.0);
    degrees * root * root * root
}

/// Least degrees of freedom of a decision: the approximation of the χ² tail fails below three.
pub const DEGREES_MIN: f64 = 3.0;

/// Two-sided band of a mean square of `degrees` standard normal variables, left with probability
/// `false_alarm`; `None` when there are too few to say.
pub fn mean_square_band(degrees: f64, false_alarm: f64) -> Option<(f64, f64)> {
    let bound = |probability| chi_square_quantile(probability, degrees) / degrees;
    (degrees >= DEGREES_MIN).then(|| (bound(false_alarm / 2.0), bound(1.0 - false_alarm / 2.0)))
}

/// Upper limit of a z-score `(χ² − n)/√(2n)` of `degrees` = n, passed with probability
/// `false_alarm`; `None` when there are too few to say. The χ² itself is used, not its normal
/// limit: with 60 degrees, 3.6 normal sigmas are passed by honest data seven times too often.
pub fn z_score_limit(degrees: f64, false_alarm: f64) -> Option<f64> {
    (degrees >= DEGREES_MIN)
        .then(|| (chi_square_quantile(1.0 - false_alarm, degrees) - degrees) / libm::sqrt(2.0 * degrees))
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    #[test]
    fn chi_square_quantiles_agree_with_printed_tables() {
        // (probability, degrees, table value to five digits)
        for (p, n, table) in [
            (0.95, 3.0, 7.8147),
            (0.05, 3.0, 0.35185),
            (0.999, 3.0, 16.266),
            (0.995, 10.0, 25.188),
            (0.005, 10.0, 2.1559),
            (0.975, 100.0, 129.561),
            (0.025, 100.0, 74.222),
            (0.9999, 1.0, 15.137),
        ] {
            let error = (chi_square_quantile(p, n) / table - 1.0).abs();
            // Of the approximation at these probabilities, nearer than the tails of its doc.
            let bound = match (n, p) {
                (100.0.., _) => 3e-4,
                (10.0.., _) => 0.03,
                (3.0.., 0.5..) => 0.02,
                (3.0.., _) => 0.07,
                _ => 1e-4, // table printed to five digits
            };
            assert!(error < bound, "p {p} n {n}: {error}");
        }
    }

    /// Degrees, and the doc's bounds there.
    const BOUNDS: [(f64, [f64; 3]); 4] = [
        (3.0, [2.6e-2, 1.1e-1, 1.0]),
        (10.0, [9e-3, 3.8e-2, 9e-2]),
        (100.0, [6e-4, 2.7e-3, 1.1e-3]),
        (1000.0, [2.2e-5, 1.2e-4, 2.5e-5]),
    ];

    /// Worst relative error, outwards positive, and the least, from `degrees` on.
    fn errors_outwards(degrees: f64, probabilities: &[f64]) -> [f64; 2] {
        let mut all = std::vec::Vec::new();
        for step in 0..40 {
            let n = (degrees * libm::pow(1e5 / degrees, f64::from(step) / 39.0)).round();
            let law = ChiSquared::new(n).unwrap();
            let outwards = |p: f64| (chi_square_quantile(p, n) / law.inverse_cdf(p) - 1.0) * (p - 0.5).signum();
            all.extend(probabilities.iter().map(|p| outwards(*p)));
        }
        [all.iter().copied().fold(f64::MIN, f64::max), all.iter().copied().fold(f64::MAX, f64::min)]
    }

    #[test]
    fn chi_square_quantiles_are_as_far_outwards_of_the_exact_ones_as_the_doc_says_and_never_inwards() {
        let near = [1e-3, 5e-4, 1e-3 / 2.0, 1e-3 / 3.0].map(|tail| 1.0 - tail);
        // a slosh scan of one grid point, and of as many as it can have
        let far = [1.0, 16.0, 256.0, 4096.0, 16384.0].map(|points| 1.0 - 1e-4 / points);
        for (degrees, bounds) in BOUNDS {
            for (probabilities, bound) in [&near[..], &far, &[5e-4]].into_iter().zip(bounds) {
                let [worst, least] = errors_outwards(degrees, probabilities);
                assert!(worst <= bound && worst > 0.8 * bound, "{degrees} {probabilities:?}: {worst}, doc {bound}");
                assert!(least > 0.0, "{degrees} {probabilities:?}: {least} inwards");
            }
        }
    }

    #[test]
    fn normal_quantile_inverts_the_error_function() {
        for p in [1e-6, 0.01, 0.3, 0.5, 0.9, 0.999] {
            let back = 0.5 * libm::erfc(-normal_quantile(p) / 2.0_f64.sqrt());
            assert!((back / p - 1.0).abs() < 1e-7, "{p}"); // Acklam's 1.2e-9 times the slope of the tail
        }
    }

    #[test]
    fn normal_quantile_inverts_the_error_function_to_rounding_in_both_tails() {
        for p in [1e-280, 1e-30, 1e-6, 0.01, 0.02425, 0.3, 0.5] {
            let z = normal_quantile(p);
            // rounding of z times the slope of ln p, which is -z in the tail
            let rounding = 8.0 * f64::EPSILON * (1.0 + z * z);
            assert!((normal_two_sided_tail(z) / (2.0 * p) - 1.0).abs() < rounding, "{p}");
        }
        assert_eq!(normal_quantile(0.975), -normal_quantile(1.0 - 0.975));
        assert!((normal_quantile(0.025) + 1.959_963_984_540_054).abs() < 1e-15); // printed tables
    }
}
