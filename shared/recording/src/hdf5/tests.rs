use super::*;
use crate::damage::{data, every_damage_is_read_or_refused};
use crate::dataset::Axis;

#[test]
fn groups_and_tables_become_datasets_with_units_from_the_attributes() {
    let found = datasets(&data("groups.h5"), &|_| true).unwrap();
    let names: Vec<_> = found.iter().map(|dataset| dataset.name.as_str()).collect();
    assert_eq!(names, ["table", "run.imu"]);
    let of = |column: &crate::dataset::RawColumn| (column.name.clone(), column.unit.clone().unwrap_or_default());
    let columns: Vec<_> = found[1].columns.iter().map(of).collect();
    let expected = [("accel[0]", "m/s^2"), ("accel[1]", "m/s^2"), ("accel[2]", "m/s^2"), ("rate", "rad/s"), ("on", "")];
    assert_eq!(columns, expected.map(|(name, unit)| (name.to_string(), unit.to_string())));
    for k in 0..40 {
        let x = (2.0 * std::f64::consts::PI * k as f64 * 0.01).sin();
        assert!((found[1].columns[0].values[k] - x).abs() < 1e-12);
        assert!((found[1].columns[3].values[k] - x).abs() < 1e-7);
        assert_eq!(found[0].columns[0].values[k], k as f64 * 0.01);
        assert_eq!(found[0].columns[1].values[k], found[1].columns[3].values[k]);
    }
}

#[test]
fn an_attribute_states_the_rate_and_what_is_not_read_is_named() {
    let found = datasets(&data("groups.h5"), &|_| true).unwrap();
    assert_eq!(found[1].axis, Axis::Uniform { start_s: 0.0, interval_s: 0.01 });
    assert!(found[1].notes[0].contains("`run.imu.sample_rate`"), "{:?}", found[1].notes);
    assert!(found[1].notes[1].contains("`run.imu.label` (text)"), "{:?}", found[1].notes);
    assert!(found[0].notes[0].contains("`impedance` (complex"), "{:?}", found[0].notes);
}

#[test]
fn a_length_that_is_absurd_is_not_read() {
    let error = datasets(&data("absurd.h5"), &|_| true).unwrap_err().explain();
    assert!(error.contains("array `x`: it states 8796093022208 bytes, absurd"), "{error}");
}

#[test]
fn texts_that_are_more_than_the_file_are_one_text_often_and_not_read() {
    let found = datasets(&data("one_text_often.h5"), &|_| true).unwrap();
    let names: Vec<&str> = found[0].columns.iter().map(|column| column.name.as_str()).collect();
    assert_eq!((names, found[0].columns[0].values.len()), (vec!["t", "w"], 60));
    assert!(found[0].notes.iter().any(|note| note.contains("`label` (text or lists)")), "{:?}", found[0].notes);
}

#[test]
fn damaged_files_never_panic() {
    for name in ["groups.h5", "v73.mat"] {
        every_damage_is_read_or_refused(name, |bytes| datasets_of("file", bytes.to_vec(), &|_| true));
    }
}
