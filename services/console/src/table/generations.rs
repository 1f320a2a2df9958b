//! One craft, identified by all its arcs, as a table for a terminal.

use crate::identify::conflicts;
use crate::outcome::JointOutcome;
use report::text::{short, with_sigma};
use std::fmt::Write;

/// The last generation's parameters beside the truth, what the arcs say of each other, the verdict.
pub fn write(found: &JointOutcome, text: &mut String) {
    let Some(last) = found.generations.last() else { return };
    let _ = writeln!(
        text,
        "\n{:<9} {:<26} {:<10} {:>13} {:>13} {:>16} {:>11} {:>6}  status",
        "block", "parameter", "unit", "truth", "prior", "estimate", "sigma", "z"
    );
    for row in &last.rows {
        let (value, sigma) = with_sigma(row.value, row.sigma);
        let _ = writeln!(
            text,
            "{:<9} {:<26} {:<10} {:>13} {:>13} {value:>16} {sigma:>11} {:>6.2}  {}",
            row.block,
            row.name,
            row.unit,
            short(row.truth),
            short(row.prior),
            row.z(),
            row.status
        );
    }
    let _ = writeln!(text, "\n{:<6} {:>12}  p against the others, per block", "arc", "chi2 per row");
    for arc in &last.arcs {
        let between = arc.p_between.iter().map(|(block, p)| format!("{block} {}", short(*p)));
        let between = between.collect::<Vec<_>>().join(", ");
        let _ = writeln!(text, "{:<6} {:>12.4}  {between}", arc.arc, arc.chi2_per_row);
    }
    if let Some((arc, chi2, p)) = &found.predicted {
        let _ = writeln!(text, "{arc:<6} {chi2:>12.4}  predicted, not fitted: p {}", short(*p));
    }
    let ratio = found.bound_ratio().map_or(String::new(), |ratio| format!("; error over sigma {ratio:.2} rms"));
    let generations = found.generations.len();
    let _ = writeln!(text, "{} after {generations} generations{ratio}", found.words());
    text.push_str(&conflicts::in_words(&found.conflicts()));
    if let Some(missing) = &found.missing {
        let _ = writeln!(text, "{}", missing.words());
    }
}
