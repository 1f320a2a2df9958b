//! Search over sets of hypotheses: a pool of fitted models, of which the best ones grow and shrink.
//!
//! Each turn takes the best model of the pool that has not been expanded and that lies within the
//! beam of the best one: hypotheses are proposed about it, alone and in pairs, and each of its
//! members is taken out. Coloured noise that was adopted early hides physics: the leader without it
//! is expanded however far behind it is. One path is not the posterior: a single law that leads may
//! keep the right pair from ever being met, and several sets live side by side. A leader stands
//! where its evidence stays as its steps of integration are halved; else the whole pool moves to
//! finer steps.

use super::alias::apart;
use super::decide::{LEVEL, PRIOR_ODDS, SAME};
use super::exact::exact;
use super::hypothesis::{Hypothesis, InnerPrior, unknown_of};
use super::model::{Ground, Model, fitted, key, settled};
use super::pool::{Entry, Open, Pool, without_colour};
use super::predict::predicted;
use super::propose::{Proposal, proposals};
use super::screen::screen;
use super::timing::shift_of;
use crate::diagnose::Options;
use crate::outline::{Outline, SET_ROUNDS};
use identification::fit::EstimationSession;
use std::collections::BTreeSet;

/// Models that are expanded at most. A budget.
const EXPANSIONS_MAX: usize = 8;
/// Standard errors of a frequency or an order from which another start is another maximum.
const MODE_SIGMA: f64 = 5.0;
/// Parts of a step of integration at most, and change of an evidence from which steps are halved:
/// one nat, as [`SAME`].
const PARTS_MAX: usize = 8;

/// Searches from `bare`, the plant without hypotheses.
///
/// Cost: a screening and some ten fits for each expansion; bounded by the session's work.
pub(super) fn searched(
    session: &EstimationSession<'_>,
    bare: Model,
    options: &Options,
    outline: &mut Outline<'_>,
) -> Pool {
    let mut pool = Pool {
        entries: Vec::new(),
        open: Vec::new(),
        looked: Vec::new(),
        log_m: 0.0,
        parts: 1,
        seen: BTreeSet::from([bare.key()]),
        dearest: 0.0,
        is_unfinished: false,
    };
    let mut own = session.clone();
    pool.enter(Ground { session: &own }, bare, options);
    let mut leader = 0;
    let mut dearest = 0.0f64;
    for turn in 0..EXPANSIONS_MAX {
        let Some(next) = pool.next() else { break };
        let begun = session.work.spent();
        if !session.work.allows(dearest, "sets of hypotheses") {
            break;
        }
        outline.expansion(turn, dearest);
        pool.expand(Ground { session: &own }, next, options);
        let mut best = pool.best();
        let is_new = best != leader;
        while is_new && best != 0 && pool.moves(session, &mut own, best) {
            pool.refit(Ground { session: &own }, options);
            best = pool.best();
        }
        leader = pool.prune();
        dearest = dearest.max(session.work.spent() - begun);
    }
    if pool.next().is_some() {
        pool.is_unfinished = pool.next_within(libm::log(LEVEL / (1.0 - LEVEL))).is_some();
        pool.open.push(Open { what: "further sets".to_owned(), why: "search not finished" });
    }
    pool.without_limits(Ground { session: &own });
    pool
}

impl Pool {
    fn enter(&mut self, ground: Ground<'_>, model: Model, options: &Options) {
        let bare = self.entries.first().map_or(&model, |entry| &entry.model);
        let other = options.held_out.as_ref();
        let held_out = other.and_then(|other| predicted(ground, other, &model, bare));
        let is_lost = self.entries.first().is_some_and(|entry| entry.held_out.is_some()) && held_out.is_none();
        self.entries.push(Entry { model, held_out, expanded: false, rejected: is_lost });
        self.reject_supersets();
    }

    /// Held-out data reject a set for any part of it that they do not reject.
    fn reject_supersets(&mut self) {
        let new = self.entries.len() - 1;
        for other in 0..new {
            for (larger, smaller) in [(new, other), (other, new)] {
                let [own, part] = [larger, smaller].map(|place| &self.entries[place]);
                if own.rejected || part.rejected || !own.model.holds(&part.model) {
                    continue;
                }
                let both = own.held_out.as_ref().zip(part.held_out.as_ref());
                let more = own.model.beyond(&part.model);
                let rejects = both.is_some_and(|(own, part)| own.rejects(&more, part));
                self.entries[larger].rejected |= rejects;
            }
        }
    }

