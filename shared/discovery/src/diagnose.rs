//! Which physics is unmodelled, according to recordings: fit, screen, compare, confirm, report.
//!
//! Order of work:
//! 1. fit the nominal plant and maximise the likelihood over its noise;
//! 2. score every effect at every site under the stated and under the adapted noise;
//! 3. compare the best sets by likelihood ratios and fit them as physics;
//! 4. repeat on the augmented plant, at most three times: greedy forward search with backward
//!    elimination;
//! 5. search once more for each earlier effect beside all others;
//! 6. freeze all parameters and predict data that were not fitted, with all effects and without
//!    each.
//!
//! If no effect is accepted, effects of lower significance are tested on the held-out recording
//! alone. No effect is reported that the robust score vetoes or held-out data reject. A significant
//! score whose model cannot be fitted is reported as such.
//!
//! Every loop is bounded, and the search as a whole by [`Options::work_max`]; the report says what
//! was omitted for it.

mod adoption;
mod evidence;
mod extent;
mod figures;
mod held_out_evidence;
mod held_out_selection;
mod insufficient_data;
mod next;
mod parsimony;
mod phase;
mod repeat;
mod report;
mod screening;
mod search;
mod simplest;
mod stamps;
mod suspicion;
mod verdict;

pub(crate) use evidence::{place_of, whiteness_p};
pub(crate) use extent::{NOMINAL_ROUNDS, nominal, within_limit};
pub(crate) use figures::{curve, state_map, tiles};
pub(crate) use held_out_evidence::{HeldOutEvidence, held_out};
pub(crate) use insufficient_data::insufficient_data;
pub(crate) use next::{Next, separating};
pub use phase::Phase;
pub(crate) use report::kept;
pub use report::{
    Angles, Compare, DetectionLimit, Diagnosis, EffectEvidence, EffectReport, EvidenceCurve, ExtraParameterBound,
    Figures, HeldOut, HeldOutChannel, HeldOutKind, InputTiming, LabelReport, LawCell, LawMap, Nominal, OpenHypothesis,
    Overlay, ParameterReport, Rival, Tile, Tried, Verdict, Where,
};
pub(crate) use verdict::{bin_location, located};

use held_out_selection::{HeldOutSelection, select_on_held_out};
use screening::Screening;
use search::{SearchResult, searched};

use crate::compete::FittedModel;
use crate::omnibus::{Outliers, StrongestBin, strongest_bin, without_outliers};
use crate::outline::Outline;
use crate::score::{Candidate, Column, Score};
use crate::unknown_law::{self, UnknownLaw};
use identification::fit::bounded::bounded;
use identification::fit::noise::{Search, maximise};
use identification::fit::{EstimationSession, Fit, fit};
use identification::held_out::{Gain, Status};
use identification::problem::Problem;
use identification::work::{NORMAL_WORK, QUICK_WORK, Watch, Work};
use std::rc::Rc;
use std::sync::Arc;

/// Levels and bounds of a diagnosis.
#[derive(Clone, Debug)]
pub struct Options {
    /// Probability of any finding where no physics is unmodelled, all tests together.
    pub alpha: f64,
    pub terms_max: usize,
    pub threads: usize,
    /// Effects that the catalogue is taken without.
    pub without: Vec<String>,
    /// Recordings to predict at the end, as a problem of the same plant.
    pub held_out: Option<Problem>,
    /// The same experiment repeated, run by run: physics recurs, noise does not.
    pub repeat: Option<Problem>,
    /// Bound of the work ([`identification::work`]), in about nanoseconds of one core; the report
    /// says what was omitted for it.
    pub work_max: f64,
    /// Fits, and how much of a recording is taken, are those of a limit of this at least: a search
    /// may be bounded to nothing, what it starts from may not.
    pub fit_work_min: f64,
    /// Where a fit of a plant has ended that is known to lack something, by the names of its
    /// unknowns: the nominal fit begins there, others at their priors, and one that does not end is
    /// a start all the same. Priors are those of the plant.
    pub refused_at: Option<Vec<(String, f64)>>,
    /// Share of the signal below which what the plant misses in free run is not worth a law; of a
    /// decision by evidence.
    pub worth: f64,
    /// What is not decided gets an experiment that would decide it, beside the limit of the work.
    pub next_experiment: bool,
    /// Sees the work and stops the search, which then ends with what it has found.
    pub watch: Watch,
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
            work_max: NORMAL_WORK,
            fit_work_min: QUICK_WORK,
            refused_at: None,
            worth: 0.0,
            next_experiment: true,
            watch: Watch::default(),
        }
    }
}

