//! Laws that are fitted whatever the linear problem promises of them, because of others that it
//! promises much of.

use super::hypothesis::{Hypothesis, Part};
use super::propose::{Look, Proposal};
use super::screen::Rated;
use crate::score::Candidate;
use crate::unknown_law::site_of_input;
use dynamics::description::{Site, SiteKind};

/// Fits of each kind. Budgets.
const KIN_MAX: usize = 4;
const REPEATING_MAX: usize = 2;
const PEAKS_MAX: usize = 3;
const PLAIN_MAX: usize = 8;

impl Look<'_> {
    /// Relatives of the fitted laws, by their places among all that were rated.
    pub(super) fn relatives(&self, fitted: &[usize], bare: f64) -> Vec<Proposal> {
        let mut list = self.elsewhere(fitted, bare);
        list.extend(self.parents(fitted, bare));
        list.extend(self.kin(fitted, bare));
        list.extend(self.plain(fitted, bare));
        list
    }

    /// The laws of most evidence at other frequencies or orders: what is a ripple in truth repeats
    /// at others nearly as well, and the best peak about a plant without it need not be its own.
    fn elsewhere(&self, fitted: &[usize], bare: f64) -> Vec<Proposal> {
        let first = |place: &usize| &self.screened.rated[*place].column.candidate;
        let laws: Vec<&Candidate> = fitted.iter().take(REPEATING_MAX).map(first).collect();
        let of = |law: &&Candidate| {
            let same = self.screened.elsewhere.iter().filter(|own| own.column.candidate.same_law(law));
            same.take(PEAKS_MAX).filter_map(|rated| self.alone(rated, bare)).collect::<Vec<_>>()
        };
        laws.iter().flat_map(of).collect()
    }

    /// The simpler laws that those of the fitted ones contain, at the same sites, where they are
    /// not among these.
    fn parents(&self, fitted: &[usize], bare: f64) -> Vec<Proposal> {
        let mut list: Vec<Proposal> = Vec::new();
        let mut known = fitted.to_vec();
        for place in fitted {
            let child = &self.screened.rated[*place].column.candidate;
            for limit in child.effect.limits {
                let is_it = |rated: &Rated| {
                    let parent = &rated.column.candidate;
                    parent.effect.kind == limit.kind && parent.site == child.site
                };
                let Some(place) = self.screened.rated.iter().position(is_it) else { continue };
                if !known.contains(&place) {
                    known.push(place);
                    list.extend(self.alone(&self.screened.rated[place], bare));
                }
            }
        }
        list
    }

    /// Laws of the leader's family at its site, or at the joint that carries its body, that are not
    /// worth a fit by themselves: those that it is confused with most, so that its weight is one
    /// among them.
    fn kin(&self, fitted: &[usize], bare: f64) -> Vec<Proposal> {
        let Some(leader) = fitted.first() else { return Vec::new() };
        let own = &self.screened.rated[*leader].column.candidate;
        let plant = &self.model.problem.plant;
        let is_near = |other: &Site| {
            let carries = |joint: &Site, body: &Site| {
                let (is_joint, is_body) = (joint.kind == SiteKind::Joint, body.kind == SiteKind::Body);
                is_joint && is_body && plant.bodies.iter().any(|b| b.name == body.name && b.joint.name == joint.name)
            };
            *other == own.site || carries(other, &own.site) || carries(&own.site, other)
        };
        let is_kin = |(place, rated): &(usize, &Rated)| {
            let other = &rated.column.candidate;
            !fitted.contains(place) && other.effect.family == own.effect.family && is_near(&other.site)
        };
        let all = self.screened.rated.iter().enumerate().filter(is_kin).take(KIN_MAX);
        all.filter_map(|(_, rated)| self.alone(rated, bare)).collect()
    }

    /// Where an unspecified disturbance has taken up something, the one-parameter law of each
    /// family: along a motion that lacks a law its linear response may be nothing (dry friction
    /// that holds, about a motion that never rests).
    fn plain(&self, fitted: &[usize], bare: f64) -> Vec<Proposal> {
        let (plant, linear) = (&self.model.problem.plant, self.model.fit.linearised.linears.first());
        let of = |own: &Hypothesis| {
            if let Hypothesis::Disturbance(k, _) = own { site_of_input(plant, linear?, *k) } else { None }
        };
        let sites: Vec<String> = self.model.set.iter().filter_map(of).collect();
        let is_plain = |(place, rated): &(usize, &Rated)| {
            let own = &rated.column.candidate;
            !fitted.contains(place) && own.numbers() == 1 && sites.contains(&own.site.to_string())
        };
        let mut all: Vec<&Rated> =
            self.screened.rated.iter().enumerate().filter(is_plain).map(|(_, own)| own).collect();
        all.sort_by_key(|own| plant.catalogue.place(own.column.candidate.effect.kind));
        let mut plain: Vec<&Rated> = Vec::new();
        for own in all {
            let same = |known: &&Rated| {
                let [a, b] = [known, own].map(|rated| &rated.column.candidate);
                a.site == b.site && a.effect.family == b.effect.family
            };
            if !plain.iter().any(same) {
                plain.push(own);
            }
        }
        plain.into_iter().take(PLAIN_MAX).filter_map(|rated| self.upright(rated, bare)).collect()
    }

    /// A law to start from the size that the linear problem gives it, in the direction that it can
    /// have.
    fn upright(&self, rated: &Rated, bare: f64) -> Option<Proposal> {
        let start = (&self.screened.noises[usize::from(rated.is_stated)], &self.model.prior(self.ground.session));
        let (value, noise, mut amplitudes) = self.linearly(&[rated], start)?;
        let mut amplitude = amplitudes.remove(0);
        if !rated.column.candidate.is_possible(&amplitude) {
            amplitude.iter_mut().for_each(|a| *a = -*a);
        }
        let set = vec![Hypothesis::Effect(vec![Part { amplitude, ..rated.part.clone() }])];
        Some(Proposal { set, instead: false, log_bayes: value - bare, noise })
    }
}
