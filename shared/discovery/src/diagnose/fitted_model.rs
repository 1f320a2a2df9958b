//! A plant with its problem, its fit and its noise.

use dynamics::description::Plant;
use identification::filter::NoiseModel;
use identification::fit::Fit;
use identification::problem::Problem;

/// A fitted plant.
pub(crate) struct FittedModel {
    pub plant: Plant,
    pub problem: Problem,
    pub fit: Fit,
    pub noise: NoiseModel,
}

impl FittedModel {
    /// The plant of `fit`.
    pub fn new(problem: Problem, fit: Fit, noise: NoiseModel) -> Self {
        Self { plant: fit.plant.clone(), problem, fit, noise }
    }
}
