//! How well a plant predicts a recording under one labelling, and the cost of testing it.

use core::cell::Cell;
use std::sync::Arc;

use dynamics::description::Plant;

use channels::{Channel, Recording};
use identification::dot::dot;
use identification::fit::{EstimationSession, Fit, FitError, LinearisedProblem, Rounds, fit, fit_by_continuation};
use identification::problem::{Problem, Unknown};
use identification::work::Work;

use super::{HYPOTHESES_FITTED, RANKING_WORK_SHARE};

/// Mean square of the whitened innovations from which a recording is missed by far: five standard
/// deviations rms. Chosen, no derivation.
pub(super) const MISFIT_MEAN_SQUARE: f64 = 25.0;
/// Prior standard deviations within which the plant's parameters must stay. Chosen, no derivation.
const DIVERGENCE_SIGMA: f64 = 5.0;
/// Bound of the parameters [prior standard deviations]; a fit that ends there has diverged.
const PARAMETER_BOUND_SIGMA: f64 = 1.01 * DIVERGENCE_SIGMA;
/// Relinearisations of a fit.
const PREDICTION_ROUNDS: Rounds = Rounds::at_most(4);
/// Cost of a fit by continuation in plain fits.
const CONTINUATION_COST: f64 = 4.0;

pub(super) struct Prediction {
    /// Mean square of the whitened innovations.
    pub mean_square: f64,
    /// Number of innovations.
    pub samples: usize,
    /// Largest distance of a parameter from its prior [standard deviations].
    divergence_sigma: f64,
    unknowns: Vec<Unknown>,
    theta: Vec<f64>,
}

impl Prediction {
    /// The plant predicts the recording with plausible parameters: mean square below
    /// [`MISFIT_MEAN_SQUARE`], all parameters within [`DIVERGENCE_SIGMA`] prior standard
    /// deviations.
    pub fn is_near(&self) -> bool {
        self.mean_square < MISFIT_MEAN_SQUARE && self.divergence_sigma < DIVERGENCE_SIGMA
    }

    /// Lower bound for a recording of so many samples that begins like this one: no parameter
    /// values miss less of the whole than of its part.
    pub fn of_more(self, samples: usize) -> Self {
        let mean_square = self.mean_square * self.samples as f64 / samples as f64;
        Self { mean_square, samples, ..self }
    }
}

/// Parameters of the plant that a recording is predicted with, never further off than
/// [`Prediction::is_near`] allows.
#[derive(Clone, Copy)]
pub(super) enum ParameterChoice<'a> {
    Priors,
    /// One round of a fit from the priors.
    Step,
    /// A fit from the priors.
    Fitted,
    /// A fit by continuation through larger disturbances, where that is better.
    ByContinuation,
    /// A fit that starts at the parameters of another prediction, at the priors where it has none
    /// of that name.
    From(&'a Prediction),
}

impl ParameterChoice<'_> {
    /// Class of equal cost.
    fn kind(self) -> usize {
        match self {
            Self::Priors => 0,
            Self::Step => 1,
            Self::Fitted => 2,
            Self::ByContinuation => 3,
            Self::From(_) => 4,
        }
    }
}

/// Evaluates a plant, and counts the work.
pub(super) struct PlantEvaluator<'a> {
    pub plant: &'a Plant,
    pub work: &'a Arc<Work>,
    /// Work of the most expensive evaluation so far of each kind, for each sample.
    dearest: [Cell<f64>; 5],
}

impl<'a> PlantEvaluator<'a> {
    /// Evaluations of `plant`, counted in `work`.
    pub fn new(plant: &'a Plant, work: &'a Arc<Work>) -> Self {
        Self { plant, work, dearest: Default::default() }
    }

    /// The work allows one more evaluation as expensive as the most expensive of its kind;
    /// otherwise `what` is recorded as omitted.
    pub fn affords(&self, recording: &Recording, numbers: ParameterChoice<'_>, what: &'static str) -> bool {
        self.work.allows(self.cost(recording, numbers), what)
    }

    /// The same within the bound `until` on the work spent.
    pub fn affords_until(&self, until: f64, recording: &Recording, numbers: ParameterChoice<'_>) -> bool {
        self.work.spent() + self.cost(recording, numbers) <= until
    }

    /// Plans the evaluation of `many` hypotheses after the plant itself was fitted: from the
    /// priors and after a step within the share of ranking, then complete fits of a few.
    pub fn plan_hypotheses(&self, recording: &Recording, many: usize) {
        let cost = |how: ParameterChoice<'_>| self.cost(recording, how);
        let (fit, pass) = (cost(ParameterChoice::Fitted), cost(ParameterChoice::Priors));
        let room = self.work.until(1.0) - self.work.spent();
        let ranking = (many as f64 * 2.0 * pass).min(RANKING_WORK_SHARE * room);
        let fits = HYPOTHESES_FITTED as f64 * (1.0 + CONTINUATION_COST) * fit;
        self.work.plan_now((ranking + fits).min(room));
    }

    /// Number of readings of the plant's sensors.
    pub fn samples(&self, recording: &Recording) -> usize {
        let is_read = |channel: &&Channel| self.plant.sensors.iter().any(|sensor| sensor.name == channel.name);
        recording.channels.iter().filter(is_read).map(|channel| channel.value.len()).sum()
    }

