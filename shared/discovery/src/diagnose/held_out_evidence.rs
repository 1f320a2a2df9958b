//! Prediction of data that were not fitted: another recording, else parts of this one predicted
//! from the others.

use super::report::{HeldOutKind, Overlay};
use super::{FittedModel, Options, figures};
use crate::score::event_of_sample;
use dynamics::description::{Plant, Quantity, Scope};
use identification::filter::{NoiseModel, gains};
use identification::fit::bounded::bounded;
use identification::fit::{EstimationSession, Fit, LinearisedProblem, NOT_FOUND_RATIO, fit};
use identification::held_out::{BLOCK_S, ChannelFit, Gain, Predictor, block_s, blocks, free_run, gain};
use identification::problem::{Problem, Unknown};

/// Folds of a recording, each predicted from the others, where no other recording is given. More
/// folds leave less out of each fit; chosen, no derivation.
const FOLDS: usize = 8;
/// Relinearisations of the fit of the parameters that belong to one recording.
const OWN_ROUNDS: usize = 3;
/// Prior standard deviations within which these parameters may always move.
const OWN_PARAMETER_SIGMA_MIN: f64 = 3.0;

/// Evidence of held-out data: kind, free runs before and after, gain, and figures.
pub(crate) struct HeldOutEvidence {
    pub kind: HeldOutKind,
    pub before: Vec<ChannelFit>,
    pub after: Vec<ChannelFit>,
    pub gain: Option<Gain>,
    pub compare: Vec<ChannelFit>,
    pub overlays: Vec<Overlay>,
}

/// Of `best` beside the nominal plant, on another recording or on blocks of the fitted ones.
pub(crate) fn held_out(
    problem: &Problem,
    session: &EstimationSession<'_>,
    stated: &Fit,
    best: &FittedModel,
    nothing: bool,
    options: &Options,
) -> HeldOutEvidence {
    let nominal = Predictor { plant: &stated.plant, theta: &stated.theta, noise: &session.noise };
    let compare = free_run(session, nominal);
    let none = |compare| {
        let (before, after, overlays) = (Vec::new(), Vec::new(), Vec::new());
        HeldOutEvidence { kind: HeldOutKind::None, before, after, gain: None, compare, overlays }
    };
    if nothing {
        return none(compare);
    }
    let evidence = match &options.held_out {
        Some(other) => on_recording(other, (session, stated), best, options),
        None => on_blocks(problem, session, stated, best, options),
    };
    match evidence {
        Some((kind, before, after, gain, overlays)) => {
            let gain = gain.map(|gain| gain.beside_free_runs(&before, &after));
            HeldOutEvidence { kind, before, after, gain, compare, overlays }
        }
        None => none(compare),
    }
}

/// Time and log-likelihood of every instant.
type Terms = Vec<(f64, f64)>;
type Free = Vec<ChannelFit>;
type HeldOutParts = (HeldOutKind, Free, Free, Option<Gain>, Vec<Overlay>);

