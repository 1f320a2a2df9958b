//! From evidence to the verdict, its sentences and its numbers.

mod noise;
mod residual;
mod rows;

pub(super) use noise::noise_p;
pub(crate) use residual::{bin_location, located};

use super::evidence::locate;
use super::figures::figures;
use super::held_out_selection::HeldOutSelection;
use super::next::{Next, next};
use super::repeat::Repeat;
use super::report::{Diagnosis, HeldOutKind, Verdict};
use super::screening::Screening;
use super::{ALPHA_SHARE_UNIDENTIFIED, Adopted, ResidualTests, Unfitted, status};
use crate::compete::FittedModel;
use crate::omnibus::StrongestBin;
use crate::score::Score;
use crate::unknown_law::{Acts, UnknownLaw};
use dynamics::description::SiteKind;
use examination::doctor::probability as chance;
use identification::fit::{EstimationSession, Fit, NOT_FOUND_RATIO};
use identification::held_out::{Gain, Status};
use noise::{changed_noise, share_explained};
use residual::{bin_in_words, has_lone_outliers, not_named, outlying, residual_law, significant_bin};
use rows::{augmented, effect, held_out, limits, nominal, prior_conflicts, tried, unfitted, without_names};

pub(super) struct Findings<'a> {
    pub session: &'a EstimationSession<'a>,
    pub stated: &'a Fit,
    pub best: &'a FittedModel,
    pub adopted: &'a [Adopted],
    pub unfitted: &'a [Unfitted],
    pub screening: &'a Screening,
    pub noise_p: f64,
    pub map: Option<&'a UnknownLaw>,
    /// A one-parameter law that BIC prefers to the adopted effects.
    pub one_parameter_law: Option<&'a UnknownLaw>,
    pub left: ResidualTests,
    /// Decrease of `−2 ln p` by all adopted effects.
    pub explained: f64,
    pub selection: HeldOutSelection,
    /// Result of the repeat, where there is one.
    pub repeat: Option<Repeat>,
    pub notes: Vec<String>,
    pub alpha: f64,
    /// What is not decided gets an experiment that would decide it.
    pub next_experiment: bool,
}

impl Findings<'_> {
    /// The plant that holds an effect of this status.
    fn with(&self, status: Status) -> &FittedModel {
        if status == Status::Confirmed { &self.selection.model } else { self.best }
    }
}

/// Posterior weight below which an effect is reported as not separable from its rivals. Chosen, no
/// derivation.
const SEPARABLE_WEIGHT_MIN: f64 = 0.9;

pub(super) fn conclude(findings: &Findings<'_>) -> Diagnosis {
    let mut diagnosis = Diagnosis::cannot_decide(String::new());
    let session = findings.session;
    diagnosis.compare.channels.clone_from(&findings.selection.evidence.compare);
    diagnosis.notes.clone_from(&findings.notes);
    let selection = findings.adopted.iter().zip(&findings.selection.status);
    diagnosis.effects = selection.map(|(own, status)| effect(session, findings.with(*status), own, *status)).collect();
    let rejected = findings.selection.rejected.iter();
    diagnosis.effects.extend(rejected.map(|(own, with)| effect(session, with, own, Status::Rejected)));
    diagnosis.nominal = nominal(findings);
    diagnosis.detection_limits = limits(findings);
    diagnosis.tried = tried(findings);
    diagnosis.not_found = (session.problem.unknowns.iter().zip(&findings.stated.ratio))
        .filter(|(_, ratio)| **ratio > NOT_FOUND_RATIO)
        .map(|(unknown, _)| unknown.name.clone())
        .collect();
    diagnosis.effects.extend(findings.unfitted.iter().map(|lost| unfitted(findings, lost)));
    held_out(findings, &mut diagnosis);
    let stated = findings.stated.clone();
    let before = FittedModel::new(session.problem.clone(), stated, session.noise.clone(), 0.0);
    if let Some(first) = findings.adopted.first() {
        diagnosis.located.extend(locate(session, &before, &first.column, &first.score, first.p));
    }
    diagnosis.located.extend(significant_bin(findings).map(|bin| bin_location(session, bin)));
    (diagnosis.verdict, diagnosis.reason) = verdict(findings);
    let unknown = overriding_law(findings);
    if unknown.is_none() {
        diagnosis.reason.push_str(&prior_conflicts(findings));
    }
    let as_stated = (&findings.stated.linearised, &session.noise);
    let (best, adopted) = (findings.best, findings.adopted);
    diagnosis.figures = figures(session, as_stated, best, adopted, findings.screening, unknown);
    diagnosis.figures.overlays.clone_from(&findings.selection.evidence.overlays);
    if let Some(map) = unknown {
        diagnosis.located.push(located(session, map, findings.alpha));
        without_names(findings, map, &mut diagnosis);
    }
    if unknown.is_none() {
        diagnosis.augmented_plant = augmented(findings);
        let next = findings.next_experiment.then(|| next(session, findings.best, findings.adopted));
        match next.unwrap_or(Next::NothingOpen) {
            Next::NothingOpen => {}
            Next::Scenario(text) => diagnosis.next_experiment = Some(text),
            Next::Never(why) => diagnosis.notes.push(why),
        }
    }
    diagnosis
}

