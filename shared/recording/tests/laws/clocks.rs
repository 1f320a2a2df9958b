//! Clocks: what the stamps of a file say is used, an outage is a gap and nothing else.

use crate::file;
use recording::{Imported, Intake, SeriesSet, TimeColumn, read, read_with, series};
use std::fmt::Write;
use std::ops::Range;

/// Stamps of a day; of a second and millisecond.
type OfDay = fn(usize) -> String;
type OfSecond = fn(usize, usize) -> String;

/// An outage.
fn lost_rows(first: usize, end: usize) -> Range<usize> {
    first..end
}

/// Times and one channel, a row each.
fn rows(count: usize, stamp: impl Fn(usize) -> String, lost: &[Range<usize>]) -> String {
    let mut text = String::new();
    for row in (0..count).filter(|row| !lost.iter().any(|range| range.contains(row))) {
        writeln!(text, "{},{:.5}", stamp(row), (0.3 * row as f64).sin()).unwrap();
    }
    text
}

fn set_of(imported: Imported) -> SeriesSet {
    assert!(!matches!(imported, Imported::Segments(_)), "several recordings");
    series(imported).unwrap()
}

fn of(name: &str, header: &str, rows: &str) -> SeriesSet {
    let path = file(&format!("clocks_{name}.csv"), &format!("{header}\n{rows}"));
    set_of(read(&path).unwrap_or_else(|error| panic!("{name}: {error:?}")))
}

/// Of a clock that the user names.
fn named(name: &str, header: &str, rows: &str, said: &str) -> SeriesSet {
    let path = file(&format!("clocks_{name}.csv"), &format!("{header}\n{rows}"));
    let intake = Intake { time_column: Some(TimeColumn::parse(said).unwrap()), ..Intake::default() };
    set_of(read_with(&path, &intake).unwrap_or_else(|error| panic!("{name}: {error:?}")))
}

fn times(set: &SeriesSet) -> &[f64] {
    &set.recording.channels[0].time_s
}

fn noted(set: &SeriesSet, text: &str) -> bool {
    set.notes.iter().any(|note| note.contains(text))
}

/// Whether the rows follow each other every 10 ms, each to 20 µs and all to that.
fn assert_even(set: &SeriesSet, count: usize, what: &str) {
    let times = times(set);
    assert_eq!(times.len(), count, "{what}: {:?}", set.notes);
    for (row, time) in times.iter().enumerate() {
        assert!((time - times[0] - 0.01 * row as f64).abs() < 2e-5, "{what}, row {row}: {time} {:?}", set.notes);
    }
}

/// The rate and the steps above one and a half of its intervals.
fn rate_and_gaps(set: &SeriesSet) -> (f64, Vec<f64>) {
    let rate = set.recording.channels[0].rate_hz().unwrap();
    let steps = times(set).windows(2).map(|pair| pair[1] - pair[0]);
    (rate, steps.filter(|step| *step > 1.5 / rate).collect())
}

#[test]
fn packets_that_were_lost_are_gaps_at_the_rate_of_the_packets() {
    let ticks = |row: usize| format!("{:.4}", 0.1 * (row / 10) as f64 + 1e-4 * (row % 10) as f64);
    let same = |row: usize| format!("{:.3}", 0.05 * (row / 5) as f64 + 0.05);
    let lost_each: [&[Range<usize>]; 4] =
        [&[lost_rows(500, 510)], &[lost_rows(400, 500)], &[lost_rows(500, 700)], &[200..210, 500..510, 700..710]];
    for lost in lost_each {
        for (kind, text) in [("ticks", rows(1000, ticks, lost)), ("same", rows(1000, same, lost))] {
            let set = of(&format!("packets_{kind}"), "t [s],gyro_z [deg/s]", &text);
            let (rate, gaps) = rate_and_gaps(&set);
            assert!((rate - 100.0).abs() < 0.1, "{lost:?} {kind}: {rate} {:?}", set.notes);
            assert_eq!(gaps.len(), lost.len(), "{lost:?} {kind}");
            for (gap, lost) in gaps.iter().zip(lost) {
                assert!((gap - 0.01 * (lost.len() + 1) as f64).abs() < 0.011, "{lost:?} {kind}: {gap}");
            }
        }
    }
}

