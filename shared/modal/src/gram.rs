//! Gram matrix of the block-Hankel matrix of a record, exactly, without ever forming the long
//! matrix.
//!
//! With `R_k = Σ_t y_t y_{t−k}ᵀ`, k = 0 … 2i−1, the first block row follows from the lag sums less
//! the products that end in no column, and the rest by displacement:
//! `G[p,q] = G[p−1,q−1] − y_{p−1} y_{q−1}ᵀ + y_{p−1+Nc} y_{q−1+Nc}ᵀ`, Nc = N − 2i + 1 columns.
//! Cost: 4 i l² N multiply-adds instead of the (2il)² N/2 of the product.
//!
//! The lag sums of a record in memory are matrix products: B samples side by side are a column of B
//! l numbers where they lie, so that `Σ_s Y_s Y_{s−j}ᵀ` (B l × B l, a view of the record) holds the
//! products of all lags from (j−1) B + 1 to (j+1) B − 1.

use crate::record::Record;
use crate::stretch::Stretch;
use faer::{Accum, Mat, MatRef, Par};
use std::ops::Range;

/// Samples kept from the end of a stretch, in units of i: 2i for the displacement, 3i for lagged
/// sums of the last columns.
pub(crate) const TAIL_LENGTH: usize = 3;
/// Numbers side by side in one column of the products: as many as fill the cache's panels.
const PANEL: usize = 192;

/// Gram matrix `H Hᵀ` of a block-Hankel matrix: 2i block rows of l channels, `columns` columns.
#[derive(Clone, Debug)]
pub struct Gram {
    pub matrix: Mat<f64>,
    pub columns: u64,
    pub channels: usize,
    pub block_rows: usize,
    /// Of every segment: its number of samples and its last 3i samples, newest first.
    pub(crate) tails: Vec<(u64, Vec<f64>)>,
    /// Channels whose past takes part; all when empty.
    pub(crate) references: Vec<bool>,
}

/// Gram matrix over `segments` of a record of `channels` (samples one after the other); no column
/// crosses a border.
#[must_use]
pub fn gram(samples: &[f64], channels: usize, block_rows: usize, segments: &[Range<usize>]) -> Gram {
    let mut gram = Gram::zeros(channels, block_rows);
    for segment in segments.iter().filter(|segment| segment.len() >= 2 * block_rows) {
        gram.add(&stretch(&samples[segment.start * channels..segment.end * channels], channels, block_rows));
    }
    gram
}

/// Sums over at least 2i samples.
pub(crate) fn stretch(samples: &[f64], channels: usize, block_rows: usize) -> Stretch {
    let (rows, depth) = (2 * block_rows, TAIL_LENGTH * block_rows);
    let mut tail: Vec<f64> = samples.rchunks_exact(channels).take(depth).flatten().copied().collect();
    tail.resize(depth * channels, 0.0);
    Stretch {
        samples: (samples.len() / channels) as u64,
        lag_sums: lag_sums(samples, channels, rows),
        head: samples[..rows * channels].to_vec(),
        tail,
    }
}

/// As [`gram`], of the outputs of a record over its segments.
#[must_use]
pub fn output_gram(record: &Record, block_rows: usize) -> Gram {
    gram(&record.outputs, record.channels, block_rows, &record.segments)
}

/// `R_k[a][b]` at `a · rows l + k · l + b`.
pub(crate) fn lag_sums(samples: &[f64], l: usize, rows: usize) -> Vec<f64> {
    let width = rows * l;
    let mut sums = vec![0.0; l * width];
    let side = (PANEL / l).clamp(1, rows);
    let columns = samples.len() / (side * l);
    let panel = side * l;
    let mut product = Mat::<f64>::zeros(panel, panel);
    for j in 0..columns.min((rows + side - 2) / side + 1) {
        let later = MatRef::from_column_major_slice(&samples[j * panel..columns * panel], panel, columns - j);
        let earlier = MatRef::from_column_major_slice(&samples[..(columns - j) * panel], panel, columns - j);
        faer::linalg::matmul::matmul(product.as_mut(), Accum::Replace, later, earlier.transpose(), 1.0, Par::Seq);
        for q in 0..side {
            for p in 0..side {
                let Some(k) = (j * side + p).checked_sub(q).filter(|k| *k < rows) else { continue };
                for b in 0..l {
                    for a in 0..l {
                        sums[a * width + k * l + b] += product[(p * l + a, q * l + b)];
                    }
                }
            }
        }
    }
    for t in columns * side..samples.len() / l {
        for k in 0..rows.min(t + 1) {
            for a in 0..l {
                for b in 0..l {
                    sums[a * width + k * l + b] += samples[t * l + a] * samples[(t - k) * l + b];
                }
            }
        }
    }
    sums
}

impl Gram {
    pub(crate) fn zeros(channels: usize, block_rows: usize) -> Self {
        let size = 2 * block_rows * channels;
        Self {
            matrix: Mat::zeros(size, size),
            columns: 0,
            channels,
            block_rows,
            tails: Vec::new(),
            references: Vec::new(),
        }
    }

    /// Rows of the past (or of the future): `i l`.
    #[must_use]
    pub fn half(&self) -> usize {
        self.block_rows * self.channels
    }

