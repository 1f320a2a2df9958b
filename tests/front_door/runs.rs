//! `obsid run`: the benchmark's mission, its keys, and the same bytes over either link.

use crate::desk::{Folder, ask, estimates, number, scenario, workspace};
use serde_json::Value;
use std::sync::LazyLock;

static DEFAULT: LazyLock<Value> = LazyLock::new(|| ask(&["run", "--link", "lockstep", "--json"]).result());
static SHORT: LazyLock<Value> =
    LazyLock::new(|| ask(&["run", &scenario("short.toml"), "--link", "lockstep", "--json"]).result());

/// Domain, phase and names of every model of the default mission.
const MODELS: [(&str, &str, &[&str]); 4] = [
    ("inertial", "pre_capture", &["a1", "a2", "a3", "a4", "a5", "a6", "a7", "a8"]),
    ("inertial", "mated", &["a1", "a2", "a3", "a4", "a5", "a6", "a7", "a8", "a9"]),
    ("slosh", "pre_capture", &["m_s", "k_s", "c_s"]),
    ("modal", "pre_capture", &["f1", "zeta1", "f2", "zeta2"]),
];

fn rows<'a>(result: &'a Value, domain: &str, phase: &str) -> Vec<&'a Value> {
    estimates(result, domain).iter().filter(|row| row["phase"] == phase).collect()
}

