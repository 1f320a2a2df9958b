//! Diagnoses of another effort, and those that are interrupted.

use crate::desk::{Folder, command};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read};
use std::process::Stdio;

const FRICTION: &str = "joint_coulomb@joint:pivot force=0.05";

fn swing(folder: &Folder) {
    folder.ask(&["simulate", "pendulum", "--duration", "8", "--hide", FRICTION, "--out", "a.csv"]).ends_with(0);
}

/// Standard output and the exit code of a diagnosis that is interrupted once `phase` begins.
fn interrupted(folder: &Folder, phase: &str, more: &[&str]) -> (String, Option<i32>) {
    let arguments = [&["diagnose", "a.csv", "--plant", "pendulum", "--progress"], more].concat();
    let mut command = command(&arguments);
    let mut child = command.current_dir(folder.path()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    assert!(lines.any(|line| line == phase), "`{phase}` is not said");
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    lines.for_each(drop);
    let mut told = String::new();
    child.stdout.take().unwrap().read_to_string(&mut told).unwrap();
    (told, child.wait().unwrap().code())
}

fn effects(result: &Value) -> Vec<String> {
    let name = |row: &Value| format!("{}@{}", row["kind"], row["site"]);
    result["effects"].as_array().unwrap().iter().map(name).collect()
}

#[test]
fn an_interrupted_diagnosis_prints_what_is_known_as_one_object_with_no_other_effects() {
    let folder = Folder::new("interrupted-diagnosis");
    swing(&folder);
    let whole = folder.ask(&["diagnose", "a.csv", "--plant", "pendulum", "--json"]).result();
    assert!(whole["interrupted"] == false && whole["effort"] == "normal", "{whole}");
    for phase in ["look at the labels", "fit the nominal plant", "compare sets of hypotheses"] {
        let (told, code) = interrupted(&folder, phase, &["--json"]);
        assert_eq!(code, Some(130), "{phase}: {told}");
        let result: Value = serde_json::from_str(&told).unwrap();
        assert_eq!(result["interrupted"], true, "{phase}: {result}");
        let known = effects(&whole);
        assert!(effects(&result).iter().all(|effect| known.contains(effect)), "{phase}: {result}");
    }
    let (told, code) = interrupted(&folder, "fit the nominal plant", &[]);
    assert!(told.starts_with("interrupted: what is known so far\n") && code == Some(130), "{told}");
}

#[test]
fn the_effort_is_said_in_the_result_and_in_the_command_that_makes_it_again() {
    let folder = Folder::new("effort");
    swing(&folder);
    let quick = folder.ask(&["diagnose", "a.csv", "--plant", "pendulum", "--effort", "quick", "--json"]).result();
    assert_eq!(quick["effort"], "quick");
    assert!(quick["command"].as_str().unwrap().ends_with("--effort quick"), "{quick}");
    folder.ask(&["diagnose", "a.csv", "--plant", "pendulum", "--effort", "much"]).ends_with(2).says(&["thorough"]);
}
