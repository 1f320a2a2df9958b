//! What loggers write is read; what a file does not say is said once beside it.

use crate::{file, scratch};
use recording::{Assignment, Imported, Intake, SeriesSet, TimeColumn};

/// Cosine and sine of the field's files, as rows of text.
fn rows(separator: &str, decimal: char) -> String {
    let number = |value: f64| format!("{value:.5}").replace('.', &decimal.to_string());
    let row = |k: i32| {
        let (t, a, b) = (f64::from(k) * 0.01, (0.3 * f64::from(k)).sin(), (0.2 * f64::from(k)).cos());
        format!("{}{separator}{}{separator}{}\n", number(t), number(a), number(b))
    };
    (0..50).map(row).collect()
}

fn said(time: Option<&str>, channels: &[&str]) -> Intake {
    Intake {
        time_column: time.map(|text| TimeColumn::parse(text).unwrap()),
        channels: channels.iter().map(|text| Assignment::parse(text).unwrap()).collect(),
        ..Intake::default()
    }
}

fn read(name: &str, text: &str, intake: &Intake) -> Result<SeriesSet, String> {
    recording::read_with(&file(name, text), intake).and_then(recording::series).map_err(|error| error.explain())
}

/// The channels are the field's, at 100 Hz.
fn holds(set: &SeriesSet, names: [&str; 2]) {
    let channels: Vec<&str> = set.recording.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(channels, names, "{:?}", set.notes);
    for (channel, first) in set.recording.channels.iter().zip([0.0, 1.0]) {
        assert_eq!(channel.value.len(), 50);
        assert_eq!(channel.value[0], first);
        assert!((channel.interval_s().unwrap() - 0.01).abs() < 1e-6, "{:?}", channel.interval_s());
    }
}

/// Spellings of a clock's header over seconds in decimal numbers.
const TIME_COLUMNS: &[&str] = &[
    "time [s]",
    "time (s)",
    "time_s",
    "time",
    "t",
    "t [s]",
    "t_s",
    "Time",
    "TIME",
    "Time [s]",
    "Time (sec)",
    "time[s]",
    "Time(s)",
    "timestamp",
    "Timestamp [s]",
    "timestamp_s",
    "time stamp",
    "TimeStamp",
    "ts",
    "elapsed",
    "elapsed_time",
    "Elapsed Time (s)",
    "seconds",
    "secs",
    "sec",
    "t(s)",
    "Zeit [s]",
    "Zeit / s",
    "temps (s)",
    "#time",
    "%time",
    "# time [s]",
    "\"Time\"",
    "stamp",
    "header.stamp",
    "__time",
    "sim_time",
    "sim time [s]",
    "Time, s",
    "time (seconds)",
    "unix_time",
    "clock",
    "rosbagTimestamp",
    "time_sec",
    "Time in s",
    "log_time",
    "relative time",
    "T",
];

