//! Which hypotheses about a model are worth a fit.
//!
//! The best laws of the screening are evaluated on the linear problem with the noise free again:
//! what is left of a column once noise may take its part. Pairs come from the normal equations of
//! all these columns; groups are one law at all like sites. What is no law: `others`.

use super::disturbed::Disturbed;
use super::exact_columns;
use super::hypothesis::{Hypothesis, Part};
use super::linear_evidence::{bounds_of, linear_evidence};
use super::marginal::{log_marginal, narrowed, part_of};
use super::model::{Ground, Model, key};
use super::noise::{Linearly, NoisePrior};
use super::pool::{BEAM, without_noise};
use super::screen::{Rated, Screened};
use super::timed;
use super::timing::shift_of;
use crate::score::Candidate;
use dynamics::description::SiteKind;
use identification::filter::NoiseModel;
use identification::fit::{EstimationSession, Normal};

/// Laws that are evaluated on the linear problem, and fits of singles, pairs, groups and others.
/// Budgets.
const LAWS_MAX: usize = 12;
const SINGLES_MAX: usize = 6;
const PAIRS_FITTED_MAX: usize = 2;
const PAIRS_EVALUATED_MAX: usize = 3;
const PAIRED_MAX: usize = 40;
const GROUPS_MAX: usize = 2;
const OTHERS_MAX: usize = 2;
const INSTEAD_MAX: usize = 6;
const INSTEAD_FITTED_MAX: usize = 3;
/// Shares of a law's width of prior that its amplitudes at like sites may have in common: half a
/// decade apart, at most a third of a nat for each amplitude between them, down to a hundredth.
const GROUP_SHARES: [f64; 5] = [1.0, 0.3, 0.1, 0.03, 0.01];
/// Nats from which a hypothesis is fitted, and share of the leader's. Budgets: a fit gains little
/// over the linear problem with free noise.
pub(super) const WORTH: f64 = 1.0;
const WORTH_SHARE: f64 = 0.2;

/// Hypotheses that join a model, with the noise to begin from.
pub(super) struct Proposal {
    pub set: Vec<Hypothesis>,
    /// They take the place of noise that is not stated.
    pub instead: bool,
    pub log_bayes: f64,
    pub noise: NoiseModel,
}

/// A law on the linear problem.
struct Linear {
    place: usize,
    proposal: Proposal,
}

/// The proposals about `model`, best first within each kind, and the names of laws that the budget
/// of fits leaves out; `ln m` is the price of a member.
pub(super) fn proposals(
    ground: Ground<'_>,
    model: &Model,
    screened: &Screened,
    log_m: f64,
) -> (Vec<Proposal>, Vec<String>) {
    let Some(session) = model.session(ground) else { return Default::default() };
    let look = Look { ground, session: &session, model, screened };
    let Some(bare) = look.bare() else { return Default::default() };
    let few = screened.rated.iter().enumerate().filter(|(_, rated)| rated.log_bayes > 0.0).take(LAWS_MAX);
    let mut singles: Vec<Linear> = few.filter_map(|(place, rated)| look.single(place, rated, bare)).collect();
    singles.sort_by(|a, b| b.proposal.log_bayes.total_cmp(&a.proposal.log_bayes));
    let best = singles.first().map_or(0.0, |own| own.proposal.log_bayes);
    let worth = WORTH.max(WORTH_SHARE * best);
    let is_fitted = |own: &&Linear| own.proposal.log_bayes > worth;
    let fitted: Vec<usize> = singles.iter().filter(is_fitted).take(SINGLES_MAX).map(|own| own.place).collect();
    let relatives = look.relatives(&fitted, bare);
    let paired: Vec<&Rated> = screened.rated.iter().take(PAIRED_MAX).collect();
    let groups = look.alike(&paired);
    let mut list = look.groups(&groups, bare, best);
    let most = list.first().map_or(best, |own| own.log_bayes.max(best));
    list.extend(look.instead(bare, log_m));
    list.extend(look.pairs((&paired, &groups), bare, most + log_m));
    let mut worthy = singles.into_iter().map(|own| own.proposal).filter(|own| own.log_bayes > worth);
    list.extend(worthy.by_ref().take(SINGLES_MAX));
    let is_open = shift_of(&model.set).is_none();
    let shift = if is_open { timed::column(&session, model) } else { None };
    let late = shift.as_ref().and_then(|shift| look.with_timing(&list, (shift, bare, log_m)));
    let near = worthy.filter(|own| own.log_bayes > best - BEAM);
    let left = near.map(|own| key(&own.set, &model.problem)).collect();
    list.extend(relatives);
    list.extend(Disturbed { ground, session: &session, model }.proposals(bare));
    let mut others = look.coloured(log_m);
    others.extend(look.conflicts());
    others.extend(shift.and_then(|shift| look.timing(&shift, bare)));
    others.extend(exact_columns::proposals(ground, &session, model, bare));
    others.sort_by(|a, b| b.log_bayes.total_cmp(&a.log_bayes));
    list.extend(others.into_iter().filter(|own| own.log_bayes > WORTH).take(OTHERS_MAX));
    list.extend(late);
    (list, left)
}

