//! Whether a model with known input is right: its residuals are white, and nothing but the input
//! moves its modes.
//!
//! Two tests. That of Ljung & Box 1978 on the residuals' own correlations sees what is missing
//! anywhere in the band. The other is the score test of the innovations form at gain zero: each
//! mode is driven by the residuals themselves, weighted by its shape, and what that explains of
//! them is `2 Δ ln L ~ χ²(2 · modes · channels)` if no disturbance acts on the structure. The
//! response to one lies within the half-power width of a mode, where the first test with its few
//! lags is blind, and just there it makes the standard deviations of that mode too small.

use crate::maximum_likelihood::scan::explained_by;
use crate::maximum_likelihood::{Evaluation, Model, Outputs, driven};
use crate::projection::{Basis, dot};
use crate::record::Record;
use faer::c64;

/// Lags of the correlations.
const LAGS: usize = 20;
/// Probability that a right model is rejected: one record in a thousand, a tenth of the share of
/// invented modes that is acceptable.
const LEVEL: f64 = 1e-3;

/// What the residuals of a model say about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Neither test rejects the model: `p` is at least one in a thousand.
    pub white: bool,
    /// Correlation from one sample to the next, of the channel of which it is largest.
    pub lag1: f64,
    /// Ljung and Box's sum over channels, or the score of the modes: of the two the less probable.
    pub statistic: f64,
    /// Its degrees of freedom, hence its mean for a right model.
    pub degrees: f64,
    /// Probability of as much by chance: twice the smaller of both tests (Bonferroni).
    pub p: f64,
}

/// Tests the residuals of a model of `record` at its `poles`.
///
/// Cost: one least squares of the model, and 2 columns per mode beside it.
#[must_use]
pub(crate) fn examine(record: &Record, model: Model, outputs: &Outputs, poles: &[c64]) -> Residual {
    let at = Evaluation::new(record, model, outputs, poles);
    let spread: Vec<Vec<f64>> = at.residuals.iter().map(|residual| outputs.spread(residual)).collect();
    let serial = ljung_box(&spread, outputs);
    let score = through_modes(record, outputs, poles, &at, &spread);
    judged(&spread, [serial, score])
}

/// The verdict from statistics with their degrees of freedom.
pub(crate) fn judged<const TESTS: usize>(residuals: &[Vec<f64>], tests: [(f64, f64); TESTS]) -> Residual {
    let tail = |(statistic, degrees): (f64, f64)| chi_square_tail(statistic, degrees);
    let worst = tests.into_iter().min_by(|a, b| tail(*a).total_cmp(&tail(*b))).expect("a test");
    let p = (TESTS as f64 * tail(worst)).min(1.0);
    let of = |e: &Vec<f64>| dot(&e[1..], &e[..e.len() - 1]) / dot(e, e).max(f64::MIN_POSITIVE);
    let lag1 = residuals.iter().map(of).max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0);
    Residual { white: p >= LEVEL, lag1, statistic: worst.0, degrees: worst.1, p }
}

/// `Σ_channels Σ_lags r² n²/pairs`, r the correlation at a lag; χ² with lags × channels degrees for
/// white residuals. Absent rows are zeros and take no part in the pairs.
pub(crate) fn ljung_box(spread: &[Vec<f64>], outputs: &Outputs) -> (f64, f64) {
    let n = outputs.present.len() as f64;
    let there = outputs.spread(&vec![1.0; outputs.present.len()]);
    let lags = LAGS.min(outputs.samples.saturating_sub(1) / 4);
    let mut sum = 0.0;
    for lag in 1..=lags {
        let pairs = dot(&there[lag..], &there[..outputs.samples - lag]);
        for e in spread.iter().filter(|_| pairs > 0.0) {
            let r = dot(&e[lag..], &e[..e.len() - lag]) / dot(e, e).max(f64::MIN_POSITIVE);
            sum += r * r * n * n / pairs;
        }
    }
    (sum, (lags * spread.len()) as f64)
}

/// Twice the gain in log-likelihood if each mode is also driven by the residuals, weighted by its
/// shape.
fn through_modes(
    record: &Record,
    outputs: &Outputs,
    poles: &[c64],
    at: &Evaluation,
    spread: &[Vec<f64>],
) -> (f64, f64) {
    let mut columns = Vec::new();
    for (k, pole) in poles.iter().enumerate() {
        let shape = crate::maximum_likelihood::shape_of(at, k);
        let weights: Vec<f64> = shape.iter().zip(&at.squares).map(|(c, s)| c.re / s.max(f64::MIN_POSITIVE)).collect();
        let source = (0..outputs.samples).map(|t| spread.iter().zip(&weights).map(|(e, w)| w * e[t]).sum());
        for half in driven(record.sample_rate_hz, *pole, source).chunks_exact(outputs.samples) {
            columns.extend(outputs.present.iter().map(|t| half[*t]));
        }
    }
    // Beside the linear columns those of the poles: in a loop a wrong pole does much of what a
    // disturbance does.
    let fitted = [at.columns.linear.as_slice(), &at.columns.derivative].concat();
    let basis = Basis::new(fitted, at.columns.rows);
    (2.0 * explained_by(columns, &basis, at), (2 * poles.len() * spread.len()) as f64)
}

/// Degrees of freedom up to which the tail of χ² is summed; `e^(−χ²/2)` underflows far beyond them.
const SUMMED_DEGREES_MAX: f64 = 200.0;

/// Probability that χ² with a whole number of degrees of freedom exceeds a value: the finite sum
/// (Abramowitz & Stegun 1964, 26.4.4 and 26.4.5), beyond 200 degrees the cube root's normality
/// (Wilson & Hilferty 1931).
pub(crate) fn chi_square_tail(statistic: f64, degrees: f64) -> f64 {
    let half = 0.5 * statistic.max(0.0);
    if degrees > SUMMED_DEGREES_MAX {
        let spread = 2.0 / (9.0 * degrees);
        let z = (libm::cbrt(statistic / degrees) - (1.0 - spread)) / spread.sqrt();
        return 0.5 * libm::erfc(z * std::f64::consts::FRAC_1_SQRT_2);
    }
    let is_odd = degrees as usize % 2 == 1;
    // Terms x^k/Γ(k + 1), k whole or half, below half the degrees.
    let (mut k, mut term, mut sum) = match is_odd {
        true => (0.5, libm::exp(-half) * (half / std::f64::consts::FRAC_PI_4).sqrt(), libm::erfc(half.sqrt())),
        false => (0.0, libm::exp(-half), 0.0),
    };
    while k < 0.5 * degrees {
        sum += term;
        k += 1.0;
        term *= half / k;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_in_a_thousand_lies_beyond_the_quantiles_of_the_tables() {
        // Abramowitz & Stegun 1964, table 26.8.
        for (degrees, quantile) in [(1.0, 10.828), (4.0, 18.467), (5.0, 20.515), (20.0, 45.315), (100.0, 149.449)] {
            let p = chi_square_tail(quantile, degrees);
            assert!((p / 1e-3 - 1.0).abs() < 0.04, "{degrees}: {p}");
        }
    }
}
