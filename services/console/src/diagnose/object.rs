//! The diagnosis as one JSON object.

use super::Diagnosed;
use super::answer::answer;
use crate::recordings::Loaded;
use serde_json::{Map, Value, json};

/// Every key of the diagnosis, and what the command line adds: the examination of the recordings,
/// the files read, and the answer as three sentences.
pub fn object(diagnosed: &Diagnosed) -> Value {
    let engine = serde_json::to_value(&diagnosed.diagnosis).expect("a diagnosis is plain data with text for keys");
    let Value::Object(engine) = engine else { return engine };
    let mut object = Map::new();
    for (key, value) in engine {
        let first = key == "compare";
        if first {
            object.insert("doctor".into(), doctor(diagnosed));
        }
        object.insert(key, value);
    }
    let case = &diagnosed.case;
    object.insert(
        "plant".into(),
        json!({ "file": case.plant_file, "name": case.plant.name, "digest": case.plant_digest }),
    );
    let all = |loaded: &[Loaded]| loaded.iter().map(Loaded::as_json).collect::<Vec<_>>();
    let spectra = case.spectra.iter().map(|(s, digest)| {
        let columns: Vec<_> = s.columns.iter().map(|c| json!({ "name": c.name, "unit": c.unit })).collect();
        json!({ "file": s.file, "digest": digest, "lines": s.frequency_hz.len(), "columns": columns })
    });
    let modes = case
        .modes
        .iter()
        .map(|m| json!({ "file": m.file, "digest": m.digest, "modes": m.modes.len(), "tracks": m.tracks.len() }));
    object.insert("recordings".into(), all(&case.fitted).into_iter().chain(spectra).chain(modes).collect());
    object.insert("held_out_recordings".into(), all(&case.held_out).into());
    object.insert("answer".into(), json!(answer(diagnosed)));
    object.insert("command".into(), case.command.as_str().into());
    object.insert("effort".into(), case.effort.name().into());
    object.insert("interrupted".into(), diagnosed.interrupted.into());
    Value::Object(object)
}

fn doctor(diagnosed: &Diagnosed) -> Value {
    let row = |(of, f): &(usize, examination::doctor::Finding)| {
        json!({ "recording": diagnosed.case.fitted[*of].recording.name, "check": f.check, "severity": f.severity,
            "channel": f.channel, "others": f.others, "value": f.value, "sigma": f.sigma, "unit": f.unit,
            "evidence": f.evidence, "cure": f.cure })
    };
    diagnosed.findings.iter().map(row).collect()
}
