//! From evidence to the verdict, its sentences and its numbers.

use super::evidence::{locate, whiteness_p};
use super::figures::figures;
use super::held_out_selection::HeldOutSelection;
use super::next::{Next, next, posterior};
use super::repeat::Repeat;
use super::report::*;
use super::screening::Screening;
use super::{ALPHA_SHARE_UNIDENTIFIED, Adopted, ResidualTests, Unfitted, status};
use crate::compete::{FittedModel, Multiplicity, onset_estimates};
use crate::omnibus::{Outliers, StrongestBin};
use crate::score::{Candidate, Score};
use crate::unknown_law::{Acts, UnknownLaw};
use dynamics::description::{EffectUse, SiteKind};
use dynamics::effect::Role;
use examination::doctor::{probability as chance, short};
use identification::filter::NoiseModel;
use identification::fit::{EstimationSession, Fit, NOT_FOUND_RATIO};
use identification::held_out::{Gain, Status};
use identification::statistics::chi_squared_tail;

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

/// The stated noise; disturbances of unspecified size count only upwards.
fn as_stated(session: &EstimationSession<'_>, found: &NoiseModel) -> NoiseModel {
    let mut stated = session.noise.clone();
    for ((own, found), actuator) in stated.input_sigma.iter_mut().zip(&found.input_sigma).zip(&session.noise_names) {
        let known = session.problem.plant.actuator(actuator).is_some_and(|a| a.noise.value > 0.0);
        if !known && *found < *own {
            *own = *found;
        }
    }
    stated
}

/// Least `−2 ln p` of `fit` under `noise`, its parameters free.
fn least(session: &EstimationSession<'_>, fit: &Fit, noise: &NoiseModel) -> Option<f64> {
    Some(fit.linearised.normal(session, &fit.theta, noise, &[])?.minimum()?.0)
}

/// p value of the stated against the adapted noise: χ² tail of the likelihood ratio.
pub(super) fn noise_p(
    session: &EstimationSession<'_>,
    stated: &Fit,
    adapted: &Fit,
    noise: &NoiseModel,
    objective: f64,
) -> f64 {
    let as_stated = as_stated(session, noise);
    let jittering = noise.jitter_s.iter().filter(|jitter| **jitter > 0.0).count();
    let freedom = (noise.input_sigma.len() + 2 * noise.sensor_sigma.len() + jittering) as f64;
    match [stated, adapted].into_iter().filter_map(|fit| least(session, fit, &as_stated)).min_by(f64::total_cmp) {
        Some(before) => chi_squared_tail((before - objective + session.disturbance_price(noise)).max(0.0), freedom),
        None => 0.0,
    }
}

/// Share of the misfit that the adopted effects remove while no disturbance, and unless granted no
/// reading, has a higher variance than stated; the rest of the misfit needed more noise. Lower
/// variances, colour and jitter are granted.
fn share_explained(findings: &Findings<'_>, grants_readings: bool) -> Option<f64> {
    let (session, best) = (findings.session, findings.best);
    let mut noise = best.noise.clone();
    let capped = |found: &mut [f64], stated: &[f64]| found.iter_mut().zip(stated).for_each(|(f, s)| *f = f.min(*s));
    capped(&mut noise.input_sigma, &session.noise.input_sigma);
    if !grants_readings {
        capped(&mut noise.sensor_sigma, &session.noise.sensor_sigma);
    }
    let own = EstimationSession::like(session, &best.problem).ok()?;
    let before = least(session, findings.stated, &noise)?;
    let (after, free) = (least(&own, &best.fit, &noise)?, least(&own, &best.fit, &best.noise)?);
    Some((before - after) / (before - free).max(f64::MIN_POSITIVE))
}

/// Every law of the first screening with the factor on its p value.
fn tried(findings: &Findings<'_>) -> Vec<Tried> {
    let columns = &findings.screening.columns;
    let multiplicity = Multiplicity::new(columns, &|_, _| None);
    let mut list: Vec<Tried> = Vec::new();
    for (c, column) in columns.iter().enumerate() {
        let (kind, site) = (column.candidate.effect.kind, column.candidate.site.to_string());
        if !list.iter().any(|known| known.kind == kind && known.site == site) {
            list.push(Tried { kind: kind.to_owned(), site, chances: multiplicity.of(c) });
        }
    }
    list
}

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

