//! A partition that dies in every life is given up: its domain is abandoned, or, without it, the
//! run.

use crate::ended::{DEGRADED, Ended, KILLED};
use crate::limits;
use crate::world::{World, undisturbed};
use serde_json::json;
use telemetry::ACTUATORS;

/// Five restarts are allowed, in the built-in table (`deploy/partitions.toml`) and in that of
/// [`limits`].
const DEATHS: usize = 6;

fn was_given_up(ended: &Ended, name: &str) {
    assert_eq!(ended.json["completed"], false, "{ended}");
    let loss = json!([{ "partition": name, "kind": "given_up", "count": DEATHS - 1 }]);
    assert!(ended.code != Some(DEGRADED) || (&ended.json["degraded"], &ended.json["loss"]) == (&json!(true), &loss));
    assert_eq!(ended.given_up(), [name], "{ended}");
    let died = ended.deaths().into_iter().filter(|death| death.name == name && death.cause == KILLED).count();
    assert_eq!(died, DEATHS, "{ended}");
}

/// Every parameter of the domain before capture is as in the undisturbed run, verdict included.
fn is_untouched(ended: &Ended, domain: &str) {
    assert_eq!(ended.estimates(domain, "pre_capture"), undisturbed().ended.estimates(domain, "pre_capture"), "{ended}");
}

fn is_abandoned(ended: &Ended, domain: &str) {
    let rows = ended.estimates(domain, "pre_capture");
    assert!(!rows.is_empty(), "{ended}");
    for row in rows {
        assert_eq!(
            (row["accepted"].as_bool(), row["reason"].as_str()),
            (Some(false), Some("the partition was given up"))
        );
    }
}

#[test]
fn an_estimator_given_up_in_its_experiment_ends_the_excitation_and_costs_only_its_own_domain() {
    let world = World::new();
    let file = world.file("flight.mcap");
    let ended = world.run(&["--kill-always", "slosh-id@700", "--record", file.to_str().unwrap()]);
    assert_eq!(ended.code, Some(DEGRADED), "{ended}");
    was_given_up(&ended, "slosh-id");
    let modes = ended.modes();
    let abort = modes.iter().find(|(_, to, cause)| (*to, *cause) == ("STANDBY", "partition lost"));
    let abort_frame = abort.unwrap_or_else(|| panic!("{ended}")).0;
    is_abandoned(&ended, "slosh");
    is_untouched(&ended, "modal");
    let inertial = ended.estimates("inertial", "pre_capture");
    assert!(inertial.len() == 8 && inertial.iter().all(|row| row["accepted"] == true), "{ended}");

    // Thrust before the abort, none from it on: there is no second experiment with the thruster.
    let recorded = recording::read_mcap(&file).unwrap();
    let force_n = |of_time: &dyn Fn(u64) -> bool| {
        let samples =
            recorded.of(ACTUATORS).map(|(_, sample)| sample).filter(|sample| of_time(sample.header.t_meas_ns));
        samples.flat_map(|sample| sample.force_b_n).map(f64::abs).fold(0.0, f64::max)
    };
    let abort_ns = abort_frame * 10_000_000;
    assert!(force_n(&|t_ns| t_ns < abort_ns) > 40.0, "of 44 N");
    assert_eq!(force_n(&|t_ns| t_ns >= abort_ns), 0.0);
}

#[test]
fn the_other_estimators_given_up_cost_only_their_own_domain() {
    let world = World::new();
    let table = limits::table(&world, &[]);
    let ended = world.run(&["--partitions", &table, "--kill-always", "modal-id@200"]);
    assert_eq!(ended.code, Some(DEGRADED), "{ended}");
    was_given_up(&ended, "modal-id");
    is_abandoned(&ended, "modal");
    assert!(ended.modes().iter().any(|(_, _, cause)| *cause == "partition lost"), "{ended}");
    for (domain, count) in [("slosh", 3), ("inertial", 8)] {
        let rows = ended.estimates(domain, "pre_capture");
        assert!(rows.len() == count && rows.iter().all(|row| row["accepted"] == true), "{domain}: {ended}");
    }

    let ended = world.run(&["--partitions", &table, "--kill-always", "inertial-id@1700"]);
    assert_eq!(ended.code, Some(DEGRADED), "{ended}");
    was_given_up(&ended, "inertial-id");
    is_abandoned(&ended, "inertial");
    is_untouched(&ended, "modal");
    is_untouched(&ended, "slosh");
    assert!(
        ended.modes().iter().all(|(_, to, _)| *to != "CAPTURE"),
        "nothing is grasped without a model of the arm: {ended}"
    );
}

#[test]
fn who_was_given_up_stays_so_over_restarts_of_the_source_and_the_supervisor() {
    let world = World::new();
    let table = limits::table(&world, &[]);
    let kills = ["--kill-always", "slosh-id@700", "--kill", "supervisor@790", "--kill", "sensor-sim@790"];
    let ended = world.run(&[&["--partitions", table.as_str()][..], &kills].concat());
    assert_eq!(ended.code, Some(DEGRADED), "{ended}");
    was_given_up(&ended, "slosh-id");
    is_abandoned(&ended, "slosh");
    assert_eq!(["supervisor", "sensor-sim"].map(|name| ended.count(name, "restarts")), [1, 1], "{ended}");
}

#[test]
fn a_run_that_loses_its_source_its_supervisor_or_its_recorder_fails_and_says_so() {
    let world = World::new();
    let table = limits::table(&world, &[]);
    for name in ["sensor-sim", "supervisor", "recorder"] {
        let ended = world.run(&["--partitions", &table, "--kill-always", &format!("{name}@700")]);
        assert_eq!(ended.code, Some(1), "{ended}");
        was_given_up(&ended, name);
        assert_eq!(ended.failure(), format!("{name} was given up after {DEATHS} deaths"));
    }
}
