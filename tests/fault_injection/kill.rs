//! SIGKILL at named points: inside a frame, after its outputs, in half a checkpoint, before the
//! first service.

use crate::PARTITIONS;
use crate::ended::{Ended, KILLED};
use crate::world::{World, undisturbed};
use recording::RecordedRun;
use telemetry::{Delivery, TICK, TOPICS};

/// Who is killed in which frame.
pub type Plan = Vec<(&'static str, u64)>;

/// Runs `plan` and checks that nothing but the log shows it; the deaths come in the log's order.
fn drill(world: &World, plan: &Plan, point: &str, more: &[&str]) -> Vec<String> {
    let kills: Vec<String> = plan.iter().map(|(name, frame)| format!("{name}@{frame}:{point}")).collect();
    let mut arguments: Vec<&str> = kills.iter().flat_map(|kill| ["--kill", kill]).collect();
    arguments.extend(more);
    let ended = world.run(&arguments);
    assert_eq!(ended.code, Some(0), "{kills:?}: {ended}");
    assert_eq!(ended.digest(), undisturbed().digest, "{kills:?}: {ended}");
    log_equals_plan(&ended, plan);
    ended.deaths().into_iter().map(|death| death.name).collect()
}

/// The warden's log of deaths and restarts is the injector's plan, name by name.
fn log_equals_plan(ended: &Ended, plan: &Plan) {
    let mut died = ended.deaths();
    died.sort();
    let mut planned: Vec<&str> = plan.iter().map(|(name, _)| *name).collect();
    planned.sort_unstable();
    let found: Vec<&str> = died.iter().map(|death| death.name.as_str()).collect();
    assert_eq!(found, planned, "{ended}");
    assert!(died.iter().all(|death| death.cause == KILLED), "{ended}");
    for name in PARTITIONS {
        assert_eq!(ended.count(name, "restarts"), u64::from(planned.contains(&name)), "{name}: {ended}");
        assert_eq!(ended.count(name, "lost"), 0, "{name}: {ended}");
        assert_eq!(ended.count(name, "frames"), undisturbed().frames, "{name}: {ended}");
    }
}

/// Everybody once, far enough apart (more than two pacing windows) that one is back before the next
/// one dies.
fn one_after_the_other(point: &str, shift: usize) {
    let world = World::new();
    let mut order = PARTITIONS;
    order.rotate_left(shift);
    let plan: Plan = order.into_iter().zip((0..).map(|k| 137 + 790 * k)).collect();
    assert_eq!(drill(&world, &plan, point, &[]), order);
}

#[test]
fn every_partition_killed_in_a_frame_leaves_the_digest_unchanged() {
    one_after_the_other("frame", 0);
}

#[test]
fn every_partition_killed_after_its_outputs_leaves_the_digest_unchanged() {
    one_after_the_other("publish", 2);
}

#[test]
fn every_partition_killed_with_half_a_checkpoint_leaves_the_digest_unchanged() {
    one_after_the_other("checkpoint", 4);
}

#[test]
fn every_partition_killed_before_it_has_opened_a_service_leaves_the_digest_unchanged() {
    let world = World::new();
    let died = drill(&world, &PARTITIONS.map(|name| (name, 0)).into(), "connect", &[]);
    assert_eq!(died[0], "supervisor", "it is started first and alone");
}

/// All but `spared` in one frame. (Services live as long as one process that holds them.)
fn all_but(spared: &str, frame: u64) -> Plan {
    PARTITIONS.into_iter().filter(|name| *name != spared).map(|name| (name, frame)).collect()
}

#[test]
fn producers_and_consumers_killed_in_one_frame_leave_the_digest_unchanged() {
    let world = World::new();
    // Frames: amid an experiment, at its closing estimate, at the change of mode that follows, in
    // capture.
    drill(&world, &all_but("recorder", 1337), "frame", &[]);
    drill(&world, &all_but("supervisor", 1060), "publish", &[]);
    drill(&world, &all_but("modal-id", 2780), "checkpoint", &[]);
    drill(&world, &all_but("sensor-sim", 2950), "publish", &[]);
}

#[test]
fn everybody_killed_in_one_frame_is_carried_over_by_checkpoints_although_the_services_may_vanish() {
    let world = World::new();
    for point in ["frame", "publish", "checkpoint"] {
        let kills = PARTITIONS.map(|name| format!("{name}@1500:{point}"));
        let arguments: Vec<&str> = kills.iter().flat_map(|kill| ["--kill", kill]).collect();
        let ended = world.run(&arguments);
        assert_eq!(ended.code, Some(0), "{ended}");
        assert_eq!(ended.digest(), undisturbed().digest, "{ended}");
        let killed = ended.deaths().into_iter().filter(|death| death.cause == KILLED).count();
        // Services made anew take down who has not come to its kill yet, and in its second life it
        // lives on.
        assert!((1..=PARTITIONS.len()).contains(&killed), "{ended}");
    }
}

#[test]
fn an_estimator_killed_at_its_closing_estimate_together_with_who_judges_it_sends_it_once() {
    let world = World::new();
    for (estimator, frame, point) in
        [("modal-id", 380, "frame"), ("slosh-id", 1060, "publish"), ("inertial-id", 2740, "checkpoint")]
    {
        drill(&world, &vec![(estimator, frame), ("supervisor", frame)], point, &[]);
    }
}

#[test]
fn kills_in_the_first_frame_leave_the_digest_unchanged() {
    let world = World::new();
    drill(&world, &all_but("recorder", 0), "frame", &[]);
    drill(&world, &all_but("inertial-id", 0), "publish", &[]);
    drill(&world, &all_but("supervisor", 0), "checkpoint", &[]);
}

#[test]
fn kills_in_the_last_frames_leave_the_digest_unchanged() {
    let world = World::new();
    let last = undisturbed().frames - 1;
    drill(&world, &all_but("supervisor", last), "frame", &[]);
    drill(&world, &all_but("sensor-sim", last), "publish", &[]);
    drill(&world, &all_but("slosh-id", last), "checkpoint", &[]);
}

#[test]
fn a_recording_made_under_kills_is_complete_and_has_the_digest_of_the_run() {
    let world = World::new();
    let file = world.file("flight.mcap");
    let file = file.to_str().unwrap();
    let plan =
        vec![("recorder", 700), ("sensor-sim", 1500), ("supervisor", 2300), ("slosh-id", 2300), ("inertial-id", 3900)];
    drill(&world, &plan, "publish", &["--record", file]);
    let digest = world.obsid(&["digest", file]);
    assert!(digest.status.success(), "{digest:?}");
    let text = String::from_utf8(digest.stdout).unwrap();
    assert_eq!(text.lines().next(), Some(undisturbed().digest.as_str()));
    // Not the results alone: each sample that belongs to a frame, once, in order. (A tick also says
    // how far the source had heard of results, which is a matter of timing.)
    let recorded = recording::read_mcap(file.as_ref()).unwrap();
    let of_frames = |topic: usize| TOPICS[topic].delivery != Delivery::Status && topic != TICK.id;
    for topic in (0..TOPICS.len()).filter(|&topic| of_frames(topic)) {
        let payloads = |run: &RecordedRun| {
            let of_topic = run.samples().filter(|sample| sample.topic == topic);
            of_topic.map(|sample| sample.payload.to_vec()).collect::<Vec<_>>()
        };
        let (found, wanted) = (payloads(&recorded), payloads(&undisturbed().recording));
        assert_eq!(found.len(), wanted.len(), "{}", TOPICS[topic].name);
        let different = found.iter().zip(&wanted).position(|(found, wanted)| found != wanted);
        assert_eq!(different, None, "{}: first different sample", TOPICS[topic].name);
    }
    assert!(recorded.of(TICK).map(|(_, tick)| tick.frame).eq(0..undisturbed().frames));
}
