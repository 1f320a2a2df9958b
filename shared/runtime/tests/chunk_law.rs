//! What every partition rests on, with toys in lockstep: neither the grouping of frames into turns,
//! nor the delay of topics, nor the death and return of partitions changes one byte of the results
//! (architecture D1 to D6).
//!
//! The toys mix everything they see, in order, into one number: whoever sees another sample, or in
//! another frame, says something else for ever after. Each law is seen red with the safeguard
//! switched off.

#![forbid(unsafe_code)]

mod splitmix64;
mod toy_run;

use runtime::checkpoint::Store;
use runtime::config::{Fault, KillPoint, Sabotage};
use runtime::link::Link;
use runtime::lockstep::{LockstepBus, LockstepLink};
use runtime::runner::{RunError, Runner, Turn};
use runtime::{Frame, Outputs, Partition, RunConfig, StateError, restore_state, save_state};
use splitmix64::splitmix64;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use telemetry::PartitionId::{InertialId, Recorder, SensorSim, SloshId, Supervisor};
use telemetry::{
    ACCELEROMETERS, Accelerometers, ESTIMATE_INERTIAL, ESTIMATE_SLOSH, Estimate, IMU, Imu, InertialEstimate, JOINTS,
    Joints, MODE, Mode, PROGRESS, PartitionId, Progress, Sample, SloshEstimate, Stamps, TOPICS, Topic, TopicId,
    VERDICT, Verdict,
};
use toy_run::toy_run;
use zerocopy::IntoBytes;

const FRAMES: u64 = 300;
static WORLDS: AtomicU64 = AtomicU64::new(0);
const MEMBERS: [PartitionId; 5] = [Supervisor, SensorSim, InertialId, SloshId, Recorder];

/// Order and value of everything seen.
fn mix(memory: u64, bytes: &[u8]) -> u64 {
    bytes.chunks(8).fold(memory, |memory, chunk| {
        let word = chunk.iter().fold(0_u64, |word, &byte| word << 8 | u64::from(byte));
        let mut state = memory ^ word;
        splitmix64(&mut state)
    })
}

fn mix_all<T: Sample>(memory: u64, samples: &[T]) -> u64 {
    samples.iter().fold(memory, |memory, sample| mix(memory, sample.as_bytes()))
}

/// A number that 53 bits hold, so that it survives as `f64`.
fn as_f64(memory: u64) -> f64 {
    (memory >> 11) as f64
}

/// Sends samples whose values depend on the frame and on the modes so far.
#[derive(Default)]
struct Source {
    memory: u64,
}

impl Partition for Source {
    fn id(&self) -> PartitionId {
        SensorSim
    }
    fn inputs(&self) -> &'static [TopicId] {
        &[]
    }
    fn frame(&mut self, frame: &Frame<'_>, out: &mut Outputs) {
        self.memory = mix_all(self.memory, frame.samples(MODE));
        let value = as_f64(self.memory ^ frame.number);
        for part in 0..2 {
            let mut imu = Imu::zeroed_at(frame.t_ns + part * frame.period_ns / 2);
            imu.omega_bi_b_rad_s[0] = value + part as f64;
            out.publish(IMU, &imu);
        }
        let mut joints = Joints::zeroed_at(frame.t_ns);
        joints.angle_rad[0] = -value;
        out.publish(JOINTS, &joints);
        let mut batch = Accelerometers::zeroed_at(frame.t_ns);
        (batch.count, batch.channels) = (1, 1);
        batch.acceleration_m_s2[0][0] = 0.5 * value;
        out.publish(ACCELEROMETERS, &batch);
        if frame.number + 1 == FRAMES {
            out.end();
        }
    }
    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        save_state(&self.memory, state)
    }
    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        self.memory = restore_state(state)?;
        Ok(())
    }
}

/// Publishes what it has seen every `every` frames.
struct Estimator<T> {
    id: PartitionId,
    topic: Topic<T>,
    common: fn(&mut T) -> &mut Estimate,
    every: u64,
    memory: u64,
}

