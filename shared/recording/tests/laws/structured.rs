//! Files of structured formats say more of their numbers than the numbers: scales, offsets, missing
//! values, dates, names. All of it is read, or named as not read.

use recording::{Intake, SeriesSet};
use std::path::PathBuf;

pub(crate) fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

pub(crate) fn read(path: &std::path::Path) -> Result<SeriesSet, String> {
    let intake = Intake { clocks_of_their_own: true, ..Intake::default() };
    recording::read_with(path, &intake).and_then(recording::series).map_err(|error| error.explain())
}

/// The channel has the unit, the rate of 100 Hz, and in row k the value; none where it is `None`.
pub(crate) fn holds(set: &SeriesSet, name: &str, unit: &str, value: impl Fn(usize) -> Option<f64>) {
    let names: Vec<&str> = set.recording.channels.iter().map(|of| of.name.as_str()).collect();
    let channel = set.recording.channel_named(name).unwrap_or_else(|| panic!("{name}: {names:?} {:?}", set.notes));
    assert_eq!(channel.unit, unit, "{name}: {:?}", set.notes);
    let rows = (0..20).filter_map(|k| Some((k, value(k)?)));
    let rows: Vec<(usize, f64)> = rows.collect();
    assert_eq!(channel.value.len(), rows.len(), "{name}: {:?}", set.notes);
    let start_s = channel.time_s[0] - 0.01 * rows[0].0 as f64;
    for ((k, expected), (time_s, found)) in rows.iter().zip(channel.time_s.iter().zip(&channel.value)) {
        assert!((time_s - start_s - 0.01 * *k as f64).abs() < 1e-6, "{name}: row {k} is at {time_s} s");
        assert!((found - expected).abs() < 1e-6 * expected.abs().max(1.0), "{name}: {found} for {expected} in {k}");
    }
}

/// The rate of the files \[deg/s\].
pub(crate) fn rate(k: usize) -> f64 {
    2.0 * k as f64 - 7.0
}

pub(crate) fn torque(k: usize) -> f64 {
    k as f64 - 2.5
}

#[test]
fn scales_offsets_and_missing_values_of_attributes_are_applied_and_noted() {
    let set = read(&data("conventions.h5")).unwrap();
    let stored = |k: usize| (k != 3).then(|| (0.1 * (10.0 * rate(k)) + 5.0).to_radians());
    holds(&set, "imu.rate", "rad/s", stored);
    holds(&set, "imu.torque", "N*m", |k| (k != 4 && k != 5).then(|| torque(k)));
    holds(&set, "imu.raw", "V", |k| Some(0.25 * k as f64));
    holds(&set, "imu.amplified", "V", |k| Some(k as f64));
    let notes = set.notes.join("\n");
    for note in [
        "`imu.rate` is 0.1 times the stored number plus 5: `scale_factor` = 0.1, `add_offset` = 5",
        "1 value(s) of `imu.rate` are marked as missing",
        "1 value(s) of `imu.torque` are outside of its valid values",
        "`lsb` = 0.25",
        "`imu.amplified` states `gain` = 10: not applied",
    ] {
        assert!(notes.contains(note), "{note}: {notes}");
    }
}

#[test]
fn a_clock_counts_from_the_date_that_its_unit_names() {
    let set = read(&data("since.nc")).unwrap();
    assert_eq!(set.origin_s, 1_709_650_800);
    holds(&set, "rate", "rad/s", |k| (k != 10).then(|| rate(k).to_radians()));
    assert_eq!(set.recording.channels.len(), 1, "{:?}", set.notes);
}

#[test]
fn texts_beside_a_matrix_name_its_columns_and_state_their_units() {
    let set = read(&data("named.h5")).unwrap();
    holds(&set, "rate", "rad/s", |k| Some(rate(k).to_radians()));
    holds(&set, "torque", "N*m", |k| Some(torque(k)));
}

