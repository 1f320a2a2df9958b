//! Search over sets of hypotheses: a pool of fitted models, of which the best ones grow and shrink.
//!
//! Each turn takes the best model of the pool that has not been expanded and that lies within the
//! beam of the best one: hypotheses are proposed about it, alone and in pairs, and each of its
//! members is taken out. Noise that was adopted early hides physics: laws are proposed in its
//! place, too. One path is not the posterior: a single law that leads may
//! keep the right pair from ever being met, and several sets live side by side. A leader stands
//! where its lead stays as its steps of integration are halved; else the whole pool moves to finer
//! steps.

use super::alias::apart;
use super::decide::{LEVEL, PRIOR_ODDS, SAME};
use super::disturbed::of_disturbances;
use super::exact::exact;
use super::hypothesis::Hypothesis;
use super::model::{Ground, Model, fitted, key, settled};
use super::noise::unstated;
use super::pool::{BEAM, Cost, Entry, Open, Pool, without_noise};
use super::predict::predicted;
use super::propose::{Proposal, WORTH, proposals};
use super::screen::screen;
use super::sharpness::sharpened;
use super::starts::{at_starts, fitted_numbers, starts};
use super::timing::shift_of;
use crate::diagnose::Options;
use crate::outline::{FITTED_SET_ROUNDS, Outline};
use identification::fit::EstimationSession;
use std::collections::BTreeSet;

/// Models that are expanded at most. A budget: twice the models that are kept, so that the leader
/// of a short recording does not hang on the order in which they are met.
const EXPANSIONS_MAX: usize = 16;
/// Members that a leader loses at the end of a search. A budget.
const SHRINKINGS_MAX: usize = 4;
/// Parts of a step of integration at most, and change of an evidence from which steps are halved:
/// one nat, as [`SAME`].
const PARTS_MAX: usize = 8;

