use super::*;
use crate::damage::{data, every_damage_is_read_or_refused};

const FILES: [&str; 6] = ["none", "snappy", "gzip", "zstd", "lz4", "encodings"];

fn read(name: &str) -> RawDataset {
    datasets(&data(&format!("{name}.parquet")), &|_| true).unwrap().remove(0)
}

#[test]
fn numbers_truths_and_times_are_read_with_every_compression_and_encoding() {
    for name in FILES {
        let found = read(name);
        let names: Vec<_> = found.columns.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["time", "angle", "rate", "count", "big", "on", "list[0]", "list[1]"], "{name}");
        for k in 0..40 {
            let x = (2.0 * std::f64::consts::PI * k as f64 * 0.01).sin();
            let row: Vec<f64> = found.columns.iter().map(|column| column.values[k]).collect();
            assert_eq!(row[0], (1_700_000_000_000_000 + 10_000 * k as i64) as f64 / 1e6, "{name}");
            assert!(if k == 3 { row[1].is_nan() } else { (row[1] - x).abs() < 1e-12 }, "{name}");
            assert!((row[2] - (2.0 * std::f64::consts::PI * k as f64 * 0.01).cos()).abs() < 1e-7, "{name}");
            assert_eq!(row[3..5], [k as f64 - 5.0, 1000.0 * k as f64], "{name}");
            assert_eq!(row[5], f64::from(u8::from(x > 1e-15)), "{name} {k}");
        }
    }
}

#[test]
fn the_column_of_dates_leads_and_units_come_from_the_metadata_of_arrow() {
    let found = read("snappy");
    assert_eq!(found.axis, Axis::Time(0));
    let units: Vec<_> = found.columns.iter().map(|column| column.unit.as_deref()).collect();
    assert_eq!(units, [Some("s"), Some("rad"), None, None, None, None, None, None]);
    let notes = found.notes.join("; ");
    assert!(notes.contains("`label` (text or bytes)"), "{notes}");
}

#[test]
fn a_compression_that_is_not_read_is_named_with_the_cure() {
    let error = datasets(&data("brotli.parquet"), &|_| true).unwrap_err().explain();
    assert!(error.contains("the compression Brotli (number 4) is not read") && error.contains("snappy"), "{error}");
}

#[test]
fn a_file_that_is_cut_is_an_error() {
    let whole = std::fs::read(data("none.parquet")).unwrap();
    let error = datasets_of("file", &whole[..whole.len() - 9], &|_| true).unwrap_err().explain();
    assert!(error.contains("it is cut"), "{error}");
}

#[test]
fn damaged_files_never_panic() {
    for name in FILES {
        every_damage_is_read_or_refused(&format!("{name}.parquet"), |bytes| datasets_of("file", bytes, &|_| true));
    }
}
