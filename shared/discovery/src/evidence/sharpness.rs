//! How sharply the sign of a dry friction turns: the rate over which it is smoothed.
//!
//! That rate is no unknown of a fit: of a sign that turns within what the readings tell the
//! likelihood is flat. Where it is not, a sign that turns too slowly leaves a remainder that
//! another law would explain (a Stribeck's dip, a cubic damping). The rate moves along the
//! likelihood, all unknowns following on the linear model, and the set is fitted again there.

use super::decide::SAME;
use super::follow::Follow;
use super::hypothesis::Hypothesis;
use super::model::{Ground, Model, from};
use crate::score::{Candidate, propagator};
use dynamics::description::{Plant, SiteKind};
use dynamics::effect::{EffectParameter, Role};
use identification::filter::{Linear, state_sigmas};
use identification::fit::EstimationSession;
use identification::problem::Timeline;

/// Divisions of all rates, further refits of a set, and rates that are tried for each of its laws.
/// Budgets.
const DIVISIONS_MAX: usize = 2;
const MOVES_MAX: usize = 3;
const RATES_TRIED_MAX: usize = 12;
/// Step of a rate's logarithm, a factor of four. Numerics, not physics.
const LOG_STEP: f64 = 2.0 * core::f64::consts::LN_2;
/// Divisor of a rate. Numerics, not physics.
const SHARPER: f64 = 5.0;
/// Decrease of `−2 ln p` from which a rate is another one, and that a parabola must promise to be
/// followed: where the likelihood bends it promises too little.
const RATE_GAIN: f64 = SAME;
const PROMISE_MIN: f64 = 0.25 * SAME;

/// The model with signs as sharp as the data ask for, as long as the evidence rises: those of laws
/// that are not `known`. Sharper ones are fitted first: where a reading feels the sign itself,
/// gains of a smooth one do not show what a sharp one explains. Then rates move along the
/// likelihood.
///
/// Cost: a fit and some three passes for each sign that stands, and a fit for each time that one
/// moves.
pub(super) fn sharpened(ground: Ground<'_>, model: Model, known: &[Hypothesis]) -> Model {
    let divided = refitted(ground, model, known, (divided, DIVISIONS_MAX));
    refitted(ground, divided, known, (along_the_likelihood, MOVES_MAX))
}