    /// Fits what is proposed about an entry, and the entry without each of its members.
    fn expand(&mut self, ground: Ground<'_>, place: usize, options: &Options) {
        self.entries[place].expanded = true;
        let model = self.entries[place].model.clone();
        let Some(screened) = screen(ground, &model, &options.without) else { return };
        if self.looked.is_empty() {
            self.looked.clone_from(&screened.looked);
            let numbers = model.problem.unknowns.len() + model.problem.plant.sensors.len();
            let numbers = numbers + exact(&model.problem.plant).len();
            self.log_m = libm::log(((screened.rated.len() + numbers).max(1)) as f64 / PRIOR_ODDS);
        }
        let (list, left) = proposals(ground, &model, &screened, self.log_m);
        let each = self.dearest.max(SET_ROUNDS * ground.session.round_work());
        ground.session.work.plan_now(each * list.len() as f64);
        for Proposal { set, noise, .. } in list {
            let before = self.entries.len();
            let joined = [&model.set[..], &set].concat();
            // inputs at another time hold none of what is fitted
            let contained = if shift_of(&set).is_some() { f64::INFINITY } else { model.objective };
            self.fit(ground, &joined, (&model, &noise), contained, options);
            // the set, not its laws: what else is missing turns the estimate of a right law
            if let Some(entry) = self.entries.get(before).filter(|entry| entry.rejected) {
                self.open.push(Open { what: entry.model.key(), why: "held-out data reject it" });
            }
        }
        let left = left.into_iter().filter(|own| !self.open.iter().any(|known| known.what == *own));
        let left: Vec<Open> = left.map(|what| Open { what, why: "beyond the budget of fits" }).collect();
        self.open.extend(left);
        let white = without_colour(&model.set);
        if white.len() < model.set.len() {
            self.fit(ground, &white, (&model, &model.noise), f64::INFINITY, options);
        }
        for gone in 0..model.set.len() {
            let mut set = model.set.clone();
            set.remove(gone);
            self.fit(ground, &set, (&model, &model.noise), f64::INFINITY, options);
        }
    }

    /// Fits a set once, and again from another start of a frequency or an order: these have many
    /// maxima, and the one that is found while another law is missing need not be that beside it.
    fn fit(
        &mut self,
        ground: Ground<'_>,
        set: &[Hypothesis],
        (from, noise): (&Model, &identification::filter::NoiseModel),
        contained: f64,
        options: &Options,
    ) {
        let (name, work) = (key(set, ground.session.problem), &ground.session.work);
        let starts = starts(set, from);
        let again = self.seen.contains(&name).then(|| at_starts(&name, &starts));
        let is_new = again.as_ref().is_none_or(|own| !self.seen.contains(own) && self.is_another_mode(&name, &starts));
        if !is_new || !work.allows(self.dearest, "sets of hypotheses") {
            return;
        }
        self.seen.insert(again.clone().unwrap_or_else(|| name.clone()));
        let begun = work.spent();
        let begin = super::model::Begin { noise, ..from.begin() };
        let found = fitted(ground, set, begin, contained).or_else(|| fitted(ground, set, from.begin(), contained));
        match (found, again) {
            (Some(model), None) => self.enter(ground, model, options),
            // one mode counts once
            (Some(model), Some(_)) if self.is_another_mode(&name, &fitted_numbers(&model)) => {
                self.enter(ground, model, options);
            }
            (Some(_), _) => {}
            (None, _) => self.open.push(Open { what: name, why: "not fitted" }),
        }
        self.dearest = self.dearest.max(work.spent() - begun);
    }

    /// Fits of the set are in the pool, all of them far from these frequencies and orders.
    fn is_another_mode(&self, name: &str, numbers: &[SearchedNumber]) -> bool {
        let own = self.entries.iter().filter(|entry| entry.model.key() == name);
        let known: Vec<Vec<SearchedNumber>> = own.map(|entry| fitted_numbers(&entry.model)).collect();
        let is_far = |other: &SearchedNumber| {
            let own = numbers.iter().find(|own| own.name == other.name);
            own.is_some_and(|own| (own.value - other.value).abs() > MODE_SIGMA * other.sigma)
        };
        !known.is_empty() && known.iter().all(|mode| mode.iter().any(is_far))
    }

    /// The evidence of the leader over the bare plant changes by more than a nat as steps are
    /// halved: `own` then takes the halved ones.
    fn moves(&mut self, session: &EstimationSession<'_>, own: &mut EstimationSession<'_>, place: usize) -> bool {
        if 2 * self.parts > PARTS_MAX {
            return false;
        }
        let Ok(finer) = session.in_parts(2 * self.parts) else { return false };
        let again = |place: usize| Some(refitted(Ground { session: &finer }, &self.entries[place].model)?.log_marginal);
        let change = |place: usize| Some(again(place)? - self.entries[place].model.log_marginal);
        let Some((ours, theirs)) = change(place).zip(change(0)) else { return false };
        if (ours - theirs).abs() < 0.5 * SAME {
            return false;
        }
        self.parts *= 2;
        (own.timelines, own.parts) = (finer.timelines, finer.parts);
        true
    }