#[test]
fn the_result_has_every_key_with_its_type() {
    let result = &*DEFAULT;
    let modes = result["modes"].as_array().unwrap();
    for mode in modes {
        assert!(mode["frame"].is_u64() && mode["t_s"].is_f64(), "{mode}");
        assert!(["from", "to", "cause"].iter().all(|key| mode[key].is_string()), "{mode}");
    }
    let texts = ["phase", "name", "unit", "reason"];
    let numbers = ["truth", "value", "sigma", "error_percent", "paper_error_percent"];
    let verdicts = ["complete", "adequate", "accepted"];
    for row in ["inertial", "slosh", "modal"].iter().flat_map(|domain| estimates(result, domain)) {
        assert!(texts.iter().all(|key| row[key].is_string()), "{row}");
        assert!(
            numbers.iter().all(|key| row.get(key).is_some_and(|value| value.is_number() || value.is_null())),
            "{row}"
        );
        assert!(verdicts.iter().all(|key| row[key].is_boolean()), "{row}");
    }
    let partitions = result["partitions"].as_array().unwrap();
    let names: Vec<&str> = partitions.iter().map(|row| row["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["sensor-sim", "inertial-id", "slosh-id", "modal-id", "supervisor", "recorder"]);
    for row in partitions {
        assert!(["received", "lost", "restarts", "bad"].iter().all(|key| row[key].is_u64()), "{row}");
        // One thread has neither a wire nor a process: unknown is null, not zero.
        assert!(["latency_us_p50", "latency_us_p99", "cpu_percent"].iter().all(|key| row[key].is_null()), "{row}");
        assert!(row["lost"] == 0 && row["restarts"] == 0 && row["bad"] == 0, "{row}");
    }
    let digest = result["digest"].as_str().unwrap();
    assert!(digest.len() == 64 && digest.bytes().all(|byte| byte.is_ascii_hexdigit()), "{digest}");
    assert!(number(result, "wall_s") > 0.0);
}

#[test]
fn every_parameter_has_its_truth_and_lies_within_four_sigma_of_it() {
    for (domain, phase, names) in MODELS {
        let rows = rows(&DEFAULT, domain, phase);
        assert!(rows.iter().map(|row| row["name"].as_str().unwrap()).eq(names.iter().copied()), "{rows:?}");
        for row in rows {
            let (truth, value, sigma) = (number(row, "truth"), number(row, "value"), number(row, "sigma"));
            // 4 sigma: 24 parameters of honest sigmas leave it once in 700 seeds, and the seed is
            // fixed.
            assert!(sigma > 0.0 && (value - truth).abs() <= 4.0 * sigma, "{row}");
            let error_percent = 100.0 * (value - truth).abs() / truth.abs();
            assert!((number(row, "error_percent") - error_percent).abs() <= 1e-12 * error_percent.max(1.0), "{row}");
            assert_eq!(row["paper_error_percent"].is_number(), phase == "pre_capture", "{row}");
        }
    }
}

#[test]
fn what_the_sensor_sheet_may_have_done_stands_beside_each_number_of_the_arm_null_where_it_is_not_known() {
    for row in estimates(&DEFAULT, "inertial") {
        assert!(number(row, "consider_sigma") > 0.0, "{row}");
    }
    let torques = estimates(&DEFAULT, "inertial_torque");
    assert!(torques.iter().all(|row| row["value"].is_number()) && torques.len() == 17, "{torques:?}");
    assert!(torques.iter().all(|row| row.get("consider_sigma").is_some_and(Value::is_null)), "{torques:?}");
    let others = ["slosh", "modal", "target"].iter().flat_map(|domain| estimates(&DEFAULT, domain));
    // the short scenario's sheet states no error
    let silent = ["inertial", "inertial_torque"].iter().flat_map(|domain| estimates(&SHORT, domain));
    for row in others.chain(silent) {
        assert!(row.get("consider_sigma").is_none(), "{row}");
    }
}

#[test]
fn the_ninth_number_alone_says_how_far_off_the_axis_it_lies_and_without_a_prior_no_number_has_an_identifiability() {
    for row in ["inertial", "slosh", "modal"].iter().flat_map(|domain| estimates(&DEFAULT, domain)) {
        assert_eq!(row.get("off_axis_sigmas").is_some(), row["name"] == "a9", "{row}");
        assert!(row.get("identifiability").is_none(), "{row}");
    }
    let [.., a9] = &rows(&DEFAULT, "inertial", "mated")[..] else { panic!("nine") };
    // 150 kg are held: far beyond the five sigmas that show a target
    assert!(number(a9, "off_axis_sigmas") < -100.0, "{a9}");
}

#[test]
fn every_model_is_complete_adequate_and_accepted_and_the_mission_ends_mated_in_standby() {
    for (domain, phase, _) in MODELS {
        for row in rows(&DEFAULT, domain, phase) {
            assert!(row["complete"] == true && row["adequate"] == true && row["accepted"] == true, "{row}");
        }
    }
    let modes = DEFAULT["modes"].as_array().unwrap();
    assert!(
        modes
            .windows(2)
            .all(|pair| pair[0]["to"] == pair[1]["from"] && pair[0]["frame"].as_u64() < pair[1]["frame"].as_u64())
    );
    let states: Vec<&str> = modes.iter().map(|mode| mode["to"].as_str().unwrap()).collect();
    let flown = [
        "PRE_CAPTURE.MODAL",
        "PRE_CAPTURE.SLOSH",
        "PRE_CAPTURE.INERTIAL",
        "APPROACH_HOLD",
        "CAPTURE",
        "MATED.SETTLE",
        "MATED.INERTIAL",
        "STANDBY",
    ];
    assert_eq!(states, flown);
}

#[test]
fn processes_over_shared_memory_and_one_thread_give_the_same_digest_and_another_seed_another() {
    let (short, lockstep) = (scenario("short.toml"), &*SHORT);
    let shm = ask(&["run", &short, "--link", "shm", "--json"]).result();
    assert_eq!(lockstep["digest"], shm["digest"]);
    assert_eq!(lockstep["estimates"], shm["estimates"]);
    for row in shm["partitions"].as_array().unwrap() {
        assert!(["latency_us_p50", "latency_us_p99", "cpu_percent"].iter().all(|key| row[key].is_number()), "{row}");
    }
    let other = ask(&["run", &short, "--link", "lockstep", "--seed", "2", "--json"]).result();
    assert_ne!(lockstep["digest"], other["digest"]);
}

#[test]
fn without_json_the_table_shows_every_parameter_and_the_digest() {
    let answer = ask(&["run", &scenario("short.toml"), "--link", "lockstep"]).ends_with(0);
    for text in
        ["a1", "a9", "m_s", "k_s", "c_s", "f1", "zeta2", "MATED.INERTIAL", "accepted yes", "digest ", "recorder"]
    {
        assert!(answer.stdout.contains(text), "{text}: {answer}");
    }
}

#[test]
fn a_damaged_sample_is_counted_and_dropped_and_changes_nothing() {
    let (short, good) = (scenario("short.toml"), &*SHORT);
    // Frame 1500 lies in the arm experiment: its inertial sample is taken by three partitions.
    let damaged = ask(&["run", &short, "--link", "lockstep", "--corrupt", "1500", "--json"]).result();
    let bad = |result: &Value, name: &str| {
        let rows = result["partitions"].as_array().unwrap();
        rows.iter().find(|row| row["name"] == name).unwrap()["bad"].as_u64().unwrap()
    };
    assert_eq!(bad(good, "inertial-id"), 0);
    assert_eq!(bad(&damaged, "inertial-id"), 1);
    assert_eq!(good["digest"], damaged["digest"]);
}

/// What the scenario of one body says of its inertia, with a line of it changed.
fn compared(line: (&str, &str)) -> Value {
    let text = std::fs::read_to_string(scenario("one_body.toml")).unwrap();
    let text = text.replace("../plants/", &format!("{}/deploy/plants/", workspace().display()));
    assert!(text.contains(line.0));
    let folder = Folder::new("one-body");
    let file = folder.file("scenario.toml", text.replace(line.0, line.1));
    let result = folder.ask(&["run", file, "--link", "lockstep", "--json"]).ends_with(0).object();
    let [row] = &result["comparisons"].as_array().unwrap()[..] else { panic!("{}", result["comparisons"]) };
    row.clone()
}

#[test]
fn the_inertias_of_one_body_by_modes_and_by_momentum_agree_and_a_momentum_mis_stated_is_doubted() {
    let row = compared(("h_cm_nms = 68.0", "h_cm_nms = 68.0"));
    assert!(row["agree"] == true && row["doubt"].is_null() && number(&row, "z").abs() <= 3.0, "{row}");
    // Of the plant, arm at 0.6 and -1.1 rad, about the centre of mass of the whole.
    assert!((number(&row, "modal_kg_m2") / 536.2423 - 1.0).abs() < 0.003, "{row}");
    // Every parameter 5 % too large, every test of the inertial model passed.
    let row = compared(("h_cm_nms = 68.0", "h_cm_nms = 71.4"));
    assert!(row["agree"] == false && row["doubt"] == "inertial" && number(&row, "z") < -3.0, "{row}");
}

#[test]
fn nothing_is_said_of_two_inertias_where_no_appendage_is_stated_and_of_separate_bodies_that_they_are() {
    assert_eq!(DEFAULT["comparisons"].as_array().unwrap().len(), 0, "{}", DEFAULT["comparisons"]);
    let row = compared(("arm_angle_rad = [0.6, -1.1]", ""));
    assert!(row["agree"].is_null() && row["doubt"].is_null(), "{row}");
    assert!(row["reason"].as_str().unwrap().contains("separate bodies"), "{row}");
}
