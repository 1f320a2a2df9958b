//! Stamps, clocks in two columns, preambles and headers of programs whose files were refused or
//! read in part. The intended readings were written down before any of the files was tried.

use crate::file;
use recording::{Intake, SeriesSet};

const ROWS: usize = 60;

/// `ROWS` rows, each `row(k, a, b)`.
fn rows(row: impl Fn(usize, f64, f64) -> String) -> String {
    (0..ROWS).map(|k| row(k, (0.3 * k as f64).sin() + 0.5, (0.2 * k as f64).cos()) + "\n").collect()
}

fn read(name: &str, text: &str) -> SeriesSet {
    let path = file(name, text);
    recording::read_with(&path, &Intake::default())
        .and_then(recording::series)
        .unwrap_or_else(|error| panic!("{name}: {}", error.explain()))
}

/// Every row is a sample of each channel, in its unit, at the rate.
fn holds(name: &str, text: &str, rate_hz: f64, channels: &[(&str, &str, f64)]) -> SeriesSet {
    let set = read(name, text);
    for (own, unit, first) in channels {
        let channel = set.recording.channel_named(own).unwrap_or_else(|| panic!("{name}: no {own}: {:?}", set.notes));
        assert_eq!((channel.unit.as_str(), channel.value.len()), (*unit, ROWS), "{name}: {own}: {:?}", set.notes);
        assert!((channel.value[0] / first - 1.0).abs() < 1e-9, "{name}: {own} begins with {}", channel.value[0]);
        let found = 1.0 / channel.interval_s().unwrap();
        assert!((found / rate_hz - 1.0).abs() < 1e-6, "{name}: {own} at {found} Hz");
    }
    set
}

const DEG: f64 = core::f64::consts::PI / 180.0;

#[test]
fn a_date_and_time_may_be_divided_by_points_and_dashes_throughout() {
    for (name, day) in [
        ("day of the year", "2021.063.05.06."),
        ("date", "2021.03.04.05.06."),
        ("dashes", "2021-03-04-05-06-"),
        ("file name", "2021-03-04_05-06-"),
        ("points of the time alone", "2021-03-04 05.06."),
    ] {
        let text = format!("time,a [deg/s],b [N.m]\n{}", rows(|k, a, b| format!("{day}{:02}.25,{a},{b}", k % 60)));
        let set = holds(&format!("divided_{name}.csv"), &text, 1.0, &[("a", "rad/s", 0.5 * DEG), ("b", "N*m", 1.0)]);
        let first_s = set.origin_s as f64 + set.recording.channels[0].time_s[0];
        assert_eq!(first_s, 1_614_834_360.25, "{name}");
    }
}

#[test]
fn milliseconds_behind_a_colon_may_be_without_zeros() {
    let stamped = |ms: usize| format!("12:03:{:02}:{}", 4 + ms / 1000, ms % 1000);
    let text = format!("Time,a [V]\n{}", rows(|k, a, _| format!("{},{a}", stamped(7 + 20 * k))));
    holds("unpadded.csv", &text, 50.0, &[("a", "V", 0.5)]);
    // two digits throughout may be frames or hundredths
    let text = format!("Time,a [V]\n{}", rows(|k, a, _| format!("12:03:{:02}:{:02},{a}", k / 25, k % 25)));
    let error = recording::read(&file("frames.csv", &text)).unwrap_err().explain();
    assert!(error.contains("no dates or times that are known"), "{error}");
}

#[test]
fn stamps_of_consoles_are_stamps() {
    let text =
        format!("\"@timestamp\",a,b\n{}", rows(|k, a, b| format!("\"Mar 5, 2024 @ 15:04:58.{:03}\",{a},{b}", 10 * k)));
    holds("kibana.csv", &text, 100.0, &[("a", "?", 0.5), ("b", "?", 1.0)]);
    let text = rows(|k, a, b| format!("15:04:58.{:03} -> a:{a},b:{b}", 10 * k));
    let mut intake = Intake::default();
    intake.read_map("said.toml", "[channels]\na = \"2\"\nb = \"3\"\n").unwrap();
    let plain = text.replace("a:", "").replace("b:", "");
    let set = recording::read_with(&file("monitor.txt", &plain), &intake).and_then(recording::series).unwrap();
    assert_eq!(set.recording.channels[0].value.len(), ROWS);
    assert!((set.recording.channels[1].interval_s().unwrap() - 0.01).abs() < 1e-9);
}

#[test]
fn a_second_and_its_parts_may_share_the_beginning_of_their_names() {
    let text = format!(
        "sim_time_sec,sim_time_nsec,a [V]\n{}",
        rows(|k, a, _| format!("{},{},{a}", 3 + k / 4, k % 4 * 250_000_000))
    );
    holds("shared_beginning.csv", &text, 4.0, &[("a", "V", 0.5)]);
    let text = format!(
        "OBT coarse [s],OBT fine [1/65536 s],a [V]\n{}",
        rows(|k, a, _| format!("{},{},{a}", 763_000_000 + k / 4, k % 4 * 16_384))
    );
    holds("coarse_and_fine.csv", &text, 4.0, &[("a", "V", 0.5)]);
    let text = format!(
        "Number,Date&Time,ms,a\nNO.,Time,ms,V\n{}",
        rows(|k, a, _| format!("{k},2024/03/05 15:04:{:02},{},{a}", 50 + k / 10, k % 10 * 100))
    );
    holds("stamp_and_ms.csv", &text, 10.0, &[("a", "V", 0.5)]);
    let text = format!("timeNano,a [V]\n{}", rows(|k, a, _| format!("{}e8,{a}", k)));
    holds("nano.csv", &text, 10.0, &[("a", "V", 0.5)]);
}

