//! What a run says of its deaths: in its result, in its trace, and to whoever watches it.

use crate::PARTITIONS;
use crate::ended::DEGRADED;
use crate::world::{World, undisturbed};
use rustix::process::Signal;
use serde_json::Value;

#[test]
fn every_death_of_every_life_is_in_the_result_with_its_cause_and_the_time_it_cost() {
    let world = World::new();
    let ended = world.run(&["--kill", "slosh-id@700", "--kill", "recorder@1500:publish"]);
    assert_eq!(ended.digest(), undisturbed().digest, "{ended}");
    let deaths = ended.json["deaths"].as_array().unwrap();
    let found: Vec<_> = deaths.iter().map(|row| [&row["partition"], &row["epoch"], &row["cause"]]).collect();
    let signal = Value::from("signal 9");
    assert_eq!(found, [[&"slosh-id".into(), &0.into(), &signal], [&"recorder".into(), &0.into(), &signal]], "{ended}");
    for row in deaths {
        for key in ["t_s", "detect_ms", "recover_ms"] {
            assert!(row[key].as_f64().is_some_and(|value| value >= 0.0), "{key}: {row}");
        }
    }
}

#[test]
fn a_partition_without_a_whole_checkpoint_begins_anew_and_its_loss_is_declared() {
    let world = World::new();
    let mut run = world.start(&["--speed", "20"]);
    run.wait_for_housekeeping();
    let victim = run.process("slosh-id");
    // Stopped, it writes no checkpoint behind our back.
    victim.signal(Signal::STOP);
    run.spoil_checkpoints("slosh-id");
    victim.signal(Signal::KILL);
    let ended = run.end();
    assert_eq!(ended.code, Some(DEGRADED), "{ended}");
    let lossy = ended.json["loss"].as_array().unwrap();
    assert!(lossy.iter().any(|loss| loss["partition"] == "slosh-id" && loss["kind"] == "samples_lost"), "{ended}");
    assert!(ended.log.iter().any(|line| line.contains("slosh-id: no checkpoint is whole")), "{ended}");
    assert_eq!(ended.count("slosh-id", "frames"), ended.count("sensor-sim", "frames"), "the run goes on: {ended}");
}

#[test]
fn a_trace_has_frames_of_every_partition_and_the_restart_of_who_died() {
    let world = World::new();
    let file = world.file("flight.json");
    let ended = world.run(&["--trace", file.to_str().unwrap(), "--kill", "modal-id@100"]);
    assert_eq!(ended.digest(), undisturbed().digest, "{ended}");
    let trace: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    let events = trace["traceEvents"].as_array().unwrap();
    let named = |name: &'static str| events.iter().filter(move |event| event["name"] == name);
    let processes: Vec<_> = named("process_name").map(|event| event["args"]["name"].as_str().unwrap()).collect();
    assert_eq!(processes, PARTITIONS);
    for process in named("process_name").map(|event| &event["pid"]) {
        let frames = named("frame").filter(|event| event["pid"] == *process).count() as u64;
        // Who dies loses the markers since it last slept, and does the frames since its checkpoint
        // again.
        assert!(frames + 100 >= undisturbed().frames, "{process}: {frames} frames");
    }
    assert_eq!(named("restart: signal 9").count(), 1);
    assert!(named("tick").count() > 0 && named("wait").count() > 0 && named("CAPTURE").count() > 0);
}

#[test]
fn a_run_that_flies_can_be_watched_from_elsewhere_and_its_end_is_said() {
    let world = World::new();
    let mut run = world.start(&["--speed", "10"]);
    run.wait_for_housekeeping();
    let seen = world.obsid(&["top", "--once", "--json", "--interval", "0.3"]);
    assert!(seen.status.success(), "{seen:?}");
    let seen: Value = serde_json::from_slice(&seen.stdout).unwrap();
    let rows = seen["partitions"].as_array().unwrap();
    assert_eq!(rows.len(), PARTITIONS.len());
    assert!(rows.iter().all(|row| row["pid"].as_u64().is_some() && row["frames"].as_u64().unwrap() > 0), "{seen}");
    assert_eq!(run.end().digest(), undisturbed().digest);
    let nothing = world.obsid(&["top", "--once"]);
    assert_eq!(nothing.status.code(), Some(3), "{nothing:?}");
}

#[test]
fn a_drill_finds_equal_digests_and_its_log_agrees_with_the_wardens() {
    let world = World::new();
    let faults = "kill,crash,corrupt,checkpoint,descriptors,disk";
    let output = world.obsid(&["drill", "--kills", "6", "--faults", faults, "--speed", "40", "--json"]);
    let drill: Value = serde_json::from_slice(&output.stdout).unwrap();
    for none in [
        "digests_differing",
        "undeclared_lost",
        "torn",
        "wedged",
        "leaks",
        "failed",
        "log_disagreements",
        "checkpoint_cuts_taken",
    ] {
        assert_eq!(drill[none], 0, "{none}: {drill}");
    }
    assert!(drill["kills"].as_u64().unwrap() >= 6 && drill["checkpoint_cuts"].as_u64().unwrap() > 1000, "{drill}");
    assert_eq!(drill["by_fault"].as_array().unwrap().len(), faults.split(',').count(), "{drill}");
    assert!(drill["recover_ms"]["p50"].as_f64().is_some(), "{drill}");
    world.assert_nothing_left();
}
