//! Every bad table is rejected with line, column, value and cure.

use crate::{file, scratch};
use flate2::write::GzEncoder;
use recording::{Imported, ReplayFrames};
use std::io::Write;

/// The explanation of the error that reading `text` gives.
fn refused(name: &str, text: &str) -> String {
    let path = file(name, text);
    let error = recording::read(&path).expect_err("must be refused");
    let explanation = error.explain();
    assert!(explanation.starts_with(&path.display().to_string()), "names the file: {explanation}");
    assert!(explanation.contains("\ncure: "), "names a cure: {explanation}");
    explanation
}

/// The explanation of the error that replaying `text` gives: it is read, as something that has not
/// one rate.
fn not_replayed(name: &str, text: &str) -> String {
    let path = file(name, text);
    let imported = recording::read(&path).unwrap();
    assert!(!matches!(imported, Imported::Table(_) | Imported::Run(_)));
    let explanation = ReplayFrames::new(&imported, None, 10_000_000).unwrap_err().explain();
    assert!(explanation.starts_with(&path.display().to_string()), "names the file: {explanation}");
    assert!(explanation.contains("\ncure: "), "names a cure: {explanation}");
    assert!(recording::csv::read_csv(&path).is_err(), "no table");
    explanation
}

fn contains_all(explanation: &str, parts: &[&str]) {
    for part in parts {
        assert!(explanation.contains(part), "`{part}` is missing in: {explanation}");
    }
}

#[test]
fn missing_time_column() {
    contains_all(
        &not_replayed("spectrum.csv", "frequency [Hz],a [m/s^2]\n0,1\n1,2\n"),
        &["line 1, column 1 `frequency [Hz]`", "no column is known to hold the times", "spectrum"],
    );
    contains_all(
        &refused("bare.csv", "0,1\n1,2\n"),
        &["line 1, column 1", "no header", "--time-column 1:s --channel 'angle = 2 [rad]'"],
    );
    contains_all(
        &refused("none.csv", "rate [rad/s],x [m]\n0,1\n1,2\n"),
        &["line 1, column 1 `rate [rad/s]`", "--time-column rate:s", "row:100Hz", "columns: rate, x"],
    );
}

#[test]
fn whole_numbers_without_a_time_unit_are_asked_about() {
    contains_all(
        &refused("counts.csv", "timestamp,x [m]\n27329869,1\n27339869,2\n27349869,3\n"),
        &["line 1, column 1 `timestamp`", "states no unit", "100 Hz as us", "--time-column timestamp:us"],
    );
}

#[test]
fn times_whose_digits_are_lost_are_hopeless_and_the_reason_is_said() {
    let rows: String = (0..9).map(|k| format!("1.4E+018,{k}\n")).collect();
    contains_all(
        &refused("rounded.csv", &format!("time,x [m]\n{rows}")),
        &["line 1, column 1 `time`", "same time as the row before (1.4e18", "all digits", "spreadsheet"],
    );
}

#[test]
fn missing_unknown_and_wrong_units() {
    contains_all(
        &refused("odd.csv", "time [s],x [furlong]\n0,1\n1,2\n"),
        &["line 1, column 2 `x [furlong]`", "accepted: -, %, s, ms", "--channel"],
    );
    contains_all(
        &refused("timeunit.csv", "time [m],x [m]\n0,1\n1,2\n"),
        &["line 1, column 1 `time [m]`", "accepted: s, ms, us, ns, min, h"],
    );
    let table = recording::csv::read_csv(&file("dimension.csv", "time [s],x [m],rate [m/s]\n0,1,2\n1,2,3\n")).unwrap();
    let error = recording::Channels::find(&table, None).unwrap_err().explain();
    contains_all(
        &error,
        &["dimension.csv: line 1, column 3 `rate [m/s]`", "`imu.rate_z`", "accepted: rad/s", "cure: "],
    );
}

#[test]
fn a_unit_that_is_not_known_is_answered_with_one_of_its_own_dimension() {
    // Not N/m, which has as many letters: a product stays a product.
    contains_all(&refused("newt.csv", "time [s],x [Newt.m]\n0,1\n1,2\n"), &["unit `Newt.m`", "[newton.m]"]);
    let set = series_of("two.csv", "time [s],x [furlong],y [m]\n0,1,1\n1,2,2\n");
    assert_eq!(set.recording.channels.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["y"]);
    assert!(set.notes[0].contains("left out: `x` (unit `furlong` is not known"), "{:?}", set.notes);
}