impl<T: Sample> Partition for Estimator<T> {
    fn id(&self) -> PartitionId {
        self.id
    }
    fn inputs(&self) -> &'static [TopicId] {
        const { &[IMU.id, JOINTS.id, ACCELEROMETERS.id] }
    }
    fn frame(&mut self, frame: &Frame<'_>, out: &mut Outputs) {
        let seen = mix_all(mix(self.memory, &frame.number.to_le_bytes()), frame.samples(MODE));
        let seen = mix_all(mix_all(seen, frame.samples(IMU)), frame.samples(JOINTS));
        self.memory = mix_all(seen, frame.samples(ACCELEROMETERS));
        if frame.number % self.every == self.every - 1 {
            let mut sample = T::zeroed_at(frame.t_ns);
            let common = (self.common)(&mut sample);
            (common.frame, common.values[0]) = (frame.number, as_f64(self.memory));
            out.publish(self.topic, &sample);
        }
    }
    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        save_state(&self.memory, state)
    }
    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        self.memory = restore_state(state)?;
        Ok(())
    }
}

/// Judges every estimate and changes the mode after about every third.
#[derive(Default)]
struct Judge {
    memory: u64,
}

impl Partition for Judge {
    fn id(&self) -> PartitionId {
        Supervisor
    }
    fn inputs(&self) -> &'static [TopicId] {
        const { &[ESTIMATE_INERTIAL.id, ESTIMATE_SLOSH.id] }
    }
    fn frame(&mut self, frame: &Frame<'_>, out: &mut Outputs) {
        let inertial = frame.samples(ESTIMATE_INERTIAL).iter().map(InertialEstimate::as_bytes);
        for estimate in inertial.chain(frame.samples(ESTIMATE_SLOSH).iter().map(SloshEstimate::as_bytes)) {
            self.memory = mix(mix(self.memory, &frame.number.to_le_bytes()), estimate);
            let mut verdict = Verdict::zeroed_at(frame.t_ns);
            (verdict.frame, verdict.measured) = (frame.number, as_f64(self.memory));
            out.publish(VERDICT, &verdict);
            if self.memory.is_multiple_of(3) {
                let mut mode = Mode::zeroed_at(frame.t_ns);
                (mode.frame, mode.measured) = (frame.number, as_f64(self.memory));
                out.publish(MODE, &mode);
            }
        }
    }
    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        save_state(&self.memory, state)
    }
    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        self.memory = restore_state(state)?;
        Ok(())
    }
}

/// (frame in which it was taken, topic, sequence number, time, body) of every result, in order.
type Stream = Vec<(u64, TopicId, u64, u64, Vec<u8>)>;

/// Keeps every result; its checkpoint holds all of them.
struct Collector {
    stream: Arc<Mutex<Stream>>,
}

impl Partition for Collector {
    fn id(&self) -> PartitionId {
        Recorder
    }
    fn inputs(&self) -> &'static [TopicId] {
        const { &[ESTIMATE_INERTIAL.id, ESTIMATE_SLOSH.id, VERDICT.id, MODE.id] }
    }
    fn frame(&mut self, frame: &Frame<'_>, _out: &mut Outputs) {
        for &topic in self.inputs() {
            for (_, payload) in frame.raw(topic) {
                let word = |at: usize| u64::from_le_bytes(payload[at..at + 8].try_into().unwrap());
                self.stream.lock().unwrap().push((frame.number, topic, word(8), word(16), payload.to_vec()));
            }
        }
    }
    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        save_state(&*self.stream.lock().unwrap(), state)
    }
    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        *self.stream.lock().unwrap() = restore_state(state)?;
        Ok(())
    }
}

/// Five toys on one bus, with checkpoints in a folder of their own.
struct World {
    bus: LockstepBus,
    run: RunConfig,
    stream: Arc<Mutex<Stream>>,
    runners: Vec<Runner<LockstepLink>>,
    folder: PathBuf,
    hold_back_seed: Option<u64>,
    restarts: u32,
}

