//! Is the estimator honest? NEES and NIS against their χ² bands, and whiteness at several time scales.
//!
//! A χ² over single samples misses small persistent errors: one tenth of a standard deviation, constant over 10⁴
//! samples, moves it by half a sigma of its own spread, but moves the mean of 100 samples by a whole one. Whiteness is
//! therefore tested on block means of 1, 10 and 100 samples.

use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// Normalised estimation error squared `e' P⁻¹ e`; `None` when `P` is not positive definite.
pub fn nees<const P: usize>(error: &SVector<f64, P>, covariance: &SMatrix<f64, P, P>) -> Option<f64> {
    Some(error.dot(&covariance.cholesky()?.solve(error)))
}

/// Quantile of the unit normal, Acklam's rational approximation: relative error below 1.2e-9 on (0, 1).
pub fn normal_quantile(probability: f64) -> f64 {
    assert!(probability > 0.0);
    assert!(probability < 1.0);
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
    if probability > 1.0 - TAIL {
        return -normal_quantile(1.0 - probability);
    }
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

/// Quantile of χ² with `degrees` of freedom: exact for one, Wilson and Hilferty's approximation for more.
///
/// Relative error for probabilities in [0.005, 0.9999]: below 3e-4 from 100 degrees on, below 3 % from 10 on. With
/// three degrees the upper tail (≥ 0.95) is within 2 %; the 5 % quantile is 7 % low.
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

/// Fewer degrees of freedom than this decide nothing: the approximation of the χ² tail fails below three.
pub const DEGREES_MIN: f64 = 3.0;

/// Two-sided band of a mean square of `degrees` unit normal numbers, left with probability `false_alarm`; `None` when
/// there are too few to say.
pub fn mean_square_band(degrees: f64, false_alarm: f64) -> Option<(f64, f64)> {
    let bound = |probability| chi_square_quantile(probability, degrees) / degrees;
    (degrees >= DEGREES_MIN).then(|| (bound(false_alarm / 2.0), bound(1.0 - false_alarm / 2.0)))
}

/// Upper limit of a z-score `(χ² − n)/√(2n)` of `degrees` = n, passed with probability `false_alarm`; `None` when there
/// are too few to say. The χ² itself is used, not its normal limit: with 60 degrees, 3.6 normal sigmas are passed by
/// honest data seven times too often.
pub fn z_score_limit(degrees: f64, false_alarm: f64) -> Option<f64> {
    (degrees >= DEGREES_MIN)
        .then(|| (chi_square_quantile(1.0 - false_alarm, degrees) - degrees) / libm::sqrt(2.0 * degrees))
}

/// Mean of a χ² statistic (NEES or NIS) with the band it should lie in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ChiSquareMean {
    sum: f64,
    count: u64,
    degrees: u64,
}

impl ChiSquareMean {
    /// Adds one value that should be χ² with `degrees` of freedom.
    pub fn push(&mut self, value: f64, degrees: u32) {
        self.sum += value;
        self.count += 1;
        self.degrees += u64::from(degrees);
    }

    pub fn count(&self) -> u64 {
        self.count
    }

    /// Sum over all degrees of freedom: one when the model and its covariance hold; `None` before the first value.
    pub fn per_degree(&self) -> Option<f64> {
        (self.degrees > 0).then(|| self.sum / self.degrees as f64)
    }

    /// Mean value; should equal the degrees of freedom of one value.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }

    /// Two-sided band of [`Self::per_degree`] that holds with `confidence` when the values are independent.
    pub fn band_per_degree(&self, confidence: f64) -> Option<(f64, f64)> {
        let degrees = self.degrees as f64;
        let tail = (1.0 - confidence) / 2.0;
        (self.degrees > 0)
            .then(|| (chi_square_quantile(tail, degrees) / degrees, chi_square_quantile(1.0 - tail, degrees) / degrees))
    }

    /// `(χ² − n) / √(2n)`: standard deviations away from the expected sum.
    pub fn z_score(&self) -> Option<f64> {
        let degrees = self.degrees as f64;
        (self.degrees > 0).then(|| (self.sum - degrees) / libm::sqrt(2.0 * degrees))
    }
}

/// Block lengths of [`Whiteness`], in samples.
pub const WHITENESS_SCALES: [u32; 3] = [1, 10, 100];

/// One scale of [`Whiteness`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct BlockMeans {
    partial_sum: f64,
    partial_count: u32,
    squares: ChiSquareMean,
}

