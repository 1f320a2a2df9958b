//! The estimate as tables for a terminal.

use super::object::status;
use super::{Identified, conflicts};
use crate::recordings::wrapped;
use examination::doctor::probability;
use report::text::{short, with_sigma};
use std::fmt::Write;

/// Level below which a recording is said to contradict the others.
const CONTRADICTS_P: f64 = 1e-3;

/// First what the recordings say of each other, then every number.
pub fn in_words(found: &Identified<'_>) -> String {
    let mut text = first_lines(found);
    recordings(found, &mut text);
    let _ = writeln!(
        text,
        "\n{:<34} {:<10} {:>16} {:>12} {:>14} {:>12}  status",
        "parameter", "unit", "value", "sigma", "prior", "sigma"
    );
    let mut row = |name: &str, unit: &str, [value, sigma, prior, prior_sigma]: [f64; 4]| {
        let (shown, shown_sigma) = with_sigma(value, sigma);
        let status = status(sigma, prior_sigma);
        let _ = writeln!(
            text,
            "{name:<34} {unit:<10} {shown:>16} {shown_sigma:>12} {:>14} {:>12}  {status}",
            short(prior),
            short(prior_sigma)
        );
    };
    for (k, unknown) in found.vehicle.unknowns.iter().enumerate() {
        row(&unknown.name, &unknown.unit, [found.fit.theta[k], found.fit.sigma[k], unknown.prior, unknown.sigma]);
    }
    for base in &found.base {
        row(&base.name, base.unit, [base.value, base.sigma, base.prior, base.prior_sigma]);
    }
    text
}

fn first_lines(found: &Identified<'_>) -> String {
    let (sigma, unknowns) = (&found.fit.sigma, &found.vehicle.unknowns);
    let identified = sigma.iter().zip(unknowns).filter(|(s, u)| status(**s, u.sigma) == "identified").count();
    let count = found.read.len();
    let mut text = format!(
        "{identified} of {} numbers identified from {count} recording{}\n",
        unknowns.len(),
        if count == 1 { "" } else { "s" }
    );
    if found.fit.interrupted {
        text.push_str("INTERRUPTED: what is known so far, of the recordings and their beginnings that were heard\n");
    } else if !found.fit.converged {
        text.push_str(
            "NOT CONVERGED: the estimates may be far from the maximum; give narrower priors or longer recordings\n",
        );
    }
    text.push_str(&conflicts::in_words(&found.conflicts()));
    text
}

fn recordings(found: &Identified<'_>, text: &mut String) {
    let _ = writeln!(
        text,
        "\n{:<34} {:>9} {:>12} {:>12}  with the others",
        "recording", "rows", "chi2 per row", "sigmas off 1"
    );
    for ((one, message), agreement) in found.read.iter().zip(&found.fit.messages).zip(&found.fit.agreement) {
        let rows = message.rows.max(1) as f64;
        let chi2 = message.chi2 / rows;
        let off = (chi2 - 1.0) / libm::sqrt(2.0 / rows);
        let others = agreement.map_or("-".to_owned(), |found| {
            let verdict = if found.p < CONTRADICTS_P { "contradicts" } else { "agrees" };
            format!("{verdict}, {}", probability(found.p))
        });
        let _ = writeln!(text, "{:<34} {:>9} {chi2:>12.4} {off:>12.1}  {others}", one.arc.name, message.rows);
        for note in crate::notes::counted(&one.notes) {
            text.push_str(&wrapped(&format!("note: {note}"), "  "));
        }
    }
    for (one, chi2) in &found.predicted {
        let _ = writeln!(text, "{:<34} {:>9} {chi2:>12.4} {:>12}  predicted, not fitted", one.arc.name, "", "");
    }
}
