//! What an arc says, and what all say together.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// What one arc knows of the vehicle at a point of linearisation, its prior not counted.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// `N = Σ h h'` over the unknowns of the vehicle (n × n), per prior standard deviations.
    pub information: DMatrix<f64>,
    /// `g = Σ h r` (n).
    pub gradient: DVector<f64>,
    /// Sum of the squared whitened innovations.
    pub chi2: f64,
    /// `Σ ln |S|`.
    pub log_determinant: f64,
    pub rows: usize,
}

impl Message {
    /// Of an arc that was not heard, on `n` unknowns.
    #[must_use]
    pub fn of_nothing(n: usize) -> Self {
        let (information, gradient) = (DMatrix::zeros(n, n), DVector::zeros(n));
        Self { information, gradient, chi2: 0.0, log_determinant: 0.0, rows: 0 }
    }
}

/// A normal law of the unknowns: `Λ` and its mean, in prior standard deviations from the priors.
#[derive(Clone, Debug, PartialEq)]
pub struct Knowledge {
    /// `Λ` (n × n).
    pub information: DMatrix<f64>,
    /// Mean of `d` (n).
    pub mean: DVector<f64>,
}

impl Knowledge {
    /// What the priors of `n` unknowns say.
    #[must_use]
    pub fn of_priors(n: usize) -> Self {
        Self { information: DMatrix::identity(n, n), mean: DVector::zeros(n) }
    }

    /// `(d − mean)' Λ (d − mean)`.
    #[must_use]
    pub fn chi2(&self, d: &DVector<f64>) -> f64 {
        let off = d - &self.mean;
        off.dot(&(&self.information * &off))
    }

    /// This and what `messages` say at `d`, folded in their order; `None` where the sum is not
    /// positive.
    #[must_use]
    pub fn with<'m>(&self, messages: impl IntoIterator<Item = &'m Message>, d: &DVector<f64>) -> Option<Self> {
        let mut information = self.information.clone();
        let mut right = &self.information * (&self.mean - d);
        for message in messages {
            information += &message.information;
            right += &message.gradient;
        }
        let step = Cholesky::new(information.clone())?.solve(&right);
        Some(Self { information, mean: d + step })
    }

    /// Factor of `Λ`.
    #[must_use]
    pub fn factor(&self) -> Option<Cholesky<f64, Dyn>> {
        Cholesky::new(self.information.clone())
    }

    /// `Λ⁻¹` (n × n).
    #[must_use]
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        self.factor().map(|factor| factor.inverse())
    }
}
