//! Files as loggers really write them: headers, cells and clocks.

use recording::{Imported, Intake, SeriesSet, TimeColumn};
use std::path::PathBuf;

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn read(name: &str, intake: &Intake) -> SeriesSet {
    let set = recording::read_with(&data(name), intake).and_then(recording::series);
    set.unwrap_or_else(|error| panic!("{name}: {}", error.explain()))
}

/// File, time column to be said, names and units of both channels (`?`: not in the file), decimals.
type Header = (&'static str, &'static str, [(&'static str, &'static str); 2], f64);
const HEADERS: &[Header] = &[
    ("comment_and_hash.csv", "", [("accel_x", "?"), ("accel_y", "?")], 5.0),
    ("iso_time.csv", "", [("a", "?"), ("b", "?")], 5.0),
    ("nan_cell.csv", "", [("a", "m/s^2"), ("b", "m/s^2")], 5.0),
    ("no_units.csv", "", [("velocity", "?"), ("torque", "?")], 5.0),
    ("semicolon_comma.csv", "", [("a", "m/s^2"), ("b", "m/s^2")], 5.0),
    ("string_columns.csv", "", [("field.header.frame_id", "?"), ("field.position0", "?")], 4.0),
    ("timestamp_us.csv", "timestamp:us", [("gyro_rad[0]", "?"), ("accelerometer_m_s2[0]", "m/s^2")], 5.0),
    ("trailing_commas.csv", "", [("a", "m/s^2"), ("b", "m/s^2")], 5.0),
    ("units_in_parentheses.csv", "", [("Acceleration x", "m/s^2"), ("Acceleration y", "m/s^2")], 5.0),
];

#[test]
fn headers_of_loggers_give_both_channels_at_100_hz_with_the_units_that_they_state() {
    let mut wrong = Vec::new();
    for (file, clock, channels, decimals) in HEADERS {
        let time_column = (!clock.is_empty()).then(|| TimeColumn::parse(clock).unwrap());
        let set = read(&format!("headers/{file}"), &Intake { time_column, ..Intake::default() });
        let found: Vec<(&str, &str)> =
            set.recording.channels.iter().map(|of| (of.name.as_str(), of.unit.as_str())).collect();
        if found != channels {
            wrong.push(format!("{file}: {found:?}"));
            continue;
        }
        for (k, channel) in set.recording.channels.iter().enumerate() {
            // one row more, whose first cell is NaN
            let rows = 300 + usize::from(*file == "nan_cell.csv" && k == 1);
            let first = channel.time_s[0];
            // stamps of nanoseconds since 1970 in seconds are right to 2.4e-7 s
            let row = |time: f64| ((time - first) * 100.0).round();
            // which stands at 0.1 s, the row of that time a millisecond later
            let odd = |time: f64| *file == "nan_cell.csv" && (0.0995..0.1015).contains(&time);
            let even = channel
                .time_s
                .iter()
                .filter(|time| !odd(**time))
                .all(|time| ((time - first) * 100.0 - row(*time)).abs() < 1e-4);
            let law = |i: f64| if k == 0 { (0.3 * i).sin() } else { (0.2 * i).cos() };
            let rounding = 0.501 * 10_f64.powf(-decimals);
            let samples = channel.time_s.iter().zip(&channel.value).filter(|(time, _)| !odd(**time));
            let right = samples.into_iter().all(|(t, v)| (v - law(row(*t))).abs() < rounding);
            if channel.value.len() != rows || !even || !right {
                wrong.push(format!("{file}: {} of {}, {even}, {right}", channel.value.len(), channel.name));
            }
        }
    }
    assert_eq!(wrong, Vec::<String>::new());
}

#[test]
fn an_even_clock_takes_the_place_of_stamps_that_were_rounded_to_the_millisecond() {
    let Imported::Table(table) = recording::read(&data("field/ms_of_300_hz.csv.gz")).unwrap() else { panic!() };
    // a line through 12 000 stamps within a millisecond, over 40 s
    assert!((table.timing.interval_s * 300.0 - 1.0).abs() < 2.5e-5, "{}", table.timing.interval_s);
    assert!(table.timing.jitter_max < 1e-9 && table.timing.gaps.is_empty());
    assert!(table.time_s.iter().enumerate().all(|(k, t)| (t - k as f64 / 300.0).abs() < 1e-3));
    assert!(
        table.notes[0].contains("rounded to 0.001 s") && table.notes[0].contains("even clock"),
        "{:?}",
        table.notes
    );
}

#[test]
fn rows_that_are_lost_leave_one_rate_and_one_note() {
    let Imported::Table(table) = recording::read(&data("field/every_tenth.csv.gz")).unwrap() else { panic!() };
    assert!((table.timing.interval_s - 0.02).abs() < 1e-9);
    assert_eq!((table.timing.gaps.len(), table.notes.len()), (1199, 1), "{:?}", table.notes);
    assert!(table.notes[0].starts_with("1199 gaps, 1199 rows missing"), "{:?}", table.notes);
}

/// A file of rows of one channel at times, and what is read.
fn of_times(name: &str, times: &[f64], value: fn(usize) -> f64) -> Result<Imported, recording::RecordingError> {
    let path = std::env::temp_dir().join(format!("obsid-{}-{name}.csv", std::process::id()));
    let rows: String = times.iter().enumerate().map(|(k, t)| format!("{t:.6},{:.6}\n", value(k))).collect();
    std::fs::write(&path, format!("time [s],rate [rad/s]\n{rows}")).unwrap();
    let read = recording::read(&path);
    std::fs::remove_file(path).unwrap();
    read
}

#[test]
fn rows_of_a_packet_with_one_stamp_get_times_of_their_own_and_a_contradiction_stays_one() {
    let sine = |k: usize| (0.1 * k as f64).sin();
    let packets: Vec<f64> = (0..1000).map(|k| 0.05 * (k / 5 + 1) as f64).collect();
    let Imported::Table(table) = of_times("packets", &packets, sine).unwrap() else { panic!() };
    assert_eq!(table.time_s.len(), 1000);
    assert!((table.timing.interval_s - 0.01).abs() < 1e-6, "{}", table.timing.interval_s);
    // one value of a sine stands twice in a packet: still a row
    let repeated = |k: usize| if k % 5 == 3 { (0.1 * (k - 1) as f64).sin() } else { (0.1 * k as f64).sin() };
    let Imported::Table(table) = of_times("repeated", &packets, repeated).unwrap() else { panic!() };
    assert_eq!((table.time_s.len(), table.timing.duplicates), (1000, 0));
    let mut once: Vec<f64> = (0..500).map(|k| 0.01 * f64::from(k)).collect();
    once[250] = once[249];
    let error = of_times("once", &once, sine).unwrap_err().explain();
    assert!(error.contains("line 252") && error.contains("stands twice"), "{error}");
}

#[test]
fn a_clock_that_is_uneven_stays_so() {
    let mut time = 0.0;
    let uneven: Vec<f64> = (0..600_u64)
        .map(|k| {
            time += 0.004 + 0.006 * ((k * k * 2_654_435_761 % 1009) as f64 / 1009.0);
            time
        })
        .collect();
    let Imported::Series(set) = of_times("uneven", &uneven, |k| (0.1 * k as f64).sin()).unwrap() else { panic!() };
    assert!(set.notes[0].starts_with("not one rate"), "{:?}", set.notes);
    assert!(set.table().is_err());
}