/// Removes effects that only approximate an unknown law from the report, together with their values
/// of the parameters and their held-out evidence.
fn without_names(findings: &Findings<'_>, map: &UnknownLaw, diagnosis: &mut Diagnosis) {
    diagnosis.effects.clear();
    diagnosis.nominal.iter_mut().zip(&findings.stated.sigma).for_each(|(own, sigma)| {
        (own.after, own.sigma, own.shift_sigma) = (own.before, *sigma, 0.0);
    });
    diagnosis.figures.overlays.clear();
    if diagnosis.held_out.kind == HeldOutKind::Recording {
        let used = if map.plain.is_some() { "used for effects of the catalogue only" } else { "not used" };
        diagnosis.notes.push(format!(
            "the held-out recording was {used}: it tests effects of the catalogue, and the law found is none of them"
        ));
    }
    let gain = &map.held_out;
    diagnosis.held_out = HeldOut {
        kind: HeldOutKind::Blocks,
        loglik_gain: Some(gain.loglik_gain),
        gain_se: Some(gain.gain_se),
        gain_ci95: Some(gain.interval95()),
        ..HeldOut::none()
    };
}

/// Prior standard deviations beyond which a parameter conflicts with its file, and posterior ones
/// that it must be away at least: two-sided probabilities of 6e-5 and 0.3 % of a normal
/// distribution. Chosen, no derivation.
const PRIOR_CONFLICT_SIGMA: f64 = 4.0;
const POSTERIOR_CONFLICT_SIGMA: f64 = 3.0;

/// The parameters of the plant whose estimates conflict with their priors, as a clause; empty
/// without any.
fn prior_conflicts(findings: &Findings<'_>) -> String {
    let best = if findings.adopted.is_empty() { findings.best } else { &findings.selection.model };
    let shared = best.problem.unknowns.iter().zip(best.fit.theta.iter().zip(&best.fit.sigma));
    let mut off: Vec<(f64, String)> = shared
        .filter(|(unknown, _)| unknown.recording.is_none() && !unknown.name.starts_with("effect"))
        .filter(|(unknown, (value, sigma))| (*value - unknown.prior).abs() > POSTERIOR_CONFLICT_SIGMA * **sigma)
        .map(|(unknown, (value, sigma))| {
            let (at, unit) = ((value - unknown.prior).abs() / unknown.sigma, &unknown.unit);
            let (name, prior, wide) = (&unknown.name, short(unknown.prior), short(unknown.sigma));
            (
                at,
                format!(
                    "{name} {} ± {} {unit}, {at:.1} standard deviations from the {prior} ± {wide} that the file states",
                    short(*value),
                    short(*sigma)
                ),
            )
        })
        .filter(|(at, _)| *at > PRIOR_CONFLICT_SIGMA)
        .collect();
    off.sort_by(|a, b| b.0.total_cmp(&a.0));
    let reported: Vec<String> = off.into_iter().take(3).map(|(_, text)| text).collect();
    if reported.is_empty() { String::new() } else { format!("; in conflict with the file: {}", reported.join(", ")) }
}

/// A significant map: evidence beyond the correction for the maps tried, and confirmed on parts
/// that it was not fitted to.
fn residual_law<'f>(findings: &Findings<'f>) -> Option<&'f UnknownLaw> {
    findings.map.filter(|map| {
        let price = 2.0 * libm::log(map.tried.max(1) as f64 / (ALPHA_SHARE_UNIDENTIFIED * findings.alpha));
        map.evidence > price && map.held_out.status() == Status::Confirmed
    })
}

/// Least share that effects must explain to be accepted: of all that was explained including the
/// map, and of the misfit while no noise (where held-out data confirm them, no disturbance) has a
/// higher variance than stated. Chosen on seeded cases, no derivation.
const EXPLAINED_SHARE_MIN: f64 = 0.75;

/// A time–frequency bin of higher energy than chance allows.
fn significant_bin<'f>(findings: &'f Findings<'_>) -> Option<&'f StrongestBin> {
    findings.left.strongest_bin.as_ref().filter(|bin| bin.is_significant(ALPHA_SHARE_UNIDENTIFIED * findings.alpha))
}

/// The deviation is due to isolated outliers: with them clipped none is significant.
fn has_lone_outliers(findings: &Findings<'_>) -> bool {
    let is_significant = |bin: &StrongestBin| bin.is_significant(ALPHA_SHARE_UNIDENTIFIED * findings.alpha);
    let left = &findings.left;
    significant_bin(findings).is_some()
        && left.outliers.iter().all(Outliers::is_rare)
        && !left.beside.as_ref().is_some_and(is_significant)
}