/// Spellings of units and their SI units.
const UNITS: &[(&str, &str)] = &[
    ("m/s^2", "m/s^2"),
    ("m/s2", "m/s^2"),
    ("m/s²", "m/s^2"),
    ("m s^-2", "m/s^2"),
    ("m s-2", "m/s^2"),
    ("m·s⁻²", "m/s^2"),
    ("m/s/s", "m/s^2"),
    ("m/sec^2", "m/s^2"),
    ("m/s**2", "m/s^2"),
    ("(m/s^2)", "m/s^2"),
    ("meters/second^2", "m/s^2"),
    ("mm/s2", "m/s^2"),
    ("g", "m/s^2"),
    ("gee", "m/s^2"),
    ("mg", "m/s^2"),
    ("in/s^2", "m/s^2"),
    ("ft/s2", "m/s^2"),
    ("rad/s", "rad/s"),
    ("rad s^-1", "rad/s"),
    ("rad/sec", "rad/s"),
    ("rad·s⁻¹", "rad/s"),
    ("rads/s", "rad/s"),
    ("radians/sec", "rad/s"),
    ("deg/s", "rad/s"),
    ("deg/sec", "rad/s"),
    ("°/s", "rad/s"),
    ("dps", "rad/s"),
    ("degrees/s", "rad/s"),
    ("deg per s", "rad/s"),
    ("mdps", "rad/s"),
    ("rpm", "rad/s"),
    ("RPM", "rad/s"),
    ("rev/min", "rad/s"),
    ("U/min", "rad/s"),
    ("rev/s", "rad/s"),
    ("deg/h", "rad/s"),
    ("deg/hr", "rad/s"),
    ("rad/s^2", "rad/s^2"),
    ("rad/s2", "rad/s^2"),
    ("rad s^-2", "rad/s^2"),
    ("deg/s²", "rad/s^2"),
    ("rad", "rad"),
    ("deg", "rad"),
    ("°", "rad"),
    ("degrees", "rad"),
    ("radians", "rad"),
    ("mrad", "rad"),
    ("urad", "rad"),
    ("arcsec", "rad"),
    ("rev", "rad"),
    ("N", "N"),
    ("mN", "N"),
    ("kN", "N"),
    ("lbf", "N"),
    ("kgf", "N"),
    ("newton", "N"),
    ("N*m", "N*m"),
    ("N.m", "N*m"),
    ("N·m", "N*m"),
    ("Nm", "N*m"),
    ("N m", "N*m"),
    ("N-m", "N*m"),
    ("mNm", "N*m"),
    ("mN.m", "N*m"),
    ("ft-lb", "N*m"),
    ("ft*lbf", "N*m"),
    ("in-lb", "N*m"),
    ("ozf*in", "N*m"),
    ("newton-meters", "N*m"),
    ("m", "m"),
    ("mm", "m"),
    ("µm", "m"),
    ("inch", "m"),
    ("in", "m"),
    ("ft", "m"),
    ("meters", "m"),
    ("m/s", "m/s"),
    ("m s^-1", "m/s"),
    ("mm/s", "m/s"),
    ("in/s", "m/s"),
    ("km/h", "m/s"),
    ("mph", "m/s"),
    ("knots", "m/s"),
    ("Pa", "Pa"),
    ("psi", "Pa"),
    ("bar", "Pa"),
    ("mbar", "Pa"),
    ("hPa", "Pa"),
    ("kPa", "Pa"),
    ("mmHg", "Pa"),
    ("V", "V"),
    ("mV", "V"),
    ("volts", "V"),
    ("A", "A"),
    ("mA", "A"),
    ("amps", "A"),
    ("W", "W"),
    ("ohm", "ohm"),
    ("Ω", "ohm"),
    ("degC", "K"),
    ("°C", "K"),
    ("celsius", "K"),
    ("K", "K"),
    ("degF", "K"),
    ("T", "T"),
    ("uT", "T"),
    ("gauss", "T"),
    ("mgauss", "T"),
    ("Hz", "Hz"),
    ("kHz", "Hz"),
    ("%", "-"),
    ("percent", "-"),
    ("LSB", "-"),
    ("counts", "-"),
    ("-", "-"),
    ("1", "-"),
    ("s", "s"),
    ("ms", "s"),
    ("us", "s"),
    ("µs", "s"),
    ("sec", "s"),
    ("msec", "s"),
    ("ns", "s"),
    ("min", "s"),
    ("kg", "kg"),
    ("lb", "kg"),
    ("kg m^2", "kg*m^2"),
    ("kg*m^2", "kg*m^2"),
    ("kgm2", "kg*m^2"),
    ("kg·m²", "kg*m^2"),
    ("N/m", "N/m"),
    ("N/mm", "N/m"),
    ("kN/m", "N/m"),
    ("lbf/in", "N/m"),
    ("N*s/m", "N*s/m"),
    ("N s/m", "N*s/m"),
    ("Nm/rad", "N*m/rad"),
    ("N·m/rad", "N*m/rad"),
    ("Nms/rad", "N*m*s/rad"),
    ("Nms", "N*m*s"),
    ("Nm/A", "N*m/A"),
    ("A*m^2", "A*m^2"),
    ("Am²", "A*m^2"),
    ("J", "J"),
    ("kg/s", "kg/s"),
    ("m/s^2/N", "m/s^2/N"),
    ("(m/s^2)/N", "m/s^2/N"),
    ("m/N", "m/N"),
];

