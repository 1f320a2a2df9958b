//! Commands, tables and events of partitions in lockstep: a command takes effect in one frame
//! everywhere, once, however partitions die and however often it is sent; a run that is given the
//! commands of another one repeats it.

#![forbid(unsafe_code)]

mod toy_run;

use runtime::checkpoint::Store;
use runtime::link::Link;
use runtime::lockstep::{LockstepBus, LockstepLink, run_to_end};
use runtime::orders::{StoredCommand, datagram};
use runtime::runner::{Runner, Turn};
use runtime::{Frame, Outputs, Partition, RunConfig, StateError, restore_state, save_state};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use telemetry::PartitionId::{InertialId, SensorSim, SloshId, Supervisor};
use telemetry::{
    EVENT, EVERY_PARTITION, Event, EventCode, IMU, Imu, Opcode, PartitionId, Refusal, Sample, TELECOMMAND, TableId,
    TableValues, Telecommand, TopicId,
};
use toy_run::toy_run;
use zerocopy::FromBytes;

const FRAMES: u64 = 200;
const MEMBERS: [PartitionId; 4] = [Supervisor, SensorSim, InertialId, SloshId];
const WINDOW: u64 = 20;

/// Ends the run after [`FRAMES`] frames.
struct Source;

impl Partition for Source {
    fn id(&self) -> PartitionId {
        SensorSim
    }
    fn inputs(&self) -> &'static [TopicId] {
        &[]
    }
    fn frame(&mut self, frame: &Frame<'_>, out: &mut Outputs) {
        out.publish(IMU, &Imu::zeroed_at(frame.t_ns));
        if frame.number + 1 == FRAMES {
            out.end();
        }
    }
    fn save(&mut self, _: &mut Vec<u8>) -> Result<(), StateError> {
        Ok(())
    }
    fn restore(&mut self, _: &[u8]) -> Result<(), StateError> {
        Ok(())
    }
}

/// Adds up the base rate limit of its table in every frame: another value, or another frame of its
/// activation, gives another sum.
struct Toy {
    id: PartitionId,
    limit: f64,
    sum: f64,
    mode_commands: u64,
    /// Events that it reports in every frame.
    flood: u64,
}

impl Toy {
    fn boxed(id: PartitionId, flood: u64) -> Box<dyn Partition> {
        if id == SensorSim {
            Box::new(Source)
        } else {
            Box::new(Toy { id, limit: 1.0, sum: 0.0, mode_commands: 0, flood })
        }
    }
}

impl Partition for Toy {
    fn id(&self) -> PartitionId {
        self.id
    }
    fn inputs(&self) -> &'static [TopicId] {
        &[IMU.id]
    }
    fn frame(&mut self, frame: &Frame<'_>, out: &mut Outputs) {
        self.sum += self.limit * (frame.number + 1) as f64;
        self.mode_commands += frame.mode_commands().count() as u64;
        for k in 0..self.flood {
            out.publish(EVENT, &Event::new(EventCode::SamplesLost, self.id, 0, &[k as f64, 0.0]));
        }
        if frame.ended {
            // What it has come to is the last word of its life.
            let numbers = [self.sum, self.mode_commands as f64];
            out.publish(EVENT, &Event::new(EventCode::Ended, self.id, 0, &numbers));
        }
    }
    fn obeys_mode_commands(&self) -> bool {
        self.id == Supervisor
    }
    fn table(&self, table: TableId) -> Option<TableValues> {
        let values = [self.limit, 0.0, 0.0, 0.0, 0.0, 0.0];
        (table == TableId::Guards && self.id == Supervisor).then(|| TableValues::checked(table, &values).unwrap())
    }
    fn activate(&mut self, _: TableId, values: &TableValues) {
        self.limit = values.as_slice()[0];
    }
    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        save_state(&(self.sum, self.mode_commands), state)
    }
    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        (self.sum, self.mode_commands) = restore_state(state)?;
        Ok(())
    }
}

/// Four partitions, and an observer of commands and events.
struct World {
    run: RunConfig,
    bus: LockstepBus,
    runners: Vec<Option<Runner<LockstepLink>>>,
    observer: LockstepLink,
    epochs: [u32; MEMBERS.len()],
    folder: PathBuf,
    flood: u64,
    commands: Vec<Telecommand>,
    events: Vec<Event>,
}

