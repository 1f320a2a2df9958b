//! One round of the search: the set of effects to adopt, and its rivals.

use super::screening::Screening;
use super::showing::block_terms;
use super::{Adopted, Contested, NAME_SHARE, Options, RIVAL_SPAN, Standing, Unfitted};
use crate::compete::{Contender, Nominal, Outcome, Ranking, Refit, SET_MAX, Subset, Veto, compete, rank, weights};
use crate::score::cosine;
use identification::filter::NoiseModel;
use identification::fit::noise::{Search, maximise};
use identification::fit::{EstimationSession, Fit, fit};
use identification::held_out::{block_s, blocks};
use identification::problem::Problem;

/// Relinearisations of the accepted plant when it is fitted again from another start.
const NULL_ROUNDS: usize = 3;

/// ΔBIC under the noise hypotheses within which a rival of the best set is also fitted as physics, and how many at most. Chosen, no derivation: a wider span finds more rivals at one fit each.
const NEAR: f64 = 6.0;
const NEAR_MAX: usize = 8;

/// Result of one round of the search.
#[derive(Default)]
pub(super) struct Step {
    pub adopted: Vec<Adopted>,
    pub refit: Option<Refit>,
    pub unfitted: Vec<Unfitted>,
    /// Least objective found of the plant without them.
    pub null: f64,
    /// Smaller accepted sets, larger ones first: needed where held-out data do not confirm the adopted one.
    pub smaller: Vec<(Vec<Adopted>, Refit)>,
    /// Accepted sets of the same size that are not excluded, and their ΔBIC: held-out data may prefer one.
    pub rivals: Vec<(Vec<Adopted>, Refit, f64)>,
}

/// The next set of effects, if any is accepted, and those that are significant but could not be fitted.
pub(super) fn step(
    session: &EstimationSession<'_>,
    best: &Standing,
    found: &Screening,
    room: usize,
    options: &Options,
) -> Step {
    let alpha = NAME_SHARE * options.alpha;
    let (linearised, theta) = (&best.fit.linearised, &best.fit.theta);
    let ranking = rank(session, linearised, theta, &found.columns, &best.noise, room.min(SET_MAX));
    let nominal = Nominal { fit: &best.fit, noise: &best.noise, objective: best.objective };
    let mut outcome = compete(session, &nominal, &found.columns, &ranking, alpha);
    let mut asked: Vec<Subset> = Vec::new();
    let better = |small: &Contender, large: &Contender| predicts_better(session, small, large);
    // work of the most expensive complete fit
    let mut settled = 0.0f64;
    while let Some(at) = outcome.best(alpha, &ranking.trials, &better) {
        if !outcome.contenders[at].is_met {
            // complete its fit, then fit the nominal plant from the noise and the parameters of the set
            let contender = &mut outcome.contenders[at];
            let before = session.work.spent();
            contender.settle(session, &found.columns);
            settled = settled.max(session.work.spent() - before);
            contender.is_met = true;
            let null = contender.refit.as_ref().and_then(|refit| nominal_with(session, best, refit));
            outcome.settle(null.unwrap_or(outcome.null), &ranking.trials);
            continue;
        }
        let near = unmet(found, &outcome, at, &ranking, &asked);
        let met = outcome.enter(session, &nominal, &found.columns, &ranking, &near);
        if met > 0 {
            asked.extend_from_slice(&near[..met]);
            continue;
        }
        if let Some(rival) = unsettled(&outcome, at, alpha)
            && session.work.allows(settled, "the last steps of rivals' fits")
        {
            outcome.contenders[rival].settle(session, &found.columns);
            outcome.settle(outcome.null, &ranking.trials);
            continue;
        }
        if !outcome.contenders[at].is_there(session, &found.columns) {
            // the gain belongs to the noise or to the other members
            asked.push(outcome.contenders.remove(at).subset);
            continue;
        }
        let adopted = adopt(found, &outcome, at, &ranking);
        let smaller = smaller(found, &outcome, at, &ranking, alpha);
        let rivals = rivals(session, found, &outcome, at, &ranking, alpha);
        let refit = outcome.contenders[at].refit.clone();
        return Step { adopted, refit, unfitted: Vec::new(), null: outcome.null, smaller, rivals };
    }
    let lost = outcome.contenders.iter().filter(|c| {
        c.p < alpha && c.veto != Veto::Vetoed && c.refit.is_none() && c.bic < 0.0 && c.subset.members.len() == 1
    });
    let unfitted = lost.filter_map(|c| {
        let column = c.subset.members[0];
        let score = found.score(column)?.clone();
        let amplitude = c.subset.amplitudes[0].first().copied().unwrap_or(0.0);
        Some(Unfitted { column: found.columns[column].clone(), score, amplitude, ratio: c.ratio, p: c.p })
    });
    Step { unfitted: unfitted.collect(), null: outcome.null, ..Step::default() }
}

