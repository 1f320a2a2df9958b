//! What holds of the whole system under faults: one result however it is carried out, whoever dies.
//!
//! "The same result" always means the same digest: identity of every estimate, mode and verdict
//! that was published. Each drill is also seen red: with the safeguard off that it proves
//! ([`sabotage`]).
//!
//! [`world`] is the only helper: start there.
#![forbid(unsafe_code)]

mod craft;
mod deaths;
mod ended;
mod give_up;
mod hang;
mod health;
mod kill;
mod kill_from_outside;
mod limits;
mod orderly_end;
mod orders;
mod process;
mod recordings;
mod rules;
mod sabotage;
mod scarcity;
mod world;

use world::{World, undisturbed};

/// All partitions of a run without a craft, in the order in which it starts them.
const PARTITIONS: [&str; 6] = ["sensor-sim", "inertial-id", "slosh-id", "modal-id", "supervisor", "recorder"];

#[test]
fn processes_over_shared_memory_give_the_digest_of_one_thread_in_lockstep_every_time() {
    let world = World::new();
    for _ in 0..3 {
        let ended = world.run(&[]);
        assert_eq!(ended.code, Some(0), "{ended}");
        assert_eq!(ended.digest(), undisturbed().digest, "{ended}");
        assert!(ended.deaths().is_empty() && ended.hangs().is_empty(), "{ended}");
        for name in PARTITIONS {
            let faults = ["lost", "bad", "restarts", "duplicates"].map(|column| ended.count(name, column));
            assert_eq!((ended.count(name, "frames"), faults), (undisturbed().frames, [0; 4]), "{name}: {ended}");
        }
    }
}

#[test]
fn another_seed_gives_another_digest_and_the_same_one_on_both_links() {
    let world = World::new();
    let (shm, lockstep) = (world.run(&["--seed", "7"]), world.lockstep(&["--seed", "7"]));
    assert_eq!(shm.digest(), lockstep.digest());
    assert_ne!(shm.digest(), undisturbed().digest, "noise does not enter the digest");
}

#[test]
fn the_short_scenario_reaches_every_experiment_so_that_its_digest_can_tell() {
    let of = |domain, phase| undisturbed().ended.estimates(domain, phase).len();
    let counts = [
        of("modal", "pre_capture"),
        of("slosh", "pre_capture"),
        of("inertial", "pre_capture"),
        of("inertial", "mated"),
    ];
    assert_eq!(counts, [4, 3, 8, 9]);
}
