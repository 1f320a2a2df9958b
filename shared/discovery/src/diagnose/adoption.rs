//! One round of the search: the set of effects to adopt, and its rivals.

use super::held_out_evidence::block_terms;
use super::screening::Screening;
use super::{ALPHA_SHARE_IDENTIFIED, Adopted, Options, RIVAL_SPAN, RivalEffect, Unfitted};
use crate::compete::{
    FittedModel, ModelHypothesis, Nominal, Outcome, Ranking, SET_MAX, Subset, Veto, compete, rank, weights,
};
use crate::outline::COMPLETION_SETS;
use crate::score::cosine;
use identification::filter::NoiseModel;
use identification::fit::noise::{Search, maximise};
use identification::fit::{EstimationSession, Fit, fit};
use identification::held_out::{block_s, blocks};
use identification::problem::Problem;

/// Relinearisations of the accepted plant when it is fitted again from another start.
const NULL_ROUNDS: usize = 3;

/// ΔBIC under the noise hypotheses within which a rival of the best set is also fitted as physics,
/// and how many at most. Chosen, no derivation: a wider span finds more rivals at one fit each.
const REFITTED_BIC_SPAN: f64 = 6.0;
const REFITTED_RIVALS_MAX: usize = 8;

/// Result of one round of the search.
#[derive(Default)]
pub(super) struct SearchRound {
    pub adopted: Vec<Adopted>,
    pub refit: Option<FittedModel>,
    pub unfitted: Vec<Unfitted>,
    /// Least objective found of the plant without them.
    pub null: f64,
    /// Smaller accepted sets, larger ones first: needed where held-out data do not confirm the
    /// adopted one.
    pub smaller: Vec<(Vec<Adopted>, FittedModel)>,
    /// Accepted sets of the same size that are not excluded, and their ΔBIC: held-out data may
    /// prefer one.
    pub rivals: Vec<(Vec<Adopted>, FittedModel, f64)>,
}

/// The next set of effects, if any is accepted, and those that are significant but could not be
/// fitted.
pub(super) fn step(
    session: &EstimationSession<'_>,
    best: &FittedModel,
    found: &Screening,
    room: usize,
    options: &Options,
) -> SearchRound {
    let alpha = ALPHA_SHARE_IDENTIFIED * options.alpha;
    let (linearised, theta) = (&best.fit.linearised, &best.fit.theta);
    let ranking = rank(session, linearised, theta, &found.columns, &best.noise, room.min(SET_MAX));
    let nominal = Nominal { fit: &best.fit, noise: &best.noise, objective: best.objective };
    let mut outcome = compete(session, &nominal, &found.columns, &ranking, alpha);
    let mut tested: Vec<Subset> = Vec::new();
    let better = |small: &ModelHypothesis, large: &ModelHypothesis| predicts_better(session, small, large);
    // work of the most expensive complete fit
    let mut settled = 0.0f64;
    while let Some(at) = outcome.best(alpha, &ranking.multiplicity, &better) {
        if !outcome.hypotheses[at].is_compared {
            outcome.plan(session, COMPLETION_SETS);
            // complete its fit, then fit the nominal plant from the noise and the parameters of the
            // set
            let hypothesis = &mut outcome.hypotheses[at];
            let before = session.work.spent();
            hypothesis.settle(session, &found.columns);
            settled = settled.max(session.work.spent() - before);
            hypothesis.is_compared = true;
            let null = hypothesis.refit.as_ref().and_then(|refit| nominal_with(session, best, refit));
            outcome.settle(null.unwrap_or(outcome.null), &ranking.multiplicity);
            continue;
        }
        let near = uncompared(found, &outcome, at, &ranking, &tested);
        let met = outcome.enter(session, &nominal, &found.columns, &ranking, &near);
        if met > 0 {
            tested.extend_from_slice(&near[..met]);
            continue;
        }
        if let Some(rival) = unsettled(&outcome, at, alpha)
            && session.work.allows(settled, "the last steps of rivals' fits")
        {
            outcome.hypotheses[rival].settle(session, &found.columns);
            outcome.settle(outcome.null, &ranking.multiplicity);
            continue;
        }
        if !outcome.hypotheses[at].all_amplitudes_significant(session, &found.columns) {
            // the gain belongs to the noise or to the other members
            tested.push(outcome.hypotheses.remove(at).subset);
            continue;
        }
        let adopted = adopt(found, &outcome, at, &ranking);
        let smaller = smaller(found, &outcome, at, &ranking, alpha);
        let rivals = rivals(session, found, &outcome, at, &ranking, alpha);
        let refit = outcome.hypotheses[at].refit.clone();
        return SearchRound { adopted, refit, unfitted: Vec::new(), null: outcome.null, smaller, rivals };
    }
    let lost = outcome.hypotheses.iter().filter(|c| {
        c.p < alpha && c.veto != Veto::Vetoed && c.refit.is_none() && c.bic < 0.0 && c.subset.members.len() == 1
    });
    let unfitted = lost.filter_map(|c| {
        let column = c.subset.members[0];
        let score = found.score(column)?.clone();
        let amplitude = c.subset.amplitudes[0].first().copied().unwrap_or(0.0);
        Some(Unfitted { column: found.columns[column].clone(), score, amplitude, ratio: c.ratio, p: c.p })
    });
    SearchRound { unfitted: unfitted.collect(), null: outcome.null, ..SearchRound::default() }
}

