//! Fitted models side by side, compared by pairs.

use super::decide::Class;
use super::hypothesis::Hypothesis;
use super::model::{Model, key};
use super::predict::HeldOut;
use super::screen::Looked;
use std::collections::BTreeSet;

/// Nats behind the best within which a model is kept and expanded (odds of 1.6e5), and models kept.
/// Budgets.
pub(super) const BEAM: f64 = 12.0;
const MODELS_MAX: usize = 8;
/// Turns in which the leader of a comparison by pairs may change.
const LEADERS_MAX: usize = 8;

/// A model of the pool.
pub(super) struct Entry {
    pub model: Model,
    pub held_out: Option<HeldOut>,
    pub expanded: bool,
    /// Held-out data reject it.
    pub rejected: bool,
}

/// A hypothesis without a weight, and why.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Open {
    pub what: String,
    pub why: &'static str,
}

/// All that was fitted; the first model is the plant without hypotheses.
pub(super) struct Pool {
    pub entries: Vec<Entry>,
    pub open: Vec<Open>,
    /// Laws of the first screening.
    pub looked: Vec<Looked>,
    /// Logarithm of the number of hypotheses over the prior odds: the price of a member.
    pub log_m: f64,
    /// Parts that each step of integration was taken in.
    pub parts: usize,
    /// The search began about sets that lead on a beginning of the recordings.
    pub is_led: bool,
    /// Keys of all sets that were tried.
    pub seen: BTreeSet<String>,
    /// Work of a fit, and of a look at the catalogue about a model. A mean: what one law costs,
    /// which may be a hundred times what others do, must not end the search for these.
    pub fits: Cost,
    pub looks: Cost,
    /// The search met the limit of its work before a model was expanded that may be the leader's
    /// equal.
    pub is_unfinished: bool,
}

/// Work of several of a kind.
#[derive(Clone, Copy, Default)]
pub(super) struct Cost {
    sum: f64,
    count: f64,
    most: f64,
}

impl Cost {
    pub(super) fn add(&mut self, work: f64) {
        self.sum += work;
        self.count += 1.0;
        self.most = self.most.max(work);
    }

    pub(super) fn mean(self) -> f64 {
        self.sum / self.count.max(1.0)
    }

    pub(super) fn most(self) -> f64 {
        self.most
    }
}

/// A set without noise that is not stated.
pub(super) fn without_noise(set: &[Hypothesis]) -> Vec<Hypothesis> {
    set.iter().filter(|own| own.class() != Class::Noise).cloned().collect()
}

impl Pool {
    /// Evidence and held-out nats of an entry with the prior of its set, before tempering.
    pub(super) fn score(&self, entry: &Entry) -> f64 {
        let held_out = entry.held_out.as_ref().map_or(0.0, HeldOut::log_evidence);
        entry.model.log_marginal + held_out - self.log_m * entry.model.set.len() as f64
    }

    /// Nats of `a` ahead of `b`, gains in likelihood tempered.
    pub(super) fn ahead(&self, a: usize, b: usize) -> f64 {
        let [ours, theirs] = [a, b].map(|place| &self.entries[place]);
        let mut ahead = self.score(ours) - self.score(theirs);
        let [whole, counts] = ours.model.terms.tempered(&theirs.model.terms);
        ahead += counts - whole;
        match (&ours.held_out, &theirs.held_out) {
            (Some(own), Some(other)) => {
                // an error of the parameters that held-out data correct goes one way for long
                let [whole, counts] = own.found.tempered(&other.found);
                ahead += counts - whole;
            }
            // a plant that does not survive what another one predicts
            (Some(own), None) => ahead -= own.log_evidence(),
            (None, Some(other)) => ahead += other.log_evidence(),
            (None, None) => {}
        }
        ahead
    }

    /// The model that no other one is ahead of.
    pub(super) fn best(&self) -> usize {
        let alive = || (0..self.entries.len()).filter(|place| !self.entries[*place].rejected);
        let scores: Vec<f64> = self.entries.iter().map(|entry| self.score(entry)).collect();
        let mut best = alive().max_by(|a, b| scores[*a].total_cmp(&scores[*b])).unwrap_or(0);
        for _ in 0..LEADERS_MAX {
            let Some(other) = alive()
                .filter(|place| *place != best)
                .max_by(|a, b| self.ahead(*a, best).total_cmp(&self.ahead(*b, best)))
            else {
                break;
            };
            if self.ahead(other, best) <= 0.0 {
                break;
            }
            best = other;
        }
        best
    }

    /// The best of the models that one contains; the plant alone where none is left.
    pub(super) fn nearest_part(&self, place: usize) -> usize {
        let contained = |other: &usize| {
            let other = &self.entries[*other];
            !other.rejected && self.entries[place].model.holds(&other.model)
        };
        let all = (0..self.entries.len()).filter(contained);
        all.max_by(|a, b| self.ahead(*a, place).total_cmp(&self.ahead(*b, place))).unwrap_or(0)
    }

