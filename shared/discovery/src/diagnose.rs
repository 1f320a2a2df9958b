//! What physics was left out of a plant, according to recordings: compare, locate, name, model, show.
//!
//! Order of work: fit the nominal plant; maximise its noise; score every effect at every site under the stated and under the adapted
//! noise; let the best compete with two-sided likelihoods; fit them as physics; repeat with the enlarged plant, at most three
//! times, what a later effect takes the place of leaving again; look once more for what came first beside all others; freeze everything
//! and ask data that were not used, of all effects and of each. Where nothing stands, what is only suspected is asked of another recording. Nothing is named that the robust score vetoes or held-out data refuse; a significant score whose model cannot be fitted is reported as that.
//!
//! Every loop is bounded, and those of the search together by [`Options::work_max`]; what was cut is said.

mod adoption;
mod evidence;
mod figures;
mod judged;
mod next;
mod plainer;
mod repeat;
mod report;
mod screening;
mod search;
mod showing;
mod silent;
mod stamps;
mod suspicion;
mod verdict;

pub use report::{
    Angles, Compare, DetectionLimit, Diagnosis, EffectReport, EvidenceCurve, Figures, HeldOut, HeldOutChannel,
    HeldOutKind, LawCell, LawMap, Nominal, Overlay, ParameterReport, Rival, Tile, Verdict, Where,
};

use judged::judged;
use screening::Screening;
use search::searched;

use crate::omnibus::{Loudest, Outliers, loudest, without_outliers};
use crate::score::{Candidate, Column, Score};
use crate::unknown_law::{self, UnknownLaw};
use dynamics::description::Plant;
use identification::filter::NoiseModel;
use identification::fit::bounded::bounded;
use identification::fit::noise::{Search, maximise};
use identification::fit::{EstimationSession, Fit, fit, fit_by_continuation};
use identification::held_out::{Gain, Status};
use identification::problem::Problem;
use identification::work::Work;
use std::rc::Rc;

/// Bounds and levels.
#[derive(Clone, Debug)]
pub struct Options {
    /// Probability of any finding where nothing is missing.
    pub alpha: f64,
    pub terms_max: usize,
    pub threads: usize,
    /// Effects that the catalogue is taken without.
    pub without: Vec<String>,
    /// Recordings to ask at the end, as a problem of the same plant.
    pub held_out: Option<Problem>,
    /// The same experiment once more, run by run: what physics does repeats, what noise does not.
    pub repeat: Option<Problem>,
    /// Largest work ([`identification::work`]): about nanoseconds of one core; what is left out for it is said.
    pub work_max: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            alpha: 2e-3,
            terms_max: 3,
            threads: 1,
            without: Vec::new(),
            held_out: None,
            repeat: None,
            work_max: identification::work::MOST,
        }
    }
}

/// Share of alpha for physics and sensors with a name that one recording shows.
const NAME_SHARE: f64 = 0.85;
/// Share for those that only a held-out recording confirms.
const CONFIRMED_SHARE: f64 = 0.01;
/// Share of each of the three that have no name: noise, tiles and maps.
const NAMELESS_SHARE: f64 = (1.0 - NAME_SHARE - CONFIRMED_SHARE) / 3.0;
/// ΔBIC within which a rival is printed.
pub const RIVAL_SPAN: f64 = 12.0;
/// Relinearisations of the nominal fit; it ends where it has converged.
const ROUNDS: usize = 6;

/// A plant that stands as the best so far.
#[derive(Clone)]
struct Standing {
    plant: Plant,
    problem: Problem,
    fit: Fit,
    noise: NoiseModel,
    objective: f64,
}

/// One adopted effect.
#[derive(Clone)]
struct Adopted {
    column: Column,
    score: Score,
    /// Significance of the set it came with.
    p: f64,
    /// Square root of the likelihood ratio of that set.
    d: f64,
    weight: f64,
    rivals: Vec<Contested>,
}

/// An effect that could stand in the place of an adopted one.
#[derive(Clone)]
struct Contested {
    candidate: Candidate,
    kind: &'static str,
    site: String,
    weight: f64,
    bic: f64,
    cosine: f64,
}

/// An effect that is significant and could not be fitted.
struct Unfitted {
    column: Column,
    score: Score,
    amplitude: f64,
    ratio: f64,
    p: f64,
}

/// Diagnoses `problem`. `progress` is told a phase and the share done.
pub fn diagnose(problem: &Problem, options: &Options, progress: &mut dyn FnMut(&str, f64)) -> Diagnosis {
    let found = match stamps::evened(problem, options.threads) {
        None => run(problem, options, progress),
        Some(mut even) => {
            even.notes
                .push("the readings are even and their stamps are not: they were put back on their grid".to_owned());
            let again = |other: &Option<Problem>| other.as_ref().map(|p| stamps::even(p).unwrap_or_else(|| p.clone()));
            let (held_out, repeat) = (again(&options.held_out), again(&options.repeat));
            run(&even, &Options { held_out, repeat, ..options.clone() }, progress)
        }
    };
    found.unwrap_or_else(Diagnosis::cannot_decide)
}