/// The plant without and with the effects, each with its session, as predictors of a recording that
/// neither was fitted to.
struct Pair<'a> {
    before: (&'a EstimationSession<'a>, Predictor<'a>),
    after: (&'a EstimationSession<'a>, Predictor<'a>),
}

/// Shared parameters are frozen as fitted. Parameters of single recordings and segments, and
/// nominal parameters that the fitted recordings did not determine, are fitted on the others, on
/// both sides alike.
fn predicting<T>(
    other: &Problem,
    (session, stated): (&EstimationSession<'_>, &Fit),
    best: &FittedModel,
    options: &Options,
    look: impl FnOnce(Pair<'_>) -> Option<T>,
) -> Option<T> {
    let fitted = [(&session.problem.unknowns[..], &stated.theta[..]), (&best.problem.unknowns, &best.fit.theta)];
    let pairs = session.problem.unknowns.iter().zip(&stated.ratio);
    let is_unseen = |(u, ratio): &(&Unknown, &f64)| **ratio > NOT_FOUND_RATIO && !u.parameter.starts_with("effect.");
    let unseen: Vec<&str> = pairs.filter(is_unseen).map(|(u, _)| &*u.name).collect();
    let show = |plant: &Plant, own: (&[Unknown], &[f64])| {
        within_reach(other.with_plant(&frozen(plant, own, &unseen)), &fitted)
    };
    let (before_problem, after_problem) = (show(&stated.plant, fitted[0]), show(&best.plant, fitted[1]));
    let before = EstimationSession::counted(&before_problem, options.threads, session.work.beside()).ok()?;
    let after = EstimationSession::like(&before, &after_problem).ok()?;
    // one noise for both, the augmented plant's: otherwise the gain is that of a noise model
    let own = own_parameters(&before, &best.noise).zip(own_parameters(&after, &best.noise));
    let (theta_before, theta_after) = own.unwrap_or_else(|| (before.prior(), after.prior()));
    let nominal = Predictor { plant: &before_problem.plant, theta: &theta_before, noise: &best.noise };
    let augmented = Predictor { plant: &after_problem.plant, theta: &theta_after, noise: &best.noise };
    look(Pair { before: (&before, nominal), after: (&after, augmented) })
}

fn on_recording(
    other: &Problem,
    own: (&EstimationSession<'_>, &Fit),
    best: &FittedModel,
    options: &Options,
) -> Option<HeldOutParts> {
    predicting(other, own, best, options, |Pair { before, after }| {
        let gain = gain(before.0, before.1, after);
        let (free_before, free_after) = (free_run(before.0, before.1), free_run(after.0, after.1));
        let overlays = figures::overlays(before, after);
        Some((HeldOutKind::Recording, free_before, free_after, gain, overlays))
    })
}

/// Parameters of a single recording stay as near to their priors as those of the fitted recordings
/// did, in any of the fits, and three standard deviations at least: an implausible sensor error is
/// no evidence about a model.
fn within_reach(mut problem: Problem, fits: &[(&[Unknown], &[f64])]) -> Problem {
    for own in &mut problem.unknowns {
        let all = fits.iter().flat_map(|(unknowns, theta)| unknowns.iter().zip(*theta));
        let off = all.filter(|(u, _)| u.parameter == own.parameter).map(|(u, value)| (value - u.prior).abs());
        let reach = off.fold(OWN_PARAMETER_SIGMA_MIN * own.sigma, f64::max);
        (own.low, own.high) = (own.low.max(own.prior - reach), own.high.min(own.prior + reach));
    }
    problem
}

/// `plant` with its shared unknowns known as fitted, except those that the fitted recordings did
/// not determine.
fn frozen(plant: &Plant, (unknowns, theta): (&[Unknown], &[f64]), unseen: &[&str]) -> Plant {
    let mut plant = plant.clone();
    plant.visit_quantities(&mut |name, _, quantity| {
        let at = unknowns.iter().position(|unknown| unknown.name == name && !unseen.contains(&name));
        if let Some(at) = at.filter(|_| quantity.scope == Scope::Shared) {
            *quantity = Quantity::known(theta[at]);
        }
    });
    plant
}

/// The parameters that belong to the recording itself, fitted on it.
fn own_parameters(session: &EstimationSession<'_>, noise: &NoiseModel) -> Option<Vec<f64>> {
    let prior = session.prior();
    if prior.is_empty() {
        return Some(prior);
    }
    fit(session, &session.problem.plant, &prior, noise, OWN_ROUNDS).ok().map(|fit| fit.theta)
}

/// Blocks of the recording, each predicted with parameters from the others; linear in the change
/// that leaving a block out makes.
fn on_blocks(
    problem: &Problem,
    session: &EstimationSession<'_>,
    stated: &Fit,
    best: &FittedModel,
    options: &Options,
) -> Option<HeldOutParts> {
    let after_session = EstimationSession::like(session, &best.problem).ok()?;
    let before = block_terms(session, &stated.linearised, &stated.theta, &best.noise)?;
    let after = block_terms(&after_session, &best.fit.linearised, &best.fit.theta, &best.noise)?;
    let differences: Vec<(f64, f64)> = before.0.iter().zip(&after.0).map(|((t, a), (_, b))| (*t, b - a)).collect();
    let gain = blocks(&differences, block_s(session));
    let (_, test) = problem.split(1.0 - 1.0 / FOLDS as f64);
    let test_before = EstimationSession::new(&test, options.threads).ok()?;
    let augmented = test.with_plant(&best.plant);
    let test_after = EstimationSession::like(&test_before, &augmented).ok()?;
    let nominal = Predictor { plant: &stated.plant, theta: &before.1, noise: &best.noise };
    let with = Predictor { plant: &best.plant, theta: &after.1, noise: &best.noise };
    let overlays = figures::overlays((&test_before, nominal), (&test_after, with));
    Some((HeldOutKind::Blocks, free_run(&test_before, nominal), free_run(&test_after, with), Some(gain), overlays))
}

/// Log-likelihood of every instant with parameters from the other folds, and the parameters without
/// the last fold.
fn block_terms(
    session: &EstimationSession<'_>,
    linearised: &LinearisedProblem,
    theta: &[f64],
    noise: &NoiseModel,
) -> Option<(Terms, Vec<f64>)> {
    let normal = linearised.normal(session, theta, noise, &[])?;
    let (r, columns) = linearised.whitened(session, noise, &[])?;
    let events = event_of_sample(session);
    let instants = events.last().map_or(0, |last| last + 1);
    let times: Vec<f64> = instants_s(session);
    let fold = |event: usize| event * FOLDS / instants.max(1);
    let n = normal.unknowns;
    let mut sum = half_log_determinants(session, linearised, noise)?;
    let mut last = theta.to_vec();
    for k in 0..FOLDS {
        let own: Vec<usize> = (0..events.len()).filter(|s| fold(events[*s]) == k).collect();
        let (mut matrix, mut right) = (normal.matrix.clone(), normal.right.clone());
        for i in 0..n {
            for j in 0..n {
                matrix[(i, j)] -= own.iter().map(|s| columns[i][*s] * columns[j][*s]).sum::<f64>();
            }
            right[i] -= own.iter().map(|s| columns[i][*s] * r[*s]).sum::<f64>();
        }
        let (_, step) = bounded(&matrix, &right, &normal.room, &(0..n).collect::<Vec<_>>())?;
        for s in own {
            let left = r[s] - (0..n).map(|i| columns[i][s] * step[i]).sum::<f64>();
            sum[events[s]] -= 0.5 * left * left;
        }
        if k + 1 == FOLDS {
            for (i, unknown) in session.problem.unknowns.iter().enumerate() {
                last[i] = (theta[i] + step[i] * unknown.sigma).clamp(unknown.low, unknown.high);
            }
        }
    }
    Some((times.into_iter().zip(sum).collect(), last))
}

/// `−½ ln |S|` of every instant.
fn half_log_determinants(
    session: &EstimationSession<'_>,
    linearised: &LinearisedProblem,
    noise: &NoiseModel,
) -> Option<Vec<f64>> {
    let mut list = Vec::new();
    for (linear, timeline) in linearised.linears.iter().zip(session.timelines.iter()) {
        let found = gains(linear, timeline, noise)?;
        for (k, event) in timeline.events.iter().enumerate().filter(|(_, event)| event.count > 0) {
            let factor = &found.factor[found.factor_first[k]..];
            list.push(-(0..event.count).map(|i| libm::log(factor[i * event.count + i])).sum::<f64>());
        }
    }
    Some(list)
}

/// Time of every instant, runs one behind the other.
fn instants_s(session: &EstimationSession<'_>) -> Vec<f64> {
    let mut times = Vec::new();
    let mut origin = 0.0;
    for timeline in session.timelines.iter() {
        let first = timeline.events.first().map_or(0.0, |event| event.t_s);
        times.extend(timeline.events.iter().filter(|event| event.count > 0).map(|event| origin + event.t_s - first));
        origin += timeline.events.last().map_or(0.0, |event| event.t_s - first) + 10.0 * BLOCK_S;
    }
    times
}

#[cfg(test)]
mod tests;
