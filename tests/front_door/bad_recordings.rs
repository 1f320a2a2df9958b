//! Recordings as they come: refused with file, place, value and cure, or repaired, counted and
//! reported.

use crate::desk::{Folder, estimates, number, skipped};
use flate2::{Compression, write::GzEncoder};
use serde_json::Value;
use std::io::Write;

const HEADER: &str = "time [s],acceleration_1 [m/s^2],acceleration_2 [m/s^2]";
/// Damped frequency of the free decay in the files; obsid states the undamped one.
const FREQUENCY_HZ: f64 = 5.0;
const DAMPING: f64 = 0.002;

/// Rows of a free decay on two channels at 100 Hz, with a noise that repeats.
fn decay() -> Vec<[String; 3]> {
    let mut noise = 1_u64;
    let mut random = move || {
        noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        1e-3 * ((noise >> 33) as f64 / f64::from(1_u32 << 30) - 1.0)
    };
    let row = |i: usize| {
        let t_s = i as f64 * 0.01;
        let omega = core::f64::consts::TAU * FREQUENCY_HZ;
        let a = (-DAMPING * omega * t_s).exp() * (omega * t_s).sin();
        [format!("{t_s:.6}"), format!("{:.9}", a + random()), format!("{:.9}", 0.5 * a + random())]
    };
    (0..2000).map(row).collect()
}

fn csv(header: &str, rows: &[[String; 3]]) -> String {
    rows.iter().fold(format!("{header}\n"), |text, row| text + &row.join(",") + "\n")
}

fn gzip(text: &str) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(text.as_bytes()).unwrap();
    encoder.finish().unwrap()
}

fn first_mode(result: &Value) -> (f64, f64) {
    let row = &estimates(result, "modal")[0];
    assert_eq!(row["name"], "f1");
    (number(row, "value"), number(row, "sigma"))
}

#[test]
fn what_is_repaired_is_reported_and_leaves_the_numbers_as_they_were() {
    let folder = Folder::new("repairs");
    let rows = decay();
    folder.file("good.csv", csv(HEADER, &rows));
    folder.file("twice.csv", csv(HEADER, &[&rows[..300], &rows[299..]].concat()));
    folder.file("gap.csv", csv(HEADER, &[&rows[..300], &rows[340..]].concat()));
    folder.file("good.csv.gz", gzip(&csv(HEADER, &rows)));
    let replay = |file: &str| folder.ask(&["replay", file, "--link", "lockstep", "--json"]).ends_with(0);
    let good = replay("good.csv");
    assert!(good.stderr.is_empty(), "{good}");
    let good = good.object();
    let (f_hz, sigma_hz) = first_mode(&good);
    let undamped_hz = FREQUENCY_HZ / (1.0 - DAMPING * DAMPING).sqrt();
    assert!((f_hz - undamped_hz).abs() < 4.0 * sigma_hz && sigma_hz < 1e-4, "{f_hz} +- {sigma_hz}");
    assert_eq!(replay("good.csv.gz").object()["digest"], good["digest"]);
    let twice = replay("twice.csv").says(&["twice.csv: 1 row(s) stood twice and were dropped once"]).object();
    assert_eq!(twice["digest"], good["digest"]);
    let gap = replay("gap.csv").says(&["gap.csv: gap of 0.41 s from 2.99 s (line 302): reported, not filled"]).object();
    let (gap_hz, gap_sigma_hz) = first_mode(&gap);
    assert!((gap_hz - f_hz).abs() < 4.0 * gap_sigma_hz.max(sigma_hz), "{gap_hz} +- {gap_sigma_hz}");
}

#[test]
fn a_cell_a_row_or_a_time_that_cannot_be_is_refused_with_its_line_and_column() {
    let folder = Folder::new("cells");
    let rows = decay();
    let cell = |value: &str| {
        let mut rows = rows.clone();
        rows[500][1] = value.into();
        csv(HEADER, &rows)
    };
    let refused = |name: &str, text: String, says: &[&str]| {
        folder.file(name, text);
        folder.ask(&["replay", name, "--link", "lockstep", "--json"]).refuses(&[&[name], says].concat());
    };
    refused(
        "nan.csv",
        cell("NaN"),
        &["needs one rate", "line 502, column 2 `acceleration_1 [m/s^2]` is empty", "split the file"],
    );
    refused("inf.csv", cell("-inf"), &["line 502, column 2"]);
    refused("word.csv", cell("abc"), &["needs one rate", "line 502, column 2", "`abc` is not a number"]);
    refused("comma.csv", cell("1,5"), &["line 502", "4 columns, the header has 3"]);
    let mut backwards = rows.clone();
    backwards[700][0] = "1.0".into();
    refused(
        "backwards.csv",
        csv(HEADER, &backwards),
        &["line 702, column 1", "time runs backwards", "6.99", "sort the rows"],
    );
    let mut conflict = rows.clone();
    conflict[700][0] = conflict[699][0].clone();
    refused("conflict.csv", csv(HEADER, &conflict), &["line 702", "6.99 s stands twice", "differs"]);
    let mut slower = rows.clone();
    for (i, row) in slower[1000..].iter_mut().enumerate() {
        row[0] = format!("{:.6}", 10.0 + 0.02 * i as f64);
    }
    let changes = ["line 1003", "changes from 0.01 s to 0.02 s for good", "resample"];
    refused("rate.csv", csv(HEADER, &slower), &changes);
    refused(
        "cut.csv",
        csv(HEADER, &rows[..10]) + "0.1,0.5\n0.11,0.5,0.5\n",
        &["line 12", "2 columns, the header has 3", "cut last row"],
    );
}

