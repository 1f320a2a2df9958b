//! Eigensystem realisation algorithm on free decays, several side by side where there are several.
//!
//! `H₀ = U S Vᵀ` (block Hankel matrix of the decay), `A = S⁻¹ Uᵀ H₁ V` in the basis of U, `C` its
//! first block row. Juang & Pappa 1985. Of the shifted matrix only `H₁ V = H₁ H₀ᵀ U S⁻¹` is needed,
//! so both come from the Gram matrix of one block row more, and decays that follow each other
//! (steps of a reference) are stacked by adding their Gram matrices: no column crosses a step.
//!
//! Cost: the Gram matrix, then subspace iteration of O((il)² n) per pass.

use crate::gram::{Gram, output_gram};
use crate::leading::leading_eigenvectors;
use crate::mac::{extended_modal_amplitude_coherence, modal_phase_collinearity, normalised};
use crate::record::Record;
use crate::ssi_cov::SsiError;
use faer::{Mat, c64};

/// A mode of the realisation.
#[derive(Clone, Debug)]
pub struct EraMode {
    /// Continuous-time pole [1/s].
    pub pole: c64,
    pub mode_shape: Vec<c64>,
    pub phase_collinearity: f64,
    /// Coherence of the last block row with the first, 1 for a mode of the structure.
    pub amplitude_coherence: f64,
}

/// Oscillations of order `order` from at least `block_rows` block rows, in order of frequency.
///
/// # Errors
/// [`SsiError`] when the segments are too short or flat.
pub fn era(record: &Record, block_rows: usize, order: usize) -> Result<Vec<EraMode>, SsiError> {
    let gram = output_gram(record, (block_rows + 1).div_ceil(2));
    let (l, rows) = (gram.channels, (2 * gram.block_rows - 1) * gram.channels);
    let need = order as u64 + 1;
    if gram.columns < need {
        return Err(SsiError::RecordTooShort { columns: gram.columns, need });
    }
    let (u, squares) = leading_eigenvectors(gram.matrix.submatrix(0, 0, rows, rows), order)
        .ok_or(SsiError::DecompositionFailed { rows })?;
    if squares[0].is_nan() || squares[0] <= f64::MIN_POSITIVE {
        return Err(SsiError::NoSignal { largest_singular_value: squares[0].max(0.0).sqrt() });
    }
    Ok(modes(&gram, &u, &squares, record.sample_rate_hz, l))
}

fn modes(gram: &Gram, u: &Mat<f64>, squares: &[f64], sample_rate_hz: f64, l: usize) -> Vec<EraMode> {
    let (rows, order) = (u.nrows(), u.ncols());
    let shifted = gram.matrix.submatrix(l, 0, rows, rows);
    let mut a = u.transpose() * (shifted * u);
    for column in 0..order {
        for row in 0..order {
            a[(row, column)] /= squares[column];
        }
    }
    let Ok(eigen) = a.eigen() else { return Vec::new() };
    let mut modes: Vec<EraMode> = (0..order)
        .filter(|&k| eigen.S().column_vector()[k].im > 0.0)
        .map(|k| {
            let z = eigen.S().column_vector()[k];
            let block = |first: usize| -> Vec<c64> {
                let component = |c: usize| {
                    (0..order).fold(c64::new(0.0, 0.0), |sum, n| sum + eigen.U()[(n, k)] * u[(first + c, n)])
                };
                (0..l).map(component).collect()
            };
            let (first, last) = (block(0), block(rows - l));
            let growth = (1..rows / l).fold(c64::new(1.0, 0.0), |power, _| power * z);
            EraMode {
                pole: c64::new(0.5 * libm::log(z.norm_sqr()), libm::atan2(z.im, z.re)) * sample_rate_hz,
                phase_collinearity: modal_phase_collinearity(&first),
                amplitude_coherence: extended_modal_amplitude_coherence(&first, &last, growth),
                mode_shape: normalised(first.into_iter()),
            }
        })
        .collect();
    modes.sort_by(|a, b| a.pole.norm_sqr().total_cmp(&b.pole.norm_sqr()));
    modes
}
