//! The answer in three sentences: the physics that the plant lacks, the proof, and the next step.

mod noise;
mod proof;
mod step;

use super::Diagnosed;
use super::names::{in_titles, named, site_in_words, titled, unit};
use super::paragraph::parameter_unit;
use discovery::diagnose::{Diagnosis, EffectReport, Nominal, ParameterReport, Verdict};
use identification::held_out::Status;
use noise::Noise;
use report::text::with_sigma;

/// Parameters of an effect that the sentence holds; the table holds all.
const PARAMETERS_MAX: usize = 3;
/// Rivals from this probability on are part of the sentence.
const RIVAL_PROBABILITY_MIN: f64 = 0.005;

/// What, proof, next: one sentence each, for every verdict.
pub fn answer(diagnosed: &Diagnosed) -> [String; 3] {
    [what(diagnosed), proof::proof(diagnosed), step::step(diagnosed)].map(|text| sentence(&text))
}

/// With a capital letter and one full stop.
fn sentence(text: &str) -> String {
    let mut letters = text.trim_end_matches('.').chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

fn what(diagnosed: &Diagnosed) -> String {
    let labels: Vec<String> =
        diagnosed.labels.iter().map(|label| format!("in {} {}", label.recording, label.in_words())).collect();
    let found = physics(diagnosed);
    match (labels.is_empty(), found) {
        (true, found) => found.unwrap_or_else(|| "the plant lacks no physics".into()),
        (false, None) => format!("a channel is mislabelled: {}; the plant lacks no physics", labels.join(", and ")),
        (false, Some(found)) => {
            format!("a channel is mislabelled: {}; with the label corrected, {found}", labels.join(", and "))
        }
    }
}

/// The verdict on the physics; `None` where a mislabelled channel is all there is.
fn physics(diagnosed: &Diagnosed) -> Option<String> {
    let (diagnosis, mislabelled) = (&diagnosed.diagnosis, !diagnosed.labels.is_empty());
    let reason = beside_labels(&diagnosis.reason);
    let supported = supported(diagnosis);
    let list = supported.iter().map(|effect| with_parameters(effect)).collect::<Vec<_>>().join("; ");
    let lacks = match supported.len() {
        1 => "the plant lacks one effect".to_owned(),
        n => format!("the plant lacks {n} effects"),
    };
    Some(match diagnosis.verdict {
        Verdict::Named if supported.is_empty() => "the plant lacks an effect".into(),
        Verdict::Named => format!("{lacks}: {list}"),
        Verdict::Sensor if supported.is_empty() && mislabelled => return None,
        Verdict::Sensor => format!("a sensor is at fault and the plant lacks no physics: {list}"),
        Verdict::NotSeparable => {
            format!("the plant lacks an effect that these data cannot separate from its rivals: {}", rivals(&supported))
        }
        Verdict::NotInCatalogue => unknown(diagnosis),
        Verdict::NoiseModel => match Noise::of(reason) {
            Some(noise) => noise.in_words(&diagnosed.case.plant_file),
            None => first_clause(reason),
        },
        Verdict::ParameterConflict => match most_shifted(diagnosis) {
            Some(moved) => conflict(moved, diagnosed),
            None => first_clause(reason),
        },
        Verdict::InputTiming => first_clause(reason),
        Verdict::CannotDecide => format!("these recordings decide nothing: {}", first_clause(reason)),
        Verdict::None if diagnosis.relevance_percent.is_some() => first_clause(reason),
        Verdict::None => "the plant lacks nothing that these recordings could show".into(),
    })
}

/// The parameter of the plant file that moves most, in standard deviations.
fn most_shifted(diagnosis: &Diagnosis) -> Option<&Nominal> {
    let moved = diagnosis.nominal.iter().filter(|n| n.shift_sigma.is_finite());
    moved.max_by(|a, b| a.shift_sigma.abs().total_cmp(&b.shift_sigma.abs()))
}

/// What the recordings say of a parameter that the plant file states otherwise.
fn conflict(moved: &Nominal, diagnosed: &Diagnosed) -> String {
    let (value, sigma) = with_sigma(moved.after, moved.sigma);
    let unit = unit(&parameter_unit(&diagnosed.case.plant, &moved.name));
    let (name, file) = (&moved.name, &diagnosed.case.plant_file);
    format!("{file} states another {name} than these recordings show, {value} ± {sigma}{unit}; no physics is missing")
}

/// A reason without the labels that stand in front of it, which have a sentence of their own.
fn beside_labels(reason: &str) -> &str {
    reason.split_once("; with that corrected: ").map_or(reason, |(_, reason)| reason)
}

/// The effects that support the verdict.
fn supported(diagnosis: &Diagnosis) -> Vec<&EffectReport> {
    let rejected = |e: &&EffectReport| matches!(e.status, Status::NotConverged | Status::Rejected);
    diagnosis.effects.iter().filter(|e| !rejected(e)).collect()
}

/// `Coulomb friction in joint pivot, 0.3000 ± 0.0040 N m`.
pub fn with_parameters(effect: &EffectReport) -> String {
    let shown: Vec<String> = match &effect.parameters[..] {
        [one] => vec![estimate(one)],
        all => all.iter().take(PARAMETERS_MAX).map(|p| format!("{} {}", p.name, estimate(p))).collect(),
    };
    let mut words = vec![titled(&effect.title, &effect.site)];
    words.extend(shown);
    words.join(", ")
}

/// Value, standard deviation and unit, rounded to what the deviation supports; of a value that the
/// range of its law bounds, that it is.
pub fn estimate(parameter: &ParameterReport) -> String {
    let (value, sigma) = with_sigma(parameter.value, parameter.sigma);
    let bound = if parameter.at_bound { " (at the limit of its range)" } else { "" };
    format!("{value} ± {sigma}{}{bound}", unit(&parameter.unit))
}

/// Each effect or its rivals, with probabilities.
fn rivals(effects: &[&EffectReport]) -> String {
    let each = |e: &&EffectReport| {
        let mut all = vec![format!("{} (probability {:.2})", titled(&e.title, &e.site), e.probability)];
        let others = e.rivals.iter().filter(|r| r.probability >= RIVAL_PROBABILITY_MIN);
        all.extend(others.map(|r| format!("{} (probability {:.2})", named(&r.kind, &r.site), r.probability)));
        all.join(", or ")
    };
    effects.iter().map(each).collect::<Vec<_>>().join("; and ")
}

/// Place and coordinates of a law outside the catalogue; a drift of modes in its own words.
fn unknown(diagnosis: &Diagnosis) -> String {
    let lacks = "the plant lacks a law that the catalogue does not contain";
    match diagnosis.located.last().filter(|place| !place.states.is_empty()) {
        Some(place) => {
            let what = if place.channel.is_empty() { "a force" } else { "an error of the reading" };
            format!("{lacks}: {what} at {} over {}", site_in_words(&place.site), place.states.join(" and "))
        }
        None => format!("{lacks}: {}", first_clause(&diagnosis.reason)),
    }
}

/// The reason up to its first semicolon, with titles for identifiers.
fn first_clause(reason: &str) -> String {
    let clause = in_titles(reason.split("; ").next().unwrap_or_default());
    if clause.is_empty() { "no reason is given".into() } else { clause }
}

/// The data that confirm an effect of this status, or its status.
pub fn confirmed_by(diagnosed: &Diagnosed, status: Status) -> String {
    match (status, proof::held_out_name(diagnosed)) {
        (Status::Confirmed, Some(name)) => name.split(',').next().unwrap_or_default().to_owned(),
        (Status::Confirmed, None) => "held-out data".into(),
        (Status::Unconfirmed, _) => "not yet".into(),
        (Status::Rejected, _) => "rejected".into(),
        (Status::NotConverged, _) => "model not converged".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_at_the_limit_of_its_range_says_so() {
        let inside = ParameterReport::inside("scale".into(), (0.29, 0.02), "1".into());
        let at_bound = ParameterReport { value: 0.3, at_bound: true, ..inside.clone() };
        assert!(!estimate(&inside).contains("limit"), "{}", estimate(&inside));
        assert!(estimate(&at_bound).ends_with("(at the limit of its range)"), "{}", estimate(&at_bound));
        // a key of the object where it holds, and no other one
        let keys = |own: &ParameterReport| serde_json::to_value(own).unwrap().as_object().unwrap().len();
        assert_eq!((keys(&inside), keys(&at_bound)), (4, 5));
    }
}