/// Sets of laws that were not compared yet and differ from set `at` in one member, as near under
/// the hypotheses as a rival.
fn uncompared(found: &Screening, outcome: &Outcome, at: usize, ranking: &Ranking, tested: &[Subset]) -> Vec<Subset> {
    let law = |a: usize, b: usize| found.columns[a].candidate.same_law(&found.columns[b].candidate);
    let alike = |a: &[usize], b: &[usize]| a.iter().filter(|m| b.iter().any(|o| law(**m, *o))).count();
    let members = &outcome.hypotheses[at].subset.members;
    let ranked = &ranking.sizes[members.len() - 1];
    let own = ranked.iter().filter(|s| alike(&s.members, members) == members.len()).map(|s| s.bic);
    let own = own.fold(f64::INFINITY, f64::min);
    let mut list: Vec<Subset> = Vec::new();
    for set in
        ranked.iter().filter(|s| s.bic < own + REFITTED_BIC_SPAN && alike(&s.members, members) + 1 == members.len())
    {
        let mut met = outcome.hypotheses.iter().map(|c| &c.subset).chain(tested).chain(&list);
        let same =
            |s: &Subset| s.members.len() == set.members.len() && alike(&s.members, &set.members) == set.members.len();
        if !met.any(same) && tested.len() + list.len() < REFITTED_RIVALS_MAX {
            list.push(set.clone());
        }
    }
    list
}

/// An accepted set whose fit is not complete: within the span of rivals of set `at`, or the best of
/// a smaller size.
fn unsettled(outcome: &Outcome, at: usize, alpha: f64) -> Option<usize> {
    let (list, winner) = (&outcome.hypotheses, &outcome.hypotheses[at]);
    let size = |c: &ModelHypothesis| c.subset.members.len();
    let best_of = |own: usize| list.iter().position(|c| size(c) == own && c.is_accepted(alpha));
    let smaller = (1..size(winner)).filter_map(best_of);
    let rivals = (0..list.len()).filter(|i| *i != at && is_rival(&list[*i], winner, alpha));
    smaller.chain(rivals).find(|i| !list[*i].is_settled)
}

/// Of the same size, accepted, and not excluded.
fn is_rival(hypothesis: &ModelHypothesis, winner: &ModelHypothesis, alpha: f64) -> bool {
    hypothesis.subset.members.len() == winner.subset.members.len()
        && hypothesis.is_accepted(alpha)
        && hypothesis.bic - winner.bic <= RIVAL_SPAN
}

