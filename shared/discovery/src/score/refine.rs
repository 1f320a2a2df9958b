//! Shape parameters of a law, moved from their grid points to the maximum of the score.
//!
//! A grid only gives starting values: a tone between two of its frequencies, a step between two of
//! its times leaves nothing in either column. Every promising law moves from its best point, one
//! parameter at a time, by half its neighbours' distance and less, all laws side by side. The
//! largest of correlated scores enters the significance: the number of grid points counts
//! ([`Candidate::tries`]).

use super::{Candidate, Column, Score, Scorer, columns};
use dynamics::description::Plant;
use dynamics::effect::{EffectParameter, Prior, Role};
use identification::fit::{EstimationSession, LinearisedProblem};

/// Rounds of steps, of laws with sharp edges in time and of all others.
const EDGE_ROUNDS_MAX: usize = 14;
const ROUNDS_MAX: usize = 5;
/// Further rounds for every further parameter: a round moves one.
const ROUNDS_PER_PARAMETER: usize = 2;
const HALVINGS: usize = 4;
/// Columns that the refinement of a law takes, about.
const COLUMNS_PER_LAW: usize = 40;
/// Statistic T from which a law is refined (three standard errors), and number of laws refined.
/// They trade work against coverage; chosen, no derivation.
const REFINED_STATISTIC_MIN: f64 = 9.0;
const REFINED_LAWS_MAX: usize = 12;
/// Bound of the samples of all columns of the refinement: long recordings refine fewer laws.
const REFINEMENT_WORK_MAX: f64 = 5e6;
/// Gain of the statistic T from which a new column is kept.
const STATISTIC_GAIN_MIN: f64 = 0.5;

/// Step of a parameter, times by addition, everything else by a factor: the first one.
fn step_of(parameter: &EffectParameter, value: f64, duration_s: f64) -> Option<Step> {
    match parameter.role {
        // where its fit has it free, too
        Role::DampingRatio if value > 0.0 => parameter.prior.sigma(value).map(|_| Step::Factor(2.0)),
        Role::Onset => Some(Step::Shift(duration_s / 16.0)),
        Role::Duration => Some(Step::Factor(4.0)),
        Role::Frequency if value > 0.0 => Some(Step::Factor(1.0 + 0.5 / (duration_s * value))),
        // an encoder before a gear repeats at no whole part of the joint's turn
        Role::Order => Some(Step::Factor(1.1)),
        Role::Width if value > 0.0 => Some(Step::Factor(2.0)),
        _ => None,
    }
}

#[derive(Clone, Copy)]
enum Step {
    Shift(f64),
    Factor(f64),
}

impl Step {
    fn halved(self) -> Self {
        match self {
            Step::Shift(by) => Step::Shift(0.5 * by),
            Step::Factor(by) => Step::Factor(by.sqrt()),
        }
    }

    fn neighbours(self, value: f64) -> [f64; 2] {
        match self {
            Step::Shift(by) => [value - by, value + by],
            Step::Factor(by) => [value / by, value * by],
        }
    }
}

/// A law under refinement.
struct Climb {
    column: Column,
    statistic: f64,
    begun_at: f64,
    levels: usize,
    steps: Vec<Stride>,
}

/// One shape parameter of a law and its step.
struct Stride {
    number: usize,
    step: Step,
    /// Halvings that remain.
    left: usize,
}

impl Climb {
    /// The law begins and ends abruptly.
    fn has_edges(&self) -> bool {
        self.column.candidate.inner_with(Role::Duration).is_some()
    }

    /// No step gained: halves the steps that are still distinguishable from zero.
    fn halve(&mut self) {
        self.steps.retain(|stride| stride.left > 0);
        for stride in &mut self.steps {
            (stride.step, stride.left) = (stride.step.halved(), stride.left - 1);
        }
    }
}

