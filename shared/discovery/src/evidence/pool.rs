//! Fitted models side by side, compared by pairs.

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
    /// Keys of all sets that were tried.
    pub seen: BTreeSet<String>,
    /// Work of the dearest fit.
    pub dearest: f64,
    /// The search met the limit of its work before a model was expanded that may be the leader's
    /// equal.
    pub is_unfinished: bool,
}

/// A set without coloured noise.
pub(super) fn without_colour(set: &[Hypothesis]) -> Vec<Hypothesis> {
    set.iter().filter(|own| !matches!(own, Hypothesis::Coloured(_))).cloned().collect()
}

impl Pool {
    /// Evidence and held-out nats of an entry with the prior of its set, before tempering.
    pub(super) fn score(&self, entry: &Entry) -> f64 {
        let held_out = entry.held_out.as_ref().map_or(0.0, HeldOut::log_evidence);
        entry.model.log_marginal + held_out - self.log_m * entry.model.set.len() as f64
    }

    /// Nats of `a` ahead of `b`, gains in likelihood tempered.
    fn ahead(&self, a: usize, b: usize) -> f64 {
        let [ours, theirs] = [a, b].map(|place| &self.entries[place]);
        let mut ahead = self.score(ours) - self.score(theirs);
        let [whole, counts] = ours.model.terms.tempered(&theirs.model.terms);
        ahead += counts - whole;
        match (&ours.held_out, &theirs.held_out) {
            (Some(own), Some(other)) => {
                let [whole, counts] = own.terms.tempered(&other.terms);
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

    /// The entry is the leader without one of its members, or without its coloured noise: about it
    /// the member meets its rivals beside all others, and physics is met that noise would hide.
    fn is_leader_without(&self, place: usize, best: usize) -> bool {
        let [entry, leader] = [place, best].map(|place| &self.entries[place].model);
        let white = without_colour(&leader.set);
        let is_white = white.len() < leader.set.len() && key(&white, &leader.problem) == entry.key();
        is_white || leader.holds(entry) && leader.set.len() == entry.set.len() + 1
    }

    /// Posterior weight of every entry.
    pub(super) fn weights(&self) -> Vec<f64> {
        let best = self.best();
        let of = |place: usize| if self.entries[place].rejected { 0.0 } else { libm::exp(self.ahead(place, best)) };
        let raw: Vec<f64> = (0..self.entries.len()).map(of).collect();
        let whole: f64 = raw.iter().sum();
        raw.into_iter().map(|weight| weight / whole.max(f64::MIN_POSITIVE)).collect()
    }

    /// Nats of an entry ahead of the plant without hypotheses, everything counted.
    pub(super) fn log_odds(&self, place: usize) -> f64 {
        self.ahead(place, 0)
    }

    /// The same of the fitted recordings alone, no gain tempered: as the evidence of a law is.
    pub(super) fn log_odds_here(&self, place: usize) -> f64 {
        let [own, bare] = [place, 0].map(|place| &self.entries[place].model);
        own.log_marginal - bare.log_marginal - self.log_m * own.set.len() as f64
    }

    /// The best model within the beam that has not been expanded.
    pub(super) fn next(&self) -> Option<usize> {
        self.next_within(BEAM)
    }

    /// The same of those that so many nats lie behind the leader at most.
    pub(super) fn next_within(&self, nats: f64) -> Option<usize> {
        let best = self.best();
        let open = |place: &usize| {
            let entry = &self.entries[*place];
            let is_near = self.ahead(*place, best) > -nats || self.is_leader_without(*place, best);
            !entry.expanded && !entry.rejected && is_near
        };
        let all = (0..self.entries.len()).filter(open);
        all.max_by(|a, b| self.ahead(*a, best).total_cmp(&self.ahead(*b, best)))
    }

    /// Only the bare plant and the best models within the beam stay; where the best one is then.
    pub(super) fn prune(&mut self) -> usize {
        let best = self.best();
        let mut order: Vec<(f64, usize)> =
            (1..self.entries.len()).map(|place| (self.ahead(place, best), place)).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        let stays =
            |(ahead, place): &(f64, usize)| *ahead > -BEAM || *place == best || self.is_leader_without(*place, best);
        let kept = order.into_iter().filter(stays).take(MODELS_MAX);
        let mut kept: Vec<usize> = kept.map(|(_, place)| place).chain([0]).collect();
        kept.sort_unstable();
        let mut place = 0;
        self.entries.retain(|_| {
            place += 1;
            kept.contains(&(place - 1))
        });
        kept.iter().position(|own| *own == best).unwrap_or(0)
    }
}