/// The set of a model with other rates of all laws but the known ones; `None` where each stands.
type Way = fn(&EstimationSession<'_>, &Model, &[Candidate]) -> Option<Vec<Hypothesis>>;

/// `model` at the rates of a way, as long as the evidence rises.
fn refitted(ground: Ground<'_>, model: Model, known: &[Hypothesis], (way, most): (Way, usize)) -> Model {
    let laws = |set: &[Hypothesis]| -> Vec<Candidate> {
        set.iter().flat_map(Hypothesis::parts).map(|part| part.column.candidate.clone()).collect()
    };
    let known = laws(known);
    let is_open = |own: &Candidate| smoothing(own).is_some() && !known.iter().any(|known| known.same_law(own));
    let mut best = model;
    if !laws(&best.set).iter().any(is_open) {
        return best;
    }
    for _ in 0..most {
        let set = best.session(ground).and_then(|session| way(&session, &best, &known));
        match set.and_then(|set| from(ground, &set, best.begin(), 1.0)) {
            Some(found) if found.log_marginal > best.log_marginal => best = found,
            _ => break,
        }
    }
    best
}

/// All signs sharper by [`SHARPER`].
fn divided(_: &EstimationSession<'_>, model: &Model, known: &[Candidate]) -> Option<Vec<Hypothesis>> {
    let (mut set, mut any) = (model.set.clone(), false);
    for candidate in set.iter_mut().flat_map(Hypothesis::parts_mut).map(|part| &mut part.column.candidate) {
        let Some((place, parameter)) = smoothing(candidate) else { continue };
        let rate = candidate.inner[place].1 / SHARPER;
        if rate >= parameter.low && !known.iter().any(|known| known.same_law(candidate)) {
            candidate.inner[place].1 = rate;
            any = true;
        }
    }
    any.then_some(set)
}

/// The set with rates of greater likelihood; `None` where each stands.
fn along_the_likelihood(
    session: &EstimationSession<'_>,
    model: &Model,
    known: &[Candidate],
) -> Option<Vec<Hypothesis>> {
    let smoothing = |own: &Candidate| smoothing(own).filter(|_| !known.iter().any(|known| known.same_law(own)));
    let mut follow = Follow::new(session, &model.fit, &model.noise);
    let mut plant = model.fit.plant.clone();
    let (mut set, mut least, mut any) = (model.set.clone(), follow.least(&plant)?, false);
    for candidate in set.iter_mut().flat_map(Hypothesis::parts_mut).map(|part| &mut part.column.candidate) {
        let Some((place, parameter)) = smoothing(candidate) else { continue };
        let begin = Tried { log_rate: libm::log(candidate.inner[place].1), least };
        let known = rate_sigma(session, model, candidate);
        let mut at = |log_rate: f64| {
            let rate = libm::exp(log_rate);
            let inside = (parameter.low.max(known)..=parameter.high).contains(&rate);
            let there = inside.then(|| with_rate(&plant, candidate, parameter.name, rate));
            let there = there.filter(|there| is_resolved(session, there, &model.fit.theta));
            there.and_then(|there| follow.least(&there)).unwrap_or(f64::INFINITY)
        };
        let found = lowest(begin, &mut at);
        if found.least < begin.least - RATE_GAIN {
            let rate = libm::exp(found.log_rate);
            plant = with_rate(&plant, candidate, parameter.name, rate);
            candidate.inner[place].1 = rate;
            (least, any) = (found.least, true);
        }
    }
    any.then_some(set)
}

/// Place among the shape parameters of the rate over which a sign turns, and the rate's entry.
fn smoothing(candidate: &Candidate) -> Option<(usize, &'static EffectParameter)> {
    Some((candidate.inner_with(Role::Smoothing)?, candidate.effect.with_role(Role::Smoothing)?))
}

/// `plant` with the law of `candidate` at another rate.
fn with_rate(plant: &Plant, candidate: &Candidate, name: &str, rate: f64) -> Plant {
    let mut plant = plant.clone();
    let own = plant.effects.iter_mut().filter(|used| candidate.is(used));
    let values = own.flat_map(|used| &mut used.values).filter(|(own, _)| *own == name);
    values.for_each(|(_, quantity)| quantity.value = rate);
    plant
}

/// The steps of integration are short against how fast a sign turns: what they are not short
/// against is another law.
fn is_resolved(session: &EstimationSession<'_>, plant: &Plant, theta: &[f64]) -> bool {
    let resolves = |run: usize| propagator(session, plant, theta, run).is_some_and(|own| own.is_resolved());
    (0..session.timelines.len()).all(resolves)
}

/// Standard deviation to which the filter knows the rate of the site of a law; zero where it has no
/// such rate. Within it a linear model has one slope, and a sharper sign has two.
fn rate_sigma(session: &EstimationSession<'_>, model: &Model, candidate: &Candidate) -> f64 {
    let rate = match candidate.site.kind {
        SiteKind::Actuator => format!("wheel:{}", candidate.site.name),
        _ => format!("{}.rate", candidate.site),
    };
    let runs = model.fit.linearised.linears.iter().zip(session.timelines.iter());
    let of_run = |(linear, timeline): (&Linear, &Timeline)| {
        let place = linear.names.iter().position(|name| *name == rate)?;
        Some(state_sigmas(linear, timeline, &model.noise)?[place])
    };
    runs.filter_map(of_run).fold(0.0, f64::max)
}

/// A rate with the least `−2 ln p` there.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Tried {
    log_rate: f64,
    least: f64,
}

