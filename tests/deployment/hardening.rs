//! What a partition may not do any more once it runs: tried from inside each of them.

use crate::{Place, object, scenario};
use runtime::sys::is_refused;
use serde_json::Value;
use std::collections::BTreeMap;

const PARTITIONS: [&str; 6] = ["sensor-sim", "inertial-id", "slosh-id", "modal-id", "supervisor", "recorder"];
/// Of the short scenario, on every link.
const ACTS_MIN: usize = 20;

/// Answers by partition, and the run's result.
fn probed(more: &[&str]) -> (BTreeMap<String, BTreeMap<String, i32>>, Value) {
    let place = Place::new();
    let short = scenario("short.toml");
    let mut arguments = vec!["run", short.as_str(), "--json"];
    PARTITIONS.iter().for_each(|name| arguments.extend(["--probe", name]));
    arguments.extend(crate::PATIENT.iter().chain(more));
    let output = place.command(&arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let parse = |line: &str| {
        let (name, answers) = line.split_once("probes of ")?.1.split_once(": ")?;
        Some((name.to_string(), serde_json::from_str(answers).ok()?))
    };
    (said.lines().filter_map(parse).collect(), object(&output, 0))
}

fn lockstep() -> Value {
    let output = Place::new().command(&["run", &scenario("short.toml"), "--json", "--link", "lockstep"]).output();
    object(&output.unwrap(), 0)
}

#[test]
fn every_act_that_a_partition_has_no_need_for_is_refused_by_the_kernel_and_the_run_is_the_same() {
    let (answers, result) = probed(&[]);
    assert_eq!(result["digest"], lockstep()["digest"]);
    assert!(answers.keys().map(String::as_str).eq({
        let mut names = PARTITIONS;
        names.sort_unstable();
        names
    }));
    for row in result["partitions"].as_array().unwrap() {
        let (name, stands) = (row["name"].as_str().unwrap(), &row["hardening"]);
        let acts = &answers[name];
        assert!(acts.len() >= ACTS_MIN, "{name}: {acts:?}");
        // A kernel without a barrier says so, and its acts are not asserted.
        if stands["files"] == true && stands["system_calls"] == true {
            let done: Vec<_> = acts.iter().filter(|(_, errno)| !is_refused(**errno)).collect();
            assert!(done.is_empty(), "{name}: {done:?}");
        } else {
            assert!(!stands["missing"].as_array().unwrap().is_empty(), "{name}: {stands}");
        }
    }
}

#[test]
fn without_the_hardening_the_same_acts_go_through_so_that_the_probes_can_tell() {
    let (answers, result) = probed(&["--sabotage", "no-hardening"]);
    assert_eq!(result["digest"], lockstep()["digest"]);
    for (name, acts) in &answers {
        let done = acts.values().filter(|errno| !is_refused(**errno)).count();
        assert!(2 * done > acts.len(), "{name}: {acts:?}");
    }
    for row in result["partitions"].as_array().unwrap() {
        assert_eq!(row["hardening"]["missing"][0], "switched off", "{row}");
    }
}

#[test]
fn killed_partitions_come_back_hardened() {
    let place = Place::new();
    let short = scenario("short.toml");
    let kills = ["supervisor@900", "inertial-id@1500:publish", "recorder@2100:checkpoint", "sensor-sim@2900"];
    let mut arguments = vec!["run", short.as_str(), "--json"];
    kills.iter().for_each(|kill| arguments.extend(["--kill", kill]));
    arguments.extend(crate::PATIENT);
    let result = object(&place.command(&arguments).output().unwrap(), 0);
    assert_eq!(result["digest"], lockstep()["digest"]);
    let rows = result["partitions"].as_array().unwrap();
    let restarts = |row: &&Value| row["restarts"].as_u64().unwrap() > 0;
    assert!(rows.iter().filter(restarts).count() >= kills.len(), "{rows:?}");
    let first = &rows[0]["hardening"];
    assert!(rows.iter().all(|row| row["hardening"]["system_calls"] == first["system_calls"]), "{rows:?}");
}
