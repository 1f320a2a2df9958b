//! Covariances of a stationary record from the pairs of samples that exist.
//!
//! With m = 1 where a sample exists and y = 0 where it does not,
//! `R_k = Σ_t y_t y_{t−k}ᵀ / Σ_t m_t m_{t−k}ᵀ` (division per lag and pair of channels) has the
//! expectation `E[y_t y_{t−k}ᵀ]` whatever is missing, as long as it is missing for reasons of its
//! own (Parzen 1963; Jones 1962). The record must be stationary: of a decay the covariances depend
//! on t, and those who want modes of it take windows without a break.
//!
//! A slower rate needs no filter over the gaps: the covariances of a record behind the half-band
//! filter h are `R'_k = Σ_n g_n R_{2k+n}`, `g_n = Σ_m h_m h_{m+n}`, so that the filter acts on the
//! lags.
//!
//! A channel that has no pair with itself at some lag (one that is updated every nth row) still has
//! pairs with the others at all lags: it takes part in the future and is no reference in the past
//! (Peeters & De Roeck 1999).
//!
//! Cost: 4 l² K N multiply-adds in matrix products, K = 955 lags for i = 40 and three halvings.

use std::ops::Range;

use faer::{Accum, Mat, MatRef, Par};

use crate::decimation::autocorrelation;
use crate::gram::Gram;

/// Numbers side by side in one column of the products: as many as fill the cache's panels.
const PANEL: usize = 192;
/// Pairs of a reference with itself at its rarest lag, as a part of the record: 1 % of missing
/// pairs leaves a hundred times the variance, more is a lag that does not exist.
const PAIRS_SHARE_MIN: f64 = 0.01;
/// Samples per block in units of the longest lag, so that neighbours are as good as independent.
const BLOCK_LAGS: usize = 1;
/// Blocks: the spread of eight is known to a factor of 1.5, that of 24 to 1.15.
const BLOCKS: (usize, usize) = (8, 24);

/// Lag covariances of a stretch, `R_k[a][b]` at `(k · l + a) · l + b`.
#[derive(Clone, Debug)]
pub(crate) struct Lags {
    channels: usize,
    values: Vec<f64>,
    /// Samples that the stretch is worth.
    pub(crate) samples: f64,
}

/// The record's covariances at one rate, whole and in blocks.
#[derive(Clone, Debug)]
pub struct PairCovariances {
    pub(crate) whole: Lags,
    pub(crate) blocks: Vec<Lags>,
    references: Vec<bool>,
}

/// Covariances of `samples` (NaN where none exists) at the full rate and at so many halvings of it;
/// fewer where the record is short.
#[must_use]
pub fn covariances(samples: &[f64], channels: usize, block_rows: usize, halvings: usize) -> Vec<PairCovariances> {
    let rows = samples.len() / channels;
    let halvings = (0..=halvings).rev().find(|h| 2 * lags_needed(block_rows, *h) <= rows).unwrap_or(0);
    let lags = lags_needed(block_rows, halvings);
    let sums = Sums::new(samples, channels, lags);
    let count = (rows / (BLOCK_LAGS * lags)).clamp(BLOCKS.0, BLOCKS.1);
    let length = (rows / count / sums.side).max(1) * sums.side;
    let mut whole = LagSums::zeros(channels, lags);
    let mut blocks: Vec<Vec<Lags>> = vec![Vec::new(); halvings + 1];
    for b in 0..count {
        let end = if b + 1 == count { rows } else { (b + 1) * length };
        let part = sums.over(b * length..end);
        whole.add(&part);
        for (rate, lags) in part.covariances().at_rates(block_rows, halvings).into_iter().enumerate() {
            blocks[rate].push(lags);
        }
    }
    let references = whole.references(rows);
    let wholes = whole.covariances().at_rates(block_rows, halvings);
    let with = |(whole, blocks)| PairCovariances { whole, blocks, references: references.clone() };
    wholes.into_iter().zip(blocks).map(with).collect()
}

/// Lags at the full rate for 2i lags after so many halvings.
fn lags_needed(block_rows: usize, halvings: usize) -> usize {
    (0..halvings).fold(2 * block_rows, |lags, _| 2 * (lags - 1) + autocorrelation().len() / 2 + 1)
}

/// Sums of products and numbers of pairs, `[k][a][b]`.
struct LagSums {
    channels: usize,
    products: Vec<f64>,
    pairs: Vec<f64>,
}

impl LagSums {
    fn zeros(channels: usize, lags: usize) -> Self {
        let empty = vec![0.0; lags * channels * channels];
        Self { channels, products: empty.clone(), pairs: empty }
    }

    fn add(&mut self, other: &Self) {
        self.products.iter_mut().zip(&other.products).for_each(|(a, b)| *a += b);
        self.pairs.iter_mut().zip(&other.pairs).for_each(|(a, b)| *a += b);
    }