#[test]
fn a_header_without_time_unit_or_known_unit_is_refused_with_its_column() {
    let folder = Folder::new("headers");
    let rows = decay();
    let refused = |name: &str, header: &str, says: &[&str]| {
        folder.file(name, csv(header, &rows));
        folder.ask(&["replay", name, "--link", "lockstep"]).refuses(&[&[name, "line 1, column"], says].concat());
    };
    refused(
        "no_time.csv",
        "acceleration_3 [m/s^2],acceleration_1 [m/s^2],acceleration_2 [m/s^2]",
        &["column 1", "to hold the times", "--time-column"],
    );
    refused(
        "no_unit.csv",
        "time [s],acceleration_1,acceleration_2 [m/s^2]",
        &["column 2 `acceleration_1`", "not stated", "--channel"],
    );
    refused(
        "furlong.csv",
        "time [s],acceleration_1 [furlong],acceleration_2 [m/s^2]",
        &["`furlong`", "accepted: m/s^2"],
    );
    refused("newton.csv", "time [s],acceleration_1 [N],acceleration_2 [m/s^2]", &["`N` does not measure `accel.1`"]);
}

#[test]
fn a_file_that_is_empty_cut_corrupt_missing_or_no_file_is_refused() {
    let folder = Folder::new("files");
    let whole = gzip(&csv(HEADER, &decay()));
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 0xff;
    folder.file("empty.csv", "");
    folder.file("header.csv", format!("{HEADER}\n"));
    folder.file("cut.csv.gz", &whole[..whole.len() / 2]);
    folder.file("flipped.csv.gz", flipped);
    folder.file("log.ulg", b"ULog\x01\x12\x35\x01");
    folder.file("noise.bin", [0, 1, 2, 3, 200, 0, 255]);
    let refused = |file: &str, says: &[&str]| {
        folder.ask(&["replay", file, "--link", "lockstep"]).refuses(&[&[file], says].concat());
    };
    refused("empty.csv", &["line 1", "empty"]);
    refused("header.csv", &["line 1", "0 row(s)"]);
    refused("cut.csv.gz", &["truncated", "complete rows"]);
    refused("flipped.csv.gz", &["gzip stream is corrupt behind line"]);
    refused("log.ulg", &["the header needs 16 bytes", "copy the file again"]);
    refused("noise.bin", &["not a known format"]);
    refused("nowhere.csv", &["No such file"]);
    refused(".", &["a folder"]);
    for file in ["nowhere.mcap", ".", "empty.csv"] {
        folder.ask(&["digest", file]).refuses(&[file]);
    }
    folder.file("table.csv", csv(HEADER, &decay()));
    folder.ask(&["digest", "table.csv"]).refuses(&["table.csv", "not an MCAP file", "--record"]);
}

#[cfg(unix)]
#[test]
fn a_file_without_permission_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new("permission");
    folder.file("secret.csv", csv(HEADER, &decay()));
    let path = folder.path().join("secret.csv");
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o000)).unwrap();
    if std::fs::File::open(&path).is_ok() {
        skipped("a file without permission is refused: this user reads every file");
        return;
    }
    folder.ask(&["replay", "secret.csv"]).refuses(&["secret.csv", "ermission denied", "permissions"]);
}

#[test]
fn a_map_names_columns_and_its_faults_are_shown_at_their_place() {
    let folder = Folder::new("maps");
    let rows = decay();
    folder.file("own.csv", csv("time [s],tip [m/s^2],root [m/s^2]", &rows));
    folder.file("plain.csv", csv(HEADER, &rows));
    folder.file("good.toml", "[channels]\naccel.1 = \"tip [m/s^2]\"\naccel.2 = \"root [m/s^2]\"\n");
    let replay = |map: &str| folder.ask(&["replay", "own.csv", "--map", map, "--link", "lockstep", "--json"]);
    let plain = folder.ask(&["replay", "plain.csv", "--link", "lockstep", "--json"]).result();
    assert_eq!(replay("good.toml").result()["digest"], plain["digest"]);
    let refused = |name: &str, text: &str, says: &[&str]| {
        folder.file(name, text);
        replay(name).refuses(says);
    };
    let at = "channel.toml: line 2, column 5";
    refused(
        "channel.toml",
        "[channels]\nimu.acel_x = \"tip [m/s^2]\"\n",
        &[at, "`imu.acel_x`", "did you mean `imu.accel_x`?"],
    );
    let at = "column.toml: line 2, column 11";
    refused("column.toml", "[channels]\naccel.1 = \"tap [m/s^2]\"\n", &[at, "own.csv", "did you mean `tip`?"]);
    refused(
        "force.toml",
        "[channels]\nforce.x = \"tip [m/s^2]\"\n",
        &["own.csv: line 1, column 2", "does not measure `force.x`"],
    );
    refused("hole.toml", "[channels]\naccel.2 = \"tip [m/s^2]\"\n", &["`accel.1` is missing"]);
    refused("nothing.toml", "", &["names no channel"]);
    refused("syntax.toml", "[channels\n", &["syntax.toml: line 1"]);
    replay("nowhere.toml").refuses(&["nowhere.toml", "No such file"]);
    folder.ask(&["replay", "own.csv", "--link", "lockstep"]).refuses(&[
        "own.csv",
        "tip [m/s^2]",
        "accel_x = \"tip [m/s^2]\"",
    ]);
}