    fn cost(&self, recording: &Recording, numbers: ParameterChoice<'_>) -> f64 {
        let each = |numbers: ParameterChoice<'_>| self.dearest[numbers.kind()].get();
        let each = match numbers {
            ParameterChoice::ByContinuation => each(numbers).max(CONTINUATION_COST * each(ParameterChoice::Fitted)),
            _ => each(numbers),
        };
        each * self.samples(recording) as f64
    }

    /// Prediction by a fit by continuation, or from the priors where the work does not allow that;
    /// `None`, and `what` recorded as omitted, where it allows neither.
    pub fn fitted(&self, recording: &Recording, what: &'static str) -> Option<Option<Prediction>> {
        let room = self.work.until(1.0);
        let far = self.affords_until(room, recording, ParameterChoice::ByContinuation);
        let how = if far { ParameterChoice::ByContinuation } else { ParameterChoice::Fitted };
        self.affords(recording, how, what).then(|| self.predicted(recording, how))
    }

    /// `None` where the filter fails.
    pub fn predicted(&self, recording: &Recording, numbers: ParameterChoice<'_>) -> Option<Prediction> {
        let mut problem = Problem::new(self.plant, core::slice::from_ref(recording), &[]).ok()?;
        confine(&mut problem.unknowns);
        let before = self.work.spent();
        let session = EstimationSession::counted(&problem, 1, self.work.clone());
        let found = session.ok().and_then(|session| predicted(&session, numbers));
        let each = (self.work.spent() - before) / self.samples(recording).max(1) as f64;
        let dearest = &self.dearest[numbers.kind()];
        dearest.set(dearest.get().max(each));
        found
    }
}

/// Bounds the parameters to the distance at which they count as diverged.
fn confine(unknowns: &mut [Unknown]) {
    for unknown in unknowns {
        unknown.low = unknown.low.max(unknown.prior - PARAMETER_BOUND_SIGMA * unknown.sigma);
        unknown.high = unknown.high.min(unknown.prior + PARAMETER_BOUND_SIGMA * unknown.sigma);
    }
}

fn predicted(session: &EstimationSession<'_>, numbers: ParameterChoice<'_>) -> Option<Prediction> {
    let (plant, prior) = (&session.problem.plant, session.prior());
    let fitted = |fit: Result<Fit, FitError>| fit.ok().map(|fit| (fit.chi2_per_sample, fit.theta));
    let from = |theta: &[f64], rounds| fitted(fit(session, plant, theta, &session.noise, rounds));
    let (mean_square, theta) = match numbers {
        ParameterChoice::Priors => {
            let linearised = LinearisedProblem::new(session, plant, &prior, &session.noise).ok()?;
            let (r, _) = linearised.whitened(session, &session.noise, &[])?;
            Some((dot(&r, &r) / r.len().max(1) as f64, prior))
        }
        ParameterChoice::Step => from(&prior, Rounds::at_most(1)),
        ParameterChoice::Fitted => from(&prior, PREDICTION_ROUNDS),
        ParameterChoice::ByContinuation => fitted(fit_by_continuation(session, PREDICTION_ROUNDS)),
        ParameterChoice::From(other) => from(&session.start_from(&other.unknowns, &other.theta), PREDICTION_ROUNDS),
    }?;
    let (samples, unknowns) = (session.samples, session.problem.unknowns.clone());
    let divergence_sigma = divergence_sigma(&unknowns, &theta);
    mean_square.is_finite().then_some(Prediction { mean_square, samples, divergence_sigma, unknowns, theta })
}

fn divergence_sigma(unknowns: &[Unknown], theta: &[f64]) -> f64 {
    let off = theta.iter().zip(unknowns).map(|(theta, unknown)| ((theta - unknown.prior) / unknown.sigma).abs());
    off.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{plant, recording};

    #[test]
    fn a_parameter_that_ends_at_its_bound_counts_as_diverged_whatever_the_decimals() {
        let nominal = plant("drive_rig");
        let problem = Problem::new(&nominal, &[recording(&nominal, 5, 0.1)], &[]).expect("it is its own");
        for k in 1..400 {
            let (prior, sigma) = (f64::from(k) * 0.1, f64::from(k % 23 + 1) * 1e-3);
            let free = (f64::NEG_INFINITY, f64::INFINITY);
            let unknown = Unknown { prior, sigma, low: free.0, high: free.1, ..problem.unknowns[0].clone() };
            let mut all = [unknown];
            confine(&mut all);
            for bound in [all[0].low, all[0].high] {
                assert!(divergence_sigma(&all, &[bound]) > DIVERGENCE_SIGMA, "{prior} {sigma}");
            }
        }
    }

    #[test]
    fn the_misfit_of_a_part_bounds_that_of_the_whole_from_below() {
        let nominal = plant("drive_rig");
        let mut rubbed = nominal.clone();
        rubbed.add_effect("joint_coulomb", &"joint:drive".parse().unwrap(), &[("force", 0.5)]).unwrap();
        let whole = recording(&rubbed, 6, 2.0);
        let work = Arc::new(Work::default());
        let evaluator = PlantEvaluator::new(&nominal, &work);
        let part =
            evaluator.predicted(&whole.beginning(0.3), ParameterChoice::ByContinuation).expect("it is predicted");
        let all = evaluator.predicted(&whole, ParameterChoice::From(&part)).expect("it is predicted");
        let (share, least) = (part.samples as f64 / all.samples as f64, part.of_more(all.samples));
        assert!((0.25..0.35).contains(&share) && least.samples == all.samples);
        assert!(!least.is_near() && least.mean_square < all.mean_square, "{} {}", least.mean_square, all.mean_square);
    }
}
