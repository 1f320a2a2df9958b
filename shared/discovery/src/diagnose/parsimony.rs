//! Parsimony: an effect is withdrawn if a one-parameter law outside the catalogue explains the data
//! as well (ΔBIC > 6).
//!
//! The law may replace one adopted effect or all of them.

use super::Adopted;
use super::screening::{Screening, along_noise_free_loop};
use crate::compete::{BIC_PREFERENCE, FittedModel, free_parameters};
use crate::score::{Candidate, Column, columns};
use crate::unknown_law::{Plain, UnknownLaw, plain};
use identification::fit::{EstimationSession, LinearisedProblem};

/// Share of the explained `−2 ln p` by which a law evaluated on the linear model may be wrong.
/// Chosen, no derivation.
const LINEARISATION_ERROR_SHARE: f64 = 1e-3;

/// The one-parameter law that BIC prefers to `adopted` by 20 : 1, the best of several. `nominal` is
/// the plant without any of the effects.
///
/// Cost: a column for each law; with several adopted effects as much again for each, and a fit
/// without it.
pub(super) fn more_parsimonious_law(
    session: &EstimationSession<'_>,
    nominal: &FittedModel,
    (best, adopted): (&FittedModel, &[Adopted]),
    screening: &Screening,
) -> Option<UnknownLaw> {
    let of_one_number = |c: &&Column| c.raw.len() == 1 && free_parameters(&c.candidate, 1) == 1;
    let named: Vec<Candidate> =
        screening.columns.iter().filter(of_one_number).map(|column| column.candidate.clone()).collect();
    let mut found: Vec<(Plain, FittedModel, f64)> = Vec::new();
    let mut look = |base: FittedModel, numbers: f64| {
        let plain = at(session, &base, best, &named);
        found.extend(plain.map(|plain| (plain, base, numbers)));
    };
    let begun = session.work.spent();
    if !adopted.is_empty() {
        look(nominal.clone(), adopted.iter().map(Adopted::parameter_count).sum());
    }
    let mut each = session.work.spent() - begun;
    for own in adopted.iter().filter(|_| adopted.len() > 1) {
        // a fit without it
        if !session.work.allows(2.0 * each, "one-parameter laws in the place of each effect") {
            break;
        }
        let begun = session.work.spent();
        if let Some(without) = best.without(session, &own.column) {
            look(without.merged(), own.parameter_count());
        }
        each = each.max(0.5 * (session.work.spent() - begun));
    }
    let price = libm::log(session.samples.max(2) as f64);
    let ahead = |(plain, base, numbers): &(Plain, FittedModel, f64)| {
        let explained = (base.objective - best.objective).max(0.0);
        best.objective - plain.objective + price * (numbers - 1.0) - LINEARISATION_ERROR_SHARE * explained
    };
    let first = found.into_iter().max_by(|a, b| ahead(a).total_cmp(&ahead(b)))?;
    let by = ahead(&first);
    let (plain, base, numbers) = first;
    let own = EstimationSession::like(session, &base.problem).ok()?;
    (by > BIC_PREFERENCE)
        .then(|| plain.as_unknown_law(&own, (&base.fit.linearised, &base.fit.theta), by, numbers as usize))
        .flatten()
}

/// The best one-parameter law on the plant `base`, under the noise of `best`.
fn at(session: &EstimationSession<'_>, base: &FittedModel, best: &FittedModel, named: &[Candidate]) -> Option<Plain> {
    let own = EstimationSession::like(session, &base.problem).ok()?;
    let (linearised, theta): (&LinearisedProblem, _) = (&base.fit.linearised, &base.fit.theta);
    along_noise_free_loop(&own, base, |along| {
        let named = columns(along, &base.plant, theta, named);
        let named: Vec<&Vec<f64>> = named.iter().filter_map(|column| column.raw.first()).collect();
        plain((&own, linearised), along, &base.plant, theta, &best.noise, &named)
    })
}
