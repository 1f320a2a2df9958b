//! Stamps since 1970 keep the digits that tell samples apart; equal names get names of their own.

use crate::{file, scratch};
use recording::{Imported, SeriesSet, read, series};

/// A sample every 20 µs and a little more: 256 ns, the step of an `f64` of these stamps, would be
/// seen.
const START_NS: u64 = 1_700_000_000_123_456_789;
const STEP_NS: u64 = 20_001;

fn stamps_ns() -> Vec<u64> {
    (0..40).map(|k| START_NS + k * STEP_NS).collect()
}

fn of(path: &std::path::Path) -> SeriesSet {
    let imported = read(path).unwrap();
    assert!(!matches!(imported, Imported::Spectrum(_)));
    series(imported).unwrap()
}

/// Times count from the whole second before the first, to `tolerance_s`.
fn assert_exact(set: &SeriesSet, tolerance_s: f64, what: &str) {
    assert_eq!(set.origin_s, 1_700_000_000, "{what}");
    assert!(set.notes.iter().any(|note| note.contains("2023-11-14T22:13:20Z")), "{what}: {:?}", set.notes);
    let times = &set.recording.channels[0].time_s;
    assert_eq!(times.len(), 40);
    for (time_s, ns) in times.iter().zip(stamps_ns()) {
        let exact = (ns - 1_700_000_000_000_000_000) as f64 / 1e9;
        assert!((time_s - exact).abs() <= tolerance_s, "{what}: {time_s} for {exact}");
    }
}

#[test]
fn stamps_since_1970_keep_their_steps_in_text() {
    type Unit<'a> = (&'a str, f64, &'a dyn Fn(u64) -> String);
    let units: [Unit<'_>; 4] = [
        ("ns", 0.0, &|ns| ns.to_string()),
        ("us", 1e-6, &|ns| (ns / 1000).to_string()),
        ("ms", 1e-15, &|ns| format!("{}.{:06}", ns / 1_000_000, ns % 1_000_000)),
        ("s", 1e-15, &|ns| format!("{}.{:09}", ns / 1_000_000_000, ns % 1_000_000_000)),
    ];
    for (unit, tolerance_s, spelled) in units {
        let rows: String = stamps_ns().iter().enumerate().map(|(k, ns)| format!("{},{k}\n", spelled(*ns))).collect();
        let path = file(&format!("stamps_{unit}.csv"), &format!("stamp [{unit}],angle [rad]\n{rows}"));
        assert_exact(&of(&path), tolerance_s, unit);
    }
}

#[test]
fn stamps_since_1970_keep_their_steps_in_arrays() {
    let header = "{'descr': [('stamp_ns', '<i8'), ('angle_rad', '<f8')], 'fortran_order': False, 'shape': (40,), }";
    let header = format!("{header:<117}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    for (k, ns) in stamps_ns().into_iter().enumerate() {
        bytes.extend(ns.to_le_bytes());
        bytes.extend((k as f64).to_le_bytes());
    }
    let path = scratch("stamps.npy");
    std::fs::write(&path, &bytes).unwrap();
    assert_exact(&of(&path), 0.0, "whole numbers");
    let dates = String::from_utf8_lossy(&bytes[10..128]).replace("'<i8'", "'<M8[ns]'");
    let dates = format!("{:<117}\n", dates.trim_end());
    bytes.splice(10..128, dates.into_bytes());
    std::fs::write(&path, &bytes).unwrap();
    assert_exact(&of(&path), 1e-15, "dates");
}

#[test]
fn a_clock_from_zero_is_left_as_it_is() {
    let path = file("stamps_zero.csv", "time [s],angle [rad]\n0.1,1\n0.2,2\n0.3,3\n");
    let set = of(&path);
    assert_eq!((set.origin_s, &set.recording.channels[0].time_s[..]), (0, &[0.1, 0.2, 0.3][..]));
}

#[test]
fn a_name_that_stands_again_gets_the_next_number_that_is_free() {
    let names = |header: &str| {
        let cells = header.split(',').count();
        let row = |k: usize| (0..cells).map(|cell| (k * cells + cell).to_string()).collect::<Vec<_>>().join(",") + "\n";
        let rows: String = (1..5).map(row).collect();
        let set = of(&file("names.csv", &format!("{header}\n{rows}")));
        set.recording.channels.into_iter().map(|channel| channel.name).collect::<Vec<_>>()
    };
    assert_eq!(names("time [s],x [m],x [m],x_2 [m]"), ["x", "x_3", "x_2"]);
    assert_eq!(names("time [s],x_2 [m],x [m],x [m],x [m]"), ["x_2", "x", "x_3", "x_4"]);
    assert_eq!(names("time [s],x [m],x [m]"), ["x", "x_2"]);
}