pub(super) struct Look<'a> {
    pub ground: Ground<'a>,
    pub session: &'a EstimationSession<'a>,
    pub model: &'a Model,
    pub screened: &'a Screened,
}

impl Look<'_> {
    /// Evidence of the model itself on its linear problem.
    fn bare(&self) -> Option<f64> {
        Some(self.linearly(&[], (&self.model.noise, &self.model.prior(self.ground.session)))?.0)
    }

    /// Evidence with the parts' columns, the noise it has, and the amplitudes.
    pub(super) fn linearly(
        &self,
        parts: &[&Rated],
        (start, prior): (&NoiseModel, &NoisePrior),
    ) -> Option<(f64, NoiseModel, Vec<Vec<f64>>)> {
        let (extra, room) = columns_of(parts);
        let (linearised, theta) = (&self.model.fit.linearised, &self.model.fit.theta[..]);
        let (extra, room) = (&extra[..], &room[..]);
        let linear = Linearly { session: self.session, linearised, theta, extra, room };
        let found = linear_evidence(&linear, (start, prior))?;
        let points: f64 = parts.iter().map(|own| own.part.log_points).sum();
        let mut at = 0;
        let mut amplitudes = Vec::new();
        for own in parts {
            let count = own.column.raw.len();
            amplitudes.push(found.amplitudes[at..at + count].iter().map(|x| x * own.part.scale).collect());
            at += count;
        }
        Some((found.value - points, found.noise, amplitudes))
    }

    /// One law on the linear problem.
    pub(super) fn alone(&self, law: &Rated, bare: f64) -> Option<Proposal> {
        self.set(&[vec![law]], bare)
    }

    /// The set of these hypotheses on the linear problem: each a law, or one at several sites.
    fn set(&self, members: &[Vec<&Rated>], bare: f64) -> Option<Proposal> {
        let parts = members.concat();
        let stated = parts.iter().any(|own| own.is_stated);
        let start = &self.screened.noises[usize::from(stated)];
        let prior = self.model.prior(self.ground.session);
        let (value, noise, amplitudes) = self.linearly(&parts, (start, &prior))?;
        let possible = parts.iter().zip(&amplitudes).all(|(own, a)| own.column.candidate.is_possible(a));
        let mut amplitudes = amplitudes.into_iter();
        let part = |own: &&Rated| Some(Part { amplitude: amplitudes.next()?, ..own.part.clone() });
        let mut parts = parts.iter().filter_map(part);
        let of = |member: &Vec<&Rated>| Hypothesis::Effect(parts.by_ref().take(member.len()).collect());
        let set = members.iter().map(of).collect();
        possible.then_some(Proposal { set, instead: false, log_bayes: value - bare, noise })
    }

    /// Laws in the place of all noise that is not stated: what such noise has taken up is evidence
    /// of no law beside it.
    fn instead(&self, bare: f64, log_m: f64) -> Vec<Proposal> {
        let kept = without_noise(&self.model.set);
        let gone = self.model.set.len() - kept.len();
        if gone == 0 {
            return Vec::new();
        }
        let (prior, start) = (NoisePrior::new(self.ground.session, &kept), &self.screened.noises[1]);
        let of = |rated: &Rated| {
            let (value, noise, mut amplitudes) = self.linearly(&[rated], (start, &prior))?;
            let log_bayes = value - bare + gone as f64 * log_m;
            let is_it = rated.column.candidate.is_possible(&amplitudes[0]) && log_bayes > -BEAM;
            let part = Part { amplitude: amplitudes.remove(0), ..rated.part.clone() };
            is_it.then(|| Proposal { set: vec![Hypothesis::Effect(vec![part])], instead: true, log_bayes, noise })
        };
        let few = self.screened.rated.iter().filter(|rated| rated.is_stated).take(INSTEAD_MAX);
        let mut list: Vec<Proposal> = few.filter_map(of).collect();
        list.sort_by(|a, b| b.log_bayes.total_cmp(&a.log_bayes));
        list.truncate(INSTEAD_FITTED_MAX);
        list
    }

    fn single(&self, place: usize, rated: &Rated, bare: f64) -> Option<Linear> {
        Some(Linear { place, proposal: self.alone(rated, bare)? })
    }

    /// One law at every like site (all joints, all wheels, all thrusters), of those that are felt
    /// at several of them, best first.
    fn groups(&self, groups: &[Vec<Rated>], bare: f64, best: f64) -> Vec<Proposal> {
        let is_felt = |group: &&Vec<Rated>| group.iter().filter(|own| own.log_bayes > 0.0).count() > 1;
        let all = groups.iter().filter(is_felt).filter_map(|group| self.set(&[group.iter().collect()], bare));
        let mut list: Vec<Proposal> = all.filter(|own| own.log_bayes > best.max(WORTH)).collect();
        list.sort_by(|a, b| b.log_bayes.total_cmp(&a.log_bayes));
        list.truncate(GROUPS_MAX);
        list
    }

    /// Each law of `few` at all like sites, where these are several.
    fn alike(&self, few: &[&Rated]) -> Vec<Vec<Rated>> {
        let plant = &self.model.problem.plant;
        let is_like = |a: &Candidate, b: &Candidate| a.effect.kind == b.effect.kind && plant.alike(&a.site, &b.site);
        let mut kinds: Vec<&Candidate> = Vec::new();
        for own in few.iter().map(|own| &own.column.candidate) {
            if !kinds.iter().any(|known| is_like(known, own)) {
                kinds.push(own);
            }
        }
        // sensors fail one by one: a group of them is a set under another name
        kinds.retain(|kind| kind.site.kind != SiteKind::Sensor);
        let group = |kind: &&Candidate| {
            let like = |rated: &&Rated| is_like(&rated.column.candidate, kind);
            let parts: Vec<&Rated> = self.screened.rated.iter().filter(like).collect();
            (parts.len() > 1).then(|| self.of_one_size(&parts))
        };
        kinds.iter().filter_map(group).collect()
    }

    /// A law at like sites whose amplitudes have a width of prior in common: like machines err
    /// alike. The first one tells how much, and pays for the law's own width; the others err as
    /// it does.
    fn of_one_size(&self, parts: &[&Rated]) -> Vec<Rated> {
        let sized = |share: f64| {
            let narrowed = |own: &&Rated| Rated { part: own.part.clone().narrowed(share), ..(*own).clone() };
            let mut own: Vec<Rated> = parts.iter().map(narrowed).collect();
            let directions = own[0].column.raw.len() as f64;
            own[0].part.log_points += libm::log(GROUP_SHARES.len() as f64) - directions * libm::log(share);
            own
        };
        let start = &self.screened.noises[usize::from(parts.iter().any(|own| own.is_stated))];
        let Some(whole) = self.normal(parts, start) else { return sized(1.0) };
        let value = |own: &[Rated]| {
            let laws: Vec<(&Rated, f64)> = own.iter().zip(parts).map(|(own, law)| (own, share_of(own, law))).collect();
            value_of(&whole, &laws).unwrap_or(f64::NEG_INFINITY)
        };
        let all = GROUP_SHARES.map(|share| {
            let own = sized(share);
            (value(&own), own)
        });
        let best = all.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or_else(|| sized(1.0), |(_, own)| own)
    }

    /// Pairs from the normal equations of all laws, at one site and at all like ones, however
    /// little one explains alone: the best under each noise that explain more than `least` once
    /// it is free.
    fn pairs(&self, (single, groups): (&[&Rated], &[Vec<Rated>]), bare: f64, least: f64) -> Vec<Proposal> {
        let groups = groups.iter().map(|group| group.iter().collect());
        let few: Vec<Vec<&Rated>> = single.iter().map(|own| vec![*own]).chain(groups).collect();
        let mut known: Vec<[usize; 2]> = Vec::new();
        let mut sets: Vec<Proposal> = Vec::new();
        for noise in &self.screened.noises {
            let mut found = self.ranked(&few, noise).unwrap_or_default();
            found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            let worthy = found.into_iter().filter(|(log_bayes, _)| *log_bayes > least).map(|(_, pair)| pair);
            let new: Vec<[usize; 2]> = worthy.take(PAIRS_EVALUATED_MAX).filter(|pair| !known.contains(pair)).collect();
            sets.extend(new.iter().filter_map(|[a, b]| self.set(&[few[*a].clone(), few[*b].clone()], bare)));
            known.extend(new);
        }
        sets.retain(|own| own.log_bayes > least);
        sets.sort_by(|a, b| b.log_bayes.total_cmp(&a.log_bayes));
        sets.truncate(PAIRS_FITTED_MAX);
        sets
    }

    /// The normal equations of the model with the columns of these laws.
    fn normal(&self, laws: &[&Rated], noise: &NoiseModel) -> Option<Normal> {
        let (extra, room) = columns_of(laws);
        let (linearised, theta) = (&self.model.fit.linearised, &self.model.fit.theta[..]);
        Linearly { session: self.session, linearised, theta, extra: &extra, room: &room }.normal(noise)
    }

    /// `ln B` of every pair of `few` under one noise, of laws that both have none.
    fn ranked(&self, few: &[Vec<&Rated>], noise: &NoiseModel) -> Option<Vec<(f64, [usize; 2])>> {
        let mut laws: Vec<&Rated> = Vec::new();
        for own in few.iter().flatten() {
            if !laws.iter().any(|known| is_same(known, own)) {
                laws.push(own);
            }
        }
        let whole = self.normal(&laws, noise)?;
        let mut first = whole.unknowns;
        let places: Vec<Vec<usize>> = laws
            .iter()
            .map(|own| {
                let own = first..first + own.column.raw.len();
                first = own.end;
                own.collect()
            })
            .collect();
        let of = |own: &[&Rated]| {
            let place = |own: &Rated| laws.iter().position(|law| is_same(law, own));
            let all: Vec<usize> = own.iter().map(|own| place(own)).collect::<Option<_>>()?;
            let kept: Vec<usize> = all.iter().flat_map(|law| places[*law].iter().copied()).collect();
            let shares = own.iter().zip(&all).map(|(own, law)| (*own, share_of(own, laws[*law])));
            value_of(&part_of(&whole, &kept), &shares.collect::<Vec<_>>())
        };
        let bare = of(&[])?;
        let is_apart = |[a, b]: &[usize; 2]| !few[*a].iter().any(|own| few[*b].iter().any(|other| is_same(own, other)));
        let all = (0..few.len()).flat_map(|a| (a + 1..few.len()).map(move |b| [a, b])).filter(is_apart);
        let both = |[a, b]: [usize; 2]| [&few[a][..], &few[b]].concat();
        Some(all.filter_map(|pair| Some((of(&both(pair))? - bare, pair))).collect())
    }
}