/// Least share that effects must explain to be accepted: of all that was explained including the
/// map, and of the misfit while no noise (where held-out data confirm them, no disturbance) has a
/// higher variance than stated. Chosen on seeded cases, no derivation.
const EXPLAINED_SHARE_MIN: f64 = 0.75;

/// A significant map beside effects that explain too little to be accepted. An error of a reading
/// over itself, or over time, approximates any law that moves the reading: it is taken only where
/// no effect is adopted, or no other recording has tested the effects.
fn overriding_law<'f>(findings: &Findings<'f>) -> Option<&'f UnknownLaw> {
    let Some(map) = residual_law(findings) else { return parsimonious_law(findings) };
    if findings.adopted.is_empty() {
        return Some(map);
    }
    let is_force = matches!(map.place.acts, Acts::Force(_)) && !map.place.is_of_time();
    let may = is_force || findings.selection.evidence.kind != HeldOutKind::Recording;
    let outweighs = may && findings.explained < EXPLAINED_SHARE_MIN * (findings.explained + map.evidence);
    if outweighs { Some(map) } else { parsimonious_law(findings) }
}

/// The one-parameter law that BIC prefers to the effects and that predicts parts it was not fitted
/// to, where the effects would be accepted otherwise.
fn parsimonious_law<'f>(findings: &Findings<'f>) -> Option<&'f UnknownLaw> {
    let one_parameter_law = findings.one_parameter_law.filter(|law| law.held_out.status() == Status::Confirmed)?;
    let is_significant = matches!(named(findings).0, Verdict::Named | Verdict::NotSeparable | Verdict::Sensor);
    is_significant.then_some(one_parameter_law)
}

fn verdict(findings: &Findings<'_>) -> (Verdict, String) {
    overriding_law(findings).map_or_else(|| named(findings), not_named)
}

/// Verdict on the adopted effects.
fn named(findings: &Findings<'_>) -> (Verdict, String) {
    let Some(first) = findings.adopted.first() else { return nothing_named(findings) };
    let kinds: Vec<String> = findings
        .adopted
        .iter()
        .map(|a| format!("{} at {}", a.column.candidate.effect.kind, a.column.candidate.site))
        .collect();
    let kinds = kinds.join(" and ");
    if let Some(reason) = contradicted(findings, &kinds).or_else(|| explains_too_little(findings, &kinds)) {
        return (Verdict::CannotDecide, reason);
    }
    let weight = findings.adopted.iter().map(|a| a.weight).fold(1.0, f64::min);
    let state = status(findings.selection.evidence.gain.as_ref());
    let word = if state == Status::Confirmed { "confirmed" } else { "not yet confirmed" };
    let runs_away = findings.selection.evidence.gain.filter(Gain::free_run_diverges).map_or(String::new(), |gain| {
        format!(", by single steps: in free run {:.1} times as far from them as the plant alone", gain.free_run)
    });
    let open = findings.adopted.iter().zip(&findings.selection.status).filter(|(_, own)| **own != state);
    let open: Vec<&str> = open.map(|(adopted, _)| adopted.column.candidate.effect.kind).collect();
    let but = if open.is_empty() { String::new() } else { format!(" without {}", open.join(" and ")) };
    let left = residual_law(findings).map_or(String::new(), |map| {
        format!("; a smaller unmodelled law remains at {} (evidence {:.0})", map.place.site, map.evidence)
    });
    let again = findings.repeat.map_or(String::new(), |repeat| {
        format!("; the repeat shows it too (z = {:.1}, expected {:.1})", repeat.z, repeat.expected)
    });
    let reason = format!(
        "{kinds} (probability {weight:.2}, {word} on held-out data{but}{runs_away}; {} after correction for all hypotheses){again}{left}",
        chance(first.p)
    );
    if weight < SEPARABLE_WEIGHT_MIN {
        return (Verdict::NotSeparable, reason);
    }
    let sensor = findings.adopted.iter().all(|a| a.column.candidate.site.kind == SiteKind::Sensor);
    (if sensor { Verdict::Sensor } else { Verdict::Named }, reason)
}

