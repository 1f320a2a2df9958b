//! What the beginning of a long recording shows, searched before the whole.
//!
//! A search about a plant that lacks a law fits many sets whose likelihoods lie far behind. On a
//! beginning each of them costs its share. The sets that lead there are fitted to the whole, and
//! the search goes on about them: evidence, names and probabilities are those of all readings.

use super::hypothesis::Hypothesis;
use super::model::{Ground, Model, from};
use super::pool::Pool;
use super::search::searched;
use crate::diagnose::Options;
use crate::outline::Outline;
use dynamics::effect::Role;
use identification::fit::EstimationSession;

/// Readings of a beginning, recordings this many times longer than it have one, and sets of it that
/// are fitted to the whole. Budgets.
const READINGS: usize = 6000;
const LONGER_MIN: usize = 3;
const SETS_MAX: usize = 3;

/// Sets that lead on the beginning of the recordings, best first; none of recordings that are not
/// long, and of a beginning that lacks nothing.
///
/// Cost: a search on the beginning.
pub(super) fn leads(
    session: &EstimationSession<'_>,
    bare: &Model,
    options: &Options,
    outline: &mut Outline<'_>,
) -> Vec<Model> {
    if session.samples < LONGER_MIN * READINGS {
        return Vec::new();
    }
    let problem = session.problem.split(READINGS as f64 / session.samples as f64).0;
    let Ok(mut own) = EstimationSession::counted(&problem, session.threads, session.work.clone()) else {
        return Vec::new();
    };
    own.lower_floors();
    let Some(bare) = from(Ground { session: &own }, &[], bare.begin(), 1.0) else { return Vec::new() };
    let options = Options { held_out: None, ..options.clone() };
    let mut leads = leading(searched(&own, (bare, &[]), &options, outline));
    let lasts_s = problem.duration_s();
    let longer = libm::log(session.problem.duration_s() / lasts_s);
    leads.iter_mut().for_each(|lead| pick_of_more(&mut lead.set, lasts_s, longer));
    leads
}

/// Times that were picked among the samples of a beginning of `lasts_s` are picked among those of
/// the whole.
fn pick_of_more(set: &mut [Hypothesis], lasts_s: f64, longer: f64) {
    for part in set.iter_mut().flat_map(Hypothesis::parts_mut) {
        let value = |role: Role| Some(part.column.candidate.inner[part.column.candidate.inner_with(role)?].1);
        let times = [value(Role::Onset), value(Role::Duration).filter(|value| *value < lasts_s)];
        part.log_points += times.iter().flatten().count() as f64 * longer;
    }
}

/// The best models with findings of a pool that is ahead of the plant without one.
fn leading(pool: Pool) -> Vec<Model> {
    let (best, quiet) = (pool.best(), pool.quiet());
    if best == quiet {
        return Vec::new();
    }
    let mut order: Vec<usize> = (0..pool.entries.len()).filter(|place| !pool.entries[*place].rejected).collect();
    order.sort_by(|a, b| pool.ahead(*b, best).total_cmp(&pool.ahead(*a, best)));
    let ahead = order.into_iter().take_while(|place| *place != quiet && *place != 0);
    ahead.take(SETS_MAX).map(|place| pool.entries[place].model.clone()).collect()
}
