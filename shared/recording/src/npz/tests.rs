use super::*;
use crate::damage::{data, every_damage_is_read_or_refused};
use crate::dataset::Axis;

fn all(name: &str) -> Vec<RawDataset> {
    datasets(&data(name), &|_| true).unwrap()
}

fn columns(dataset: &RawDataset) -> Vec<&str> {
    dataset.columns.iter().map(|column| column.name.as_str()).collect()
}

#[test]
fn arrays_of_one_length_are_a_dataset_and_a_structured_array_is_one_of_its_own() {
    let found = all("arrays.npz");
    let names: Vec<_> = found.iter().map(|dataset| (dataset.name.as_str(), columns(dataset))).collect();
    assert_eq!(
        names,
        [
            ("", vec!["t", "x", "m[0]", "m[1]", "m[2]", "n", "on"]),
            ("length_7", vec!["other"]),
            ("table", vec!["t", "x", "m[0]", "m[1]", "m[2]"])
        ]
    );
    assert_eq!(found[0].notes, ["left out: `objects` (Python objects), `words` (text), `Fs` (one number)"]);
}

#[test]
fn numbers_of_every_type_and_order_are_read() {
    let found = all("arrays.npz");
    let columns = &found[0].columns;
    for k in 0..40 {
        let t = k as f64 * 0.01;
        let x = (2.0 * std::f64::consts::PI * t).sin();
        assert_eq!(columns[0].values[k], t);
        assert!((columns[1].values[k] - x).abs() < 1e-7);
        assert!((columns[2].values[k] - x).abs() < 1e-12, "the first column of a matrix in Fortran order");
        assert_eq!(columns[5].values[k], (100.0 * columns[2].values[k]).trunc());
        assert_eq!(columns[6].values[k], f64::from(u8::from(columns[2].values[k] > 0.0)));
        assert_eq!(found[2].columns[2].values[k], columns[2].values[k]);
    }
}

#[test]
fn dates_are_the_times_in_seconds_and_deflated_entries_are_read() {
    let found = all("deflated.npz");
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].axis, Axis::Time(1));
    let times = &found[0].columns[1];
    assert_eq!((times.name.as_str(), times.unit.as_deref()), ("when", Some("s")));
    assert_eq!(times.values[0], 1_767_323_045.5);
    assert_eq!(times.values[39], 1_767_323_045.89);
}

#[test]
fn an_array_alone_is_a_dataset_without_a_name() {
    let found = all("matrix.npy");
    assert_eq!((found[0].name.as_str(), columns(&found[0])), ("", vec!["array[0]", "array[1]", "array[2]"]));
    assert_eq!(found[0].rows(), 40);
}

#[test]
fn a_length_that_the_file_cannot_have_is_an_error() {
    let mut bytes = std::fs::read(data("matrix.npy")).unwrap();
    let at = bytes.windows(2).position(|two| two == b"40").unwrap();
    bytes[at] = b'9';
    let error = datasets_of("file", &bytes, &|_| true).unwrap_err().explain();
    assert!(error.contains("the array needs 2160 bytes, 960 are there"), "{error}");
}

#[test]
fn an_entry_that_states_an_absurd_size_is_not_expanded() {
    let mut bytes = std::fs::read(data("deflated.npz")).unwrap();
    let at = bytes.windows(4).position(|four| four == b"PK\x01\x02").unwrap();
    bytes[at + 24..at + 28].copy_from_slice(&0x7fff_ffffu32.to_le_bytes());
    let error = datasets_of("file", &bytes, &|_| true).unwrap_err().explain();
    assert!(error.contains("the entry states 2147483647 bytes, absurd"), "{error}");
}

#[test]
fn damaged_files_never_panic() {
    for name in ["arrays.npz", "deflated.npz", "matrix.npy"] {
        every_damage_is_read_or_refused(name, |bytes| datasets_of("file", bytes, &|_| true));
    }
}
