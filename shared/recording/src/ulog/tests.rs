use super::*;
use crate::damage::{data, every_damage_is_read_or_refused};

fn all(name: &str) -> Vec<RawDataset> {
    datasets(&data(name), &|_| true).unwrap()
}

fn names(datasets: &[RawDataset]) -> Vec<(&str, usize)> {
    datasets.iter().map(|dataset| (dataset.name.as_str(), dataset.rows())).collect()
}

#[test]
fn every_topic_and_instance_is_a_dataset_with_its_times() {
    let found = all("flight.ulg");
    assert_eq!(names(&found), [("sensor_accel_0", 40), ("sensor_accel_1", 40), ("esc_status", 10)]);
    for dataset in &found {
        assert_eq!(dataset.axis, Axis::Time(0));
        assert_eq!(dataset.columns[0].unit.as_deref(), Some("us"));
        assert_eq!(dataset.columns[0].values[0], 1_000_000.0);
    }
    let accel = &found[1].columns;
    let names: Vec<_> = accel.iter().map(|column| column.name.as_str()).collect();
    assert_eq!(
        names,
        ["timestamp", "timestamp_sample", "x", "y", "z", "clip_counter[0]", "clip_counter[1]", "clip_counter[2]"]
    );
    assert_eq!(accel[2].unit.as_deref(), Some("m/s^2"));
    assert_eq!(accel[4].values[7], f64::from(9.81f32));
    assert_eq!(accel[5].values[7], 7.0);
    for k in 0..40 {
        let x = 1.0 + (2.0 * std::f64::consts::PI * k as f64 * 0.01).sin();
        assert!((accel[2].values[k] - x).abs() < 1e-6);
        assert_eq!(accel[0].values[k] - accel[1].values[k], 50.0);
    }
}

#[test]
fn messages_in_messages_are_flattened_and_texts_are_named() {
    let found = all("flight.ulg");
    let esc = &found[2];
    let names: Vec<_> = esc.columns.iter().map(|column| column.name.as_str()).collect();
    assert_eq!(names, ["timestamp", "esc[0].rpm", "esc[0].current", "esc[1].rpm", "esc[1].current", "armed"]);
    assert_eq!(esc.columns[2].values[9], -36.0);
    assert_eq!(esc.columns[5].values[..4], [0.0, 0.0, 0.0, 1.0]);
    assert_eq!(esc.columns[1].unit, None);
    assert!(esc.notes.contains(&"left out: `name` (text)".to_string()), "{:?}", esc.notes);
}

#[test]
fn dropouts_are_counted_in_the_notes() {
    let found = all("flight.ulg");
    assert!(found[0].notes[0].contains("dropped out 1 time(s), 0.25 s in all"), "{:?}", found[0].notes);
}

#[test]
fn a_log_that_is_cut_keeps_what_is_whole_and_says_so() {
    let whole = std::fs::read(data("flight.ulg")).unwrap();
    let found = datasets_of("file", &whole[..whole.len() - 200], &|_| true).unwrap();
    assert_eq!(found[0].columns[2].values[..36], all("flight.ulg")[0].columns[2].values[..36]);
    assert!(found[0].notes[1].contains("cut or damaged"), "{:?}", found[0].notes);
}

#[test]
fn reading_goes_on_behind_damage_at_the_next_mark() {
    let found = all("damaged.ulg");
    let rows: Vec<f64> = found[0].columns[0].values.clone();
    assert_eq!(rows[20], 1_200_000.0);
    assert_eq!(rows[21], 1_300_000.0, "from the mark behind the damage");
    assert!(found[0].notes[1].contains("at 1 more place(s)"), "{:?}", found[0].notes);
}

#[test]
fn data_that_were_appended_are_read_behind_a_cut_message() {
    let found = all("appended.ulg");
    let esc = &found[2];
    assert_eq!(esc.columns[0].values, [1_000_000.0, 1_040_000.0, 1_080_000.0, 9_000_000.0]);
    assert_eq!(esc.columns[4].values[3], 4.0);
}

#[test]
fn only_the_wanted_topics_are_read() {
    let found = datasets(&data("flight.ulg"), &|name| name == "esc_status").unwrap();
    assert_eq!(names(&found), [("esc_status", 10)]);
}

#[test]
fn flags_that_are_not_known_are_refused() {
    let mut log = std::fs::read(data("flight.ulg")).unwrap();
    log[16 + 3 + 8] = 2;
    let error = datasets_of("file", &log, &|_| true).unwrap_err().explain();
    assert!(error.contains("the flags [02, 00") && error.contains("cure: "), "{error}");
}

#[test]
fn damaged_files_never_panic() {
    for name in ["flight.ulg", "appended.ulg"] {
        every_damage_is_read_or_refused(name, |bytes| datasets_of("file", bytes, &|_| true));
    }
}
