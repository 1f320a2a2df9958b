//! A line on a mode: the weights of the channels that take the mode out and leave the line.
//!
//! Near a resonance all channels move in one shape. The cells of a narrow band about it hold
//! `y_k = φ q_k + n_k`, n_k being the sensors' noise and the skirts of other modes, which hardly
//! change within the band; the cell of a line holds its amplitude, too. Of the eigenvectors of
//! `S = Σ_k y_k y_kᴴ / M` over M neighbours (eigenvalues λ) the r leading ones, of coordinates x,
//! hold the modes. In the coordinates z of the others a line stands alone, however high the modes
//! are. Under normal noise without a line
//!
//! `T² = Σ_j |z_j|² / (M λ_j) / (1 + Σ_i |x_i|² / (M λ_i)) ~ p/(M − l + 1) · F(2p, 2(M − l + 1))`
//!
//! for the cell itself, p = l − r: z given x is a regression on x, so that the spectrum of the
//! modes has no part in it (Hotelling 1931; Rao 1948, test of additional information; of complex
//! variables Goodman 1963).
//!
//! Fails on a line whose channels move in the shape of the mode: it has no z.

use super::spectra::Spectra;
use faer::{Mat, Side, c64};

/// Nearest neighbour, in cells: beyond the peak that a Hann window makes of a line.
const NEAREST: usize = 3;
/// Distance of neighbours in cells: behind a Hann window their correlation is 1/6.
const APART: usize = 2;
/// Neighbours per dimension: of fewer the inverse of S is mostly chance.
const NEIGHBOURS_PER_DIMENSION: usize = 2;
/// Eigenvalues below this part of the largest are rounding.
const ROUNDING_SHARE: f64 = 1e-12;

/// Weights `w` of the channels, `wᵀ y`, in which a line `cells` from zero frequency stands above a
/// band of ± `half_cells` with so many `modes` in it; `None` where none stands out by less than
/// `chance`.
pub(super) fn weights(spectra: &Spectra, cells: f64, half_cells: usize, modes: usize, chance: f64) -> Option<Vec<c64>> {
    let centre = spectra.at(cells)?;
    let offsets = (NEAREST..=half_cells + 1).step_by(APART).flat_map(|offset| [-(offset as f64), offset as f64]);
    let neighbours: Vec<Vec<c64>> = offsets.map(|offset| spectra.at(cells + offset)).collect::<Option<_>>()?;
    let (l, count) = (centre.len(), neighbours.len() as f64);
    let scale: Vec<f64> = (0..l)
        .map(|c| neighbours.iter().map(|y| y[c].norm_sqr()).sum::<f64>() / count)
        .map(|mean| if mean > 0.0 { 1.0 / mean.sqrt() } else { 0.0 })
        .collect();
    let element = |a: usize, b: usize| {
        let sum = neighbours.iter().fold(c64::new(0.0, 0.0), |sum, y| sum + y[a] * y[b].conj());
        sum * (scale[a] * scale[b] / count)
    };
    let eigen = Mat::from_fn(l, l, element).self_adjoint_eigen(Side::Lower).ok()?;
    let value = |k: usize| eigen.S().column_vector()[l - 1 - k].re;
    let largest = neighbours.len() / NEIGHBOURS_PER_DIMENSION;
    let dimensions = (0..l.min(largest)).take_while(|k| value(*k) > ROUNDING_SHARE * value(0)).count();
    if dimensions < 2 {
        return None;
    }
    let of_modes = modes.clamp(1, dimensions - 1);
    let coordinate = |k: usize| {
        let along = |c: usize| eigen.U()[(c, l - 1 - k)].conj() * centre[c] * scale[c];
        (0..l).map(along).fold(c64::new(0.0, 0.0), |sum, x| sum + x)
    };
    let share = |k: usize| coordinate(k).norm_sqr() / (count * value(k));
    let with_modes: f64 = (0..of_modes).map(share).sum();
    let beside: f64 = (of_modes..dimensions).map(share).sum();
    let freedom = neighbours.len() - dimensions + 1;
    if tail(beside / (1.0 + with_modes), dimensions - of_modes, freedom) > chance {
        return None;
    }
    let of_channel = |c: usize| {
        let along = |k: usize| eigen.U()[(c, l - 1 - k)].conj() * coordinate(k).conj() / value(k);
        (of_modes..dimensions).map(along).fold(c64::new(0.0, 0.0), |sum, x| sum + x) * scale[c]
    };
    Some((0..l).map(of_channel).collect())
}

