//! Headers that are divided otherwise than their rows, rows with one sample each, numbers as
//! spreadsheets format them: what each file means, in SI.

use crate::file;
use recording::{Assignment, Intake, SeriesSet, TimeColumn};

const ROWS: usize = 60;

/// Rows at 100 Hz of a rate \[rad/s\] and a torque \[N m\].
fn rows(row: impl Fn(usize, f64, f64, f64) -> String) -> String {
    (0..ROWS).map(|k| row(k, 0.01 * k as f64, rate(k), torque(k)) + "\n").collect()
}

fn rate(k: usize) -> f64 {
    (1.0 + 0.1 * (k % 7) as f64) * 0.5
}

fn torque(k: usize) -> f64 {
    2.0 - (k % 3) as f64
}

fn read(name: &str, text: &str, intake: &Intake) -> Result<SeriesSet, String> {
    let path = file(&format!("shape_{}.csv", name.replace(' ', "_")), text);
    recording::read_with(&path, intake).and_then(recording::series).map_err(|error| error.explain())
}

/// The file holds the rate and the torque under these names, in these units, times these factors.
fn holds(name: &str, text: &str, rate_as: (&str, &str, f64), torque_as: (&str, &str, f64)) {
    let set = read(name, text, &Intake::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
    let names: Vec<&str> = set.recording.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, [rate_as.0, torque_as.0], "{name}: {:?}", set.notes);
    for ((own, unit, factor), value) in [(rate_as, rate as fn(usize) -> f64), (torque_as, torque)] {
        let channel = set.recording.channel_named(own).unwrap();
        assert_eq!(channel.unit, unit, "{name}: {own}");
        assert_eq!(channel.value.len(), ROWS, "{name}: {own}");
        for (k, (time_s, found)) in channel.time_s.iter().zip(&channel.value).enumerate() {
            assert!((time_s - channel.time_s[0] - 0.01 * k as f64).abs() < 1e-9, "{name}: {own} at {time_s} s");
            assert!((found - factor * value(k)).abs() < 1e-9, "{name}: {own} is {found} in row {k}");
        }
    }
}

fn between(separator: &str) -> String {
    rows(|_, t, w, u| format!("{t:.2}{separator}{w:.4}{separator}{u:.1}"))
}

const RATE: (&str, &str, f64) = ("rate", "rad/s", 1.0);
const TORQUE: (&str, &str, f64) = ("torque", "N*m", 1.0);

#[test]
fn a_header_may_be_divided_otherwise_than_its_rows_and_a_blank_divides_no_unit() {
    let headers = [
        ("commas above blanks", "# time [s], rate [rad/s], torque [N m]\n", " "),
        ("blanks above commas", "% time[s] rate[rad/s] torque[N*m]\n", ","),
        ("units in brackets behind blanks", "time [s]  rate [rad/s]  torque [N m]\n", "  "),
        ("units in parentheses behind a blank", "time (s) rate (rad/s) torque (N m)\n", " "),
        ("a line of units with blanks in brackets", "time rate torque\n[s] [rad / s] [N m]\n", " "),
        ("a line of units in parentheses", "# time rate torque\n# (s) (rad/s) (N m)\n", "\t"),
        ("units behind commas", "Time,s rate,rad/s torque,N*m\n", " "),
        ("a word for units with a colon", "time,rate,torque\nunits: s,rad/s,N.m\n", ","),
        ("a word for units in a cell of its own", "time;rate;torque\nUnits;s;rad/s;Nm\n", ";"),
        ("descriptions below the units", "time;rate;torque\ns;rad/s;Nm\n;measured;commanded\n", ";"),
        (
            "units in the preamble of LabVIEW",
            "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\nY_Unit_Label\trad/s\tN.m\n\
             X_Dimension\tTime\tTime\n***End_of_Header***\t\t\nX_Value\trate\ttorque\tComment\n",
            "\t",
        ),
    ];
    for (name, header, separator) in headers {
        holds(name, &(header.to_owned() + &between(separator)), RATE, TORQUE);
    }
    let silent = ("# t, rate, torque\n".to_owned() + &between(" "), "names with commas above blanks");
    holds(silent.1, &silent.0, ("rate", "?", 1.0), ("torque", "?", 1.0));
}

