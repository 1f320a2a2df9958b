//! The decision as one comparison of hypotheses, in nats.
//!
//! A hypothesis is a way in which the nominal plant is wrong: an effect at a site, the same law at
//! all like sites, coloured noise, a number in conflict with its file, inputs shifted by a share of
//! a sample. A set of them is a model:
//!
//! ```text
//! log Z = log ∫ p(D | θ, φ, η) p(θ) p(φ) p(η)          plant, effects and noise, each with a prior
//! odds(set : plant alone) = Z_set / Z_0 · (ρ/m)^|set|     m hypotheses at all sites
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `marginal`, `noise` | Laplace's method with bounds; the noise with its priors |
//! | `timing`, `exact` | inputs between their samples; numbers that are stated as exact |
//! | `hypothesis`, `scale`, `model` | priors of laws; how large they may be; a fitted set |
//! | `follow`, `onset`, `sharpness` | numbers that a fit holds: times, rates over which signs turn |
//! | `screen`, `propose`, `others`, `disturbed` | the catalogue about a model; what to fit |
//! | `temper`, `predict`, `learned` | coloured innovations; held-out data in nats |
//! | `horizon` | distances from held-out data in free runs over windows: whether it matters |
//! | `pool`, `search`, `beginning` | sets compared by pairs; sets that grow and shrink |
//! | `alias`, `law`, `powers` | models that are the same on a record; what no entry describes |
//! | `labels` | recordings as labelled against corrected ones |
//! | `decide`, `answer` | every constant, the verdict; the diagnosis |
//!
//! Not built: latent inputs, the share of coloured noise beside white one.

mod alias;
mod answer;
mod augmented;
mod beginning;
mod decide;
mod disturbed;
mod exact;
mod exact_columns;
mod follow;
mod horizon;
mod hypothesis;
pub mod labels;
mod law;
mod learned;
mod linear_evidence;
mod marginal;
mod model;
mod noise;
mod onset;
mod others;
mod pool;
mod powers;
mod predict;
mod propose;
mod relatives;
mod scale;
mod screen;
mod search;
mod sharpness;
mod starts;
mod temper;
mod timed;
mod timing;

use crate::diagnose::{Diagnosis, Options, Phase, even_stamps, insufficient_data, nominal, within_limit};
use crate::outline::Outline;
use identification::fit::{EstimationSession, Fit};
use identification::problem::Problem;
use identification::work::Work;
use model::{Ground, Model, settled};
use std::sync::Arc;

/// Diagnoses `problem`: which physics is unmodelled, by the evidence of sets of hypotheses.
/// `progress` receives a phase and the share of the planned work that is done.
///
/// A problem that cannot be decided (too few samples, a constant channel, a fit that fails) is a
/// [`Diagnosis`] with the verdict `cannot_decide` and the reason, never an error. The same problem
/// and options give the same answer on every machine and with any number of threads.
///
/// Cost: at most [`Options::work_max`], half as much more for what it then finishes, and one
/// linearisation; where that does not pay for the whole recording, its beginning is diagnosed.
pub fn diagnose(problem: &Problem, options: &Options, progress: &mut dyn FnMut(Phase, f64)) -> Diagnosis {
    within_limit(problem, options, &mut |problem, options, work| {
        even_stamps(problem, options, work, &mut |problem, options| run(problem, options, work, progress))
    })
}

fn run(
    problem: &Problem,
    options: &Options,
    work: &Arc<Work>,
    progress: &mut dyn FnMut(Phase, f64),
) -> Result<Diagnosis, String> {
    let mut session =
        EstimationSession::counted(problem, options.threads, work.clone()).map_err(|error| error.to_string())?;
    let mut outline = Outline::new(&session, progress);
    outline.begin(Phase::Fit);
    if let Some(reason) = insufficient_data(&session) {
        return Err(reason);
    }
    let stated = nominal(&session, options)?;
    session.lower_floors();
    outline.begin(Phase::Noise);
    let bare = bare(&session, &stated).ok_or("the evidence of the plant alone cannot be found")?;
    outline.begin(Phase::Compare);
    let leads = beginning::leads(&session, &bare, options, &mut outline);
    let pool = search::searched(&session, (bare, &leads), options, &mut outline);
    outline.begin(Phase::UnknownLaw);
    let own = session.in_parts(pool.parts).map_err(|error| error.to_string())?;
    let goes_on = session.work.goes_on(Phase::UnknownLaw.words());
    let law = if goes_on { law::missing(Ground { session: &own }, &pool, &options.without) } else { None };
    let mut notes = problem.notes.clone();
    if pool.parts > 1 {
        notes.push(format!("steps of integration were taken in {} parts until evidence stood", pool.parts));
    }
    notes.extend(session.work.note());
    outline.begin(Phase::Report);
    Ok(answer::answered(&own, &pool, law.as_ref(), (options, notes)))
}

/// The plant without hypotheses: from the fit under stated noise on.
fn bare(session: &EstimationSession<'_>, stated: &Fit) -> Option<Model> {
    settled(Ground { session }, &[], session.problem.clone(), (session.prior(), &stated.theta), &session.noise)
}

#[cfg(test)]
mod cases;
#[cfg(test)]
mod tests;
