//! The diagnosis as data; field names are those of its JSON.

use crate::mislabelled::Mislabelled;
use crate::score::Candidate;
use dynamics::description::{EffectUse, Plant};
use dynamics::effect::Role;
use identification::held_out::{ChannelFit, Status};
use serde::Serialize;

/// Conclusion of a diagnosis, in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing is missing that the recording could show.
    None,
    /// Effects of the catalogue are identified.
    Named,
    /// Effects are significant, but rivals explain the recording nearly as well.
    NotSeparable,
    /// A law is missing that the catalogue does not contain.
    NotInCatalogue,
    /// The noise is not as stated; no physics is missing.
    NoiseModel,
    /// A number of the plant lies beyond what its file allows (evidence alone decides so).
    ParameterConflict,
    /// Recorded inputs act earlier or later than their stamps (evidence alone decides so).
    InputTiming,
    /// Only errors of sensors are missing, or the channel metadata is wrong.
    Sensor,
    /// The data do not decide, for the reason given.
    CannotDecide,
}

/// Free run of the nominal plant against the fitted recording, by channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compare {
    pub channels: Vec<ChannelFit>,
}

/// Where the evidence lies.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Where {
    pub channel: String,
    pub site: String,
    /// [s, s]
    pub time: [f64; 2],
    pub band_hz: [f64; 2],
    pub states: Vec<String>,
    pub p: f64,
}

/// An effect that could replace a reported one, with its posterior probability in [0, 1].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rival {
    pub kind: String,
    pub site: String,
    pub probability: f64,
    pub reason: String,
}

/// An estimated parameter with its standard deviation, both in `unit`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterReport {
    pub name: String,
    pub value: f64,
    pub sigma: f64,
    pub unit: String,
    /// The value is the least or the largest that the law may have: the truth may lie beyond, and
    /// the law may stand for another one. Absent where it is neither.
    #[serde(skip_serializing_if = "is_inside")]
    pub at_bound: bool,
}

impl ParameterReport {
    /// Of a value inside its range.
    pub fn inside(name: String, (value, sigma): (f64, f64), unit: String) -> Self {
        Self { name, value, sigma, unit, at_bound: false }
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
const fn is_inside(at_bound: &bool) -> bool {
    !*at_bound
}

/// A reported effect: its probability in [0, 1], its status on held-out data, its rivals and
/// parameters, the share `kappa` of its energy that the plant's parameters absorb, and its
/// significance `d` in standard errors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectReport {
    pub kind: String,
    /// In words, of its entry in the catalogue.
    pub title: String,
    pub site: String,
    pub probability: f64,
    pub status: Status,
    pub rivals: Vec<Rival>,
    pub parameters: Vec<ParameterReport>,
    /// Values at which the law was fitted and that were not estimated, by name: with the
    /// catalogue's defaults instead it is another law.
    #[serde(skip)]
    pub kept: Vec<(String, f64)>,
    pub kappa: f64,
    pub d: f64,
    /// What a decision by evidence adds.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<EffectEvidence>,
}

/// Of an effect that was decided by evidence: nats of its set ahead of the plant alone, share of
/// the free run's misfit on held-out data that the set takes away by channel [%], family, and the
/// sites of a law at all like ones.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectEvidence {
    pub log_evidence: f64,
    pub free_run_share_percent: Vec<f64>,
    pub family: String,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub group: Vec<String>,
    /// Of larger laws that hold this one as a limit.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub extra_parameter_bound: Vec<ExtraParameterBound>,
}

/// The range of two standard deviations of a parameter that the law `kind` has beside those of the
/// named one, and the value at which both are the same law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExtraParameterBound {
    pub kind: String,
    pub parameter: String,
    pub low: f64,
    pub high: f64,
    pub same_at: f64,
    pub unit: String,
}

/// A shift of the recorded inputs, in samples of their own: half of one earlier is linear between
/// stamps; and the weight of all models with a shift.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct InputTiming {
    pub shift_samples: f64,
    pub probability: f64,
}

/// A label of a channel that was in doubt: what it would be wrong by, the probability of that where
/// it was decided by evidence, and whether it was corrected.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LabelReport {
    pub recording: String,
    pub channels: Vec<String>,
    pub mistake: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probability: Option<f64>,
    pub corrected: bool,
}