/// Sets of laws that were not compared yet and differ from set `at` in one member, as near under the hypotheses as a rival.
fn unmet(found: &Screening, outcome: &Outcome, at: usize, ranking: &Ranking, asked: &[Subset]) -> Vec<Subset> {
    let law = |a: usize, b: usize| found.columns[a].candidate.same_law(&found.columns[b].candidate);
    let alike = |a: &[usize], b: &[usize]| a.iter().filter(|m| b.iter().any(|o| law(**m, *o))).count();
    let members = &outcome.contenders[at].subset.members;
    let ranked = &ranking.sizes[members.len() - 1];
    let own = ranked.iter().filter(|s| alike(&s.members, members) == members.len()).map(|s| s.bic);
    let own = own.fold(f64::INFINITY, f64::min);
    let mut list: Vec<Subset> = Vec::new();
    for set in ranked.iter().filter(|s| s.bic < own + NEAR && alike(&s.members, members) + 1 == members.len()) {
        let mut met = outcome.contenders.iter().map(|c| &c.subset).chain(asked).chain(&list);
        let same =
            |s: &Subset| s.members.len() == set.members.len() && alike(&s.members, &set.members) == set.members.len();
        if !met.any(same) && asked.len() + list.len() < NEAR_MAX {
            list.push(set.clone());
        }
    }
    list
}

/// An accepted set whose fit is not complete: within the span of rivals of set `at`, or the best of a smaller size.
fn unsettled(outcome: &Outcome, at: usize, alpha: f64) -> Option<usize> {
    let (list, winner) = (&outcome.contenders, &outcome.contenders[at]);
    let size = |c: &Contender| c.subset.members.len();
    let best_of = |own: usize| list.iter().position(|c| size(c) == own && c.stands(alpha));
    let smaller = (1..size(winner)).filter_map(best_of);
    let rivals = (0..list.len()).filter(|i| *i != at && is_rival(&list[*i], winner, alpha));
    smaller.chain(rivals).find(|i| !list[*i].is_settled)
}

/// Of the same size, accepted, and not excluded.
fn is_rival(contender: &Contender, winner: &Contender, alpha: f64) -> bool {
    contender.subset.members.len() == winner.subset.members.len()
        && contender.stands(alpha)
        && contender.bic - winner.bic <= RIVAL_SPAN
}

/// The best accepted set of every size below that of set `at`.
fn smaller(
    found: &Screening,
    outcome: &Outcome,
    at: usize,
    ranking: &Ranking,
    alpha: f64,
) -> Vec<(Vec<Adopted>, Refit)> {
    let size = |c: &Contender| c.subset.members.len();
    let sizes = (1..size(&outcome.contenders[at])).rev();
    let best = sizes.filter_map(|own| outcome.contenders.iter().position(|c| size(c) == own && c.stands(alpha)));
    best.filter_map(|i| Some((adopt(found, outcome, i, ranking), outcome.contenders[i].refit.clone()?))).collect()
}

/// The other accepted sets of the size of set `at` within the span of rivals, best first.
fn rivals(
    session: &EstimationSession<'_>,
    found: &Screening,
    outcome: &Outcome,
    at: usize,
    ranking: &Ranking,
    alpha: f64,
) -> Vec<(Vec<Adopted>, Refit, f64)> {
    let winner = &outcome.contenders[at];
    let stands = |c: &Contender| is_rival(c, winner, alpha) && c.is_there(session, &found.columns);
    let others = (0..outcome.contenders.len()).filter(|i| *i != at && stands(&outcome.contenders[*i]));
    let told = |i: usize| {
        let rival = &outcome.contenders[i];
        Some((adopt(found, outcome, i, ranking), rival.refit.clone()?, rival.bic - winner.bic))
    };
    others.filter_map(told).collect()
}

/// `large` predicts parts of the recording from the others better than `small`, by more than the standard error over blocks (the one-standard-error rule).
fn predicts_better(session: &EstimationSession<'_>, small: &Contender, large: &Contender) -> bool {
    let (Some(without), Some(with)) = (&small.refit, &large.refit) else { return false };
    let terms = |problem: &Problem, fit: &Fit| {
        let own = EstimationSession::like(session, problem).ok()?;
        block_terms(&own, &fit.linearised, &fit.theta, &with.noise)
    };
    let before = terms(&without.problem, &without.fit);
    let (Some(before), Some(after)) = (before, terms(&with.problem, &with.fit)) else { return false };
    let differences: Vec<(f64, f64)> = before.0.iter().zip(&after.0).map(|((t, a), (_, b))| (*t, b - a)).collect();
    let gain = blocks(&differences, block_s(session));
    gain.loglik_gain > gain.gain_se
}

