//! Short gaps of a stationary record, filled from the samples beside them.
//!
//! With samples missing at random, covariances from pairs carry a noise of their own: to every lag
//! a missing share p adds the error of white noise of `p/(1 − p)` of the channel's power, however
//! little the sensor has. Motion that is sampled fast enough is known better than that from the
//! samples on both sides: `ŷ_t = r K⁻¹ y`, with K and r the covariances of the nearest samples that
//! exist with each other and with the missing one (Wiener; kriging). The error is orthogonal to the
//! samples used, so that the covariances of the filled record keep their expectation, but for what
//! lies beyond them.
//!
//! How good that is the record says itself: samples that exist are predicted in gaps of the same
//! length. An error of the share e of the power leaves a noise of `p e` in place of `p/(1 − p)`; a
//! length is filled where that is a tenth.

use crate::maximum_likelihood::solve;
use faer::Mat;

/// Nearest samples that exist from which one is predicted: at 0.4 of the rate, five periods.
const SAMPLES: usize = 16;
/// Longest distance of a sample used.
const REACH: usize = 40;
/// Longest gap filled.
const SHORT_GAP_MAX: usize = 8;
/// Missing samples per existing one up to which gaps are exceptions: a channel that is updated
/// every other row has one, and what its samples cannot show would come back as images.
const ODDS_MAX: f64 = 0.5;
/// Samples predicted to see the error of a gap of one length: it is known to a tenth.
const TRIALS: usize = 200;
/// Mean square error of a filled gap, relative to the power of the channel.
const ERROR_SHARE_MAX: f64 = 0.1;
/// Added to the variance, in deviations of the matrix of covariances: `(SAMPLES p/(1 − p)/N)^½` of
/// it is the error that the missing share p leaves in it. Without it weights follow that error.
const RIDGE_SIGMA: f64 = 2.0;

/// The samples with short gaps filled, and how many were; `None` where none is worth it.
pub(crate) fn filled(values: &[f64], channels: usize) -> Option<(Vec<f64>, usize)> {
    let mut all = values.to_vec();
    let mut count = 0;
    for c in 0..channels {
        let mut column: Vec<f64> = values.iter().skip(c).step_by(channels).copied().collect();
        let here = fill(&mut column);
        if here > 0 {
            column.iter().enumerate().for_each(|(t, y)| all[t * channels + c] = *y);
            count += here;
        }
    }
    (count > 0).then_some((all, count))
}

/// Fills a channel; how many samples.
fn fill(column: &mut [f64]) -> usize {
    let present = column.iter().filter(|y| y.is_finite()).count();
    let missing = column.len() - present;
    if missing == 0 || present < 10 * REACH || missing as f64 > ODDS_MAX * present as f64 {
        return 0;
    }
    let mean = column.iter().filter(|y| y.is_finite()).sum::<f64>() / present as f64;
    let centred: Vec<f64> = column.iter().map(|y| y - mean).collect();
    let mut covariance = covariances(&centred);
    if covariance[0] <= 0.0 {
        return 0;
    }
    let odds = missing as f64 / present as f64;
    let allowed = ERROR_SHARE_MAX * covariance[0];
    covariance[0] *= 1.0 + RIDGE_SIGMA * (SAMPLES as f64 * odds / column.len() as f64).sqrt();
    let worth: Vec<bool> = (1..=SHORT_GAP_MAX).map(|length| error(&centred, &covariance, length) < allowed).collect();
    let mut filled = 0;
    let mut start = 0;
    while start < column.len() {
        let length = centred[start..].iter().take_while(|y| !y.is_finite()).count();
        if length > 0 && length <= SHORT_GAP_MAX && worth[length - 1] && start > 0 && start + length < column.len() {
            for (t, y) in column.iter_mut().enumerate().skip(start).take(length) {
                if let Some(predicted) = predict(&centred, &covariance, t, t..t) {
                    *y = mean + predicted;
                    filled += 1;
                }
            }
        }
        start += length.max(1);
    }
    filled
}

