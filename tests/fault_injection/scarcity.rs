//! Want of a disk, of descriptors, of memory: refused before the run with need and cure, or
//! declared.

use crate::ended::DEGRADED;
use crate::world::{World, undisturbed};

#[test]
fn a_full_disk_stops_the_recording_and_not_the_run() {
    let world = World::new();
    let ended = world.run(&["--record", "/dev/full"]);
    assert_eq!(ended.code, Some(DEGRADED), "{ended}");
    assert_eq!(ended.digest(), undisturbed().digest, "{ended}");
    let loss = &ended.json["loss"][0];
    assert_eq!((&ended.json["degraded"], &loss["kind"]), (&true.into(), &"recording_stopped".into()), "{ended}");
    assert!(loss["detail"].as_str().unwrap().contains("No space left on device"), "{ended}");
    assert!(ended.deaths().is_empty(), "{ended}");
}

#[test]
fn a_computer_that_is_not_enough_is_refused_before_the_run_with_need_have_and_cure() {
    let world = World::new();
    for (limit, what, cure) in [("-n 64", "descriptors", "ulimit -n 1024"), ("-v 400000", "address space", "MemoryMax")]
    {
        let refused = world.limited(limit, &["run", "--json"]);
        let said = String::from_utf8_lossy(&refused.stderr);
        assert_eq!(refused.status.code(), Some(3), "{said}");
        for word in [what, "needs", "there are", cure] {
            assert!(said.contains(word), "{word}: {said}");
        }
    }
    world.assert_nothing_left();
}