#[test]
fn units_stand_in_a_table_of_channels_or_behind_labels() {
    let table = "Root Name\tTitle\tAuthor\trig\t\tJK\n\nUntitled\nChannel\tDatatype\tUnit\tLength\twf_increment\n\
                 Torque\tDT_DOUBLE\tN·m\t60\t1.0E-2\nAngle\tDT_DOUBLE\tdeg\t60\t1.0E-2\n\nTorque\tAngle\n";
    let text = format!("{table}{}", rows(|_, a, b| format!("{a}\t{b}")));
    holds("properties.txt", &text, 100.0, &[("Torque", "N*m", 0.5), ("Angle", "rad", DEG)]);
    let text = format!(
        "type,csv\nunit,s,rad,A\nXLabel,Time\ntrace_values,time,theta,i_mot\n{}",
        rows(|k, a, b| format!(",{},{a},{b}", 0.001 * k as f64))
    );
    holds("labelled.csv", &text, 1000.0, &[("theta", "rad", 0.5), ("i_mot", "A", 1.0)]);
    let text = format!(
        "\"TraceName\",\"CH1\",\"CH2\"\n\"BlockSize\",60,60\n\"VUnit\",\"V\",\"A\"\n\"SampleRate\",1000,1000\n\
         \"HOffset\",0.0,0.0\n\n{}",
        rows(|_, a, b| format!(",{a},{b}"))
    );
    holds("trace_names.csv", &text, 1000.0, &[("CH1", "V", 0.5), ("CH2", "A", 1.0)]);
}

#[test]
fn a_unit_may_stand_in_the_middle_in_quotes_and_in_capitals() {
    let row = |k: usize, a: f64, b: f64| format!("{},{a},{b}", 0.05 * k as f64);
    let text = format!("\"Time (s) Run #1\",\"Angle (deg) Run #1\",\"Torque (FT-LB)\"\n{}", rows(row));
    let channels = [("Angle Run #1", "rad", 0.5 * DEG), ("Torque", "N*m", 1.355_817_948_331_400_4)];
    holds("middle.csv", &text, 20.0, &channels);
    let text = format!(
        "\"TIME\" \"angle\" \"torque\"\n\"sec\" \"deg\" \"newton-mm\"\n{}",
        rows(|k, a, b| row(k, a, b).replace(',', " "))
    );
    holds("quoted.tab", &text, 20.0, &[("angle", "rad", 0.5 * DEG), ("torque", "N*m", 1e-3)]);
}

#[test]
fn a_remark_above_names_is_not_the_names_where_one_of_these_is_a_unit_too() {
    let text = format!("# counter of the board\ntick,a [V]\n{}", rows(|k, a, _| format!("{k},{a}")));
    let mut intake = Intake::default();
    intake.read_map("said.toml", "time = \"tick:100Hz\"\n").unwrap();
    let set = recording::read_with(&file("tick.csv", &text), &intake).and_then(recording::series).unwrap();
    assert_eq!((set.recording.channels[0].name.as_str(), set.recording.channels[0].unit.as_str()), ("a", "V"));
}

#[test]
fn a_date_of_a_preamble_is_no_name_and_a_column_that_rises_by_the_interval_is_the_clock() {
    let above = "Start time,3/5/2024 3:04:58 PM\nSample rate (Hz),500\n";
    let text = format!("{above}Sample,Ch0 (V),Ch1 (V)\n{}", rows(|k, a, b| format!("{k},{a},{b}")));
    holds("preamble_date.csv", &text, 500.0, &[("Ch0", "V", 0.5), ("Ch1", "V", 1.0)]);
    let above = "Interval=\t0.001 s\nChannelTitle=\tForce\tAngle\nRange=\t10.000 V\t5.000 V\nUnitName=\tN\tdeg\n";
    let text = format!("{above}{}", rows(|k, a, b| format!("{:.4}\t{a}\t{b}", 0.001 * k as f64)));
    let set = holds("titles.txt", &text, 1000.0, &[("Force", "N", 0.5), ("Angle", "rad", DEG)]);
    assert!(set.notes.iter().any(|note| note.contains("column 1 holds the times")), "{:?}", set.notes);
}

#[test]
fn what_looks_like_a_stamp_a_unit_or_an_arrow_is_none() {
    let rows = || rows(|k, a, _| format!("{:.2},192.168.1.{k},2021.04.05.1,{a}", 0.01 * k as f64));
    let text = format!("time [s],ip,firmware,a -> b [V]\n{}", rows());
    holds("no_stamps.csv", &text, 100.0, &[("a -> b", "V", 0.5)]);
    let text = format!("time [s],ip,firmware,mode (A) speed\n{}", rows());
    holds("no_ampere.csv", &text, 100.0, &[("mode (A) speed", "?", 0.5)]);
}
