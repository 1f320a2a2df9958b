//! The estimate as one JSON object.

use super::{Identified, conflicts};
use estimation::identifiability::Identifiability;
use serde_json::{Value, json};

/// `parameters[]`, `arcs[]`, `predicted[]` and what else the estimate holds.
pub fn object(found: &Identified<'_>, command: &str) -> Value {
    let (vehicle, fit) = (found.vehicle, &found.fit);
    let physical = vehicle.unknowns.iter().enumerate().map(|(k, unknown)| {
        json!({ "name": unknown.name, "kind": "physical", "unit": unknown.unit, "value": fit.theta[k], "sigma": fit.sigma[k],
            "prior": unknown.prior, "prior_sigma": unknown.sigma, "status": status(fit.sigma[k], unknown.sigma) })
    });
    let base = found.base.iter().map(|row| {
        json!({ "name": row.name, "kind": "base", "unit": row.unit, "value": row.value, "sigma": row.sigma,
            "prior": row.prior, "prior_sigma": row.prior_sigma, "status": status(row.sigma, row.prior_sigma) })
    });
    let parameters: Vec<Value> = physical.chain(base).collect();
    let arcs = found.read.iter().zip(&fit.messages).zip(&fit.agreement).map(|((one, message), agreement)| {
        json!({ "recording": one.file, "name": one.arc.name, "plant": one.plant_file, "digest": one.digest, "rows": message.rows,
            "chi2_per_row": message.chi2 / message.rows.max(1) as f64, "p_between": agreement.map(|a| a.p),
            "chi2_between": agreement.map(|a| a.chi2), "freedom_between": agreement.map(|a| a.freedom), "notes": one.notes })
    });
    let predicted = found.predicted.iter().map(|(one, chi2)| {
        json!({ "recording": one.file, "name": one.arc.name, "plant": one.plant_file, "digest": one.digest, "chi2_per_row": chi2 })
    });
    json!({ "command": command, "converged": fit.converged, "interrupted": fit.interrupted, "parameters": parameters,
        "prior_conflicts": conflicts::object(&found.conflicts()),
        "arcs": arcs.collect::<Vec<_>>(), "predicted": predicted.collect::<Vec<_>>() })
}

/// What the recordings did to the prior.
pub fn status(sigma: f64, prior_sigma: f64) -> &'static str {
    if prior_sigma > 0.0 { Identifiability::of(sigma, prior_sigma).text() } else { "known" }
}