/// Held-out data reject the effects, or a repeat does not show them.
fn contradicted(findings: &Findings<'_>, kinds: &str) -> Option<String> {
    let gain = findings.selection.evidence.gain;
    if status(gain.as_ref()) == Status::Rejected {
        let so = gain.filter(|gain| gain.interval95()[1] >= 0.0).map_or(String::new(), |gain| {
            let (own, se, predicted) = (gain.loglik_gain, gain.gain_se, gain.expected);
            format!(": the gain on them is {own:.1} ± {se:.1} where {predicted:.1} is predicted")
        });
        return Some(format!("{kinds} explained this recording, but held-out data reject it{so}"));
    }
    findings.repeat.filter(|repeat| !repeat.confirms()).map(|repeat| {
        format!(
            "{kinds} explained this recording, but the repeat does not show it: z = {:.1} where {:.1} was expected{}",
            repeat.z,
            repeat.expected,
            if repeat.lacks_power() { "; the repeat is too short or excites too little to decide" } else { "" }
        )
    })
}

/// The effects leave too much of the misfit. Confirmed ones may leave readings of higher variance
/// than stated; a force of unspecified variance is a missing part, unless the whole recurs in a
/// repeat.
fn explains_too_little(findings: &Findings<'_>, kinds: &str) -> Option<String> {
    let is_sure = status(findings.selection.evidence.gain.as_ref()) == Status::Confirmed;
    let repeats = findings.repeat.is_some();
    let share = if repeats { 1.0 } else { share_explained(findings, is_sure).unwrap_or(0.0) };
    let (noise, but) = if is_sure {
        ("disturbances", "held-out data confirm that much")
    } else {
        ("noise", "held-out data do not confirm them")
    };
    let largest = || {
        significant_bin(findings).map_or(String::new(), |bin| format!(" (largest: {})", bin_in_words(findings, bin)))
    };
    (share < EXPLAINED_SHARE_MIN).then(|| {
        format!(
            "{kinds} explain {:.0} % of the misfit under {noise} of the stated variance, and {but}; the rest is an unknown law or an unknown \
             disturbance: repeat the experiment; a residual that recurs at the same states is deterministic, not noise{}",
            100.0 * share.max(0.0),
            largest()
        )
    })
}

fn nothing_named(findings: &Findings<'_>) -> (Verdict, String) {
    if let Some(lost) = findings.unfitted.first() {
        let candidate = &lost.column.candidate;
        let reason = format!(
            "{} at {} is significant ({}), but no model with it could be fitted",
            candidate.effect.kind,
            candidate.site,
            chance(lost.p)
        );
        return (Verdict::CannotDecide, reason);
    }
    let is_noise = findings.noise_p < ALPHA_SHARE_UNIDENTIFIED * findings.alpha;
    if has_lone_outliers(findings) {
        let beside = if is_noise { format!("{}; ", changed_noise(findings)) } else { String::new() };
        let reason = format!(
            "the noise is not as stated ({}): {beside}isolated outliers of the readings, or impacts: {}; no physics is missing beside them",
            chance(significant_bin(findings).map_or(1.0, StrongestBin::p).min(findings.noise_p)),
            outlying(findings)
        );
        return (Verdict::NoiseModel, reason);
    }
    if let Some(bin) = significant_bin(findings) {
        let beside = if is_noise { format!("beside {} ", changed_noise(findings)) } else { String::new() };
        let reason = format!(
            "the recording is not as the plant predicts ({}), and no noise explains it either: {beside}most residual energy is left in {}; \
             an unknown law or a disturbance: repeat the experiment; a residual that recurs at the same states is deterministic, not noise",
            chance(findings.noise_p.min(bin.p())),
            bin_in_words(findings, bin)
        );
        return (Verdict::CannotDecide, reason);
    }
    if is_noise {
        let noise = changed_noise(findings);
        let reason = format!(
            "the noise is not as stated ({}): {noise}; no physics is missing beside it",
            chance(findings.noise_p)
        );
        return (Verdict::NoiseModel, reason);
    }
    if !observable(findings) {
        let reason =
            "no effect of the catalogue would show here at the size that is usual for it: excite more, or measure more";
        return (Verdict::Unobservable, reason.to_owned());
    }
    (Verdict::None, "nothing is missing that this recording could show; see the detection limits".to_owned())
}

/// Some effect of the catalogue would be detectable at its usual size.
fn observable(findings: &Findings<'_>) -> bool {
    let columns = &findings.screening.columns;
    let usual = |score: &Score| columns[score.column].candidate.effect.parameters[0].default.abs();
    findings.screening.scores.iter().any(|score| usual(score) > score.limit)
}