/// Share of alpha for effects of the catalogue that one recording shows. The shares add to one
/// (Bonferroni); how they are split is chosen, no derivation.
const ALPHA_SHARE_IDENTIFIED: f64 = 0.85;
/// Share of alpha for effects that only a held-out recording confirms.
const ALPHA_SHARE_CONFIRMED: f64 = 0.01;
/// Share of alpha for each of the three tests without an effect of the catalogue: noise,
/// time–frequency bins, maps.
const ALPHA_SHARE_UNIDENTIFIED: f64 = (1.0 - ALPHA_SHARE_IDENTIFIED - ALPHA_SHARE_CONFIRMED) / 3.0;
/// ΔBIC within which a rival is reported: posterior weight exp(−12/2) = 0.25 % at its edge.
pub const RIVAL_SPAN: f64 = 12.0;
/// Why a diagnosis without a nominal plant decides nothing.
const INTERRUPTED_EARLY: &str = "the search was interrupted before the nominal plant was fitted";

/// An adopted effect.
#[derive(Clone)]
struct Adopted {
    column: Column,
    score: Score,
    /// p value of the set it was adopted with.
    p: f64,
    /// Square root of the likelihood ratio of that set.
    d: f64,
    weight: f64,
    rivals: Vec<RivalEffect>,
}

/// A rival: an effect that could replace an adopted one.
#[derive(Clone)]
struct RivalEffect {
    candidate: Candidate,
    kind: &'static str,
    site: String,
    weight: f64,
    bic: f64,
    cosine: f64,
}

/// A significant effect that could not be fitted.
struct Unfitted {
    column: Column,
    score: Score,
    amplitude: f64,
    ratio: f64,
    p: f64,
}

/// Diagnoses `problem`: the whole sequence above, from the nominal fit to the report. `progress`
/// receives a phase and the share of the planned work that is done.
///
/// A problem that cannot be decided (too few samples, a constant channel, a fit that fails) is a
/// [`Diagnosis`] with the verdict [`Verdict::CannotDecide`] and the reason, never an error. The
/// same problem and options give the same answer on every machine and with any number of threads.
///
/// Cost: at most [`Options::work_max`], half as much more for what it then finishes, and one
/// linearisation; where that does not pay for the whole recording, its beginning is diagnosed.
pub fn diagnose(problem: &Problem, options: &Options, progress: &mut dyn FnMut(Phase, f64)) -> Diagnosis {
    within_limit(problem, options, &mut |problem, options, work| {
        even_stamps(problem, options, work, &mut |problem, options| run(problem, options, work, progress))
    })
}

/// A diagnosis by `each` on even stamps, where they explain the recordings better.
pub(crate) fn even_stamps(
    problem: &Problem,
    options: &Options,
    work: &Arc<Work>,
    each: &mut dyn FnMut(&Problem, &Options) -> Result<Diagnosis, String>,
) -> Result<Diagnosis, String> {
    match stamps::evened(problem, options.threads, work) {
        None => each(problem, options),
        Some(mut even) => {
            even.notes.push(
                "the readings are even and their stamps are not: the stamps were replaced by their grid".to_owned(),
            );
            let again = |other: &Option<Problem>| other.as_ref().map(|p| stamps::even(p).unwrap_or_else(|| p.clone()));
            let (held_out, repeat) = (again(&options.held_out), again(&options.repeat));
            each(&even, &Options { held_out, repeat, ..options.clone() })
        }
    }
}

fn run(
    problem: &Problem,
    options: &Options,
    work: &Arc<Work>,
    progress: &mut dyn FnMut(Phase, f64),
) -> Result<Diagnosis, String> {
    let session =
        EstimationSession::counted(problem, options.threads, work.clone()).map_err(|error| error.to_string())?;
    let mut outline = Outline::new(&session, options.held_out.is_some(), progress);
    outline.begin(Phase::Fit);
    if let Some(reason) = insufficient_data(&session) {
        return Err(reason);
    }
    if session.work.is_stopped() {
        return Err(INTERRUPTED_EARLY.to_owned());
    }
    let stated = nominal(&session, options)?;
    if session.work.is_stopped() {
        return Err(INTERRUPTED_EARLY.to_owned());
    }
    outline.begin(Phase::Noise);
    let mut notes = problem.notes.clone();
    let bare = standing(&session, &stated)?;
    let noise_p = verdict::noise_p(&session, &stated, &bare.fit, &bare.noise, bare.objective);
    outline.noise_found(noise_p);
    let (found, selection) =
        found_and_tested(problem, (&session, &stated, &bare), (options, &mut outline), &mut notes)?;
    let repeat = match &options.repeat {
        Some(again) if !found.adopted.is_empty() => {
            repeat::test_on_repeat(again, (&session, &stated, &bare.noise), &found.best, &found.adopted)
        }
        _ => None,
    };
    outline.begin(Phase::OneParameterLaw);
    let one_parameter_law =
        parsimony::more_parsimonious_law(&session, &bare, (&found.best, &found.adopted), &found.screening);
    outline.begin(Phase::UnknownLaw);
    // an effect that another recording rejects explained something here all the same
    let whole = selection.rejected.first().map_or(&found.best, |(_, with)| with);
    let looks = session.work.goes_on(Phase::UnknownLaw.words());
    let mut map = if looks { residual_law(&session, whole)? } else { None };
    if let Some(map) = &mut map {
        map.evidence -= found.unknown_noise;
    }
    let left = left_over(&session, whole)?;
    let explained = (bare.objective - whole.objective).max(0.0);
    notes.extend(session.work.note());
    outline.begin(Phase::Report);
    let mut diagnosis = verdict::conclude(&verdict::Findings {
        session: &session,
        stated: &stated,
        best: &found.best,
        adopted: &found.adopted,
        unfitted: &found.unfitted,
        screening: &found.screening,
        noise_p,
        map: map.as_ref(),
        one_parameter_law: one_parameter_law.as_ref(),
        left,
        explained,
        selection,
        repeat,
        notes,
        alpha: options.alpha,
        next_experiment: options.next_experiment,
    });
    if session.work.is_stopped() && diagnosis.effects.is_empty() {
        diagnosis.reason = format!("the search was interrupted; so far: {}", diagnosis.reason);
        diagnosis.verdict = Verdict::CannotDecide;
    }
    Ok(diagnosis)
}

