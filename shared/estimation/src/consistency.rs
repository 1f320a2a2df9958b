//! Is the estimator honest? NEES and NIS against their χ² bands, and whiteness at several time
//! scales.
//!
//! A χ² over single samples misses small persistent errors: one tenth of a standard deviation,
//! constant over 10⁴ samples, moves it by half a sigma of its own spread, but moves the mean of 100
//! samples by a whole one. Whiteness is therefore tested on block means of 1, 10 and 100 samples.
//!
//! | file | subject |
//! |---|---|
//! | `laws` | quantiles of the normal and the χ² law, bands and limits |
//! | `whiteness` | block means, lag one, Ljung and Box |
//! | `score` | does a column that the model lacks explain its residuals |

mod laws;
mod score;
mod whiteness;

pub use laws::{
    DEGREES_MIN, chi_square_quantile, mean_square_band, normal_quantile, normal_two_sided_tail, z_score_limit,
};
pub use score::{bartlett_weight, score_statistic};
pub use whiteness::{ScaleVerdict, WHITENESS_SCALES, Whiteness, coloured_scale, ljung_box, tested_scales};

use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// Normalised estimation error squared `e' P⁻¹ e`; `None` when `P` is not positive definite.
pub fn nees<const P: usize>(error: &SVector<f64, P>, covariance: &SMatrix<f64, P, P>) -> Option<f64> {
    Some(error.dot(&covariance.cholesky()?.solve(error)))
}

/// Mean of a χ² statistic (NEES or NIS) with the band it should lie in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ChiSquareMean {
    sum: f64,
    count: u64,
    degrees: u64,
}

impl ChiSquareMean {
    /// Adds one value that should be χ² with `degrees` of freedom.
    pub fn push(&mut self, value: f64, degrees: u32) {
        self.sum += value;
        self.count += 1;
        self.degrees += u64::from(degrees);
    }

    /// Number of accumulated values.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Sum over all degrees of freedom: one when the model and its covariance hold; `None` before
    /// the first value.
    pub fn per_degree(&self) -> Option<f64> {
        (self.degrees > 0).then(|| self.sum / self.degrees as f64)
    }

    /// Mean value; should equal the degrees of freedom of one value.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }

    /// Two-sided band of [`Self::per_degree`] that holds with `confidence` when the values are
    /// independent.
    pub fn band_per_degree(&self, confidence: f64) -> Option<(f64, f64)> {
        let degrees = self.degrees as f64;
        let tail = (1.0 - confidence) / 2.0;
        (self.degrees > 0)
            .then(|| (chi_square_quantile(tail, degrees) / degrees, chi_square_quantile(1.0 - tail, degrees) / degrees))
    }

    /// `(χ² − n) / √(2n)`: standard deviations away from the expected sum.
    pub fn z_score(&self) -> Option<f64> {
        let degrees = self.degrees as f64;
        (self.degrees > 0).then(|| (self.sum - degrees) / libm::sqrt(2.0 * degrees))
    }
}