    /// The best living model within the beam of one that is no part of it.
    pub(super) fn rival(&self, place: usize) -> Option<usize> {
        let is_rival = |other: &usize| {
            let own = &self.entries[*other];
            let is_part = self.entries[place].model.holds(&own.model);
            *other != place && !own.rejected && !is_part && self.ahead(*other, place) > -BEAM
        };
        let all = (0..self.entries.len()).filter(is_rival);
        all.max_by(|a, b| self.ahead(*a, place).total_cmp(&self.ahead(*b, place)))
    }

    /// The entry is the leader without one of its findings, which meets its rivals about it beside
    /// all others; they have met where the search was led to the leader.
    fn is_leader_without(&self, place: usize, best: usize) -> bool {
        if self.is_led {
            return false;
        }
        let [entry, leader] = [place, best].map(|place| &self.entries[place].model);
        leader.holds(entry) && matches!(&leader.beyond(entry)[..], [own] if own.class() != Class::Noise)
    }

    /// The best model without a finding: the plant alone, or with noise that is not stated.
    pub(super) fn quiet(&self) -> usize {
        let is_quiet = |place: &usize| {
            let entry = &self.entries[*place];
            !entry.rejected && without_noise(&entry.model.set).is_empty()
        };
        let all = (0..self.entries.len()).filter(is_quiet);
        all.max_by(|a, b| self.ahead(*a, 0).total_cmp(&self.ahead(*b, 0))).unwrap_or(0)
    }

    /// Posterior weight of every entry.
    pub(super) fn weights(&self) -> Vec<f64> {
        let best = self.best();
        let of = |place: usize| if self.entries[place].rejected { 0.0 } else { libm::exp(self.ahead(place, best)) };
        let raw: Vec<f64> = (0..self.entries.len()).map(of).collect();
        let whole: f64 = raw.iter().sum();
        raw.into_iter().map(|weight| weight / whole.max(f64::MIN_POSITIVE)).collect()
    }

    /// Nats of an entry ahead of the plant without a finding, everything counted.
    pub(super) fn log_odds(&self, place: usize) -> f64 {
        self.ahead(place, self.quiet())
    }

    /// The same of the fitted recordings alone, no gain tempered: as the evidence of a law is.
    pub(super) fn log_odds_here(&self, place: usize) -> f64 {
        let [own, quiet] = [place, self.quiet()].map(|place| &self.entries[place].model);
        let more = own.set.len() as f64 - quiet.set.len() as f64;
        own.log_marginal - quiet.log_marginal - self.log_m * more
    }

    /// The best model within the beam that has not been expanded.
    pub(super) fn next(&self) -> Option<usize> {
        self.next_within(BEAM)
    }

    /// The same of those that so many nats lie behind the leader at most.
    pub(super) fn next_within(&self, nats: f64) -> Option<usize> {
        let best = self.best();
        self.open(nats).max_by(|a, b| self.ahead(*a, best).total_cmp(&self.ahead(*b, best)))
    }

    /// All of those.
    pub(super) fn open(&self, nats: f64) -> impl Iterator<Item = usize> {
        let best = self.best();
        let is_open = move |place: &usize| {
            let entry = &self.entries[*place];
            let is_near = self.ahead(*place, best) > -nats || self.is_leader_without(*place, best);
            !entry.expanded && !entry.rejected && is_near && !self.is_known(entry)
        };
        (0..self.entries.len()).filter(is_open)
    }

    /// What is met about an entry was met about one of the same laws and all of its noise, of which
    /// it has some: there in the place of noise.
    fn is_known(&self, entry: &Entry) -> bool {
        let laws = |entry: &Entry| key(&without_noise(&entry.model.set), &entry.model.problem);
        let own = laws(entry);
        let has_met = |other: &Entry| other.expanded && other.model.holds(&entry.model) && laws(other) == own;
        own != entry.model.key() && self.entries.iter().any(has_met)
    }

    /// Only the plant alone, the best model without a finding and the best ones within the beam
    /// stay; where the best one is then.
    pub(super) fn prune(&mut self) -> usize {
        let (best, quiet) = (self.best(), self.quiet());
        let alive = (1..self.entries.len()).filter(|place| !self.entries[*place].rejected);
        let mut order: Vec<(f64, usize)> = alive.map(|place| (self.ahead(place, best), place)).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        let stays =
            |(ahead, place): &(f64, usize)| *ahead > -BEAM || *place == best || self.is_leader_without(*place, best);
        let kept = order.into_iter().filter(stays).take(MODELS_MAX);
        let mut kept: Vec<usize> = kept.map(|(_, place)| place).chain([0, quiet, best]).collect();
        kept.sort_unstable();
        kept.dedup();
        let mut place = 0;
        self.entries.retain(|_| {
            place += 1;
            kept.contains(&(place - 1))
        });
        kept.iter().position(|own| *own == best).unwrap_or(0)
    }
}
