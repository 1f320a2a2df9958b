//! Selection on held-out data: which of several sets they prefer, and what each effect of a set
//! adds to the others.
//!
//! An effect is confirmed on its own where the set predicts better with it than without it, the
//! others fitted again. An effect that held-out data reject beside the others is removed. An effect
//! that they do not decide is reported and stays out of the model.

use super::held_out_evidence::{HeldOutEvidence, held_out, with_expected_gain};
use super::search::SearchResult;
use super::{Adopted, Options, RIVAL_SPAN, status};
use crate::compete::{FittedModel, multistart, refine_onsets};
use crate::score::Column;
use core::cmp::Ordering;
use identification::fit::{EstimationSession, Fit};
use identification::held_out::{Gain, Status};
use identification::problem::Problem;

/// Log-odds from which another recording replaces the adopted set by a rival: ln 20 = 3.0, odds of
/// 20 : 1.
const RIVAL_LOG_ODDS_MIN: f64 = 3.0;
/// Probability that an effect that adds nothing is rejected or confirmed; for rejections divided by
/// the number of effects tested (Bonferroni).
const MEMBER_TEST_LEVEL: f64 = 0.05;

/// Evidence of held-out data on a set of effects, and on each.
pub(super) struct HeldOutSelection {
    /// For the whole model.
    pub evidence: HeldOutEvidence,
    /// For each adopted effect, in their order.
    pub status: Vec<Status>,
    /// The plant with the effects that are confirmed each on its own, where the set is.
    pub model: FittedModel,
    /// Rejected effects, with the plant that had them.
    pub rejected: Vec<(Adopted, FittedModel)>,
}

/// The plant without one of its effects, and the gain on held-out data of the plant with it.
struct Part {
    without: FittedModel,
    gain: Gain,
}

/// A recording, the nominal plant and the held-out data to test on.
struct HeldOutTest<'a> {
    problem: &'a Problem,
    session: &'a EstimationSession<'a>,
    stated: &'a Fit,
    options: &'a Options,
}

