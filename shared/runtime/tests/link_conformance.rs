//! One suite of laws for both links: whatever holds in lockstep must hold in shared memory, and the
//! other way round.
//!
//! Several shared-memory links live in this one process, each as another partition; the
//! supervisor's creates the services and lives longest, as in a run.

#![forbid(unsafe_code)]

mod splitmix64;
mod toy_run;

use runtime::link::Link;
use runtime::lockstep::LockstepBus;
use runtime::rundir::{OwnedRunDir, RunDir};
use runtime::shm::{Role, ShmLink};
use splitmix64::splitmix64;
use std::path::Path;
use std::time::{Duration, Instant};
use telemetry::PartitionId::{InertialId, Recorder, SensorSim, SloshId, Supervisor};
use telemetry::{ESTIMATE_INERTIAL, IMU, PROGRESS, PartitionId, Stamps, TICK, TOPICS, TopicId};
use toy_run::toy_run;

/// A medium that partitions can join.
trait Medium {
    fn join(&self, id: PartitionId, inputs: &[TopicId]) -> Box<dyn Link>;
}

impl Medium for LockstepBus {
    fn join(&self, _id: PartitionId, _inputs: &[TopicId]) -> Box<dyn Link> {
        Box::new(LockstepBus::join(self))
    }
}

/// Shared memory under a private prefix and root; nothing of it is left on drop.
struct SharedMemory {
    supervisor: Option<ShmLink>,
    folder: OwnedRunDir,
}

impl SharedMemory {
    fn new() -> Self {
        let folder = OwnedRunDir::create(Path::new("/dev/shm"), &toy_run(&[SensorSim])).unwrap();
        let supervisor = join_shm(folder.dir(), Supervisor, &[], Role::Creates);
        SharedMemory { supervisor: Some(supervisor), folder }
    }
}

impl Drop for SharedMemory {
    fn drop(&mut self) {
        drop(self.supervisor.take());
        // What a clean end leaves is the one 16-byte file that the owner of the prefix removes.
        assert!(in_shared_memory(&self.folder.dir().prefix()).len() <= 1);
    }
}

impl Medium for SharedMemory {
    fn join(&self, id: PartitionId, inputs: &[TopicId]) -> Box<dyn Link> {
        Box::new(join_shm(self.folder.dir(), id, inputs, Role::Opens))
    }
}

fn join_shm(dir: &RunDir, id: PartitionId, inputs: &[TopicId], role: Role) -> ShmLink {
    ShmLink::join(&dir.prefix(), &dir.iceoryx_root(), id, inputs, role).unwrap()
}

fn in_shared_memory(prefix: &str) -> Vec<String> {
    let names =
        std::fs::read_dir("/dev/shm").unwrap().flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    names.filter(|name| name.starts_with(prefix)).collect()
}

/// Runs one law over both media.
fn over_both(law: impl Fn(&dyn Medium)) {
    law(&LockstepBus::default());
    law(&SharedMemory::new());
}

type Message = (Stamps, Vec<u8>);

/// Any bit pattern: a link knows nothing of what it carries.
fn message(topic: TopicId, number: u64) -> Message {
    let mut state = number.wrapping_mul(1000) + topic as u64;
    let stamps = Stamps { epoch: number as u32, crc32: splitmix64(&mut state) as u32, sent_ns: splitmix64(&mut state) };
    let payload = (0..TOPICS[topic].size / 8).flat_map(|_| splitmix64(&mut state).to_le_bytes()).collect();
    (stamps, payload)
}

fn publish(link: &mut dyn Link, topic: TopicId, numbers: impl Iterator<Item = u64>) {
    for number in numbers {
        let (stamps, payload) = message(topic, number);
        link.publish(topic, &stamps, &payload).unwrap();
    }
}

fn drain(link: &mut dyn Link, topic: TopicId) -> Vec<Message> {
    let mut arrived = Vec::new();
    link.drain(topic, &mut |stamps, payload| arrived.push((*stamps, payload.to_vec()))).unwrap();
    arrived
}

/// Compares without printing kilobytes.
fn assert_messages(arrived: &[Message], topic: TopicId, numbers: impl Iterator<Item = u64>, law: &str) {
    let expected: Vec<Message> = numbers.map(|number| message(topic, number)).collect();
    let name = TOPICS[topic].name;
    assert_eq!(arrived.len(), expected.len(), "{law}: count of samples on {name}");
    for (at, (a, e)) in arrived.iter().zip(&expected).enumerate() {
        assert_eq!(a.0, e.0, "{law}: stamps of arrival {at} on {name}");
        assert!(a.1 == e.1, "{law}: body of arrival {at} on {name}");
    }
}

