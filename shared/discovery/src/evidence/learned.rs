//! What held-out data say of the numbers of a set: the fitted recordings leave each of them with a
//! width, within which these data may move it.
//!
//! ```text
//! ln p(D₂|D₁) = ln ∫ p(D₂|θ) p(θ|D₁) = ln p(D₂|θ*) − ½ xᵀ P x − ½ ln det M + ½ ln det P
//! P: information of the fitted recordings, x = θ* − θ̂₁, M = J₂ᵀJ₂ + P       (k × k, k numbers)
//! ```
//!
//! θ* maximises the first two terms, and θ̂₁ is where these data were predicted from: numbers that
//! the fitted recordings do not tell stand where D₂ has them. With the numbers held there a right
//! law loses ½ tr(J₂ᵀJ₂ P⁻¹): many nats where D₂ tells more than D₁, which speak neither against
//! the law nor for its rival.

use super::horizon::Horizons;
use super::model::{Ground, Model, session_of};
use super::noise::Linearly;
use super::temper::Instants;
use super::timing::as_seen;
use identification::filter::NoiseModel;
use identification::fit::{EstimationSession, LinearisedProblem};
use identification::problem::{Problem, Unknown};
use nalgebra::{Cholesky, DMatrix, DVector};

/// Held-out data at the numbers that the fitted recordings leave: those of the held-out recordings
/// alone with their values, the noise, and the log-likelihood.
pub(super) struct At<'a> {
    pub own: (&'a [Unknown], &'a [f64]),
    pub noise: &'a NoiseModel,
    pub log_likelihood: f64,
}

/// Steps to θ*, how often one is shortened, and the gain in nats that is not worth one: a tenth of
/// the nat that two models may differ by.
const HELD_OUT_STEPS_MAX: usize = 5;
const HELD_OUT_SHORTENINGS_MAX: usize = 3;
const HELD_OUT_STEP_GAIN_MIN: f64 = 0.1;

