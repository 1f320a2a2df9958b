//! Recursive, fixed-memory estimators and the statistics that say whether to believe them.
//!
//! May import: nalgebra, libm, serde. No std, no alloc: every size is a const generic and every loop has a bound
//! that can be stated. Must never know: any spacecraft, sensor, unit of a physical quantity, clock or file.
//!
//! | file | subject |
//! |---|---|
//! | `weighted_least_squares` | errors-in-variables least squares with noise compensation and late weights |
//! | `weighted_pass` | the same in batch: one pass at fixed weights |
//! | `golden_section` | minimum of a function of one variable |
//! | `identifiability` | what data did to a prior: identified, prior kept, not excited |
//! | `instrumental_variables` | rows with noise, instruments without; with itself as instrument, least squares |
//! | `generalised_total_least_squares` | noise covariance of the columns, observation exact |
//! | `total_least_squares` | the seed's estimator, streamed through the Givens factor of `[Y b]` |
//! | `unscented` | square-root unscented Kalman filter; the trait of models in state space |
//! | `consistency` | NEES, NIS, χ² bands; whiteness on block means and by Ljung and Box; score tests |
//! | `cramer_rao` | Fisher information and the bound it implies |
//! | `cusum` | a lasting change of a mean: cumulative sums, jump from a running mean |
//! | `quantiles` | median and quantiles by linear interpolation |
//!
//! *Why no trait for "linear in the parameters"?* Only one estimator here consumes rows, and it takes the row as a
//! value ([`weighted_least_squares::NoisyRow`]); a trait would have a single implementor.

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
pub mod quantiles;
#[cfg(test)]
mod seeded_noise;
pub mod total_least_squares;
pub mod unscented;
pub mod weighted_least_squares;
pub mod weighted_pass;

use serde::{Deserialize, Serialize};

/// Five standard deviations: the gate [`Innovation::test_ratio`] is measured against.
pub const GATE_SIGMAS: f64 = 5.0;

/// What one measurement said before it was used: the raw material of every validation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Innovation {
    /// Measured minus predicted, in the unit of the measurement.
    pub innovation: f64,
    /// Variance the estimator expected of it, its own uncertainty included.
    pub variance: f64,
    /// Part of `variance` that the sensors alone account for; the rest is uncertainty of the estimate.
    pub noise_variance: f64,
    /// `innovation² / (5² variance)`: above one, the measurement lies outside five standard deviations.
    pub test_ratio: f64,
}

impl Innovation {
    pub fn new(innovation: f64, noise_variance: f64, uncertainty: f64) -> Self {
        let variance = noise_variance + uncertainty;
        let test_ratio = innovation * innovation / (GATE_SIGMAS * GATE_SIGMAS * variance);
        Self { innovation, variance, noise_variance, test_ratio }
    }

    /// Share of the expected variance that is the estimate's own uncertainty, relative to the sensors' share.
    pub fn uncertainty_over_noise(&self) -> f64 {
        (self.variance - self.noise_variance) / self.noise_variance
    }

    /// Innovation over its predicted standard deviation: a unit normal number when the model holds.
    pub fn normalised(&self) -> f64 {
        self.innovation / libm::sqrt(self.variance)
    }
}
