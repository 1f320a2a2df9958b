//! The last hypotheses: a law that no entry of the catalogue describes, and innovations that are
//! not white.

use super::decide::LEVEL;
use super::hypothesis::Hypothesis;
use super::model::{Ground, Model};
use super::pool::Pool;
use super::powers;
use crate::diagnose::{LawMap, Where, bin_location, located, state_map};
use crate::omnibus::{Outliers, StrongestBin, strongest_bin, without_outliers};
use crate::unknown_law::{self, UnknownLaw};
use identification::fit::EstimationSession;
use identification::held_out::{Status, instants};

/// What a remainder is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A law alone is ahead of the leading model; over time alone anything is smooth: a
    /// disturbance, or a law.
    Instead { is_of_time: bool },
    /// A law is left beside the names, of less evidence than they have.
    Beside,
    /// Of more.
    Larger { is_of_time: bool },
    /// Energy in a bin of time and frequency, of no known law.
    Coloured,
    /// Single readings alone.
    Outliers,
}

/// What the leading model lacks.
pub(super) struct Law {
    pub kind: Kind,
    pub words: String,
    pub place: Where,
    /// Of a law: its map over its coordinates.
    pub map: Option<LawMap>,
}

/// The law that the leading model lacks, where its odds reach the level and parts of the recording
/// that it was not fitted to bear it out; else innovations that are not white; `None` where nothing
/// is left.
///
/// Cost: the maps of every place, twice where names lead.
pub(super) fn missing(ground: Ground<'_>, pool: &Pool, without: &[String]) -> Option<Law> {
    let level = libm::log(LEVEL / (1.0 - LEVEL));
    let best = pool.best();
    let of = |place: usize| {
        let model = &pool.entries[place].model;
        let session = model.session(ground)?;
        let plant = &model.problem.plant;
        let found = unknown_law::best(&session, plant, &model.fit.linearised, &model.fit.theta, &model.noise)?;
        Some((nats_of(&found, pool)?, found))
    };
    let beside = of(best);
    let rest = || not_white(ground, &pool.entries[best].model, pool.log_m + level);
    // a law alone that is ahead of the names; names that leave nothing lack no map of many numbers
    let quiet = pool.quiet();
    let is_left = best != quiet && (beside.is_some() || rest().is_some());
    let is_ahead = |(nats, _): &(f64, UnknownLaw)| *nats > pool.log_odds_here(best) + level;
    let alone = if is_left { of(quiet).filter(is_ahead) } else { None };
    // of two laws of one number the one with a name carries it: one without may take the place of
    // several numbers, or of none
    let numbers = numbers(&pool.entries[best].model);
    let needed = pool.log_odds_here(best) + level + pool.log_m;
    let power = if numbers != 1 { powers::best(ground, &pool.entries[quiet].model, (without, needed)) } else { None };
    let power = power.and_then(|found| Some((nats_of(&found, pool)?, found))).filter(is_ahead);
    let (instead, beside) = if numbers > 0 { (alone, beside) } else { (beside, None) };
    let instead = power.into_iter().chain(instead).max_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((nats, found)) = instead {
        // one number times a function of time is a law; any function of time is not
        let kind = Kind::Instead { is_of_time: found.formula.is_none() && found.place.is_of_time() };
        return Some(law(ground, kind, words(nats, &found), &found));
    }
    match beside {
        Some((nats, found)) => {
            let kind = beside_names(nats, pool.log_odds_here(best), found.place.is_of_time());
            Some(law(ground, kind, format!("beside that, {}", words(nats, &found)), &found))
        }
        None => rest(),
    }
}

/// How many numbers the laws of a model have.
fn numbers(model: &Model) -> usize {
    model.set.iter().flat_map(Hypothesis::parts).map(|part| part.column.candidate.numbers()).sum()
}

