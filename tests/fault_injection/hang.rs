//! Hangs: a process that lives and does nothing (SIGSTOP) is found by its execution counter, killed
//! and restarted.

use crate::limits;
use crate::world::{World, undisturbed};
use rustix::process::Signal;
use std::os::unix::net::UnixDatagram;

fn is_found(hanging: &[&str], frame: u64) {
    let world = World::new();
    let table = limits::table(&world, hanging);
    let hangs: Vec<String> = hanging.iter().map(|name| format!("{name}@{frame}")).collect();
    let mut arguments = vec!["--partitions", &table];
    arguments.extend(hangs.iter().flat_map(|hang| ["--hang", hang]));
    let ended = world.run(&arguments);
    assert_eq!(ended.code, Some(0), "{ended}");
    assert_eq!(ended.digest(), undisturbed().digest, "{ended}");
    for &name in hanging {
        assert!(ended.hangs().contains(&name), "the reason of the restart: {ended}");
        assert!(ended.count(name, "restarts") >= 1, "{ended}");
    }
    // A death without a hang before it would be another fault than the one of this drill.
    let mut died: Vec<String> = ended.deaths().into_iter().map(|death| death.name).collect();
    let mut hung = ended.hangs();
    died.sort_unstable();
    hung.sort_unstable();
    assert_eq!(died, hung, "{ended}");
    assert!(hung.iter().all(|name| hanging.contains(name)), "{ended}");
}

#[test]
fn an_estimator_that_hangs_is_restarted_and_the_digest_is_unchanged() {
    is_found(&["slosh-id"], 700);
}

#[test]
fn a_source_that_hangs_is_restarted_and_the_digest_is_unchanged() {
    is_found(&["sensor-sim"], 1500);
}

#[test]
fn a_supervisor_that_hangs_is_restarted_by_the_warden_and_the_digest_is_unchanged() {
    is_found(&["supervisor"], 2500);
}

#[test]
fn an_estimator_that_hangs_while_nobody_watches_is_found_by_the_supervisor_that_comes_back() {
    is_found(&["slosh-id", "supervisor"], 700);
}

#[test]
fn who_is_stopped_as_it_starts_is_found_before_a_start_may_take() {
    let world = World::new();
    for name in ["supervisor", "sensor-sim", "modal-id"] {
        let mut run = world.start(&[]);
        run.process(name).signal(Signal::STOP);
        let ended = run.end();
        assert_eq!(ended.code, Some(0), "{ended}");
        assert_eq!(ended.digest(), undisturbed().digest, "{ended}");
        assert_eq!(ended.hangs(), [name], "{ended}");
        // A start may take 5 s.
        let detected = ended.json["deaths"].as_array().unwrap().iter().find(|death| death["cause"] == "hang").unwrap();
        assert!(detected["detect_ms"].as_f64().unwrap() < 4000.0, "{detected}");
    }
    world.assert_nothing_left();
}

#[test]
fn a_warden_that_hangs_is_noticed_by_the_console_and_the_run_ends_with_the_reason() {
    let world = World::new();
    let mut run = world.start(&["--speed", "5"]);
    run.wait_for_housekeeping();
    run.process("warden").signal(Signal::STOP);
    let ended = run.end();
    assert_eq!(ended.code, Some(1), "{ended}");
    assert!(ended.failure().contains("the warden hung"), "{ended}");
    world.assert_nothing_left();
}

/// What the manager of a run is told.
fn words(arguments: &[&str]) -> (i32, Vec<String>) {
    let world = World::new();
    let socket = world.file("word");
    let manager = UnixDatagram::bind(&socket).unwrap();
    manager.set_nonblocking(true).unwrap();
    let ended = world.start_under(Some(&socket), arguments).end();
    world.assert_nothing_left();
    let mut word = [0; 64];
    let next = || manager.recv(&mut word).ok().map(|count| String::from_utf8_lossy(&word[..count]).into_owned());
    (ended.code.unwrap(), std::iter::from_fn(next).collect())
}

#[test]
fn a_watchdog_is_stroked_by_the_warden_alone_while_every_partition_is_up() {
    // Five seconds of flight, a stroke each half of one.
    let (code, told) = words(&["--speed", "9"]);
    assert_eq!((code, told[0].as_str()), (0, "READY=1"), "{told:?}");
    assert!(told.len() >= 4 && told[1..].iter().all(|word| word == "WATCHDOG=1"), "{told:?}");
    // Held down from its first frame on for longer than the run has patience.
    let world = World::new();
    let table = limits::table(&world, &[]);
    let text = std::fs::read_to_string(&table).unwrap();
    std::fs::write(&table, text.replace("back_off_ms = [0]", "back_off_ms = [3600000]")).unwrap();
    let (code, told) = words(&["--partitions", &table, "--stall-s", "4", "--kill-always", "slosh-id@0"]);
    assert_eq!(code, 1, "the run stands still and fails: {told:?}");
    // One may fall between its first frame and its death.
    assert!(told.iter().filter(|word| *word == "WATCHDOG=1").count() <= 1, "{told:?}");
}