fn series_of(name: &str, text: &str) -> recording::SeriesSet {
    recording::series(recording::read(&file(name, text)).unwrap()).unwrap()
}

#[test]
fn ragged_rows() {
    contains_all(
        &refused("ragged.csv", "time [s],x [m],y [m]\n0,1,2\n\n1,2\n2,1,2\n"),
        &["line 4", "2 columns, the header has 3", "`1,2`", "complete or delete"],
    );
    contains_all(&refused("long.csv", "time [s],x [m]\n0,1\n1,2,7\n"), &["line 3", "3 columns, the header has 2"]);
}

#[test]
fn cells_that_are_no_number() {
    for (cell, shown) in [("abc", "`abc`"), ("1.2.3", "`1.2.3`"), ("0x10", "`0x10`"), ("1 2", "`1 2`")] {
        contains_all(
            &refused("number.csv", &format!("time [s],y [m]\n0,2\n1,{cell}\n")),
            &["line 3, column 2 `y [m]`", shown, "is not a number", "decimal"],
        );
    }
    // No time, no line of a spectrum.
    contains_all(
        &refused("notime.csv", "time [s],x [m]\n0,1\n,1\n"),
        &["line 3, column 1 `time [s]`", "`` is not a number"],
    );
    contains_all(
        &refused("noline.csv", "frequency [Hz],x [m]\n0,1\n1,\n"),
        &["line 3, column 2 `x [m]`", "`` is not a number"],
    );
}

#[test]
fn values_beyond_what_a_number_holds() {
    contains_all(
        &refused("finite.csv", "time [s],x [m]\n0,1\n1,1e999\n2,3\n"),
        &["line 3, column 2 `x [m]`", "`1e999`", "is not finite", "delete the row"],
    );
    // Finite in the file, not in SI.
    contains_all(
        &refused("overflow.csv", "time [s],x [g]\n0,1\n1,1.7e308\n"),
        &["line 3, column 2 `x [g]`", "not finite"],
    );
}

#[test]
fn empty_files_and_files_with_too_few_rows() {
    contains_all(&refused("empty.csv", ""), &["line 1", "the file is empty", "export"]);
    contains_all(&refused("blank.csv", "\n\n"), &["the file is empty"]);
    contains_all(&refused("header.csv", "time [s],x [m]\n"), &["0 row(s)", "at least two"]);
    contains_all(&refused("one.csv", "time [s],x [m]\n0,1\n"), &["line 2", "1 row(s)", "at least two"]);
}

#[test]
fn time_that_runs_backwards() {
    contains_all(
        &refused("back.csv", "time [s],x [m]\n0,1\n0.5,1\n0.4,1\n0.6,1\n"),
        &["line 4, column 1 `time [s]`", "0.5 s is followed by 0.4 s", "sort the rows"],
    );
    contains_all(
        &not_replayed("restart.csv", "time [s],x [m]\n0,1\n0.5,1\n0,1\n0.5,1\n"),
        &["line 4", "0.5 s is followed by 0 s", "several recordings one after another: split it before line 4"],
    );
}

#[test]
fn a_recording_of_one_row_is_none_where_time_starts_again() {
    contains_all(&refused("glitch.csv", "time [s],x [m]\n0,1\n1,1\n0,1\n"), &["line 4", "1 s is followed by 0 s"]);
    contains_all(&refused("first.csv", "time [s],x [m]\n1,1\n0,1\n1,1\n"), &["line 3", "1 s is followed by 0 s"]);
}

#[test]
fn frequencies_out_of_order() {
    contains_all(
        &refused("order.csv", "frequency [Hz],x [m]\n0,1\n2,1\n1,1\n"),
        &["line 4, column 1 `frequency [Hz]`", "2 Hz is followed by 1 Hz", "sort the rows"],
    );
    contains_all(
        &refused("negative.csv", "frequency [Hz],x [m]\n-1,1\n2,1\n"),
        &["line 2, column 1", "-1 Hz is negative"],
    );
    contains_all(&refused("line.csv", "frequency [Hz],x [m]\n1,1\n"), &["line 2", "1 row(s)"]);
    contains_all(&refused("unit.csv", "frequency [s],x [m]\n1,1\n"), &["line 1, column 1", "accepted: Hz, kHz"]);
}