    fn covariances(&self) -> Lags {
        let mean = |(product, pairs): (&f64, &f64)| if *pairs > 0.5 { product / pairs } else { 0.0 };
        let samples = self.pairs.iter().sum::<f64>() / self.pairs.len() as f64;
        let values = self.products.iter().zip(&self.pairs).map(mean).collect();
        Lags { channels: self.channels, values, samples }
    }

    /// Channels with pairs among themselves at every lag; the rarest leave first.
    fn references(&self, rows: usize) -> Vec<bool> {
        let (l, least) = (self.channels, PAIRS_SHARE_MIN * rows as f64);
        let rarest = |a: usize, b: usize| -> f64 {
            let at = |k: usize| self.pairs[k * l * l + a * l + b];
            (1..self.pairs.len() / (l * l)).map(at).fold(f64::INFINITY, f64::min)
        };
        let mut kept: Vec<bool> = (0..l).map(|a| rarest(a, a) >= least).collect();
        for a in 0..l {
            kept[a] = kept[a] && (0..a).all(|b| !kept[b] || rarest(a, b).min(rarest(b, a)) >= least);
        }
        kept
    }
}

/// The record as matrix products want it: zeros where nothing is, and masks.
struct Sums {
    channels: usize,
    lags: usize,
    /// Samples side by side in one column.
    side: usize,
    /// Rows of zeros in front, so that every lag reaches back.
    front: usize,
    values: Vec<f64>,
    masks: Vec<f64>,
}

impl Sums {
    fn new(samples: &[f64], channels: usize, lags: usize) -> Self {
        let side = (PANEL / channels).clamp(1, lags);
        let front = (steps(lags, side)) * side;
        let rows = samples.len() / channels;
        let length = (front + rows.next_multiple_of(side)) * channels;
        let (mut values, mut masks) = (vec![0.0; length], vec![0.0; length]);
        for (k, y) in samples.iter().enumerate().filter(|(_, y)| y.is_finite()) {
            values[front * channels + k] = *y;
            masks[front * channels + k] = 1.0;
        }
        Self { channels, lags, side, front, values, masks }
    }

    /// Sums over the pairs whose later sample lies in `rows` (a multiple of `side` from the start).
    fn over(&self, rows: Range<usize>) -> LagSums {
        let mut sums = LagSums::zeros(self.channels, self.lags);
        self.accumulate(&self.values, &rows, &mut sums.products);
        self.accumulate(&self.masks, &rows, &mut sums.pairs);
        sums
    }

    fn accumulate(&self, of: &[f64], rows: &Range<usize>, sums: &mut [f64]) {
        let (l, side) = (self.channels, self.side);
        let panel = side * l;
        let columns = rows.len().div_ceil(side);
        let start = (self.front + rows.start) * l;
        let mut product = Mat::<f64>::zeros(panel, panel);
        let view = |from: usize| MatRef::from_column_major_slice(&of[from..from + columns * panel], panel, columns);
        for j in 0..=steps(self.lags, side) {
            let (later, earlier) = (view(start), view(start - j * panel));
            faer::linalg::matmul::matmul(product.as_mut(), Accum::Replace, later, earlier.transpose(), 1.0, Par::Seq);
            for q in 0..side {
                for p in 0..side {
                    let Some(k) = (j * side + p).checked_sub(q).filter(|k| *k < self.lags) else { continue };
                    for b in 0..l {
                        for a in 0..l {
                            sums[(k * l + a) * l + b] += product[(p * l + a, q * l + b)];
                        }
                    }
                }
            }
        }
    }
}

/// Steps back of whole columns until no lag is left.
fn steps(lags: usize, side: usize) -> usize {
    (lags + side - 2) / side
}

impl Lags {
    fn lags(&self) -> usize {
        self.values.len() / (self.channels * self.channels)
    }

    fn at(&self, k: usize) -> &[f64] {
        let size = self.channels * self.channels;
        &self.values[k * size..(k + 1) * size]
    }

    /// `R_k[a][b]`, `R_{−k} = R_kᵀ`.
    fn element(&self, k: isize, a: usize, b: usize) -> f64 {
        let (a, b) = if k < 0 { (b, a) } else { (a, b) };
        self.at(k.unsigned_abs())[a * self.channels + b]
    }

    /// First 2i lags at this rate and at every half of it.
    fn at_rates(self, block_rows: usize, halvings: usize) -> Vec<Self> {
        let mut all = Vec::new();
        let mut at_this = self;
        for left in (0..=halvings).rev() {
            let slower = (left > 0).then(|| at_this.halved());
            at_this.values.truncate(2 * block_rows * at_this.channels * at_this.channels);
            all.push(at_this);
            match slower {
                Some(slower) => at_this = slower,
                None => break,
            }
        }
        all
    }