impl World {
    fn new(commands: Vec<StoredCommand>, flood: u64) -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        // Thousands of checkpoints: in memory.
        let folder = PathBuf::from(format!("/dev/shm/commands-law-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let bus = LockstepBus::default();
        let observer = bus.join();
        let run = RunConfig { commands, ..toy_run(&MEMBERS) };
        assert_eq!(run.window_frames, WINDOW);
        let runners = MEMBERS.iter().map(|_| None).collect();
        let (commands, events) = (Vec::new(), Vec::new());
        let mut world = World { run, bus, runners, observer, epochs: [0; 4], folder, flood, commands, events };
        (0..MEMBERS.len()).for_each(|member| world.start(member));
        world
    }

    fn start(&mut self, member: usize) {
        let id = MEMBERS[member];
        let store = Store::new(&self.folder, id.text());
        let partition = Toy::boxed(id, if id == SloshId { self.flood } else { 0 });
        let epoch = self.epochs[member];
        self.runners[member] = Some(Runner::start(partition, self.bus.join(), &self.run, epoch, Some(store)).unwrap());
    }

    /// Dies without a word and comes back from its checkpoint.
    fn restart(&mut self, member: usize) {
        self.runners[member] = None;
        self.epochs[member] += 1;
        self.start(member);
    }

    fn supervisor(&mut self) -> &mut Runner<LockstepLink> {
        self.runners[0].as_mut().unwrap()
    }

    fn send(&mut self, command: Telecommand) {
        self.supervisor().take_command(&datagram(command)).unwrap();
    }

    /// One frame at most of every partition; whether the run is over.
    fn turn(&mut self) -> bool {
        let mut ended = true;
        for runner in &mut self.runners {
            ended &= runner.as_mut().unwrap().turn(1).unwrap() == Turn::Finished;
        }
        self.observe();
        ended
    }

    fn observe(&mut self) {
        let (commands, events) = (&mut self.commands, &mut self.events);
        self.observer
            .drain(TELECOMMAND.id, &mut |_, payload| {
                let command = Telecommand::read_from_bytes(payload).unwrap();
                // A supervisor that comes back sends its last ones again.
                if !commands.contains(&command) {
                    commands.push(command);
                }
            })
            .unwrap();
        self.observer.drain(EVENT.id, &mut |_, payload| events.push(Event::read_from_bytes(payload).unwrap())).unwrap();
    }

    fn fly(&mut self) {
        let mut turns = 0;
        while !self.turn() {
            turns += 1;
            assert!(turns < 100 * FRAMES, "the run does not end");
        }
    }

    fn of(&self, code: EventCode) -> Vec<Event> {
        self.events.iter().filter(|event| event.known_code() == Some(code)).copied().collect()
    }

    /// What the toys have come to, by partition.
    fn ends(&self) -> Vec<(u16, f64, f64)> {
        let mut ends: Vec<_> =
            self.of(EventCode::Ended).iter().map(|end| (end.partition, end.argument[0], end.argument[1])).collect();
        ends.sort_by(|one, other| one.partial_cmp(other).unwrap());
        ends.dedup();
        ends
    }
}

impl Drop for World {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn command(opcode: Opcode, key: u64, sequence: u32) -> Telecommand {
    let partition = if opcode == Opcode::Ping { EVERY_PARTITION } else { Supervisor.code() };
    Telecommand { opcode: opcode.code(), partition, key, sequence, ..Telecommand::zeroed_at(0) }
}

fn table(opcode: Opcode, key: u64, sequence: u32, limit: f64) -> Telecommand {
    let mut command = Telecommand { table: TableId::Guards.code(), version: 3, ..command(opcode, key, sequence) };
    if opcode == Opcode::LoadTable {
        (command.count, command.values[0]) = (6, limit);
    }
    command
}

#[test]
fn a_command_is_carried_out_in_one_frame_by_everybody_and_that_frame_is_in_the_sample() {
    let mut world = World::new(Vec::new(), 0);
    for frame in 0..40 {
        if frame == 17 {
            world.send(command(Opcode::Ping, 7, 1));
        }
        world.turn();
    }
    world.fly();
    let [sent] = world.commands[..] else { panic!("{:?}", world.commands) };
    assert_eq!(sent.effective_frame, sent.frame + WINDOW);
    let done = world.of(EventCode::CommandExecuted);
    assert_eq!(done.len(), MEMBERS.len());
    for event in done {
        assert_eq!(event.argument[..3], [7.0, f64::from(Opcode::Ping.code()), sent.effective_frame as f64]);
    }
}

#[test]
fn a_run_with_the_commands_of_another_one_repeats_them_frame_by_frame() {
    let mut first = World::new(Vec::new(), 0);
    for frame in 0..100 {
        match frame {
            10 => first.send(table(Opcode::LoadTable, 1, 1, 2.5)),
            30 => first.send(table(Opcode::ActivateTable, 2, 2, 0.0)),
            31 => first.send(command(Opcode::Safe, 3, 3)),
            _ => {}
        }
        first.turn();
    }
    first.fly();
    let stored = first.commands.iter().map(|command| StoredCommand {
        frame: command.frame,
        bytes: datagram(Telecommand { frame: 0, effective_frame: 0, header: telemetry::Header::at(0), ..*command }),
    });
    let mut second = World::new(stored.collect(), 0);
    second.fly();
    assert_eq!(first.commands.len(), 3);
    assert_eq!(second.commands, first.commands);
    assert_eq!(second.ends(), first.ends());
    // and the commands are what made the difference
    let mut without = World::new(Vec::new(), 0);
    without.fly();
    assert!(without.commands.is_empty());
    assert_ne!(without.ends(), first.ends());
}

#[test]
fn whoever_dies_whenever_a_command_is_carried_out_once_in_its_frame() {
    let run = |death: Option<(usize, u64)>| {
        let mut world = World::new(Vec::new(), 0);
        let mut accepted = [false; 3];
        for turn in 0..90 {
            if death.is_some_and(|(_, at)| at == turn) {
                world.restart(death.unwrap().0);
            }
            // The ground sends the same keys until they are accepted.
            if turn >= 8 {
                let orders = [
                    table(Opcode::LoadTable, 1, 1, 2.5),
                    table(Opcode::ActivateTable, 2, 2, 0.0),
                    command(Opcode::Safe, 3, 3),
                ];
                let next = accepted.iter().position(|accepted| !accepted);
                next.into_iter().for_each(|next| world.send(orders[next]));
            }
            world.turn();
            for event in world.of(EventCode::CommandAccepted) {
                accepted[event.argument[0] as usize - 1] = true;
            }
        }
        world.fly();
        world
    };
    let undisturbed = run(None);
    assert_eq!(undisturbed.commands.len(), 3);
    for (member, name) in MEMBERS.iter().enumerate() {
        for turn in (5..60).step_by(2) {
            let world = run(Some((member, turn)));
            let keys: Vec<u64> = world.commands.iter().map(|command| command.key).collect();
            assert_eq!(keys, [1, 2, 3], "{name} dies in turn {turn}");
            let activated = world.commands[1].effective_frame;
            // limit 1 before the activation, 2.5 from its frame on; once safe
            let sum = |frames: std::ops::Range<u64>| frames.map(|frame| (frame + 1) as f64).sum::<f64>();
            let expected = sum(0..activated) + 2.5 * sum(activated..FRAMES);
            let end = world.ends().into_iter().find(|end| end.0 == Supervisor.code()).unwrap();
            assert_eq!((end.1, end.2), (expected, 1.0), "{name} dies in turn {turn}");
        }
    }
}

#[test]
fn a_command_is_known_to_nobody_before_a_checkpoint_holds_it() {
    let mut world = World::new(Vec::new(), 0);
    (0..6).for_each(|_| _ = world.turn());
    world.send(command(Opcode::Ping, 7, 1));
    world.restart(0);
    world.fly();
    assert!(world.commands.is_empty() && world.of(EventCode::CommandAccepted).is_empty());
}

#[test]
fn a_refused_command_changes_nothing_and_the_reason_is_said() {
    let mut world = World::new(Vec::new(), 0);
    (0..4).for_each(|_| _ = world.turn());
    world.send(command(Opcode::Ping, 7, 5));
    let good = command(Opcode::Ping, 8, 6);
    let mut bit = datagram(good);
    bit[40] ^= 1;
    let mut wild = table(Opcode::LoadTable, 8, 6, -1.0);
    wild.count = 6;
    let cases = [
        (bit, Refusal::NotWhole),
        (datagram(good)[1..].to_vec(), Refusal::NotWhole),
        (datagram(Telecommand { opcode: 99, ..good }), Refusal::UnknownCommand),
        (datagram(Telecommand { partition: PartitionId::ModalId.code(), ..good }), Refusal::UnknownPartition),
        (datagram(Telecommand { partition: SloshId.code(), ..command(Opcode::Safe, 8, 6) }), Refusal::NotForIt),
        (datagram(Telecommand { partition: SloshId.code(), ..table(Opcode::LoadTable, 8, 6, 1.0) }), Refusal::NotForIt),
        (datagram(Telecommand { sequence: 5, ..good }), Refusal::SequenceOld),
        (datagram(Telecommand { key: 0, ..good }), Refusal::KeyTooLarge),
        (datagram(wild), Refusal::OutOfRange),
        (datagram(Telecommand { count: 33, ..table(Opcode::LoadTable, 8, 6, 1.0) }), Refusal::OutOfRange),
    ];
    for (bytes, refusal) in cases {
        world.events.clear();
        world.supervisor().take_command(&bytes).unwrap();
        world.observe();
        let said = world.of(EventCode::CommandRefused).first().map(|event| event.argument[2]);
        assert_eq!(said, Some(f64::from(refusal.code())), "{refusal}");
    }
    world.fly();
    assert_eq!(world.commands.iter().map(|command| command.key).collect::<Vec<_>>(), [7]);
}

#[test]
fn a_table_that_was_not_loaded_cannot_be_activated_and_the_bad_field_of_a_bad_one_is_named() {
    let mut world = World::new(Vec::new(), 0);
    world.send(table(Opcode::ActivateTable, 1, 1, 0.0));
    world.send(table(Opcode::LoadTable, 2, 2, -4.0));
    world.fly();
    let refused = world.of(EventCode::CommandRefused);
    let reasons: Vec<f64> = refused.iter().map(|event| event.argument[2]).collect();
    assert!(reasons.contains(&f64::from(Refusal::NothingLoaded.code())), "{reasons:?}");
    assert_eq!(world.of(EventCode::TableRefused)[0].argument[..3], [f64::from(TableId::Guards.code()), 0.0, -4.0]);
    assert!(world.of(EventCode::TableActivated).is_empty());
}

#[test]
fn a_key_that_is_sent_a_hundred_times_is_executed_once() {
    let mut world = World::new(Vec::new(), 0);
    for turn in 0..100 {
        world.send(command(Opcode::Safe, 7, turn + 1));
        world.turn();
    }
    world.fly();
    assert_eq!((world.commands.len(), world.of(EventCode::CommandExecuted).len()), (1, 1));
    assert_eq!(world.ends().into_iter().find(|end| end.0 == Supervisor.code()).unwrap().2, 1.0);
}

#[test]
fn a_flood_of_events_is_squelched_and_counted_and_changes_no_result() {
    let (mut quiet, mut flooded) = (World::new(Vec::new(), 0), World::new(Vec::new(), 100));
    quiet.fly();
    flooded.fly();
    // 100 a frame of 10 ms: ten thousand a second
    let seconds = FRAMES / 100;
    let sent = flooded.of(EventCode::SamplesLost);
    assert!(!sent.is_empty() && sent.len() as u64 <= 8 * (seconds + 1), "{}", sent.len());
    let counts = flooded.runners[3].as_ref().unwrap().event_counts();
    let said: u64 = sent.iter().map(|event| event.squelched).sum();
    assert_eq!(sent.len() as u64 + counts.squelched, 100 * FRAMES, "every one of them is sent or counted");
    flooded.runners[3].as_mut().unwrap().say_squelched(true).unwrap();
    flooded.observe();
    let summaries = flooded.of(EventCode::Squelched);
    let last: f64 =
        summaries.iter().filter(|event| event.partition == SloshId.code()).map(|event| event.argument[1]).sum();
    assert_eq!(said + last as u64, counts.squelched, "what is counted is said once");
    assert_eq!(flooded.ends(), quiet.ends());
}

#[test]
fn a_filter_that_is_loaded_and_activated_in_flight_holds_from_its_frame_on() {
    let mut world = World::new(Vec::new(), 1);
    let monitor = |opcode: Opcode, key, sequence| {
        let mut command = Telecommand {
            partition: SloshId.code(),
            table: TableId::Monitor.code(),
            version: 1,
            ..command(opcode, key, sequence)
        };
        let fields = TableId::Monitor.fields();
        for (value, field) in command.values.iter_mut().zip(fields).filter(|_| opcode == Opcode::LoadTable) {
            *value = match field.name {
                "samples_lost" => 0.0,
                "severity" => 0.0,
                _ => field.highest,
            };
        }
        Telecommand { count: if opcode == Opcode::LoadTable { fields.len() as u32 } else { 0 }, ..command }
    };
    world.send(monitor(Opcode::LoadTable, 1, 1));
    world.send(monitor(Opcode::ActivateTable, 2, 2));
    world.fly();
    let activated = world.of(EventCode::TableActivated);
    assert_eq!(activated.len(), 1);
    let frame = world.commands[1].effective_frame;
    assert!(world.of(EventCode::SamplesLost).iter().all(|event| event.frame <= frame));
    assert_eq!(world.runners[3].as_ref().unwrap().event_counts().filtered, FRAMES - frame);
}

#[test]
fn without_commands_nothing_is_sent_on_their_topic_in_any_grouping_of_frames() {
    for chunk in [1, 7, 25] {
        let bus = LockstepBus::default();
        let mut observer = bus.join();
        let run = toy_run(&MEMBERS);
        let start = |&id: &PartitionId| Runner::start(Toy::boxed(id, 0), bus.join(), &run, 0, None).unwrap();
        let mut runners: Vec<_> = MEMBERS.iter().map(start).collect();
        run_to_end(&mut runners, |_| chunk, || false).unwrap();
        let mut seen = 0;
        observer.drain(TELECOMMAND.id, &mut |_, _| seen += 1).unwrap();
        assert_eq!(seen, 0);
    }
}
