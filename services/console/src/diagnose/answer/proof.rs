//! The second sentence: on which data, in which channel, from what to what.

use super::{Diagnosed, beside_labels, first_clause, in_titles, sentence, supported, titled};
use crate::diagnose::paragraph::{gain_words, percent};
use discovery::diagnose::{Diagnosis, HeldOutChannel, HeldOutKind, Verdict, Where};
use discovery::mislabelled::Mislabelled;
use examination::doctor::probability;
use identification::held_out::{ChannelFit, Status};
use report::text::short;

/// Names of recordings that a sentence holds.
const NAMES_MAX: usize = 3;

/// The evidence for the first sentence.
pub fn proof(diagnosed: &Diagnosed) -> String {
    let diagnosis = &diagnosed.diagnosis;
    if let (Some(label), true) = (diagnosed.labels.first(), supported(diagnosis).is_empty()) {
        return corrected(label);
    }
    match diagnosis.verdict {
        Verdict::Named | Verdict::Sensor | Verdict::NotSeparable => held_out(diagnosed),
        Verdict::NotInCatalogue => law(diagnosed),
        Verdict::NoiseModel | Verdict::ParameterConflict | Verdict::InputTiming => beside_noise(diagnosed),
        Verdict::CannotDecide => undecided(diagnosed),
        Verdict::None => alone(diagnosed),
    }
}

/// What the correction of the label does to the innovations.
fn corrected(label: &Mislabelled) -> String {
    let after = short(label.after);
    let name = &label.recording;
    if label.before.is_finite() {
        let before = short(label.before);
        return format!(
            "the correction takes the innovations of {name} from {before} to {after} stated standard deviations"
        );
    }
    format!("as labelled the plant cannot follow {name}, and corrected it leaves {after} stated standard deviations")
}

/// What was held out: `slew2.csv, not used in fitting,`.
pub fn held_out_name(diagnosed: &Diagnosed) -> Option<String> {
    let case = &diagnosed.case;
    let names = |loaded: &[crate::recordings::Loaded]| {
        let mut all: Vec<String> = loaded.iter().map(|one| one.recording.name.clone()).collect();
        let more = all.len().saturating_sub(NAMES_MAX);
        all.truncate(NAMES_MAX);
        if more > 0 {
            all.push(format!("{more} more"));
        }
        all.join(" and ")
    };
    match diagnosed.diagnosis.held_out.kind {
        HeldOutKind::Recording => Some(format!("{}, not used in fitting,", names(&case.held_out))),
        HeldOutKind::Blocks if case.fitted.is_empty() => Some("the upper modes, predicted from the lower ones,".into()),
        HeldOutKind::Blocks => Some(format!("blocks of {}, predicted from the others,", names(&case.fitted))),
        HeldOutKind::None => None,
    }
}

/// The channel whose held-out fit rises most.
fn best(diagnosis: &Diagnosis) -> Option<&HeldOutChannel> {
    let rise = |c: &HeldOutChannel| c.fit_percent_after - c.fit_percent_before;
    let rising = diagnosis.held_out.channels.iter().filter(|c| rise(c).is_finite() && rise(c) > 0.0);
    rising.max_by(|a, b| rise(a).total_cmp(&rise(b)))
}

/// The channel of the most significant time–frequency bin: its name and standard errors without
/// and with the effects.
fn most_significant(diagnosis: &Diagnosis) -> Option<(&str, f64, f64)> {
    let tiles = diagnosis.figures.tiles.iter().filter(|t| t.z_before.is_finite() && t.z_after.is_finite());
    let most = tiles.max_by(|a, b| a.z_before.total_cmp(&b.z_before))?;
    Some((&most.channel, most.z_before, most.z_after))
}

