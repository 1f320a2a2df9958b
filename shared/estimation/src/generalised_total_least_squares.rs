//! Generalised total least squares: noisy regressors with a known covariance, an observation
//! without noise.
//!
//! `min ‖Y α − b‖² / (α' S α)`, S the mean noise covariance of a row. With the exact column first,
//! `[b Y] = Q R`: the first row of R is met exactly, and the remainder, whitened by `S = L L'`, is
//! a smallest right singular vector (Golub, Hoffman, Stewart 1987; Van Huffel, Vandewalle 1989).
//! Plain total least squares is `S = 1` and `b` as noisy as the rest.

use crate::total_least_squares::{TlsError, rotate_in, smallest_right_singular_vector};
use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// Triangular factor of the rows `[b y']` and the sum of their noise covariances; `A = P + 1`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GeneralisedTotalLeastSquares<const P: usize, const A: usize> {
    factor: SMatrix<f64, A, A>,
    noise: SMatrix<f64, P, P>,
    rows: u64,
}

impl<const P: usize, const A: usize> Default for GeneralisedTotalLeastSquares<P, A> {
    fn default() -> Self {
        const { assert!(A == P + 1) }
        Self { factor: SMatrix::zeros(), noise: SMatrix::zeros(), rows: 0 }
    }
}

impl<const P: usize, const A: usize> GeneralisedTotalLeastSquares<P, A> {
    /// Rotates one row into the factor; `noise` (P × C) are the columns `σ_c ∂y/∂c`. O(A² + P² C),
    /// no allocation.
    pub fn push<const C: usize>(&mut self, regressor: &SVector<f64, P>, observed: f64, noise: &SMatrix<f64, P, C>) {
        let row = SVector::<f64, A>::from_fn(|i, _| if i == 0 { observed } else { regressor[i - 1] });
        rotate_in(&mut self.factor, row);
        self.noise += noise * noise.transpose();
        self.rows += 1;
    }

    /// # Errors
    /// [`TlsError::Nongeneric`]: no finite α explains the data. [`TlsError::NoiseSingular`]: some
    /// combination of the columns is free of noise, so that no division by its noise is possible;
    /// weight with [`crate::weighted_pass`] instead.
    pub fn estimate(&self) -> Result<SVector<f64, P>, TlsError> {
        if self.rows < A as u64 {
            return Err(TlsError::TooFewRows { got: self.rows, need: A as u64 });
        }
        let whitening = (self.noise / self.rows as f64).cholesky().ok_or(TlsError::NoiseSingular)?.l();
        let rest = SMatrix::<f64, P, P>::from_fn(|i, j| self.factor[(i + 1, j + 1)]);
        // rest · L'⁻¹ = (L⁻¹ rest')'
        let whitened = whitening.solve_lower_triangular(&rest.transpose()).ok_or(TlsError::NoiseSingular)?.transpose();
        let u = smallest_right_singular_vector(&whitened).ok_or(TlsError::NotConverged)?;
        let v = whitening.tr_solve_lower_triangular(&u).ok_or(TlsError::NoiseSingular)?;
        let along: f64 = (0..P).map(|j| self.factor[(0, j + 1)] * v[j]).sum();
        let v_b = -along / self.factor[(0, 0)];
        if v_b.is_nan() || v_b.abs() <= A as f64 * f64::EPSILON * v.norm() {
            return Err(TlsError::Nongeneric { v_qq: v_b });
        }
        Ok(v / -v_b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;
    use nalgebra::{matrix, vector};

    #[test]
    fn the_estimate_makes_the_rayleigh_quotient_stationary_and_smallest() {
        let mut noise = SeededNoise::new(3);
        let (mut gtls, mut yy, mut yb, mut bb) =
            (GeneralisedTotalLeastSquares::<2, 3>::default(), SMatrix::<f64, 2, 2>::zeros(), SVector::zeros(), 0.0);
        let columns = matrix![0.1, 0.0; 0.05, 0.3];
        for _ in 0..500 {
            let clean = vector![noise.normal(), noise.normal()];
            let y = clean + columns * vector![noise.normal(), noise.normal()];
            let b = 2.0 * clean[0] - clean[1];
            gtls.push(&y, b, &columns);
            yy += y * y.transpose();
            yb += y * b;
            bb += b * b;
        }
        let alpha = gtls.estimate().expect("generic");
        let s = columns * columns.transpose();
        let cost = |a: &SVector<f64, 2>| (a.dot(&(yy * a)) - 2.0 * a.dot(&yb) + bb) / a.dot(&(s * a));
        let best = cost(&alpha);
        for k in 0..64 {
            let angle = f64::from(k) * 0.1;
            let moved = alpha + vector![libm::cos(angle), libm::sin(angle)] * 1e-3;
            assert!(cost(&moved) > best);
        }
        // Truth within the sampling error 0.3 · 2 / √500.
        assert!((alpha - vector![2.0, -1.0]).norm() < 0.15, "{alpha}");
    }

    #[test]
    fn a_column_without_noise_is_refused() {
        let mut gtls = GeneralisedTotalLeastSquares::<2, 3>::default();
        for k in 0..10 {
            gtls.push(&vector![f64::from(k), 1.0], 1.0, &matrix![0.1; 0.0]);
        }
        assert_eq!(gtls.estimate(), Err(TlsError::NoiseSingular));
    }
}