/// Tests `found` on held-out data; the effects that they reject are removed from it.
///
/// Cost: a prediction for each rival and smaller set, and a fit and a prediction for each effect of
/// a set of several.
pub(super) fn select_on_held_out(
    problem: &Problem,
    (session, stated): (&EstimationSession<'_>, &Fit),
    found: &mut SearchResult,
    options: &Options,
    notes: &mut Vec<String>,
) -> HeldOutSelection {
    let test = HeldOutTest { problem, session, stated, options };
    let mut rivals: Vec<ParameterSet> =
        found.rivals.iter().map(|(_, standing, behind)| ParameterSet::of(standing, *behind)).collect();
    rivals.push(ParameterSet::of(&found.best, 0.0));
    let (mut evidence, lead) = choose_among_rivals(&test, found, notes);
    let mut rejected = Vec::new();
    let mut parts = test.parts(&found.best, &found.adopted);
    while let Some(place) = worst(&parts, |gain, count| gain.interval(MEMBER_TEST_LEVEL / count)[1] < 0.0) {
        let Some(part) = parts.swap_remove(place) else { break };
        let gone = found.adopted.remove(place);
        notes.push(format!("held-out data reject {} beside {}", named([&gone]), named(&found.adopted)));
        let left = test.standing(part.without, &found.adopted);
        rejected.push((gone, core::mem::replace(&mut found.best, left)));
        evidence = test.held_out(&found.best, false);
        parts = test.parts(&found.best, &found.adopted);
    }
    // up to here gains were only tested for confirmation
    evidence.gain = evidence.gain.map(|gain| with_expected_gain((session, stated), &found.best, gain, options));
    let of_all = status(evidence.gain.as_ref());
    let mut selection =
        HeldOutSelection { evidence, status: vec![of_all; found.adopted.len()], model: found.best.clone(), rejected };
    if of_all != Status::Rejected {
        selection.confirm_each(&test, &found.adopted, parts);
    }
    widen(&mut found.best, &rivals, lead);
    widen(&mut selection.model, &rivals, lead);
    selection
}

impl HeldOutSelection {
    /// An effect without a certain gain leaves the model, the least first, where the rest is
    /// confirmed.
    fn confirm_each(&mut self, test: &HeldOutTest<'_>, adopted: &[Adopted], mut parts: Vec<Option<Part>>) {
        let mut left: Vec<usize> = (0..adopted.len()).collect();
        let others = |left: &[usize]| left.iter().map(|place| adopted[*place].clone()).collect::<Vec<_>>();
        let mut model = None;
        // a bound that cannot be compared is not above zero
        while let Some(place) =
            worst(&parts, |gain, _| gain.interval(MEMBER_TEST_LEVEL)[0].partial_cmp(&0.0) != Some(Ordering::Greater))
        {
            let Some(part) = parts.swap_remove(place) else { break };
            left.remove(place);
            let standing = test.standing(part.without, &others(&left));
            parts = test.parts(&standing, &others(&left));
            model = Some(standing);
        }
        let Some(model) = model else { return };
        let evidence = test.held_out(&model, false);
        // otherwise they are confirmed together and none alone
        if status(evidence.gain.as_ref()) == Status::Confirmed {
            self.status.fill(Status::Unconfirmed);
            left.iter().for_each(|place| self.status[*place] = Status::Confirmed);
            (self.model, self.evidence) = (model, evidence);
        }
    }
}

/// The part of least gain among those that are `meant`, given their gains and the number of parts.
fn worst(parts: &[Option<Part>], meant: impl Fn(&Gain, f64) -> bool) -> Option<usize> {
    let all = parts.iter().enumerate().filter_map(|(place, part)| Some((place, part.as_ref()?.gain)));
    let those = all.filter(|(_, gain)| meant(gain, parts.len() as f64));
    those.min_by(|a, b| a.1.loglik_gain.total_cmp(&b.1.loglik_gain)).map(|(place, _)| place)
}

impl HeldOutTest<'_> {
    fn held_out(&self, best: &FittedModel, nothing: bool) -> HeldOutEvidence {
        held_out(self.problem, self.session, self.stated, best, nothing, self.options)
    }

    /// The fit without some effects after multistart, its standard deviations over all local
    /// optima.
    fn standing(&self, left: FittedModel, adopted: &[Adopted]) -> FittedModel {
        let columns: Vec<&Column> = adopted.iter().map(|own| &own.column).collect();
        multistart(self.session, refine_onsets(self.session, left, &columns), &columns).merged()
    }

    /// Tests each of `adopted` on its own, where there are several.
    ///
    /// Cost: a fit and a prediction each.
    fn parts(&self, best: &FittedModel, adopted: &[Adopted]) -> Vec<Option<Part>> {
        let several = adopted.len() > 1;
        adopted.iter().map(|own| several.then(|| self.part(best, own)).flatten()).collect()
    }

    fn part(&self, best: &FittedModel, own: &Adopted) -> Option<Part> {
        let without = best.without(self.session, &own.column)?;
        let session = EstimationSession::like(self.session, &without.problem).ok()?;
        let gain = held_out(&without.problem, &session, &without.fit, best, false, self.options).gain?;
        drop(session);
        Some(Part { without, gain })
    }
}

fn named<'a>(set: impl IntoIterator<Item = &'a Adopted>) -> String {
    set.into_iter().map(|own| own.column.candidate.effect.kind).collect::<Vec<_>>().join(" and ")
}

/// Evidence of held-out data, and the ΔBIC of the set chosen behind the best one on this recording.
/// A rival replaces the adopted set if both recordings together prefer it, each law under its own
/// noise, or if it alone is confirmed; otherwise the nearest smaller set that held-out data
/// confirm, or at least predict better with, is taken. Weights stay those of this recording: for
/// laws that only approximate the truth a second recording would make them overconfident.
fn choose_among_rivals(
    test: &HeldOutTest<'_>,
    found: &mut SearchResult,
    notes: &mut Vec<String>,
) -> (HeldOutEvidence, f64) {
    let (evidence, lead) = preferred_rival(test, found, notes);
    (prefer_smaller_confirmed_set(test, found, evidence, notes), lead)
}