/// What [`Whiteness`] found at one scale.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ScaleVerdict {
    pub block_samples: u32,
    pub blocks: u64,
    /// Mean of `(block mean / its predicted standard deviation)²`; one when white.
    pub mean_square: f64,
    /// `(χ² − n) / √(2n)`.
    pub z_score: f64,
}

/// Multi-scale test that normalised innovations are unit, independent and of zero mean. Fixed memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Whiteness {
    scales: [BlockMeans; WHITENESS_SCALES.len()],
    previous: Option<f64>,
    lag_one_sum: f64,
    square_sum: f64,
    lag_one_count: u64,
}

impl Whiteness {
    /// Takes one normalised innovation (innovation over its predicted standard deviation).
    pub fn push(&mut self, normalised: f64) {
        for (scale, samples) in self.scales.iter_mut().zip(WHITENESS_SCALES) {
            scale.partial_sum += normalised;
            scale.partial_count += 1;
            if scale.partial_count == samples {
                scale.squares.push(scale.partial_sum * scale.partial_sum / f64::from(samples), 1);
                scale.partial_sum = 0.0;
                scale.partial_count = 0;
            }
        }
        if let Some(previous) = self.previous {
            self.lag_one_sum += previous * normalised;
            self.lag_one_count += 1;
        }
        self.square_sum += normalised * normalised;
        self.previous = Some(normalised);
    }

    /// One verdict per scale of [`WHITENESS_SCALES`]; a scale without a complete block has `blocks = 0`.
    pub fn verdicts(&self) -> [ScaleVerdict; WHITENESS_SCALES.len()] {
        core::array::from_fn(|i| ScaleVerdict {
            block_samples: WHITENESS_SCALES[i],
            blocks: self.scales[i].squares.count(),
            mean_square: self.scales[i].squares.mean().unwrap_or(0.0),
            z_score: self.scales[i].squares.z_score().unwrap_or(0.0),
        })
    }

    /// Largest z-score over the scales.
    pub fn worst_z_score(&self) -> f64 {
        self.verdicts().iter().map(|verdict| verdict.z_score).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Autocorrelation at lag one; `None` before two samples. Its standard deviation is `1/√n` for white input.
    pub fn lag_one_autocorrelation(&self) -> Option<f64> {
        (self.lag_one_count > 0 && self.square_sum > 0.0).then(|| self.lag_one_sum / self.square_sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;

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
            // The bounds the function's doc promises.
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

    #[test]
    fn normal_quantile_inverts_the_error_function() {
        for p in [1e-6, 0.01, 0.3, 0.5, 0.9, 0.999] {
            let back = 0.5 * libm::erfc(-normal_quantile(p) / 2.0_f64.sqrt());
            assert!((back / p - 1.0).abs() < 1e-7, "{p}"); // Acklam's 1.2e-9 times the slope of the tail
        }
    }

    #[test]
    fn white_noise_stays_inside_its_band_at_every_scale() {
        // z of 3 scales × 100 seeds; a unit-variance z beyond 4.5 happens once in 10⁵ (χ² skew included).
        for seed in 0..100 {
            let (mut noise, mut white) = (SeededNoise::new(seed), Whiteness::default());
            for _ in 0..20_000 {
                white.push(noise.normal());
            }
            for verdict in white.verdicts() {
                assert!(verdict.z_score.abs() < 4.5, "seed {seed}: {verdict:?}");
            }
            assert!(white.lag_one_autocorrelation().expect("20 000 samples").abs() < 4.5 / 20_000.0_f64.sqrt());
        }
    }

    #[test]
    fn a_tenth_of_a_sigma_is_invisible_per_sample_and_evident_in_block_means() {
        let (mut noise, mut white) = (SeededNoise::new(1), Whiteness::default());
        for _ in 0..100_000 {
            white.push(noise.normal() + 0.1);
        }
        let [single, _, hundred] = white.verdicts();
        assert!(single.z_score < 5.0, "{single:?}"); // expected 0.01 · √(10⁵/2) = 2.2, spread 1
        assert!(hundred.z_score > 15.0, "{hundred:?}"); // expected 1 · √(10³/2) = 22, spread √3
    }

    #[test]
    fn alternating_innovations_are_caught_by_lag_one_only() {
        let mut white = Whiteness::default();
        for k in 0..1000 {
            white.push(if k % 2 == 0 { 1.0 } else { -1.0 });
        }
        assert!(white.lag_one_autocorrelation().expect("1000 samples") < -0.99);
        assert!(white.verdicts()[0].z_score.abs() < 1e-12);
    }
}
