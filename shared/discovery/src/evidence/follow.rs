//! Least objective beside a fit: a held number moved, all unknowns following on the linear model.

use dynamics::description::Plant;
use identification::filter::NoiseModel;
use identification::fit::{EstimationSession, Fit, LinearisedProblem};

/// Least objective of a plant near a fit, all unknowns following on the fit's linear model.
pub(super) struct Follow<'a, 'p> {
    pub session: &'a EstimationSession<'p>,
    pub linearised: LinearisedProblem,
    pub theta: &'a [f64],
    pub noise: &'a NoiseModel,
}

impl<'a, 'p> Follow<'a, 'p> {
    /// Beside `fit`.
    pub fn new(session: &'a EstimationSession<'p>, fit: &'a Fit, noise: &'a NoiseModel) -> Self {
        Self { session, linearised: fit.linearised.clone(), theta: &fit.theta, noise }
    }

    /// `−2 ln p` of `plant`, up to a constant of the data. Cost: a pass and the normal equations.
    pub fn least(&mut self, plant: &Plant) -> Option<f64> {
        self.linearised.nu = self.session.innovations(plant, self.theta, &self.linearised.linears, &|_| true)?;
        self.linearised.normal(self.session, self.theta, self.noise, &[])?.least().map(|(least, _)| least)
    }
}
