//! Initial states that a recording hardly shows.
//!
//! What nobody states of a start has a wide prior, and the filter finds it in the first readings. A state that these see only through a
//! product of small motions (the rate of a hub whose accelerometers feel nothing but its centrifugal pull) leaves the linear model
//! before it is found, and every relinearisation finds it elsewhere. Such a state is taken to start as near its value as the recorded
//! commands alone would drive it from there.

use super::engine::{Engine, open};
use crate::filter::{Machine, initial_sigmas, tangent_names};

/// A state is hardly seen where all readings together narrow its wide prior by less than this.
const NARROWED: f64 = 30.0;
/// What is hardly seen starts within this many times what the commands do to it, and within this share of its wide prior at least.
const REACHES: f64 = 10.0;
const LEAST: f64 = 1.0 / NARROWED;
/// Share of the prior's standard deviation over which a sensitivity is taken.
const SHARE: f64 = 1e-4;

/// Names and standard deviations of states of run `run` that are hardly seen; none where the free run from the priors fails.
pub(super) fn hardly_seen(engine: &Engine<'_>, run: usize) -> Vec<(String, f64)> {
    found(engine, run).unwrap_or_default()
}

fn found(engine: &Engine<'_>, run: usize) -> Option<Vec<(String, f64)>> {
    if engine.problem.runs[run].is_rest {
        return None;
    }
    let instance = engine.problem.instance(&engine.problem.plant, &engine.prior(), run);
    let initial = &engine.problem.runs[run].initial;
    let mut machine = Machine::new(engine.problem, run, &instance, &engine.timelines[run]).ok()?;
    let wide = initial_sigmas(&instance, &machine.system, initial, &[]);
    let frozen = open(&machine);
    let samples = machine.timeline.value.len();
    let start = machine.x0.clone();
    let mut base = vec![0.0; samples];
    machine.pass(&frozen, &[], &mut base).then_some(())?;
    let mut list = Vec::new();
    let mut moved = vec![0.0; samples];
    let mut reach: Option<Vec<f64>> = None;
    for (i, (name, _)) in tangent_names(&machine.system).into_iter().enumerate() {
        let mut delta = vec![0.0; wide.len()];
        delta[i] = SHARE * wide[i];
        let mut x0 = start.clone();
        machine.system.retract(&start, &delta, &mut x0);
        machine.x0 = x0;
        let seen = machine.pass(&frozen, &[], &mut moved);
        machine.x0.clone_from(&start);
        let units = |k: usize| SHARE * engine.noise.sensor_sigma[machine.timeline.channel[k]];
        let information: f64 = (0..samples).map(|k| ((moved[k] - base[k]) / units(k)).powi(2)).sum();
        if seen && information < NARROWED * NARROWED {
            let reach = reach.get_or_insert_with(|| machine.reach());
            let sigma = (REACHES * reach[i]).clamp(LEAST * wide[i], wide[i]);
            list.push((name, sigma));
        }
    }
    engine.work.add(machine.work());
    Some(list)
}