fn producer_of(topic: TopicId) -> PartitionId {
    PartitionId::named(TOPICS[topic].producers).unwrap_or(SensorSim)
}

fn all_topics() -> Vec<TopicId> {
    (0..TOPICS.len()).collect()
}

#[test]
fn samples_of_every_topic_arrive_in_order_and_byte_identical_with_their_stamps() {
    over_both(|medium| {
        let mut reader = medium.join(Recorder, &all_topics());
        for producer in [SensorSim, InertialId] {
            let mut writer = medium.join(producer, &[]);
            for topic in all_topics().into_iter().filter(|&topic| producer_of(topic) == producer) {
                let (first, last) = (1, TOPICS[topic].depth as u64);
                publish(&mut *writer, topic, first..=last);
                assert_messages(&drain(&mut *reader, topic), topic, first..=last, "order");
                publish(&mut *writer, topic, last + 1..=last + 3);
                assert_messages(&drain(&mut *reader, topic), topic, last + 1..=last + 3, "order, second drain");
                assert!(drain(&mut *reader, topic).is_empty());
            }
        }
    });
}

#[test]
fn a_full_buffer_drops_the_oldest_and_publish_never_waits_for_a_reader_that_sleeps() {
    over_both(|medium| {
        let mut reader = medium.join(Recorder, &all_topics());
        let mut writer = medium.join(SensorSim, &[]);
        for topic in [IMU.id, TICK.id, PROGRESS.id] {
            let depth = TOPICS[topic].depth as u64;
            publish(&mut *writer, topic, 1..=3 * depth + 7);
            assert_messages(&drain(&mut *reader, topic), topic, 2 * depth + 8..=3 * depth + 7, "overflow");
        }
    });
}

#[test]
fn a_late_joiner_finds_the_history_after_a_refresh() {
    over_both(|medium| {
        let mut writer = medium.join(SensorSim, &[]);
        let depth = TOPICS[IMU.id].depth as u64;
        publish(&mut *writer, IMU.id, 1..=depth + 5);
        publish(&mut *writer, TICK.id, 1..=3);
        let mut late = medium.join(SloshId, &[IMU.id, TICK.id]);
        writer.refresh().unwrap();
        assert_messages(&drain(&mut *late, IMU.id), IMU.id, 6..=depth + 5, "history");
        assert_messages(&drain(&mut *late, TICK.id), TICK.id, 1..=3, "history of a topic that is not full");
    });
}

#[test]
fn a_late_joiner_finds_the_history_before_the_next_sample() {
    over_both(|medium| {
        let mut writer = medium.join(SensorSim, &[]);
        publish(&mut *writer, TICK.id, 1..=9);
        let mut late = medium.join(SloshId, &[TICK.id]);
        publish(&mut *writer, TICK.id, 10..=11);
        assert_messages(&drain(&mut *late, TICK.id), TICK.id, 1..=11, "history, then new samples");
    });
}

#[test]
fn a_reader_that_comes_back_finds_what_it_missed() {
    over_both(|medium| {
        let mut writer = medium.join(SensorSim, &[]);
        let mut reader = medium.join(SloshId, &[TICK.id]);
        publish(&mut *writer, TICK.id, 1..=4);
        assert_eq!(drain(&mut *reader, TICK.id).len(), 4);
        drop(reader);
        publish(&mut *writer, TICK.id, 5..=8);
        let mut reader = medium.join(SloshId, &[TICK.id]);
        writer.refresh().unwrap();
        assert_messages(&drain(&mut *reader, TICK.id), TICK.id, 1..=8, "restarted reader");
    });
}

#[test]
fn two_producers_on_a_status_topic_both_arrive_each_in_its_order() {
    over_both(|medium| {
        let mut reader = medium.join(Recorder, &[PROGRESS.id]);
        let (mut one, mut other) = (medium.join(SensorSim, &[]), medium.join(SloshId, &[]));
        for number in 1..=5 {
            publish(&mut *one, PROGRESS.id, number..=number);
            publish(&mut *other, PROGRESS.id, 100 + number..=100 + number);
        }
        let arrived = drain(&mut *reader, PROGRESS.id);
        let (first, second): (Vec<_>, Vec<_>) = arrived.into_iter().partition(|(stamps, _)| stamps.epoch < 100);
        assert_messages(&first, PROGRESS.id, 1..=5, "first producer");
        assert_messages(&second, PROGRESS.id, 101..=105, "second producer");
    });
}