#[test]
fn spellings_of_the_clock_are_known() {
    let refused: Vec<&str> = TIME_COLUMNS
        .iter()
        .filter(|header| {
            let text = format!("{header};a [m];b [m]\n{}", rows(";", '.'));
            !read("clock.csv", &text, &Intake::default()).is_ok_and(|set| set.recording.channels[0].value.len() == 50)
        })
        .copied()
        .collect();
    println!("clocks: {} of {} known, not {refused:?}", TIME_COLUMNS.len() - refused.len(), TIME_COLUMNS.len());
    assert!(20 * refused.len() <= TIME_COLUMNS.len(), "{refused:?}");
}

#[test]
fn the_name_of_a_clock_may_end_in_its_unit() {
    for (header, interval_s) in
        [("TimeUS", 0.01), ("time_us", 0.01), ("timestamp_ns", 1e-5), ("logTimeMs", 10.0), ("t_s", 1e4)]
    {
        let text: String = (0..20).map(|k| format!("{},{k}\n", 500 + 10_000 * k)).collect();
        let set = read("ending_clock.csv", &format!("{header},a [m]\n{text}"), &Intake::default()).unwrap();
        let found = set.recording.channels[0].interval_s().unwrap();
        assert!((found / interval_s - 1.0).abs() < 1e-9, "{header}: {found}");
    }
}

#[test]
fn spellings_of_units_are_known_and_have_the_right_dimension() {
    let mut refused = Vec::new();
    for (spelling, si) in UNITS {
        match recording::units::unit_named(spelling) {
            Some(unit) => assert_eq!(unit.si, *si, "{spelling}"),
            None => refused.push(spelling),
        }
    }
    println!("units: {} of {} known, not {refused:?}", UNITS.len() - refused.len(), UNITS.len());
    assert!(20 * refused.len() <= UNITS.len(), "{refused:?}");
}

#[test]
fn units_convert_by_their_definitions() {
    for (spelling, value, si) in [
        ("dps", 180.0, core::f64::consts::PI),
        ("RPM", 60.0, 2.0 * core::f64::consts::PI),
        ("psi", 1.0, 6_894.757_293_168_361),
        ("in/s", 1.0, 0.0254),
        ("km/h", 3.6, 1.0),
        ("ft-lb", 1.0, 1.355_817_948_331_400_4),
        ("kgf", 1.0, 9.806_65),
        ("degF", 32.0, 273.15),
        ("gauss", 1.0, 1e-4),
        ("deg/hr", 3600.0, core::f64::consts::PI / 180.0),
        ("mN.m", 1.0, 1e-3),
        ("urad", 1.0, 1e-6),
    ] {
        let found = recording::units::unit_named(spelling).unwrap().to_si(value);
        assert!((found / si - 1.0).abs() < 1e-12, "{spelling}: {found} is not {si}");
    }
}

#[test]
fn what_may_mean_two_things_is_no_unit() {
    for text in ["G", "C", "NM", "gal", "M", "quux", "m/", "N**", "m^99", "((((((m))))))"] {
        assert_eq!(recording::units::unit_named(text), None, "{text}");
    }
}

