//! SIGKILL from outside, at moments nobody planned: young processes, and wherever the others happen
//! to be.

use crate::PARTITIONS;
use crate::ended::{Death, Ended, FOUND_NOTHING, KILLED, TAKEN_DOWN};
use crate::process::Process;
use crate::world::{Run, World, undisturbed};
use rustix::process::Signal;
use std::time::Duration;

/// What was killed, as the warden's log should have it.
fn kill(process: &Process) -> Death {
    process.signal(Signal::KILL);
    Death { name: process.name.clone(), pid: process.pid, cause: KILLED.into() }
}

/// Kills `name` when it has lived for `age`.
fn kill_young(run: &mut Run, name: &str, age: Duration) -> Death {
    let process = run.process(name);
    process.ends_within(age);
    kill(&process)
}

/// The result is that of the undisturbed run, and the warden's log has every kill of ours and no
/// other.
fn is_undisturbed(ended: &Ended, killed: &[Death]) {
    assert_eq!(ended.code, Some(0), "{ended}");
    assert_eq!(ended.digest(), undisturbed().digest, "{ended}");
    let died = ended.deaths();
    for kill in killed {
        // Who was being taken down when our kill came may stand in the log with that cause.
        let logged = died.iter().find(|death| (death.pid, &death.name) == (kill.pid, &kill.name));
        assert!(logged.is_some(), "{kill:?} is not in the log: {ended}");
    }
    for death in died {
        // The services vanish with the last process that has opened them: then, and only then,
        // others die too.
        let consequence = death.cause == FOUND_NOTHING || death.cause == TAKEN_DOWN;
        assert!(consequence || killed.contains(&death), "{death:?} was not planned: {ended}");
    }
}

#[test]
fn a_supervisor_killed_while_it_creates_the_services_wedges_nothing() {
    let world = World::new();
    for round in 0..6 {
        let mut run = world.start(&[]);
        let killed = kill_young(&mut run, "supervisor", Duration::from_micros(2000 * round));
        let ended = run.end();
        world.assert_nothing_left();
        is_undisturbed(&ended, &[killed]);
    }
}

/// A young process, then three others a few frames apart; what dies is chosen by the round.
fn kills_at_any_moment(rounds: impl Iterator<Item = usize>) {
    let world = World::new();
    for round in rounds {
        let mut run = world.start(&[]);
        let mut killed = vec![kill_young(&mut run, PARTITIONS[round % 6], Duration::from_micros(1300 * round as u64))];
        for k in 1..4 {
            let victim = run.process(PARTITIONS[(round + k * (1 + round / 6)) % 6]);
            victim.ends_within(Duration::from_millis((17 * round as u64 + 31 * k as u64) % 60));
            killed.push(kill(&victim));
        }
        let ended = run.end();
        world.assert_nothing_left();
        is_undisturbed(&ended, &killed);
    }
}

#[test]
fn kills_at_any_moment_leave_the_digest_unchanged() {
    kills_at_any_moment((0..10).step_by(2));
}

#[test]
fn other_kills_at_any_moment_leave_the_digest_unchanged() {
    kills_at_any_moment((1..10).step_by(2));
}

#[test]
fn who_is_killed_while_the_others_end_ends_too_and_the_result_is_complete() {
    let world = World::new();
    for name in PARTITIONS {
        let mut run = world.start(&[]);
        let first = if name == "sensor-sim" { "inertial-id" } else { "sensor-sim" };
        let (first, victim) = (run.process(first), run.process(name));
        run.wait_until("the end of the first", |_| first.ends_within(Duration::ZERO).then_some(()));
        victim.signal(Signal::KILL);
        let ended = run.end();
        world.assert_nothing_left();
        assert_eq!(ended.code, Some(0), "{ended}");
        assert_eq!(ended.digest(), undisturbed().digest, "{ended}");
    }
}
