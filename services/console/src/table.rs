//! Tables for a terminal: aligned on the decimal point, with sigmas.

mod generations;

use crate::outcome::{FoundNumber, Outcome, ParameterRow};
use crate::scenario_run::LinkKind;
use std::fmt::Write;
use telemetry::{Domain, PartitionId};

/// The table a run ends with.
#[must_use]
pub fn outcome(outcome: &Outcome) -> String {
    let mut text = completion(outcome);
    modes(outcome, &mut text);
    match &outcome.joint {
        Some(found) => generations::write(found, &mut text),
        None => parameters(outcome, &mut text),
    }
    partitions(outcome, &mut text);
    lost_domains(outcome, &mut text);
    let digest = outcome.digest.as_deref().unwrap_or("none: nothing was recorded");
    let _ = writeln!(text, "\ndigest {digest}\nwall time {:.1} s", outcome.wall_s);
    text
}

/// Whether the run got to its end with all that it was to deliver, in a line.
fn completion(outcome: &Outcome) -> String {
    let losses: Vec<String> = outcome.losses().iter().map(ToString::to_string).collect();
    match (&outcome.failure, losses.is_empty()) {
        (Some(failure), true) => format!("NOT COMPLETED: {failure}\n\n"),
        (Some(failure), false) => format!("NOT COMPLETED: {failure}; {}\n\n", losses.join("; ")),
        (None, true) => "completed, nothing lost\n\n".into(),
        (None, false) => format!("DEGRADED: {}\n\n", losses.join("; ")),
    }
}

fn modes(outcome: &Outcome, text: &mut String) {
    let _ = writeln!(text, "{:>9} {:>9}  {:<22} {:<22} cause", "frame", "t [s]", "from", "to");
    for row in &outcome.modes {
        let _ = writeln!(text, "{:>9} {:>9.2}  {:<22} {:<22} {}", row.frame, row.t_s, row.from, row.to, row.cause);
    }
}

fn parameters(outcome: &Outcome, text: &mut String) {
    let _ = writeln!(
        text,
        "\n{:<9} {:<12} {:<6} {:<8} {:>14} {:>28} {:>10} {:>10}",
        "domain", "phase", "name", "unit", "truth", "estimate +- sigma", "error %", "paper %"
    );
    for row in &outcome.parameters {
        number(row.domain.text(), row.phase.text(), &row.number, &row.remark(), text);
    }
    for (domain, rows) in [("torques", &outcome.arm.torques), ("target", &outcome.arm.target)] {
        rows.iter().for_each(|row| number(domain, row.of, &row.number, row.remark, text));
    }
    for row in one_per_model(&outcome.parameters) {
        let _ = writeln!(
            text,
            "{:<9} {:<12} complete {:<3} adequate {:<3} accepted {:<3}  {}",
            row.domain,
            row.phase,
            yes(row.complete),
            yes(row.adequate),
            yes(row.accepted),
            row.reason
        );
    }
    for row in &outcome.comparisons {
        let _ = writeln!(text, "{:<9} {:<12} {}", "both", row.phase, row.reason);
    }
}

/// A line of the table: whose number it is, of which phase or origin, the number, and what is to be
/// said of it.
fn number(domain: &str, of: &str, number: &FoundNumber, remark: &str, text: &mut String) {
    let line = format!(
        "{domain:<9} {of:<12} {:<6} {:<8} {:>14} {:>28} {:>10} {:>10}  {remark}",
        number.name,
        number.unit,
        optional(number.truth, 6),
        with_sigma(number.value, number.sigma),
        optional(number.error_percent(), 4),
        optional(number.paper_error_percent, 2),
    );
    let _ = writeln!(text, "{}", line.trim_end());
}

fn one_per_model(rows: &[ParameterRow]) -> impl Iterator<Item = &ParameterRow> {
    rows.iter()
        .enumerate()
        .filter(|(i, row)| *i == 0 || (rows[i - 1].domain, rows[i - 1].phase) != (row.domain, row.phase))
        .map(|(_, row)| row)
}

fn partitions(outcome: &Outcome, text: &mut String) {
    let _ = writeln!(
        text,
        "\n{:<12} {:>10} {:>6} {:>9} {:>5} {:>8} {:>12} {:>12} {:>7}  state",
        "partition", "received", "lost", "restarts", "bad", "frames", "p50 [us]", "p99 [us]", "CPU %"
    );
    for row in &outcome.partitions {
        let wire =
            |value: f64| if outcome.link == LinkKind::Lockstep { "-".to_string() } else { format!("{value:.1}") };
        let _ = writeln!(
            text,
            "{:<12} {:>10} {:>6} {:>9} {:>5} {:>8} {:>12} {:>12} {:>7}  {}",
            row.name,
            row.received,
            row.lost,
            row.restarts,
            row.bad,
            row.frames,
            wire(row.latency_us_p50),
            wire(row.latency_us_p99),
            wire(row.cpu_percent),
            if row.given_up { "given up" } else { "kept" }
        );
    }
}

/// Without its estimator a domain has no results from then on; the run goes on without it.
fn lost_domains(outcome: &Outcome, text: &mut String) {
    let estimators = [
        (PartitionId::InertialId, Domain::Inertial),
        (PartitionId::SloshId, Domain::Slosh),
        (PartitionId::ModalId, Domain::Modal),
    ];
    for row in outcome.partitions.iter().filter(|row| row.given_up) {
        let domain = estimators.iter().find(|(id, _)| id.text() == row.name);
        let lost = domain.map_or(String::new(), |(_, domain)| format!(": no {domain} results from then on"));
        let _ = writeln!(text, "\n{} was given up after {} restarts{lost}", row.name, row.restarts);
    }
}

fn optional(value: Option<f64>, decimals: usize) -> String {
    value.map_or("-".into(), |value| format!("{value:.decimals$}"))
}

fn yes(value: Option<bool>) -> &'static str {
    match value {
        Some(true) => "yes",
        Some(false) => "no",
        None => "?",
    }
}

/// Value and sigma with the decimals that the sigma gives meaning to.
fn with_sigma(value: Option<f64>, sigma: Option<f64>) -> String {
    let (Some(value), Some(sigma)) = (value, sigma) else { return "-".into() };
    let decimals =
        if sigma > 0.0 && sigma.is_finite() { (1.0 - sigma.log10().floor()).clamp(0.0, 12.0) as usize } else { 6 };
    format!("{value:.decimals$} +- {sigma:.decimals$}")
}
