//! Clocks that stand in several columns, count from a date, or are one of several in a file.

use crate::file;
use recording::{Imported, Intake, SeriesSet, read_with, series};
use std::fmt::Write;

/// 2024-03-05T15:00:00Z.
const START_S: f64 = 1_709_650_800.0;
const ROWS: usize = 400;

fn value(row: usize) -> f64 {
    ((0.3 * row as f64).sin() * 1e5).round() / 1e5
}

fn table(header: &str, row: impl Fn(usize) -> String) -> String {
    let mut text = format!("{header}\n");
    (0..ROWS).for_each(|k| writeln!(text, "{}", row(k)).unwrap());
    text
}

fn read(name: &str, text: &str) -> SeriesSet {
    let path = file(&format!("parts_{name}.csv"), text);
    let imported = read_with(&path, &Intake::default()).unwrap_or_else(|error| panic!("{name}: {}", error.explain()));
    assert!(!matches!(imported, Imported::Segments(_)), "{name}: several recordings");
    series(imported).unwrap()
}

/// The channel has every row, from `start_s` on at `rate_hz`, each time right to 20 µs.
fn runs(set: &SeriesSet, channel: &str, start_s: f64, rate_hz: f64) {
    let names: Vec<&str> = set.recording.channels.iter().map(|of| of.name.as_str()).collect();
    let of = set.recording.channel_named(channel).unwrap_or_else(|| panic!("{channel}: {names:?} {:?}", set.notes));
    assert_eq!(of.value.len(), ROWS, "{channel}: {:?}", set.notes);
    for (k, (time_s, found)) in of.time_s.iter().zip(&of.value).enumerate() {
        let expected = start_s + k as f64 / rate_hz;
        let time_s = time_s + set.origin_s as f64;
        assert!((time_s - expected).abs() < 2e-5, "{channel}, row {k}: {time_s} is not {expected}: {:?}", set.notes);
        assert_eq!(*found, value(k), "{channel}, row {k}");
    }
}

fn noted(set: &SeriesSet, text: &str) {
    assert!(set.notes.iter().any(|note| note.contains(text)), "{text}: {:?}", set.notes);
}

/// Hours, minutes, seconds and their hundredths of a row, from a minute's last second on.
fn of_day(row: usize) -> (usize, usize, usize, usize) {
    let second = 15 * 3600 + 59 + row / 100;
    (second / 3600, second / 60 % 60, second % 60, row % 100)
}

#[test]
fn the_fields_of_a_calendar_are_one_clock() {
    type Row = fn(usize) -> String;
    let cases: [(&str, f64, Row); 6] = [
        ("year,month,day,hour,minute,second,w", START_S + 59.0, |k| {
            let (h, m, s, part) = of_day(k);
            format!("2024,3,5,{h},{m},{s}.{part:02}")
        }),
        ("Year,DOY,Hour,Min,Sec,w", START_S + 59.0, |k| {
            let (h, m, s, part) = of_day(k);
            format!("2024,65,{h},{m},{s}.{part:02}")
        }),
        ("utc_year,utc_month,utc_day,utc_hour,utc_min,utc_sec,utc_msec,w", START_S + 59.0, |k| {
            let (h, m, s, part) = of_day(k);
            format!("2024,3,5,{h},{m},{s},{}", 10 * part)
        }),
        ("hour,minute,second,w", 54_059.0, |k| {
            let (h, m, s, part) = of_day(k);
            format!("{h},{m},{s}.{part:02}")
        }),
        ("date,utc_time,w", START_S + 59.0, |k| {
            let (h, m, s, part) = of_day(k);
            format!("050324,{h:02}{m:02}{s:02}.{part:02}")
        }),
        ("UTC,w", 54_059.0, |k| {
            let (h, m, s, part) = of_day(k);
            format!("{h:02}{m:02}{s:02}.{part:02}")
        }),
    ];
    for (header, start_s, row) in cases {
        let set = read("calendar", &table(header, |k| format!("{},{}", row(k), value(k))));
        assert_eq!(set.recording.channels.len(), 1, "{header}: {:?}", set.notes);
        runs(&set, "w", start_s, 100.0);
    }
}