#[test]
fn rows_of_one_sample_are_read_by_the_column_that_names_their_channel() {
    let header = "time [s],channel,value\n";
    let each = rows(|_, t, w, u| format!("{t:.2},rate_rad_s,{w:.4}\n{t:.2},torque_Nm,{u:.1}"));
    holds("tidy", &(header.to_owned() + &each), ("rate_rad_s", "rad/s", 1.0), ("torque_Nm", "N*m", 1.0));
    let one_by_one = rows(|_, t, w, _| format!("{t:.2},rate,{w:.4},rad/s"))
        + &rows(|_, t, _, u| format!("{t:.2},torque,{:.1},mN.m", 1e3 * u));
    holds("tidy one by one", &("time [s],signal,value,unit\n".to_owned() + &one_by_one), RATE, TORQUE);
    let wide = rows(|_, t, w, u| format!("{t:.2},bus,{w:.4},{u:.1}\n{t:.2},arm,{:.4},{:.1}", 2.0 * w, 2.0 * u));
    let wide = format!("time [s],body,rate [rad/s],torque [N*m]\n{wide}");
    let set = read("tidy wide", &wide, &Intake::default()).unwrap();
    let names: Vec<&str> = set.recording.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["bus.rate", "bus.torque", "arm.rate", "arm.torque"], "{:?}", set.notes);
    assert_eq!(set.recording.channels[2].value[1], 2.0 * rate(1));
    let named = Intake { channels: vec![Assignment::parse("omega = arm.rate").unwrap()], ..Intake::default() };
    let set = read("tidy wide", &wide, &named).unwrap();
    assert_eq!(set.recording.channel_named("omega").unwrap().value[1], 2.0 * rate(1));
}

#[test]
fn a_column_of_states_names_no_channels() {
    let text = rows(|k, t, w, u| format!("{t:.2},{},{w:.4},{u:.1}", if k < 20 { "IDLE" } else { "RUN" }));
    holds("states", &format!("time [s],mode,rate [rad/s],torque [N*m]\n{text}"), RATE, TORQUE);
    // the name of a column that has one of its own stays
    let text = rows(|_, t, w, _| format!("{t:.2},gyro 2,{w:.4}"));
    let set = read("one sensor", &format!("time [s],sensor,rate [rad/s]\n{text}"), &Intake::default()).unwrap();
    assert_eq!(set.recording.channels[0].name, "rate");
}

#[test]
fn numbers_are_read_as_spreadsheets_format_them() {
    let thousands = |value: f64| {
        let text = format!("{value:.2}");
        let (whole, part) = text.split_once('.').unwrap();
        let split = whole.len().saturating_sub(3);
        let mark = if whole.len() > 3 { "," } else { "" };
        format!("\"{}{mark}{}.{part}\"", &whole[..split], &whole[split..])
    };
    let text = rows(|_, t, w, u| format!("{},{},{}", thousands(1e4 * t), thousands(1e4 * w), thousands(1e3 * u)));
    let header = "\"Time (ms)\",\"rate (mrad/s)\",\"torque (mN·m)\"\n";
    let set = read("thousands", &(header.to_owned() + &text), &Intake::default()).unwrap();
    let channel = |name: &str| set.recording.channel_named(name).unwrap();
    assert_eq!((channel("rate").unit.as_str(), channel("torque").unit.as_str()), ("rad/s", "N*m"));
    assert!(
        (channel("rate").value[6] - 10.0 * rate(6)).abs() < 1e-12 && (channel("torque").value[0] - 2.0).abs() < 1e-12
    );
    assert!((channel("rate").time_s[59] - 5.9).abs() < 1e-12);
    let swiss = rows(|k, t, w, u| format!("{t:.2};{w:.4};{u:.1};1'0{:02}.5", k));
    let set = read("apostrophes", &format!("time [s];rate;torque;count\n{swiss}"), &Intake::default()).unwrap();
    assert_eq!(set.recording.channel_named("count").unwrap().value[7], 1007.5);
    let german = rows(|k, t, w, u| format!("{t:.2};{w:.4};{u:.1};").replace('.', ",") + &format!("1.0{k:02},5"));
    let set = read("points", &format!("Zeit [s];rate;torque;count\n{german}"), &Intake::default()).unwrap();
    assert_eq!(set.recording.channel_named("count").unwrap().value[7], 1007.5);
    let decimals = rows(|_, t, w, u| format!("{t:.3};{w:.3};{u:.3}").replace('.', ","));
    holds("three decimals behind a comma", &format!("Zeit [s];rate [rad/s];torque [Nm]\n{decimals}"), RATE, TORQUE);
}