fn run(problem: &Problem, options: &Options, progress: &mut dyn FnMut(&str, f64)) -> Result<Diagnosis, String> {
    progress("fit the nominal plant", 0.0);
    let work = std::sync::Arc::new(Work::of(options.work_max));
    let session = EstimationSession::counted(problem, options.threads, work).map_err(|error| error.to_string())?;
    if let Some(reason) = silent::silent(&session) {
        return Err(reason);
    }
    let stated = fit_by_continuation(&session, ROUNDS).map_err(|error| error.to_string())?;
    progress("noise of the nominal plant", 0.1);
    let mut notes = problem.notes.clone();
    let nominal = standing(&session, &stated)?;
    let bare = nominal.clone();
    let noise_p = verdict::noise_p(&session, &stated, &nominal.fit, &nominal.noise, nominal.objective);
    let begun = session.work.spent();
    let mut found = searched(&session, (nominal, Rc::default()), options, progress)?;
    let search = session.work.spent() - begun;
    progress("held out", 0.85);
    let mut judged = judged(problem, (&session, &stated), &mut found, options, &mut notes);
    let is_open = found.adopted.is_empty() && found.unfitted.is_empty() && options.held_out.is_some();
    if is_open && session.work.allows(search, "what is only suspected") {
        progress("what is only suspected", 0.9);
        let confirmed = suspicion::confirmed(problem, (&session, &stated), (&bare, &found), options, &mut notes);
        if let Some(confirmed) = confirmed {
            (found, judged) = confirmed;
        }
    }
    let repeat = match &options.repeat {
        Some(again) if !found.adopted.is_empty() => {
            repeat::ask(again, (&session, &stated, &bare.noise), &found.best, &found.adopted)
        }
        _ => None,
    };
    progress("a plain law without a name", 0.93);
    let plainer = plainer::plainer(&session, &bare, (&found.best, &found.adopted), &found.screening);
    progress("a law that is not in the catalogue", 0.95);
    // what another recording refuses was something here all the same
    let whole = judged.refused.first().map_or(&found.best, |(_, with)| with);
    let mut map = remainder(&session, whole)?;
    if let Some(map) = &mut map {
        map.evidence -= found.unknown_noise;
    }
    let left = left_over(&session, whole)?;
    let explained = (bare.objective - whole.objective).max(0.0);
    notes.extend(session.work.note());
    progress("report", 1.0);
    Ok(verdict::conclude(&verdict::Findings {
        session: &session,
        stated: &stated,
        best: &found.best,
        adopted: &found.adopted,
        unfitted: &found.unfitted,
        screening: &found.screening,
        noise_p,
        map: map.as_ref(),
        plainer: plainer.as_ref(),
        left,
        explained,
        judged,
        repeat,
        notes,
        alpha: options.alpha,
    }))
}

/// The law that the standing plant still lacks.
fn remainder(session: &EstimationSession<'_>, best: &Standing) -> Result<Option<UnknownLaw>, String> {
    let own = EstimationSession::like(session, &best.problem).map_err(|error| error.to_string())?;
    Ok(unknown_law::best(&own, &best.plant, &best.fit.linearised, &best.fit.theta, &best.noise))
}

/// Where the innovations of a plant are least like normal white noise.
#[derive(Default)]
struct LeftOver {
    loudest: Option<Loudest>,
    outliers: Vec<Outliers>,
    /// The loudest tile beside them.
    beside: Option<Loudest>,
}

/// What is left of the innovations of the standing plant.
fn left_over(session: &EstimationSession<'_>, best: &Standing) -> Result<LeftOver, String> {
    let own = EstimationSession::like(session, &best.problem).map_err(|error| error.to_string())?;
    let left = || {
        let normal = best.fit.linearised.normal(&own, &best.fit.theta, &best.noise, &[])?;
        let all: Vec<usize> = (0..normal.unknowns).collect();
        let (_, step) = bounded(&normal.matrix, &normal.right, &normal.room, &all)?;
        let (mut r, columns) = best.fit.linearised.whitened(&own, &best.noise, &[])?;
        for (column, step) in columns.iter().zip(&step) {
            r.iter_mut().zip(column).for_each(|(r, c)| *r -= c * step);
        }
        let (outliers, beside) = without_outliers(&own, &r);
        Some(LeftOver { loudest: loudest(&own, &r), outliers, beside })
    };
    Ok(left().unwrap_or_default())
}

/// Noise maximised, parameters fitted under it, noise once more.
fn standing(session: &EstimationSession<'_>, stated: &Fit) -> Result<Standing, String> {
    let search = Search { sweeps: 8, colour: true, scan: true };
    let failed = || "the likelihood of the noise cannot be found".to_owned();
    let plant = &stated.plant;
    let (noise, _) =
        maximise(session, &stated.linearised, &stated.theta, &[], &session.noise, search).ok_or_else(failed)?;
    let adapted = fit(session, plant, &stated.theta, &noise, ROUNDS).map_err(|error| error.to_string())?;
    let search = Search { scan: false, ..search };
    let (noise, objective) =
        maximise(session, &adapted.linearised, &adapted.theta, &[], &noise, search).ok_or_else(failed)?;
    Ok(Standing { plant: plant.clone(), problem: session.problem.clone(), fit: adapted, noise, objective })
}

/// Standing of all adopted effects together.
fn status(gain: Option<&Gain>) -> Status {
    gain.map_or(Status::Unconfirmed, Gain::status)
}

#[cfg(test)]
mod tests;
