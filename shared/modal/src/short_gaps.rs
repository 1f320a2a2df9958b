//! Gaps of a stationary record, filled from the samples beside them.
//!
//! Covariances from pairs carry a noise of the choice of pairs. Of a missing share p in gaps of
//! mean length L every lag has an error of variance `L p/(1 − p)/N` of the square of the channel's
//! power, another one at lags more than L apart, so that no motion of the structure explains it:
//! modes that are weaker than the others drown in it. Motion is known better from the samples on
//! both sides: `ŷ_t = r_tᵀ K⁻¹ y`, with K and r_t the covariances of the nearest samples that exist
//! with each other and with the missing one (Wiener; kriging). Its error is orthogonal to the
//! samples used, so that products of a predicted sample with one that exists have the right
//! expectation. Those of two predicted ones lack the covariance P of their errors. It is given back
//! by an error of that covariance: that of a gap of the same length elsewhere in the record, whose
//! samples exist and are predicted in the same way (conditioning by kriging; Journel & Huijbregts
//! 1978, ch. VII). Channels that lack the same samples take it from the same place, so that the
//! covariances between them are right, too, and with all of them the windows of the record,
//! whatever the error is.
//!
//! An error that is borrowed tells nothing new: with the share p missing and errors of the share e
//! of the power, the record is worth `1 − p e` of its length.
//!
//! A channel whose errors have its power, white noise to these samples, is left to the pairs.

use crate::maximum_likelihood::solve;
use crate::seeded::Seeded;
use faer::Mat;
use std::ops::Range;

/// Samples from which a gap of one is predicted, both sides together: at 0.4 of the rate, five
/// periods. One more for every sample of a longer gap.
const SAMPLES: usize = 16;
/// Distance up to which they are sought, in units of their number on one side: up to two of three
/// may be missing.
const REACH: usize = 3;
/// Longest gap filled: the windows of the covariances, 2i rows. A longer one is a break, at which
/// they lose no more than it holds.
const FILLED_ROWS_MAX: usize = 80;
/// Missing samples per existing one up to which gaps are exceptions: a channel that is updated
/// every other row has one, and what its samples cannot show would come back as images.
const ODDS_MAX: f64 = 0.5;
/// Least samples of a channel.
const PRESENT_MIN: usize = 400;
/// Mean square error of the gaps relative to the power of the channel from which nothing is
/// predicted: that of white noise, 1, known to a tenth from a hundred gaps.
const ERROR_SHARE_MAX: f64 = 0.9;
/// Places tried for a gap to borrow an error from: where stretches are as long as gaps, one of e
/// begins a whole gap, and (1 − 1/e)^40 is 1e-8.
const PLACES: usize = 40;
/// Added to the variance, in deviations of the matrix of covariances: `(n L p/(1 − p)/N)^½` of it
/// is the error that gaps of mean length L leave in one of n samples. Without it weights follow
/// that error.
const RIDGE_SIGMA: f64 = 2.0;

/// A record with its gaps filled.
pub(crate) struct Filled {
    pub values: Vec<f64>,
    /// Samples that were missing.
    pub count: usize,
    /// Part of the record that is not known for it.
    pub unknown: f64,
}

/// The samples (NaN where none exists) with gaps filled; `None` where none is worth it.
pub(crate) fn filled(values: &[f64], channels: usize) -> Option<Filled> {
    let mut all = Filled { values: values.to_vec(), count: 0, unknown: 0.0 };
    for c in 0..channels {
        let column: Vec<f64> = values.iter().skip(c).step_by(channels).copied().collect();
        let Some(of_channel) = of_channel(&column) else { continue };
        all.count += of_channel.samples.len();
        all.unknown += of_channel.error_share * of_channel.samples.len() as f64 / values.len() as f64;
        of_channel.samples.into_iter().for_each(|(t, y)| all.values[t * channels + c] = y);
    }
    (all.count > 0).then_some(all)
}

/// Samples of a channel that were missing.
struct OfChannel {
    /// Row and value.
    samples: Vec<(usize, f64)>,
    /// Mean square error of the predictions, relative to the power of the channel.
    error_share: f64,
}

fn of_channel(column: &[f64]) -> Option<OfChannel> {
    let present = column.iter().filter(|y| y.is_finite()).count();
    let missing = column.len() - present;
    if missing == 0 || present < PRESENT_MIN || missing as f64 > ODDS_MAX * present as f64 {
        return None;
    }
    let mean = column.iter().filter(|y| y.is_finite()).sum::<f64>() / present as f64;
    let predictor = Predictor::new(column.iter().map(|y| y - mean).collect(), missing as f64 / present as f64)?;
    let (mut samples, mut squares) = (Vec::new(), 0.0);
    for gap in predictor.gaps() {
        let Some((predicted, errors)) = predictor.predicted(&gap).zip(predictor.borrowed(&gap)) else { continue };
        squares += errors.iter().map(|e| e * e).sum::<f64>();
        samples.extend(gap.zip(predicted.iter().zip(&errors).map(|(y, e)| mean + y + e)));
    }
    let error_share = squares / (samples.len() as f64 * predictor.covariance[0]);
    (error_share < ERROR_SHARE_MAX).then_some(OfChannel { samples, error_share })
}

/// A channel without its mean, and its covariances.
struct Predictor {
    centred: Vec<f64>,
    covariance: Vec<f64>,
    /// Of the variance, per root of the number of samples used.
    ridge: f64,
}

