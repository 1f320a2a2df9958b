//! The health table: who goes on dying climbs from restart over cold restart and the mode SAFE to
//! the end, and each rung is an event.

use crate::ended::{DEGRADED, Ended};
use crate::limits;
use crate::world::World;
use rustix::process::Signal;
use telemetry::HealthAction::{ColdRestart, GiveUp, Restart, SafeMode};
use telemetry::HealthError::{Hang, Kill};
use telemetry::HealthLevel::{Partition, Process};
use telemetry::PartitionId::{ModalId, SloshId, Supervisor};
use telemetry::{
    ACTUATORS, EVENT, Event, EventCode, HealthAction, HealthError, HealthLevel, Opcode, PartitionId, Stamps,
    TELECOMMAND,
};

const RISING: &str = r#"
[[health]]
level = "partition"
count = 2
action = "cold-restart"
acts_max = 1
[[health]]
level = "partition"
count = 3
action = "safe-mode"
[[health]]
level = "partition"
partition = "slosh-id"
count = 4
action = "give-up"
"#;
const OF_A_HANG: &str = "[[health]]\nlevel = \"process\"\nerror = \"hang\"\naction = \"cold-restart\"\n";
const OF_THE_MODULE: &str = r#"
[[health]]
level = "module"
count = 3
action = "safe-mode"
[[health]]
level = "module"
count = 5
action = "end-run"
"#;
const SAFE_AT_ONCE: &str = "[[health]]\nlevel = \"process\"\npartition = \"slosh-id\"\naction = \"safe-mode\"\n";

/// A table of limits with a health table.
fn table(world: &World, hanging: &[&str], rows: &str) -> String {
    let path = limits::table(world, hanging);
    let limits = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, format!("{limits}{rows}")).unwrap();
    path
}

/// A recording as far as these laws need it.
struct Flown {
    ended: Ended,
    recorded: recording::RecordedRun,
}

fn fly(world: &World, arguments: &[&str]) -> Flown {
    let file = world.file("flight.mcap");
    let ended = world.run(&[&["--record", file.to_str().unwrap()], arguments].concat());
    let recorded = recording::read_mcap(&file).unwrap_or_else(|error| panic!("{error}: {ended}"));
    Flown { ended, recorded }
}

type Act = (HealthAction, HealthError, HealthLevel, PartitionId);

impl Flown {
    fn events(&self, code: EventCode) -> impl Iterator<Item = (&Stamps, &Event)> {
        self.recorded.of(EVENT).filter(move |(_, event)| event.known_code() == Some(code))
    }

    /// What the supervisor reported of the warden's actions, in their order.
    fn acts(&self) -> Vec<Act> {
        let act = |(_, event): (&Stamps, &Event)| {
            let [action, error, level, partition] = event.argument.map(|code| code as u16);
            Some((
                HealthAction::from_code(action)?,
                HealthError::from_code(error)?,
                HealthLevel::from_code(level)?,
                PartitionId::from_code(partition)?,
            ))
        };
        self.events(EventCode::HealthActed).map(|event| act(event).unwrap()).collect()
    }

    /// Who began without a checkpoint, in which life.
    fn begun_anew(&self) -> Vec<(u16, u32)> {
        self.events(EventCode::BeganAnew).map(|(stamps, event)| (event.partition, stamps.epoch)).collect()
    }

    /// Frame from which the mode SAFE holds because it was ordered.
    fn safe_from(&self) -> Option<u64> {
        let modes = self.ended.modes();
        modes.iter().find(|(_, to, cause)| (*to, *cause) == ("SAFE", "safe command")).map(|mode| mode.0)
    }
}

