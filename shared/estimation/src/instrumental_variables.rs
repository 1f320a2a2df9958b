//! Instrumental variables: noisy rows, and instruments correlated with the signal but not with the
//! noise.
//!
//! `(Σ w ζ y') α = Σ w ζ b`: consistent however large the noise of `y`, if only `ζ` is independent
//! of it (Söderström, Stoica 1983). The instruments come from simulating the model at the last
//! estimate along the commanded motion; a few passes settle.

use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

use crate::weighted_least_squares::{Estimate, add_outer_product};

/// Data without an instrumental-variable estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InstrumentError {
    /// `Σ ζ y'` is singular: the instruments do not see some direction of the parameters.
    InstrumentsWeak { rows: u64 },
}

/// Sums of one pass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InstrumentalVariables<const P: usize> {
    zy: SMatrix<f64, P, P>,
    zb: SVector<f64, P>,
    /// `Σ w² s² ζ ζ'`
    spread: SMatrix<f64, P, P>,
    rows: u64,
}

impl<const P: usize> Default for InstrumentalVariables<P> {
    fn default() -> Self {
        Self { zy: SMatrix::zeros(), zb: SVector::zeros(), spread: SMatrix::zeros(), rows: 0 }
    }
}

impl<const P: usize> InstrumentalVariables<P> {
    /// One row `y' α = b` with its instrument, weight w, and the variance s² of its residual.
    /// O(P²), no allocation.
    pub fn push(
        &mut self,
        instrument: &SVector<f64, P>,
        regressor: &SVector<f64, P>,
        observed: f64,
        weight: f64,
        variance: f64,
    ) {
        add_outer_product(&mut self.zy, instrument, &(regressor * weight));
        self.zb += instrument * (weight * observed);
        add_outer_product(&mut self.spread, instrument, &(instrument * (weight * weight * variance)));
        self.rows += 1;
    }

    /// `α = (Σ w ζ y')⁻¹ Σ w ζ b`, covariance `(Σ w ζ y')⁻¹ (Σ w² s² ζ ζ') (Σ w ζ y')⁻ᵀ` for
    /// independent residuals.
    ///
    /// # Errors
    /// [`InstrumentError::InstrumentsWeak`].
    pub fn estimate(&self) -> Result<Estimate<P>, InstrumentError> {
        let weak = InstrumentError::InstrumentsWeak { rows: self.rows };
        let inverse = self.zy.try_inverse().ok_or(weak)?;
        let alpha = inverse * self.zb;
        if !alpha.iter().all(|value| value.is_finite()) {
            return Err(weak);
        }
        Ok(Estimate { alpha, covariance: inverse * self.spread * inverse.transpose() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::consistency::{ChiSquareMean, nees};
    use crate::seeded_noise::SeededNoise;
    use nalgebra::vector;

    #[test]
    fn instruments_remove_the_attenuation_of_least_squares_and_the_covariance_is_honest() {
        let (mut statistic, mut attenuated) = (ChiSquareMean::default(), 0.0);
        for seed in 0..300 {
            let (mut noise, mut iv) = (SeededNoise::new(seed), InstrumentalVariables::<2>::default());
            let (mut yy, mut yb) = (0.0, 0.0);
            for k in 0..400 {
                let clean = vector![libm::sin(0.1 * f64::from(k)), 1.0];
                let y = clean + vector![0.5 * noise.normal(), 0.0];
                let b = 2.0 * clean[0] - clean[1] + 0.1 * noise.normal();
                iv.push(&clean, &y, b, 1.0, 4.0 * 0.25 + 0.01);
                (yy, yb) = (yy + y[0] * y[0], yb + y[0] * (b + 1.0));
            }
            attenuated += yb / yy / 300.0;
            let estimate = iv.estimate().expect("instruments see both");
            statistic.push(nees(&(estimate.alpha - vector![2.0, -1.0]), &estimate.covariance).expect("positive"), 2);
        }
        assert!((attenuated - 2.0 * 0.5 / 0.75).abs() < 0.02, "{attenuated}"); // signal over signal and noise
        let (low, high) = statistic.band_per_degree(0.999).expect("300 values");
        let mean = statistic.per_degree().expect("300 values");
        assert!(mean > low && mean < high, "{mean} outside [{low}, {high}]");
    }

    #[test]
    fn an_instrument_that_never_moves_is_refused() {
        let mut iv = InstrumentalVariables::<2>::default();
        for k in 0..10 {
            iv.push(&vector![1.0, 0.0], &vector![f64::from(k), 1.0], 1.0, 1.0, 1.0);
        }
        assert_eq!(iv.estimate(), Err(InstrumentError::InstrumentsWeak { rows: 10 }));
    }
}
