//! The diagnosis for a terminal.

use super::answer::answer;
use super::names::{in_titles, named, site_in_words, unit};
use super::paragraph::{
    details_paragraph, gain_words, held_out_words, not_found, parameter_unit, percent, verdict_words,
};
use super::{Diagnosed, summary};
use crate::notes::counted;
use crate::recordings::{Loaded, wrapped};
use discovery::diagnose::{Diagnosis, EffectReport};
use dynamics::description::Plant;
use examination::doctor::{Severity, probability};
use identification::held_out::Status;
use report::text::{short, with_sigma};
use std::fmt::Write;

/// Detection limits that are printed; the JSON and the page hold all.
const LIMITS_PRINTED: usize = 5;
/// Rows of the plant's parameters that are printed: those that moved most.
const PARAMETERS_PRINTED: usize = 12;

/// The diagnosis as text for a terminal; `written`: files were written with `--out`, so that the
/// next steps can name them.
pub fn in_words(diagnosed: &Diagnosed, written: bool) -> String {
    let Diagnosed { case, findings, diagnosis, .. } = diagnosed;
    let mut text: String = answer(diagnosed).iter().map(|sentence| wrapped(sentence, "")).collect();
    text.push_str(&summary::in_words(diagnosed));
    text.push_str("\n--- details ---\n");
    for (what, loaded) in [("", &case.fitted), ("held out  ", &case.held_out)] {
        loaded.iter().for_each(|one| text.push_str(&recording(what, one)));
    }
    let counted = |severity| findings.iter().filter(|(_, finding)| finding.severity == severity).count();
    let (faults, warnings) = (counted(Severity::Fault), counted(Severity::Warning));
    if faults + warnings > 0 {
        let _ = writeln!(
            text,
            "  doctor: {}, {}; `obsid doctor` lists them with their cures",
            number_of(faults, "fault"),
            number_of(warnings, "warning")
        );
    }
    let _ = writeln!(text, "\nverdict: {}", verdict_words(diagnosis.verdict));
    text.push_str(&wrapped(&details_paragraph(diagnosis, &case.plant), "  "));
    diagnosis.effects.iter().for_each(|e| text.push_str(&effect(e)));
    text.push_str(&places(diagnosis));
    text.push_str(&nominal(diagnosis, &case.plant));
    text.push_str(&held_out(diagnosis));
    text.push_str(&compare(diagnosis));
    text.push_str(&limits(diagnosis));
    text.push_str(&rest(diagnosis, written));
    text
}

fn recording(what: &str, loaded: &Loaded) -> String {
    let mut text = format!("{what}{}: {}\n", loaded.recording.name, loaded.in_words());
    counted(&loaded.notes).iter().for_each(|note| text.push_str(&wrapped(&format!("note: {note}"), "  ")));
    text
}

/// `confirmed`, `not converged`.
pub fn status_words(status: Status) -> &'static str {
    match status {
        Status::Confirmed => "confirmed",
        Status::Unconfirmed => "unconfirmed",
        Status::Rejected => "rejected",
        Status::NotConverged => "detected, model not converged",
    }
}

fn effect(effect: &EffectReport) -> String {
    let mut text = format!(
        "\n{} ({}@{}): {}",
        named(&effect.kind, &effect.site),
        effect.kind,
        effect.site,
        status_words(effect.status)
    );
    if effect.status != Status::NotConverged {
        let _ = write!(text, ", probability {:.2}", effect.probability);
    }
    let _ = writeln!(
        text,
        ", {} standard errors from zero, {} % collinear with the plant's parameters",
        short(effect.d),
        short(100.0 * effect.kappa)
    );
    for p in &effect.parameters {
        let (value, sigma) = with_sigma(p.value, p.sigma);
        let _ = writeln!(text, "  {:<24} {value:>14} ± {sigma}{}", p.name, unit(&p.unit));
    }
    for rival in &effect.rivals {
        let line = format!(
            "rival {}, probability {:.2}: {}",
            named(&rival.kind, &rival.site),
            rival.probability,
            rival.reason
        );
        text.push_str(&wrapped(&line, "  "));
    }
    text
}

fn places(diagnosis: &Diagnosis) -> String {
    let mut text = String::new();
    for place in &diagnosis.located {
        let ([from, to], [low, high]) = (place.time.map(short), place.band_hz.map(short));
        let p = probability(place.p);
        let states =
            if place.states.is_empty() { String::new() } else { format!(", over {}", place.states.join(", ")) };
        let channel = if place.channel.is_empty() { String::new() } else { format!("{} ", place.channel) };
        let line = format!(
            "where: {channel}at {}, {from} to {to} s, {low} to {high} Hz{states}, {p}",
            site_in_words(&place.site)
        );
        let _ = writeln!(text, "\n{line}");
    }
    text
}

