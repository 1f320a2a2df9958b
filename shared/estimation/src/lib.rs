//! Recursive, fixed-memory estimators and the statistics that test their consistency.
//!
//! What it is: least squares with noisy rows (weighted, total, instrumental), a square-root
//! unscented Kalman filter, information bounds, tests of consistency and of lasting changes; and
//! the numerical methods that more than one crate needs: minimisers, the exponential of a matrix,
//! quantiles. Sizes are generic; every loop has a stated bound. No std, no alloc: the crate flies.
//!
//! May import: nalgebra, libm, serde.
//!
//! Must never know: any spacecraft, sensor, unit of a physical quantity, clock or file.
//!
//! ```
//! use estimation::{cramer_rao::FisherInformation, total_least_squares::TotalLeastSquares};
//! use nalgebra::vector;
//!
//! let mut fit = TotalLeastSquares::<2, 3>::default(); // two parameters, three columns of [Y b]
//! let mut information = FisherInformation::<2>::default();
//! for k in 0..20 {
//!     let (row, observed) = (vector![1.0, f64::from(k)], 3.0 + 0.5 * f64::from(k));
//!     fit.push(&row, observed);
//!     information.push(&row, 0.01); // variance of one observation
//! }
//! let alpha = fit.estimate().expect("more rows than parameters");
//! assert!((alpha - vector![3.0, 0.5]).norm() < 1e-12);
//! let sigmas = information.sigmas().expect("both parameters are observable");
//! assert!(sigmas[1] < sigmas[0] && sigmas[0] < 0.05);
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `weighted_least_squares` | errors-in-variables least squares, noise compensated |
//! | `weighted_pass` | the same in batch: one pass at fixed weights |
//! | `golden_section` | minimum of a function of one variable |
//! | `levenberg_marquardt` | minimum of a sum of squares |
//! | `matrix_exponential` | exponential of a matrix |
//! | `identifiability` | what data did to a prior: identified, prior kept, not excited |
//! | `instrumental_variables` | noisy rows, instruments without noise |
//! | `generalised_total_least_squares` | noise covariance of the columns, observation exact |
//! | `total_least_squares` | the seed's estimator, streamed through the Givens factor of `[Y b]` |
//! | `unscented` | square-root unscented Kalman filter; the trait of models in state space |
//! | `consistency` | NEES, NIS, χ² bands; whiteness; score tests |
//! | `cramer_rao` | Fisher information and the bound it implies |
//! | `cusum` | a lasting change of a mean: cumulative sums, jump from a running mean |
//! | `quantiles` | median and quantiles by linear interpolation |
//!
//! *Why no trait for "linear in the parameters"?* Only one estimator here consumes rows, and it
//! takes the row as a value ([`weighted_least_squares::NoisyRow`]); a trait would have a single
//! implementor.

#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod consistency;
pub mod cramer_rao;
pub mod cusum;
pub mod generalised_total_least_squares;
pub mod golden_section;
pub mod identifiability;
pub mod instrumental_variables;
pub mod levenberg_marquardt;
pub mod matrix_exponential;
pub mod quantiles;
#[cfg(test)]
mod seeded_noise;
pub mod total_least_squares;
pub mod unscented;
pub mod weighted_least_squares;
pub mod weighted_pass;

pub use matrix_exponential::matrix_exponential;
use serde::{Deserialize, Serialize};

/// Five standard deviations: the gate [`Innovation::test_ratio`] is measured against. An innovation
/// beyond it is reported as not accepted; the estimators use it all the same.
pub const GATE_SIGMAS: f64 = 5.0;

/// Difference between a measurement and its prediction, before the update.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Innovation {
    /// Measured minus predicted, in the unit of the measurement.
    pub innovation: f64,
    /// Variance the estimator expected of it, its own uncertainty included.
    pub variance: f64,
    /// Part of `variance` that the sensors alone account for; the rest is uncertainty of the
    /// estimate.
    pub noise_variance: f64,
    /// `innovation² / (5² variance)`: above one, the measurement lies outside five standard
    /// deviations.
    pub test_ratio: f64,
}

impl Innovation {
    /// The innovation with its variance, the sum of `noise_variance` and of the `uncertainty` of
    /// the prediction.
    pub fn new(innovation: f64, noise_variance: f64, uncertainty: f64) -> Self {
        let variance = noise_variance + uncertainty;
        let test_ratio = innovation * innovation / (GATE_SIGMAS * GATE_SIGMAS * variance);
        Self { innovation, variance, noise_variance, test_ratio }
    }

    /// Share of the expected variance that is the estimate's own uncertainty, relative to the
    /// sensors' share.
    pub fn uncertainty_over_noise(&self) -> f64 {
        (self.variance - self.noise_variance) / self.noise_variance
    }

    /// Innovation over its predicted standard deviation: standard normal if the model holds.
    pub fn normalised(&self) -> f64 {
        self.innovation / libm::sqrt(self.variance)
    }
}