#[test]
fn truth_values_are_commands() {
    let text = rows(|k, t, w, _| format!("{t:.2},{},{w:.4}", if k % 2 == 1 { "TRUE" } else { "False" }));
    let set = read("truth", &format!("time [s],thruster,rate\n{text}"), &Intake::default()).unwrap();
    assert_eq!(set.recording.channel_named("thruster").unwrap().value[..3], [0.0, 1.0, 0.0]);
}

#[test]
fn names_of_rows_without_a_header_shift_no_column() {
    let text = rows(|k, t, w, u| format!("\"{}\",{t:.2},{w:.4},{u:.1}", k + 1));
    holds("row names", &format!("\"time [s]\",\"rate [rad/s]\",\"torque [N*m]\"\n{text}"), RATE, TORQUE);
}

#[test]
fn a_column_that_stays_empty_is_left_out_and_named() {
    let text = rows(|_, t, w, u| format!("{t:.2};{w:.4};{u:.1};"));
    let text = format!("time [s];rate [rad/s];torque [N*m];Bemerkung\n{text}");
    holds("empty column", &text, RATE, TORQUE);
    let set = read("empty column", &text, &Intake::default()).unwrap();
    assert!(set.notes.iter().any(|note| note.contains("`Bemerkung` (empty)")), "{:?}", set.notes);
}

#[test]
fn a_column_with_a_word_for_time_that_rises_is_the_clock_where_none_is_called_so() {
    let text = rows(|_, t, w, u| format!("{w:.4},{u:.1},{t:.2}"));
    holds("rising", &format!("rate [rad/s],torque [N*m],imu_capture_time_s\n{text}"), RATE, TORQUE);
    // one that falls somewhere is none
    let text = rows(|_, t, w, u| format!("{w:.4},{u:.1},{:.2}", (t - 0.3).abs()));
    let error = read("falling", &format!("rate [rad/s],torque [N*m],time_of_flight_x\n{text}"), &Intake::default());
    assert!(error.unwrap_err().contains("no column is known to hold the times"));
}

#[test]
fn stamps_in_coarse_units_do_not_shift_the_rate() {
    let text = rows(|_, t, w, u| format!("{:.6},{w:.4},{u:.1}", t / 60.0));
    let set = read("minutes", &format!("time_min,rate,torque\n{text}"), &Intake::default()).unwrap();
    let found = set.recording.channels[0].rate_hz().unwrap();
    assert!((found / 100.0 - 1.0).abs() < 1e-4, "{found}");
}

#[test]
fn the_cure_of_a_file_without_a_header_names_columns_of_numbers() {
    let text = rows(|_, t, w, u| format!("IMU,{t:.2},{w:.4},{u:.1}"));
    let error = read("labels", &text, &Intake::default()).unwrap_err();
    assert!(error.contains("--time-column 2:s --channel 'angle = 3 [rad]'"), "{error}");
    let said = Intake {
        time_column: Some(TimeColumn::parse("2:s").unwrap()),
        channels: vec![Assignment::parse("rate = 3 [rad/s]").unwrap()],
        ..Intake::default()
    };
    assert_eq!(read("labels", &text, &said).unwrap().recording.channels[0].value[1], rate(1));
}