#[test]
fn rows_lost_under_coarse_stamps_are_gaps() {
    let tenth = |row: usize| format!("{:.2}", (row / 3) as f64 / 100.0);
    for lost in [500..506, 500..530] {
        let set = of("coarse", "t [s],gyro_z [deg/s]", &rows(1000, tenth, std::slice::from_ref(&lost)));
        let (rate, gaps) = rate_and_gaps(&set);
        assert!((rate - 300.0).abs() < 0.5 && gaps.len() == 1, "{lost:?}: {rate} {gaps:?} {:?}", set.notes);
        assert!((gaps[0] - (lost.len() + 1) as f64 / 300.0).abs() < 4e-3, "{lost:?} {gaps:?}");
    }
    let second = |row: usize| format!("2024-03-05 15:00:{:02}", row / 100);
    let unix = |row: usize| format!("{}", 1_709_650_798 + row / 100);
    for (lost, unix) in
        [(430..560, rows(1000, unix, &[lost_rows(400, 500)])), (440..470, rows(1000, second, &[lost_rows(440, 470)]))]
    {
        let header = if lost.len() == 30 { "timestamp,gyro_z [deg/s]" } else { "time,gyro_z [deg/s]" };
        let (rate, gaps) = rate_and_gaps(&of("whole", header, &unix));
        assert!((rate - 100.0).abs() < 1.0 && gaps.len() == 1, "{lost:?}: {rate} {gaps:?}");
    }
    let (rate, gaps) =
        rate_and_gaps(&of("whole_gap", "timestamp,gyro_z [deg/s]", &rows(1000, second, &[lost_rows(430, 560)])));
    // rows are missing in two of the seconds; where within them is not known
    let missing: f64 = gaps.iter().map(|gap| gap * rate - 1.0).sum();
    assert!((rate - 100.0).abs() < 1.0 && (missing - 130.0).abs() < 2.0, "{rate} {gaps:?}");
}

#[test]
fn a_gap_of_ten_years_is_a_gap() {
    let stamp = |row: usize| format!("{:.2}", 0.01 * row as f64 + if row < 500 { 0.0 } else { 3e8 });
    let (rate, gaps) = rate_and_gaps(&of("ten_years", "t [s],gyro_z [deg/s]", &rows(1000, stamp, &[])));
    assert!((rate - 100.0).abs() < 0.01 && gaps.len() == 1, "{rate} {gaps:?}");
}

/// Date, hour, minute, second and milliseconds of a row, 5 s before a midnight.
fn around_midnight(row: usize) -> (usize, String) {
    let ms = (86_395_000 + 10 * row) % 86_400_000;
    let time = format!("{:02}:{:02}:{:02}.{:03}", ms / 3_600_000, ms / 60_000 % 60, ms / 1000 % 60, ms % 1000);
    (usize::from(row >= 500), time)
}

#[test]
fn the_order_of_day_and_month_is_that_which_makes_the_times_go_on() {
    let cases: [(&str, &str, OfDay); 5] = [
        ("03/05/2024 ", "month/day/year", |day| format!("03/{:02}/2024 ", 5 + day)),
        ("05/03/2024 ", "day/month/year", |day| format!("{:02}/03/2024 ", 5 + day)),
        ("05/03/24 ", "day/month/year", |day| format!("{:02}/03/24 ", 5 + day)),
        ("24.03.05 ", "year/month/day", |day| format!("24.03.{:02} ", 5 + day)),
        ("05.03.24 ", "day/month/year", |day| format!("{:02}.03.24 ", 5 + day)),
    ];
    for (what, order, date) in cases {
        let joined = |row: usize| {
            let (day, time) = around_midnight(row);
            date(day) + &time
        };
        let set = of("order", "Timestamp,gyro_z [deg/s]", &rows(1000, joined, &[]));
        assert_even(&set, 1000, what);
        assert!(noted(&set, order) && noted(&set, "time counts from 2024-03-05"), "{what}: {:?}", set.notes);
        let apart = |row: usize| joined(row).replace(' ', ",");
        assert_even(&of("order_apart", "Date,Time,gyro_z [deg/s]", &rows(1000, apart, &[])), 1000, what);
    }
    let one_day = |row: usize| format!("03/05/2024 12:00:{:02}.{:03}", row / 100, row % 100 * 10);
    let set = of("order_open", "Timestamp,gyro_z [deg/s]", &rows(1000, one_day, &[]));
    assert_even(&set, 1000, "one day");
    assert!(noted(&set, "day/month/year; month/day/year fits as well"), "{:?}", set.notes);
}