/// Nats of a law ahead of the plant without a finding, price and choice counted, where its odds
/// reach the level and parts of the recording that it was not fitted to confirm it.
fn nats_of(found: &UnknownLaw, pool: &Pool) -> Option<f64> {
    let nats = 0.5 * found.evidence - libm::log(found.tried.max(1) as f64) - pool.log_m;
    let level = libm::log(LEVEL / (1.0 - LEVEL));
    (nats > level && found.held_out.status() == Status::Confirmed).then_some(nats)
}

/// What is left beside names. A law that explains ρ² of one outside the catalogue takes ρ² of its
/// evidence and leaves the rest: below one half it may be no more than its shadow.
fn beside_names(nats: f64, of_names: f64, is_of_time: bool) -> Kind {
    if nats > of_names { Kind::Larger { is_of_time } } else { Kind::Beside }
}

/// The bin of most energy of a model's innovations, where its odds reach the level: at most
/// `−1/(e p ln p)` to one of a p value (Sellke, Bayarri & Berger, Am. Stat. 55, 2001).
fn not_white(ground: Ground<'_>, model: &Model, least: f64) -> Option<Law> {
    let session = model.session(ground)?;
    let r = instants(&session, &model.fit.linearised.linears, &model.noise)?.1;
    let nats = |bin: &StrongestBin| {
        let p = bin.p().max(f64::MIN_POSITIVE);
        if p < core::f64::consts::E.recip() { -1.0 - libm::log(p) - libm::log(-libm::log(p)) } else { 0.0 }
    };
    let bin = strongest_bin(&session, &r).filter(|bin| nats(bin) > least)?;
    let (outliers, beside) = without_outliers(&session, &r);
    let is_alone = outliers.iter().all(Outliers::is_rare) && beside.is_none_or(|bin| nats(&bin) < least);
    let kind = if is_alone { Kind::Outliers } else { Kind::Coloured };
    let channel = &model.problem.plant.sensors[bin.channel].name;
    let ([begin, end], [low, high]) = (bin.time_s, bin.band_hz);
    let all = outliers.iter().map(|own| outlying(&session, own)).collect::<Vec<_>>().join("; ");
    let white = || {
        format!(
            "the innovations are not white: most energy is left in {channel} from {begin:.3} to {end:.3} s between {low:.3} and {high:.3} Hz, \
         {:.1} nats, of no law or noise that was compared",
            nats(&bin)
        )
    };
    let words = if is_alone { format!("outliers: {all}") } else { white() };
    Some(Law { kind, words, place: bin_location(&session, &bin), map: None })
}

/// `angle has 3 of 2000 beyond 4 standard deviations, the largest of 17.2 at 7.000 s of run.csv`.
fn outlying(session: &EstimationSession<'_>, own: &Outliers) -> String {
    let problem = session.problem;
    let (channel, recording) =
        (&problem.plant.sensors[own.channel].name, &problem.recordings[problem.runs[own.run].recording]);
    let Outliers { count, samples, largest, time_s, .. } = own;
    format!(
        "{channel} has {count} of {samples} beyond 4 standard deviations, the largest of {largest:.1} at {time_s:.3} s of {recording}"
    )
}

fn law(ground: Ground<'_>, kind: Kind, words: String, found: &UnknownLaw) -> Law {
    let session = ground.session;
    Law { kind, words, place: located(session, found, 1.0 - LEVEL), map: Some(state_map(session, found)) }
}

fn words(nats: f64, found: &UnknownLaw) -> String {
    let over = found.names.join(" and ");
    let what = match &found.formula {
        Some(formula) => format!("one number times {formula}"),
        None => format!("a law smooth over {over}"),
    };
    format!(
        "something acts at {} that no effect of the catalogue describes: {what} is {nats:.1} nats ahead",
        found.place.site
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_as_long_as_they_have_more_evidence_than_what_they_leave() {
        assert_eq!(beside_names(29.0, 43.0, true), Kind::Beside);
        assert_eq!(beside_names(43.0, 29.0, true), Kind::Larger { is_of_time: true });
    }
}