/// `R_k` over the pairs that exist.
fn covariances(centred: &[f64]) -> Vec<f64> {
    let at = |k: usize| {
        let pairs = centred.iter().skip(k).zip(centred).map(|(a, b)| a * b).filter(|product| product.is_finite());
        let (n, sum) = pairs.fold((0.0, 0.0), |(n, sum), product| (n + 1.0, sum + product));
        if n > 0.0 { sum / n } else { 0.0 }
    };
    (0..=2 * REACH).map(at).collect()
}

/// Mean square error of samples that exist when they lie in a gap of this length.
fn error(centred: &[f64], covariance: &[f64], length: usize) -> f64 {
    let step = (centred.len() / TRIALS).max(1);
    let (mut sum, mut count) = (0.0, 0.0);
    for (trial, t) in (REACH..centred.len() - REACH).step_by(step).enumerate() {
        let begin = t - trial % length;
        if !centred[t].is_finite() {
            continue;
        }
        if let Some(predicted) = predict(centred, covariance, t, begin..begin + length) {
            sum += (predicted - centred[t]) * (predicted - centred[t]);
            count += 1.0;
        }
    }
    if count > 0.0 { sum / count } else { f64::INFINITY }
}

/// Sample `t` from the nearest ones that exist outside `hidden`.
fn predict(centred: &[f64], covariance: &[f64], t: usize, hidden: std::ops::Range<usize>) -> Option<f64> {
    let mut used: Vec<usize> = Vec::with_capacity(SAMPLES);
    for distance in 1..=REACH {
        for at in [t.checked_sub(distance), Some(t + distance)].into_iter().flatten() {
            if used.len() < SAMPLES && !hidden.contains(&at) && centred.get(at).is_some_and(|y| y.is_finite()) {
                used.push(at);
            }
        }
    }
    let both_sides = used.iter().any(|at| *at < t) && used.iter().any(|at| *at > t);
    if used.len() < SAMPLES || !both_sides {
        return None;
    }
    let lag = |a: usize, b: usize| covariance[a.abs_diff(b)];
    let matrix = Mat::from_fn(SAMPLES, SAMPLES, |a, b| lag(used[a], used[b]));
    let right: Vec<f64> = used.iter().map(|at| lag(*at, t)).collect();
    let weights = solve(&matrix, &right, 0.0)?;
    let explained: f64 = weights.iter().zip(&right).map(|(w, r)| w * r).sum();
    if explained > covariance[0] {
        return None;
    }
    Some(weights.iter().zip(&used).map(|(w, at)| w * centred[*at]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::Noise;

    /// A mode at 0.1 of the rate with 2 % of noise, and what is left of it.
    fn record(kept: impl Fn(usize, &mut Noise) -> bool) -> (Vec<f64>, Vec<f64>) {
        let mut noise = Noise::new(5);
        let (mut newer, mut older) = (0.0, 0.0);
        let whole: Vec<f64> = (0..6000)
            .map(|_| {
                (newer, older) =
                    (1.98 * libm::cos(0.2 * std::f64::consts::PI) * newer - 0.9801 * older + noise.normal(), newer);
                newer + 0.1 * noise.normal()
            })
            .collect();
        let left = (0..whole.len()).map(|t| if kept(t, &mut noise) { whole[t] } else { f64::NAN }).collect();
        (whole, left)
    }

    #[test]
    fn samples_missing_at_random_are_known_from_those_beside_them() {
        let (whole, left) = record(|_, noise| noise.uniform() > 0.15);
        let (filled, count) = filled(&left, 1).unwrap();
        let missing = left.iter().filter(|y| !y.is_finite()).count();
        assert!(count > 9 * missing / 10, "{count} of {missing}");
        let power = whole.iter().map(|y| y * y).sum::<f64>() / whole.len() as f64;
        let errors = (0..whole.len()).filter(|t| !left[*t].is_finite() && filled[*t].is_finite());
        let error = errors.map(|t| (filled[t] - whole[t]).powi(2)).sum::<f64>() / count as f64;
        assert!(error < 0.05 * power, "{error} of {power}");
    }

    #[test]
    fn white_noise_is_not_filled() {
        let mut noise = Noise::new(6);
        let left: Vec<f64> =
            (0..6000).map(|_| if noise.uniform() > 0.15 { noise.normal() } else { f64::NAN }).collect();
        assert!(filled(&left, 1).is_none());
    }
}
