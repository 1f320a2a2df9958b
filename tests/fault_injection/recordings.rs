//! A recording that fills up leaves sensor samples out and never a result; older recordings go by
//! their number; the run does not notice.

use crate::world::{World, undisturbed};
use telemetry::{ACCELEROMETERS, EVENT, Event, EventCode, IMU, TICK, VERDICT};

const TABLE: &str = include_str!("../../deploy/partitions.toml");
const LIMITS: &str = "[recording]\nsize_mb = 0.4\nleast_first = [[\"imu\"], [\"joints\", \"actuators\"]]\n\
                      [recording.older]\nfiles_max = 1\n";

#[test]
fn a_recording_that_fills_up_keeps_every_result_and_says_what_it_left_out() {
    let world = World::new();
    let (table, file) = (world.file("partitions.toml"), world.file("flight.mcap"));
    std::fs::write(&table, format!("{TABLE}{LIMITS}")).unwrap();
    let arguments = ["--partitions", table.to_str().unwrap(), "--record", file.to_str().unwrap()];
    for round in 0..3 {
        // The last round loses its recorder when topics are left out already.
        let kill: &[&str] = if round == 2 { &["--kill", "recorder@4000"] } else { &[] };
        let ended = world.run(&[&arguments[..], kill].concat());
        assert_eq!((ended.code, ended.digest()), (Some(0), undisturbed().digest.as_str()), "{ended}");
    }
    let recorded = recording::read_mcap(&file).unwrap();
    let whole = &undisturbed().recording;
    assert_eq!(recording::digest(&recorded).unwrap().hex, undisturbed().digest);
    assert_eq!(recorded.of(VERDICT).count(), whole.of(VERDICT).count());
    let (imu, all) = (recorded.of(IMU).count(), whole.of(IMU).count());
    assert!(0 < imu && imu < all, "{imu} of {all}");
    assert!(recorded.of(ACCELEROMETERS).count() > 0 && recorded.of(TICK).count() < whole.of(TICK).count());
    let events = |code: EventCode| -> Vec<Event> {
        recorded.of(EVENT).map(|(_, event)| *event).filter(|event| event.known_code() == Some(code)).collect()
    };
    // The last step leaves events out, too: what was said before is in the file.
    let reduced = events(EventCode::RecordingReduced);
    assert!(!reduced.is_empty() && reduced.is_sorted_by(|a, b| a.argument[0] < b.argument[0]), "{reduced:?}");
    let removed = events(EventCode::RecordingsRemoved);
    assert_eq!((removed.len(), removed[0].argument[0]), (1, 1.0), "of three runs two are kept");
    let size = std::fs::metadata(&file).unwrap().len();
    assert!(size < 2_000_000, "{size} bytes");
    let older = std::fs::read_dir(file.parent().unwrap()).unwrap().flatten();
    let older = older.filter(|entry| entry.file_name().to_string_lossy().starts_with("flight."));
    assert_eq!(older.count(), 2, "this one and one older");
}
