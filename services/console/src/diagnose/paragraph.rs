//! The first paragraph: for an engineer who reads nothing else.

use crate::recordings::probability;
use discovery::diagnose::{Diagnosis, EffectReport, HeldOutChannel, HeldOutKind, ParameterReport, Verdict};
use identification::held_out::Status;
use report::text::{short, with_sigma};

/// What is missing, where, how large, confirmed or not, what it changes.
pub fn first_paragraph(diagnosis: &Diagnosis) -> String {
    let mut sentences = vec![headline(diagnosis)];
    if says_more_than_headline(diagnosis.verdict) {
        sentences.extend(place(diagnosis));
        sentences.extend(shown(diagnosis));
        sentences.extend(standing(diagnosis));
        sentences.extend(bias(diagnosis));
    }
    if !diagnosis.reason.is_empty() && says_more_than_headline(diagnosis.verdict) {
        sentences.push(format!("Reason: {}", sentence_within(&diagnosis.reason)));
    }
    sentences.join(" ")
}

fn says_more_than_headline(verdict: Verdict) -> bool {
    !matches!(verdict, Verdict::None | Verdict::CannotDecide)
}

/// The verdict in a few words.
pub fn verdict_words(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::None => "nothing is missing",
        Verdict::Named => "named",
        Verdict::NotSeparable => "several effects cannot be told apart",
        Verdict::NotInCatalogue => "not in the catalogue",
        Verdict::NoiseModel => "the noise is not as stated",
        Verdict::Sensor => "a sensor",
        Verdict::Unobservable => "unobservable",
        Verdict::CannotDecide => "cannot decide",
    }
}

fn headline(diagnosis: &Diagnosis) -> String {
    let all = held_up(diagnosis).map(in_words).collect::<Vec<_>>().join("; and ");
    match diagnosis.verdict {
        Verdict::None if diagnosis.reason.is_empty() => "Nothing is missing that these recordings could show.".into(),
        Verdict::None => sentence(&diagnosis.reason),
        Verdict::Named if all.is_empty() => "Something is missing.".into(),
        Verdict::Named => format!("What is missing: {all}."),
        Verdict::Sensor if all.is_empty() => "No physics is missing; a channel is labelled wrongly.".into(),
        Verdict::Sensor => format!("No physics is missing; a sensor is at fault: {all}."),
        Verdict::NotSeparable => {
            format!("Something is missing, and these recordings cannot tell which it is: {}.", set(diagnosis))
        }
        Verdict::NotInCatalogue => "Something is missing that the catalogue does not hold.".into(),
        Verdict::NoiseModel => "No physics is missing; the noise is not what the plant file states.".into(),
        Verdict::Unobservable => "What may be missing cannot be observed in these recordings.".into(),
        Verdict::CannotDecide => format!("Nothing can be decided, because {}", sentence_within(&diagnosis.reason)),
    }
}

/// `Coulomb friction at joint:pivot (joint_coulomb), force 0.300 ± 0.004 N*m`.
pub fn in_words(effect: &EffectReport) -> String {
    let numbers: Vec<String> = effect.parameters.iter().map(parameter).collect();
    let numbers = if numbers.is_empty() { String::new() } else { format!(", {}", numbers.join(", ")) };
    format!("{} at {} ({}){numbers}", effect.title, effect.site, effect.kind)
}

fn parameter(parameter: &ParameterReport) -> String {
    let (value, sigma) = with_sigma(parameter.value, parameter.sigma);
    format!("{} {value} ± {sigma}{}", parameter.name, unit(&parameter.unit))
}

/// A unit behind a number.
pub fn unit(unit: &str) -> String {
    if matches!(unit, "" | "-" | "1") { String::new() } else { format!(" {unit}") }
}

/// The effects and their rivals with probabilities.
fn set(diagnosis: &Diagnosis) -> String {
    let named = |kind: &str, site: &str, p: f64| format!("{kind} at {site} ({p:.2})");
    let each = |e: &EffectReport| {
        let mut all = vec![named(&e.kind, &e.site, e.probability)];
        all.extend(e.rivals.iter().filter(|r| r.probability >= 0.005).map(|r| named(&r.kind, &r.site, r.probability)));
        all.join(", or ")
    };
    held_up(diagnosis).map(each).collect::<Vec<_>>().join("; and ")
}

/// The effects that support the verdict.
fn held_up(diagnosis: &Diagnosis) -> impl Iterator<Item = &EffectReport> {
    diagnosis.effects.iter().filter(|e| !matches!(e.status, Status::NotConverged | Status::Rejected))
}

fn place(diagnosis: &Diagnosis) -> Option<String> {
    let first = diagnosis.located.first()?;
    let [from, to] = first.time.map(short);
    // a force is of no channel
    let at = if first.channel.is_empty() { format!("at {}", first.site) } else { format!("in {}", first.channel) };
    Some(format!("It shows most {at} between {from} and {to} s ({}).", probability(first.p)))
}