    /// All models within the beam on finer steps; others leave.
    fn refit(&mut self, ground: Ground<'_>, options: &Options) {
        self.prune();
        for entry in core::mem::take(&mut self.entries) {
            let expanded = entry.expanded;
            if let Some(model) = refitted(ground, &entry.model) {
                self.enter(ground, model, options);
                if let Some(own) = self.entries.last_mut() {
                    own.expanded = expanded;
                }
            }
        }
    }

    /// A model whose law stands at the limit that another model of the pool is: the same within
    /// [`SAME`] of whitened innovations. The simpler one keeps the weight of both.
    fn without_limits(&mut self, ground: Ground<'_>) {
        for child in 0..self.entries.len() {
            let parents = (0..self.entries.len()).filter(|place| *place != child);
            let is_limit = |parent: &usize| {
                let [ours, theirs] = [&self.entries[child].model, &self.entries[*parent].model];
                contains(&ours.set, &theirs.set) && apart(ground, ours, theirs).is_some_and(|apart| apart < SAME)
            };
            if parents.into_iter().any(|parent| is_limit(&parent)) {
                self.entries[child].rejected = true;
                let what = self.entries[child].model.key();
                self.open.push(Open { what, why: "in the limit of a simpler law" });
            }
        }
    }
}

/// A frequency or an order of a set, by the name of its unknown.
struct SearchedNumber {
    name: String,
    value: f64,
    sigma: f64,
}

fn searched_numbers(set: &[Hypothesis]) -> impl Iterator<Item = (String, f64)> {
    set.iter().flat_map(Hypothesis::parts).flat_map(|part| {
        let all = part.inner.iter().filter(|(_, prior)| matches!(prior, InnerPrior::LogUniform(_)));
        all.filter_map(|(name, _)| {
            let candidate = &part.column.candidate;
            let (_, value) = candidate.inner.iter().find(|(own, _)| own == name)?;
            Some((unknown_of(candidate, name), *value))
        })
    })
}

/// As they were fitted.
fn fitted_numbers(model: &Model) -> Vec<SearchedNumber> {
    let all = searched_numbers(&model.set).filter_map(|(name, _)| {
        let at = model.problem.unknowns.iter().position(|unknown| unknown.parameter == name)?;
        Some(SearchedNumber { name, value: model.fit.theta[at], sigma: model.fit.sigma[at] })
    });
    all.collect()
}

/// As a fit that begins at `from` begins at them.
fn starts(set: &[Hypothesis], from: &Model) -> Vec<SearchedNumber> {
    let known = fitted_numbers(from);
    let start = |(name, value): (String, f64)| {
        let value = known.iter().find(|own| own.name == name).map_or(value, |own| own.value);
        SearchedNumber { name, value, sigma: 0.0 }
    };
    searched_numbers(set).map(start).collect()
}

/// The key of a set from these starts, to a percent of each.
fn at_starts(name: &str, starts: &[SearchedNumber]) -> String {
    starts.iter().fold(name.to_owned(), |key, own| format!("{key} at {:.2e}", own.value))
}

/// The sets differ in one law, of which the one in `theirs` is a limit of the one in `ours`.
fn contains(ours: &[Hypothesis], theirs: &[Hypothesis]) -> bool {
    let laws = |set: &[Hypothesis]| -> Vec<(&'static dynamics::effect::Effect, String)> {
        let parts = set.iter().flat_map(Hypothesis::parts).map(|part| &part.column.candidate);
        parts.map(|candidate| (candidate.effect, candidate.site.to_string())).collect()
    };
    let (a, b) = (laws(ours), laws(theirs));
    let only = |own: &[(&'static dynamics::effect::Effect, String)],
                other: &[(&'static dynamics::effect::Effect, String)]| {
        own.iter().filter(|law| !other.contains(law)).cloned().collect::<Vec<_>>()
    };
    match (&only(&a, &b)[..], &only(&b, &a)[..]) {
        ([(child, at)], [(parent, site)]) => at == site && child.limits.iter().any(|limit| limit.kind == parent.kind),
        _ => false,
    }
}

/// The same set from its own parameters, on other steps of integration.
fn refitted(ground: Ground<'_>, model: &Model) -> Option<Model> {
    settled(ground, &model.set, model.problem.clone(), (model.start.clone(), &model.fit.theta), &model.noise)
}