fn nominal(diagnosis: &Diagnosis, plant: &Plant) -> String {
    let mut rows: Vec<_> = diagnosis.nominal.iter().collect();
    if rows.is_empty() {
        return String::new();
    }
    rows.sort_by(|a, b| b.shift_sigma.abs().total_cmp(&a.shift_sigma.abs()));
    let mut text = format!(
        "\n{:<34} {:>14} {:>14} {:>12} {:>12}\n",
        "parameter of the plant", "before", "after", "sd", "shift [sd]"
    );
    for row in rows.iter().take(PARAMETERS_PRINTED) {
        let (after, sigma) = with_sigma(row.after, row.sigma);
        let _ = writeln!(
            text,
            "{:<34} {:>14} {after:>14} {sigma:>12} {:>12}",
            with_unit(plant, &row.name),
            short(row.before),
            short(row.shift_sigma)
        );
    }
    if rows.len() > PARAMETERS_PRINTED {
        let _ = writeln!(text, "  and {} more", rows.len() - PARAMETERS_PRINTED);
    }
    text
}

/// `disc.inertia [kg m²]`.
fn with_unit(plant: &Plant, name: &str) -> String {
    match unit(&parameter_unit(plant, name)).trim_start() {
        "" => name.to_owned(),
        unit => format!("{name} [{unit}]"),
    }
}

/// `no faults`, `1 warning`, `3 warnings`.
fn number_of(count: usize, what: &str) -> String {
    match count {
        0 => format!("no {what}s"),
        1 => format!("1 {what}"),
        n => format!("{n} {what}s"),
    }
}

fn held_out(diagnosis: &Diagnosis) -> String {
    let held = &diagnosis.held_out;
    let Some(on) = held_out_words(held.kind) else { return String::new() };
    let mut text = format!("\nheld out: {on}\n");
    let _ =
        writeln!(text, "{:<26} {:>14} {:>14} {:>14} {:>14}", "channel", "fit % before", "after", "rms before", "after");
    for c in &held.channels {
        let _ = writeln!(
            text,
            "{:<26} {:>14} {:>14} {:>14} {:>14}",
            c.name,
            percent(c.fit_percent_before),
            percent(c.fit_percent_after),
            short(c.rms_before),
            short(c.rms_after)
        );
    }
    if let Some(gain) = gain_words(diagnosis) {
        let _ = writeln!(text, "  {gain}");
    }
    if let (Some(before), Some(after)) = (held.whiteness_p_before, held.whiteness_p_after) {
        let _ = writeln!(text, "  innovations white: {} before, {} after", probability(before), probability(after));
    }
    text
}

/// Free run of the nominal plant, where nothing was held out.
fn compare(diagnosis: &Diagnosis) -> String {
    if diagnosis.compare.channels.is_empty() || !diagnosis.held_out.channels.is_empty() {
        return String::new();
    }
    let mut text = format!("\n{:<26} {:>14} {:>14}\n", "free run of the plant", "rms", "fit %");
    for c in &diagnosis.compare.channels {
        let _ = writeln!(text, "{:<26} {:>14} {:>14}", c.name, short(c.rms), percent(c.fit_percent));
    }
    text
}

fn limits(diagnosis: &Diagnosis) -> String {
    let all = not_found(diagnosis);
    if all.is_empty() {
        return String::new();
    }
    let mut text = String::from("\neffects that are not found, and the least size that would have been found\n");
    for limit in all.iter().take(LIMITS_PRINTED) {
        let name = named(&limit.kind, &limit.site);
        let _ = writeln!(text, "  {name:<48} {:>12}{}", short(limit.amplitude), unit(&limit.unit));
    }
    if all.len() > LIMITS_PRINTED {
        let _ = writeln!(text, "  and {} more (--json, or the page of --out)", all.len() - LIMITS_PRINTED);
    }
    text
}

fn rest(diagnosis: &Diagnosis, written: bool) -> String {
    let mut text = String::new();
    if !diagnosis.not_found.is_empty() {
        text.push('\n');
        text.push_str(&wrapped(
            &format!("parameters that these data do not determine: {}", diagnosis.not_found.join(", ")),
            "",
        ));
    }
    for note in counted(&diagnosis.notes) {
        text.push_str(&wrapped(&format!("note: {}", in_titles(&note)), ""));
    }
    text.push('\n');
    for (what, path) in [
        ("augmented plant", &diagnosis.augmented_plant),
        ("next experiment", &diagnosis.next_experiment),
        ("report", &diagnosis.report),
    ] {
        if let Some(path) = path {
            let _ = writeln!(text, "{what:<16} {path}");
        }
    }
    if !written {
        text.push_str("nothing was written; --out DIR writes the page, the augmented plant and the next experiment\n");
    }
    text
}