/// Held-out fit of the channel that gains most.
fn shown(diagnosis: &Diagnosis) -> Option<String> {
    let held = &diagnosis.held_out;
    let gain = |c: &HeldOutChannel| c.fit_percent_after - c.fit_percent_before;
    let best = held.channels.iter().filter(|c| gain(c).is_finite()).max_by(|a, b| gain(a).total_cmp(&gain(b)))?;
    let on = held_out_words(held.kind)?;
    let others = match held.channels.len() - 1 {
        0 => String::new(),
        n => format!(" ({n} more channel{} in the table)", if n == 1 { "" } else { "s" }),
    };
    let (before, after) = (percent(best.fit_percent_before), percent(best.fit_percent_after));
    // neither is wrong: they judge different things
    let but =
        if gain(best) < 0.0 { ": it carries the error of its start along, and the gain below does not" } else { "" };
    Some(format!("With it the fit of {} in free run goes from {before} to {after} % on {on}{others}{but}.", best.name))
}

/// A fit as it is printed: without decimals where it is far below zero.
pub fn percent(fit: f64) -> String {
    match fit {
        f if !f.is_finite() => "–".into(),
        f if f < -1000.0 => short(f),
        f => format!("{f:.1}"),
    }
}

/// What was held out, in words.
pub fn held_out_words(kind: HeldOutKind) -> Option<&'static str> {
    match kind {
        HeldOutKind::Recording => Some("a recording that nothing was fitted to"),
        HeldOutKind::Blocks => Some("blocks of the recordings, each predicted from the others"),
        HeldOutKind::None => None,
    }
}

fn standing(diagnosis: &Diagnosis) -> Option<String> {
    let fitted: Vec<&EffectReport> = diagnosis.effects.iter().filter(|e| e.status != Status::NotConverged).collect();
    let name = |e: &EffectReport| if fitted.len() == 1 { "it".to_owned() } else { format!("{} at {}", e.kind, e.site) };
    let of = |status| fitted.iter().filter(|e| e.status == status).map(|e| name(e)).collect::<Vec<_>>();
    let [confirmed, open, rejected] = [Status::Confirmed, Status::Unconfirmed, Status::Rejected].map(of);
    let numbers = gain_words(diagnosis).map_or(String::new(), |gain| format!(" ({gain})"));
    let left_out = |kinds: &[String], does: &str, numbers: &str| {
        let is = if kinds.len() == 1 { "is" } else { "are" };
        format!("Held-out data {does} {}{numbers}, which {is} not in the augmented plant.", kinds.join(" and "))
    };
    let mut sentences = Vec::new();
    if !confirmed.is_empty() {
        sentences.push(format!("Held-out data confirm {}{numbers}.", confirmed.join(" and ")));
    }
    for (kinds, does) in [(&open, "do not decide yet on"), (&rejected, "refuse")] {
        // the gain is that of the model
        let numbers = if sentences.is_empty() { &*numbers } else { "" };
        if !kinds.is_empty() {
            sentences.push(left_out(kinds, does, numbers));
        }
    }
    (!sentences.is_empty()).then(|| sentences.join(" "))
}

/// `gain in log-likelihood 184 ± 22, 95 %: 140 to 228`.
pub fn gain_words(diagnosis: &Diagnosis) -> Option<String> {
    let held = &diagnosis.held_out;
    let gain = held.loglik_gain?;
    let mut text = match held.gain_se {
        Some(sigma) => {
            let (gain, sigma) = with_sigma(gain, sigma);
            format!("gain in log-likelihood {gain} ± {sigma}")
        }
        None => format!("gain in log-likelihood {}", short(gain)),
    };
    if let Some([low, high]) = held.gain_ci95 {
        text.push_str(&format!(", 95 %: {} to {}", short(low), short(high)));
    }
    Some(text)
}

/// The nominal number that the missing physics had biased most, from two sigmas on.
fn bias(diagnosis: &Diagnosis) -> Option<String> {
    let shifted = diagnosis.nominal.iter().filter(|n| n.shift_sigma.is_finite() && n.shift_sigma.abs() >= 2.0);
    let most = shifted.max_by(|a, b| a.shift_sigma.abs().total_cmp(&b.shift_sigma.abs()))?;
    Some(format!(
        "Without it {} came out as {} instead of {}, {} sigma off.",
        most.name,
        short(most.before),
        short(most.after),
        short(most.shift_sigma.abs())
    ))
}

/// With a capital letter and a full stop.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    sentence_within(&format!("{first}{}", letters.as_str()))
}

fn sentence_within(text: &str) -> String {
    if text.ends_with('.') { text.to_owned() } else { format!("{text}.") }
}
