//! Products of the Gram matrix of one stretch of samples without the matrix.
//!
//! `G = Σ_t Y_t Y_tᵀ` over the Nc = N − 2i + 1 columns `Y_t = [y_t; …; y_{t+2i−1}]` of N samples.
//! Over all t, with zeros where there is no sample, its blocks would be
//! `Σ_t y_{t+p} y_{t+q}ᵀ = R_{p−q}`: constant along the diagonals, so that one column of lag sums
//! holds every block column as a window. The columns that reach beyond the ends follow from the
//! first and last samples and are taken out again.
//!
//! Cost of a product with n vectors: 2 (il)² n operations, and 4il numbers of memory per channel
//! instead of (2il)².

use faer::{Accum, Mat, MatRef, Par};
use serde::{Deserialize, Serialize};

/// Sums over samples without a break.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Stretch {
    pub(crate) samples: u64,
    /// `R_k[a][b]` at `a · 2il + k · l + b`.
    pub(crate) lag_sums: Vec<f64>,
    /// First 2i samples in order of time.
    pub(crate) head: Vec<f64>,
    /// Last 3i samples, newest first.
    pub(crate) tail: Vec<f64>,
}

impl Stretch {
    fn channels(&self) -> usize {
        self.lag_sums.len() / self.head.len()
    }

    fn block_rows(&self) -> usize {
        self.head.len() / (2 * self.channels())
    }

    /// Columns of the block-Hankel matrix, of which there are some.
    pub(crate) fn columns(&self) -> u64 {
        self.samples + 1 - 2 * self.block_rows() as u64
    }

    /// The same with every sample `weight^(1/2)` times as large.
    pub(crate) fn weighted(&self, weight: f64) -> Self {
        let by = |values: &[f64], factor: f64| values.iter().map(|y| factor * y).collect();
        Self {
            samples: self.samples,
            lag_sums: by(&self.lag_sums, weight),
            head: by(&self.head, weight.sqrt()),
            tail: by(&self.tail, weight.sqrt()),
        }
    }

    /// i block rows of G from block row `from` on, i at most, times `x` (il × n) over its first i
    /// block columns: of the past by the past (0), or of the future by the past (i).
    pub(crate) fn product(&self, from: usize, x: MatRef<'_, f64>) -> Mat<f64> {
        let (l, i) = (self.channels(), self.block_rows());
        let lags = Mat::from_fn((2 * i - 1) * l, l, |row, b| {
            self.lag((from + row / l) as isize - (i as isize - 1), row % l, b)
        });
        let mut product = Mat::<f64>::zeros(i * l, x.ncols());
        for q in 0..i {
            let window = lags.submatrix((i - 1 - q) * l, 0, i * l, l);
            let x = x.submatrix(q * l, 0, l, x.ncols());
            faer::linalg::matmul::matmul(product.as_mut(), Accum::Add, window, x, 1.0, Par::Seq);
        }
        product - self.beyond(from) * (self.beyond(0).transpose() * x)
    }

    /// Sum of the diagonal of the past by the past.
    pub(crate) fn past_power(&self) -> f64 {
        let power: f64 = (0..self.channels()).map(|a| self.lag(0, a, a)).sum();
        self.block_rows() as f64 * power - self.beyond(0).squared_norm_l2()
    }

    /// `Σ_t y_t[a] y_{t−k}[b]`.
    fn lag(&self, k: isize, a: usize, b: usize) -> f64 {
        let (a, b) = if k < 0 { (b, a) } else { (a, b) };
        self.lag_sums[a * self.head.len() + k.unsigned_abs() * self.channels() + b]
    }

    /// Block rows `from … from + i` of the columns that reach beyond the first or the last sample.
    fn beyond(&self, from: usize) -> Mat<f64> {
        let (l, i) = (self.channels(), self.block_rows());
        let columns: Vec<isize> = (1 - i as isize..0).chain(self.columns() as isize..self.samples as isize).collect();
        Mat::from_fn(i * l, columns.len(), |row, e| self.sample(columns[e] + (from + row / l) as isize, row % l))
    }

    /// A value of one of the first or last samples; zero where there is none.
    fn sample(&self, t: isize, channel: usize) -> f64 {
        let (l, newest) = (self.channels(), self.samples as isize - 1 - t);
        match (usize::try_from(t), usize::try_from(newest)) {
            (Ok(t), Ok(_)) if t * l < self.head.len() => self.head[t * l + channel],
            (Ok(_), Ok(newest)) => self.tail[newest * l + channel],
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gram::{Gram, stretch};
    use crate::test_noise::Noise;

    #[test]
    fn products_and_power_are_those_of_the_gram_matrix() {
        for (seed, l, i, rows) in [(1, 1, 5, 333), (2, 3, 4, 90), (3, 7, 20, 41), (4, 2, 6, 12)] {
            let mut noise = Noise::new(seed);
            let decay = |t: usize| libm::exp(-0.05 * t as f64);
            let samples: Vec<f64> = (0..rows * l).map(|k| decay(k / l) + 0.1 * noise.normal()).collect();
            let stretch = stretch(&samples, l, i);
            let mut gram = Gram::zeros(l, i);
            gram.add(&stretch);
            let half = gram.half();
            let x = Mat::from_fn(half, 3, |_, _| noise.normal());
            for from in [0, i] {
                let expected = gram.matrix.submatrix(from * l, 0, half, half) * &x;
                let apart = (stretch.product(from, x.as_ref()) - &expected).norm_max();
                // Rounding of some hundred products of numbers up to ten.
                assert!(apart < 1e-11, "seed {seed}, from {from}: {apart}");
            }
            let power: f64 = (0..half).map(|k| gram.matrix[(k, k)]).sum();
            assert!((stretch.past_power() - power).abs() < 1e-11, "seed {seed}");
            assert_eq!(stretch.columns(), gram.columns);
        }
    }
}