#[test]
fn hours_that_begin_again_have_passed_midnight() {
    let row = |k: usize| {
        let second = (86_398 + k / 100) % 86_400;
        format!("{},{},{}.{:02},{}", second / 3600, second / 60 % 60, second % 60, k % 100, value(k))
    };
    runs(&read("midnight", &table("hour,minute,second,w", row)), "w", 86_398.0, 100.0);
}

#[test]
fn the_week_of_gps_and_the_time_in_it_are_one_clock_across_weeks() {
    let gps = 315_964_800.0;
    let at = |k: usize| 604_798.0 + 0.01 * k as f64;
    let seconds = |k: usize| format!("{},{:.2},{}", 2303 + (at(k) / 604_800.0) as u32, at(k) % 604_800.0, value(k));
    let set = read("gps", &table("GPS_Week,GPS_TOW [s],w", seconds));
    runs(&set, "w", gps + 2303.0 * 604_800.0 + at(0), 100.0);
    noted(&set, "ahead of UTC");
    let whole = |k: usize| format!("2303,{},{}", 216_000_000 + 10 * k, value(k));
    for header in ["week,iTOW,w", "GWk,GMS,w", "GPSWeek,GPSTime_ms,w"] {
        runs(&read("gps_ms", &table(header, whole)), "w", gps + 2303.0 * 604_800.0 + 216_000.0, 100.0);
    }
    let old = |k: usize| format!("255,{},{}", 216_000_000 + 10 * k, value(k));
    noted(&read("gps_old", &table("week,iTOW,w", old)), "modulo 1024");
}

#[test]
fn a_header_may_name_the_date_from_which_its_numbers_count() {
    for (header, start_s, per_s) in [
        ("time [seconds since 2024-03-05 15:00:00],w", START_S, 1.0),
        ("time (seconds since 2024-03-05T15:00:00Z),w", START_S, 1.0),
        ("t [ms since 2024-03-05],w", START_S - 54_000.0, 1e3),
        ("time [hours since 2024-03-05 15:00:00 +01:00],w", START_S - 3600.0, 1.0 / 3600.0),
    ] {
        let set = read("since", &table(header, |k| format!("{:.9},{}", 0.01 * per_s * k as f64, value(k))));
        runs(&set, "w", start_s, 100.0);
        noted(&set, "time counts from 2024-03-05");
    }
    let set = read("j2000", &table("t [seconds since J2000],w", |k| format!("{:.2},{}", 0.01 * k as f64, value(k))));
    runs(&set, "w", 0.0, 100.0);
    noted(&set, "`J2000`, which is no date that is known");
}

#[test]
fn days_of_every_program_are_dates() {
    // whole days and their part apart: together an `f64` of them steps by 40 us
    let days_since = |zero: f64, k: usize| {
        let part = zero.fract() + 0.625 + k as f64 / 86_400.0;
        format!("{:.0}{}", zero.floor() + 19_787.0 + part.floor(), &format!("{:.12}", part.fract())[1..])
    };
    for (header, days) in [
        ("datenum,w", 719_529.0),
        ("Time,w", 25_569.0),
        ("MJD,w", 40_587.0),
        ("JD,w", 2_440_587.5),
        ("Sat.UTCModJulian,w", 10_587.5),
        ("time [days],w", 25_569.0),
    ] {
        let set = read("days", &table(header, |k| format!("{},{}", days_since(days, k), value(k))));
        runs(&set, "w", START_S, 1.0);
    }
}

#[test]
fn the_time_since_the_row_before_adds_up() {
    for (header, step, per_s) in [
        ("dt [s],w", "0.01", 1.0),
        ("delta_t (ms),w", "10", 1e3),
        ("dt_us,w", "10000", 1e6),
        ("interval [ms],w", "10", 1e3),
    ] {
        let text = table(header, |k| format!("{},{}", if k == 0 { "" } else { step }, value(k)));
        let set = read("steps", &text);
        runs(&set, "w", 0.0, 100.0);
        noted(&set, "the time since the row before");
        let uneven = table(header, |k| format!("{},{}", 0.01 * per_s * (1.0 + 0.1 * (k % 2) as f64), value(k)));
        let times = &read("uneven_steps", &uneven).recording.channels[0].time_s;
        assert!((times[ROWS - 1] - times[0] - 0.01 * (ROWS as f64 - 1.0) * 1.05).abs() < 1e-3, "{header}: {times:?}");
    }
}