/// Shapes of files: name, text, what is said beside it, expected names.
fn shapes() -> Vec<(&'static str, String, Intake, [&'static str; 2])> {
    let none = Intake::default;
    let head = "time [s],a [m],b [m]\n";
    let comma = rows(",", '.');
    let shape = |name, text: String| (name, text, none(), ["a", "b"]);
    let mut all = vec![
        shape("plain", format!("{head}{comma}")),
        shape("semicolon", format!("time [s];a [m];b [m]\n{}", rows(";", '.'))),
        shape("semicolon and decimal comma", format!("time [s];a [m];b [m]\n{}", rows(";", ','))),
        shape("tab", format!("time [s]\ta [m]\tb [m]\n{}", rows("\t", '.'))),
        shape("tab and decimal comma", format!("time [s]\ta [m]\tb [m]\n{}", rows("\t", ','))),
        shape("bar", format!("time [s]|a [m]|b [m]\n{}", rows("|", '.'))),
        shape("blanks", format!("time a b\n{}", rows("   ", '.'))),
        shape("blanks around commas", format!("time [s] , a [m] , b [m]\n{}", rows(" , ", '.'))),
        shape("mark of UTF-8", format!("\u{feff}{head}{comma}")),
        shape("carriage returns", format!("{head}{comma}").replace('\n', "\r\n")),
        shape("remarks above", format!("# logger v2\n# rate 100\n{head}{comma}")),
        shape("header in a remark", format!("# logger v2\n#time,a,b\n{comma}")),
        shape("header in a remark of %", format!("%time,a,b\n{comma}")),
        shape("units in a second line", format!("time,a,b\ns,m,m\n{comma}")),
        shape(
            "units of which one is not known",
            format!("Zeit;a;b;c\ns;Grad;m;Furlong\n{}", rows(";", ',').replace('\n', ";1\n")),
        ),
        shape("units in brackets in a second line", format!("time,a,b\n[s],[m/s^2],[m]\n{comma}")),
        shape("units in parentheses", format!("\"Time (s)\",\"a (m)\",\"b (m)\"\n{comma}")),
        shape("units behind slashes", format!("Zeit / s;a / m;b / m/s\n{}", rows(";", ','))),
        shape("separators at the end", format!("time [s],a [m],b [m],\n{}", comma.replace('\n', ",\n"))),
        shape("separators at the end of rows", format!("{head}{}", comma.replace('\n', ",\n"))),
        shape("rows of separators", format!("{head}{comma},,\n,,\n")),
        shape("footer", format!("{head}{comma}# end\nTotal: 50 rows\n")),
        shape("text column", format!("time [s],a [m],state,b [m]\n{}", with_third(&comma, "idle"))),
        shape("clock last", format!("a [m],b [m],time [s]\n{}", clock_last(&comma))),
        shape("title above the header", format!("Measurement of Tuesday\n\n{head}{comma}")),
        shape("header again", format!("{head}{comma}{head}")),
        shape("blank lines", format!("{head}\n{}", comma.replace('\n', "\n\n"))),
        shape("all in quotes", format!("{head}{}", quoted(&comma))),
        shape("decimal commas in quotes", format!("{head}{}", quoted_decimals())),
        shape("last line open", format!("{head}{}", comma.trim_end())),
        shape("exponents of Fortran", format!("{head}{}", comma.replace(",0.", ",00.")).replace("\n", "\n")),
        shape("index of pandas", format!(",time [s],a [m],b [m]\n{}", indexed(&comma))),
        shape("stamps of ISO 8601", format!("time,a,b\n{}", stamped(&comma, "2025-04-17T17:00:", ""))),
        shape("stamps with a blank and Z", format!("time,a,b\n{}", stamped(&comma, "2025-04-17 17:00:", "Z"))),
        shape("stamps with an offset", format!("timestamp,a,b\n{}", stamped(&comma, "2025-04-17T17:00:", "+02:00"))),
        shape("stamps of Germany", format!("Zeit,a,b\n{}", stamped(&comma, "17.04.2025 17:00:", ""))),
        shape("time of day", format!("time,a,b\n{}", stamped(&comma, "17:00:", ""))),
        shape("date and time", format!("date,time,a,b\n{}", stamped(&comma, "2025-04-17,17:00:", ""))),
        shape("stamps across midnight", format!("time,a,b\n{}", stamped_over_midnight(&comma))),
        shape("nanoseconds since 1970", format!("time,a,b\n{}", epoch(&comma, 1e9))),
        shape("microseconds since 1970", format!("timestamp,a,b\n{}", epoch(&comma, 1e6))),
        shape("milliseconds since 1970", format!("timestamp,a,b\n{}", epoch(&comma, 1e3))),
        shape("signs", format!("{head}{}", comma.replace(",0.", ",+0."))),
    ];
    all.push(("no header", comma.clone(), said(Some("1:s"), &["a = 2 [m]", "b = 3 [m]"]), ["a", "b"]));
    all.push(("no clock", format!("a [m],b [m]\n{}", without_clock(&comma)), said(Some("row:100Hz"), &[]), ["a", "b"]));
    all.push(("counter", format!("n,a,b\n{}", counted(&comma)), said(Some("n:100Hz"), &[]), ["a", "b"]));
    all.push((
        "microseconds of the system",
        format!("timestamp,gyro_rad[0],accelerometer_m_s2[0]\n{}", micros(&comma)),
        said(Some("timestamp:us"), &["gyro_rad[0] [rad/s]"]),
        ["gyro_rad[0]", "accelerometer_m_s2[0]"],
    ));
    all
}