#[test]
fn lists_of_texts_in_attributes_name_columns_and_state_units() {
    let set = read(&data("named_by_attributes.h5")).unwrap();
    holds(&set, "rate", "rad/s", |k| Some(rate(k).to_radians()));
    holds(&set, "torque", "N*m", |k| Some(torque(k)));
    holds(&set, "table.rate", "rad/s", |k| Some(rate(k).to_radians()));
}

#[test]
fn texts_that_are_dates_are_the_times() {
    let set = read(&data("stamps.h5")).unwrap();
    assert_eq!(set.origin_s, 1_709_650_800);
    holds(&set, "rate", "?", |k| Some(rate(k)));
}

/// A file of JSON with rates [deg/s] and torques at 100 Hz.
fn json(name: &str, text: &str, channels: [&str; 2], missing: Option<usize>) {
    let set = read(&crate::file(name, text)).unwrap_or_else(|error| panic!("{name}: {error}"));
    holds(&set, channels[0], "?", |k| (Some(k) != missing).then(|| rate(k)));
    holds(&set, channels[1], "?", |k| Some(torque(k)));
}

/// `of` each row, commas between.
fn listed(of: impl Fn(usize, f64, f64, f64) -> String) -> String {
    (0..20).map(|k| of(k, 0.01 * k as f64, rate(k), torque(k))).collect::<Vec<_>>().join(",")
}

const OWN: [&str; 2] = ["rate", "torque"];

#[test]
fn numbers_that_are_none_are_no_samples() {
    for none in ["NaN", "Infinity", "-Infinity", "nan", "-inf", "null", "\"NaN\""] {
        let row = |k: usize, t: f64, w: f64, u: f64| {
            let rate = if k == 9 { none.to_owned() } else { w.to_string() };
            format!("{{\"t\": {t:.2}, \"rate\": {rate}, \"torque\": {u}}}")
        };
        json("none.json", &format!("[{}]", listed(row)), OWN, Some(9));
        json("none.jsonl", &listed(row).replace("},{", "}\n{"), OWN, Some(9));
        let column = listed(|k, _, w, _| if k == 9 { none.to_owned() } else { w.to_string() });
        let (times, torques) = (listed(|_, t, _, _| format!("{t:.2}")), listed(|_, _, _, u| u.to_string()));
        let columns = format!("{{\"t\":[{times}],\"rate\":[{column}],\"torque\":[{torques}]}}");
        json("none_columns.json", &columns, OWN, Some(9));
    }
}

#[test]
fn the_orients_of_tables_in_json_are_read() {
    let columns = |of: &dyn Fn(usize) -> String| {
        let column = |value: fn(f64, f64, f64) -> f64| listed(|k, t, w, u| format!("\"{}\":{}", of(k), value(t, w, u)));
        let [t, w, u] = [column(|t, _, _| t), column(|_, w, _| w), column(|_, _, u| u)];
        (format!("{{\"t\":{{{t}}},\"rate\":{{{w}}},\"torque\":{{{u}}}}}"), w, u)
    };
    json("columns.json", &columns(&|k| k.to_string()).0, OWN, None);
    json("columns_from_7.json", &columns(&|k| (k + 7).to_string()).0, OWN, None);
    for (name, key) in [
        ("stamps.json", (|k: usize| (1_709_650_800_000 + 10 * k).to_string()) as fn(usize) -> String),
        ("dates.json", |k: usize| format!("2024-03-05T15:00:00.{:03}Z", 10 * k)),
    ] {
        let (_, w, u) = columns(&key);
        json(name, &format!("{{\"rate\":{{{w}}},\"torque\":{{{u}}}}}"), OWN, None);
        let row = |k: usize, _: f64, w: f64, u: f64| format!("\"{}\":{{\"rate\":{w},\"torque\":{u}}}", key(k));
        json(name, &format!("{{{}}}", listed(row)), OWN, None);
    }
    let row = |k: usize, t: f64, w: f64, u: f64| format!("\"{k}\":{{\"t\":{t:.2},\"rate\":{w},\"torque\":{u}}}");
    json("index.json", &format!("{{{}}}", listed(row)), OWN, None);
    let (index, rows) = (listed(|k, _, _, _| k.to_string()), listed(|_, t, w, u| format!("[{t:.2},{w},{u}]")));
    let split = format!("{{\"columns\":[\"t\",\"rate\",\"torque\"],\"index\":[{index}],\"data\":[{rows}]}}");
    json("split.json", &split, OWN, None);
    let table = listed(|k, t, w, u| format!("{{\"index\":{k},\"t\":{t:.2},\"rate\":{w},\"torque\":{u}}}"));
    let fields = "{\"name\":\"index\",\"type\":\"integer\"},{\"name\":\"t\",\"type\":\"number\"}";
    let table = format!("{{\"schema\":{{\"fields\":[{fields}]}},\"data\":[{table}]}}");
    json("table.json", &table, ["data.rate", "data.torque"], None);
}