    /// Behind the half-band filter, every second lag.
    fn halved(&self) -> Self {
        let (l, taps) = (self.channels, autocorrelation());
        let reach = taps.len() / 2;
        let lags = (self.lags() - reach - 1) / 2 + 1;
        let mut values = Vec::with_capacity(lags * l * l);
        for k in 0..lags {
            for a in 0..l {
                for b in 0..l {
                    let lag = |n: usize| (2 * k + n) as isize - reach as isize;
                    values.push(taps.iter().enumerate().map(|(n, g)| g * self.element(lag(n), a, b)).sum());
                }
            }
        }
        Self { channels: l, values, samples: 0.5 * self.samples }
    }

    /// `Σ q[(p,a)] R_{i+p−n}[a][b] r[(n,b)]` times the samples: the future–past product of the
    /// stretch between two filters.
    pub(crate) fn bilinear(&self, q: &[faer::c64], r: &[faer::c64]) -> faer::c64 {
        let l = self.channels;
        let block_rows = r.len() / l;
        let zero = faer::c64::new(0.0, 0.0);
        // All that meets R_k: Σ_{i+p−n=k} q_p r_nᵀ.
        let mut sum = zero;
        let mut meets = vec![zero; l * l];
        for k in 1..2 * block_rows {
            meets.fill(zero);
            for p in 0..block_rows {
                let Some(n) = (block_rows + p).checked_sub(k).filter(|n| *n < block_rows) else { continue };
                for a in 0..l {
                    for b in 0..l {
                        meets[a * l + b] += q[p * l + a] * r[n * l + b];
                    }
                }
            }
            for (meet, value) in meets.iter().zip(self.at(k)) {
                sum += *meet * *value;
            }
        }
        sum * self.samples
    }
}

impl PairCovariances {
    /// The Gram matrix that a record with these covariances has.
    #[must_use]
    pub fn gram(&self) -> Gram {
        let (lags, l) = (&self.whole, self.whole.channels);
        let block_rows = lags.lags() / 2;
        let columns = (lags.samples as u64).saturating_sub(2 * block_rows as u64 - 1);
        let mut gram = Gram::zeros(l, block_rows);
        let size = 2 * block_rows * l;
        gram.matrix = Mat::from_fn(size, size, |row, column| {
            let k = (row / l) as isize - (column / l) as isize;
            columns as f64 * lags.element(k, row % l, column % l)
        });
        gram.columns = columns;
        gram.references.clone_from(&self.references);
        gram
    }

    /// Whether any channel can be a reference.
    #[must_use]
    pub fn has_reference(&self) -> bool {
        self.references.contains(&true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::Noise;

    #[test]
    fn covariances_are_means_over_the_pairs_that_exist_in_every_block() {
        let (l, rows, lags) = (3, 500, 90);
        let mut noise = Noise::new(1);
        let mut samples: Vec<f64> = (0..rows * l).map(|_| noise.normal()).collect();
        samples.iter_mut().for_each(|y| {
            if noise.uniform() < 0.2 {
                *y = f64::NAN;
            }
        });
        let sums = Sums::new(&samples, l, lags);
        for range in [0..sums.side * 2, sums.side * 2..rows] {
            let found = sums.over(range.clone()).covariances();
            for k in [0, 1, 17, 89] {
                for (a, b) in [(0, 0), (1, 2), (2, 1)] {
                    let pairs: Vec<f64> = range
                        .clone()
                        .filter(|t| *t >= k)
                        .map(|t| samples[t * l + a] * samples[(t - k) * l + b])
                        .filter(|product| product.is_finite())
                        .collect();
                    let mean = pairs.iter().sum::<f64>() / pairs.len() as f64;
                    assert!((found.element(k as isize, a, b) - mean).abs() < 1e-12, "{range:?} {k} {a} {b}");
                }
            }
        }
    }

    #[test]
    fn halved_covariances_are_those_of_the_filtered_record() {
        // White noise of unit variance has R_k = δ; behind the filter, R'_k = g_{2k}.
        let mut values = vec![0.0; 200];
        values[0] = 1.0;
        let halved = Lags { channels: 1, values, samples: 200.0 }.halved();
        let g = autocorrelation();
        for k in 0..30 {
            let expected = g.get(g.len() / 2 + 2 * k).copied().unwrap_or(0.0);
            assert!((halved.element(k as isize, 0, 0) - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn a_channel_updated_every_fourth_row_is_no_reference_and_the_others_are() {
        let mut noise = Noise::new(2);
        let rows = 2000;
        let sample = |t: usize, c: usize, y: f64| if c == 1 && !t.is_multiple_of(4) { f64::NAN } else { y };
        let samples: Vec<f64> = (0..rows * 3).map(|k| sample(k / 3, k % 3, noise.normal())).collect();
        let found = covariances(&samples, 3, 10, 0);
        assert_eq!(found[0].references, [true, false, true]);
    }
}
