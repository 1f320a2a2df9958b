//! Every safeguard switched off is seen to break the law it keeps: a check never seen red does not
//! count.

use crate::world::{World, undisturbed};

/// The drill is green as it is and gives another digest with the safeguard off.
fn breaks(drill: &[&str], safeguard_off: &str) {
    let world = World::new();
    let ended = world.run(drill);
    assert_eq!(ended.digest(), undisturbed().digest, "{ended}");
    let ended = world.run(&[drill, &["--sabotage", safeguard_off]].concat());
    assert_eq!(ended.code, Some(0), "{ended}");
    assert_ne!(ended.digest(), undisturbed().digest, "{safeguard_off} went unnoticed");
}

#[test]
fn taking_whatever_has_arrived_instead_of_what_the_tick_covers_changes_the_digest() {
    breaks(&[], "drain-by-topic");
}

#[test]
fn taking_repeated_samples_again_after_a_kill_changes_the_digest() {
    breaks(&["--kill", "supervisor@1337:publish"], "no-dedupe");
}

#[test]
fn taking_a_damaged_sample_for_good_changes_the_digest() {
    breaks(&["--corrupt", "1500"], "skip-crc");
}

#[test]
fn without_the_outbox_two_dead_wait_for_each_other_and_the_run_fails_by_its_stall_limit() {
    let world = World::new();
    let drill = ["--kill", "supervisor@1090", "--kill", "slosh-id@1090"];
    let ended = world.run(&drill);
    assert_eq!(ended.digest(), undisturbed().digest, "{ended}");
    let ended = world.run(&[&drill[..], &["--sabotage", "no-outbox", "--stall-s", "4"]].concat());
    assert_eq!(ended.code, Some(1), "{ended}");
    let (who, last) =
        ended.failure().split_once(": no frame was processed for 4 s (last: ").unwrap_or_else(|| panic!("{ended}"));
    assert!(who.contains("sensor-sim") && who.contains("waits for slosh-id"), "{ended}");
    let last: u64 = last.trim_end_matches(')').parse().unwrap();
    // The source goes on to a pacing window behind the frame of the kills, and no further.
    assert!((1090 - 40..=1090 + 40).contains(&last), "{ended}");
}

#[test]
fn a_damaged_sample_is_counted_by_everybody_who_gets_it_and_changes_nothing() {
    let world = World::new();
    let ended = world.run(&["--corrupt", "700", "--corrupt", "1500", "--corrupt", "3500"]);
    assert_eq!(ended.digest(), undisturbed().digest, "{ended}");
    let bad = crate::PARTITIONS.map(|name| ended.count(name, "bad"));
    // Consumers of the damaged topic (imu): inertial-id, slosh-id, supervisor, recorder; frame 700
    // has no such sample.
    assert_eq!(bad, [0, 2, 2, 0, 2, 2], "{ended}");
    assert!(crate::PARTITIONS.iter().all(|name| ended.count(name, "lost") == 0), "{ended}");
}