#[test]
fn a_zone_is_applied_wherever_it_stands() {
    let summer = |row: usize| {
        let (day, time) = around_midnight(row);
        if day == 0 {
            format!("2024-03-31T01{}+01:00", &time[2..])
        } else {
            format!("2024-03-31T03{}+02:00", &time[2..])
        }
    };
    assert_even(&of("summer", "timestamp,gyro_z [deg/s]", &rows(1000, summer, &[])), 1000, "+01:00 to +02:00");
    for (zone, hour) in [("+05:30", 20.5), (" UTC", 26.0), (" CET", 25.0), (" +0100", 25.0), ("Z", 26.0)] {
        let stamp = |row: usize| format!("2024-03-06 02:00:{:02}.{:03}{zone}", row / 100, row % 100 * 10);
        let set = of("zone", "timestamp,gyro_z [deg/s]", &rows(1000, stamp, &[]));
        assert_even(&set, 1000, zone);
        let day = if hour < 24.0 { "2024-03-05" } else { "2024-03-06" };
        let day = if hour < 25.5 && hour > 24.0 { "2024-03-06" } else { day };
        assert!(noted(&set, &format!("time counts from {day}")), "{zone}: {:?}", set.notes);
        assert!((times(&set)[0] - (hour * 3600.0_f64).rem_euclid(86_400.0)).abs() < 1e-6, "{zone}");
    }
}

#[test]
fn stamps_of_the_c_library_and_of_ordinal_days_are_read() {
    let second = |row: usize| (row / 100, row % 100 * 10);
    let cases: [(&str, OfSecond); 8] = [
        ("c", |s, ms| format!("Tue Mar  5 15:00:{s:02}.{ms:03} 2024")),
        ("quoted", |s, ms| format!("\"Mar 5, 2024, 03:00:{s:02}.{ms:03} PM\"")),
        ("ordinal", |s, ms| format!("2024-065T15:00:{s:02}.{ms:03}")),
        ("colons", |s, ms| format!("2024:065:15:00:{s:02}.{ms:03}")),
        ("milliseconds", |s, ms| format!("15:00:{s:02}:{ms:03}")),
        ("days", |s, ms| format!("0 days 00:00:{s:02}.{ms:03}000")),
        ("digits", |s, ms| format!("202403051500{s:02}{ms:03}")),
        ("twelve", |s, ms| format!("03/25/2024 3:00:{s:02}.{ms:03} PM")),
    ];
    for (what, stamp) in cases {
        let text = rows(1000, |row| stamp(second(row).0, second(row).1), &[]);
        assert_even(&of(&format!("text_{what}"), "time,gyro_z [deg/s]", &text), 1000, what);
    }
}

#[test]
fn a_leap_second_is_a_second() {
    let stamp = |row: usize| match row / 100 {
        second @ 0..3 => format!("2016-12-31T23:59:{}.{:03}Z", 57 + second, row % 100 * 10),
        3 => format!("2016-12-31T23:59:60.{:03}Z", row % 100 * 10),
        second => format!("2017-01-01T00:00:{:02}.{:03}Z", second - 4, row % 100 * 10),
    };
    let set = of("leap", "timestamp,gyro_z [deg/s]", &rows(1000, stamp, &[]));
    assert_even(&set, 1000, "leap second");
    assert!(noted(&set, "begins again"), "{:?}", set.notes);
}

#[test]
fn days_of_a_spreadsheet_are_told_by_their_size() {
    let excel = |row: usize| format!("{:.12}", 45_356.624_976_851_85 + 0.01 * row as f64 / 86_400.0);
    let set = of("excel", "Time,gyro_z [deg/s]", &rows(1000, excel, &[]));
    assert_even(&set, 1000, "days");
    assert!(noted(&set, "days since 1899-12-30") && set.origin_s == 1_709_596_800, "{} {:?}", set.origin_s, set.notes);
}

#[test]
fn seconds_and_their_parts_in_two_columns_are_one_time() {
    for (header, parts) in [("sec,nanosec", 1_000_000_000), ("tv_sec,tv_usec", 1_000_000)] {
        let stamp = |row: usize| format!("{},{}", 1_700_000_000 + row / 100, row % 100 * (parts / 100));
        let set = of("parts", &format!("{header},gyro_z [deg/s]"), &rows(1000, stamp, &[]));
        assert_even(&set, 1000, header);
        assert_eq!(set.recording.channels.len(), 1, "{header}");
    }
}