/// Columns of promising laws at better shape parameters than the grid's, taken `along` a
/// trajectory; empty where no step gains.
///
/// Cost: at most `REFINED_LAWS_MAX` × parameters × 2 × `EDGE_ROUNDS_MAX` columns, fewer laws
/// where the recording is long; a law whose steps are all halved out is finished.
pub fn refined(
    scorer: &Scorer<'_, '_>,
    along: (&EstimationSession<'_>, &LinearisedProblem),
    plant: &Plant,
    theta: &[f64],
    (list, found): (&[Column], &[Score]),
) -> Vec<Column> {
    let session = along.0;
    let [begin_s, end_s] = session.problem.span_s();
    let duration_s = end_s - begin_s;
    let laws = (REFINEMENT_WORK_MAX / (COLUMNS_PER_LAW as f64 * session.samples.max(1) as f64)) as usize;
    // an edge in time is as sharp as a sample
    let edges = libm::log2((duration_s / (16.0 * session.timelines[0].period_s)).max(1.0)).ceil() as usize;
    let mut climbs = starts(list, found, duration_s, edges);
    climbs.truncate(laws.clamp(2, REFINED_LAWS_MAX));
    for level in 0..EDGE_ROUNDS_MAX.max(2 * edges) {
        let goes_on = |climb: &&Climb| level < climb.levels || climb.has_edges();
        let flat: Vec<Candidate> =
            climbs.iter().filter(goes_on).flat_map(|climb| proposed(climb, duration_s)).collect();
        if flat.is_empty() {
            break;
        }
        let tried = columns(along, plant, theta, &flat);
        let scored = scorer.scores(&tried);
        for climb in &mut climbs {
            let own = |column: &Column| column.candidate.same_law(&climb.column.candidate);
            let better = scored.iter().flatten().filter(|s| own(&tried[s.column]));
            let best = better.max_by(|a, b| a.statistic.total_cmp(&b.statistic));
            match best.filter(|best| best.statistic > climb.statistic) {
                Some(best) => (climb.column, climb.statistic) = (tried[best.column].clone(), best.statistic),
                None => climb.halve(),
            }
        }
    }
    let free = libm::log(session.samples.max(2) as f64);
    // a whole order is that of the scale and free of charge; any other one is an estimated
    // parameter
    let is_charged = |parameter: &EffectParameter| matches!(parameter.prior, Prior::FreeUnlessWhole(_));
    let gained = |climb: &Climb| {
        if climb.column.candidate.effect.parameters.iter().any(is_charged) { free } else { STATISTIC_GAIN_MIN }
    };
    climbs.into_iter().filter(|c| c.statistic > c.begun_at + gained(c)).map(|climb| climb.column).collect()
}

/// The best point of every promising law that has shape parameters to move.
fn starts(list: &[Column], found: &[Score], duration_s: f64, edges: usize) -> Vec<Climb> {
    let mut order: Vec<&Score> = found.iter().filter(|score| score.statistic > REFINED_STATISTIC_MIN).collect();
    order.sort_by(|a, b| b.statistic.total_cmp(&a.statistic));
    let mut climbs: Vec<Climb> = Vec::new();
    for score in order {
        let candidate = &list[score.column].candidate;
        let numbers = candidate.inner.iter().enumerate();
        let stride = |(number, (name, value)): (usize, &(&str, f64))| {
            let parameter = candidate.effect.parameter(name)?;
            let is_time = matches!(parameter.role, Role::Onset | Role::Duration);
            let left = if is_time { edges.max(HALVINGS) } else { HALVINGS };
            Some(Stride { number, step: step_of(parameter, *value, duration_s)?, left })
        };
        let steps: Vec<Stride> = numbers.filter_map(stride).collect();
        let known = climbs.iter().any(|climb| climb.column.candidate.same_law(candidate));
        if climbs.len() < REFINED_LAWS_MAX && !steps.is_empty() && !known {
            let (column, statistic) = (list[score.column].clone(), score.statistic);
            let levels = ROUNDS_MAX + ROUNDS_PER_PARAMETER * (steps.len() - 1);
            climbs.push(Climb { column, statistic, begun_at: statistic, levels, steps });
        }
    }
    climbs
}

/// Neighbours of a law's present point, one parameter moved in each; a law with onset and duration
/// may begin elsewhere and end where it did.
fn proposed(climb: &Climb, duration_s: f64) -> Vec<Candidate> {
    let candidate = Candidate { felt: Some(climb.column.step), ..climb.column.candidate.clone() };
    let (begins, lasts) = (candidate.inner_with(Role::Onset), candidate.inner_with(Role::Duration));
    let mut list = Vec::with_capacity(4 * climb.steps.len());
    for Stride { number, step, .. } in &climb.steps {
        let (name, value) = candidate.inner[*number];
        let range = candidate.effect.parameter(name).map_or([value, value], |p| [p.low, p.high]);
        // a law that lasts beyond the end has shorter durations as its only neighbours
        let value = if lasts == Some(*number) { value.min(duration_s) } else { value };
        for moved in step.neighbours(value) {
            let moved = moved.clamp(range[0], range[1]);
            if moved == value {
                continue;
            }
            let mut next = candidate.clone();
            next.inner[*number].1 = moved;
            if let Some(lasts) = lasts.filter(|_| begins == Some(*number)) {
                let mut same_end = next.clone();
                same_end.inner[lasts].1 -= moved - value;
                let range = candidate.effect.with_role(Role::Duration);
                let possible = range.is_some_and(|p| (p.low..=p.high).contains(&same_end.inner[lasts].1));
                if possible && same_end.inner[lasts].1 > 0.0 && same_end.inner[lasts].1 < duration_s {
                    list.push(same_end);
                }
            }
            list.push(next);
        }
    }
    list
}
