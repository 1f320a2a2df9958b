//! A diagnosis: what is asked, what is answered, and the parts that a decision needs beside its
//! search (extent of a recording, even stamps, held-out predictions, figures, next experiment).
//!
//! The decision itself is [`crate::evidence`].

mod extent;
mod figures;
mod fitted_model;
mod held_out_evidence;
mod insufficient_data;
mod next;
mod phase;
mod place;
mod report;
mod stamps;

pub(crate) use extent::{nominal, within_limit};
pub(crate) use figures::{curve, state_map, tiles};
pub(crate) use fitted_model::FittedModel;
pub(crate) use held_out_evidence::{HeldOutEvidence, held_out};
pub(crate) use insufficient_data::insufficient_data;
pub(crate) use next::{Next, separating};
pub use phase::Phase;
pub(crate) use place::{bin_location, located, place_of, whiteness_p};
pub(crate) use report::kept;
pub use report::{
    Angles, Compare, DetectionLimit, Diagnosis, EffectEvidence, EffectReport, EvidenceCurve, ExtraParameterBound,
    Figures, HeldOut, HeldOutChannel, HeldOutKind, InputTiming, LabelReport, LawCell, LawMap, Nominal, OpenHypothesis,
    Overlay, ParameterReport, Rival, Tile, Tried, Verdict, Where,
};
pub(crate) use stamps::even_stamps;

use identification::problem::Problem;
use identification::work::{NORMAL_WORK, QUICK_WORK, Watch};

/// What a diagnosis is asked for, and its bounds.
#[derive(Clone, Debug)]
pub struct Options {
    pub threads: usize,
    /// Effects that the catalogue is taken without.
    pub without: Vec<String>,
    /// Recordings to predict at the end, as a problem of the same plant.
    pub held_out: Option<Problem>,
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
            threads: 1,
            without: Vec::new(),
            held_out: None,
            work_max: NORMAL_WORK,
            fit_work_min: QUICK_WORK,
            refused_at: None,
            worth: 0.0,
            next_experiment: true,
            watch: Watch::default(),
        }
    }
}
