//! Files of other programs through the one door: every format is found by its content, listed, and
//! read as channels.

use recording::{Intake, SeriesSet};
use std::path::PathBuf;

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn read(name: &str, dataset: Option<&str>) -> SeriesSet {
    let intake = Intake { dataset: dataset.map(str::to_owned), clocks_of_their_own: true, ..Intake::default() };
    let set = recording::read_with(&data(name), &intake).and_then(recording::series);
    set.unwrap_or_else(|error| panic!("{name}: {}", error.explain()))
}

/// File, dataset, first channel with its unit, samples and rate [Hz].
const FILES: &[(&str, &str, &str, &str, usize, f64)] = &[
    ("others/json_zstd.mcap", "/rig", "x", "?", 24, 100.0),
    ("others/json_lz4.mcap", "/rig", "x", "?", 24, 100.0),
    ("others/json_unindexed.mcap", "/rig", "x", "?", 24, 100.0),
    ("others/real_json_zstd.mcap", "/imu", "accel_x", "?", 2000, 200.0),
    ("others/ros2_imu.mcap", "/imu/data", "linear_acceleration.x", "m/s^2", 2000, 200.0),
    ("others/ros1.mcap", "/imu/data", "angular_velocity.z", "rad/s", 24, 100.0),
    ("others/cdr_little.mcap", "/imu/data", "angular_velocity.z", "rad/s", 24, 100.0),
    ("others/cdr_big.mcap", "/imu/data", "angular_velocity.z", "rad/s", 24, 100.0),
    ("others/protobuf.mcap", "/state", "force.x", "?", 24, 100.0),
    ("others/ros1_none.bag", "/imu/data", "angular_velocity.z", "rad/s", 24, 100.0),
    ("others/ros1_bz2.bag", "/imu/data", "angular_velocity.z", "rad/s", 24, 100.0),
    ("others/ros1_lz4.bag", "/imu/data", "angular_velocity.z", "rad/s", 24, 100.0),
    ("others/rosbag2", "/imu/data", "angular_velocity.z", "rad/s", 24, 100.0),
    ("others/without_definitions.db3", "/imu/data", "angular_velocity.z", "rad/s", 24, 100.0),
    ("flight.ulg", "sensor_accel_0", "x", "m/s^2", 40, 100.0),
    ("level5.mat", "", "x", "?", 40, 100.0),
    ("big_endian.mat", "", "x", "?", 40, 100.0),
    ("compressed.mat", "", "x", "?", 40, 100.0),
    ("v73.mat", "", "x", "?", 40, 100.0),
    ("groups.h5", "run.imu", "rate", "rad/s", 40, 100.0),
    ("arrays.npz", "", "x", "?", 40, 100.0),
    ("deflated.npz", "", "x", "?", 40, 100.0),
    ("none.parquet", "", "angle", "rad", 39, 100.0),
    ("snappy.parquet", "", "angle", "rad", 39, 100.0),
    ("gzip.parquet", "", "angle", "rad", 39, 100.0),
    ("zstd.parquet", "", "angle", "rad", 39, 100.0),
    ("lz4.parquet", "", "angle", "rad", 39, 100.0),
];

#[test]
fn every_format_is_listed_and_read_with_the_names_units_and_clock_it_states() {
    let mut wrong = Vec::new();
    for (file, dataset, channel, unit, samples, rate_hz) in FILES {
        let set = read(file, Some(dataset).filter(|name| !name.is_empty()).copied());
        let full = if dataset.is_empty() { (*channel).to_owned() } else { format!("{dataset}.{channel}") };
        let Some(found) = set.recording.channel_named(&full) else {
            let names: Vec<&str> = set.recording.channels.iter().map(|of| of.name.as_str()).collect();
            wrong.push(format!("{file}: {names:?}"));
            continue;
        };
        let rate = found.interval_s().map_or(0.0, |interval_s| 1.0 / interval_s);
        if (found.unit.as_str(), found.value.len()) != (*unit, *samples) || (rate / rate_hz - 1.0).abs() > 1e-4 {
            wrong.push(format!("{file}: {} [{}] {} samples at {rate} Hz", found.name, found.unit, found.value.len()));
        }
        let listed = recording::list(&data(file), &Intake::default()).unwrap();
        let of_dataset = listed.iter().find(|of| of.name == *dataset).unwrap_or_else(|| panic!("{file}: {listed:?}"));
        assert!(of_dataset.channels.iter().any(|of| of.name == *channel), "{file}: {of_dataset:?}");
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_channel_is_called_by_dataset_and_name_however_many_datasets_there_are_and_both_names_are_known() {
    for theirs in ["angular_velocity.z", "/imu/data.angular_velocity.z"] {
        for file in ["others/ros2_imu.mcap", "others/ros1.mcap"] {
            let channels = vec![recording::Assignment::parse(&format!("rate = {theirs}")).unwrap()];
            let intake = Intake { channels, clocks_of_their_own: true, ..Intake::default() };
            let set = recording::read_with(&data(file), &intake).and_then(recording::series).unwrap();
            let names: Vec<&str> = set.recording.channels.iter().map(|of| of.name.as_str()).collect();
            assert!(names.contains(&"rate") && names.contains(&"/imu/data.angular_velocity.x"), "{file}: {names:?}");
        }
    }
}

#[test]
fn rows_without_a_clock_are_read_at_the_rate_that_is_said() {
    let said = recording::TimeColumn::parse("row:100Hz").unwrap();
    let path = data("matrix.npy");
    assert!(recording::read(&path).unwrap_err().explain().contains("--time-column row:100Hz"));
    let intake = Intake { time_column: Some(said), ..Intake::default() };
    let set = recording::read_with(&path, &intake).and_then(recording::series).unwrap();
    assert!((set.recording.channels[0].interval_s().unwrap() - 0.01).abs() < 1e-12);
}

#[test]
fn a_dataset_that_is_not_there_is_answered_with_those_that_are() {
    let intake = Intake { dataset: Some("imu/dat".into()), ..Intake::default() };
    let error = recording::read_with(&data("others/ros2_imu.mcap"), &intake).unwrap_err().explain();
    assert!(error.contains("no dataset is called `imu/dat`") && error.contains("did you mean `/imu/data`?"), "{error}");
}

#[test]
fn a_dataset_is_chosen_by_its_name_whatever_its_case() {
    let set = read("others/ros2_imu.mcap", Some("IMU/data"));
    assert!(set.recording.channel_named("/imu/data.linear_acceleration.x").is_some());
}
