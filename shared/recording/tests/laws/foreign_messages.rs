//! Recordings of other programs give the numbers their messages hold, with names, units and times.
//!
//! `tests/data/README.md` says how the files were made: sample k of 24 is at 1 700 000 000 s + k /
//! 100, x = k / 8, y = -k / 4, logged 2 ms late.

use recording::foreign::{bag_datasets, is_own_mcap, mcap_datasets, rosbag2_datasets};
use recording::{Axis, RawDataset, RecordingError};
use std::path::{Path, PathBuf};

pub const START_S: f64 = 1.7e9;
pub const MCAP_FILES: [&str; 7] = [
    "ros1.mcap",
    "cdr_little.mcap",
    "cdr_big.mcap",
    "json_unindexed.mcap",
    "json_lz4.mcap",
    "json_zstd.mcap",
    "protobuf.mcap",
];
pub const BAGS: [&str; 3] = ["ros1_none.bag", "ros1_bz2.bag", "ros1_lz4.bag"];
pub const DATABASES: [&str; 2] = ["rosbag2/rosbag2_0.db3", "without_definitions.db3"];
const COUNT: usize = 24;

pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/others").join(name)
}

pub fn datasets(path: &Path) -> Result<Vec<RawDataset>, RecordingError> {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("mcap") => mcap_datasets(path, &|_| true),
        Some("bag") => bag_datasets(path, &|_| true),
        _ => rosbag2_datasets(path, &|_| true),
    }
}

pub fn named<'d>(datasets: &'d [RawDataset], name: &str) -> &'d RawDataset {
    datasets.iter().find(|dataset| dataset.name == name).unwrap_or_else(|| panic!("no dataset `{name}`"))
}

fn values<'d>(dataset: &'d RawDataset, name: &str) -> &'d [f64] {
    let column = dataset.columns.iter().find(|column| column.name == name);
    &column.unwrap_or_else(|| panic!("no column `{name}` in {:?}", names(dataset))).values
}

fn unit<'d>(dataset: &'d RawDataset, name: &str) -> Option<&'d str> {
    dataset.columns.iter().find(|column| column.name == name).and_then(|column| column.unit.as_deref())
}

fn names(dataset: &RawDataset) -> Vec<&str> {
    dataset.columns.iter().map(|column| column.name.as_str()).collect()
}

fn samples(of: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..COUNT).map(|k| of(k as f64)).collect()
}

fn assert_times(dataset: &RawDataset, name: &str, late_s: f64) {
    assert_eq!(dataset.axis, Axis::Time(0), "{}", dataset.name);
    assert_eq!(dataset.columns[0].name, name);
    assert_eq!(dataset.columns[0].unit.as_deref(), Some("s"));
    // One rounding of the whole time, none before.
    let late_ms = (late_s * 1e3) as u32;
    let expected = samples(|k| START_S + (k * 10.0 + f64::from(late_ms)) / 1e3);
    assert_eq!(dataset.columns[0].values, expected, "{}", dataset.name);
}

/// The four topics that every file of ROS messages holds.
fn assert_ros(file: &str) {
    let found = datasets(&data(file)).unwrap_or_else(|error| panic!("{file}: {}", error.explain()));
    let topics: Vec<&str> = found.iter().map(|dataset| dataset.name.as_str()).collect();
    assert_eq!(topics, ["/imu/data", "/joint_states", "/load", "/text"], "{file}");

    let imu = named(&found, "/imu/data");
    assert_times(imu, "header.stamp", 0.0);
    assert_eq!(values(imu, "linear_acceleration.x"), samples(|k| k / 8.0), "{file}");
    assert_eq!(values(imu, "linear_acceleration.z"), samples(|_| 9.5), "{file}");
    assert_eq!(values(imu, "angular_velocity.z"), samples(|k| -k / 4.0), "{file}");
    assert_eq!(unit(imu, "linear_acceleration.y"), Some("m/s^2"));
    assert_eq!(unit(imu, "angular_velocity.x"), Some("rad/s"));
    assert_eq!(unit(imu, "orientation.w"), Some("-"));
    assert_eq!(unit(imu, "orientation_covariance[8]"), None);
    assert_eq!(imu.columns.len(), 1 + 4 + 3 + 3 + 27);
    assert!(imu.notes.is_empty(), "{file}: {:?}", imu.notes);

    let joints = named(&found, "/joint_states");
    let expected = ["header.stamp", "position.hip", "position.knee", "velocity.hip", "velocity.knee"];
    assert_eq!(names(joints), expected, "{file}");
    assert_eq!(values(joints, "position.knee"), samples(|k| -k / 4.0), "{file}");
    assert_eq!(unit(joints, "position.hip"), None);

    let load = named(&found, "/load");
    assert_times(load, "log_time", 0.002);
    assert_eq!(values(load, "data"), samples(|k| k / 8.0), "{file}");

    let text = named(&found, "/text");
    assert_eq!((names(text), text.rows()), (vec!["log_time"], 2), "{file}");
    assert_eq!(text.notes, ["left out: 1 text field(s) (`data`)"]);
}

#[test]
fn ros_1_messages_in_mcap_give_their_fields() {
    assert_ros("ros1.mcap");
}

#[test]
fn ros_2_messages_in_mcap_are_read_in_both_byte_orders() {
    assert_ros("cdr_little.mcap");
    assert_ros("cdr_big.mcap");
}

#[test]
fn bags_give_the_same_whatever_compresses_their_chunks() {
    BAGS.into_iter().for_each(assert_ros);
}

#[test]
fn rosbag2_databases_are_read_with_and_without_definitions_and_as_a_folder() {
    DATABASES.into_iter().for_each(assert_ros);
    assert_ros("rosbag2");
}

