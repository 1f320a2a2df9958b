//! Whether one arc says the same as all others.

use super::fold::{Knowledge, Message};
use crate::statistics::chi_squared_tail;
use nalgebra::{DVector, SymmetricEigen};

/// What separates an arc from all others together: `(θ_i − θ_r)' (N_i⁻¹ + Λ_r⁻¹)⁻¹ (θ_i − θ_r)`
/// over the directions that the arc sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    pub chi2: f64,
    /// Directions that the arc sees.
    pub freedom: usize,
    /// Upper tail: how often arcs of one vehicle differ as much.
    pub p: f64,
}

/// Share of the others' information from which an arc sees a direction: below, the sum changes by
/// rounding of the differences that the sensitivities are (step 10⁻³ of a prior, relative error
/// 10⁻³ of each, squared).
const SEEN_SHARE: f64 = 1e-6;

impl Agreement {
    /// Of `message` with what `others` know, both linearised at `d`. With `Λ_r = L L'`,
    /// `A = L⁻¹ N L⁻' = Σ a v v'` and the arc's own score at the others' mean
    /// `b = L⁻¹ (g − N (mean − d))`, whose covariance is `A + A²`: `χ² = Σ (v'b)²/(a + a²)`.
    ///
    /// `None` where the others' information is not positive.
    #[must_use]
    pub fn of(message: &Message, others: &Knowledge, d: &DVector<f64>) -> Option<Self> {
        let factor = others.factor()?.unpack();
        let score = &message.gradient - &message.information * (&others.mean - d);
        let b = factor.solve_lower_triangular(&score)?;
        let half = factor.solve_lower_triangular(&message.information)?;
        let whole = factor.solve_lower_triangular(&half.transpose())?;
        let eigen = SymmetricEigen::new(0.5 * (&whole + whole.transpose()));
        let seen = eigen.eigenvalues.iter().enumerate().filter(|(_, a)| **a > SEEN_SHARE);
        let (mut chi2, mut freedom) = (0.0, 0);
        for (k, a) in seen {
            chi2 += eigen.eigenvectors.column(k).dot(&b).powi(2) / (a + a * a);
            freedom += 1;
        }
        Some(Self { chi2, freedom, p: if freedom == 0 { 1.0 } else { chi_squared_tail(chi2, freedom as f64) } })
    }
}