fn map_rows(text: &str, f: impl Fn(usize, &[&str]) -> String) -> String {
    text.lines().enumerate().map(|(k, line)| f(k, &line.split(',').collect::<Vec<_>>()) + "\n").collect()
}

fn with_third(text: &str, third: &str) -> String {
    map_rows(text, |_, cells| format!("{},{},{third},{}", cells[0], cells[1], cells[2]))
}

fn clock_last(text: &str) -> String {
    map_rows(text, |_, cells| format!("{},{},{}", cells[1], cells[2], cells[0]))
}

fn without_clock(text: &str) -> String {
    map_rows(text, |_, cells| format!("{},{}", cells[1], cells[2]))
}

fn counted(text: &str) -> String {
    map_rows(text, |k, cells| format!("{k},{},{}", cells[1], cells[2]))
}

fn micros(text: &str) -> String {
    map_rows(text, |k, cells| format!("{},{},{}", 27_329_869 + 10_000 * k, cells[1], cells[2]))
}

fn indexed(text: &str) -> String {
    map_rows(text, |k, cells| format!("{k},{}", cells.join(",")))
}

fn quoted(text: &str) -> String {
    map_rows(text, |_, cells| cells.iter().map(|cell| format!("\"{cell}\"")).collect::<Vec<_>>().join(","))
}

fn quoted_decimals() -> String {
    let row = |line: &str| line.split(';').map(|cell| format!("\"{cell}\"")).collect::<Vec<_>>().join(",") + "\n";
    rows(";", ',').lines().map(row).collect()
}

fn stamped(text: &str, before: &str, behind: &str) -> String {
    map_rows(text, |_, cells| {
        let seconds: f64 = cells[0].parse().unwrap();
        format!("{before}{seconds:05.2}{behind},{},{}", cells[1], cells[2])
    })
}

fn stamped_over_midnight(text: &str) -> String {
    map_rows(text, |k, cells| {
        let stamp = if k < 20 { format!("23:59:59.{:02}", 80 + k) } else { format!("00:00:00.{:02}", k - 20) };
        format!("{stamp},{},{}", cells[1], cells[2])
    })
}

fn epoch(text: &str, per_s: f64) -> String {
    map_rows(text, |k, cells| {
        let stamp = 1_486_559_106 * per_s as i128 + k as i128 * (per_s * 0.01) as i128;
        format!("{stamp},{},{}", cells[1], cells[2])
    })
}

#[test]
fn shapes_of_files_are_read_as_what_they_mean() {
    let shapes = shapes();
    let mut refused = Vec::new();
    for (name, text, intake, names) in &shapes {
        match read(&format!("{}.csv", name.replace(' ', "_")), text, intake) {
            Ok(set) => holds(&set, *names),
            Err(error) => refused.push((name, error)),
        }
    }
    println!("shapes: {} of {} read", shapes.len() - refused.len(), shapes.len());
    assert!(refused.is_empty(), "{refused:#?}");
}

