//! An arc is heard from other starts where its likelihood may have another maximum.
//!
//! Windows that grow follow one of several maxima from where the first of them is: of a fuel whose
//! slosh was watched for one period, two sinusoids of nearly one frequency, mass, stiffness and
//! place trade against each other, and the nearest maximum to what is known may be a lower one.
//! Neither noise nor priors nor other arcs need show it. Other maxima of nearly equal likelihood
//! lie along what the arc tells and does not tell much better than what was known before it: an arc
//! is heard again from either side of what is known, along the least known combinations of its
//! parameters, where the objective there is not that of a parabola. The highest maximum is kept.

use super::fold::{Knowledge, Message};
use super::sequence::{ROUNDS_OF_A_WINDOW, ROUNDS_OF_ALL};
use super::stage::{Part, Stage, deviations};
use super::{JointError, Vehicle};
use crate::fit::{LinearisedProblem, prior_chi2};
use nalgebra::{DVector, SymmetricEigen};

/// Information of an arc over what was known, from which it tells of a combination at all: below,
/// nine tenths of the standard deviation are left.
const TOLD_LEAST: f64 = 0.25;
/// The same from which a second maximum shows itself: a standard deviation of what was known away,
/// −2 ln p is higher by a hundred.
const TOLD_MOST: f64 = 100.0;
/// Ratio of the objective's rise to that of its parabola from which it bends.
const NOT_PARABOLIC: f64 = 2.0;
/// Combinations along which starts are moved, the least known first.
const COMBINATIONS_MAX: usize = 3;
/// Standard deviations of what was known by which they are moved: half of all vehicles lie within
/// 0.7, nine of ten within 1.6.
const MOVED_SIGMA: f64 = 1.5;

/// Where an arc ended, and what it says there.
type Heard = (Vec<f64>, Message);