#[test]
fn parts_of_a_second_are_as_many_as_begin_again_with_it() {
    for (parts, header) in [
        (65_536, "seconds,subseconds,w"),
        (1 << 32, "Seconds,Subsecs,w"),
        (1_000_000, "sec,frac,w"),
        (1000, "sec,msec,w"),
    ] {
        let per_row = parts / 50;
        let row = |k: usize| format!("{},{},{}", 1000 + k / 50, (k as u64 % 50) * per_row, value(k));
        let text = table(header, row);
        let set = read("parts", &text);
        let of = set.recording.channel_named("w").unwrap();
        assert!((of.rate_hz().unwrap() - 50.0).abs() < 0.1, "{header}: {:?} {:?}", of.rate_hz(), set.notes);
        assert_eq!(set.recording.channels.len(), 1, "{header}");
    }
}

#[test]
fn every_sensor_has_the_clock_that_stands_before_it() {
    let row = |k: usize| format!("{:.4},{},{:.4},{}", 0.01 * k as f64, value(k), 0.02 * k as f64 + 0.004, value(k));
    for header in [
        "gyro_t,gyro_z,accel_t,accel_x",
        "gyro.t,gyro_z,accel.t,accel_x",
        "t_gyro [s],gyro_z [rad/s],t_accel [s],accel_x [m/s^2]",
        "Time_gyro (s),gyro_z (rad/s),Time_accel (s),accel_x (m/s^2)",
    ] {
        let set = read("each", &table(header, row));
        runs(&set, "gyro_z", 0.0, 100.0);
        runs(&set, "accel_x", 0.004, 50.0);
        assert_eq!(set.recording.channels.len(), 2, "{header}: {:?}", set.notes);
    }
    // at the same rate, 4 ms later
    let late = |k: usize| format!("{:.4},{},{:.4},{}", 0.01 * k as f64, value(k), 0.01 * k as f64 + 0.004, value(k));
    let set = read("late", &table("t_gyro [s],gyro_z [rad/s],t_accel [s],accel_x [m/s^2]", late));
    runs(&set, "accel_x", 0.004, 100.0);
    let same = |k: usize| format!("{0:.2},{1},{0:.2},{1}", 0.01 * k as f64, value(k));
    let set = read("same", &table("X_Value,w,X_Value,a", same));
    runs(&set, "a", 0.0, 100.0);
    noted(&set, "repeats the times of the rows");
}

#[test]
fn another_clock_of_the_rows_is_noted_and_never_used_for_half_of_them() {
    let row = |k: usize| format!("{:.3},{},{}", START_S + 0.01 * k as f64, 123_456 + 10_000 * k, value(k));
    let set = read("another", &table("host_time,device_time_us,w", row));
    runs(&set, "w", START_S, 100.0);
    noted(&set, "`device_time_us` is another clock of the rows");
    let row = |k: usize| format!("{:.3},{1},{2},{1}", START_S + 0.01 * k as f64, value(k), 123_456 + 10_000 * k);
    let set = read("zero", &table("time,w,device_time_us,a", row));
    runs(&set, "a", START_S, 100.0);
    noted(&set, "`device_time_us` counts from another zero");
}

#[test]
fn a_column_that_is_called_a_unit_of_time_counts_it() {
    for (header, per_s) in
        [("millis,w", 1e3), ("micros,w", 1e6), ("Milliseconds,w", 1e3), ("seconds,w", 1.0), ("Clock:offsetTime,w", 1.0)]
    {
        let row = |k: usize| {
            let count = 0.01 * per_s * k as f64;
            if per_s > 1.0 { format!("{count:.0},{}", value(k)) } else { format!("{count:.2},{}", value(k)) }
        };
        runs(&read("unit", &table(header, row)), "w", 0.0, 100.0);
    }
}