#[test]
fn utf_16_and_latin_1_are_read() {
    let text = format!("time [s];a [°/s];b [m]\n{}", rows(";", ','));
    for (name, mark, big) in [("le", true, false), ("be", true, true), ("bare", false, false)] {
        let units = mark.then_some(0xfeff).into_iter().chain(text.encode_utf16());
        let bytes: Vec<u8> = units.flat_map(|unit| if big { unit.to_be_bytes() } else { unit.to_le_bytes() }).collect();
        let path = scratch(&format!("{name}.csv"));
        std::fs::write(&path, bytes).unwrap();
        holds(&recording::series(recording::read(&path).unwrap()).unwrap(), ["a", "b"]);
    }
    let latin: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    let path = scratch("latin.csv");
    std::fs::write(&path, latin).unwrap();
    let set = recording::series(recording::read(&path).unwrap()).unwrap();
    holds(&set, ["a", "b"]);
    assert_eq!(set.recording.channels.iter().map(|c| c.unit.as_str()).collect::<Vec<_>>(), ["rad/s", "m"]);
}

#[test]
fn what_says_that_there_is_no_sample_costs_one_sample_of_one_channel() {
    for cell in ["NaN", "nan", "", "inf", "-inf", "NULL", "N/A", "-nan(ind)", "#N/A", "None"] {
        let text: String = (0..9).map(|k| format!("{k}.5,{},{k}\n", if k == 4 { cell } else { "1" })).collect();
        let set = read("missing.csv", &format!("time [s],a [m],b [m]\n{text}"), &Intake::default()).unwrap();
        let samples: Vec<usize> = set.recording.channels.iter().map(|channel| channel.value.len()).collect();
        assert_eq!(samples, [8, 9], "{cell}");
        assert_eq!(
            set.notes.iter().any(|note| note.contains("infinite")),
            cell.contains("inf"),
            "{cell}: {:?}",
            set.notes
        );
    }
}

#[test]
fn an_empty_cell_shifts_no_value_into_another_column_whatever_the_separator() {
    for separator in [",", ";", "\t", "|"] {
        let rows: String = (0..9)
            .map(|k| {
                let cells = [
                    if k == 4 { String::new() } else { "1".into() },
                    format!("{k}.5"),
                    if k == 6 { String::new() } else { "2".into() },
                ];
                cells.join(separator) + "\n"
            })
            .collect();
        let header = ["a [m]", "time [s]", "b [m]"].join(separator);
        let set = read("empty_cells.csv", &format!("{header}\n{rows}"), &Intake::default()).unwrap();
        let [a, b] = &set.recording.channels[..] else { panic!("two channels") };
        assert!(a.value == [1.0; 8] && !a.time_s.contains(&4.5), "{separator:?}: {a:?}");
        assert!(b.value == [2.0; 8] && !b.time_s.contains(&6.5), "{separator:?}: {b:?}");
    }
}

#[test]
fn an_assignment_is_of_one_column_although_two_names_differ_by_case_alone() {
    let text = "time [s],A [m],a [m],2 [m]\n0,1,2,3\n1,1,2,3\n";
    for (said_of, value) in [("x = a", 2.0), ("x = A", 1.0), ("x = 2", 3.0)] {
        let set = read("cases.csv", text, &said(None, &[said_of])).unwrap();
        let named: Vec<f64> = set.recording.channels.iter().filter(|c| c.name == "x").map(|c| c.value[0]).collect();
        assert_eq!(named, [value], "{said_of}");
    }
}

#[test]
fn a_row_that_a_stopped_writer_cut_is_left_out_and_a_short_row_within_is_an_error() {
    let text = "time [s],a [m],b [m]\n0,1,2\n1,1,2\n2,1,2\n3,1";
    let set = read("cut.csv", text, &Intake::default()).unwrap();
    assert_eq!(set.recording.channels[0].time_s, [0.0, 1.0, 2.0]);
    assert!(set.notes[0].contains("from line 5 on"), "{:?}", set.notes);
    assert!(read("short.csv", &format!("{text}\n4,1,2\n"), &Intake::default()).unwrap_err().contains("line 5"));
}

