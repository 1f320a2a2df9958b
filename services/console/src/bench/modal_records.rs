//! `obsid bench modal-records`: a line per kind of defect, per kind of frequency responses, and per
//! kind of known input.

use super::{Answers, Arguments, ask};
use crate::Failure;
use bench::modal_records::defects::Defect;
use bench::modal_records::{Figures, figures, known_input, names, responses};
use serde_json::json;
use std::fmt::Write;

pub(super) fn measure(arguments: &Arguments, to: &mut Answers) -> Result<(), Failure> {
    ask("kind", &arguments.kind, &names())?;
    let wanted = |name: &str| arguments.kind.is_empty() || arguments.kind.iter().any(|kind| kind == name);
    let (trials, seed) = (arguments.trials, arguments.seed);
    let defects = Defect::ALL.into_iter().filter(|defect| wanted(defect.name()));
    let all: Vec<Figures> = defects.map(|defect| figures(defect, trials, seed)).collect();
    let rows = responses::run(wanted, trials as usize, seed);
    let inputs = known_input::run(wanted, trials as usize, seed);
    let object = || {
        let all =
            json!({ "problem": "modal-records", "seed": seed, "kinds": all, "responses": rows, "known_input": inputs });
        format!("{all}\n")
    };
    let marked = [markdown(&all, &rows), inputs_in_markdown(&inputs)];
    let marked: Vec<String> = marked.into_iter().filter(|table| !table.is_empty()).collect();
    to.add(|| table(&all) + &of_responses(&rows) + &of_inputs(&inputs), Some(marked.join("\n")), object);
    Ok(())
}

fn of_inputs(rows: &[known_input::Row]) -> String {
    let mut text = String::new();
    for row in rows {
        let _ = writeln!(
            text,
            "{:22} modes {:>4}  missed {:>3}  invented {:>3}  no model {:>3}  mean z {:>5.2} {:>5.2}  rms z {:>5.2} {:>5.2}",
            row.kind,
            row.modes,
            row.missed,
            row.invented,
            row.not_adequate + row.conditional,
            row.mean_z_frequency,
            row.mean_z_damping,
            row.rms_z_frequency,
            row.rms_z_damping
        );
    }
    text
}

fn inputs_in_markdown(rows: &[known_input::Row]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let mut text = "| known input | records | modes | missed | invented | no model is right, or with a condition | mean z of f, zeta | rms z of f, zeta | in 95 % intervals |\n|---|---|---|---|---|---|---|---|---|\n".to_owned();
    for row in rows {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {}, {} | {:.2} {:.2} | {:.2} {:.2} | {:.1} {:.1} |",
            row.kind,
            row.trials,
            row.modes,
            row.missed,
            row.invented,
            row.not_adequate,
            row.conditional,
            row.mean_z_frequency,
            row.mean_z_damping,
            row.rms_z_frequency,
            row.rms_z_damping,
            100.0 * row.coverage_frequency,
            100.0 * row.coverage_damping
        );
    }
    text
}

fn of_responses(rows: &[responses::Row]) -> String {
    let mut text = String::new();
    for row in rows {
        let percent = |part: usize| 100.0 * part as f64 / row.modes.max(1) as f64;
        let _ = writeln!(
            text,
            "{:18} {:>6} {:>8.1} {:>10.1} {:>6.2} {:>6.2} {:>6.1} {:>6.1}",
            row.kind,
            row.modes,
            percent(row.missed),
            percent(row.invented),
            row.frequency_rms_z,
            row.damping_rms_z,
            100.0 * row.frequency_coverage,
            100.0 * row.damping_coverage
        );
    }
    text
}

fn markdown(all: &[Figures], rows: &[responses::Row]) -> String {
    if all.is_empty() && rows.is_empty() {
        return String::new();
    }
    let mut text = "| kind | modes | missed [%] | invented [%] | rms z of f, zeta | in 95 % intervals | tones named [%] | mode beside right or hidden [%] |\n|---|---|---|---|---|---|---|---|\n".to_owned();
    for f in all {
        let [missed, invented, f_rms, zeta_rms, f_held, zeta_held, named, beside] = in_words(f);
        let _ = writeln!(
            text,
            "| {} | {} | {missed} | {invented} | {f_rms} {zeta_rms} | {f_held} {zeta_held} | {named} | {beside} |",
            f.defect, f.modes
        );
    }
    for row in rows {
        let percent = |part: usize| 100.0 * part as f64 / row.modes.max(1) as f64;
        let _ = writeln!(
            text,
            "| {} | {} | {:.1} | {:.1} | {:.2} {:.2} | {:.1} {:.1} | – | – |",
            row.kind,
            row.modes,
            percent(row.missed),
            percent(row.invented),
            row.frequency_rms_z,
            row.damping_rms_z,
            100.0 * row.frequency_coverage,
            100.0 * row.damping_coverage
        );
    }
    text
}

/// Missed and invented, rms z, in intervals, and of tones: `–` for a share of nothing.
fn in_words(f: &Figures) -> [String; 8] {
    let shares = [f.missed_percent, f.invented_percent];
    let honesty = [f.frequency_coverage_percent, f.damping_coverage_percent];
    let tones = [f.tones_named_percent, f.beside_right_percent];
    let word = |value: Option<f64>, decimals: usize| {
        value.map_or_else(|| "–".to_owned(), |value| format!("{value:.decimals$}"))
    };
    let [[missed, invented], [f_held, zeta_held], [named, beside]] =
        [shares, honesty, tones].map(|pair| pair.map(|value| word(value, 1)));
    let [f_rms, zeta_rms] = [f.frequency_rms_z, f.damping_rms_z].map(|value| word(value, 2));
    [missed, invented, f_rms, zeta_rms, f_held, zeta_held, named, beside]
}

fn table(all: &[Figures]) -> String {
    if all.is_empty() {
        return String::new();
    }
    let mut text = format!(
        "{:18} {:>6} {:>8} {:>10} {:>13} {:>13} {:>9} {:>9}\n",
        "defect", "modes", "missed %", "invented %", "rms z f, damp.", "95 % f, damp.", "tones %", "beside %"
    );
    for f in all {
        let [missed, invented, f_rms, zeta_rms, f_held, zeta_held, named, beside] = in_words(f);
        let _ = writeln!(
            text,
            "{:18} {:>6} {missed:>8} {invented:>10} {f_rms:>6} {zeta_rms:>6} {f_held:>6} {zeta_held:>6} {named:>9} {beside:>9}",
            f.defect, f.modes
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_kind_is_refused_with_those_that_there_are() {
        let refused = ask("kind", &["clear".to_owned()], &names()).unwrap_err();
        let Failure::Input(report) = refused else { panic!("no input error") };
        assert_eq!(report.to_string(), "no kind 'clear'");
        let help = report.help().unwrap().to_string();
        assert!(help.contains("'clean', 'missing rows'") && help.contains("'open loop, random'"), "{help}");
        let mut all = names();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), names().len());
    }

    #[test]
    fn a_share_of_nothing_is_a_dash_and_null() {
        let figures = Figures { defect: "clean", modes: 4, missed_percent: Some(0.0), ..Figures::default() };
        assert_eq!(in_words(&figures), ["0.0", "–", "–", "–", "–", "–", "–", "–"]);
        let json = json!(figures);
        assert!(json["missed_percent"] == 0.0 && json["beside_right_percent"].is_null(), "{json}");
    }
}
