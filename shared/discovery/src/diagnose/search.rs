//! Greedy forward search with backward elimination.
//!
//! Sets of effects are added to the plant round by round; an effect that later ones make
//! insignificant is removed.

use super::adoption::{SearchRound, step};
use super::next::is_open;
use super::screening::{Screening, screen};
use super::{Adopted, Options, Phase, RIVAL_SPAN, RivalEffect, Unfitted};
use crate::compete::{BIC_PREFERENCE, FittedModel, free_parameters, multistart, refine_onsets, weights};
use crate::next_experiment::entries;
use crate::outline::{Found, Outline};
use crate::score::{Column, cosine};
use identification::fit::EstimationSession;
use std::rc::Rc;

/// Result of the search.
pub(super) struct SearchResult {
    pub best: FittedModel,
    pub adopted: Vec<Adopted>,
    pub unfitted: Vec<Unfitted>,
    /// The scored catalogue on the nominal plant.
    pub screening: Rc<Screening>,
    /// Smaller sets accepted on the way, nearest first.
    pub smaller: Vec<(Vec<Adopted>, FittedModel)>,
    /// Sets that the recording does not exclude beside the last one adopted, and their ΔBIC.
    pub rivals: Vec<(Vec<Adopted>, FittedModel, f64)>,
    /// Gain of a different noise model on the accepted plant [−2 ln p].
    pub unknown_noise: f64,
}

/// Adds sets of effects to the nominal plant until no further effect is accepted. The catalogue is
/// scored on it, unless `screened` has columns.
///
/// Cost: for each round a screening, the likelihoods of the shortlist and their fits; bounded by
/// `session.work`.
pub(super) fn searched(
    session: &EstimationSession<'_>,
    (nominal, screened): (FittedModel, Rc<Screening>),
    options: &Options,
    outline: &mut Outline<'_>,
) -> Result<SearchResult, String> {
    let mut found = SearchResult::nominal(nominal, screened);
    let mut last: Option<(FittedModel, usize)> = None;
    let mut begun = session.work.spent();
    for round in 0..options.terms_max {
        if found.adopted.len() >= options.terms_max || !found.unfitted.is_empty() {
            break;
        }
        if !session.work.goes_on("a further effect") {
            break;
        }
        if round > 0 && !session.work.allows(session.work.spent() - begun, "a further effect") {
            break;
        }
        begun = session.work.spent();
        let joined = found.round(session, options, outline)?;
        outline.round_ended(&found.outlook(session, joined.is_some() && round + 1 < options.terms_max, options));
        let Some(joined) = joined else { break };
        last = Some(joined);
    }
    if let Some((refit, earlier)) = last {
        let refit = if earlier > 0 {
            outline.begin(Phase::SearchAgain);
            found.look_again(session, refit, (earlier, begun), options)
        } else {
            refit
        };
        found.prune(session, refit);
        found.simplify(session);
    }
    found.rivals.retain(|(.., behind)| *behind <= RIVAL_SPAN);
    Ok(found)
}

impl SearchResult {
    pub(super) fn nominal(best: FittedModel, screening: Rc<Screening>) -> Self {
        let (adopted, unfitted, smaller, rivals) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { best, adopted, unfitted, screening, smaller, rivals, unknown_noise: 0.0 }
    }

    /// Adopts the set that fits best on the accepted model: its fit, and the number of effects
    /// adopted before; `None` where no further effect is accepted.
    fn round(
        &mut self,
        session: &EstimationSession<'_>,
        options: &Options,
        outline: &mut Outline<'_>,
    ) -> Result<Option<(FittedModel, usize)>, String> {
        outline.begin(Phase::Score);
        let own = EstimationSession::like(session, &self.best.problem).map_err(|error| error.to_string())?;
        let is_known = self.adopted.is_empty() && !self.screening.columns.is_empty();
        let screened = if is_known { self.screening.clone() } else { Rc::new(screen(&own, &self.best, options)) };
        outline.begin(Phase::Compare);
        let mut step = step(&own, &self.best, &screened, options.terms_max - self.adopted.len(), options);
        self.unfitted = core::mem::take(&mut step.unfitted);
        if self.adopted.is_empty() {
            self.screening = screened;
        }
        match step.refit.take() {
            Some(refit) => Ok(Some(self.join(session, step, refit))),
            None => {
                self.unknown_noise = (self.best.objective - step.null).max(0.0);
                Ok(None)
            }
        }
    }

    /// What the work that follows depends on.
    fn outlook(&self, session: &EstimationSession<'_>, goes_on: bool, options: &Options) -> Found {
        let adopted = self.adopted.len();
        let goes_on = goes_on && adopted < options.terms_max && self.unfitted.is_empty();
        let others = if options.held_out.is_some() { self.rivals.len() } else { 0 };
        let experiments =
            if options.next_experiment && is_open(&self.adopted) { entries(&session.problem.plant) } else { 0 };
        Found { adopted, goes_on, others, experiments }
    }