#[test]
fn a_talkative_producer_does_not_push_out_what_another_said() {
    // Pacing lives from this: the progress of the slowest partition must survive that of the fast
    // ones.
    over_both(|medium| {
        let mut reader = medium.join(Recorder, &[PROGRESS.id]);
        let (mut quiet, mut talkative) = (medium.join(SensorSim, &[]), medium.join(SloshId, &[]));
        publish(&mut *quiet, PROGRESS.id, 1..=1);
        publish(&mut *talkative, PROGRESS.id, 100..=199);
        let heard = |arrived: &[Message]| arrived.iter().filter(|(stamps, _)| stamps.epoch == 1).count();
        assert_eq!(heard(&drain(&mut *reader, PROGRESS.id)), 1, "the quiet one is heard by who listens");
        let mut late = medium.join(InertialId, &[PROGRESS.id]);
        for writer in [&mut quiet, &mut talkative] {
            writer.refresh().unwrap();
        }
        assert_eq!(heard(&drain(&mut *late, PROGRESS.id)), 1, "and by a late joiner");
    });
}

#[test]
fn what_was_delivered_outlives_its_producer_and_history_does_not() {
    // Why a restarted partition sends its last outputs again: nobody else can. Shared memory keeps
    // this promise to readers that have looked since the producer joined: only then have they
    // mapped its samples.
    over_both(|medium| {
        let mut reader = medium.join(Recorder, &[ESTIMATE_INERTIAL.id]);
        let mut writer = medium.join(InertialId, &[]);
        assert!(drain(&mut *reader, ESTIMATE_INERTIAL.id).is_empty());
        publish(&mut *writer, ESTIMATE_INERTIAL.id, 1..=3);
        drop(writer);
        let mut late = medium.join(SloshId, &[ESTIMATE_INERTIAL.id]);
        let mut writer = medium.join(InertialId, &[]);
        publish(&mut *writer, ESTIMATE_INERTIAL.id, 4..=4);
        assert_messages(
            &drain(&mut *reader, ESTIMATE_INERTIAL.id),
            ESTIMATE_INERTIAL.id,
            1..=4,
            "delivered before the death",
        );
        assert_messages(&drain(&mut *late, ESTIMATE_INERTIAL.id), ESTIMATE_INERTIAL.id, 4..=4, "history of the dead");
    });
}

#[test]
fn shared_memory_carries_nothing_that_was_not_asked_for_and_nothing_from_who_does_not_produce_it() {
    let medium = SharedMemory::new();
    let mut writer = Medium::join(&medium, SensorSim, &[]);
    let mut reader = Medium::join(&medium, SloshId, &[TICK.id]);
    publish(&mut *writer, IMU.id, 1..=3);
    publish(&mut *writer, TICK.id, 1..=1);
    assert!(drain(&mut *reader, IMU.id).is_empty());
    assert_eq!(drain(&mut *reader, TICK.id).len(), 1);
    let (stamps, payload) = message(IMU.id, 4);
    let refused = reader.publish(IMU.id, &stamps, &payload).unwrap_err().to_string();
    assert!(refused.contains("imu") && refused.contains("does not produce"), "{refused}");
}

#[test]
fn a_wake_ends_a_wait() {
    let medium = SharedMemory::new();
    let sleeper = join_shm(medium.folder.dir(), SloshId, &[], Role::Opens);
    let mut waker = Medium::join(&medium, SensorSim, &[]);
    let since = Instant::now();
    waker.wake(SloshId);
    waker.wake(InertialId);
    sleeper.wait(Duration::from_secs(60)).unwrap();
    assert!(since.elapsed() < Duration::from_secs(30), "the wait lasted to its time-out"); // 60 s when the wake is lost
    sleeper.wait(Duration::from_millis(1)).unwrap();
}

#[test]
fn a_run_that_ends_leaves_nothing_in_shared_memory() {
    let medium = SharedMemory::new();
    let (prefix, folder) = (medium.folder.dir().prefix(), medium.folder.dir().path().to_path_buf());
    let mut writer = Medium::join(&medium, SensorSim, &[]);
    let mut reader = Medium::join(&medium, Recorder, &all_topics());
    publish(&mut *writer, IMU.id, 1..=5);
    assert_eq!(drain(&mut *reader, IMU.id).len(), 5);
    assert!(in_shared_memory(&prefix).len() > TOPICS.len(), "the run was in shared memory at all");
    drop((writer, reader));
    drop(medium);
    assert_eq!(in_shared_memory(&prefix), Vec::<String>::new());
    assert!(!folder.exists());
}