/// Fit of the channel that matters, and whether held-out data confirm the effects.
fn held_out(diagnosed: &Diagnosed) -> String {
    let diagnosis = &diagnosed.diagnosis;
    let supported = supported(diagnosis);
    let (they, raise) = match &supported[..] {
        // of several candidates the first is the one that was added
        [one] if diagnosis.verdict == Verdict::NotSeparable => (titled(&one.title, &one.site), "raises"),
        [_] => ("it".to_owned(), "raises"),
        _ => ("they".to_owned(), "raise"),
    };
    let Some(on) = held_out_name(diagnosed) else {
        return match most_significant(diagnosis).filter(|(_, before, after)| after < before) {
            Some((channel, before, after)) => format!(
                "no data were held out; {they} {} the innovations of {channel} from {} to {} standard errors",
                if supported.len() == 1 { "takes" } else { "take" },
                short(before),
                short(after)
            ),
            None => format!("no data were held out to confirm {}", if supported.len() == 1 { "it" } else { "them" }),
        };
    };
    let open = supported.iter().any(|effect| effect.status != Status::Confirmed);
    let but = if open { "; held-out data do not confirm every effect yet" } else { "" };
    if let Some(c) = best(diagnosis) {
        let (before, after) = (percent(c.fit_percent_before), percent(c.fit_percent_after));
        return format!("{they} {raise} the fit of {} in {on} from {before} to {after} %{but}", c.name);
    }
    match (most_significant(diagnosis).filter(|(_, before, after)| after < before), gain_words(diagnosis)) {
        (_, Some(gain)) if diagnosis.held_out.gain_ci95.is_none_or(|[low, _]| low > 0.0) => {
            format!("in {on} the fit of no free run rises, and that of one-step predictions does: {gain}{but}")
        }
        (_, Some(gain)) => format!("in {on} neither free runs nor one-step predictions show it: {gain}{but}"),
        (Some((channel, before, after)), None) => format!(
            "the innovations of {channel} fall from {} to {} standard errors, and in {on} the fit of no free run rises{but}",
            short(before),
            short(after)
        ),
        (None, None) => format!("in {on} the fit of no free run rises{but}"),
    }
}

/// The gain of a law on parts that it was not fitted to, or the significance of a drift.
fn law(diagnosed: &Diagnosed) -> String {
    let diagnosis = &diagnosed.diagnosis;
    if let (Some(gain), Some(on)) = (gain_words(diagnosis), held_out_name(diagnosed)) {
        return format!("it predicts {on} with a {gain}");
    }
    match diagnosis.located.last() {
        Some(place) => shows(place),
        None => "the reason below holds the evidence".into(),
    }
}

/// `the frequency over the parts shows it from 0 to 20 s (p < 1e-12)`.
fn shows(place: &Where) -> String {
    let channel = if place.channel.is_empty() { &place.site } else { &place.channel };
    let [from, to] = place.time.map(short);
    let when = if place.time[1] > place.time[0] { format!(" from {from} to {to} s") } else { String::new() };
    format!("the {channel} shows it{when} ({})", probability(place.p))
}

fn beside_noise(diagnosed: &Diagnosed) -> String {
    if diagnosed.interrupted {
        return "the interruption came before all effects were compared".into();
    }
    match diagnosed.diagnosis.located.last() {
        Some(place) => format!("{}, and no other effect of the catalogue is significant", shows(place)),
        None => "with this noise no effect of the catalogue is significant".into(),
    }
}

/// Why nothing is decided: held-out numbers, else the second clause of the reason.
fn undecided(diagnosed: &Diagnosed) -> String {
    let diagnosis = &diagnosed.diagnosis;
    if let (Some(on), Some(gain)) = (held_out_name(diagnosed), gain_words(diagnosis)) {
        return format!("{on} show a {gain}");
    }
    let second = beside_labels(&diagnosis.reason).split("; ").nth(1).filter(|clause| !clause.is_empty());
    match (second, diagnosis.located.last()) {
        (_, Some(place)) => shows(place),
        (Some(clause), None) => in_titles(clause),
        (None, None) => "no effect was accepted, so there is none that held-out data could confirm".into(),
    }
}

/// The plant alone: its worst channel, or for modes the reason.
fn alone(diagnosed: &Diagnosed) -> String {
    let diagnosis = &diagnosed.diagnosis;
    if diagnosed.case.fitted.is_empty() {
        return first_clause(&diagnosis.reason);
    }
    let fit = |c: &&ChannelFit| c.fit_percent.is_finite();
    let worst = diagnosis.compare.channels.iter().filter(fit).min_by(|a, b| a.fit_percent.total_cmp(&b.fit_percent));
    match worst {
        Some(c) => format!(
            "no effect of the catalogue is significant, and in free run the plant fits {} to {} %{}",
            c.name,
            percent(c.fit_percent),
            if diagnosis.compare.channels.len() > 1 { ", its worst channel" } else { "" }
        ),
        None => sentence("no effect of the catalogue is significant"),
    }
}
