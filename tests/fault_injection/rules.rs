//! Rules of a run that flies: so many events of a kind become one command, which is stamped and
//! recorded as one from the ground.

use crate::world::{World, undisturbed};
use telemetry::{EVENT, EventCode, Opcode, PartitionId, TELECOMMAND};

const TABLE: &str = include_str!("../../deploy/partitions.toml");
/// The first fires at once and then pauses for longer than the run; the second at the second event.
const RULES: &str = r#"
[[rule]]
event = "bad-samples"
partition = "slosh-id"
count = 1
within_s = 600
order = "ping"
to = "slosh-id"
cool_down_s = 600
[[rule]]
event = "bad-samples"
partition = "inertial-id"
count = 2
within_s = 600
order = "clear-counters"
to = "modal-id"
cool_down_s = 600
"#;

#[test]
fn a_rule_orders_once_what_its_events_call_for_and_the_recording_repeats_it() {
    let world = World::new();
    let (table, file) = (world.file("partitions.toml"), world.file("flight.mcap"));
    std::fs::write(&table, format!("{TABLE}{RULES}")).unwrap();
    let (table, file) = (table.to_str().unwrap(), file.to_str().unwrap());
    // Damaged samples early and in the middle of the flight: seconds of wall time apart, as are the
    // second and the end; a partition says once a second what it has dropped.
    let faults = ["--corrupt", "400", "--corrupt", "2700"];
    let flown =
        [&["--partitions", table, "--record", file, "--speed", "8", "--hang-ms", "60000"], &faults[..]].concat();
    let ended = world.run(&flown);
    assert_eq!(ended.code, Some(0), "{ended}");

    let recorded = recording::read_mcap(std::path::Path::new(file)).unwrap();
    let bad = |partition: PartitionId| {
        let is_bad = move |event: &telemetry::Event| {
            event.known_code() == Some(EventCode::BadSamples) && event.partition == partition.code()
        };
        recorded.of(EVENT).map(|(_, event)| *event).filter(is_bad).collect::<Vec<_>>()
    };
    let (slosh, inertial) = (bad(PartitionId::SloshId), bad(PartitionId::InertialId));
    assert!(slosh.len() >= 2 && inertial.len() >= 2, "the faults were injected: {slosh:?} {inertial:?}");
    let ordered: Vec<(Opcode, u16)> = recorded
        .of(TELECOMMAND)
        .map(|(_, command)| (Opcode::from_code(command.opcode).unwrap(), command.partition))
        .collect();
    let pings = (Opcode::Ping, PartitionId::SloshId.code());
    let clears = (Opcode::ClearCounters, PartitionId::ModalId.code());
    assert_eq!(ordered, [pings, clears], "each once, the second behind its second event");
    let executed = |(opcode, partition): (Opcode, u16)| {
        let is_executed = move |event: &&telemetry::Event| {
            event.known_code() == Some(EventCode::CommandExecuted)
                && event.partition == partition
                && event.argument[1] == f64::from(opcode.code())
        };
        recorded.of(EVENT).map(|(_, event)| event).filter(is_executed).count()
    };
    assert_eq!([executed(pings), executed(clears)], [1, 1]);

    // Commands are results; what a rule ordered is repeated like what the ground ordered.
    assert_ne!(ended.digest(), undisturbed().digest);
    let repeated = world.lockstep(&["--commands", file]);
    assert_eq!(repeated.digest(), ended.digest(), "{repeated}");
}
