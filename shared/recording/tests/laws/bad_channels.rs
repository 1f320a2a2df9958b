//! Channels that a file cannot hold are rejected before it is touched; files of channels that are
//! not believed.

use crate::samples::everything;
use crate::scratch;
use channels::{Channel, Recording};
use recording::{Imported, McapRecorder, read, read_mcap, write_series};
use std::collections::BTreeMap;

fn one(name: &str, unit: &str, time_s: &[f64], values: &[f64]) -> Recording {
    let channel = Channel::new(name, unit, time_s.to_vec(), values.to_vec());
    Recording { name: "memory".into(), channels: vec![channel] }
}

fn good() -> Recording {
    one("x", "m", &[0.0, 1.0], &[1.0, 2.0])
}

#[test]
fn what_would_not_read_back_is_refused_and_the_old_file_stays() {
    let two = Recording { channels: [good().channels, good().channels].concat(), ..good() };
    let cases = [
        (one("", "m", &[0.0, 1.0], &[1.0, 2.0]), "the name is empty"),
        (one(" x", "m", &[0.0, 1.0], &[1.0, 2.0]), "blank"),
        (one("x\"y", "m", &[0.0, 1.0], &[1.0, 2.0]), "quote"),
        (one("x\ny", "m", &[0.0, 1.0], &[1.0, 2.0]), "control character"),
        (one("time", "m", &[0.0, 1.0], &[1.0, 2.0]), "time column"),
        (one("x", "deg", &[0.0, 1.0], &[1.0, 2.0]), "`deg` is not an SI unit"),
        (one("x", "m", &[0.0, 1.0], &[1.0]), "2 times and 1 values"),
        (one("x", "m", &[0.0, 1.0], &[1.0, f64::NAN]), "sample 2 is NaN at 1 s"),
        (one("x", "m", &[0.0, f64::INFINITY], &[1.0, 2.0]), "not finite"),
        (one("x", "m", &[0.0, 1.0, 1.0], &[1.0, 2.0, 3.0]), "sample 3: time 1 s is followed by 1 s"),
        (two, "stands twice"),
    ];
    for name in ["keep.csv", "keep.csv.gz", "keep.mcap"] {
        let path = scratch(name);
        write_series(&good(), &path).unwrap();
        let before = std::fs::read(&path).unwrap();
        for (bad, says) in &cases {
            let error = write_series(bad, &path).unwrap_err().explain();
            assert!(error.contains(says) && error.contains("channel `") && error.contains("cure: "), "{error}");
        }
        assert_eq!(std::fs::read(&path).unwrap(), before);
    }
    let error = write_series(&good(), &scratch("keep.txt")).unwrap_err().explain();
    assert!(error.contains("keep.txt") && error.contains(".mcap, .csv or .csv.gz"), "{error}");
    let error = write_series(&one("x", "m", &[0.0], &[1.0]), &scratch("keep.csv")).unwrap_err().explain();
    assert!(error.contains("at least two"), "{error}");
}

#[test]
fn times_that_mcap_cannot_tell_apart_are_refused() {
    let path = scratch("times.mcap");
    for (bad, says) in [
        (one("x", "m", &[-1.0, 0.0], &[1.0, 2.0]), "time -1 s is outside"),
        (one("x", "m", &[1e11, 1e11 + 1.0], &[1.0, 2.0]), "outside of 0 s to"),
        (one("x", "m", &[0.0, 1e-10], &[1.0, 2.0]), "are the same nanosecond"),
    ] {
        let error = write_series(&bad, &path).unwrap_err().explain();
        assert!(error.contains("times.mcap: channel `x`") && error.contains(says) && error.contains(".csv"), "{error}");
        assert!(!path.exists());
        let csv = scratch("times.csv");
        write_series(&bad, &csv).unwrap();
        assert_eq!(recording::series(read(&csv).unwrap()).unwrap().recording.channels, bad.channels);
    }
}

/// An MCAP of one scalar channel by another hand.
fn foreign(path: &std::path::Path, name: &str, unit: Option<&str>, samples: &[(u64, f64)]) {
    let mut writer = mcap::Writer::new(std::fs::File::create(path).unwrap()).unwrap();
    let schema = writer.add_schema("obsid_msgs/Scalar", "ros1msg", b"float64 value").unwrap();
    let facts = unit.iter().map(|unit| ("unit".to_string(), unit.to_string())).collect::<BTreeMap<_, _>>();
    let channel_id = writer.add_channel(schema, name, "ros1", &facts).unwrap();
    for (time, value) in samples {
        let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time: *time, publish_time: *time };
        writer.write_to_known_channel(&header, &value.to_le_bytes()).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn scalar_channels_of_another_hand_are_read_in_si_or_refused_with_the_channel() {
    let path = scratch("hand.mcap");
    foreign(&path, "/angle", Some("deg"), &[(0, 180.0), (5, 90.0)]);
    let Imported::Series(set) = read(&path).unwrap() else { panic!("channels") };
    let angle = &set.recording.channels[0];
    assert_eq!(angle.value, [core::f64::consts::PI, core::f64::consts::FRAC_PI_2]);
    assert_eq!((angle.unit.as_str(), set.unit_in_file(angle)), ("rad", "deg"));
    assert_eq!(angle.time_s, [0.0, 5e-9]);
    let refused = |name: &str, unit: Option<&str>, samples: &[(u64, f64)], says: &str| {
        foreign(&path, name, unit, samples);
        let error = read(&path).unwrap_err().explain();
        assert!(error.contains("hand.mcap: channel `") && error.contains(says) && error.contains("cure: "), "{error}");
    };
    refused("/a", None, &[(0, 1.0)], "unit `` is not known");
    refused("/a", Some("furlong"), &[(0, 1.0)], "unit `furlong` is not known");
    refused("/a", Some("m"), &[(0, f64::NAN)], "not finite");
    refused("/a", Some("m"), &[(5, 1.0), (0, 1.0)], "sample 2: time 0.000000005 s is followed by 0 s");
    refused("/", Some("m"), &[(0, 1.0)], "the name is empty");
}

#[test]
fn a_recording_of_channels_is_no_run() {
    let path = scratch("norun.mcap");
    write_series(&good(), &path).unwrap();
    let before = std::fs::read(&path).unwrap();
    for error in [read_mcap(&path).map(drop), McapRecorder::recover(&path, |_, _, _| true).map(drop)] {
        let error = error.unwrap_err().explain();
        assert!(error.contains("norun.mcap: channel `/x`") && error.contains("not a topic of a run"), "{error}");
    }
    assert_eq!(std::fs::read(&path).unwrap(), before);
    assert!(!scratch("norun.mcap.recovering").exists());
    for format in recording::FORMATS {
        let imported = Imported::Run(everything(1));
        let written = format.write(&imported, &scratch("run.any"));
        assert_eq!(written.is_ok(), format.name() == "mcap");
    }
}
