//! A plant and its recordings as one estimation problem: what drives, what is measured, what is
//! unknown.
//!
//! Every number of the plant that has a prior standard deviation is an unknown of its scope: one
//! for all recordings, one a recording, one a segment. Initial states are no unknowns here: the
//! filter takes them with a wide prior. What does not match (a channel's name, its unit) is an
//! error that names the nearest word.
//!
//! Inputs of a recording are held commands, prescribed motions (a smoothing spline, broken at
//! kinks, so that rate and acceleration belong to them), the plant's own signals where nothing was
//! recorded, or nothing.

mod angles;
mod driven;
mod gaps;
mod inputs;
mod mapping;
mod matching;
mod smooth;
mod standstill;
mod timeline;
mod unknown;

pub use driven::{Driven, driven};
pub use inputs::{Course, Drive};
pub use mapping::{Mapping, apply_map};
pub use smooth::SmoothMotion;
pub use standstill::{period_s, sample_sigma, standstill};
pub use timeline::{Event, Timeline};
pub use unknown::Unknown;
pub(crate) use unknown::{is_start, unknowns};

use channels::Recording;
use dynamics::description::{Initial, Plant};

/// Why a plant and a recording do not belong together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProblemError {
    #[error("recording '{recording}' has no channel '{channel}', which the plant calls {what}{}", nearest.as_ref().map(|n| format!("; did you mean '{n}'? A map can join the two names")).unwrap_or_default())]
    MissingChannel { recording: String, channel: String, what: &'static str, nearest: Option<String> },
    #[error("channel '{channel}' of recording '{recording}' is in {got}, the plant's is in {expected}")]
    Unit { recording: String, channel: String, got: String, expected: String },
    #[error(
        "channel '{channel}' of recording '{recording}' has no two samples in order between {begin_s} s and {end_s} s"
    )]
    Empty { recording: String, channel: String, begin_s: f64, end_s: f64 },
    #[error(
        "what '{actuator}' did is not recorded, and the plant states no signal of its own for it: record its command, or, where it is unknown, state `recorded = false` and a signal with unknown numbers"
    )]
    UnknownInput { actuator: String },
    #[error("there is no recording")]
    NoRecording,
    #[error("the plant cannot be compiled: {0}")]
    Plant(String),
    #[error("channel '{0}' has no noise: state what its data sheet says")]
    NoNoise(String),
}

/// Samples of one sensor in one run.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    /// By the channel's own clock.
    pub time_s: Vec<f64>,
    pub value: Vec<f64>,
}

/// One stretch of one recording with its own initial state.
#[derive(Clone, Debug)]
pub struct Run {
    pub recording: usize,
    pub segment: Option<usize>,
    pub begin_s: f64,
    pub end_s: f64,
    pub initial: Initial,
    /// Per actuator of the plant.
    pub drives: Vec<Drive>,
    /// Per sensor of the plant; empty where the recording does not hold it.
    pub samples: Vec<Samples>,
    /// Begins where another run was cut: what the plant states of a start is not about this one.
    pub is_rest: bool,
}

impl Run {
    /// The samples in `[begin_s, end_s]`; what `is_rest` begins at an unspecified state.
    fn part(&self, [begin_s, end_s]: [f64; 2], is_rest: bool) -> Self {
        let mut part = Self { begin_s, end_s, is_rest: is_rest || self.is_rest, ..self.clone() };
        part.keep(|t| (begin_s..=end_s).contains(&t));
        if is_rest {
            part.initial.values.iter_mut().for_each(|value| {
                (value.position.sigma, value.rate.sigma) = (None, None);
            });
        }
        part
    }

    fn before(mut self, end_s: f64) -> Self {
        self.keep(|t| t < end_s);
        self
    }

    fn keep(&mut self, keep: impl Fn(f64) -> bool) {
        for samples in &mut self.samples {
            let kept: Vec<usize> = (0..samples.time_s.len()).filter(|i| keep(samples.time_s[*i])).collect();
            samples.value = kept.iter().map(|i| samples.value[*i]).collect();
            samples.time_s = kept.iter().map(|i| samples.time_s[*i]).collect();
        }
    }
}

/// The problem.
#[derive(Clone, Debug)]
pub struct Problem {
    pub plant: Plant,
    pub recordings: Vec<String>,
    pub runs: Vec<Run>,
    pub unknowns: Vec<Unknown>,
    /// Remarks on what was assumed.
    pub notes: Vec<String>,
}

