//! The answer as one JSON object.

use super::{Arguments, FoundMode, Outcome, Verdict};
use modal::c64;
use modal::drift::{Drift, Track};
use serde_json::{Value, json};

pub(super) fn as_json(arguments: &Arguments, outcome: &Outcome, written: Option<&str>) -> Value {
    let shape = |mode: &FoundMode| -> Vec<Value> {
        let of = |(name, psi): (&String, &c64)| json!({ "channel": name, "re": psi.re, "im": psi.im });
        outcome.channels.iter().zip(&mode.shape).map(of).collect()
    };
    let shape_sd = |mode: &FoundMode| -> Option<Vec<Value>> {
        let of = |(name, sd): (&String, &c64)| json!({ "channel": name, "re": sd.re, "im": sd.im });
        (!mode.shape_sd.is_empty()).then(|| outcome.channels.iter().zip(&mode.shape_sd).map(of).collect())
    };
    let mode = |(k, mode): (usize, &FoundMode)| {
        let mut object = json!({ "frequency_hz": mode.frequency_hz, "frequency_sd": mode.frequency_sd, "damping": mode.damping,
            "damping_sd": mode.damping_sd, "sd_basis": mode.frequency_sd.map(|_| outcome.deviations),
            "shape": shape(mode), "shape_sd": shape_sd(mode), "mpc": mode.phase_collinearity, "kind": outcome.kind });
        outcome.as_it_is.describe(k, &mut object);
        object
    };
    let rejected: Vec<Value> =
        outcome.rejected.iter().map(|(reason, poles)| json!({ "reason": reason, "poles": poles })).collect();
    let drift = |drift: &Drift| {
        json!({ "frequency_hz": drift.frequency_hz, "frequency_change_hz": drift.frequency_change_hz, "frequency_z": drift.frequency_z,
            "damping": drift.damping_ratio, "damping_change": drift.damping_change, "damping_z": drift.damping_z })
    };
    let track = |track: &Track| {
        let parts = track.points.iter().map(|p| {
            json!({ "begin_s": p.begin_s, "end_s": p.end_s, "amplitude": p.amplitude, "frequency_hz": p.frequency_hz,
                "frequency_sd": p.frequency_sd, "damping": p.damping_ratio, "damping_sd": p.damping_sd })
        });
        json!({ "frequency_hz": track.frequency_hz, "damping": track.damping_ratio, "parts": parts.collect::<Vec<_>>() })
    };
    let residual = |verdict: Verdict| {
        let modal::adequacy::Residual { white, lag1, statistic, degrees, p } = verdict.residual;
        json!({ "white": white, "lag1": lag1, "statistic": statistic, "degrees": degrees, "p": p })
    };
    json!({ "files": arguments.files.iter().map(|f| f.display().to_string()).collect::<Vec<_>>(),
        "method": outcome.method, "kind": outcome.kind, "standard_deviations": outcome.deviations,
        "channels": outcome.channels, "modes": outcome.modes.iter().enumerate().map(mode).collect::<Vec<_>>(),
        "examination": outcome.as_it_is.examination(),
        "model_adequate": outcome.verdict.map(|verdict| verdict.adequate), "residual": outcome.verdict.map(residual),
        "rejected": rejected, "drift": outcome.drift.iter().map(drift).collect::<Vec<_>>(), "tracks": outcome.tracks.iter().map(track).collect::<Vec<_>>(), "advice": outcome.advice, "notes": outcome.notes,
        "mac": outcome.structure.compared.as_ref().map(|compared| compared.as_json(outcome)),
        "setups": outcome.structure.merge.as_ref().map(super::merge::Merge::setups),
        "merge": outcome.structure.merge.as_ref().map(super::merge::Merge::as_json), "report": written })
}
