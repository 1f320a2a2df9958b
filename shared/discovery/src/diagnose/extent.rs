//! How much of a recording the limit of the work pays for, and the fit of the nominal plant within
//! its share.
//!
//! Every step of a diagnosis costs in proportion to the recording: no limit of the search bounds a
//! diagnosis of any length. Where the limit does not pay for the least that a diagnosis needs, the
//! beginning is diagnosed that it pays for, and the report says so.

use super::{Diagnosis, Options, Verdict};
use identification::fit::{EstimationSession, Fit, fit, fit_by_continuation};
use identification::problem::{Problem, Unknown};
use identification::work::{LIMIT_NOTE, Work};
use std::sync::Arc;

/// Relinearisations that a diagnosis needs at least: of the nominal plant under stated and under
/// adapted noise, of a leading set and of its rival, six each.
const DIAGNOSIS_ROUNDS: f64 = 24.0;
/// Relinearisations of the nominal fit; it ends earlier where it has converged.
const NOMINAL_ROUNDS: usize = 6;
/// Share of the work left for it, which is a third of a limit at first.
const NOMINAL_SHARE: f64 = 2.0 / 9.0;
/// Why a nominal fit that has no room to end decides nothing.
const NOMINAL_UNFINISHED: &str = "the fit of the plant as stated did not end within a third of the work, on a sixteenth of the recording neither: what it leaves is no evidence of unmodelled physics. Give a shorter part of the recording, fewer uncertain parameters, start values that are nearer, or a higher --effort";

/// What is left of a recording on which the nominal fit had no room to end: its cost with it.
const SHORTER: f64 = 0.25;
/// How often it is shortened.
const SHORTER_MAX: usize = 2;

/// Share of the recordings from which the answer that nothing is missing is one about them: what
/// can be found in a quarter is up to twice as large as what can be in all.
const LOOKED_AT_MIN: f64 = 0.25;

/// A share of all runs of `problem` from their beginnings on, with a note; `None` from all on.
fn beginning(problem: &Problem, share: f64, what: &str) -> Option<Problem> {
    if share >= 1.0 || share.is_nan() {
        return None;
    }
    let mut beginning = problem.split(share).0;
    let whole_s = problem.duration_s();
    beginning.notes.push(format!("{LIMIT_NOTE}all but the first {:.3} of {whole_s:.3} s of {what}", share * whole_s));
    Some(beginning)
}

/// The share of a recording that `limit` pays for.
fn paid_share(problem: &Problem, limit: f64) -> f64 {
    EstimationSession::new(problem, 1).map_or(1.0, |session| limit / (DIAGNOSIS_ROUNDS * session.round_work()))
}

/// Problem and options with a share of every recording; `None` where that is all of each.
fn cut(problem: &Problem, options: &Options, share: &dyn Fn(&Problem) -> f64) -> Option<(Problem, Options)> {
    let of = |own: &Problem, what: &str| beginning(own, share(own), what);
    let fitted = of(problem, "the fitted recordings");
    let held_out = options.held_out.as_ref().and_then(|own| of(own, "the held-out recordings"));
    if fitted.is_none() && held_out.is_none() {
        return None;
    }
    let mut fitted = fitted.unwrap_or_else(|| problem.clone());
    fitted.notes.extend(held_out.iter().filter_map(|own| own.notes.last().cloned()));
    let held_out = held_out.or_else(|| options.held_out.clone());
    Some((fitted, Options { held_out, ..options.clone() }))
}

/// A diagnosis of a problem whose work is counted, or why there is none.
type Decide<'a> = dyn FnMut(&Problem, &Options, &Arc<Work>) -> Result<Diagnosis, String> + 'a;

/// A diagnosis by `each` of as much of the recordings as the limit pays for, and of a quarter of
/// that, and again, where the nominal fit had no room to end.
pub(crate) fn within_limit(problem: &Problem, options: &Options, each: &mut Decide<'_>) -> Diagnosis {
    let paid = options.work_max.max(options.fit_work_min);
    let work = Arc::new(Work::watched(options.work_max, options.watch.clone()).with_fits_of(paid));
    let mut own = cut(problem, options, &|own| paid_share(own, paid));
    let mut shorter = 0;
    let found = loop {
        let (problem, options) = own.as_ref().map_or((problem, options), |(problem, options)| (problem, options));
        let found = each(problem, options, &work);
        let is_cut = found.as_ref().is_err_and(|reason| reason == NOMINAL_UNFINISHED);
        if !is_cut || shorter == SHORTER_MAX {
            break found;
        }
        shorter += 1;
        own = cut(problem, options, &|_| SHORTER);
    };
    work.plan(0.0, 0.0);
    let whole_s = problem.duration_s();
    let problem = own.as_ref().map_or(problem, |(problem, _)| problem);
    found.map(|found| nothing_in_a_part(found, problem.duration_s(), whole_s)).unwrap_or_else(|reason| {
        let notes = problem.notes.iter().filter(|note| note.starts_with(LIMIT_NOTE)).cloned().collect();
        Diagnosis { notes, ..Diagnosis::cannot_decide(reason) }
    })
}

/// `found`; where nothing was found in less than [`LOOKED_AT_MIN`] of the recordings, that the rest
/// was not examined.
fn nothing_in_a_part(found: Diagnosis, part_s: f64, whole_s: f64) -> Diagnosis {
    let is_quiet = matches!(found.verdict, Verdict::None | Verdict::NoiseModel);
    let is_enough = part_s >= LOOKED_AT_MIN * (1.0 - 1e-9) * whole_s;
    if !is_quiet || is_enough {
        return found;
    }
    let reason = format!(
        "nothing is missing in the first {part_s:.3} of {whole_s:.3} s, which is all that this effort pays for: the rest was not examined. Give a part of the recording in which much happens, fewer uncertain parameters, or a higher --effort"
    );
    Diagnosis { verdict: Verdict::CannotDecide, reason, ..found }
}

/// The nominal plant under its stated noise.
///
/// # Errors
/// The plant cannot predict the recording, or the fit did not end within its share of the work and
/// nothing else says that the plant lacks something.
pub(crate) fn nominal(session: &EstimationSession<'_>, options: &Options) -> Result<Fit, String> {
    let own = EstimationSession { work: Work::part(&session.work, NOMINAL_SHARE), ..session.clone() };
    let found = match &options.refused_at {
        Some(at) => fit(&own, &own.problem.plant, &started(&own, at), &own.noise, NOMINAL_ROUNDS),
        None => fit_by_continuation(&own, NOMINAL_ROUNDS),
    };
    let fit = found.map_err(|error| error.to_string())?;
    let is_cut = !fit.converged && own.work.note().is_some() && options.refused_at.is_none();
    if is_cut { Err(NOMINAL_UNFINISHED.to_owned()) } else { Ok(fit) }
}

/// Values of all unknowns: those of `at`, within what is possible, others at their priors.
fn started(session: &EstimationSession<'_>, at: &[(String, f64)]) -> Vec<f64> {
    let value = |unknown: &Unknown| {
        let known = at.iter().find(|(name, _)| *name == unknown.name).map(|(_, value)| *value);
        known.map_or(unknown.prior, |value| value.clamp(unknown.low, unknown.high))
    };
    session.problem.unknowns.iter().map(value).collect()
}

#[cfg(test)]
mod tests;