/// The rival that both recordings together prefer, if any.
fn preferred_rival(
    test: &HeldOutTest<'_>,
    found: &mut SearchResult,
    notes: &mut Vec<String>,
) -> (HeldOutEvidence, f64) {
    let mut evidence = test.held_out(&found.best, found.adopted.is_empty());
    let rivals = core::mem::take(&mut found.rivals);
    // Bonferroni over the rivals: the best of several confirmations occurs by chance more often
    let alpha = MEMBER_TEST_LEVEL / rivals.len().max(1) as f64;
    let mut lead = 0.0;
    // parts of the same recording took part in the selection already
    let is_other = test.options.held_out.is_some();
    for (set, standing, behind) in rivals.into_iter().filter(|_| is_other) {
        let is_confirmed = status(evidence.gain.as_ref()) == Status::Confirmed;
        let again = test.held_out(&standing, false);
        // log-odds by both recordings
        let ahead = again.loglik.zip(evidence.loglik).map_or(0.0, |(rival, own)| rival - own - 0.5 * (behind - lead));
        let confirms = again.gain.as_ref().is_some_and(|gain| gain.interval(alpha)[0] > 0.0);
        // if neither is confirmed, the better predicted one as well
        if (confirms || !is_confirmed) && ahead > RIVAL_LOG_ODDS_MIN || confirms && !is_confirmed {
            let word =
                if confirms && !is_confirmed { "held-out data confirm" } else { "both recordings together prefer" };
            notes.push(format!("{word} {}, not {}", named(&set), named(&found.adopted)));
            (found.adopted, found.best, found.unknown_noise, evidence, lead) = (set, standing, 0.0, again, behind);
        }
    }
    (evidence, lead)
}

/// The plant's parameters under one set: names, values, standard deviations, and the set's ΔBIC on
/// this recording.
struct ParameterSet {
    list: Vec<(String, f64, f64)>,
    behind: f64,
}

impl ParameterSet {
    fn of(standing: &FittedModel, behind: f64) -> Self {
        let (unknowns, fit) = (&standing.problem.unknowns, &standing.fit);
        let numbers = unknowns.iter().zip(&fit.theta).zip(&fit.sigma);
        Self { list: numbers.map(|((unknown, theta), sigma)| (unknown.name.clone(), *theta, *sigma)).collect(), behind }
    }
}

/// Standard deviations over all sets that this recording does not exclude, weights `exp(−ΔBIC/2)`.
/// If several effects remain possible, parameter uncertainties include all of them.
///
/// ```text
/// σ² ← Σ w_i (σ_i² + (θ_i − θ)²) / Σ w_i,   never below its own
/// ```
fn widen(best: &mut FittedModel, sets: &[ParameterSet], lead: f64) {
    let open: Vec<&ParameterSet> = sets.iter().filter(|set| set.behind - lead <= RIVAL_SPAN).collect();
    let fit = &mut best.fit;
    for ((unknown, theta), sigma) in best.problem.unknowns.iter().zip(&fit.theta).zip(&mut fit.sigma) {
        let (mut whole, mut sum) = (0.0, 0.0);
        for set in &open {
            let Some((_, value, spread)) = set.list.iter().find(|(name, ..)| *name == unknown.name) else { continue };
            let weight = libm::exp(-0.5 * (set.behind - lead));
            whole += weight;
            sum += weight * (spread * spread + (value - theta) * (value - theta));
        }
        if whole > 0.0 {
            *sigma = sigma.max((sum / whole).sqrt());
        }
    }
}

/// The nearest smaller set where held-out data do not confirm all of `found`: an unconfirmed effect
/// must not discredit the others.
fn prefer_smaller_confirmed_set(
    test: &HeldOutTest<'_>,
    found: &mut SearchResult,
    mut evidence: HeldOutEvidence,
    notes: &mut Vec<String>,
) -> HeldOutEvidence {
    for (set, standing) in core::mem::take(&mut found.smaller) {
        if found.adopted.is_empty() || status(evidence.gain.as_ref()) == Status::Confirmed {
            break;
        }
        let law = |own: &Adopted, other: &Adopted| own.column.candidate.same_law(&other.column.candidate);
        // sets from before a replacement hold other effects
        if !set.iter().all(|own| found.adopted.iter().any(|other| law(own, other))) {
            continue;
        }
        let again = test.held_out(&standing, false);
        let gain =
            |evidence: &HeldOutEvidence| evidence.gain.as_ref().map_or(f64::NEG_INFINITY, |gain| gain.loglik_gain);
        let is_confirmed = status(again.gain.as_ref()) == Status::Confirmed;
        if is_confirmed || gain(&again) > gain(&evidence) {
            let word = if is_confirmed { "confirm" } else { "are better predicted by" };
            notes.push(format!(
                "held-out data {word} {} of {} effects that this recording suggests",
                set.len(),
                found.adopted.len()
            ));
            (found.adopted, found.best, found.unknown_noise, evidence) = (set, standing, 0.0, again);
        }
    }
    evidence
}

#[cfg(test)]
mod tests;