impl Predictor {
    /// With so many samples missing per existing one; `None` for a flat channel.
    fn new(centred: Vec<f64>, odds: f64) -> Option<Self> {
        let mut predictor = Self { centred, covariance: Vec::new(), ridge: 0.0 };
        let gaps = predictor.gaps();
        let longest = gaps.iter().map(ExactSizeIterator::len).max()?;
        let mean_length = gaps.iter().map(ExactSizeIterator::len).sum::<usize>() as f64 / gaps.len() as f64;
        let lags = 2 * REACH * on_one_side(longest) + longest;
        predictor.covariance = covariances(&predictor.centred, lags);
        predictor.ridge = RIDGE_SIGMA * (mean_length * odds / predictor.centred.len() as f64).sqrt();
        (predictor.covariance[0] > 0.0).then_some(predictor)
    }

    /// Gaps that may be filled: between samples, and no longer than [`FILLED_ROWS_MAX`].
    fn gaps(&self) -> Vec<Range<usize>> {
        let rows = self.centred.len();
        let is_missing = |t: &usize| !self.centred[*t].is_finite();
        let begins = (1..rows).filter(|t| is_missing(t) && !is_missing(&(t - 1)));
        let gaps = begins.map(|begin| begin..(begin..rows).find(|t| !is_missing(t)).unwrap_or(rows));
        gaps.filter(|gap| gap.end < rows && gap.len() <= FILLED_ROWS_MAX).collect()
    }

    /// The samples of a gap from the nearest ones that exist on both sides.
    fn predicted(&self, gap: &Range<usize>) -> Option<Vec<f64>> {
        let count = on_one_side(gap.len());
        let reach = REACH * count;
        let exists = |t: &usize| self.centred[*t].is_finite();
        let before = (gap.start.saturating_sub(reach)..gap.start).rev().filter(exists).take(count);
        let after = (gap.end..self.centred.len().min(gap.end + reach)).filter(exists).take(count);
        let used: Vec<usize> = before.chain(after).collect();
        // At an end of the record those of one side do; anywhere else both have them.
        if used.len() < count {
            return None;
        }
        let lag = |a: usize, b: usize| self.covariance[a.abs_diff(b)];
        let variance = lag(0, 0) * (1.0 + self.ridge * (used.len() as f64).sqrt());
        let matrix = Mat::from_fn(used.len(), used.len(), |a, b| if a == b { variance } else { lag(used[a], used[b]) });
        let samples: Vec<f64> = used.iter().map(|t| self.centred[*t]).collect();
        let solved = solve(&matrix, &samples, 0.0)?;
        let at = |t: usize| used.iter().zip(&solved).map(|(of, x)| lag(*of, t) * x).sum();
        Some(gap.clone().map(at).collect())
    }

    /// Errors of the prediction of samples that exist, as many as in the gap, far from it.
    fn borrowed(&self, gap: &Range<usize>) -> Option<Vec<f64>> {
        let reach = REACH * on_one_side(gap.len());
        let room = self.centred.len().checked_sub(2 * reach + gap.len())?;
        // The same places for all channels with this gap.
        let mut random = Seeded::new(gap.start as u64);
        (0..PLACES).find_map(|_| {
            let start = reach + (random.uniform() * room as f64) as usize;
            let place = start..start + gap.len();
            let is_far = start.abs_diff(gap.start) > 2 * reach + gap.len();
            if !is_far || self.centred[place.clone()].iter().any(|y| !y.is_finite()) {
                return None;
            }
            let predicted = self.predicted(&place)?;
            Some(self.centred[place].iter().zip(predicted).map(|(y, predicted)| y - predicted).collect())
        })
    }
}

/// Samples used on either side of a gap.
fn on_one_side(length: usize) -> usize {
    (SAMPLES + length).div_ceil(2)
}

/// `R_k` over the pairs that exist.
fn covariances(centred: &[f64], lags: usize) -> Vec<f64> {
    let mask: Vec<f64> = centred.iter().map(|y| f64::from(u8::from(y.is_finite()))).collect();
    let values: Vec<f64> = centred.iter().map(|y| if y.is_finite() { *y } else { 0.0 }).collect();
    let sum = |of: &[f64], k: usize| of.iter().skip(k).zip(of).map(|(a, b)| a * b).sum::<f64>();
    (0..=lags).map(|k| sum(&values, k) / sum(&mask, k).max(1.0)).collect()
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
        let Filled { values: filled, count, unknown } = filled(&left, 1).unwrap();
        let missing = left.iter().filter(|y| !y.is_finite()).count();
        assert!(count > 9 * missing / 10, "{count} of {missing}");
        let power = whole.iter().map(|y| y * y).sum::<f64>() / whole.len() as f64;
        let errors = (0..whole.len()).filter(|t| !left[*t].is_finite() && filled[*t].is_finite());
        let error = errors.map(|t| (filled[t] - whole[t]).powi(2)).sum::<f64>() / count as f64;
        assert!(error < 0.05 * power, "{error} of {power}");
        assert!(unknown < 0.01, "{unknown}");
    }

    #[test]
    fn white_noise_is_not_filled() {
        let mut noise = Noise::new(6);
        let left: Vec<f64> =
            (0..6000).map(|_| if noise.uniform() > 0.15 { noise.normal() } else { f64::NAN }).collect();
        assert!(filled(&left, 1).is_none());
    }
}
