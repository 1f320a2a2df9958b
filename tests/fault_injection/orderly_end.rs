//! Ends from outside: a signal to the console ends a run in order; without warden or console
//! nothing stays behind.

use crate::ended::Ended;
use crate::world::{World, undisturbed};
use rustix::process::Signal;
use telemetry::is_result;

/// A run slow enough (about 10 s) to be ended long before its end.
const SLOW: [&str; 2] = ["--speed", "5"];

fn is_ended_in_order(signal: Signal) {
    let world = World::new();
    let file = world.file("flight.mcap");
    let mut run = world.start(&[&SLOW[..], &["--record", file.to_str().unwrap()]].concat());
    run.wait_for_housekeeping();
    run.console.signal(signal);
    let ended: Ended = run.end();
    world.assert_nothing_left();
    assert_eq!(ended.code, Some(1), "{ended}");
    assert_eq!(ended.failure(), "stopped by a signal");
    assert!(ended.deaths().is_empty(), "ended, not killed: {ended}");

    let digest = world.obsid(&["digest", file.to_str().unwrap()]);
    assert!(digest.status.success(), "the recording is complete: {digest:?}");
    // What was recorded is the beginning of what the whole run gives.
    let recorded = recording::read_mcap(&file).unwrap();
    let results = |run: &recording::RecordedRun| {
        run.samples().filter(|sample| is_result(sample.topic)).map(|sample| sample.payload.to_vec()).collect::<Vec<_>>()
    };
    let (found, whole) = (results(&recorded), results(&undisturbed().recording));
    assert!(!found.is_empty() && found.len() < whole.len(), "{} of {} results", found.len(), whole.len());
    assert!(whole.starts_with(&found), "{} results, not the first ones of {}", found.len(), whole.len());
}

#[test]
fn ctrl_c_ends_a_run_in_order_and_leaves_a_readable_recording() {
    is_ended_in_order(Signal::INT);
}

#[test]
fn sigterm_ends_a_run_in_order_and_leaves_a_readable_recording() {
    is_ended_in_order(Signal::TERM);
}

#[test]
fn the_wardens_death_ends_its_children_and_the_console_says_so_and_removes_what_they_left() {
    let world = World::new();
    let mut run = world.start(&SLOW);
    run.wait_for_housekeeping();
    run.process("warden").signal(Signal::KILL);
    let ended = run.end();
    world.assert_nothing_left();
    assert_eq!(ended.code, Some(1), "{ended}");
    assert!(ended.failure().contains("the warden ended without a result (signal: 9"), "{ended}");
}

#[test]
fn the_death_of_console_and_warden_ends_the_partitions_and_the_next_start_removes_what_they_left() {
    let world = World::new();
    let mut run = world.start(&SLOW);
    run.wait_for_housekeeping();
    let warden = run.process("warden");
    run.console.signal(Signal::KILL);
    warden.signal(Signal::KILL);
    let ended = run.end();
    assert_eq!(ended.code, Some(-9), "{ended}");
    assert!(world.processes().is_empty(), "{ended}");
    assert!(!world.shared_memory().is_empty(), "else there is nothing to remove and the next line proves nothing");
    let ended = world.run(&[]);
    assert_eq!(ended.digest(), undisturbed().digest);
}

#[test]
fn the_consoles_death_does_not_disturb_the_run() {
    let world = World::new();
    let file = world.file("flight.mcap");
    let mut run = world.start(&["--speed", "30", "--record", file.to_str().unwrap()]);
    run.process("recorder");
    run.console.signal(Signal::KILL);
    let ended = run.end();
    assert_eq!(ended.code, Some(-9), "{ended}");
    assert!(ended.deaths().is_empty(), "{ended}");
    let digest = world.obsid(&["digest", file.to_str().unwrap()]);
    assert!(String::from_utf8_lossy(&digest.stdout).starts_with(&undisturbed().digest), "{digest:?}");
    world.assert_nothing_left();
}
