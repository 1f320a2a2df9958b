//! Sensitivities to all unknowns in one pass along the linear model's own trajectory.

use super::super::estimation_session::EstimationSession;
use super::super::parallel;
use super::LinearisedProblem;
use crate::filter::{Moved, Propagator, sensitivities};
use dynamics::description::Plant;

/// Step of the differences [prior standard deviations]: residuals are polynomials in most numbers,
/// so curvature leaves as much, and rounding, 1e-16 of terms of the same size, 1e-11.
const PRIOR_STEP: f64 = 1e-5;

impl LinearisedProblem {
    /// [`LinearisedProblem::take_jacobian`] in one pass a run; what that pass cannot tell of an
    /// unknown takes a pass of its own.
    pub(super) fn take_along(&mut self, session: &EstimationSession<'_>, plant: &Plant, theta: &[f64]) {
        let runs = parallel(self.linears.len(), session.threads, |run| self.run_along(session, plant, theta, run));
        let told = |i: usize| runs.iter().all(|columns| columns[i].is_some());
        let taken = parallel(theta.len(), session.threads, |i| {
            if !told(i) {
                return self.sensitivity(session, plant, theta, i);
            }
            let whole = runs.iter().flat_map(|columns| columns[i].iter().flatten().copied()).collect();
            (whole, self.steps[i])
        });
        (self.jacobian, self.steps) = taken.into_iter().unzip();
    }

    /// `∂ŷ/∂θ` of one run, of every unknown that this pass tells.
    fn run_along(
        &self,
        session: &EstimationSession<'_>,
        plant: &Plant,
        theta: &[f64],
        run: usize,
    ) -> Vec<Option<Vec<f64>>> {
        let (problem, linear) = (session.problem, &self.linears[run]);
        let begun = |theta: &[f64]| {
            let instance = problem.instance(plant, theta, run);
            let mut propagator = Propagator::new(problem, run, &instance, &session.timelines[run]).ok()?;
            let same: Vec<usize> = (0..linear.layout.tangent).collect();
            // slopes at events say nothing of a step that is stiff
            let alike = propagator.layout == linear.layout && propagator.finer() == 1;
            alike.then(|| {
                propagator.begin_as(linear, &same);
                propagator
            })
        };
        let mut found = vec![None; theta.len()];
        let Some(mut nominal) = begun(theta) else { return found };
        let (mut places, mut moved) = (Vec::new(), Vec::new());
        for (i, unknown) in problem.unknowns.iter().enumerate() {
            if !unknown.concerns(&problem.runs[run]) {
                found[i] = Some(vec![0.0; linear.nu.len()]);
                continue;
            }
            // away from the edge of what is possible
            let step = if theta[i] + PRIOR_STEP * unknown.sigma > unknown.high { -PRIOR_STEP } else { PRIOR_STEP };
            let mut there = theta.to_vec();
            there[i] += step * unknown.sigma;
            if let Some(one) = begun(&there).and_then(|propagator| Moved::new(&nominal, propagator, step)) {
                places.push(i);
                moved.push(one);
            }
        }
        let before = nominal.work();
        let columns = sensitivities(&mut nominal, linear, &mut moved, session.parts);
        session.work.add(nominal.work() - before + moved.iter().map(Moved::work).sum::<f64>());
        for (i, column) in places.into_iter().zip(columns.into_iter().flatten()) {
            found[i] = Some(column);
        }
        found
    }
}

#[cfg(test)]
mod tests;
