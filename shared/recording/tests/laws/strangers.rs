//! Files of instruments and programs whose exports were refused or read wrong: what each one means.

use crate::file;
use recording::{Intake, SeriesSet};
use std::fmt::Write;

const ROWS: usize = 300;
const DEG: f64 = core::f64::consts::PI / 180.0;

/// A channel's values in the file, to six digits.
fn a(k: usize) -> f64 {
    ((0.1 + 0.5 * (0.3 * k as f64).sin()) * 1e6).round() / 1e6
}

fn b(k: usize) -> f64 {
    ((0.2 * k as f64).cos() * 1e6).round() / 1e6
}

fn rows(row: impl Fn(usize) -> String) -> String {
    let mut text = String::new();
    (0..ROWS).for_each(|k| writeln!(text, "{}", row(k)).unwrap());
    text
}

fn read(name: &str, text: &str) -> Result<SeriesSet, String> {
    let path = file(&format!("stranger_{}.txt", name.replace([' ', '/'], "_")), text);
    recording::read_with(&path, &Intake::default()).and_then(recording::series).map_err(|error| error.explain())
}

/// A channel by name, unit, and what its value in row 7 is in SI.
type Channel<'a> = (&'a str, &'a str, f64);

/// Every row is a sample of each channel at the rate.
fn holds(name: &str, text: &str, rate_hz: f64, channels: &[Channel<'_>]) -> SeriesSet {
    let set = read(name, text).unwrap_or_else(|error| panic!("{name}: {error}"));
    for (own, unit, seventh) in channels {
        let names: Vec<&str> = set.recording.channels.iter().map(|of| of.name.as_str()).collect();
        let channel = set.recording.channel_named(own).unwrap_or_else(|| panic!("{name}: no {own} in {names:?}"));
        assert_eq!((channel.unit.as_str(), channel.value.len()), (*unit, ROWS), "{name}: {own}: {:?}", set.notes);
        assert!(
            (channel.value[7] - seventh).abs() < 1e-9 * seventh.abs().max(1.0),
            "{name}: {own} {}",
            channel.value[7]
        );
        let span_s = channel.time_s[ROWS - 1] - channel.time_s[0];
        assert!((span_s * rate_hz / (ROWS - 1) as f64 - 1.0).abs() < 1e-4, "{name}: {own} lasts {span_s} s");
        let found = channel.rate_hz().unwrap();
        assert!((found / rate_hz - 1.0).abs() < 1e-4, "{name}: {own} at {found} Hz: {:?}", set.notes);
    }
    set
}

fn refused(name: &str, text: &str, cure: &str) {
    let error = read(name, text).expect_err(name);
    assert!(error.contains(cure), "{name}: {error}");
}

/// Times of day from 15:04:58 on, `ms` apart.
fn of_day(k: usize, ms: usize) -> (usize, usize, usize, usize) {
    let all = (15 * 3600 + 4 * 60 + 58) * 1000 + k * ms;
    (all / 3_600_000, all / 60_000 % 60, all / 1000 % 60, all % 1000)
}

fn two(separator: &str) -> String {
    rows(|k| format!("{:.2}{separator}{}{separator}{}", 0.01 * k as f64, a(k), b(k)))
}

#[test]
fn a_temperature_with_its_unit_in_the_cell_is_converted_once() {
    let text = rows(|k| format!("{:.2},{:.3} °C,{:.3} °F", 0.01 * k as f64, 20.0 + k as f64, 68.0 + k as f64));
    let text = format!("time [s],bearing,motor\n{text}");
    holds("temperatures", &text, 100.0, &[("bearing", "K", 300.15), ("motor", "K", 293.15 + 7.0 / 1.8)]);
}

#[test]
fn a_whole_number_without_a_unit_is_no_interval_and_the_cure_says_it() {
    for (key, said) in [("dt,10", "row:10ms"), ("Interval: 10", "row:10ms"), ("Sampling period,250", "row:250ms")] {
        let text = format!("Device,X\n{key}\nTorque [Nm],Rate [rad/s]\n{}", rows(|k| format!("{},{}", a(k), b(k))));
        refused(key, &text, said);
    }
    let stated = [
        "Sample interval (ms),10",
        "dt,0.01",
        "dt = 10 ms",
        "XInc,1e-2",
        "Sample rate,100",
        "dt_ms,10",
        "Sample Rate,0.1,kHz",
        "dt,10,ms",
        "Scan rate: 100 scans/s",
        "Sampling rate: 100 samples per second",
        "Ts = 0.01",
        "Sampling: 100 Hz",
        "Sampling,10ms",
        "Periode: 10 ms",
        "Recording rate 100 Hz",
        "Output data rate: 100 Hz",
        "ODR=100Hz",
        "Rate: 100 Hz",
        "Samples per second: 100",
    ];
    for key in stated {
        let text = format!("Device,X\n{key}\nTorque [Nm],Rate [rad/s]\n{}", rows(|k| format!("{},{}", a(k), b(k))));
        holds(key, &text, 100.0, &[("Torque", "N*m", a(7)), ("Rate", "rad/s", b(7))]);
    }
}

#[test]
fn times_that_may_be_parts_of_a_day_are_asked_for_and_a_torque_is_in_no_nanometres() {
    let of_day = |k: usize| 0.628_45 + 0.01 * k as f64 / 86_400.0;
    let text = format!("Time,w\n{}", rows(|k| format!("{:.12},{}", of_day(k), a(k))));
    refused("parts of a day", &text, "--time-column Time:d");
    let text = format!("Time,w\n{}", rows(|k| format!("{:.12},{}", 0.5 + 1e-6 * k as f64, a(k))));
    holds("a megahertz", &text, 1e6, &[("w", "?", a(7))]);
    let text = format!("time [s],torque [nm],gap [nm]\n{}", two(","));
    holds("newton metres", &text, 100.0, &[("torque", "N*m", a(7)), ("gap", "m", 1e-9 * b(7))]);
}

#[test]
fn header_lines_may_begin_with_marks_that_are_remarks_elsewhere() {
    for (mark, separator) in [("! ", " "), ("; ", " "), ("// ", ","), ("-- ", ","), ("!", "\t")] {
        let text = format!("{mark}made by a logger\n{mark}t{separator}w{separator}u\n{}", two(separator));
        holds("marked", &text, 100.0, &[("w", "?", a(7)), ("u", "?", b(7))]);
    }
}

#[test]
fn a_table_with_a_channel_in_each_row_is_refused_with_the_way_to_turn_it() {
    let row = |name: &str, of: &dyn Fn(usize) -> f64| {
        format!("{name},{}\n", (0..60).map(|k| of(k).to_string()).collect::<Vec<_>>().join(","))
    };
    let text = row("time [s]", &|k| 0.01 * k as f64) + &row("torque [Nm]", &a) + &row("rate [rad/s]", &b);
    refused("turned", &text, "turn it");
}

#[test]
fn stamps_of_other_languages_and_with_exponents_are_read() {
    type Stamp = fn(usize) -> String;
    let cases: [(&str, f64, Stamp); 7] = [
        ("시간", 1.0, |k| format!("2024-03-05 오후 3:{:02}:{:02}", 4 + k / 60, k % 60)),
        ("时间", 1.0, |k| format!("2024/3/5 下午 3:{:02}:{:02}", 4 + k / 60, k % 60)),
        ("Date", 1.0, |k| format!("5 mars 2024 15:{:02}:{:02}", 4 + k / 60, k % 60)),
        ("Fecha", 1.0, |k| format!("05-ene-2024 15:{:02}:{:02}", 4 + k / 60, k % 60)),
        ("Datum", 1.0, |k| format!("5. Juni 2024 15:{:02}:{:02}", 4 + k / 60, k % 60)),
        ("Data", 1.0, |k| format!("5 giu 2024 15:{:02}:{:02}", 4 + k / 60, k % 60)),
        ("time", 100.0, |k| format!("1.7096510{:02}{:02}E+09", 10 + k / 100, k % 100)),
    ];
    for (name, rate_hz, stamp) in cases {
        let text = format!("{name};w [rad]\n{}", rows(|k| format!("{};{}", stamp(k), a(k))));
        holds(name, &text, rate_hz, &[("w", "rad", a(7))]);
    }
}

#[test]
fn numbers_within_a_preamble_and_lines_of_rates_and_dashes_are_no_rows() {
    let waveforms = "channel names:\t\ntorque\trate\t\nstart times:\t\n3/5/2024 15:04:58.0\t3/5/2024 15:04:58.0\t\n\
                     dt:\t\n0.010000\t0.010000\t\ndata:\t\n";
    let text = format!("{waveforms}{}", rows(|k| format!("{}\t{}\t", a(k), b(k))));
    holds("waveforms", &text, 100.0, &[("torque", "?", a(7)), ("rate", "?", b(7))]);
    let rates = "Drehmoment\tWinkel\tZeit\nNm\t°\ts\n100 Hz\t100 Hz\t100 Hz\n";
    let text = format!("{rates}{}", rows(|k| format!("{}\t{}\t{:.2}", a(k), b(k), 0.01 * k as f64)));
    holds("rates", &text, 100.0, &[("Drehmoment", "N*m", a(7)), ("Winkel", "rad", b(7) * DEG)]);
    let results = "Results Table 1\n,Maximum Load (N)\n1,123.4\n\nTime,Extension,Load\n(s),(mm),(kN)\n\n";
    let text = format!("{results}{}", rows(|k| format!("\"{:.4}\",\"{}\",\"{}\"", 0.01 * k as f64, a(k), b(k))));
    holds("results", &text, 100.0, &[("Extension", "m", 1e-3 * a(7)), ("Load", "N", 1e3 * b(7))]);
    // a remark behind the first row
    let row = |k: usize| format!("{:.2},{}{}", 0.01 * k as f64, a(k), if k == 0 { "\nEVENT start" } else { "" });
    let text = format!("time [s],torque [Nm]\n{}", rows(row));
    holds("event", &text, 100.0, &[("torque", "N*m", a(7))]);
    let above = "                                      05 Mar 2024 15:04:58\nSatellite-Sat1:  Position\n\n\
                      Time (UTCG)              x (km)           y (km)\n\
                 ------------------------    -------------    -------------\n";
    let stamp = |k: usize| {
        let (h, m, s, ms) = of_day(k, 1000);
        format!(" 5 Mar 2024 {h}:{m:02}:{s:02}.{ms:03}      {:12.6}    {:13.6}", a(k), b(k))
    };
    holds("report", &format!("{above}{}", rows(stamp)), 1.0, &[("x", "m", 1e3 * a(7)), ("y", "m", 1e3 * b(7))]);
}

#[test]
fn a_label_before_the_names_that_rows_do_not_have_shifts_no_column() {
    let above = "*CREATOR;MSR 6\n*STARTTIME;05.03.2024;15:04:58\n*TIMEDELTA;0.01;s\n*CHANNEL;TIME;ACC x;ACC y\n\
                 *UNIT;SEC;G;m/s2\n*DATA\n";
    holds(
        "msr",
        &format!("{above}{}", two(";")),
        100.0,
        &[("ACC x", "m/s^2", 9.80665 * a(7)), ("ACC y", "m/s^2", b(7))],
    );
    let text = format!("Channel name,time,torque,rate\nUnit,s,Nm,deg/s\n{}", two(","));
    holds("labels", &text, 100.0, &[("torque", "N*m", a(7)), ("rate", "rad/s", b(7) * DEG)]);
}

#[test]
fn durations_with_their_units_are_times() {
    type Stamp = fn(usize) -> String;
    let cases: [(&str, f64, Stamp); 6] = [
        ("iso", 100.0, |k| format!("PT{:.2}S", 0.01 * k as f64)),
        ("iso parts", 1.0, |k| format!("P0DT0H{}M{}.5S", k / 60, k % 60)),
        ("parts", 1.0, |k| format!("{}m{}.5s", k / 60, k % 60)),
        ("days", 1.0 / 60.0, |k| format!("{}d {:02}:{:02}:00", 1 + k / 1440, k / 60 % 24, k % 60)),
        ("words", 100.0, |k| format!("{} sec", k as f64 / 100.0)),
        ("long", 1.0 / 60.0, |k| format!("{}:{:02}:00.000", 30 + k / 60, k % 60)),
    ];
    for (name, rate_hz, stamp) in cases {
        let text = format!("elapsed time,torque [Nm]\n{}", rows(|k| format!("{},{}", stamp(k), a(k))));
        holds(name, &text, rate_hz, &[("torque", "N*m", a(7))]);
    }
}

#[test]
fn a_first_column_called_by_a_unit_of_time_alone_is_the_clock_where_it_rises() {
    for (name, of_hour) in [("min", 60.0), ("Minutes", 60.0), ("h", 1.0), ("hours", 1.0)] {
        let text = format!("{name},torque [Nm]\n{}", rows(|k| format!("{:.9},{}", k as f64 / 360.0 * of_hour, a(k))));
        holds(name, &text, 0.1, &[("torque", "N*m", a(7))]);
    }
    let text = format!("torque [Nm],index [ms]\n{}", rows(|k| format!("{},{}", a(k), 10 * k)));
    holds("index", &text, 100.0, &[("torque", "N*m", a(7))]);
    refused("a minimum", &format!("min,max\n{}", rows(|k| format!("{},{}", a(k), b(k)))), "--time-column");
}

#[test]
fn ticks_of_windows_and_hours_minutes_and_seconds_in_one_number_are_times() {
    for (name, first) in [("timestamp", 133_541_246_980_000_000_u64), ("Ticks", 638_452_478_980_000_000)] {
        let text = format!("{name},torque [Nm]\n{}", rows(|k| format!("{},{}", first + 100_000 * k as u64, a(k))));
        let set = holds(name, &text, 100.0, &[("torque", "N*m", a(7))]);
        assert_eq!(set.origin_s as f64 + set.recording.channels[0].time_s[0], 1_709_651_098.0, "{name}");
    }
    let packed = |k: usize| {
        let (h, m, s, ms) = of_day(k, 50);
        format!("{h:02}{m:02}{s:02}.{:02} {} {}", ms / 10, a(k), b(k))
    };
    holds(
        "packed",
        &format!("time torque rate\n{}", rows(packed)),
        20.0,
        &[("torque", "?", a(7)), ("rate", "?", b(7))],
    );
    // seconds of the same size, which go on at 60
    let text = format!("time,torque\n{}", rows(|k| format!("{:.2},{}", 150_458.0 + 0.05 * k as f64, a(k))));
    holds("seconds", &text, 20.0, &[("torque", "?", a(7))]);
}

#[test]
fn of_two_rows_at_a_jump_the_one_behind_it_is_taken_and_two_samples_under_one_stamp_stay_an_error() {
    let valve = |k: usize| u8::from(k >= 100);
    let row = |k: usize| format!("{:.2},{},{}", 0.01 * k as f64, a(k), valve(k));
    let at_jump = |k: usize| if k == 100 { format!("{:.2},{},0\n{}", 1.0, a(k), row(k)) } else { row(k) };
    let set = holds("jump", &format!("time,phi,valve\n{}", rows(at_jump)), 100.0, &[("phi", "?", a(7))]);
    let valve = &set.recording.channel_named("valve").unwrap().value;
    assert_eq!((valve.len(), valve[99], valve[100]), (ROWS, 0.0, 1.0));
    assert!(
        set.notes.iter().any(|note| note.contains("1 time(s) stand twice") && note.contains("line 103")),
        "{:?}",
        set.notes
    );
    let conflict = |k: usize| if k == 100 { format!("1.00,{},0\n{}", a(k) + 0.01, row(k)) } else { row(k) };
    refused("conflict", &format!("time,phi,valve\n{}", rows(conflict)), "stands twice");
}

#[test]
fn names_and_units_are_divided_by_slashes_where_the_clock_is() {
    let text = format!("mode\ttime/s\tI/mA\tEwe/V\t\n{}", rows(|k| format!("1\t{k}.0E+00\t{}\t{}\t", a(k), b(k))));
    holds("slashes", &text, 1.0, &[("I", "A", 1e-3 * a(7)), ("Ewe", "V", b(7))]);
    let text = format!("Time / s;Torque / Nm;Rate / (rad/s)\n{}", two(";"));
    holds("blanks", &text, 100.0, &[("Torque", "N*m", a(7)), ("Rate", "rad/s", b(7))]);
    let text = format!("in s,C1 in V,C2 in A\n{}", two(","));
    holds("in words", &text, 100.0, &[("C1", "V", a(7)), ("C2", "A", b(7))]);
    let text = format!("time,acc,gyro\nms,m/(s^2),deg/s\n{}", rows(|k| format!("{},{},{}", 10 * k, a(k), b(k))));
    holds("brackets", &text, 100.0, &[("acc", "m/s^2", a(7)), ("gyro", "rad/s", b(7) * DEG)]);
    let text = format!("time [s],a [V DC],b [A rms]\n{}", two(","));
    holds("of a meter", &text, 100.0, &[("a", "V", a(7)), ("b", "A", b(7))]);
}

#[test]
fn a_clock_that_stands_still_gives_way_to_one_that_goes() {
    let stamp = |k: usize| {
        let (h, m, s, ms) = of_day(k, 100);
        format!(
            "05-Mar-2024 15:04:58,05-Mar-2024 {h}:{m:02}:{s:02}.{ms:03},{},{}",
            a(k),
            if k == 3 { "-".into() } else { a(k).to_string() }
        )
    };
    holds(
        "still",
        &format!("GPS Time,Device Time,speed (km/h),load\n{}", rows(stamp)),
        10.0,
        &[("speed", "m/s", a(7) / 3.6)],
    );
}

#[test]
fn markers_and_bodies_have_the_names_and_units_of_the_lines_above() {
    let keys = |what: &str| {
        format!("NO_OF_FRAMES\t300\nNO_OF_CAMERAS\t8\nFREQUENCY\t100\nTIME_STAMP\t2024-03-05, 15:04:58\n{what}")
    };
    let markers = |k: usize| format!("{}\t{}\t1.5\t{}\t{}\t3.5", a(k), b(k), 2.0 * a(k), 2.0 * b(k));
    let counted = |k: usize| format!("{}\t{:.5}\t{}", k + 1, 0.01 * k as f64, markers(k));
    let of_markers: [Channel<'_>; 2] = [("base.x", "m", 1e-3 * a(7)), ("tip.y", "m", 2e-3 * b(7))];
    let names = keys("DATA_INCLUDED\t3D\nMARKER_NAMES\tbase\ttip\nTRAJECTORY_TYPES\tMeasured\tMeasured\n");
    holds("3d", &format!("{names}{}", rows(markers)), 100.0, &of_markers);
    let titles = "Frame\tTime\tbase X\tbase Y\tbase Z\ttip X\ttip Y\ttip Z\n";
    holds("3d with times", &format!("{names}{titles}{}", rows(counted)), 100.0, &of_markers);
    let body = |k: usize| format!("{}\t0.2\t1\t0\t0\t0\t1\t0\t0\t0\t1", markers(k));
    let titles =
        "X\tY\tZ\tRoll\tPitch\tYaw\tResidual\tRot[0]\tRot[1]\tRot[2]\tRot[3]\tRot[4]\tRot[5]\tRot[6]\tRot[7]\tRot[8]\n";
    let text = format!("{}{titles}{}", keys("DATA_INCLUDED\t6D\nBODY_NAMES\tsled\n"), rows(body));
    holds(
        "6d",
        &text,
        100.0,
        &[("sled.x", "m", 1e-3 * a(7)), ("sled.pitch", "rad", 2.0 * b(7) * DEG), ("sled.rotation[4]", "-", 1.0)],
    );
    let trc = "PathFileType\t4\t(X/Y/Z)\tswing.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n100\t100\t300\t2\tmm\n\
               Frame#\tTime\tbase\t\t\ttip\t\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\t\n\n";
    holds("trc", &format!("{trc}{}", rows(counted)), 100.0, &of_markers);
}

#[test]
fn groups_of_channels_have_the_times_below_their_keys() {
    let lines = [
        "Name\tscope",
        "Starttime of export\t132959733843760000\tMontag, 2. Mai 2022\t15:56:24.376",
        "",
        "Name\ttorque\trate\tName\tangle",
        "Data-Type\tREAL64\tREAL64\tData-Type\tREAL64",
        "SampleTime[ms]\t1\t1\tSampleTime[ms]\t5",
        "NetID\t5.1.2.3.1.1\t5.1.2.3.1.1\tNetID\t5.1.2.3.1.1",
        "Offset\t0\t0\tOffset\t0",
        "BitMask\t0xffffffffffffffff\t0xffffffffffffffff\tBitMask\t0xffffffffffffffff",
        "Unit\tNm (Torque)\t(None)\tUnit\trad (Angle)",
        "",
    ];
    let slow = |k: usize| if k < 60 { format!("{}\t{}", 5 * k, 2.0 * a(k)) } else { "\t".into() };
    let text = format!("{}\n{}", lines.join("\n"), rows(|k| format!("{k}\t{}\t{}\t{}", a(k), b(k), slow(k))));
    for (name, text) in
        [("tabs", text.clone()), ("decimal commas", text.replace('.', ",")), ("semicolons", text.replace('\t', ";"))]
    {
        let set = holds(name, &text, 1000.0, &[("torque", "N*m", a(7)), ("rate", "?", b(7))]);
        let angle = set.recording.channel_named("angle").unwrap();
        assert_eq!((angle.unit.as_str(), angle.value.len(), angle.value[7]), ("rad", 60, 2.0 * a(7)), "{name}");
        assert!((angle.rate_hz().unwrap() - 200.0).abs() < 1e-6, "{name}: {:?}", set.notes);
    }
}