#[test]
fn a_name_that_stands_twice_is_told_by_its_turn() {
    let set = read("twice.csv", "time [s],x [m],x [mm]\n0,1,2\n1,1,2\n", &Intake::default()).unwrap();
    let named: Vec<(&str, f64)> = set.recording.channels.iter().map(|c| (c.name.as_str(), c.value[0])).collect();
    assert_eq!(named, [("x", 1.0), ("x_2", 0.002)]);
    assert!(set.notes.iter().any(|note| note.contains("column 3 is `x_2`")), "{:?}", set.notes);
}

#[test]
fn a_unit_that_is_not_stated_is_no_unit_and_the_cure_is_noted() {
    let set = read("silent.csv", "t,velocity,torque\n0.0,0,1\n0.5,1,2\n1.0,2,3\n", &Intake::default()).unwrap();
    assert!(set.recording.channels.iter().all(|channel| channel.unit == "?" && set.unit_in_file(channel) == "?"));
    assert!(set.notes.iter().any(|note| note.contains("--channel 'velocity = velocity [UNIT]'")), "{:?}", set.notes);
    assert!(set.notes.iter().any(|note| note.contains("seconds are assumed")), "{:?}", set.notes);
    let intake = said(Some("t:ms"), &["rate = velocity [deg/s]", "torque [mN*m]"]);
    let set = read("said.csv", "t,velocity,torque\n0.0,0,1\n0.5,180,2\n1.0,2,3\n", &intake).unwrap();
    let [rate, torque] = &set.recording.channels[..] else { panic!("two channels") };
    assert_eq!((rate.name.as_str(), rate.unit.as_str(), rate.value[1]), ("rate", "rad/s", core::f64::consts::PI));
    assert_eq!((torque.name.as_str(), torque.unit.as_str(), torque.value[1]), ("torque", "N*m", 0.002));
    assert_eq!(rate.time_s[1], 0.0005);
}

#[test]
fn the_name_of_a_quantity_that_contradicts_its_ending_states_no_unit() {
    let units = |header: &str| {
        let text = format!("time_ms,{header}\n0.0,1\n0.5,2\n1.0,3\n");
        let set = read("ending.csv", &text, &Intake::default()).unwrap();
        (set.recording.channels[0].unit.clone(), set.recording.channels[0].time_s[1])
    };
    for (header, unit) in [
        ("accel_m_s2", "m/s^2"),
        ("rate_deg_s", "rad/s"),
        ("torque_Nm", "N*m"),
        ("pressure_kPa", "Pa"),
        ("angle_rad", "rad"),
        ("accelerometer_m_s2[0]", "m/s^2"),
        ("gyro_rad[0]", "?"),
        ("omega_deg", "?"),
        ("x_m", "?"),
        ("phase_A", "?"),
        ("speed_rpm", "rad/s"),
    ] {
        assert_eq!(units(header), (unit.to_owned(), 0.0005), "{header}");
    }
}

#[test]
fn what_is_said_of_a_column_that_is_not_there_is_an_error_with_the_columns() {
    let text = "time [s],rate_z [deg/s]\n0,1\n1,2\n";
    let absent = read("absent_column.csv", text, &said(None, &["rate = rate_y [deg/s]"])).unwrap_err();
    assert!(absent.contains("rate_y") && absent.contains("did you mean `rate_z`"), "{absent}");
    let absent = read("absent_column.csv", text, &said(Some("stamp:us"), &[])).unwrap_err();
    assert!(absent.contains("--time-column stamp") && absent.contains("columns: time, rate_z"), "{absent}");
    for bad in ["", "= x", "x =", "a = b [furlong]"] {
        let error = Assignment::parse(bad).unwrap_err().explain();
        assert!(error.contains("--channel") && error.contains("cure: "), "{error}");
    }
    for bad in ["", ":us", "row", "t:m", "t:"] {
        let error = TimeColumn::parse(bad).unwrap_err().explain();
        assert!(error.contains("--time-column") && error.contains("cure: "), "{error}");
    }
}