    /// Future–past product with zeros for the past of channels that are no references; `None` when
    /// all are.
    pub(crate) fn of_references(&self) -> Option<Mat<f64>> {
        let (l, half) = (self.channels, self.half());
        let all = self.references.iter().all(|is| *is);
        let element = |row: usize, column: usize| {
            if self.references[column % l] { self.matrix[(half + row, column)] } else { 0.0 }
        };
        (!all).then(|| Mat::from_fn(half, half, element))
    }

    /// Adds the Gram matrix of one stretch: first block row from the lag sums, the rest by
    /// displacement.
    pub(crate) fn add(&mut self, stretch: &Stretch) {
        let (l, rows) = (self.channels, 2 * self.block_rows);
        if stretch.samples < rows as u64 {
            return;
        }
        self.columns += stretch.samples - rows as u64 + 1;
        self.tails.push((stretch.samples, stretch.tail.clone()));
        let first_row = self.first_block_row(stretch);
        for q in 0..rows {
            // `acc` walks down the diagonal G[0,q], G[1,q+1], …
            let mut acc: Vec<f64> = first_row[q * l * l..(q + 1) * l * l].to_vec();
            for p in 0..rows - q {
                if p > 0 {
                    displace(&mut acc, stretch, l, (p, q, rows));
                }
                for a in 0..l {
                    let below = &mut self.matrix.col_as_slice_mut(p * l + a)[(p + q) * l..(p + q + 1) * l];
                    below.iter_mut().zip(&acc[a * l..(a + 1) * l]).for_each(|(sum, x)| *sum += x);
                }
                for b in 0..if q > 0 { l } else { 0 } {
                    let above = &mut self.matrix.col_as_slice_mut((p + q) * l + b)[p * l..(p + 1) * l];
                    above.iter_mut().zip(acc.iter().skip(b).step_by(l)).for_each(|(sum, x)| *sum += x);
                }
            }
        }
    }

    /// `G[0,k] = Σ_{t<Nc} y_t y_{t+k}ᵀ`: the lag sums without the products that end in no column.
    fn first_block_row(&self, stretch: &Stretch) -> Vec<f64> {
        let (l, rows) = (self.channels, 2 * self.block_rows);
        let width = rows * l;
        let mut first_row = vec![0.0; rows * l * l];
        for k in 0..rows {
            let out = &mut first_row[k * l * l..(k + 1) * l * l];
            for a in 0..l {
                for b in 0..l {
                    out[a * l + b] = stretch.lag_sums[b * width + k * l + a];
                }
            }
            for late in 0..(rows - 1).saturating_sub(k) {
                let (newer, older) =
                    (&stretch.tail[late * l..(late + 1) * l], &stretch.tail[(late + k) * l..(late + k + 1) * l]);
                for a in 0..l {
                    for b in 0..l {
                        out[a * l + b] -= older[a] * newer[b];
                    }
                }
            }
        }
        first_row
    }
}

/// One step down the diagonal `q`, to block row `p`.
fn displace(acc: &mut [f64], stretch: &Stretch, l: usize, (p, q, rows): (usize, usize, usize)) {
    let (head_p, head_q) = (&stretch.head[(p - 1) * l..p * l], &stretch.head[(p + q - 1) * l..(p + q) * l]);
    let (late_p, late_q) = (rows - 1 - p, rows - 1 - p - q);
    let (tail_p, tail_q) = (&stretch.tail[late_p * l..(late_p + 1) * l], &stretch.tail[late_q * l..(late_q + 1) * l]);
    for a in 0..l {
        for b in 0..l {
            acc[a * l + b] += tail_p[a] * tail_q[b] - head_p[a] * head_q[b];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::Noise;

    /// Product of the block-Hankel matrix with itself, column by column.
    fn direct(samples: &[f64], l: usize, rows: usize, segments: &[Range<usize>]) -> (Mat<f64>, u64) {
        let mut product = Mat::<f64>::zeros(rows * l, rows * l);
        let mut columns = 0;
        for segment in segments {
            for t in segment.start..(segment.end + 1).saturating_sub(rows).max(segment.start) {
                let column = &samples[t * l..(t + rows) * l];
                for a in 0..rows * l {
                    for b in 0..rows * l {
                        product[(a, b)] += column[a] * column[b];
                    }
                }
                columns += 1;
            }
        }
        (product, columns)
    }

    #[test]
    fn matrix_is_the_product_of_the_hankel_matrix_whatever_lengths_channels_and_segments() {
        for (seed, l, block_rows, segments) in [
            (1, 1, 5, std::iter::once(0..333).collect::<Vec<_>>()),
            (2, 3, 4, vec![3..90, 90..333]),
            (3, 7, 20, vec![0..300, 310..330]),
            (4, 2, 6, std::iter::once(5..17).collect()),
        ] {
            let mut noise = Noise::new(seed);
            let samples: Vec<f64> = (0..333 * l).map(|k| noise.normal() + (k % l) as f64).collect();
            let fast = gram(&samples, l, block_rows, &segments);
            let (product, columns) = direct(&samples, l, 2 * block_rows, &segments);
            assert_eq!(fast.columns, columns);
            for a in 0..2 * block_rows * l {
                for b in 0..2 * block_rows * l {
                    // Rounding of some hundred products of numbers up to 10.
                    assert!((fast.matrix[(a, b)] - product[(a, b)]).abs() < 1e-10, "seed {seed}: {a} {b}");
                }
            }
        }
    }
}
