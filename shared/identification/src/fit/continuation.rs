//! A fit whose start may be far off: disturbances large enough to explain the misfit at first,
//! smaller step by step.
//!
//! A number that the recording tells to a thousandth of its prior (the frequency of a slosh mass
//! over many of its periods) has a likelihood with many maxima, one for each cycle that the model
//! slips. A filter with large disturbances in its model believes its sensors and forgets: its
//! innovations feel a wrong frequency over its memory alone, which makes one maximum of them. As
//! the disturbances shrink the memory grows, and the next fit starts within the cycle that the last
//! one found.

use super::{EstimationSession, Fit, FitError, LinearisedProblem, Rounds, fit};

/// Mean square of the whitened innovations up to which a fit is taken as it is.
const CHI2_PER_SAMPLE_NEAR: f64 = 2.0;
/// Factor between one loudness of the disturbances and the next, and how many there are at most.
const DISTURBANCE_FACTOR: f64 = 10.0;
const STEPS_MAX: usize = 6;
/// Relinearisations under one loudness: the next begins where this comes to.
const ROUNDS_PER_STEP: usize = 3;

/// Fits the plant of `session`'s problem under its stated noise from the priors; where something is
/// left that the noise does not explain, once more by way of larger disturbances, those that the
/// plant states of its actuators among them, and the better of both to its end.
///
/// # Errors
/// Those of [`fit`].
pub fn fit_by_continuation(session: &EstimationSession<'_>, rounds: impl Into<Rounds>) -> Result<Fit, FitError> {
    let rounds = rounds.into();
    let plant = &session.problem.plant;
    let from = |theta: &[f64], rounds: Rounds| fit(session, plant, theta, &session.noise, rounds);
    let direct = from(&session.prior(), rounds.without_more());
    let is_near = direct.as_ref().is_ok_and(|fit| fit.chi2_per_sample < CHI2_PER_SAMPLE_NEAR);
    let has_room = || session.work.allows_step(0.0);
    let approached = if is_near || session.noise.input_sigma.is_empty() || !has_room() {
        None
    } else {
        approached(session).and_then(|theta| from(&theta, rounds.without_more())).ok()
    };
    let best = match (direct, approached) {
        (Ok(direct), Some(approached)) if approached.objective < direct.objective => approached,
        (Err(_), Some(approached)) => approached,
        (direct, _) => direct?,
    };
    if best.converged || rounds.more == 0 || !has_room() { Ok(best) } else { from(&best.theta, rounds).or(Ok(best)) }
}

/// Where fits under disturbances of ever lower variance end, from those on that explain the misfit
/// at the priors.
fn approached(session: &EstimationSession<'_>) -> Result<Vec<f64>, FitError> {
    let plant = &session.problem.plant;
    let mut theta = session.prior();
    let driven = |power: usize| {
        let mut noise = session.noise.clone();
        noise.input_sigma.iter_mut().for_each(|sigma| *sigma *= libm::pow(DISTURBANCE_FACTOR, power as f64));
        noise
    };
    let explains = |power: &usize| {
        if !session.work.allows_step(0.0) {
            return true;
        }
        let noise = driven(*power);
        let linearised = LinearisedProblem::new(session, plant, &theta, &noise).ok();
        let normal = linearised.and_then(|linearised| linearised.normal(session, &theta, &noise, &[]));
        normal.is_some_and(|normal| normal.chi2 < CHI2_PER_SAMPLE_NEAR * session.samples as f64)
    };
    let largest = (1..=STEPS_MAX).find(explains).unwrap_or(STEPS_MAX);
    for power in (1..=largest).rev() {
        let fitted = fit(session, plant, &theta, &driven(power), Rounds::at_most(ROUNDS_PER_STEP))?;
        theta = fitted.theta;
    }
    Ok(theta)
}