#[test]
fn texts_that_are_numbers_are_numbers() {
    let row =
        |_, t: f64, w: f64, u: f64| format!("{{\"time\":\"{t:.2}\",\"rate\":\"{w}\",\"torque\":\"{u}\",\"id\":\"a\"}}");
    json("texts.jsonl", &listed(row).replace("},{", "}\n{"), OWN, None);
    let lists = [listed(|_, t, _, _| format!("\"{t:.2}\"")), listed(|_, _, w, _| format!("\"{w}\""))];
    let torques = listed(|_, _, _, u| u.to_string());
    json("texts.json", &format!("{{\"t\":[{}],\"rate\":[{}],\"torque\":[{torques}]}}", lists[0], lists[1]), OWN, None);
    // a field of texts of which some are numbers is none
    let row = |k: usize, t: f64, w: f64, _| format!("{{\"t\":{t:.2},\"rate\":{w},\"id\":\"{}\"}}", ["7", "7a"][k % 2]);
    let set = read(&crate::file("ids.json", &format!("[{}]", listed(row)))).unwrap();
    assert_eq!(set.recording.channels.len(), 1, "{:?}", set.notes);
}

#[test]
fn answers_of_data_bases_are_read() {
    let rows = listed(|k, _, w, u| format!("[{},{w},{u}]", 1_709_650_800_000 + 10 * k));
    let series = format!("{{\"name\":\"imu\",\"columns\":[\"time\",\"rate\",\"torque\"],\"values\":[{rows}]}}");
    let influx = format!("{{\"results\":[{{\"statement_id\":0,\"series\":[{series}]}}]}}");
    json("influx.json", &influx, ["imu.rate", "imu.torque"], None);
    let rows = listed(|k, _, w, u| format!("[\"2024-03-05T15:00:00.{:03}Z\",{w},{u}]", 10 * k));
    let series = format!("{{\"name\":\"imu\",\"columns\":[\"time\",\"rate\",\"torque\"],\"values\":[{rows}]}}");
    json(
        "influx_dates.json",
        &format!("{{\"results\":[{{\"series\":[{series}]}}]}}"),
        ["imu.rate", "imu.torque"],
        None,
    );
    let result = |name: &str, value: fn(f64, f64) -> f64| {
        let pairs = listed(|k, _, w, u| format!("[{:.2},\"{}\"]", 1_709_650_800.0 + 0.01 * k as f64, value(w, u)));
        format!("{{\"metric\":{{\"__name__\":\"{name}\",\"job\":\"rig\"}},\"values\":[{pairs}]}}")
    };
    let results = format!("{},{}", result("rate", |w, _| w), result("torque", |_, u| u));
    let prometheus =
        format!("{{\"status\":\"success\",\"data\":{{\"resultType\":\"matrix\",\"result\":[{results}]}}}}");
    json("prometheus.json", &prometheus, ["rate.value", "torque.value"], None);
}