#[test]
fn a_map_says_the_same_as_the_command_line_and_the_command_line_wins() {
    let map = "time = \"t:ms\"\n[channels]\nrate = { name = \"velocity\", unit = \"deg/s\", scale = -1 }\nimu.torque = \"torque [mN*m]\"\n";
    let mut intake = said(None, &["rate = torque [N*m]"]);
    intake.read_map("said.toml", map).unwrap();
    assert_eq!(intake.channels.iter().map(|of| of.own.as_str()).collect::<Vec<_>>(), ["rate", "imu.torque"]);
    let mut intake = Intake::default();
    intake.read_map("said.toml", map).unwrap();
    let set = read("map.csv", "t,velocity,torque\n0,0,1\n5,180,2\n10,2,3\n", &intake).unwrap();
    let [rate, torque] = &set.recording.channels[..] else { panic!("two channels") };
    assert_eq!((rate.name.as_str(), rate.value[1]), ("rate", -core::f64::consts::PI));
    assert_eq!((torque.name.as_str(), torque.value[1], torque.time_s[1]), ("imu.torque", 0.002, 0.005));
    let mut again = Intake::default();
    again.read_map("again.toml", &intake.to_map_text()).unwrap();
    assert_eq!(
        read("map.csv", "t,velocity,torque\n0,0,1\n5,180,2\n10,2,3\n", &again).unwrap().recording,
        set.recording
    );
}

#[test]
fn datasets_and_channels_of_a_file_are_listed_before_anything_is_said() {
    let path = file("listed.csv", "time [s],a [m],state,b\n0,1,idle,\n0.5,1,idle,2\n1,1,run,2\n1.5,1,run,\n");
    let listed = recording::list(&path, &Intake::default()).unwrap();
    let [dataset] = &listed[..] else { panic!("one dataset") };
    let channels: Vec<_> = dataset.channels.iter().map(|c| (c.name.as_str(), c.unit.as_deref(), c.samples)).collect();
    assert_eq!(channels, [("a", Some("m"), 4), ("b", None, 2)]);
    assert_eq!((dataset.channels[0].rate_hz, dataset.channels[0].end_s), (Some(2.0), Some(1.5)));
    assert!(dataset.notes.iter().any(|note| note.contains("`state` (text)")), "{:?}", dataset.notes);
}

#[test]
fn a_line_without_end_and_what_is_no_file_are_refused() {
    let path = scratch("endless.csv");
    std::fs::write(&path, format!("time [s],a [m]\n{}", "1".repeat(9 << 20))).unwrap();
    assert!(recording::read(&path).unwrap_err().explain().contains("line 2 is longer than"));
    let device = recording::read(std::path::Path::new("/dev/zero")).unwrap_err().explain();
    assert!(device.contains("a pipe or a device"), "{device}");
    let folder = recording::read(&std::env::temp_dir()).unwrap_err().explain();
    assert!(folder.contains("a folder"), "{folder}");
}

#[test]
fn control_characters_of_a_file_are_made_visible() {
    let text = "time [s],\u{1b}[31mx [furlong],y [m]\n0,1,1\n1,2,2\n";
    let set = read("escape.csv", text, &Intake::default()).unwrap();
    assert!(set.notes.iter().all(|note| !note.contains('\u{1b}')), "{:?}", set.notes);
}

#[test]
fn a_spectrum_of_another_program_is_one_whatever_its_header_looks_like() {
    for header in ["frequency [Hz]", "Frequency (Hz)", "f [Hz]", "freq_Hz"] {
        let path = file("spectrum.csv", &format!("{header},a [m/s^2]\n0,1\n1,2\n2,3\n"));
        assert!(matches!(recording::read(&path).unwrap(), Imported::Spectrum(_)), "{header}");
    }
}
