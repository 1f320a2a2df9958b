//! Models that are the same on a record: laws that predict the same, whatever their numbers.
//!
//! ```text
//! Σ (e_a − e_b)²/S < 2        whitened innovations of two fitted sets of one size
//! ```
//!
//! No test can tell them apart. A constant torque of a joint, of its motor and of its body have a
//! third of one law's weight each: the law leads by their sum.

use super::decide::SAME;
use super::model::{Ground, Model};
use super::pool::Pool;
use identification::held_out::instants;

/// Weight below which a model is a class of its own: it changes no leader.
const WEIGHT_MIN: f64 = 1e-3;

/// Of every entry the first one that is the same, itself where there is none.
///
/// Cost: a pass of the filter for each pair of models with a weight.
pub(super) fn classes(ground: Ground<'_>, pool: &Pool, weights: &[f64]) -> Vec<usize> {
    let mut classes: Vec<usize> = (0..pool.entries.len()).collect();
    for place in 0..classes.len() {
        let is_same = |other: &usize| {
            let [ours, theirs] = [place, *other].map(|place| &pool.entries[place].model);
            weights[place].min(weights[*other]) > WEIGHT_MIN
                && classes[*other] == *other
                && ours.set.len() == theirs.set.len()
                && apart(ground, ours, theirs).is_some_and(|apart| apart < SAME)
        };
        let first = (0..place).find(is_same);
        classes[place] = first.unwrap_or(place);
    }
    classes
}

/// `Σ (e_a − e_b)²/S` of whitened innovations at both modes, under the noise of `theirs`.
pub(super) fn apart(ground: Ground<'_>, ours: &Model, theirs: &Model) -> Option<f64> {
    let white = |model: &Model| {
        let session = model.session(ground)?;
        Some(instants(&session, &model.fit.linearised.linears, &theirs.noise)?.1)
    };
    let (a, b) = (white(ours)?, white(theirs)?);
    Some(a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum())
}
