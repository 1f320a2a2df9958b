//! What the program answers, without what may change from run to run.

use serde_json::{Map, Value, json};
use std::path::Path;
use std::process::Command;

/// Standard output of the program.
pub fn program(arguments: &[&str]) -> String {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new(env!("CARGO_BIN_EXE_obsid")).args(arguments).current_dir(workspace).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    assert!(output.status.success(), "obsid {}: {}", arguments.join(" "), text(output.stderr));
    text(output.stdout)
}

fn object(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// Digest of a run in one thread.
pub fn digest(arguments: &[&str]) -> Value {
    object(&program(&[arguments, &["--link", "lockstep", "--json"]].concat()))["digest"].clone()
}

/// Answers to `cases` challenge cases of `seed`, by case.
pub fn challenge(folder: &Path, cases: u64, seed: u64) -> Value {
    let list = folder.join("cases.json");
    let (cases, seed, file) = (cases.to_string(), seed.to_string(), list.display().to_string());
    program(&["challenge", "--cases", &cases, "--seed", &seed, "--threads", "2", "--list", &file, "--json"]);
    let text = std::fs::read_to_string(&list).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    let cases = object(&text)["cases"].as_array().unwrap().clone();
    let answer = |case: &Value| {
        let effects = case["answer"]["names"].as_array().unwrap().iter().map(|name| {
            let parameters = name["parameters"].as_array().unwrap().iter().map(|p| (p[0].clone(), &p[1], &p[2]));
            effect(name, parameters)
        });
        let effects: Vec<Value> = effects.collect();
        json!({ "plant": case["truth"]["plant"], "verdict": case["answer"]["verdict"], "effects": effects })
    };
    let by_case = cases.iter().enumerate().map(|(k, case)| (format!("case {k}"), answer(case)));
    Value::Object(by_case.collect())
}

/// The whole object of `obsid diagnose` with these arguments.
pub fn diagnosis(arguments: &[&str]) -> Value {
    object(&program(&[&["diagnose"], arguments, &["--json"]].concat()))
}

/// Of a diagnosis the verdict and the effects.
pub fn answer(found: &Value) -> Value {
    let effects = found["effects"].as_array().unwrap().iter().map(|one| {
        let parameters = one["parameters"].as_array().unwrap();
        effect(one, parameters.iter().map(|p| (p["name"].clone(), &p["value"], &p["sigma"])))
    });
    let effects: Vec<Value> = effects.collect();
    json!({ "verdict": found["verdict"], "effects": effects })
}

/// Site and kind, status, and every parameter with its sigma.
fn effect<'a>(one: &Value, parameters: impl Iterator<Item = (Value, &'a Value, &'a Value)>) -> Value {
    let word = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let of = |(name, value, sigma)| (word(&name), json!([rounded(value), rounded(sigma)]));
    let parameters: Map<String, Value> = parameters.map(of).collect();
    let name = format!("{}@{}", word(&one["kind"]), word(&one["site"]));
    json!({ "effect": name, "status": one["status"], "parameters": parameters })
}

/// Four significant digits: bits beyond may differ between machines, answers may not.
fn rounded(value: &Value) -> Value {
    value.as_f64().map_or(Value::Null, |number| format!("{number:.3e}").into())
}