#[test]
fn json_is_read_as_lines_as_an_array_of_objects_and_as_arrays_by_name() {
    let list = |f: fn(usize) -> f64| (0..ROWS).map(|k| format!("{:.4}", f(k))).collect::<Vec<_>>().join(",");
    let object = |k: usize| {
        format!(
            "{{\"t\":{:.2},\"imu\":{{\"rate_rad_s\":{:.4}}},\"tau_Nm\":{:.1}}}",
            0.01 * k as f64,
            rate(k),
            torque(k)
        )
    };
    let objects = |between: &str| (0..ROWS).map(object).collect::<Vec<_>>().join(between);
    let stamped = rows(|k, t, w, _| {
        format!("{{\"time\":\"2026-11-27T08:00:{t:05.2}Z\",\"rate_rad_s\":{w:.4},\"on\":{}}}", k % 2 == 1)
    });
    let by_name =
        format!("{{\"fs\": 100, \"rate_rad_s\": [{}], \"note\": \"x\", \"tau_Nm\": [{}]}}", list(rate), list(torque));
    let files = [
        ("json lines", objects("\n"), "imu.rate_rad_s"),
        ("json array", format!("[\n{}\n]\n", objects(",\n")), "imu.rate_rad_s"),
        ("json nested", format!("{{\"run\": 7, \"samples\": [{}]}}", objects(",")), "samples.imu.rate_rad_s"),
        ("json stamps", stamped, "rate_rad_s"),
        ("json by name", by_name, "rate_rad_s"),
    ];
    for (name, text, channel) in files {
        let set = read(name, &text, &Intake::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
        let found = set.recording.channel_named(channel).unwrap_or_else(|| panic!("{name}: {:?}", set.recording));
        assert_eq!((found.value.len(), found.unit.as_str()), (ROWS, "rad/s"), "{name}");
        assert!(found.value.iter().enumerate().all(|(k, value)| *value == rate(k)), "{name}");
        assert!((found.rate_hz().unwrap() - 100.0).abs() < 1e-6, "{name}: {:?}", found.rate_hz());
    }
    let cut = objects("\n");
    let set = read("json cut", &cut[..cut.len() - 9], &Intake::default()).unwrap();
    assert!(set.notes.iter().any(|note| note.contains("line 60")), "{:?}", set.notes);
    let error = read("json broken", "{\"t\": [0, 1,\n 2, ], \"a\": [1, 2, 3]}", &Intake::default()).unwrap_err();
    assert!(error.contains("line 2, column"), "{error}");
}

#[test]
fn a_cell_may_state_its_unit_and_each_is_read_in_its_own() {
    let unit_of =
        |k: usize, w: f64| if k.is_multiple_of(2) { format!("{w:.4} rad/s") } else { format!("{:.1} mrad/s", 1e3 * w) };
    let files = [
        ("in every cell", "time;rate;torque\n", rows(|_, t, w, u| format!("{t:.2} s;{w:.4} rad/s;{u:.1} N m"))),
        ("without blanks", "time,rate,torque\n", rows(|_, t, w, u| format!("{:.0}ms,{w:.4}rad/s,{u:.1}Nm", 1e3 * t))),
        (
            "of the header too",
            "time [s],rate [rad/s],torque [N m]\n",
            rows(|k, t, w, u| format!("{t:.2},{},{u:.1}", unit_of(k, w))),
        ),
        (
            "now one and now another",
            "time [s]\trate\ttorque [N m]\n",
            rows(|k, t, w, u| format!("{t:.2}\t{}\t{u:.1}", unit_of(k, w))),
        ),
        (
            "with decimal commas",
            "time;rate;torque\n",
            rows(|_, t, w, u| format!("{t:.2} s;{w:.4} rad/s;{u:.1} N m").replace('.', ",")),
        ),
    ];
    for (name, header, rows) in files {
        holds(name, &format!("{header}{rows}"), RATE, TORQUE);
    }
    let foreign = rows(|k, t, w, u| format!("{t:.2},{w:.4} {},{u:.1}", if k == 40 { "V" } else { "rad/s" }));
    let error =
        read("foreign unit", &format!("time [s],rate,torque [N m]\n{foreign}"), &Intake::default()).unwrap_err();
    assert!(error.contains("line 42") && error.contains(" V"), "{error}");
}

#[test]
fn a_comma_that_divides_cells_and_decimals_is_refused_with_the_cure_and_other_nameless_columns_are_left_out() {
    let comma = |number: f64, digits: usize| format!("{number:.digits$}").replace('.', ",");
    let refused = [
        ("in every number", rows(|_, t, w, u| format!("{},{},{}", comma(t, 2), comma(w, 3), comma(u, 1)))),
        ("in the last", rows(|_, t, w, u| format!("{t:.2},{w:.3},{}", comma(u, 1)))),
        ("in one between", rows(|_, t, w, u| format!("{t:.2},{},{u:.2}", comma(w, 3)))),
    ];
    for (name, rows) in refused {
        let error = read(name, &format!("time [s],rate [rad/s],torque [N m]\n{rows}"), &Intake::default()).unwrap_err();
        assert!(error.contains("line 2 has") && error.contains("quotes"), "{name}: {error}");
    }
    let more = rows(|k, t, w, u| format!("{t:.2},{w:.4},{u:.1},{}.5", k % 5));
    holds("a nameless column", &format!("time [s],rate [rad/s],torque [N m]\n{more}"), RATE, TORQUE);
}