/// The best accepted set of every size below that of set `at`.
fn smaller(
    found: &Screening,
    outcome: &Outcome,
    at: usize,
    ranking: &Ranking,
    alpha: f64,
) -> Vec<(Vec<Adopted>, FittedModel)> {
    let size = |c: &ModelHypothesis| c.subset.members.len();
    let sizes = (1..size(&outcome.hypotheses[at])).rev();
    let best = sizes.filter_map(|own| outcome.hypotheses.iter().position(|c| size(c) == own && c.is_accepted(alpha)));
    best.filter_map(|i| Some((adopt(found, outcome, i, ranking), outcome.hypotheses[i].refit.clone()?))).collect()
}

/// The other accepted sets of the size of set `at` within the span of rivals, best first.
fn rivals(
    session: &EstimationSession<'_>,
    found: &Screening,
    outcome: &Outcome,
    at: usize,
    ranking: &Ranking,
    alpha: f64,
) -> Vec<(Vec<Adopted>, FittedModel, f64)> {
    let winner = &outcome.hypotheses[at];
    let is_accepted =
        |c: &ModelHypothesis| is_rival(c, winner, alpha) && c.all_amplitudes_significant(session, &found.columns);
    let others = (0..outcome.hypotheses.len()).filter(|i| *i != at && is_accepted(&outcome.hypotheses[*i]));
    let reported = |i: usize| {
        let rival = &outcome.hypotheses[i];
        Some((adopt(found, outcome, i, ranking), rival.refit.clone()?, rival.bic - winner.bic))
    };
    others.filter_map(reported).collect()
}

/// `large` predicts parts of the recording from the others better than `small`, by more than the
/// standard error over blocks (the one-standard-error rule).
fn predicts_better(session: &EstimationSession<'_>, small: &ModelHypothesis, large: &ModelHypothesis) -> bool {
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

/// The members of set `at` with their rivals: sets of the same size that differ from it in that
/// member alone.
fn adopt(found: &Screening, outcome: &Outcome, at: usize, ranking: &Ranking) -> Vec<Adopted> {
    let winner = &outcome.hypotheses[at];
    let law = |a: usize, b: usize| found.columns[a].candidate.same_law(&found.columns[b].candidate);
    let members = &winner.subset.members;
    let on_hypothesis = ranking.sizes[members.len() - 1]
        .iter()
        .filter(|s| s.members.iter().zip(members).all(|(a, b)| law(*a, *b)))
        .map(|s| s.bic)
        .fold(f64::INFINITY, f64::min);
    let on_hypothesis = if on_hypothesis.is_finite() { on_hypothesis } else { winner.bic };
    // maximised likelihoods where they exist, else BIC under the hypotheses, relative to the
    // winner's own at the same depth
    let deep = outcome.hypotheses.iter().map(|c| (&c.subset.members, c.bic - winner.bic));
    let shallow = ranking.sizes[members.len() - 1].iter().map(|s| (&s.members, s.bic - on_hypothesis));
    let all: Vec<(&Vec<usize>, f64)> = deep.chain(shallow).filter(|(set, _)| set.len() == members.len()).collect();
    let mut list = Vec::with_capacity(members.len());
    for own in members {
        let others: Vec<usize> = members.iter().copied().filter(|m| m != own).collect();
        let mut rival_effects: Vec<(usize, f64)> = Vec::new();
        for (set, bic) in &all {
            let rest: Vec<usize> = set.iter().copied().filter(|s| !others.iter().any(|o| law(*s, *o))).collect();
            let [instead] = rest[..] else { continue };
            let known = rival_effects.iter().any(|(c, _)| law(*c, instead));
            if !law(instead, *own) && !known && *bic <= RIVAL_SPAN {
                rival_effects.push((instead, bic.max(0.0)));
            }
        }
        let mut bic = vec![0.0];
        bic.extend(rival_effects.iter().map(|(_, bic)| *bic));
        let weights = weights(&bic, RIVAL_SPAN);
        let Some(score) = found.score(*own) else { continue };
        let rivals = rival_effects.iter().zip(&weights[1..]).map(|((column, bic), weight)| RivalEffect {
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

/// Least objective of the accepted plant under the noise of `refit`: from its own parameters and
/// from those of `refit`, fitted again, then the noise.
fn nominal_with(session: &EstimationSession<'_>, best: &FittedModel, refit: &FittedModel) -> Option<f64> {
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