/// A hypothesis that has no probability, and why; of several together the kind is `set`, the site
/// is empty, and the members say which.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OpenHypothesis {
    pub kind: String,
    pub site: String,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub members: Vec<String>,
    pub why: String,
}

/// A parameter of the plant before and after the diagnosis, in its own unit; the shift in standard
/// deviations.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Nominal {
    pub name: String,
    pub before: f64,
    pub after: f64,
    pub sigma: f64,
    pub shift_sigma: f64,
}

/// Source of the held-out data: another recording, blocks of the same one, or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HeldOutKind {
    /// Another recording.
    Recording,
    /// Blocks of the fitted recording, each predicted from the others.
    Blocks,
    /// No held-out data.
    None,
}

/// Free-run fit of one channel on held-out data, without and with the effects
/// [%, unit of the channel].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldOutChannel {
    pub name: String,
    pub fit_percent_before: f64,
    pub fit_percent_after: f64,
    pub rms_before: f64,
    pub rms_after: f64,
}

/// Prediction of held-out data without and with the effects: gain in log-likelihood with its
/// standard error and 95 % interval, p values of whiteness.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldOut {
    pub kind: HeldOutKind,
    pub channels: Vec<HeldOutChannel>,
    pub loglik_gain: Option<f64>,
    pub gain_se: Option<f64>,
    pub gain_ci95: Option<[f64; 2]>,
    pub whiteness_p_before: Option<f64>,
    pub whiteness_p_after: Option<f64>,
}

/// Smallest amplitude of an effect that the recording would show at six standard errors, in `unit`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DetectionLimit {
    pub kind: String,
    pub site: String,
    pub amplitude: f64,
    pub unit: String,
}

/// A time–frequency bin: whitened innovations of one channel in one window and octave, deviation of
/// their power from one in standard errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    pub channel: String,
    pub time: [f64; 2],
    pub band_hz: [f64; 2],
    pub z_before: f64,
    pub z_after: f64,
}

/// Gain in log-likelihood that one effect has collected up to each instant.
#[derive(Clone, Debug, PartialEq)]
pub struct EvidenceCurve {
    pub kind: String,
    pub site: String,
    pub time_s: Vec<f64>,
    pub gain: Vec<f64>,
}

/// A law over two coordinates, or over `x` alone: the data in each cell and the fitted law there.
#[derive(Clone, Debug, PartialEq)]
pub struct LawMap {
    /// What it is and where, and its unit.
    pub quantity: String,
    pub unit: String,
    /// Name and unit of each coordinate.
    pub x: (String, String),
    pub y: (String, String),
    pub cells: Vec<LawCell>,
}

/// One cell of a [`LawMap`]: coordinates, value with its standard error, and the fitted law at that
/// place.
#[derive(Clone, Debug, PartialEq)]
pub struct LawCell {
    pub x: f64,
    pub y: f64,
    pub value: f64,
    pub sigma: f64,
}

/// Cosines between the best candidates once the nominal unknowns are projected off.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Angles {
    pub names: Vec<String>,
    pub cosine: Vec<Vec<f64>>,
}

/// One channel of held-out data with the free runs of both plants.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    pub channel: String,
    pub unit: String,
    pub time_s: Vec<f64>,
    pub measured: Vec<f64>,
    pub before: Vec<f64>,
    pub after: Vec<f64>,
}

/// Data of the figures; not part of the JSON.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures {
    pub tiles: Vec<Tile>,
    pub evidence: Vec<EvidenceCurve>,
    pub law_maps: Vec<LawMap>,
    pub angles: Angles,
    pub overlays: Vec<Overlay>,
}

/// A law that was tested.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    pub kind: String,
    pub site: String,
    /// Number of laws times the points of its own grid: the factor on its p value before collinear
    /// laws are counted once.
    pub chances: f64,
}