/// `ln p(D₂|D₁) − ln p(D₂|θ̂₁)`, and the instants at θ*; `None` where `other` cannot be linearised.
///
/// Cost: a pass for each number and step.
pub(super) fn learned(
    ground: Ground<'_>,
    (other, blank): (&Problem, &EstimationSession<'_>),
    model: &Model,
    at: &At<'_>,
) -> Option<(f64, Instants)> {
    let problem = about_estimates(other, model);
    let begun = begun(&problem, at.own);
    let session = session_of(Ground { session: blank }, &model.set, &problem, &begun)?;
    let precision = known_precision(ground, model, &problem.unknowns)?;
    let more = &precision - DMatrix::identity(precision.nrows(), precision.nrows());
    let price = |x: &DVector<f64>| 0.5 * x.dot(&(&precision * x));
    let unknowns = &problem.unknowns;
    let off = |theta: &[f64]| DVector::from_fn(theta.len(), |i, _| (theta[i] - begun[i]) / unknowns[i].sigma);
    let from_prior =
        |theta: &[f64]| DVector::from_fn(theta.len(), |i, _| (theta[i] - unknowns[i].prior) / unknowns[i].sigma);
    let there = |theta: Vec<f64>| {
        let linearised = LinearisedProblem::new(&session, &problem.plant, &theta, at.noise).ok()?;
        let terms = Instants::new(&session, &linearised.linears, at.noise)?;
        let value = terms.sum() - price(&off(&theta));
        Some((value, theta, linearised, terms)).filter(|(value, ..)| value.is_finite())
    };
    let mut best = there(begun.clone())?;
    let log_det = |factor: &Cholesky<f64, nalgebra::Dyn>| factor.l_dirty().diagonal().map(libm::log).sum();
    let prior = log_det(&Cholesky::new(precision.clone())?);
    let mut width = 0.0;
    for _ in 0..HELD_OUT_STEPS_MAX {
        let (value, theta, linearised, _) = &mut best;
        linearised.take_jacobian(&session, &problem.plant, theta);
        let linear = Linearly { session: &session, linearised, theta, extra: &[], room: &[] };
        let normal = linear.normal(at.noise)?;
        let factor = Cholesky::new(&normal.matrix + &more)?;
        width = prior - log_det(&factor);
        // the pull of the priors is in `right` already: P's takes its place
        let slope = &normal.right + from_prior(theta) - &precision * off(theta);
        let step = factor.solve(&slope);
        if 0.5 * step.dot(&slope) < HELD_OUT_STEP_GAIN_MIN {
            break;
        }
        let moved = |share: f64| {
            let all = unknowns.iter().zip(&*theta).zip(step.iter());
            there(all.map(|((u, at), step)| (at + share * step * u.sigma).clamp(u.low, u.high)).collect())
        };
        let least = *value + HELD_OUT_STEP_GAIN_MIN;
        let tried = (0..HELD_OUT_SHORTENINGS_MAX).filter_map(|k| moved(libm::pow(0.3, k as f64)));
        let Some(next) = tried.into_iter().find(|next| next.0 > least) else { break };
        best = next;
    }
    Some((best.0 + width - at.log_likelihood, best.3))
}

/// `horizons` of `model` with what its shared parameters give a distance: with C = P⁻¹ = L Lᵀ (k ×
/// k) the squares of the columns of J L. Numbers that were fitted to `other` itself give none.
pub(super) fn with_parameters(
    horizons: Horizons,
    ground: Ground<'_>,
    (other, blank): (&Problem, &EstimationSession<'_>),
    model: &Model,
    at: &At<'_>,
) -> Option<Horizons> {
    let problem = about_estimates(other, model);
    let begun = begun(&problem, at.own);
    let session = session_of(Ground { session: blank }, &model.set, &problem, &begun)?;
    let mut linearised = LinearisedProblem::new(&session, &problem.plant, &begun, at.noise).ok()?;
    linearised.take_jacobian(&session, &problem.plant, &begun);
    let is_shared = |i: &usize| !at.own.0.iter().any(|own| own.name == problem.unknowns[*i].name);
    let shared: Vec<usize> = (0..problem.unknowns.len()).filter(is_shared).collect();
    let covariance = Cholesky::new(known_precision(ground, model, &problem.unknowns)?)?.inverse();
    let part = DMatrix::from_fn(shared.len(), shared.len(), |i, j| covariance[(shared[i], shared[j])]);
    let root = Cholesky::new(part)?.unpack();
    let column = |axis: usize| {
        let mut sum = vec![0.0; linearised.nu.len()];
        for (k, place) in shared.iter().enumerate().skip(axis) {
            sum.iter_mut().zip(&linearised.jacobian[*place]).for_each(|(sum, c)| *sum += c * root[(k, axis)]);
        }
        sum
    };
    let columns: Vec<Vec<f64>> = (0..shared.len()).map(column).collect();
    horizons.with_parameters(&session, &linearised.linears, at.noise, &columns)
}

/// `other` with the plant of `model`, its shared numbers about their estimates.
fn about_estimates(other: &Problem, model: &Model) -> Problem {
    let mut plant = model.problem.plant.clone();
    let unknowns = &model.problem.unknowns;
    plant.visit_quantities(&mut |name, _, quantity| {
        let own = unknowns.iter().position(|unknown| unknown.parameter == name && unknown.recording.is_none());
        if let Some(at) = own {
            (quantity.value, quantity.sigma) = (model.fit.theta[at], Some(unknowns[at].sigma));
        }
    });
    as_seen(other.with_plant(&plant), &model.set)
}

/// Where `other` was predicted: estimates, and what it alone was fitted to.
fn begun(problem: &Problem, (unknowns, theta): (&[Unknown], &[f64])) -> Vec<f64> {
    let own = |unknown: &Unknown| unknowns.iter().position(|other| other.name == unknown.name);
    problem.unknowns.iter().map(|unknown| own(unknown).map_or(unknown.prior, |at| theta[at])).collect()
}

/// The information of the fitted recordings about `unknowns`, in prior standard deviations: that of
/// the prior for numbers of other recordings.
fn known_precision(ground: Ground<'_>, model: &Model, unknowns: &[Unknown]) -> Option<DMatrix<f64>> {
    let session = model.session(ground)?;
    let (linearised, theta) = (&model.fit.linearised, &model.fit.theta[..]);
    let linear = Linearly { session: &session, linearised, theta, extra: &[], room: &[] };
    let covariance = linear.normal(&model.noise)?.factor()?.inverse();
    let all = &model.problem.unknowns;
    let place = |own: &Unknown| all.iter().position(|other| other.name == own.name && other.recording.is_none());
    let shared: Vec<(usize, usize)> =
        unknowns.iter().enumerate().filter_map(|(i, unknown)| Some((i, place(unknown)?))).collect();
    let part = DMatrix::from_fn(shared.len(), shared.len(), |i, j| covariance[(shared[i].1, shared[j].1)]);
    let inverse = Cholesky::new(part)?.inverse();
    let mut precision = DMatrix::identity(unknowns.len(), unknowns.len());
    for (i, (row, _)) in shared.iter().enumerate() {
        for (j, (column, _)) in shared.iter().enumerate() {
            precision[(*row, *column)] = inverse[(i, j)];
        }
    }
    Some(precision)
}

#[cfg(test)]
mod tests {
    use crate::diagnose::{Options, nominal};
    use crate::evidence::bare;
    use crate::evidence::model::Ground;
    use crate::evidence::predict::predicted;
    use crate::synthetic::{plant, problem, recording};
    use identification::fit::EstimationSession;

    #[test]
    fn two_recordings_have_one_evidence_whichever_of_them_is_held_out() {
        let plant = plant("pendulum");
        let [short, long] = [(5, 1.5), (6, 8.0)].map(|(seed, s)| problem(&plant, recording(&plant, seed, s)));
        let whole = |[fitted, other]: [&identification::problem::Problem; 2]| {
            let session = EstimationSession::new(fitted, 1).unwrap();
            let stated = nominal(&session, &Options::default()).unwrap();
            let model = bare(&session, &stated).unwrap();
            let held_out = predicted(Ground { session: &session }, other, &model, &model).unwrap();
            model.log_marginal + held_out.log_evidence()
        };
        let [first, second] = [whole([&short, &long]), whole([&long, &short])];
        // Laplace's errors; with the numbers held where they were predicted from it is 1.9 nats
        assert!((first - second).abs() < 1.0, "{first} {second}");
    }
}
