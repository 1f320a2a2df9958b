//! The sentences behind the answer: where, confirmed or not, what it biased, the reason.

use super::names::{in_titles, named, site_in_words, unit};
use discovery::diagnose::{DetectionLimit, Diagnosis, EffectReport, HeldOutKind, Verdict};
use dynamics::description::Plant;
use examination::doctor::probability;
use identification::held_out::Status;
use report::text::{short, with_sigma};

/// Place, status, bias and reason: the evidence behind the answer.
pub fn details_paragraph(diagnosis: &Diagnosis, plant: &Plant) -> String {
    let mut sentences = Vec::new();
    if says_more_than_headline(diagnosis.verdict) {
        sentences.extend(place(diagnosis));
        sentences.extend(standing(diagnosis));
        sentences.extend(bias(diagnosis, plant));
    }
    if !diagnosis.reason.is_empty() {
        let reason = match diagnosis.verdict {
            Verdict::NoiseModel => noise_in_words(&diagnosis.reason),
            _ => diagnosis.reason.clone(),
        };
        sentences.push(format!("Reason: {}", sentence_within(&in_titles(&reason))));
    }
    sentences.join(" ")
}

/// `angle x0.99` as `angle 0.99 times the stated noise`.
fn noise_in_words(reason: &str) -> String {
    let factor = |word: &str| {
        let number = word.strip_prefix('x')?;
        let bare = number.trim_end_matches([',', ';', '.']);
        bare.parse::<f64>().ok().map(|_| format!("{bare} times the stated noise{}", &number[bare.len()..]))
    };
    let words: Vec<String> = reason.split(' ').map(|word| factor(word).unwrap_or_else(|| word.to_owned())).collect();
    words.join(" ")
}

fn says_more_than_headline(verdict: Verdict) -> bool {
    !matches!(verdict, Verdict::None | Verdict::CannotDecide)
}

/// The verdict in a few words.
pub fn verdict_words(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::None => "nothing is missing",
        Verdict::Named => "the missing physics is named",
        Verdict::NotSeparable => "several effects cannot be told apart",
        Verdict::NotInCatalogue => "the missing physics is not in the catalogue",
        Verdict::NoiseModel => "the noise is not as stated",
        Verdict::ParameterConflict => "a parameter is not as stated",
        Verdict::InputTiming => "inputs act at another time than stated",
        Verdict::Sensor => "a sensor is at fault",
        Verdict::CannotDecide => "cannot decide",
    }
}

fn place(diagnosis: &Diagnosis) -> Option<String> {
    let first = diagnosis.located.first()?;
    let [from, to] = first.time.map(short);
    // a force is of no channel
    let at = if first.channel.is_empty() {
        format!("at {}", site_in_words(&first.site))
    } else {
        format!("in {}", first.channel)
    };
    Some(format!(
        "The misfit of the plant is most significant {at} between {from} and {to} s ({}).",
        probability(first.p)
    ))
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
    let name = |e: &EffectReport| if fitted.len() == 1 { "the effect".to_owned() } else { named(&e.kind, &e.site) };
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
    for (kinds, does) in [(&open, "do not decide yet on"), (&rejected, "reject")] {
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

/// The nominal parameter that the missing physics had biased most, from two sigmas on.
fn bias(diagnosis: &Diagnosis, plant: &Plant) -> Option<String> {
    let shifted = diagnosis.nominal.iter().filter(|n| n.shift_sigma.is_finite() && n.shift_sigma.abs() >= 2.0);
    let most = shifted.max_by(|a, b| a.shift_sigma.abs().total_cmp(&b.shift_sigma.abs()))?;
    Some(format!(
        "Without {} the fit gives {} as {} instead of {}{}, {} standard deviations off.",
        if diagnosis.effects.len() > 1 { "the effects" } else { "the effect" },
        most.name,
        short(most.before),
        short(most.after),
        unit(&parameter_unit(plant, &most.name)),
        short(most.shift_sigma.abs())
    ))
}

/// SI unit of a parameter of the plant; empty where it has none, or is of one recording alone.
pub fn parameter_unit(plant: &Plant, name: &str) -> String {
    let all = plant.parameters();
    all.into_iter().find(|own| own.name == name).map_or(String::new(), |own| own.unit)
}

fn sentence_within(text: &str) -> String {
    if text.ends_with('.') { text.to_owned() } else { format!("{text}.") }
}

/// Detection limits of what was not found.
pub fn not_found(diagnosis: &Diagnosis) -> Vec<&DetectionLimit> {
    let found = |l: &DetectionLimit| diagnosis.effects.iter().any(|e| e.kind == l.kind && e.site == l.site);
    diagnosis.detection_limits.iter().filter(|l| l.amplitude.is_finite() && !found(l)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_of_a_noise_says_what_it_is_a_factor_of() {
        let said = noise_in_words("not as stated: angle x0.99, pole 0.90, extra x1.2; more");
        assert_eq!(
            said,
            "not as stated: angle 0.99 times the stated noise, pole 0.90, extra 1.2 times the stated noise; more"
        );
    }
}