/// Searches from `bare`, the plant without hypotheses, and from the sets of `leads`.
///
/// Cost: a screening and some ten fits for each expansion; bounded by the session's work.
pub(super) fn searched(
    session: &EstimationSession<'_>,
    (bare, leads): (Model, &[Model]),
    options: &Options,
    outline: &mut Outline<'_>,
) -> Pool {
    let mut pool = Pool {
        entries: Vec::new(),
        open: Vec::new(),
        looked: Vec::new(),
        log_m: 0.0,
        parts: 1,
        is_led: !leads.is_empty(),
        seen: BTreeSet::from([bare.key()]),
        fits: Cost::default(),
        looks: Cost::default(),
        is_unfinished: false,
    };
    let mut own = session.clone();
    pool.enter(Ground { session: &own }, bare, options);
    pool.fits.add(FITTED_SET_ROUNDS * session.round_work());
    pool.disturb(Ground { session: &own }, options);
    for lead in leads {
        pool.fit(Ground { session: &own }, &lead.set, (lead, &lead.noise), f64::INFINITY, options);
    }
    let mut leader = 0;
    let mut dearest = 0.0f64;
    for turn in 0..EXPANSIONS_MAX {
        let Some(next) = pool.next() else { break };
        let begun = session.work.spent();
        if !session.work.allows(pool.looks.mean() + pool.fits.mean(), "sets of hypotheses") {
            break;
        }
        let open = pool.open(BEAM).count().min(EXPANSIONS_MAX - turn);
        outline.expansion(turn, dearest, open - 1);
        let is_whole = pool.expand(Ground { session: &own }, next, options);
        pool.entries[next].expanded = is_whole;
        let mut best = pool.best();
        let is_new = best != leader;
        while is_new && best != 0 && pool.moves(session, &mut own, best) {
            pool.refit(Ground { session: &own }, options);
            best = pool.best();
        }
        leader = pool.prune();
        dearest = dearest.max(session.work.spent() - begun);
        if !is_whole {
            break;
        }
    }
    if pool.next().is_some() {
        pool.is_unfinished = pool.next_within(libm::log(LEVEL / (1.0 - LEVEL))).is_some();
        pool.open.push(Open { what: "further sets".to_owned(), why: "search not finished" });
    }
    pool.shrink(Ground { session: &own }, options);
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

    /// The plant alone with disturbances of unspecified size: where these are large, a look about
    /// a plant that has none finds them under the names of laws.
    fn disturb(&mut self, ground: Ground<'_>, options: &Options) {
        let Some(bare) = self.entries.first().map(|entry| entry.model.clone()) else { return };
        for Proposal { set, noise, .. } in of_disturbances(ground, &bare) {
            self.fit(ground, &set, (&bare, &noise), bare.objective, options);
        }
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

    /// Fits what is proposed about an entry: what promises something, then the entry without each
    /// of its members, then what promises nothing; `false` where work ended before.
    fn expand(&mut self, ground: Ground<'_>, place: usize, options: &Options) -> bool {
        self.entries[place].expanded = true;
        let begun = ground.session.work.spent();
        let model = self.entries[place].model.clone();
        let mut is_whole = true;
        let Some(screened) = screen(ground, &model, &options.without) else { return is_whole };
        if self.looked.is_empty() {
            self.looked.clone_from(&screened.looked);
            let numbers = model.problem.unknowns.len() + model.problem.plant.sensors.len();
            let numbers = numbers + exact(&model.problem.plant).len() + unstated(ground.session).count();
            self.log_m = libm::log(((screened.rated.len() + numbers).max(1)) as f64 / PRIOR_ODDS);
        }
        let (list, beyond) = proposals(ground, &model, &screened, self.log_m);
        self.looks.add(ground.session.work.spent() - begun);
        let (promising, others): (Vec<Proposal>, Vec<Proposal>) =
            list.into_iter().partition(|own| own.log_bayes > WORTH);
        let count = promising.len() + others.len();
        let mut left = (1..=count).rev();
        for own in promising {
            self.plan(ground.session, (place, left.next().unwrap_or(0), count));
            is_whole &= self.propose(ground, &model, own, options);
        }
        for set in smaller(&model.set) {
            is_whole &= self.fit(ground, &set, (&model, &model.noise), f64::INFINITY, options);
        }
        for own in others {
            self.plan(ground.session, (place, left.next().unwrap_or(0), count));
            is_whole &= self.propose(ground, &model, own, options);
        }
        let beyond = beyond.into_iter().filter(|own| !self.open.iter().any(|known| known.what == *own));
        let beyond: Vec<Open> = beyond.map(|what| Open { what, why: "beyond the budget of fits" }).collect();
        self.open.extend(beyond);
        is_whole
    }

    /// Fits what is proposed about an entry; `false` where work does not allow it.
    fn propose(&mut self, ground: Ground<'_>, model: &Model, own: Proposal, options: &Options) -> bool {
        let Proposal { set, noise, instead, .. } = own;
        let before = self.entries.len();
        let kept = if instead { without_noise(&model.set) } else { model.set.clone() };
        let joined = [&kept[..], &set].concat();
        // inputs at another time hold none of what is fitted
        let is_part = !instead && shift_of(&set).is_none();
        let contained = if is_part { model.objective } else { f64::INFINITY };
        let is_done = self.fit(ground, &joined, (model, &noise), contained, options);
        // the set, not its laws: what else is missing turns the estimate of a right law
        if let Some(entry) = self.entries.get(before).filter(|entry| entry.rejected) {
            self.open.push(Open { what: entry.model.key(), why: "held-out data reject this set" });
        }
        is_done
    }

    /// Plans the `left` ones of `count` fits about an entry; of the first one as much again about
    /// what is ahead of it.
    fn plan(&self, session: &EstimationSession<'_>, (place, left, count): (usize, usize, usize)) {
        let now = self.fits.most() * left as f64;
        let is_first = self.entries.iter().filter(|entry| entry.expanded).count() == 1;
        match is_first && self.best() != place {
            false => session.work.plan_now(now),
            true => session.work.plan(now, self.looks.mean() + self.fits.mean() * count as f64),
        }
    }

    /// Fits a set once, and again from another start of a frequency or an order: these have many
    /// maxima, and the one that is found while another law is missing need not be that beside it.
    /// `false`: work does not allow it.
    fn fit(
        &mut self,
        ground: Ground<'_>,
        set: &[Hypothesis],
        (from, noise): (&Model, &identification::filter::NoiseModel),
        contained: f64,
        options: &Options,
    ) -> bool {
        let (name, work) = (key(set, ground.session.problem), &ground.session.work);
        let starts = starts(set, from);
        let again = self.seen.contains(&name).then(|| at_starts(&name, &starts));
        let is_new =
            again.as_ref().is_none_or(|own| !self.seen.contains(own) && self.is_another_maximum(&name, &starts));
        if !is_new {
            return true;
        }
        if !work.allows(self.fits.mean(), "sets of hypotheses") {
            return false;
        }
        self.seen.insert(again.clone().unwrap_or_else(|| name.clone()));
        self.fit_from(ground, set, (from, noise), (contained, again.is_some()), options);
        true
    }

    /// Fits a set, from `another` start than before where it was fitted.
    fn fit_from(
        &mut self,
        ground: Ground<'_>,
        set: &[Hypothesis],
        (from, noise): (&Model, &identification::filter::NoiseModel),
        (contained, another): (f64, bool),
        options: &Options,
    ) {
        let (name, work) = (key(set, ground.session.problem), &ground.session.work);
        let begun = work.spent();
        let begin = super::model::Begin { noise, ..from.begin() };
        let found = fitted(ground, set, begin, contained).or_else(|| fitted(ground, set, from.begin(), contained));
        // signs of known laws turn as they did, beside a law that gains nothing
        let evidence = |model: &Model| model.log_marginal - self.log_m * model.set.len() as f64;
        let found = found.map(|own| {
            let known = if evidence(&own) > evidence(from) { &[] } else { &from.set[..] };
            sharpened(ground, own, known)
        });
        match found {
            // one mode counts once
            Some(model) if !another || self.is_another_maximum(&name, &fitted_numbers(&model)) => {
                self.enter(ground, model, options);
            }
            Some(_) => {}
            None => self.open.push(Open { what: name, why: "not fitted" }),
        }
        self.fits.add(work.spent() - begun);
    }

    /// The leader without each of its members, as long as one of these leads instead: a search that
    /// ends early has not met them, one that moved to finer steps has left them on coarse ones.
    fn shrink(&mut self, ground: Ground<'_>, options: &Options) {
        for _ in 0..SHRINKINGS_MAX {
            let best = self.best();
            if self.entries[best].expanded && self.parts == 1 {
                break;
            }
            let model = self.entries[best].model.clone();
            for set in smaller(&model.set) {
                let name = key(&set, ground.session.problem);
                if !self.entries.iter().any(|entry| entry.model.key() == name) {
                    self.fit_from(ground, &set, (&model, &model.noise), (f64::INFINITY, false), options);
                }
            }
            if self.best() == best {
                break;
            }
        }
    }

    /// The evidence of the leader over its nearest rival changes by more than a nat as steps are
    /// halved, or that over the nearest model that it contains, where this lead does not stand
    /// beyond the beam whatever the steps: `own` then takes the halved ones. An error of first
    /// order is twice its change.
    fn moves(&mut self, session: &EstimationSession<'_>, own: &mut EstimationSession<'_>, place: usize) -> bool {
        if 2 * self.parts > PARTS_MAX {
            return false;
        }
        let Ok(finer) = session.in_parts(2 * self.parts) else { return false };
        let again = |place: usize| Some(refitted(Ground { session: &finer }, &self.entries[place].model)?.log_marginal);
        let change = |place: usize| Some(again(place)? - self.entries[place].model.log_marginal);
        let ours = change(place);
        let moved = |other: usize| Some((ours? - change(other)?).abs());
        let part = self.nearest_part(place);
        let is_felt = |moved: f64| moved >= 0.5 * SAME;
        let turns_part = moved(part).is_some_and(|by| is_felt(by) && self.ahead(place, part) - 2.0 * by < BEAM);
        if !turns_part && !self.rival(place).and_then(moved).is_some_and(is_felt) {
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

/// A set without all noise that is not stated, where it has some, and without each of its members.
fn smaller(set: &[Hypothesis]) -> Vec<Vec<Hypothesis>> {
    let white = without_noise(set);
    let without = |gone: usize| [&set[..gone], &set[gone + 1..]].concat();
    let is_noisy = white.len() < set.len();
    is_noisy.then_some(white).into_iter().chain((0..set.len()).map(without)).collect()
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