/// Downhill from `begin` in equal steps, then to the vertices of parabolas through the lowest one
/// and its neighbours, as long as one promises [`PROMISE_MIN`]; sharper signs first.
fn lowest(begin: Tried, at: &mut dyn FnMut(f64) -> f64) -> Tried {
    let mut bracket = Bracket { best: begin, beside: [None, None] };
    for _ in 0..RATES_TRIED_MAX {
        let Some(log_rate) = bracket.next() else { break };
        let least = at(log_rate);
        bracket.take(Tried { log_rate, least });
    }
    bracket.best
}

/// The lowest rate so far and its neighbours, below and above.
struct Bracket {
    best: Tried,
    beside: [Option<Tried>; 2],
}

impl Bracket {
    /// Where to look next; `None` where nothing is promised.
    fn next(&self) -> Option<f64> {
        match self.beside {
            [None, _] => Some(self.best.log_rate - LOG_STEP),
            [_, None] => Some(self.best.log_rate + LOG_STEP),
            [Some(left), Some(right)] => self.between(left, right),
        }
    }

    /// The parabola's vertex where it promises something; halfway to a rate that no step of
    /// integration resolves.
    fn between(&self, left: Tried, right: Tried) -> Option<f64> {
        let [below, above] = [left, right].map(|own| own.log_rate - self.best.log_rate);
        let [rise_below, rise_above] = [left, right].map(|own| own.least - self.best.least);
        if rise_below.is_infinite() {
            return (-below > 0.25 * LOG_STEP).then_some(self.best.log_rate + 0.5 * below);
        }
        let determinant = below * above * (above - below);
        let slope = (rise_below * above * above - rise_above * below * below) / determinant;
        let bend = (rise_above * below - rise_below * above) / determinant;
        let is_promising = bend > 0.0 && 0.25 * slope * slope / bend >= PROMISE_MIN;
        is_promising.then(|| self.best.log_rate - 0.5 * slope / bend)
    }

    fn take(&mut self, found: Tried) {
        let side = usize::from(found.log_rate > self.best.log_rate);
        // a step downhill is one that the data tell
        let is_step = self.beside[side].is_none();
        let gain = if is_step { RATE_GAIN } else { 0.0 };
        if found.least < self.best.least - gain {
            self.beside[1 - side] = Some(self.best);
            self.best = found;
        } else {
            self.beside[side] = Some(found);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(from: f64, of: impl Fn(f64) -> f64) -> (Tried, usize) {
        let mut count = 0;
        let begin = Tried { log_rate: from, least: of(from) };
        let found = lowest(begin, &mut |log_rate| {
            count += 1;
            of(log_rate)
        });
        (found, count)
    }

    #[test]
    fn a_rate_is_found_to_two_nats_from_either_side_and_one_that_is_not_felt_stays() {
        // steeper on the side of slow turns, as a likelihood is
        let valley = |x: f64| 600.0 * (libm::exp(x - 1.0) - x);
        for from in [-4.0, 0.5, 5.0] {
            let (found, _) = found(from, valley);
            // a parabola is off where the valley bends
            assert!(found.least < valley(1.0) + 2.0 * RATE_GAIN, "{found:?}");
        }
        for (flat, tries) in [(0.0, 2), (500.0, 6)] {
            let (stays, count) = found(-1.0, |x| libm::fmax(x, 0.0) * flat);
            assert_eq!((stays.log_rate, count), (-1.0, tries));
        }
    }

    #[test]
    fn a_rate_that_no_plant_survives_is_not_taken() {
        let of = |x: f64| if x < 0.0 { f64::INFINITY } else { 300.0 * x };
        let (own, count) = found(2.0, of);
        assert!((0.0..0.4).contains(&own.log_rate) && count <= 6, "{own:?} {count}");
    }
}
