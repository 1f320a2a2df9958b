//! Parameters of one plant, estimated on all recordings at once by prediction errors, its noise
//! given.
//!
//! Levenberg–Marquardt on whitened innovations with frozen gains, priors as further residuals;
//! gains are computed again at each relinearisation. Who estimates the noise, too, does so apart, on
//! the linear model.

pub mod bounded;
mod continuation;
pub mod estimation_session;
pub mod linearised_problem;
mod normal;
mod parallel;
mod white;

pub use continuation::fit_by_continuation;
pub use estimation_session::{EstimationSession, is_mass};
pub use linearised_problem::LinearisedProblem;
pub use normal::{Normal, prior_chi2};
pub use parallel::parallel;
pub use white::White;

use crate::filter::NoiseModel;
use dynamics::description::Plant;
use estimation::levenberg_marquardt::Damping;

/// A fitted plant.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Description with the effects it was fitted with; parameters stand at their priors, estimates
    /// in `theta`.
    pub plant: Plant,
    pub theta: Vec<f64>,
    /// Posterior standard deviation, as the noise model has it.
    pub sigma: Vec<f64>,
    /// Share of the prior's standard deviation that is left.
    pub ratio: Vec<f64>,
    /// `−2 ln p` up to a constant of the data.
    pub objective: f64,
    pub noise: NoiseModel,
    /// Whitened innovations' mean square.
    pub chi2_per_sample: f64,
    pub converged: bool,
    pub iterations: usize,
    pub linearised: LinearisedProblem,
}

/// A fit that did not work out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    #[error("the plant cannot predict this recording: {0}")]
    Filter(String),
    #[error("the covariance of the innovations is not positive; the noise that is stated may be zero")]
    NotPositive,
}

/// Share of a prior's standard deviation above which a parameter counts as not found: the recording
/// then holds less than `1/0.98² − 1` = 4 % of the information that the prior holds.
pub const NOT_FOUND_RATIO: f64 = 0.98;
/// Decrease of `−2 ln p` that ends the iteration, at noise of the size that the residuals have: a
/// tenth of a standard error.
const CONVERGED: f64 = 1e-2;
/// Share of the promised decrease above which sensitivities serve for the next step, too.
pub(crate) const AS_PROMISED: f64 = 0.7;
/// Relinearisations beyond those asked for, as long as each takes this share off the sum of
/// squares: a start far off is no minimum.
const ROUNDS_MORE: usize = 14;
const FAR: f64 = 0.02;
/// Damping from which a step is too short to be worth a trial.
pub(crate) const DAMPING_MAX: f64 = 1e3;
/// Steps with one linearisation.
pub(crate) const INNER_STEPS: usize = 3;

/// Relinearisations of a fit.
#[derive(Clone, Copy, Debug)]
pub struct Rounds {
    most: usize,
    /// So many more, as long as each takes its share off the sum of squares.
    more: usize,
}

impl Rounds {
    /// No more than these wherever it started: steps towards the minimum, not the minimum.
    pub const fn at_most(most: usize) -> Self {
        Self { most, more: 0 }
    }

    /// The same however far off the start was.
    #[must_use]
    pub const fn without_more(self) -> Self {
        Self::at_most(self.most)
    }
}

/// So many, some more where the start was far off.
impl From<usize> for Rounds {
    fn from(most: usize) -> Self {
        Self { most, more: ROUNDS_MORE }
    }
}

