//! Fisher information of an experiment and the Cramér–Rao bound on the covariance of any unbiased
//! estimator.

use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// `I = Σ h h' / σ²` over independent scalar measurements with sensitivity `h = ∂(mean)/∂θ`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FisherInformation<const P: usize> {
    pub matrix: SMatrix<f64, P, P>,
}

impl<const P: usize> Default for FisherInformation<P> {
    fn default() -> Self {
        Self { matrix: SMatrix::zeros() }
    }
}

impl<const P: usize> FisherInformation<P> {
    /// Adds a scalar measurement: `F += h hᵀ / σ²`, `h` (P) its sensitivity, σ² its variance.
    ///
    /// # Panics
    /// `variance` is not positive.
    pub fn push(&mut self, sensitivity: &SVector<f64, P>, variance: f64) {
        assert!(variance > 0.0);
        self.matrix += sensitivity * sensitivity.transpose() / variance;
    }

    /// Lower bound on the covariance; `None` when some direction of the parameters leaves no trace
    /// in the data.
    ///
    /// "No trace": information scaled to unit diagonal is not positive, or its weakest Cholesky
    /// pivot is below 1e-7 (condition above ~1e14, where the inverse is rounding).
    pub fn bound(&self) -> Option<SMatrix<f64, P, P>> {
        let diagonal = self.matrix.diagonal();
        if !diagonal.iter().all(|value| *value > 0.0 && value.is_finite()) {
            return None;
        }
        let scaling = SMatrix::<f64, P, P>::from_diagonal(&diagonal.map(|value| 1.0 / libm::sqrt(value)));
        let factor = (scaling * self.matrix * scaling).cholesky()?;
        let weakest = factor.l_dirty().diagonal().min();
        (weakest > 1e-7).then(|| scaling * factor.inverse() * scaling)
    }

    /// Square roots of the diagonal of [`Self::bound`].
    pub fn sigmas(&self) -> Option<SVector<f64, P>> {
        Some(self.bound()?.diagonal().map(libm::sqrt))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;

    #[test]
    fn bound_of_a_straight_line_equals_the_textbook() {
        let mut information = FisherInformation::<2>::default();
        let (n, sigma) = (101, 0.3);
        for k in 0..n {
            information.push(&vector![1.0, f64::from(k) - 50.0], sigma * sigma);
        }
        let sigmas = information.sigmas().expect("two unknowns, 101 points");
        let sum_t2 = (1..=50).map(|t| 2.0 * f64::from(t * t)).sum::<f64>();
        assert!((sigmas[0] - sigma / 101.0_f64.sqrt()).abs() < 1e-15);
        assert!((sigmas[1] - sigma / sum_t2.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn an_unseen_direction_has_no_bound() {
        let mut information = FisherInformation::<2>::default();
        for k in 0..10 {
            let x = 1.0 + f64::from(k);
            information.push(&vector![x, 3.0 * x], 1.0);
        }
        assert_eq!(information.bound(), None);
    }
}