/// `angle has 3 outliers of 2000, the largest of 17.2 standard deviations at 7.000 s of run.csv`,
/// of every channel.
fn outlying(findings: &Findings<'_>) -> String {
    let session = findings.session;
    let reported = |own: &Outliers| {
        format!(
            "{} has {} of {}, the largest of {:.1} standard deviations at {:.3} s of {}",
            session.problem.plant.sensors[own.channel].name,
            own.count,
            own.samples,
            own.largest,
            own.time_s,
            session.problem.recordings[session.problem.runs[own.run].recording]
        )
    };
    findings.left.outliers.iter().map(reported).collect::<Vec<_>>().join("; ")
}

/// Where a time–frequency bin lies.
pub(crate) fn bin_location(session: &EstimationSession<'_>, bin: &StrongestBin) -> Where {
    let channel = session.problem.plant.sensors[bin.channel].name.clone();
    Where { site: channel.clone(), channel, time: bin.time_s, band_hz: bin.band_hz, states: Vec::new(), p: bin.p() }
}

/// The recording that contains a time–frequency bin.
fn recording<'e>(session: &'e EstimationSession<'_>, bin: &StrongestBin) -> &'e str {
    &session.problem.recordings[session.problem.runs[bin.run].recording]
}

fn bin_in_words(findings: &Findings<'_>, bin: &StrongestBin) -> String {
    format!(
        "{} of {} from {:.3} to {:.3} s between {:.3} and {:.3} Hz, evidence {:.0}",
        findings.session.problem.plant.sensors[bin.channel].name,
        recording(findings.session, bin),
        bin.time_s[0],
        bin.time_s[1],
        bin.band_hz[0],
        bin.band_hz[1],
        bin.evidence
    )
}

/// Where an unknown law acts.
pub(crate) fn located(session: &EstimationSession<'_>, map: &UnknownLaw, alpha: f64) -> Where {
    let (begin, end) = session
        .problem
        .runs
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(b, e), run| (b.min(run.begin_s), e.max(run.end_s)));
    let channel = match map.place.acts {
        Acts::Reading(channel) => session.problem.plant.sensors[channel].name.clone(),
        Acts::Force(_) => String::new(),
    };
    Where {
        channel,
        site: map.place.site.clone(),
        time: [begin, end],
        band_hz: [0.0, 0.5 / session.timelines[0].period_s],
        states: map.names.clone(),
        p: (libm::exp(-0.5 * map.evidence) * map.tried as f64).min(alpha),
    }
}

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

