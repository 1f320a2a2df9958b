//! The warden itself: who watches it, and what it says of a drill.

use crate::world::World;
use rustix::process::Signal;
use serde_json::Value;

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