/// Fits `plant` from `theta` under `noise` with at most `rounds` relinearisations, as far as the
/// session's work allows its steps: one set of sensitivities in any case, another one where it ends
/// no lower than at a point that a linearisation was made at before, the start among them, which is
/// where it ends then.
///
/// # Errors
/// The first linearisation fails; later failures end the iteration with what is there.
pub fn fit(
    session: &EstimationSession<'_>,
    plant: &Plant,
    theta: &[f64],
    noise: &NoiseModel,
    rounds: impl Into<Rounds>,
) -> Result<Fit, FitError> {
    let rounds = rounds.into();
    let mut theta = theta.to_vec();
    let mut linearised = LinearisedProblem::new(session, plant, &theta, noise)?;
    let (mut converged, mut iterations) = (false, 0);
    let mut damping = Damping::on_failure();
    let mut steps = Steps::new(session);
    // steps descend along one trajectory; about the next one the objective may be higher
    let mut least: Option<(f64, Vec<f64>)> = None;
    let mut is_moved = false;
    for round in 0..rounds.most + rounds.more {
        let (mut total, mut enough, mut far) = (0.0, CONVERGED, f64::INFINITY);
        let mut stale = true;
        for inner in 0..INNER_STEPS {
            if !steps.has_room() {
                break;
            }
            iterations += 1;
            if stale {
                linearised.take_jacobian(session, plant, &theta);
            }
            let normal = linearised.normal(session, &theta, noise, &[]).ok_or(FitError::NotPositive)?;
            if inner == 0 && least.as_ref().is_none_or(|(least, _)| normal.objective < *least) {
                least = Some((normal.objective, theta.clone()));
            }
            let Some((step, predicted)) = normal.step(session, &theta, damping.value()) else { break };
            // a plant that is far off moves for ever in units of a noise that it does not reach
            enough = CONVERGED * (normal.chi2 / linearised.samples().max(1) as f64).max(1.0);
            far = FAR * normal.chi2;
            if predicted < enough && !linearised.has_jacobian(&theta) {
                stale = true;
                continue;
            }
            if predicted < enough {
                converged = true;
                break;
            }
            let (moved, gained) = search(session, plant, &mut linearised, &theta, &step, noise, normal.objective);
            if gained <= 0.0 && !linearised.has_jacobian(&theta) {
                stale = true;
                continue;
            }
            if gained <= 0.0 {
                damping.failed();
                if damping.value() > DAMPING_MAX {
                    break;
                }
                continue;
            }
            damping.taken();
            theta = moved;
            total += gained;
            stale = gained < AS_PROMISED * predicted;
            if gained < enough {
                converged = true;
                break;
            }
        }
        is_moved = total > enough;
        let worth = if round + 1 < rounds.most { enough } else { far };
        let goes_on = total > worth && steps.has_room();
        match goes_on.then(|| LinearisedProblem::new(session, plant, &theta, noise)) {
            Some(Ok(fresh)) => {
                linearised = fresh.with_steps_of(&linearised);
                (converged, is_moved) = (false, false);
            }
            _ => break,
        }
    }
    let end = finish(session, plant, theta, noise, (linearised, is_moved), (converged, iterations));
    let reached = end.as_ref().map_or(f64::INFINITY, |end| end.objective);
    match least {
        Some((least, at)) if least + CONVERGED < reached => {
            let began = LinearisedProblem::new(session, plant, &at, noise)?;
            finish(session, plant, at, noise, (began, false), (false, iterations))
        }
        _ => end,
    }
}

/// Steps of a fit within the work: as dear as the dearest so far.
struct Steps<'a> {
    work: &'a crate::work::Work,
    at: Option<f64>,
    dearest: f64,
}

impl<'a> Steps<'a> {
    fn new(session: &'a EstimationSession<'_>) -> Self {
        Self { work: &session.work, at: None, dearest: 0.0 }
    }

    /// There is room for a further step; for a first one in any case.
    fn has_room(&mut self) -> bool {
        let spent = self.work.spent();
        let Some(before) = self.at.replace(spent) else { return true };
        self.dearest = self.dearest.max(spent - before);
        self.work.allows_step(self.dearest)
    }
}

/// Objective, Jacobian and posterior at `theta`, on a fresh linearisation where steps since the
/// last one gained more than is worth a step.
fn finish(
    session: &EstimationSession<'_>,
    plant: &Plant,
    theta: Vec<f64>,
    noise: &NoiseModel,
    (linearised, is_moved): (LinearisedProblem, bool),
    (converged, iterations): (bool, usize),
) -> Result<Fit, FitError> {
    let fresh = |linearised: &LinearisedProblem| {
        LinearisedProblem::new(session, plant, &theta, noise).map(|fresh| fresh.with_steps_of(linearised))
    };
    let is_here = linearised.theta == theta && !is_moved;
    let mut linearised = if is_here { linearised } else { fresh(&linearised).unwrap_or(linearised) };
    linearised.take_jacobian(session, plant, &theta);
    let normal = linearised.normal(session, &theta, noise, &[]).ok_or(FitError::NotPositive)?;
    let sigma = normal.sigmas(session);
    let ratio = sigma.iter().zip(&session.problem.unknowns).map(|(s, u)| s / u.sigma).collect();
    let within = theta.iter().zip(&session.problem.unknowns).map(|(t, u)| t.clamp(u.low, u.high)).collect();
    Ok(Fit {
        plant: plant.clone(),
        theta: within,
        sigma,
        ratio,
        objective: normal.objective,
        noise: noise.clone(),
        chi2_per_sample: normal.chi2 / linearised.samples().max(1) as f64,
        converged,
        iterations,
        linearised,
    })
}

/// Halves the step until the objective falls; returns where and by how much, zero where it does
/// not.
fn search(
    session: &EstimationSession<'_>,
    plant: &Plant,
    linearised: &mut LinearisedProblem,
    theta: &[f64],
    step: &[f64],
    noise: &NoiseModel,
    before: f64,
) -> (Vec<f64>, f64) {
    let mut share = 1.0;
    for _ in 0..4 {
        let moved: Vec<f64> = (theta.iter().zip(step).zip(&session.problem.unknowns))
            .map(|((t, s), u)| (t + share * s).clamp(u.low, u.high))
            .collect();
        let nu = session.innovations(plant, &moved, &linearised.linears, &|_| true);
        let after = nu.as_ref().and_then(|nu| linearised.objective(session, nu, &moved, noise));
        if let (Some(nu), Some(after)) = (nu, after)
            && after < before
        {
            linearised.nu = nu;
            linearised.theta.clone_from(&moved);
            return (moved, before - after);
        }
        share *= 0.4;
    }
    (theta.to_vec(), 0.0)
}

#[cfg(test)]
mod tests;
