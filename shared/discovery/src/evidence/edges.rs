//! Onsets and ends of a fitted set, moved to the maximum of its likelihood.
//!
//! The screening finds them beside the noise and the numbers of a plant that lacks the law. The fit
//! behind it has others, and a frequency or a phase that follows the onset.

use super::hypothesis::Hypothesis;
use super::model::{Begin, Ground, Model, from};
use super::onset::{Follow, Place, places, span_s, time, with};
use dynamics::description::{EffectUse, Plant};
use dynamics::effect::Role;

/// First and last step of the search [samples].
const FIRST_STEP: f64 = 16.0;
const LAST_STEP: f64 = 0.25;
/// Moves of all edges, and refits behind them. Budgets.
const MOVES_MAX: usize = 32;
const EDGE_TURNS_MAX: usize = 3;
/// Decrease of `−2 ln p` that is worth a move: that which ends a fit.
const EDGE_GAIN: f64 = 0.1;

/// The model with its edges where its likelihood is greatest, as long as the evidence rises.
///
/// Cost: some thirty passes for each edge, and a fit for each turn in which one moves.
pub(super) fn edged(ground: Ground<'_>, model: Model) -> Model {
    let mut best = model;
    for _ in 0..EDGE_TURNS_MAX {
        let Some((set, theta)) = moved(ground, &best) else { break };
        match from(ground, &set, Begin { theta: &theta, ..best.begin() }, 1.0) {
            Some(found) if found.log_marginal > best.log_marginal => best = found,
            _ => break,
        }
    }
    best
}

/// The set with other onsets and ends, and where its unknowns begin, all other parameters following
/// on the linear model; `None` where none is better.
fn moved(ground: Ground<'_>, model: &Model) -> Option<(Vec<Hypothesis>, Vec<f64>)> {
    let session = model.session(ground)?;
    let mut plant = model.fit.plant.clone();
    let parts = model.set.iter().flat_map(Hypothesis::parts);
    let list: Vec<Place> = parts.flat_map(|part| places(&session, &plant, &part.column.candidate)).collect();
    if list.is_empty() {
        return None;
    }
    let mut follow = Follow::new(&session, &model.fit, &model.noise);
    let ([begin_s, end_s], period_s) = (span_s(&session), session.timelines.first()?.period_s);
    let (mut least, mut moves, mut step_s) = (follow.least(&plant)?, 0, FIRST_STEP * period_s);
    while step_s >= LAST_STEP * period_s && moves < MOVES_MAX {
        let before = moves;
        for place in &list {
            let near = [-step_s, step_s].into_iter().filter_map(|by| {
                let t_s = time(&plant, place.effect, place.edge)? + by;
                let there = (begin_s..=end_s).contains(&t_s).then(|| with(&plant, *place, t_s))??;
                Some((follow.least(&there)?, there))
            });
            let Some((found, there)) = near.min_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
            if found < least - EDGE_GAIN {
                (least, plant, moves) = (found, there, moves + 1);
            }
        }
        if moves == before {
            step_s *= 0.5;
        }
    }
    (moves > 0).then(|| (with_times_of(&plant, &model.set), follow.theta(&plant)))
}

/// `set` with the onsets and durations of `plant`.
fn with_times_of(plant: &Plant, set: &[Hypothesis]) -> Vec<Hypothesis> {
    let mut set = set.to_vec();
    let effects = set.iter_mut().filter_map(|own| match own {
        Hypothesis::Effect(parts) => Some(parts),
        _ => None,
    });
    for candidate in effects.flatten().map(|part| &mut part.column.candidate) {
        let is_own = |used: &&EffectUse| used.kind == candidate.effect.kind && used.site == candidate.site;
        let Some(used) = plant.effects.iter().find(is_own) else { continue };
        for role in [Role::Onset, Role::Duration] {
            if let (Some(place), Some(value)) = (candidate.inner_with(role), plant.stated(used, role)) {
                candidate.inner[place].1 = value.value;
            }
        }
    }
    set
}