    /// Adopts the effects of `step`; earlier effects that are insignificant beside them are
    /// removed.
    fn join(&mut self, session: &EstimationSession<'_>, step: SearchRound, refit: FittedModel) -> (FittedModel, usize) {
        // nearest first: without the effects of this round, then its own smaller sets before that
        let joined = |set: Vec<Adopted>| self.adopted.iter().cloned().chain(set).collect::<Vec<_>>();
        let mut nearest: Vec<(Vec<Adopted>, FittedModel)> =
            step.smaller.into_iter().map(|(set, refit)| (joined(set), refit.merged())).collect();
        self.rivals =
            step.rivals.into_iter().map(|(set, refit, behind)| (joined(set), refit.merged(), behind)).collect();
        let (refit, left) = relieved(session, refit, &self.adopted);
        let before = core::mem::replace(&mut self.best, refit.merged());
        let gained = before.objective - self.best.objective;
        if left.contains(&true) {
            // they hold a removed effect
            self.rivals.clear();
            nearest.clear();
        } else if !self.adopted.is_empty() {
            nearest.push((self.adopted.clone(), before));
        }
        nearest.append(&mut self.smaller);
        self.smaller = nearest;
        let earlier = core::mem::take(&mut self.adopted).into_iter();
        let (gone, stay) = earlier.zip(left).partition::<Vec<_>, _>(|(_, left)| *left);
        self.adopted = stay.into_iter().map(|(adopted, _)| adopted).collect();
        let mut new = step.adopted;
        if let ([new], [(gone, _)]) = (&mut new[..], &gone[..])
            && self.adopted.is_empty()
        {
            new.replace(gone, gained, session.samples.max(2) as f64);
        }
        let earlier = self.adopted.len();
        self.adopted.extend(new);
        (refit, earlier)
    }

    /// Searches again for each of the `earlier` effects beside those of the last round, which began
    /// at the work `begun`.
    fn look_again(
        &mut self,
        session: &EstimationSession<'_>,
        refit: FittedModel,
        (earlier, begun): (usize, f64),
        options: &Options,
    ) -> FittedModel {
        let before = self.best.objective;
        // the earlier local optima belong to a smaller set
        let mut refit = self.multistart(session, refit);
        // about one round
        let mut looked = session.work.spent() - begun;
        for place in 0..earlier {
            if !session.work.allows(looked, "another search for earlier effects") {
                break;
            }
            let begun = session.work.spent();
            refit = match reconsidered(session, &refit, self, place, options) {
                Some(better) => self.multistart(session, better),
                None => refit,
            };
            looked = looked.max(session.work.spent() - begun);
        }
        self.unknown_noise = (self.unknown_noise + self.best.objective - before).max(0.0);
        refit
    }

    /// Backward elimination: an effect that another one has made insignificant is removed; the most
    /// significant one stays.
    fn prune(&mut self, session: &EstimationSession<'_>, refit: FittedModel) {
        let mut others = self.adopted.clone();
        others.sort_by(|a, b| refit.evidence(&a.column).total_cmp(&refit.evidence(&b.column)));
        others.pop();
        let before = refit.objective;
        let (refit, left) = relieved(session, refit, &others);
        if !left.contains(&true) {
            return;
        }
        let gone: Vec<Adopted> = others.into_iter().zip(left).filter_map(|(own, left)| left.then_some(own)).collect();
        let is_gone = |own: &Adopted| gone.iter().any(|gone| own.column.candidate.same_law(&gone.column.candidate));
        let price = libm::log(session.samples.max(2) as f64) * gone.iter().map(Adopted::parameter_count).sum::<f64>();
        let gained = before - refit.objective + price;
        self.best = refit.merged();
        self.adopted.retain(|own| !is_gone(own));
        self.rivals.retain(|(set, ..)| !set.iter().any(is_gone));
        self.rivals.iter_mut().for_each(|(.., behind)| *behind += gained);
        self.smaller.retain(|(set, _)| set.len() < self.adopted.len() && !set.iter().any(is_gone));
    }

    /// Multistart of `refit` over all adopted effects; its result is the accepted model.
    fn multistart(&mut self, session: &EstimationSession<'_>, refit: FittedModel) -> FittedModel {
        let columns: Vec<&Column> = self.adopted.iter().map(|adopted| &adopted.column).collect();
        let refit = multistart(session, refine_onsets(session, refit, &columns), &columns);
        let gained = self.best.objective - refit.objective;
        self.rivals.iter_mut().for_each(|(.., behind)| *behind += gained);
        self.best = refit.merged();
        refit
    }

    /// The adopted effects, with another effect at `place`.
    fn with(&self, place: usize, other: Adopted) -> Vec<Adopted> {
        let mut set = self.adopted.clone();
        set[place] = other;
        set
    }
}

