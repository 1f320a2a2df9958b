//! Rows of the report: effects, parameters, detection limits, held-out evidence, conflicts.

use super::Findings;
use crate::compete::{FittedModel, Multiplicity, onset_estimates};
use crate::diagnose::evidence::whiteness_p;
use crate::diagnose::next::posterior;
use crate::diagnose::report::*;
use crate::diagnose::{Adopted, Unfitted, status};
use crate::score::Candidate;
use crate::unknown_law::UnknownLaw;
use dynamics::description::EffectUse;
use examination::doctor::short;
use identification::fit::EstimationSession;
use identification::held_out::Status;

/// Every law of the first screening with the factor on its p value.
pub(super) fn tried(findings: &Findings<'_>) -> Vec<Tried> {
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

/// Removes effects that only approximate an unknown law from the report, together with their values
/// of the parameters and their held-out evidence.
pub(super) fn without_names(findings: &Findings<'_>, map: &UnknownLaw, diagnosis: &mut Diagnosis) {
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
pub(super) fn prior_conflicts(findings: &Findings<'_>) -> String {
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

pub(super) fn effect(
    session: &EstimationSession<'_>,
    best: &FittedModel,
    adopted: &Adopted,
    status: Status,
) -> EffectReport {
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
        kept: kept(&best.plant, candidate),
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

pub(super) fn unfitted(findings: &Findings<'_>, lost: &Unfitted) -> EffectReport {
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

pub(super) fn nominal(findings: &Findings<'_>) -> Vec<Nominal> {
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

pub(super) fn limits(findings: &Findings<'_>) -> Vec<DetectionLimit> {
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

pub(super) fn held_out(findings: &Findings<'_>, diagnosis: &mut Diagnosis) {
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
pub(super) fn augmented(findings: &Findings<'_>) -> Option<String> {
    if findings.adopted.is_empty() || status(findings.selection.evidence.gain.as_ref()) != Status::Confirmed {
        return None;
    }
    Some(plant_file::write(&posterior(&findings.selection.model)))
}