impl ProblemError {
    /// What the operator can do; `plant_file` is where the plant is written.
    #[must_use]
    pub fn cure(&self, plant_file: &str) -> String {
        match self {
            Self::MissingChannel { channel, nearest, .. } => {
                let theirs = nearest.as_deref().unwrap_or("name in the recording");
                format!("give --map FILE with [channels] {} = \"{theirs}\", or rename one of the two", key(channel))
            }
            Self::Unit { channel, expected, .. } => format!(
                "correct the header, or give --map FILE with [channels] {} = {{ name = \"{channel}\", unit = \"{expected}\" }}",
                key(channel)
            ),
            Self::Empty { .. } => {
                "give a longer recording, or [[segment]]s in the plant file that lie in this one; `obsid doctor` shows its span".into()
            }
            Self::UnknownInput { actuator } => {
                format!("record what '{actuator}' did, or take its controller out of the plant file and state the command")
            }
            Self::NoNoise(channel) => {
                format!("give [[sensor]] '{channel}' its noise in {plant_file}, as its data sheet states it")
            }
            Self::NoRecording | Self::Plant(_) => {
                format!("`obsid plant check {plant_file}` says what the plant itself lacks")
            }
        }
    }
}

/// A name as a key of TOML.
fn key(name: &str) -> String {
    let bare = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-') && !name.is_empty();
    if bare { name.to_owned() } else { format!("\"{name}\"") }
}

impl Problem {
    /// Every reason for which [`Problem::new`] rejects `recording`, names and units first; empty
    /// where it does not.
    #[must_use]
    pub fn refusals(plant: &Plant, recording: &Recording) -> Vec<ProblemError> {
        let unmet = matching::unmet(plant, recording, &[]);
        if unmet.is_empty() {
            return Self::new(plant, core::slice::from_ref(recording), &[]).err().into_iter().collect();
        }
        unmet
    }

    /// Joins `plant` and `recordings`. `map` gives (name in the plant, name in the recording) where
    /// they differ.
    ///
    /// # Errors
    /// See [`ProblemError`].
    pub fn new(plant: &Plant, recordings: &[Recording], map: &[(String, String)]) -> Result<Self, ProblemError> {
        if recordings.is_empty() {
            return Err(ProblemError::NoRecording);
        }
        dynamics::system::System::new(plant).map_err(|error| ProblemError::Plant(error.to_string()))?;
        let mut runs = Vec::new();
        let mut notes = Vec::new();
        for (index, recording) in recordings.iter().enumerate() {
            runs.extend(matching::runs(plant, recording, index, map, &mut notes)?);
        }
        let unknowns = unknown::unknowns(plant, recordings.len(), &runs);
        let recordings = recordings.iter().map(|recording| recording.name.clone()).collect();
        Ok(Self { plant: plant.clone(), recordings, runs, unknowns, notes })
    }

    /// The same recordings with another plant of the same channels (an augmented one).
    #[must_use]
    pub fn with_plant(&self, plant: &Plant) -> Self {
        let unknowns = unknown::unknowns(plant, self.recordings.len(), &self.runs);
        let mut other = Self { plant: plant.clone(), unknowns, ..self.clone() };
        other
            .runs
            .iter_mut()
            .for_each(|run| run.drives.iter_mut().zip(&plant.actuators).for_each(|(d, a)| d.renew(plant, a)));
        other
    }

    /// The beginnings and the ends of all runs, divided at `share` of their time.
    #[must_use]
    pub fn split(&self, share: f64) -> (Self, Self) {
        let cut = |first: bool| {
            let mut part = self.clone();
            for run in &mut part.runs {
                let at = run.begin_s + share * (run.end_s - run.begin_s);
                let end_s = run.end_s;
                *run = if first { run.part([run.begin_s, at], false).before(at) } else { run.part([at, end_s], true) };
            }
            part
        };
        (cut(true), cut(false))
    }

    /// Total number of measured samples.
    pub fn samples(&self) -> usize {
        self.runs.iter().flat_map(|run| &run.samples).map(|samples| samples.value.len()).sum()
    }

    /// Begin and end of the first recording, over all its runs \[s\].
    pub fn span_s(&self) -> [f64; 2] {
        let first = self
            .runs
            .iter()
            .filter(|run| run.recording == self.runs[0].recording && run.segment == self.runs[0].segment);
        first.fold([f64::INFINITY, f64::NEG_INFINITY], |[b, e], run| [b.min(run.begin_s), e.max(run.end_s)])
    }

    /// Total recorded time \[s\].
    pub fn duration_s(&self) -> f64 {
        self.runs.iter().map(|run| run.end_s - run.begin_s).sum()
    }

    /// `plant` with the numbers that `theta` gives the unknowns, as run `run` sees them.
    pub fn instance(&self, plant: &Plant, theta: &[f64], run: usize) -> Plant {
        let run = &self.runs[run];
        let mut values: Vec<(&str, f64)> = Vec::with_capacity(theta.len());
        for (unknown, value) in self.unknowns.iter().zip(theta) {
            if unknown.concerns(run) {
                values.push((&unknown.parameter, *value));
            }
        }
        values.sort_by(|a, b| a.0.cmp(b.0));
        let mut plant = plant.clone();
        plant.visit_quantities(&mut |name, _, quantity| {
            if let Ok(at) = values.binary_search_by(|(known, _)| (*known).cmp(name)) {
                quantity.value = values[at].1;
            }
        });
        plant
    }
}

#[cfg(test)]
mod tests;