/// The members of set `at` with their rivals: sets of the same size that differ from it in that member alone.
fn adopt(found: &Screening, outcome: &Outcome, at: usize, ranking: &Ranking) -> Vec<Adopted> {
    let winner = &outcome.contenders[at];
    let law = |a: usize, b: usize| found.columns[a].candidate.same_law(&found.columns[b].candidate);
    let members = &winner.subset.members;
    let on_hypothesis = ranking.sizes[members.len() - 1]
        .iter()
        .filter(|s| s.members.iter().zip(members).all(|(a, b)| law(*a, *b)))
        .map(|s| s.bic)
        .fold(f64::INFINITY, f64::min);
    let on_hypothesis = if on_hypothesis.is_finite() { on_hypothesis } else { winner.bic };
    // maximised likelihoods where they exist, else BIC under the hypotheses, relative to the winner's own at the same depth
    let deep = outcome.contenders.iter().map(|c| (&c.subset.members, c.bic - winner.bic));
    let shallow = ranking.sizes[members.len() - 1].iter().map(|s| (&s.members, s.bic - on_hypothesis));
    let all: Vec<(&Vec<usize>, f64)> = deep.chain(shallow).filter(|(set, _)| set.len() == members.len()).collect();
    let mut list = Vec::with_capacity(members.len());
    for own in members {
        let others: Vec<usize> = members.iter().copied().filter(|m| m != own).collect();
        let mut contested: Vec<(usize, f64)> = Vec::new();
        for (set, bic) in &all {
            let rest: Vec<usize> = set.iter().copied().filter(|s| !others.iter().any(|o| law(*s, *o))).collect();
            let [instead] = rest[..] else { continue };
            let known = contested.iter().any(|(c, _)| law(*c, instead));
            if !law(instead, *own) && !known && *bic <= RIVAL_SPAN {
                contested.push((instead, bic.max(0.0)));
            }
        }
        let mut bic = vec![0.0];
        bic.extend(contested.iter().map(|(_, bic)| *bic));
        let weights = weights(&bic, RIVAL_SPAN);
        let Some(score) = found.score(*own) else { continue };
        let rivals = contested.iter().zip(&weights[1..]).map(|((column, bic), weight)| Contested {
            candidate: found.columns[*column].candidate.clone(),
            kind: found.columns[*column].candidate.effect.kind,
            site: found.columns[*column].candidate.site.to_string(),
            weight: *weight,
            bic: *bic,
            cosine: found.score(*column).map_or(0.0, |other| cosine(score, other)),
        });
        let rivals = rivals.collect();
        let (p, d) = (winner.p, winner.ratio.max(0.0).sqrt());
        list.push(Adopted {
            column: found.columns[*own].clone(),
            score: score.clone(),
            p,
            d,
            weight: weights[0],
            rivals,
        });
    }
    list
}

impl Standing {
    /// As `refit` has it, its standard deviations over all local optima.
    pub(super) fn of(refit: &Refit) -> Self {
        Self {
            plant: refit.plant.clone(),
            problem: refit.problem.clone(),
            fit: Fit { sigma: refit.sigma(), ..refit.fit.clone() },
            noise: refit.noise.clone(),
            objective: refit.objective,
        }
    }
}

impl From<Standing> for Refit {
    fn from(best: Standing) -> Self {
        let Standing { plant, problem, fit, noise, objective } = best;
        Self { plant, problem, fit, noise, objective, free: 0, valleys: Vec::new() }
    }
}

/// Least objective of the accepted plant under the noise of `refit`: from its own parameters and from those of `refit`, fitted again, then the noise.
fn nominal_with(session: &EstimationSession<'_>, best: &Standing, refit: &Refit) -> Option<f64> {
    let search = Search { sweeps: 4, colour: true, scan: false };
    let own = maximise(session, &best.fit.linearised, &best.fit.theta, &[], &refit.noise, search)?;
    let theirs = session.start_from(&refit.problem.unknowns, &refit.fit.theta);
    let from = |(theta, noise): (&Vec<f64>, &NoiseModel)| {
        let again = fit(session, &best.plant, theta, noise, NULL_ROUNDS).ok()?;
        let (noise, _) = maximise(session, &again.linearised, &again.theta, &[], noise, search)?;
        let again = fit(session, &best.plant, &again.theta, &noise, 1).ok()?;
        Some(maximise(session, &again.linearised, &again.theta, &[], &noise, search)?.1)
    };
    let again = (!refit.noise.is_about(&best.noise)).then_some((&best.fit.theta, &own.0));
    let (mut least, mut cost) = (own.1, 0.0);
    for start in again.into_iter().chain([(&theirs, &refit.noise)]) {
        if cost > 0.0 && !session.work.allows(cost, "the plant without an effect from another start") {
            break;
        }
        let before = session.work.spent();
        least = from(start).map_or(least, |found| found.min(least));
        cost = session.work.spent() - before;
    }
    Some(least)
}