/// The effects that the search accepts and what held-out recordings say of them; where it accepts
/// none, those of low significance that held-out recordings confirm.
fn found_and_tested(
    problem: &Problem,
    (session, stated, bare): (&EstimationSession<'_>, &Fit, &FittedModel),
    (options, outline): (&Options, &mut Outline<'_>),
    notes: &mut Vec<String>,
) -> Result<(SearchResult, HeldOutSelection), String> {
    let begun = session.work.spent();
    let mut found = searched(session, (bare.clone(), Rc::default()), options, outline)?;
    let search = session.work.spent() - begun;
    outline.begin(Phase::HeldOut);
    let selection = select_on_held_out(problem, (session, stated), &mut found, options, notes);
    let is_open = found.adopted.is_empty() && found.unfitted.is_empty() && options.held_out.is_some();
    if is_open && session.work.allows(search, "effects of low significance") {
        outline.begin(Phase::LowSignificance);
        let confirmed = outline.within(|outline| {
            suspicion::confirmed(problem, (session, stated), (bare, &found), (options, outline), notes)
        });
        return Ok(confirmed.unwrap_or((found, selection)));
    }
    Ok((found, selection))
}

/// The law that the accepted plant still lacks.
fn residual_law(session: &EstimationSession<'_>, best: &FittedModel) -> Result<Option<UnknownLaw>, String> {
    let own = EstimationSession::like(session, &best.problem).map_err(|error| error.to_string())?;
    Ok(unknown_law::best(&own, &best.plant, &best.fit.linearised, &best.fit.theta, &best.noise))
}

/// Where the innovations of a plant deviate most from normal white noise.
#[derive(Default)]
struct ResidualTests {
    strongest_bin: Option<StrongestBin>,
    outliers: Vec<Outliers>,
    /// The strongest time–frequency bin once outliers are clipped.
    beside: Option<StrongestBin>,
}

/// Deviations from white noise of the innovations of the accepted plant.
fn left_over(session: &EstimationSession<'_>, best: &FittedModel) -> Result<ResidualTests, String> {
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
        Some(ResidualTests { strongest_bin: strongest_bin(&own, &r), outliers, beside })
    };
    Ok(left().unwrap_or_default())
}

/// The nominal plant under adapted noise: noise maximised, parameters fitted under it, noise
/// maximised again.
fn standing(session: &EstimationSession<'_>, stated: &Fit) -> Result<FittedModel, String> {
    let search = Search { sweeps: 8, colour: true, scan: true };
    let failed = || "the likelihood of the noise cannot be found".to_owned();
    let plant = &stated.plant;
    let (noise, _) =
        maximise(session, &stated.linearised, &stated.theta, &[], &session.noise, search).ok_or_else(failed)?;
    let adapted = fit(session, plant, &stated.theta, &noise, NOMINAL_ROUNDS).map_err(|error| error.to_string())?;
    let search = Search { scan: false, ..search };
    let (noise, objective) =
        maximise(session, &adapted.linearised, &adapted.theta, &[], &noise, search).ok_or_else(failed)?;
    Ok(FittedModel::new(session.problem.clone(), adapted, noise, objective))
}

/// Status of all adopted effects together.
fn status(gain: Option<&Gain>) -> Status {
    gain.map_or(Status::Unconfirmed, Gain::status)
}

#[cfg(test)]
mod tests;