impl Drop for World {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

impl World {
    fn new(run: RunConfig, hold_back_seed: Option<u64>) -> Self {
        // Tests run side by side, and several make a reference: every world has its own number.
        let number = WORLDS.fetch_add(1, Ordering::Relaxed);
        // On tmpfs, as in flight: a disk would be most of the time of this test.
        let folder = PathBuf::from(format!("/dev/shm/toys-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let stream = Arc::new(Mutex::new(Stream::new()));
        let bus = LockstepBus::default();
        let mut world = World { bus, run, stream, runners: Vec::new(), folder, hold_back_seed, restarts: 0 };
        world.runners = MEMBERS.iter().map(|&id| world.start(id, 0)).collect();
        world
    }

    fn start(&self, id: PartitionId, epoch: u32) -> Runner<LockstepLink> {
        let partition: Box<dyn Partition> = match id {
            SensorSim => Box::new(Source::default()),
            Supervisor => Box::new(Judge::default()),
            InertialId => {
                let common: fn(&mut InertialEstimate) -> &mut Estimate = |sample| &mut sample.estimate;
                Box::new(Estimator { id, topic: ESTIMATE_INERTIAL, common, every: 7, memory: 0 })
            }
            SloshId => {
                let common: fn(&mut SloshEstimate) -> &mut Estimate = |sample| &mut sample.estimate;
                Box::new(Estimator { id, topic: ESTIMATE_SLOSH, common, every: 11, memory: 0 })
            }
            _ => {
                self.stream.lock().unwrap().clear();
                Box::new(Collector { stream: Arc::clone(&self.stream) })
            }
        };
        let mut link = self.bus.join();
        if let Some(seed) = self.hold_back_seed {
            let mut state = seed ^ u64::from(id.code());
            link = link.with_hold_back(Box::new(move |_, waiting| match splitmix64(&mut state) % 4 {
                0 => 0,
                1 => waiting / 2,
                _ => waiting,
            }));
        }
        let store = Store::new(&self.folder, id.text());
        Runner::start(partition, link, &self.run, epoch, Some(store))
            .unwrap()
            .with_fault_hook(|_| resume_unwind(Box::new(Killed)))
    }

    /// Ends the runners `which` as a crash would, all at once, then starts them again in the same
    /// order.
    fn kill(&mut self, which: &[usize]) {
        // A dead process leaves its place on the bus; the order of the others stays.
        let kept = core::mem::take(&mut self.runners);
        let (dead, mut kept): (Vec<_>, Vec<_>) =
            kept.into_iter().enumerate().partition(|(index, _)| which.contains(index));
        let ends: Vec<(usize, PartitionId, u32)> = dead.iter().map(|(index, r)| (*index, r.id(), r.epoch())).collect();
        drop(dead);
        for (index, id, epoch) in ends {
            kept.push((index, self.start(id, epoch + 1)));
            self.restarts += 1;
        }
        kept.sort_by_key(|(index, _)| *index);
        self.runners = kept.into_iter().map(|(_, runner)| runner).collect();
    }

    /// Turns everybody until all have finished. `chunk` bounds the frames of a turn; `before_turn`
    /// may kill.
    fn run(&mut self, mut chunk: impl FnMut() -> u64, mut before_turn: impl FnMut(&mut World)) -> Result<(), RunError> {
        let mut idle_rounds = 0;
        while idle_rounds < 200 {
            let (mut finished, mut worked) = (0, false);
            for index in 0..self.runners.len() {
                before_turn(self);
                let frames = chunk();
                let turn = catch_unwind(AssertUnwindSafe(|| self.runners[index].turn(frames)));
                match turn {
                    Err(cause) if cause.is::<Killed>() => self.kill(&[index]),
                    Err(cause) => resume_unwind(cause),
                    Ok(turn) => match turn? {
                        Turn::Finished => finished += 1,
                        Turn::Worked(_) => worked = true,
                        Turn::Idle => self.runners[index].beat()?,
                    },
                }
                self.check_pacing();
            }
            if finished == self.runners.len() {
                return Ok(());
            }
            idle_rounds = if worked { 0 } else { idle_rounds + 1 };
        }
        let state: Vec<String> =
            self.runners.iter().map(|r| format!("{} after {} frames", r.id(), r.frames_done())).collect();
        Err(RunError::Stalled(state.join(", ")))
    }

    /// The source is never more than W frames ahead of what the slowest partition has done.
    fn check_pacing(&self) {
        let done =
            |id: PartitionId| self.runners.iter().find(|runner| runner.id() == id).map_or(0, Runner::frames_done);
        let slowest = MEMBERS.iter().map(|&id| done(id)).min().unwrap_or(0);
        if self.run.sabotage == Sabotage::None {
            assert!(
                done(SensorSim) <= slowest + self.run.window_frames,
                "source {} slowest {slowest}",
                done(SensorSim)
            );
        }
    }

    fn results(&self) -> Stream {
        self.stream.lock().unwrap().clone()
    }
}

/// What a toy dies of in a drill.
struct Killed;

fn reference() -> Stream {
    let mut world = World::new(toy_run(&MEMBERS), None);
    world.run(|| 1, |_| {}).unwrap();
    world.results()
}

/// One run with random grouping and random delays.
fn grouped(seed: u64, sabotage: Sabotage) -> Stream {
    let run = RunConfig { sabotage, ..toy_run(&MEMBERS) };
    let mut world = World::new(run, Some(seed.wrapping_mul(77)));
    let mut state = seed;
    world.run(|| 1 + splitmix64(&mut state) % 40, |_| {}).unwrap();
    world.results()
}

fn assert_same(found: &Stream, expected: &Stream, what: &str) {
    let first = found.iter().zip(expected).position(|(a, b)| a != b);
    let at = |stream: &Stream| {
        first.and_then(|first| stream.get(first)).map(|(frame, topic, seq, ..)| (*frame, *topic, *seq))
    };
    assert!(
        found == expected,
        "{what}: {} of {} results, first difference {:?} for {:?}",
        found.len(),
        expected.len(),
        at(found),
        at(expected)
    );
}

#[test]
fn the_toys_say_something_and_listen_to_each_other() {
    let stream = reference();
    let count = |id: TopicId| stream.iter().filter(|(_, topic, ..)| *topic == id).count() as u64;
    // What is made in the last W = 20 frames is due after the end.
    assert_eq!(count(ESTIMATE_INERTIAL.id), (FRAMES - 20) / 7);
    assert_eq!(count(ESTIMATE_SLOSH.id), (FRAMES - 20) / 11);
    assert!(count(MODE.id) > 10 && count(VERDICT.id) > 50);
    for (frame, _, _, _, body) in &stream {
        let made = u64::from_le_bytes(body[24..32].try_into().unwrap());
        assert_eq!(*frame, made + 20, "a result takes effect one pacing window after it was made (D4)");
    }
}

#[test]
fn any_grouping_of_frames_and_any_delay_of_topics_gives_the_same_bytes() {
    let expected = reference();
    for seed in 0..40 {
        assert_same(&grouped(seed, Sabotage::None), &expected, &format!("seed {seed}"));
    }
}

#[test]
fn the_chunk_law_is_red_when_a_frame_takes_whatever_has_arrived() {
    let streams: BTreeSet<Stream> = (0..10).map(|seed| grouped(seed, Sabotage::DrainByTopic)).collect();
    assert!(streams.len() > 1, "ten groupings gave one stream: this toy world cannot see the sabotage");
}

/// One run in which a random partition dies at a random point of a random frame.
fn killed_at_a_point(seed: u64, sabotage: Sabotage) -> (Result<(), RunError>, Stream, u32) {
    let mut state = seed.wrapping_mul(31) + 5;
    let partition = MEMBERS[seed as usize % MEMBERS.len()];
    let point = [KillPoint::Frame, KillPoint::Publish, KillPoint::Checkpoint][splitmix64(&mut state) as usize % 3];
    let frame = splitmix64(&mut state) % FRAMES;
    let faults = vec![Fault::Kill { partition, frame, point }];
    let mut world = World::new(RunConfig { sabotage, faults, ..toy_run(&MEMBERS) }, None);
    let end = world.run(|| 1 + splitmix64(&mut state) % 40, |_| {});
    (end, world.results(), world.restarts)
}

#[test]
fn a_partition_killed_at_any_point_of_a_frame_changes_nothing() {
    let expected = reference();
    for seed in 0..60 {
        let (end, stream, restarts) = killed_at_a_point(seed, Sabotage::None);
        end.unwrap();
        assert_eq!(restarts, 1, "seed {seed}: the drill killed nobody");
        assert_same(&stream, &expected, &format!("seed {seed}"));
    }
}

#[test]
fn the_restart_law_is_red_when_seen_samples_are_taken_again() {
    let expected = reference();
    let differs = |seed: &u64| {
        let (end, stream, _) = killed_at_a_point(*seed, Sabotage::NoDedupe);
        end.is_err() || stream != expected
    };
    assert!((0..10).filter(differs).count() > 0);
}

/// Enough for every partition to die several times in one run.
const RESTARTS: u32 = 25;

/// One run in which, several times, a random set of partitions dies between two turns, all at once.
fn killed_together(seed: u64, sabotage: Sabotage) -> (Result<(), RunError>, Stream, u32) {
    let run = RunConfig { sabotage, ..toy_run(&MEMBERS) };
    let mut world = World::new(run, None);
    let (mut state, mut chunks) = (seed.wrapping_mul(131) + 7, seed);
    let end = world.run(
        || 1 + splitmix64(&mut chunks) % 40,
        |world| {
            if world.restarts < RESTARTS && splitmix64(&mut state).is_multiple_of(16) {
                let set = splitmix64(&mut state);
                let which: Vec<usize> = (0..MEMBERS.len()).filter(|index| set >> index & 1 == 1).collect();
                world.kill(&which);
            }
        },
    );
    let restarts = world.restarts;
    (end, world.results(), restarts)
}

#[test]
fn partitions_killed_together_again_and_again_change_nothing() {
    let expected = reference();
    for seed in 0..40 {
        let (end, stream, restarts) = killed_together(seed, Sabotage::None);
        end.unwrap_or_else(|error| panic!("seed {seed}, {restarts} restarts: {error}"));
        assert!(restarts > 0, "seed {seed}");
        assert_same(&stream, &expected, &format!("seed {seed}, {restarts} restarts"));
    }
}

#[test]
fn the_restart_law_is_red_when_the_last_outputs_are_not_sent_again() {
    let expected = reference();
    let differs = |seed: &u64| {
        let (end, stream, _) = killed_together(*seed, Sabotage::NoOutbox);
        end.is_err() || stream != expected
    };
    assert!((0..10).filter(differs).count() > 0);
}

#[test]
fn a_partition_killed_after_its_last_checkpoint_ends_at_once_when_it_is_back() {
    for (index, member) in MEMBERS.into_iter().enumerate() {
        let mut world = World::new(toy_run(&MEMBERS), None);
        world.run(|| 10, |_| {}).unwrap();
        let expected = world.results();
        world.kill(&[index]);
        world.run(|| 10, |_| {}).unwrap_or_else(|error| panic!("{member}: {error}"));
        assert_same(&world.results(), &expected, member.text());
        assert_eq!(world.runners[index].frames_done(), FRAMES, "{member}");
    }
}

#[test]
fn the_source_waits_for_the_checkpoint_of_a_partition_that_sleeps_and_not_longer() {
    for (sleeper, member) in MEMBERS.into_iter().enumerate() {
        let run = toy_run(&MEMBERS);
        let (window, every) = (run.window_frames, run.checkpoint_frames);
        let mut world = World::new(run, None);
        // Ten rounds of everybody, then the sleeper turns no more.
        for round in 0..60 {
            for index in (0..MEMBERS.len()).filter(|&index| index != sleeper || round < 10) {
                world.runners[index].turn(3).unwrap();
            }
        }
        if member != SensorSim {
            let source = world.runners.iter().find(|runner| runner.id() == SensorSim).unwrap().frames_done();
            let checkpointed = world.runners[sleeper].frames_done() / every * every;
            assert!(checkpointed > 0 && source == checkpointed + window, "{source} for {checkpointed} + {window}");
        }
    }
}

#[test]
fn a_damaged_progress_report_opens_no_frame() {
    let run = toy_run(&MEMBERS);
    let window = run.window_frames;
    let mut world = World::new(run, None);
    for runner in &mut world.runners {
        runner.turn(0).unwrap();
    }
    let mut rogue = world.bus.join();
    for partition in MEMBERS {
        let mut report = Progress::zeroed_at(0);
        (report.partition, report.frames_checkpointed) = (partition.code().into(), 1000);
        (report.header.layout, report.header.source) = (TOPICS[PROGRESS.id].layout, partition.code());
        report.header.seq = 1000;
        let stamps = Stamps { crc32: telemetry::crc32(report.as_bytes()) ^ 1, ..Stamps::default() };
        rogue.publish(PROGRESS.id, &stamps, report.as_bytes()).unwrap();
    }
    let source = world.runners.iter_mut().find(|runner| runner.id() == SensorSim).unwrap();
    source.turn(1000).unwrap();
    assert_eq!(source.frames_done(), window, "nobody has checkpointed a frame");
}