#[test]
fn units_beside_arrays_of_json_are_theirs() {
    let [t, w, u] = [
        listed(|_, t, _, _| format!("{t:.2}")),
        listed(|_, _, w, _| w.to_string()),
        listed(|_, _, _, u| u.to_string()),
    ];
    let by_name = format!(
        "{{\"units\":{{\"t\":\"s\",\"rate\":\"deg/s\",\"torque\":\"N.m\"}},\"t\":[{t}],\"rate\":[{w}],\"torque\":[{u}]}}"
    );
    let alone = format!(
        "[{{\"name\":\"t\",\"unit\":\"s\",\"values\":[{t}]}},{{\"name\":\"rate\",\"unit\":\"deg/s\",\"values\":[{w}]}},\
         {{\"name\":\"torque\",\"unit\":\"Nm\",\"values\":[{u}]}}]"
    );
    for (name, text) in [("units_by_name.json", by_name), ("units_alone.json", alone)] {
        let set = read(&crate::file(name, &text)).unwrap_or_else(|error| panic!("{name}: {error}"));
        holds(&set, "rate", "rad/s", |k| Some(rate(k).to_radians()));
        holds(&set, "torque", "N*m", |k| Some(torque(k)));
    }
}

#[test]
fn texts_of_parquet_that_are_dates_or_numbers_are_such() {
    let set = read(&data("stamps_in_text.parquet")).unwrap();
    assert_eq!(set.origin_s, 1_709_650_800);
    holds(&set, "rate", "?", |k| Some(rate(k)));
    holds(&set, "torque", "?", |k| Some(torque(k)));
    assert!(set.notes.iter().any(|note| note.contains("`mode` (text or bytes)")), "{:?}", set.notes);
}

#[test]
fn durations_lists_decimals_and_half_precision_of_parquet_are_read() {
    let set = read(&data("kinds.parquet")).unwrap();
    holds(&set, "gyro[0]", "?", |k| Some(rate(k)));
    holds(&set, "gyro[1]", "?", |k| Some(-rate(k)));
    holds(&set, "torque", "?", |k| Some(torque(k)));
    holds(&set, "temperature", "?", |k| (k != 3).then(|| 100.0 * rate(k)));
    assert!(set.notes.iter().any(|note| note.contains("`events` (lists of varying length)")), "{:?}", set.notes);
}

#[test]
fn scales_of_the_metadata_of_parquet_are_applied() {
    let set = read(&data("scaled.parquet")).unwrap();
    assert_eq!(set.origin_s, 1_709_650_800);
    holds(&set, "rate", "rad/s", |k| (k != 0).then(|| rate(k).to_radians()));
    holds(&set, "torque", "N*m", |k| Some(torque(k)));
}

#[test]
fn structures_in_cells_of_matlab_are_read_and_carry_the_names_and_units_that_they_state() {
    let set = read(&data("cells.mat")).unwrap();
    holds(&set, "run[0].rate", "?", |k| Some(rate(k)));
    holds(&set, "run[1].torque", "?", |k| Some(torque(k)));
    let set = read(&data("named_signals.mat")).unwrap();
    holds(&set, "rec.rate", "rad/s", |k| Some(rate(k).to_radians()));
    holds(&set, "rec.torque", "N*m", |k| Some(torque(k)));
    let set = read(&data("named_columns.mat")).unwrap();
    holds(&set, "rate", "rad/s", |k| Some(rate(k).to_radians()));
    holds(&set, "torque", "N*m", |k| Some(torque(k)));
}

#[test]
fn dates_texts_and_orders_of_numpy_are_read() {
    let set = read(&data("kinds.npz")).unwrap();
    assert_eq!(set.origin_s, 1_709_650_800);
    holds(&set, "rate", "?", |k| Some(rate(k)));
    holds(&set, "a", "?", |k| Some(rate(k)));
    holds(&set, "b", "?", |k| Some(torque(k) + 0.5));
    assert!(set.notes.iter().any(|note| note.contains("`objects` (Python objects)")), "{:?}", set.notes);
    let set = read(&data("stamps_in_text.npy")).unwrap();
    assert_eq!(set.origin_s, 1_709_650_800);
    holds(&set, "rate", "?", |k| Some(rate(k)));
    holds(&set, "torque", "?", |k| Some(torque(k)));
}
