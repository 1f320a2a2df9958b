//! What passes over all runs cost, in counted work.

use super::EstimationSession;
use crate::filter::Propagator;
use dynamics::description::Plant;

impl EstimationSession<'_> {
    /// Work of a pass over all runs.
    pub fn pass_work(&self, plant: &Plant, theta: &[f64]) -> f64 {
        self.work_of(plant, theta, &|propagator| propagator.pass_work())
    }

    /// Work of a relinearisation at the priors with its sensitivities and normal equations.
    pub fn round_work(&self) -> f64 {
        let prior = self.prior();
        self.work_of(&self.problem.plant, &prior, &|propagator| propagator.round_work(prior.len()))
    }

    fn work_of(&self, plant: &Plant, theta: &[f64], each: &dyn Fn(&Propagator<'_>) -> f64) -> f64 {
        let of = |run: usize| {
            let instance = self.problem.instance(plant, theta, run);
            Propagator::new(self.problem, run, &instance, &self.timelines[run]).map_or(0.0, |own| each(&own))
        };
        (0..self.timelines.len()).map(of).sum()
    }
}