/// Searches again for the effect at `place` beside all others: the best single effect need not be
/// the best beside them. A better one by BIC replaces it, and its fit is returned; effects that the
/// recording does not exclude there join the rivals.
///
/// Cost: a round of the search.
fn reconsidered(
    session: &EstimationSession<'_>,
    refit: &FittedModel,
    found: &mut SearchResult,
    place: usize,
    options: &Options,
) -> Option<FittedModel> {
    let gone = found.adopted[place].clone();
    let without = refit.without(session, &gone.column)?.merged();
    let own = EstimationSession::like(session, &without.problem).ok()?;
    let screened = screen(&own, &without, options);
    let step = step(&own, &without, &screened, 1, options);
    let (again, new) = (step.refit?, step.adopted.into_iter().next()?);
    let same = |other: &Adopted| other.column.candidate.same_law(&gone.column.candidate);
    let price = libm::log(session.samples.max(2) as f64) * (new.parameter_count() - gone.parameter_count());
    let ahead = refit.objective - again.objective - price;
    let wins = ahead > BIC_PREFERENCE;
    // of this round's winner
    let behind = if wins { 0.0 } else { (-ahead).max(0.0) };
    let others = step.rivals.iter().filter_map(|(set, rival, more)| Some((set.first()?, rival, behind + more)));
    let all = (!wins).then_some((&new, &again, behind)).into_iter().chain(others);
    let rivals = all.filter(|(other, ..)| !same(other));
    let rivals: Vec<_> =
        rivals.map(|(other, rival, behind)| (found.with(place, other.clone()), rival.merged(), behind)).collect();
    if wins {
        found.rivals.iter_mut().for_each(|(.., behind)| *behind += ahead);
        if !same(&new) {
            found.rivals.push((found.adopted.clone(), found.best.clone(), ahead));
        }
        found.best = again.merged();
    }
    found.rivals.extend(rivals);
    found.adopted[place] = if wins || same(&new) { new } else { gone.beside(&new, behind) };
    wins.then_some(again)
}

impl Adopted {
    /// Number of its free parameters.
    pub(super) fn parameter_count(&self) -> f64 {
        free_parameters(&self.column.candidate, self.column.raw.len()) as f64
    }

    /// Replaces `gone`, the only effect, with a gain in `−2 ln p`: `gone` becomes a rival, and the
    /// p value is the larger of both.
    fn replace(&mut self, gone: &Self, gained: f64, samples: f64) {
        let behind = gained + libm::log(samples) * (gone.parameter_count() - self.parameter_count());
        self.p = self.p.max(gone.p);
        self.d = (gone.d * gone.d + gained).max(0.0).sqrt();
        self.rivals.push(self.rival_effects(gone, behind));
        self.weigh();
    }

    /// With the rivals of `other`, which has the ΔBIC `behind`, for its own.
    pub(super) fn beside(mut self, other: &Self, behind: f64) -> Self {
        let is_self = |rival: &&RivalEffect| self.column.candidate.same_law(&rival.candidate);
        let theirs = other.rivals.iter().filter(|rival| !is_self(rival));
        let theirs = theirs.map(|rival| RivalEffect { bic: rival.bic + behind, ..rival.clone() });
        self.rivals = core::iter::once(self.rival_effects(other, behind)).chain(theirs).collect();
        self.weigh();
        self
    }

    /// `other` as a rival of ΔBIC `behind`.
    fn rival_effects(&self, other: &Self, behind: f64) -> RivalEffect {
        let candidate = other.column.candidate.clone();
        let (kind, site) = (candidate.effect.kind, candidate.site.to_string());
        RivalEffect { candidate, kind, site, weight: 0.0, bic: behind, cosine: cosine(&self.score, &other.score) }
    }

    /// Weights by BIC; beyond the span there is no rival.
    fn weigh(&mut self) {
        self.rivals.retain(|rival| rival.bic <= RIVAL_SPAN);
        let bic: Vec<f64> = core::iter::once(0.0).chain(self.rivals.iter().map(|rival| rival.bic)).collect();
        let weights = weights(&bic, RIVAL_SPAN);
        self.weight = weights[0];
        self.rivals.iter_mut().zip(&weights[1..]).for_each(|(rival, weight)| rival.weight = *weight);
    }
}

/// `refit` without the effects of `adopted` that are insignificant beside later ones, where BIC
/// agrees; which of them were removed.
fn relieved(session: &EstimationSession<'_>, refit: FittedModel, adopted: &[Adopted]) -> (FittedModel, Vec<bool>) {
    let price = libm::log(session.samples.max(2) as f64);
    let mut best = refit;
    let leaves = |earlier: &Adopted| {
        let column = &earlier.column;
        let found = best.amplitude_insignificant(column).then(|| best.without(session, column)).flatten();
        let found = found.filter(|found| found.objective < best.objective + price * earlier.parameter_count());
        found.map(|found| best = found).is_some()
    };
    let left = adopted.iter().map(leaves).collect();
    (best, left)
}