impl Vehicle<'_> {
    /// Where arc `arc` has ended at `first`, or where it ends from another start, if that is more
    /// probable.
    ///
    /// Cost: two linearisations without sensitivities for each combination; with starts, for the
    /// first end and each of the six at most as much as a hearing or two.
    pub(super) fn restarted(&self, arc: usize, known: &Knowledge, first: Heard) -> Heard {
        let starts = if self.work.is_stopped() { None } else { self.other_starts(arc, known, &first) };
        let Some(starts) = starts.filter(|starts| !starts.is_empty()) else { return first };
        // ends are compared where they ended: the way down from the first one may not be over
        let first = self.heard_whole(arc, known, first.0.clone(), ROUNDS_OF_ALL).unwrap_or(first);
        let Some(model) = self.model(known, &first) else { return first };
        let going_on = starts.into_iter().take_while(|_| !self.work.is_stopped());
        going_on.filter_map(|start| self.heard_elsewhere(arc, known, &model, start).ok()).fold(first, |best, other| {
            let is_higher = self.objective(known, &other) < self.objective(known, &best);
            if is_higher { other } else { best }
        })
    }

    /// The normal law about an end.
    fn model(&self, known: &Knowledge, (theta, message): &Heard) -> Option<Knowledge> {
        known.with([message], &deviations(&self.unknowns, theta))
    }

    /// Starts on either side of what is `known`, along the least known combinations that bend.
    fn other_starts(&self, arc: usize, known: &Knowledge, first: &Heard) -> Option<Vec<Vec<f64>>> {
        let on_both_sides = |of: &DVector<f64>, by: &DVector<f64>| [self.values(&(of - by)), self.values(&(of + by))];
        let d = deviations(&self.unknowns, &first.0);
        let (reached, model) = (self.objective(known, first), self.model(known, first)?);
        // of the parabola about the end, so often its rise is that of the objective
        let is_of_the_parabola = |at: &Vec<f64>| {
            let promised = model.chi2(&deviations(&self.unknowns, at)) - model.chi2(&d);
            let rise = self.objective_at(arc, known, at).map(|found| found - reached);
            rise.is_some_and(|rise| rise > promised / NOT_PARABOLIC && rise < promised * NOT_PARABOLIC)
        };
        let moved = combinations(known, &first.1)?.into_iter().map(|combination| MOVED_SIGMA * combination);
        let bent = moved.filter(|by| !on_both_sides(&d, by).iter().all(is_of_the_parabola));
        let starts = bent.take(COMBINATIONS_MAX).flat_map(|by| on_both_sides(&known.mean, &by));
        Some(starts.collect())
    }

    fn values(&self, d: &DVector<f64>) -> Vec<f64> {
        let of = self.unknowns.iter().zip(d.iter());
        of.map(|(unknown, d)| (unknown.prior + d * unknown.sigma).clamp(unknown.low, unknown.high)).collect()
    }

    /// The maximum of the whole arc that is nearest to `start`; no further than to where that is
    /// the end of `model` again.
    fn heard_elsewhere(
        &self,
        arc: usize,
        known: &Knowledge,
        model: &Knowledge,
        start: Vec<f64>,
    ) -> Result<Heard, JointError> {
        let (theta, message) = self.heard_whole(arc, known, start, ROUNDS_OF_A_WINDOW)?;
        let is_again = model.chi2(&deviations(&self.unknowns, &theta)) < self.places[arc].len() as f64;
        if is_again { Ok((theta, message)) } else { self.heard_whole(arc, known, theta, ROUNDS_OF_ALL) }
    }

    fn heard_whole(&self, arc: usize, known: &Knowledge, theta: Vec<f64>, rounds: usize) -> Result<Heard, JointError> {
        let part = Part { session: &self.sessions[arc], places: &self.places[arc], arc };
        let stage = Stage { unknowns: &self.unknowns, parts: vec![part], before: known, free: self.free_of(arc) };
        let mut ended = stage.maximise(theta, rounds, &mut |_| {}).map_err(|found| self.failed(found))?;
        Ok((ended.theta, ended.messages.pop().ok_or(JointError::NotPositive)?))
    }

    /// −2 ln of the posterior density, up to a constant of the arc.
    fn objective(&self, known: &Knowledge, (theta, message): &Heard) -> f64 {
        message.chi2 + message.log_determinant + known.chi2(&deviations(&self.unknowns, theta))
    }

    /// The same at `theta`, without sensitivities.
    fn objective_at(&self, arc: usize, known: &Knowledge, theta: &[f64]) -> Option<f64> {
        let (session, own) = (&self.sessions[arc], self.of_arc(arc, theta));
        let linearised = LinearisedProblem::new(session, &session.problem.plant, &own, &session.noise).ok()?;
        let normal = linearised.normal(session, &own, &session.noise, &[])?;
        Some(normal.objective - prior_chi2(session, &own) + known.chi2(&deviations(&self.unknowns, theta)))
    }
}

/// The combinations of parameters that `message` tells of and does not settle, the least known
/// first, each one standard deviation of what was `known` long. With `Λ = L L'`, `L⁻¹ N L⁻' = Σ a v v'`,
/// they are `L⁻' v`.
fn combinations(known: &Knowledge, message: &Message) -> Option<Vec<DVector<f64>>> {
    let lower = known.factor()?.unpack();
    let half = lower.solve_lower_triangular(&message.information)?;
    let whole = lower.solve_lower_triangular(&half.transpose())?;
    let eigen = SymmetricEigen::new(0.5 * (&whole + whole.transpose()));
    let told = eigen.eigenvalues.iter().enumerate().filter(|(_, a)| (TOLD_LEAST..TOLD_MOST).contains(*a));
    let mut told: Vec<(usize, f64)> = told.map(|(k, a)| (k, *a)).collect();
    told.sort_by(|a, b| a.1.total_cmp(&b.1));
    told.into_iter().map(|(k, _)| lower.tr_solve_lower_triangular(&eigen.eigenvectors.column(k))).collect()
}