#[test]
fn who_dies_in_every_life_climbs_from_restart_over_cold_restart_and_safe_mode_to_its_end() {
    let world = World::new();
    let table = table(&world, &[], RISING);
    let flown = fly(&world, &["--partitions", &table, "--kill-always", "slosh-id@700"]);
    let ended = &flown.ended;
    let rungs = [(Restart, Process), (ColdRestart, Partition), (SafeMode, Partition), (GiveUp, Partition)];
    assert_eq!(flown.acts(), rungs.map(|(action, level)| (action, Kill, level, SloshId)), "{ended}");

    // The life after the second death alone found no checkpoint.
    assert_eq!(flown.begun_anew(), [(SloshId.code(), 2)], "{ended}");
    // One order, recorded as one from the ground; the excitation ends with it.
    let ordered = flown.recorded.of(TELECOMMAND).map(|(_, command)| (command.opcode, command.partition));
    assert_eq!(ordered.collect::<Vec<_>>(), [(Opcode::Safe.code(), Supervisor.code())], "{ended}");
    let safe_ns = flown.safe_from().unwrap_or_else(|| panic!("{ended}")) * 10_000_000;
    let force_n = |of_time: &dyn Fn(u64) -> bool| {
        let samples = flown.recorded.of(ACTUATORS).filter(|(_, sample)| of_time(sample.header.t_meas_ns));
        samples.flat_map(|(_, sample)| sample.force_b_n).map(f64::abs).fold(0.0, f64::max)
    };
    assert!(force_n(&|t_ns| t_ns < safe_ns) > 40.0, "of 44 N");
    assert_eq!(force_n(&|t_ns| t_ns >= safe_ns), 0.0);
    // The end of the partition is none of the run.
    assert_eq!((ended.code, ended.given_up()), (Some(DEGRADED), vec!["slosh-id"]), "{ended}");
    assert_eq!(ended.count("slosh-id", "restarts"), 3, "{ended}");
}

#[test]
fn without_rows_the_same_deaths_lead_from_restart_to_the_end_and_neither_to_priors_nor_to_safe_mode() {
    let world = World::new();
    let table = table(&world, &[], "");
    let flown = fly(&world, &["--partitions", &table, "--kill-always", "slosh-id@700"]);
    let mut expected = vec![(Restart, Kill, Process, SloshId); 6];
    expected[5].0 = GiveUp;
    assert_eq!(flown.acts(), expected, "{}", flown.ended);
    assert_eq!((flown.begun_anew(), flown.safe_from()), (vec![], None), "{}", flown.ended);
}

#[test]
fn a_row_of_the_process_level_acts_on_its_error_at_once_and_on_no_other() {
    let world = World::new();
    let table = table(&world, &["slosh-id"], OF_A_HANG);
    let flown = fly(&world, &["--partitions", &table, "--kill", "modal-id@200", "--hang", "slosh-id@700"]);
    let acts = [(Restart, Kill, Process, ModalId), (ColdRestart, Hang, Process, SloshId)];
    assert_eq!(flown.acts(), acts, "{}", flown.ended);
    assert_eq!(flown.begun_anew(), [(SloshId.code(), 1)], "{}", flown.ended);
}

#[test]
fn errors_of_different_partitions_add_up_to_safe_mode_and_to_the_end_of_the_run() {
    let world = World::new();
    let table = table(&world, &[], OF_THE_MODULE);
    let flown = fly(&world, &["--partitions", &table, "--kill", "modal-id@200", "--kill-always", "slosh-id@650"]);
    let ended = &flown.ended;
    let acts: Vec<&str> = ended.log.iter().filter_map(|line| line.strip_prefix("slosh-id killed: ")).collect();
    assert_eq!(acts, ["safe mode (module)", "end of the run (module)"], "{ended}");
    // No frame follows in which the recorder would take the later ones.
    let restarts = [ModalId, SloshId].map(|partition| (Restart, Kill, Process, partition));
    assert!(flown.acts().starts_with(&restarts), "{ended}");
    assert_eq!(ended.failure(), "slosh-id killed: the health table ends the run");
    assert_eq!(ended.code, Some(1), "{ended}");
}

#[test]
fn a_safe_order_that_dies_with_the_supervisor_is_given_to_its_next_life() {
    let world = World::new();
    let table = table(&world, &[], SAFE_AT_ONCE);
    let mut run = world.start(&["--partitions", &table, "--speed", "4"]);
    run.wait_for_housekeeping();
    let supervisor = run.process("supervisor");
    supervisor.signal(Signal::STOP);
    run.process("slosh-id").signal(Signal::KILL);
    run.wait_until("the order", |run| run.said("slosh-id killed: safe mode (process)").then_some(()));
    supervisor.signal(Signal::KILL);
    let ended = run.end();
    let modes = ended.modes();
    assert!(modes.iter().any(|(_, to, cause)| (*to, *cause) == ("SAFE", "safe command")), "{ended}");
    assert_eq!(ended.count("supervisor", "restarts"), 1, "{ended}");
}