/// All findings of a diagnosis. The checks of the recordings themselves come from
/// [`examination::doctor`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Diagnosis {
    pub verdict: Verdict,
    pub reason: String,
    pub compare: Compare,
    #[serde(rename = "where")]
    pub located: Vec<Where>,
    pub effects: Vec<EffectReport>,
    pub nominal: Vec<Nominal>,
    pub held_out: HeldOut,
    pub detection_limits: Vec<DetectionLimit>,
    /// Unknowns that keep their prior.
    pub not_found: Vec<String>,
    pub notes: Vec<String>,
    pub next_experiment: Option<String>,
    /// Text of the plant file with the confirmed effects (a caller that writes it puts the path
    /// here).
    pub augmented_plant: Option<String>,
    pub report: Option<String>,
    /// Largest share of the free run's misfit on held-out data that the effects take away [%];
    /// of a decision by evidence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relevance_percent: Option<f64>,
    /// Hypotheses without a probability; of a decision by evidence.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub open: Vec<OpenHypothesis>,
    /// Where the leading model has the recorded inputs at another time.
    pub input_timing: Vec<InputTiming>,
    /// Channel metadata that was in doubt.
    pub labels: Vec<LabelReport>,
    /// Nats of the leading model with those of the recordings that it was not fitted to, and how
    /// many readings that counts; of a decision by evidence.
    #[serde(skip)]
    pub total_evidence: Option<(f64, usize)>,
    #[serde(skip)]
    pub figures: Figures,
    #[serde(skip)]
    pub tried: Vec<Tried>,
}

impl HeldOut {
    /// No held-out data were evaluated.
    pub fn none() -> Self {
        Self {
            kind: HeldOutKind::None,
            channels: Vec::new(),
            loglik_gain: None,
            gain_se: None,
            gain_ci95: None,
            whiteness_p_before: None,
            whiteness_p_after: None,
        }
    }
}

impl Diagnosis {
    /// The diagnosis of recordings whose `mislabelled` channels were corrected first: the mistake
    /// comes first in the reason. The verdict is [`Verdict::Sensor`] where nothing else is missing.
    #[must_use]
    pub fn of_mislabelled(mut self, mislabelled: &[Mislabelled]) -> Self {
        if mislabelled.is_empty() {
            return self;
        }
        if self.labels.is_empty() {
            self.labels = mislabelled.iter().map(|label| label.report(None, true)).collect();
        }
        let mut kinds: Vec<(&Mislabelled, Vec<&str>)> = Vec::new();
        for label in mislabelled {
            let known = kinds.iter_mut().find(|(known, _)| known.is_like(label));
            match known {
                Some((_, files)) => files.push(&label.recording),
                None => kinds.push((label, vec![&label.recording])),
            }
        }
        let reported = kinds.iter().map(|(label, files)| format!("in {} {}", files.join(", "), label.in_words()));
        let reported = reported.collect::<Vec<_>>().join(", and ");
        self.notes.push(format!("{reported}: corrected before the diagnosis; correct the header or the map"));
        self.reason = match self.verdict {
            Verdict::None => format!("{reported}; with that corrected: nothing else is missing; {}", self.reason),
            _ => format!("{reported}; with that corrected: {}", self.reason),
        };
        if self.verdict == Verdict::None {
            self.verdict = Verdict::Sensor;
        }
        self
    }

    /// A diagnosis without findings, because of `reason`.
    pub fn cannot_decide(reason: String) -> Self {
        Self {
            verdict: Verdict::CannotDecide,
            reason,
            compare: Compare { channels: Vec::new() },
            located: Vec::new(),
            effects: Vec::new(),
            nominal: Vec::new(),
            held_out: HeldOut::none(),
            detection_limits: Vec::new(),
            not_found: Vec::new(),
            notes: Vec::new(),
            next_experiment: None,
            augmented_plant: None,
            report: None,
            relevance_percent: None,
            open: Vec::new(),
            input_timing: Vec::new(),
            labels: Vec::new(),
            total_evidence: None,
            figures: Figures::default(),
            tried: Vec::new(),
        }
    }
}

/// Parameters that the fit of the effect of `candidate` kept, and their values; times apart.
pub(crate) fn kept(plant: &Plant, candidate: &Candidate) -> Vec<(String, f64)> {
    let of = |used: &&EffectUse| used.kind == candidate.effect.kind && used.site == candidate.site;
    let values = plant.effects.iter().filter(of).flat_map(|used| &used.values);
    let is_time =
        |name: &str| candidate.effect.parameter(name).is_some_and(|p| matches!(p.role, Role::Onset | Role::Duration));
    let kept = values.filter(|(name, quantity)| quantity.sigma.is_none() && !is_time(name));
    kept.map(|(name, quantity)| (name.clone(), quantity.value)).collect()
}