#[test]
fn a_counter_that_begins_again_is_counted_on() {
    let micros = |row: usize| format!("{}", (4_289_967_296_u64 + 10_000 * row as u64) % (1 << 32));
    let millis = |row: usize| format!("{}", (60_000 + 10 * row) % (1 << 16));
    let week = |row: usize| format!("{:.2}", (604_795.0 + 0.01 * row as f64) % 604_800.0);
    let hour = |row: usize| around_midnight(row).1[3..].to_owned();
    let twelve = |row: usize| {
        let (day, time) = around_midnight(row);
        format!("{}{}", if day == 0 { "12" } else { "01" }, &time[2..])
    };
    let cases: [(&str, String); 5] = [
        ("t_us", rows(1000, micros, &[])),
        ("t_ms", rows(1000, millis, &[])),
        ("tow_s", rows(1000, week, &[])),
        ("time", rows(1000, hour, &[])),
        ("time", rows(1000, twelve, &[])),
    ];
    for (clock, text) in cases {
        let set = if clock == "tow_s" {
            named("week", "tow_s,gyro_z [deg/s]", &text, "tow_s:s")
        } else {
            of("again", &format!("{clock},gyro_z [deg/s]"), &text)
        };
        assert_even(&set, 1000, clock);
        assert!(noted(&set, "begins again"), "{clock}: {:?}", set.notes);
    }
    let byte = |row: usize| format!("{}", row % 256);
    let set = named("byte", "counter,gyro_z [deg/s]", &rows(1000, byte, &[]), "counter:100Hz");
    assert_even(&set, 1000, "byte");
    let set = named("byte_lost", "counter,gyro_z [deg/s]", &rows(1000, byte, &[lost_rows(300, 350)]), "counter:100Hz");
    assert_eq!(rate_and_gaps(&set).1.len(), 1);
}

#[test]
fn a_recording_that_starts_again_where_it_began_is_another_one() {
    let text = rows(720, |row| format!("{}", row % 360 * 10), &[]);
    let path = file("clocks_hours.csv", &format!("t [s],gyro_z [deg/s]\n{text}"));
    assert!(matches!(read(&path).unwrap(), Imported::Segments(segments) if segments.parts.len() == 2));
}

#[test]
fn a_counter_in_digits_to_base_16_and_rows_with_the_newest_first_are_read() {
    let set = of("hex", "tick_us,gyro_z [deg/s]", &rows(1000, |row| format!("0x{:08X}", row * 10_000), &[]));
    assert_even(&set, 1000, "hex");
    let newest = |row: usize| format!("{:.3}", 9.99 - 0.01 * row as f64);
    let set = of("newest", "t [s],gyro_z [deg/s]", &rows(1000, newest, &[]));
    assert_even(&set, 1000, "newest first");
    let last = set.recording.channels[0].value.last().copied().unwrap();
    assert!(noted(&set, "newest row stands first") && last.abs() < 1e-9, "{last} {:?}", set.notes);
}

#[test]
fn a_second_clock_is_that_of_the_channels_behind_it() {
    let mut text = String::from("Time1 [s],gyro_z [deg/s],Time2 [s],torque [Nm]\n");
    for row in 0..1000 {
        let k = row as f64;
        writeln!(text, "{:.3},{:.4},{:.3},{:.4}", 0.01 * k, (0.3 * k).sin(), 0.02 * k, (0.1 * k).cos()).unwrap();
    }
    let set = set_of(read(&file("clocks_second.csv", &text)).unwrap());
    let names: Vec<&str> = set.recording.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["gyro_z", "torque"]);
    let rates = set.recording.channels.iter().map(|channel| channel.rate_hz().unwrap().round()).collect::<Vec<_>>();
    assert_eq!(rates, [100.0, 50.0]);
    assert!(noted(&set, "`Time2` is the clock of torque"), "{:?}", set.notes);
}

#[test]
fn the_hint_names_a_column_that_can_be_the_clock() {
    let hint = |text: &str| format!("{:?}", read(&file("clocks_hint.csv", text)).unwrap_err());
    let words = hint("time,gyro_z\nthree o'clock,1.5\nfour o'clock,2.5\nfive o'clock,3.5\n");
    assert!(words.contains("`time` should be the clock") && !words.contains("gyro_z:s"), "{words}");
    let nameless = hint("0.1,1.5\n0.2,2.5\n0.3,3.5\n");
    assert!(!nameless.contains("--time-column :s"), "{nameless}");
}