fn not_named(map: &UnknownLaw) -> (Verdict, String) {
    let what = if matches!(map.place.acts, Acts::Force(_)) { "a force" } else { "an error of the reading" };
    let reason = match &map.plain {
        Some(reported) => format!(
            "something acts at {} that no effect of the catalogue describes: {what} with one parameter, {}, explains as much as effects with {} \
             (ahead by {:.0} in BIC)",
            map.place.site, reported.formula, reported.numbers, map.evidence
        ),
        None => format!(
            "something acts at {} that no effect of the catalogue describes: {what}, smooth over {}, gains {:.0} in evidence \
             and predicts parts of this recording that it was not fitted to (gain {:.1} ± {:.1})",
            map.place.site,
            map.names.join(" and "),
            map.evidence,
            map.held_out.loglik_gain,
            map.held_out.gain_se
        ),
    };
    if map.place.is_of_time() {
        let cure = "an unknown law or a disturbance: repeat the experiment; a residual that recurs at the same states is deterministic, not noise";
        return (Verdict::CannotDecide, format!("{reason}; {cure}"));
    }
    (Verdict::NotInCatalogue, reason)
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
    let weight = findings.adopted.iter().map(|a| a.weight).fold(1.0, f64::min);
    let sensor = findings.adopted.iter().all(|a| a.column.candidate.site.kind == SiteKind::Sensor);
    let state = status(findings.selection.evidence.gain.as_ref());
    if state == Status::Rejected {
        let short = findings.selection.evidence.gain.filter(|gain| gain.interval95()[1] >= 0.0);
        let so = short.map_or(String::new(), |gain| {
            let (own, se, predicted) = (gain.loglik_gain, gain.gain_se, gain.expected);
            format!(": the gain on them is {own:.1} ± {se:.1} where {predicted:.1} is predicted")
        });
        let reason = format!("{} explained this recording, but held-out data reject it{so}", kinds.join(" and "));
        return (Verdict::CannotDecide, reason);
    }
    if let Some(repeat) = findings.repeat.filter(|repeat| !repeat.confirms()) {
        let reason = format!(
            "{} explained this recording, but the repeat does not show it: z = {:.1} where {:.1} was expected{}",
            kinds.join(" and "),
            repeat.z,
            repeat.expected,
            if repeat.lacks_power() { "; the repeat is too short or excites too little to decide" } else { "" }
        );
        return (Verdict::CannotDecide, reason);
    }
    let is_sure = state == Status::Confirmed;
    // confirmed effects may leave readings of higher variance than stated; a force of unspecified
    // variance is a missing part, unless the whole recurs in a repeat
    let repeats = findings.repeat.is_some();
    let share = if repeats { 1.0 } else { share_explained(findings, is_sure).unwrap_or(0.0) };
    if share < EXPLAINED_SHARE_MIN {
        let (noise, but) = if is_sure {
            ("disturbances", "held-out data confirm that much")
        } else {
            ("noise", "held-out data do not confirm them")
        };
        let reason = format!(
            "{} explain {:.0} % of the misfit under {noise} of the stated variance, and {but}; the rest is an unknown law or an unknown \
             disturbance: repeat the experiment; a residual that recurs at the same states is deterministic, not noise{}",
            kinds.join(" and "),
            100.0 * share.max(0.0),
            significant_bin(findings)
                .map_or(String::new(), |bin| format!(" (largest: {})", bin_in_words(findings, bin)))
        );
        return (Verdict::CannotDecide, reason);
    }
    let word = if state == Status::Confirmed { "confirmed" } else { "not yet confirmed" };
    let runs_away = findings.selection.evidence.gain.filter(Gain::free_run_diverges).map_or(String::new(), |gain| {
        format!(", by single steps: in free run {:.1} times as far from them as the plant alone", gain.free_run)
    });
    let open = findings.adopted.iter().zip(&findings.selection.status).filter(|(_, own)| **own != state);
    let open: Vec<&str> = open.map(|(adopted, _)| adopted.column.candidate.effect.kind).collect();
    let but = if open.is_empty() { String::new() } else { format!(" without {}", open.join(" and ")) };
    let reason = format!(
        "{} (probability {:.2}, {word} on held-out data{but}{runs_away}; {} after correction for all hypotheses)",
        kinds.join(" and "),
        weight,
        chance(first.p)
    );
    let left = residual_law(findings).map_or(String::new(), |map| {
        format!("; a smaller unmodelled law remains at {} (evidence {:.0})", map.place.site, map.evidence)
    });
    let again = findings.repeat.map_or(String::new(), |repeat| {
        format!("; the repeat shows it too (z = {:.1}, expected {:.1})", repeat.z, repeat.expected)
    });
    let reason = format!("{reason}{again}{left}");
    if weight < SEPARABLE_WEIGHT_MIN {
        return (Verdict::NotSeparable, reason);
    }
    (if sensor { Verdict::Sensor } else { Verdict::Named }, reason)
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

/// Gain in `−2 ln p` from which a change of the noise is reported by itself: odds of exp(5) = 150 :
/// 1. Chosen, no derivation; it affects the sentence only.
const NOISE_CHANGE_GAIN_MIN: f64 = 10.0;

/// The largest changes between stated and adapted noise, in words.
fn changed_noise(findings: &Findings<'_>) -> String {
    let (session, best) = (findings.session, findings.best);
    let mut list = changes(session, &best.noise);
    list.sort_by(|a, b| b.0.total_cmp(&a.0));
    let objective = |noise: &NoiseModel| {
        let normal = best.fit.linearised.normal(session, &best.fit.theta, noise, &[]);
        normal.and_then(|normal| normal.minimum_without()).unwrap_or(f64::INFINITY) + session.disturbance_price(noise)
    };
    let least = objective(&best.noise);
    let (worth, rest): (Vec<_>, Vec<_>) =
        list.into_iter().partition(|(.., before)| objective(before) > least + NOISE_CHANGE_GAIN_MIN);
    let reported = if worth.is_empty() { rest } else { worth };
    reported.into_iter().take(3).map(|(_, text, _)| text).collect::<Vec<_>>().join(", ")
}

/// Every parameter of the noise that was adapted: the size of its change, in words, and the noise
/// without it.
fn changes(session: &EstimationSession<'_>, noise: &NoiseModel) -> Vec<(f64, String, NoiseModel)> {
    let mut list = Vec::new();
    let stated = &session.noise;
    let mut push = |size: f64, text: String, back: &dyn Fn(&mut NoiseModel)| {
        let mut before = noise.clone();
        back(&mut before);
        list.push((size, text, before));
    };
    for (i, sensor) in session.problem.plant.sensors.iter().enumerate() {
        let (name, factor) = (&sensor.name, noise.sensor_sigma[i] / stated.sensor_sigma[i]);
        push(libm::log(factor).abs(), format!("{name} x{factor:.2}"), &|n| n.sensor_sigma[i] = stated.sensor_sigma[i]);
        let jitter = noise.jitter_s[i] / session.interval_s(i);
        if jitter > 0.0 {
            // a hundredth of an interval counts as much as a factor of e
            let text = format!("stamps of {name} jitter by {:.1} % of the interval", 100.0 * jitter);
            push(libm::log(1.0 + 100.0 * jitter), text, &|n| n.jitter_s[i] = 0.0);
        }
        let colour = libm::atanh(noise.pole[i].abs().min(0.999));
        push(colour, format!("{name} correlated, pole {:.2}", noise.pole[i]), &|n| n.pole[i] = 0.0);
    }
    for (i, name) in session.noise_names.iter().enumerate() {
        let factor = noise.input_sigma[i] / stated.input_sigma[i];
        if factor > 1.0 {
            let text = format!("{name} x{factor:.3}");
            push(0.3 * libm::log(factor), text, &|n| n.input_sigma[i] = stated.input_sigma[i]);
        }
    }
    list
}

fn effect(session: &EstimationSession<'_>, best: &FittedModel, adopted: &Adopted, status: Status) -> EffectReport {
    let rivals = adopted.rivals.iter().map(|rival| Rival {
        kind: rival.kind.to_owned(),
        site: rival.site.clone(),
        probability: rival.weight,
        reason: format!(
            "fits worse by {:.1} in BIC; cosine {:.3} between what the two would show",
            rival.bic, rival.cosine
        ),
    });
    let candidate = &adopted.column.candidate;
    EffectReport {
        kind: candidate.effect.kind.to_owned(),
        title: candidate.effect.title.to_owned(),
        site: candidate.site.to_string(),
        probability: adopted.weight,
        status,
        rivals: rivals.collect(),
        parameters: parameters(session, best, candidate),
        kept: kept(best, candidate),
        kappa: adopted.score.kappa,
        d: adopted.d,
        evidence: None,
    }
}

/// Estimated parameters of the effect of `candidate`, and its searched times.
fn parameters(session: &EstimationSession<'_>, best: &FittedModel, candidate: &Candidate) -> Vec<ParameterReport> {
    let prefix = format!("effect.{}@{}.", candidate.effect.kind, candidate.site);
    let times = EstimationSession::like(session, &best.problem).ok();
    let times = times.and_then(|own| onset_estimates(&own, (&best.fit, &best.noise), candidate));
    let (times, beside) = times.unwrap_or_default();
    let own = best.problem.unknowns.iter().enumerate().filter(|(_, u)| u.parameter.starts_with(&prefix));
    let estimated = own.map(|(i, unknown)| ParameterReport {
        name: unknown.parameter[prefix.len()..].to_owned(),
        value: best.fit.theta[i],
        sigma: beside.get(i).copied().unwrap_or(0.0).max(best.fit.sigma[i]),
        unit: unknown.unit.clone(),
    });
    let times = times.into_iter().map(|found| ParameterReport {
        name: found.name.to_owned(),
        value: found.value,
        sigma: found.sigma,
        unit: "s".to_owned(),
    });
    estimated.chain(times).collect()
}

/// Parameters that the fit of the effect of `candidate` kept, and their values; times apart.
fn kept(best: &FittedModel, candidate: &Candidate) -> Vec<(String, f64)> {
    let of = |used: &&EffectUse| used.kind == candidate.effect.kind && used.site == candidate.site;
    let values = best.plant.effects.iter().filter(of).flat_map(|used| &used.values);
    let is_time =
        |name: &str| candidate.effect.parameter(name).is_some_and(|p| matches!(p.role, Role::Onset | Role::Duration));
    let kept = values.filter(|(name, quantity)| quantity.sigma.is_none() && !is_time(name));
    kept.map(|(name, quantity)| (name.clone(), quantity.value)).collect()
}

fn unfitted(findings: &Findings<'_>, lost: &Unfitted) -> EffectReport {
    let candidate = &lost.column.candidate;
    let unit = findings.session.problem.plant.effect_unit(
        &EffectUse { kind: candidate.effect.kind.to_owned(), site: candidate.site.clone(), values: Vec::new() },
        candidate.effect.parameters[0].unit,
    );
    let amplitude = ParameterReport {
        name: candidate.amplitude().to_owned(),
        value: lost.amplitude,
        sigma: lost.score.limit / crate::score::LIMIT_D,
        unit,
    };
    EffectReport {
        kind: candidate.effect.kind.to_owned(),
        title: candidate.effect.title.to_owned(),
        site: candidate.site.to_string(),
        probability: 0.0,
        status: Status::NotConverged,
        rivals: Vec::new(),
        parameters: vec![amplitude],
        kept: Vec::new(),
        kappa: lost.score.kappa,
        d: lost.ratio.max(0.0).sqrt(),
        evidence: None,
    }
}

fn nominal(findings: &Findings<'_>) -> Vec<Nominal> {
    let (before, after) = (findings.stated, &findings.selection.model);
    let unknowns = &findings.session.problem.unknowns;
    unknowns
        .iter()
        .enumerate()
        .map(|(i, unknown)| {
            let at = after.problem.unknowns.iter().position(|other| other.name == unknown.name);
            let (value, sigma) =
                at.map_or((before.theta[i], before.sigma[i]), |at| (after.fit.theta[at], after.fit.sigma[at]));
            Nominal {
                name: unknown.name.clone(),
                before: before.theta[i],
                after: value,
                sigma,
                shift_sigma: if sigma > 0.0 { (value - before.theta[i]) / sigma } else { 0.0 },
            }
        })
        .collect()
}

fn limits(findings: &Findings<'_>) -> Vec<DetectionLimit> {
    let mut list: Vec<DetectionLimit> = Vec::new();
    let plant = &findings.session.problem.plant;
    for score in &findings.screening.scores {
        let candidate = &findings.screening.columns[score.column].candidate;
        let (kind, site) = (candidate.effect.kind, candidate.site.to_string());
        if let Some(known) = list.iter_mut().find(|known| known.kind == kind && known.site == site) {
            known.amplitude = known.amplitude.min(score.limit);
            continue;
        }
        let used = EffectUse { kind: kind.to_owned(), site: candidate.site.clone(), values: Vec::new() };
        let unit = plant.effect_unit(&used, candidate.effect.parameters[0].unit);
        list.push(DetectionLimit { kind: kind.to_owned(), site, amplitude: score.limit, unit });
    }
    list
}

fn held_out(findings: &Findings<'_>, diagnosis: &mut Diagnosis) {
    let evidence = &findings.selection.evidence;
    let held = &mut diagnosis.held_out;
    held.kind = evidence.kind;
    held.channels = (evidence.before.iter().zip(&evidence.after))
        .map(|(before, after)| HeldOutChannel {
            name: before.name.clone(),
            fit_percent_before: before.fit_percent,
            fit_percent_after: after.fit_percent,
            rms_before: before.rms,
            rms_after: after.rms,
        })
        .collect();
    if let Some(gain) = &evidence.gain {
        (held.loglik_gain, held.gain_se, held.gain_ci95) =
            (Some(gain.loglik_gain), Some(gain.gain_se), Some(gain.interval95()));
    }
    held.whiteness_p_before = whiteness_p(findings.session, findings.stated, &findings.session.noise);
    held.whiteness_p_after =
        whiteness_p(findings.session, &findings.selection.model.fit, &findings.selection.model.noise);
}

/// Plant file with estimates and confirmed effects.
fn augmented(findings: &Findings<'_>) -> Option<String> {
    if findings.adopted.is_empty() || status(findings.selection.evidence.gain.as_ref()) != Status::Confirmed {
        return None;
    }
    Some(plant_file::write(&posterior(&findings.selection.model)))
}