/// Evidence of laws on the normal equations of their columns, whose widths of prior are these
/// shares of those in the equations.
fn value_of(whole: &Normal, laws: &[(&Rated, f64)]) -> Option<f64> {
    let shares = laws.iter().flat_map(|(own, share)| own.column.raw.iter().map(|_| *share));
    let own = narrowed(whole, &shares.collect::<Vec<_>>());
    let points: f64 = laws.iter().map(|(own, _)| own.part.log_points).sum();
    log_marginal(&own, &bounds_of(&own)).map(|value| value - points)
}

/// The width of prior of a law over that of the same law in another one's units.
fn share_of(own: &Rated, law: &Rated) -> f64 {
    own.part.scale / law.part.scale
}

/// One law at one site.
fn is_same(a: &Rated, b: &Rated) -> bool {
    let [a, b] = [a, b].map(|own| &own.column.candidate);
    a.effect.kind == b.effect.kind && a.site == b.site
}

/// Columns per standard deviation of their priors, and their room.
pub(super) fn columns_of(parts: &[&Rated]) -> (Vec<Vec<f64>>, Vec<[f64; 2]>) {
    let (mut extra, mut room) = (Vec::new(), Vec::new());
    for own in parts {
        for (direction, raw) in own.column.raw.iter().enumerate() {
            extra.push(raw.iter().map(|c| c * own.part.scale).collect());
            room.push(own.column.candidate.linear_range(direction).map(|end| end / own.part.scale));
        }
    }
    (extra, room)
}
