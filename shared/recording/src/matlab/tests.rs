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
fn vectors_matrices_and_structures_become_datasets() {
    let found = all("level5.mat");
    let names: Vec<_> = found.iter().map(|dataset| (dataset.name.as_str(), columns(dataset))).collect();
    assert_eq!(
        names,
        [
            ("", vec!["t", "x", "m[0]", "m[1]", "m[2]", "n", "on"]),
            ("length_7", vec!["other"]),
            ("s", vec!["time", "angle"]),
            ("s.inner", vec!["time", "rate"]),
            ("many[0]", vec!["time", "v"]),
            ("many[1]", vec!["time", "v"])
        ]
    );
    for k in 0..40 {
        let x = (2.0 * std::f64::consts::PI * k as f64 * 0.01).sin();
        assert!((found[0].columns[2].values[k] - x).abs() < 1e-12);
        assert_eq!(found[0].columns[5].values[k], (100.0 * found[0].columns[1].values[k]).trunc());
        assert_eq!(found[3].columns[1].values[k], found[0].columns[1].values[k]);
    }
}

#[test]
fn what_is_not_read_is_named_with_its_reason() {
    let found = all("level5.mat");
    let note = &found[0].notes[0];
    for part in ["`words` (text)", "`cells[0]` (text)", "`sparse` (a sparse", "`z` (complex", "`Fs` (one number)"] {
        assert!(note.contains(part), "{note}");
    }
    assert_eq!(found[2].notes, ["left out: `s.mass` (one number)"]);
    assert_eq!(found[3].notes, ["the times are those of `s.time`", "left out: `s.inner.label` (text)"]);
}

#[test]
fn compressed_variables_are_read_and_a_rate_is_taken_where_no_times_are() {
    let found = all("compressed.mat");
    assert_eq!(found[0].axis, Axis::Uniform { start_s: 0.0, interval_s: 0.01 });
    assert_eq!(found[0].columns, all("level5.mat")[0].columns[1..]);
    assert_eq!(found[2].axis, Axis::Unknown, "the structure has times");
}

#[test]
fn the_other_order_of_bytes_is_read_and_objects_are_named() {
    let found = all("big_endian.mat");
    assert_eq!(columns(&found[0]), ["t", "x"]);
    assert_eq!(found[0].columns[0].values[39], 0.39);
    assert_eq!(
        found[0].notes,
        ["left out: `ts` (an object of class `timeseries`: save `t = x.Time` and `d = x.Data`)"]
    );
}

#[test]
fn version_7_3_has_the_same_content() {
    let found = all("v73.mat");
    let names: Vec<_> = found.iter().map(|dataset| (dataset.name.as_str(), columns(dataset))).collect();
    assert_eq!(names, [("", vec!["t", "x", "m[0]", "m[1]", "m[2]", "k"]), ("s", vec!["time", "angle"])]);
    let older = all("level5.mat");
    assert_eq!(found[0].columns[..5], older[0].columns[..5]);
    assert_eq!(found[0].columns[5].values, older[0].columns[5].values);
    let note = &found[0].notes[0];
    for part in ["`words` (text)", "`cells` (a cell array: save it with", "`none` (empty)", "`sparse` (a sparse matrix"]
    {
        assert!(note.contains(part), "{note}");
    }
}

#[test]
fn a_variable_that_states_an_absurd_size_is_not_expanded() {
    use std::io::Write;
    let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    zlib.write_all(&[14, 0, 0, 0, 0, 0, 0, 0x7f]).unwrap();
    zlib.write_all(&[0; 1 << 16]).unwrap();
    let packed = zlib.finish().unwrap();
    let mut file = std::fs::read(data("level5.mat")).unwrap()[..MATLAB_HEADER_BYTES].to_vec();
    file.extend(elements::COMPRESSED.to_le_bytes());
    file.extend((packed.len() as u32).to_le_bytes());
    file.extend(packed);
    let error = datasets_of("file", &file, &|_| true).unwrap_err().explain();
    assert!(error.contains("states 2130706432 bytes, absurd"), "{error}");
}

#[test]
fn files_of_version_4_are_read_in_both_orders_of_bytes() {
    let written = all("level4.mat");
    assert_eq!(columns(&written[0]), ["t", "x", "m[0]", "m[1]", "m[2]", "n"]);
    assert_eq!(written[1].name, "length_7");
    for k in 0..40 {
        let x = (2.0 * std::f64::consts::PI * k as f64 * 0.01).sin();
        assert!((written[0].columns[1].values[k] - x).abs() < 1e-12);
        assert_eq!(written[0].columns[5].values[k], (100.0 * written[0].columns[1].values[k]).trunc());
    }
    assert_eq!(all("level4_big_endian.mat")[0].columns, written[0].columns[..2]);
    let note = &written[0].notes[0];
    for part in ["`words` (text)", "`sparse` (a sparse", "`z` (complex", "`Fs` (one number)"] {
        assert!(note.contains(part), "{note}");
    }
}

#[test]
fn what_is_no_file_of_matlab_is_none_of_version_4_either() {
    let text = b"time,x\n0.0,1.0\n0.1,2.0\n0.2,3.0\n0.3,4.0\n";
    for bytes in [&[0; 200][..], &[0xff; 200], text] {
        assert!(!is_matlab(bytes), "{bytes:02x?}");
        let error = datasets_of("file", bytes, &|_| true).unwrap_err().explain();
        assert!(error.contains("\ncure: "), "{error}");
    }
}

#[test]
fn damaged_files_never_panic() {
    for name in ["level4.mat", "level5.mat", "compressed.mat", "big_endian.mat"] {
        every_damage_is_read_or_refused(name, |bytes| datasets_of("file", bytes, &|_| true));
    }
}
