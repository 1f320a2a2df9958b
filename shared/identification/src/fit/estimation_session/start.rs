//! Initial states that a recording hardly shows.
//!
//! An unspecified initial state has a wide prior, and the filter finds it in the first readings. A
//! state that these see only through a product of small motions (the rate of a hub whose
//! accelerometers feel nothing but its centrifugal pull) leaves the linear model before it is
//! found, and every relinearisation finds it elsewhere. Such a state is taken to start as near its
//! value as the recorded commands alone would drive it from there.
//!
//! So is a mode or a tank that an effect adds: nothing is known of its start but that it is one of
//! a structure that the commands move. A wide prior on it would cost the effect evidence for an
//! implausible assumption (a wide prior that the data narrow to a point has a low likelihood).

use super::EstimationSession;
use crate::filter::{Frozen, Propagator, equip, initial_sigmas, tangent_names};
use dynamics::system::System;

/// A state is hardly seen where all readings together narrow its wide prior by less than this.
/// Chosen, not derived.
const NARROWING_MIN: f64 = 30.0;
/// What is hardly seen starts within this many times what the commands do to it, and within this
/// share of its wide prior at least.
const REACH_FACTOR: f64 = 10.0;
const SIGMA_SHARE_MIN_UNSEEN: f64 = 1.0 / NARROWING_MIN;
/// Share of the prior's standard deviation over which a sensitivity is taken.
const STEP_SHARE: f64 = 1e-4;

/// Names and standard deviations of states of run `run` that are hardly seen; none where the free
/// run from the priors fails.
pub(super) fn hardly_seen(session: &EstimationSession<'_>, run: usize) -> Vec<(String, f64)> {
    found(session, run).unwrap_or_default()
}

/// Of each run, names and standard deviations of the states of modes and tanks that the effects of
/// the plant add, `system` being the whole: as for what is hardly seen, but for the least share of
/// a width that says nothing of them. None where the commands move nothing, and of runs that begin
/// behind a gap.
/// The plant is that at `theta`.
pub(super) fn added(session: &EstimationSession<'_>, system: &System, theta: &[f64]) -> Vec<Vec<(String, f64)>> {
    let runs = session.problem.runs.len();
    let none = vec![Vec::new(); runs];
    if session.problem.plant.effects.is_empty() {
        return none;
    }
    let mut bare = session.problem.plant.clone();
    bare.effects.clear();
    let Ok(bare) = System::new(&equip(&bare)) else { return none };
    let is_added = |name: &str| is_mass(name) && !bare.states().iter().any(|state| state.name == name);
    if !system.states().iter().any(|state| is_added(&state.name)) {
        return none;
    }
    (0..runs).map(|run| driven(session, (run, theta), &is_added).unwrap_or_default()).collect()
}

/// A state is one of a mode or of a tank.
pub fn is_mass(state: &str) -> bool {
    state.starts_with("mode:") || state.starts_with("tank:")
}

fn driven(
    session: &EstimationSession<'_>,
    (run, theta): (usize, &[f64]),
    is_added: &dyn Fn(&str) -> bool,
) -> Option<Vec<(String, f64)>> {
    let (mut propagator, wide) = begun(session, run, theta)?;
    let reach = propagator.reach();
    session.work.add(propagator.work());
    let states = tangent_names(&propagator.system).into_iter().zip(reach.into_iter().zip(wide));
    let driven = states.filter(|((name, _), (reach, _))| is_added(name) && reach.is_finite() && *reach > 0.0);
    Some(driven.map(|((name, _), (reach, wide))| (name, (REACH_FACTOR * reach).min(wide))).collect())
}

/// The filter of run `run` at `theta` with the wide standard deviations of its start; none of a
/// run that begins behind a gap.
fn begun<'e>(session: &'e EstimationSession<'_>, run: usize, theta: &[f64]) -> Option<(Propagator<'e>, Vec<f64>)> {
    if session.problem.runs[run].is_rest {
        return None;
    }
    let instance = session.problem.instance(&session.problem.plant, theta, run);
    let initial = &session.problem.runs[run].initial;
    let propagator = Propagator::new(session.problem, run, &instance, &session.timelines[run]).ok()?;
    let wide = initial_sigmas(&instance, &propagator.system, initial, &[]);
    Some((propagator, wide))
}

fn found(session: &EstimationSession<'_>, run: usize) -> Option<Vec<(String, f64)>> {
    let (mut propagator, wide) = begun(session, run, &session.prior())?;
    let frozen = Frozen::of_free_run(propagator.timeline.events.len());
    let samples = propagator.timeline.value.len();
    let start = propagator.x0.clone();
    let mut base = vec![0.0; samples];
    propagator.pass(&frozen, &[], &mut base).then_some(())?;
    let mut list = Vec::new();
    let mut moved = vec![0.0; samples];
    let mut reach: Option<Vec<f64>> = None;
    for (i, (name, _)) in tangent_names(&propagator.system).into_iter().enumerate() {
        let mut delta = vec![0.0; wide.len()];
        delta[i] = STEP_SHARE * wide[i];
        let mut x0 = start.clone();
        propagator.system.retract(&start, &delta, &mut x0);
        propagator.x0 = x0;
        let seen = propagator.pass(&frozen, &[], &mut moved);
        propagator.x0.clone_from(&start);
        let units = |k: usize| STEP_SHARE * session.noise.sensor_sigma[propagator.timeline.channel[k]];
        let information: f64 = (0..samples).map(|k| ((moved[k] - base[k]) / units(k)).powi(2)).sum();
        let is_added = session.added[run].iter().any(|(own, _)| *own == name);
        if seen && !is_added && information < NARROWING_MIN * NARROWING_MIN {
            let reach = reach.get_or_insert_with(|| propagator.reach());
            let sigma = (REACH_FACTOR * reach[i]).clamp(SIGMA_SHARE_MIN_UNSEEN * wide[i], wide[i]);
            list.push((name, sigma));
        }
    }
    session.work.add(propagator.work());
    Some(list)
}
