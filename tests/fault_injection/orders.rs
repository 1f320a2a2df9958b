//! Commands, tables and events of a run as processes: what is ordered in flight is in the
//! recording, and a run in one thread that is given the recording's commands repeats it.

use crate::process::Process;
use crate::world::{Run, World, undisturbed};
use rustix::process::Signal;
use serde_json::Value;

/// A busy computer answers late.
const PATIENCE: [&str; 2] = ["--timeout", "60"];

/// A command, which must be executed; its answer.
fn obsid(world: &World, arguments: &[&str]) -> Value {
    let output = world.obsid(&[arguments, &PATIENCE, &["--json"]].concat());
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{arguments:?}: {} {}", text(&output.stdout), text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn events(world: &World) -> Vec<Value> {
    let output = world.obsid(&["events", "--once", "--json"]);
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    told["events"].as_array().unwrap().clone()
}

fn named<'a>(events: &'a [Value], text: &str) -> Vec<&'a Value> {
    events.iter().filter(|event| event["event"] == text).collect()
}

fn guards(world: &World, line: &str) -> String {
    let file = world.file("guards.toml");
    let head = "format = 1\npartition = \"supervisor\"\ntable = \"guards\"\nversion = 4\n[values]\n";
    std::fs::write(&file, format!("{head}{line}\n")).unwrap();
    file.display().to_string()
}

/// Kills the supervisor and waits for its next life.
fn restart_supervisor(run: &mut Run<'_>) {
    let first: Process = run.process("supervisor");
    let pid = first.pid;
    first.signal(Signal::KILL);
    run.wait_until("another supervisor", |run| (run.process("supervisor").pid != pid).then_some(()));
}

#[test]
fn a_run_commanded_in_flight_while_its_supervisor_dies_is_repeated_by_its_recording() {
    let world = World::new();
    let (file, store) = (world.file("flight.mcap"), world.file("store"));
    std::fs::create_dir(&store).unwrap();
    let (file, store) = (file.to_str().unwrap(), store.to_str().unwrap());
    let mut run = world.start(&["--record", file, "--keep", store, "--speed", "4", "--hang-ms", "60000"]);
    run.wait_for_housekeeping();
    let table = guards(&world, "safe_dwell_frames = 800");
    assert_eq!(obsid(&world, &["command", "ping", "all"])["state"], "executed");
    obsid(&world, &["tables", "load", &table]);
    restart_supervisor(&mut run);
    obsid(&world, &["tables", "activate", &table]);
    obsid(&world, &["command", "ping", "slosh-id", "--key", "77"]);
    obsid(&world, &["command", "ping", "slosh-id", "--key", "77"]);
    let told = events(&world);
    let dumped = obsid(&world, &["tables", "dump", "supervisor", "guards"])["tables"].clone();
    let bad = world.obsid(&["tables", "load", &guards(&world, "safe_dwell_frames = -1")]);
    let unknown = world.obsid(&["command", "ping", "diagnosis", "--timeout", "60"]);
    let ended = run.end();
    assert_eq!(ended.code, Some(0), "{ended}");

    // What was ordered is known, once.
    assert_eq!(dumped[0]["active"]["values"]["safe_dwell_frames"], 800.0);
    assert!(dumped[0]["active"]["version"] == 4 && dumped[0]["default"] == false, "{dumped}");
    let of_key = |event: &&&Value| event["arguments"]["key"] == 77.0 && event["partition"] == "slosh-id";
    assert_eq!(named(&told, "command executed").iter().filter(of_key).count(), 1, "{told:?}");
    assert_eq!(named(&told, "table activated").len(), 1, "{told:?}");
    let restarts = named(&told, "started").iter().filter(|event| event["arguments"]["restarts"] == 1.0).count();
    assert_eq!(restarts, 1, "{told:?}");
    // What is not valid is refused with the reason, before or at the port.
    let text = String::from_utf8_lossy(&bad.stderr).into_owned();
    assert!(bad.status.code() == Some(3) && text.contains("safe_dwell_frames = -1"), "{text}");
    let text = String::from_utf8_lossy(&unknown.stderr).into_owned();
    assert!(unknown.status.code() == Some(1) && text.contains("no such partition in this run"), "{text}");

    // The recording repeats the run, and the store has what the next run begins with.
    let commands = recording::read_mcap(std::path::Path::new(file)).unwrap();
    let commands: Vec<u64> = commands.of(telemetry::TELECOMMAND).map(|(_, command)| command.key).collect();
    assert!(commands.len() >= 4, "{commands:?}");
    assert_ne!(ended.digest(), undisturbed().digest, "commands are results");
    let repeated = world.lockstep(&["--commands", file]);
    assert_eq!(repeated.digest(), ended.digest(), "{repeated}");
    let kept = obsid(&world, &["tables", "dump", "--store", store])["tables"].clone();
    assert_eq!(kept[0]["active"], dumped[0]["active"]);
}

#[test]
fn a_stored_sequence_gives_one_digest_as_processes_and_in_one_thread() {
    let world = World::new();
    let file = world.file("sequence.toml");
    let text = "format = 1\n\
                [[command]]\nframe = 300\norder = \"ping\"\nto = \"all\"\n\
                [[command]]\nframe = 1200\norder = \"allow-capture\"\n\
                [[command]]\nframe = 1200\norder = \"ping\"\nto = \"modal-id\"\n";
    std::fs::write(&file, text).unwrap();
    let arguments = ["--commands", file.to_str().unwrap()];
    let (processes, thread) = (world.run(&arguments), world.lockstep(&arguments));
    assert_eq!(processes.code, Some(0), "{processes}");
    assert_eq!(processes.digest(), thread.digest());
    assert_ne!(processes.digest(), undisturbed().digest);
}

/// A hundred a frame: ten thousand a second of flight.
#[test]
fn a_flood_of_events_changes_no_result_and_every_event_is_sent_or_counted() {
    let world = World::new();
    let file = world.file("flight.mcap");
    // Two windows of a second at least.
    let ended = world.run(&["--flood", "slosh-id@100", "--speed", "15", "--record", file.to_str().unwrap()]);
    assert_eq!(ended.code, Some(0), "{ended}");
    assert_eq!(ended.digest(), undisturbed().digest);
    let recorded = recording::read_mcap(&file).unwrap();
    let flood = telemetry::EventCode::SamplesLost.code();
    let slosh = telemetry::PartitionId::SloshId.code();
    let of_flood = |event: &&telemetry::Event| event.code == flood && event.partition == slosh;
    let sent: Vec<_> = recorded.of(telemetry::EVENT).map(|(_, event)| event).filter(of_flood).collect();
    let mut before = 0;
    for (k, event) in sent.iter().enumerate() {
        // Event `argument[1]` of the hundred of its frame: what was not sent before it is counted.
        before += event.squelched;
        assert_eq!(k as u64 + before, 100 * event.frame + event.argument[1] as u64, "{event:?}");
    }
    assert!(before > 100 * sent.len() as u64, "{before} counted, {} sent", sent.len());
}