/// Probability that `p/b · F(2p, 2b)` exceeds `t`:
/// `(1 + t)^(−b) Σ_{j<p} C(b + j − 1, j) (t/(1 + t))^j` (Abramowitz & Stegun 1964, 26.6.4).
fn tail(t: f64, p: usize, b: usize) -> f64 {
    let ratio = t / (1.0 + t);
    let (mut term, mut sum) = (1.0, 0.0);
    for j in 0..p {
        sum += term;
        term *= ratio * (b + j) as f64 / (j + 1) as f64;
    }
    sum * libm::exp(-(b as f64) * libm::log1p(t))
}

#[cfg(test)]
mod tests {
    use super::super::baseband::Samples;
    use super::*;
    use crate::seeded::Seeded;

    const ROWS: usize = 2000;
    const CELLS: f64 = 400.0;

    /// A mode of half width `width` cells in one shape, noise of a hundredth of it, and a line of
    /// so much of its rms in another.
    fn record(width: f64, line: f64, random: &mut Seeded) -> Samples {
        let (shape, of_line) = ([1.0, -0.6, 0.8, 0.4], [0.5, 0.9, -0.7, 1.0]);
        let keep = super::super::fourier::turn(core::f64::consts::TAU * CELLS / ROWS as f64)
            * libm::exp(-core::f64::consts::TAU * width / ROWS as f64);
        let drive = (1.0 - keep.norm_sqr()).sqrt();
        let mut q = random.complex_normal();
        let mut values = Vec::with_capacity(4 * ROWS);
        for t in 0..ROWS {
            q = q * keep + random.complex_normal() * drive;
            let tone = line * libm::sin(core::f64::consts::TAU * (CELLS + 0.4) * t as f64 / ROWS as f64);
            values.extend((0..4).map(|c| shape[c] * q.re + of_line[c] * tone + 0.01 * random.complex_normal().re));
        }
        Samples::new(&values, 4, 1.0)
    }

    #[test]
    fn the_tail_is_that_of_the_tables() {
        // F(4, 10) and F(2, 20) at 1 %: 5.994 and 5.849 (Abramowitz & Stegun 1964, table 26.9).
        assert!((tail(5.994 * 2.0 / 5.0, 2, 5) / 0.01 - 1.0).abs() < 2e-3);
        assert!((tail(5.849 * 1.0 / 10.0, 1, 10) / 0.01 - 1.0).abs() < 2e-3);
    }

    #[test]
    fn a_mode_of_any_width_is_no_line_more_often_than_chance_has_it() {
        let mut random = Seeded::new(21);
        for width in [1.0, 4.0, 20.0] {
            let passes = (0..200).filter(|_| {
                let spectra = Spectra::new(&record(width, 0.0, &mut random));
                weights(&spectra, CELLS, 24, 1, 0.05).is_some()
            });
            // 10 expected, deviation 3.1; neighbours behind a window are not quite independent.
            let passed = passes.count();
            assert!((1..=24).contains(&passed), "{width}: {passed}");
        }
    }

    #[test]
    fn a_line_of_a_tenth_of_the_mode_is_seen_on_it_and_the_mode_is_not() {
        let mut random = Seeded::new(22);
        for width in [1.0, 4.0, 20.0] {
            let samples = record(width, 0.1, &mut random);
            let w = weights(&Spectra::new(&samples), CELLS + 0.4, 24, 1, 1e-9).expect("a line");
            let gain =
                |shape: [f64; 4]| w.iter().zip(shape).fold(c64::new(0.0, 0.0), |sum, (w, x)| sum + *w * x).norm_sqr();
            assert!(gain([1.0, -0.6, 0.8, 0.4]) < 1e-2 * gain([0.5, 0.9, -0.7, 1.0]), "{width}");
        }
    }
}
