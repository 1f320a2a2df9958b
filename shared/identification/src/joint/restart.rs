//! An arc that ended far from what is known is heard once more from there.
//!
//! Windows that grow follow one of several maxima from where the first of them is: of a fuel whose
//! slosh was watched for one period, mass, stiffness and place trade against each other, and the
//! windows of less than a period may leave them at a maximum that the whole arc has only as a lower
//! one. What is known before the arc then contradicts the estimate. From there the whole arc at
//! once finds its own maximum, and the higher of both is kept.

use super::Vehicle;
use super::fold::{Knowledge, Message};
use super::sequence::ROUNDS_OF_ALL;
use super::stage::{Part, Stage, deviations};
use nalgebra::Cholesky;

/// Distance of an estimate from what was known, in its own standard deviations, from which the arc
/// is heard again. Of one in 370 right estimates it is as large by chance, so that one hearing of
/// 36 parameters in ten is repeated in vain, which costs its work and nothing else.
const CONFLICT_SIGMA: f64 = 3.0;

impl Vehicle<'_> {
    /// Where arc `arc` has `ended`, or where it ends from what is `known` before it, if that is in
    /// conflict with the first and the second is more probable.
    ///
    /// Cost: none without a conflict; else some sets of sensitivities of the arc.
    pub(super) fn restarted(
        &self,
        arc: usize,
        known: &Knowledge,
        (theta, message): (Vec<f64>, Message),
    ) -> (Vec<f64>, Message) {
        if self.work.is_stopped() || !self.is_in_conflict(known, &theta, &message).unwrap_or(false) {
            return (theta, message);
        }
        let at_known = self.unknowns.iter().zip(known.mean.iter());
        let start = at_known.map(|(unknown, d)| (unknown.prior + d * unknown.sigma).clamp(unknown.low, unknown.high));
        let mut free = vec![false; self.unknowns.len()];
        self.places[arc].iter().for_each(|at| free[*at] = true);
        let part = Part { session: &self.sessions[arc], places: &self.places[arc], arc };
        let stage = Stage { unknowns: &self.unknowns, parts: vec![part], before: known, free };
        let again = stage.maximise(start.collect(), ROUNDS_OF_ALL, &mut |_| {}).ok();
        let again = again.and_then(|mut ended| Some((ended.theta, ended.messages.pop()?)));
        let objective = |(theta, message): &(Vec<f64>, Message)| {
            message.chi2 + message.log_determinant + known.chi2(&deviations(&self.unknowns, theta))
        };
        let first = (theta, message);
        match again {
            Some(again) if objective(&again) < objective(&first) => again,
            _ => first,
        }
    }

    /// Some parameter is further from what was `known` than [`CONFLICT_SIGMA`]. An estimate that
    /// folds the knowledge of covariance P₀ into its own P is from it by a deviation of variance
    /// P₀ − P.
    fn is_in_conflict(&self, known: &Knowledge, theta: &[f64], message: &Message) -> Option<bool> {
        let before = known.covariance()?;
        let after = Cholesky::new(&known.information + &message.information)?.inverse();
        let off = deviations(&self.unknowns, theta) - &known.mean;
        let is_far = |i: usize| {
            let variance = before[(i, i)] - after[(i, i)];
            // of what the arc does not tell, the difference is rounding
            variance > 1e-6 * before[(i, i)] && off[i] * off[i] > CONFLICT_SIGMA * CONFLICT_SIGMA * variance
        };
        Some((0..off.len()).any(is_far))
    }
}