#[test]
fn json_messages_give_numbers_of_nested_objects_whatever_the_container_does() {
    for file in ["json_unindexed.mcap", "json_lz4.mcap", "json_zstd.mcap"] {
        let found = datasets(&data(file)).unwrap();
        let rig = named(&found, "/rig");
        assert_times(rig, "log_time", 0.0);
        assert_eq!(names(rig), ["log_time", "x", "inner.y", "inner.on", "pair[0]", "pair[1]"], "{file}");
        assert_eq!(values(rig, "inner.y"), samples(|k| -k / 4.0));
        assert_eq!(values(rig, "inner.on"), samples(|k| f64::from(k % 2.0 == 0.0)));
        assert_eq!(values(rig, "pair[1]"), samples(|k| 2.0 * k));
        assert_eq!(rig.notes, ["left out: 1 text field(s) (`inner.name`); 1 array(s) of varying length (`ragged`)"]);
    }
}

#[test]
fn protobuf_messages_give_zeros_for_numbers_they_leave_out() {
    let found = datasets(&data("protobuf.mcap")).unwrap();
    let state = named(&found, "/state");
    assert_times(state, "timestamp", 0.0);
    let expected = ["timestamp", "force.x", "force.y", "force.z", "count", "gain", "on", "pair[0]", "pair[1]", "big"];
    assert_eq!(names(state), expected);
    assert_eq!(values(state, "force.x"), samples(|k| k / 8.0));
    assert_eq!(values(state, "force.z"), samples(|_| 0.0));
    assert_eq!(values(state, "count"), samples(|k| -k));
    assert_eq!(values(state, "on"), samples(|k| f64::from(k % 2.0 == 0.0)));
    assert_eq!(values(state, "pair[1]"), samples(|k| -k));
    assert_eq!(values(state, "big"), samples(|k| k));
    assert_eq!(state.notes, ["left out: 1 text field(s) (`name`); 1 field(s) of bytes (`picture`)"]);
}

#[test]
fn protobuf_numbers_of_every_encoding_are_read_and_what_is_absent_has_no_value() {
    let found = datasets(&data("protobuf.mcap")).unwrap();
    let extra = named(&found, "/extra");
    assert_times(extra, "log_time", 0.0);
    for (name, of) in [("fixed", -1.0), ("zigzag", -1.0), ("signed", -1.0), ("large", 1.0), ("again.fixed", 1.0)] {
        assert_eq!(values(extra, name), samples(|k| of * k), "{name}");
    }
    assert_eq!(values(extra, "steps[0]"), samples(|k| -k));
    assert_eq!(values(extra, "points[0].x"), samples(|k| k / 8.0));
    assert_eq!(values(extra, "points[1].y"), samples(|k| -k / 4.0));
    assert_eq!(values(extra, "mode"), samples(|k| k % 2.0));
    assert_eq!(values(extra, "took"), samples(|_| -1.5));
    assert_eq!(unit(extra, "took"), Some("s"));
    for (k, value) in values(extra, "maybe").iter().enumerate() {
        assert!(if k % 2 == 0 { *value == k as f64 / 8.0 } else { value.is_nan() }, "{k}: {value}");
    }
    assert!(!names(extra).iter().any(|name| name.starts_with("absent")), "{:?}", names(extra));
    assert_eq!(extra.notes, ["left out: 1 map(s) (`table`)"]);
}

#[test]
fn recordings_of_ten_seconds_give_every_sample_at_its_time() {
    for (file, topic, names) in [
        ("ros2_imu.mcap", "/imu/data", ["linear_acceleration.x", "angular_velocity.z"]),
        ("real_json_zstd.mcap", "/imu", ["accel_x", "gyro_z"]),
    ] {
        let found = datasets(&data(file)).unwrap();
        let imu = named(&found, topic);
        assert_eq!((found.len(), imu.rows()), (1, 2000));
        for (k, time_s) in imu.columns[0].values.iter().enumerate() {
            assert_eq!(*time_s, START_S + k as f64 * 5.0 / 1e3);
            let phase = core::f64::consts::TAU * 3.0 * k as f64 / 200.0;
            // The file in ROS 2 has the sine in the acceleration, as the other one.
            assert!((values(imu, names[0])[k] - phase.sin()).abs() < 1e-9, "{file}: row {k}");
            assert!((values(imu, names[1])[k] - phase.cos()).abs() < 1e-9, "{file}: row {k}");
        }
    }
}

#[test]
fn only_the_topics_that_are_wanted_are_given() {
    for file in MCAP_FILES.iter().chain(&BAGS).chain(&DATABASES) {
        let path = data(file);
        let load = |name: &str| name == "/load";
        let found = match path.extension().and_then(|extension| extension.to_str()) {
            Some("mcap") => mcap_datasets(&path, &load),
            Some("bag") => bag_datasets(&path, &load),
            _ => rosbag2_datasets(&path, &load),
        };
        assert!(found.unwrap().iter().all(|dataset| dataset.name == "/load"), "{file}");
    }
}

#[test]
fn a_file_that_another_program_wrote_is_not_our_own() {
    for file in MCAP_FILES {
        assert!(!is_own_mcap(&data(file)).unwrap(), "{file}");
    }
}

#[test]
fn a_run_and_its_copy_by_another_program_are_our_own() {
    let path = crate::scratch("own.mcap");
    recording::write_mcap(&crate::samples::everything(3), &path).unwrap();
    assert!(is_own_mcap(&path).unwrap());
    let bytes = std::fs::read(&path).unwrap();
    let at = bytes.windows(6).position(|window| window == b"obsid ").unwrap();
    let mut copied = bytes;
    copied[at..at + 6].copy_from_slice(b"other ");
    std::fs::write(&path, copied).unwrap();
    assert!(is_own_mcap(&path).unwrap());
}