#[test]
fn one_time_with_two_values() {
    contains_all(
        &refused("conflict.csv", "time [s],x [m],y [mm]\n0,1,1\n0.5,1,1\n0.5,1,2\n"),
        &["line 4, column 3 `y [mm]`", "time 0.5 s stands twice", "0.001 and 0.002", "more digits"],
    );
}

#[test]
fn a_rate_that_changes_for_good_is_found_at_its_line() {
    let mut text = String::from("time [s],x [m]\n");
    let mut t = 0.0;
    for row in 0..400 {
        text.push_str(&format!("{t:.3},0\n"));
        t += if row < 230 { 0.01 } else { 0.02 };
    }
    // Row 231 (line 233) is the first that comes 0.02 s after its predecessor.
    contains_all(
        &not_replayed("rate.csv", &text),
        &["needs one rate", "line 233, column 1", "at 2.32 s", "from 0.01", "to 0.02", "split the file at this line"],
    );
}

#[test]
fn a_rate_that_drifts_away_slowly_is_found_too() {
    let mut text = String::from("time [s],x [m]\n");
    let mut t = 0.0;
    for row in 0..2000 {
        text.push_str(&format!("{t:.6},0\n"));
        t += 0.01 * (1.0 + 0.4 * f64::from(row) / 2000.0);
    }
    contains_all(&not_replayed("drift.csv", &text), &["the sample interval changes", "split the file"]);
}

#[test]
fn a_time_unit_that_cannot_be_right() {
    contains_all(
        &refused("years.csv", "time [h],x [m]\n0,0\n1e6,0\n"),
        &["line 3, column 1", "3600000000 s", "check the unit"],
    );
}

fn gzipped(text: &str) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(text.as_bytes()).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn truncated_and_corrupt_gzip() {
    let rows: String = (0..20_000).map(|i| format!("{},{}\n", f64::from(i) * 0.01, (i * 7919) % 10007)).collect();
    let bytes = gzipped(&format!("time [s],x [m]\n{rows}"));
    let path = scratch("cut.csv.gz");
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let error = recording::read(&path).unwrap_err().explain();
    contains_all(&error, &["cut.csv.gz", "ends after line ", "complete rows", "truncated", "copy the file again"]);
    // Even the trailer alone: the numbers are there, their checksum is not.
    std::fs::write(&path, &bytes[..bytes.len() - 4]).unwrap();
    contains_all(
        &recording::read(&path).unwrap_err().explain(),
        &["after line 20001", "20000 complete rows", "truncated"],
    );
    let mut corrupt = bytes.clone();
    let trailer = bytes.len() - 6;
    corrupt[trailer] ^= 1;
    std::fs::write(&path, &corrupt).unwrap();
    contains_all(
        &recording::read(&path).unwrap_err().explain(),
        &["cut.csv.gz", "corrupt behind line", "copy the file again"],
    );
}

#[test]
fn a_file_that_ends_behind_its_first_bytes_is_refused_by_its_place() {
    for bytes in [
        &b"ULog\x01\x12\x35\x01"[..],
        b"#ROSBAG V2.0\n",
        b"\x89HDF\r\n\x1a\n",
        b"MATLAB 5.0 MAT-file",
        b"PAR1",
        b"PK\x03\x04",
        b"SQLite format 3\0",
        b"\x93NUMPY\x01\0",
    ] {
        let path = scratch("foreign.bin");
        std::fs::write(&path, bytes).unwrap();
        contains_all(&recording::read(&path).unwrap_err().explain(), &["foreign.bin", "cure: "]);
    }
    let path = scratch("noise.bin");
    std::fs::write(&path, [0u8, 1, 2, 3]).unwrap();
    contains_all(
        &recording::read(&path).unwrap_err().explain(),
        &["not a known format", "[00, 01, 02, 03]", "give CSV"],
    );
    let absent = recording::read(&scratch("absent.csv")).unwrap_err().explain();
    contains_all(&absent, &["absent.csv", "cannot open", "check the path"]);
}
