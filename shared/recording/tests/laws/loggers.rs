//! Spellings of loggers of other languages and vendors, written down before any was tried.

use crate::file;
use recording::Intake;

/// 50 rows at 100 Hz: each is `row(t, a, b)`.
fn rows(row: impl Fn(usize, f64, f64, f64) -> String) -> String {
    let at = |k: usize| (k as f64 * 0.01, (0.3 * k as f64).sin(), (0.2 * k as f64).cos());
    let line = |k: usize| {
        let (t, a, b) = at(k);
        row(k, t, a, b) + "\n"
    };
    (0..50).map(line).collect()
}

fn plain(separator: &str) -> String {
    rows(|_, t, a, b| format!("{t:.2}{separator}{a:.5}{separator}{b:.5}"))
}

fn with_comma(separator: &str) -> String {
    plain(separator).replace('.', ",")
}

/// Names of a clock in seconds.
const CLOCKS: &[&str] = &[
    "Tempo [s]",
    "Tiempo (s)",
    "Tid [s]",
    "tijd (s)",
    "Aika [s]",
    "Czas [s]",
    "Čas [s]",
    "время [с]",
    "时间(s)",
    "時間[s]",
    "시간 (s)",
    "Zeitstempel [s]",
    "Messzeit in s",
    "Zeit[sec]",
    "Laufzeit [s]",
    "Sekunden",
    "segundos",
    "X_Value",
    "Time (Seconds)",
    "TIME (sec.)",
    "Total Time [Sec]",
    "Running Time (sec)",
    "Test Time (s)",
    "Elapsed [s]",
    "ElapsedSeconds",
    "elapsedSec",
    "time_since_start",
    "time_boot_s",
    "rel_time_s",
    "t_rel [s]",
    "uptime",
    "uptime_s",
    "Horodatage [s]",
    "Temps écoulé (s)",
    "rosbag_time",
    "/time",
    "TIME_S",
    "t/s",
    "time_abs",
    "tempo_s",
    "gps_time",
    "t_sec",
    "TimeSec",
    "time.s",
    "Time - Voltage_0",
    "Time@100Hz",
];

/// Units as vendors write them, the SI unit they are of, and one of them in it.
const UNITS: &[(&str, &str, f64)] = &[
    ("Umdr/min", "rad/s", 0.104_719_755_119_659_77),
    ("Umdr./min", "rad/s", 0.104_719_755_119_659_77),
    ("tr/min", "rad/s", 0.104_719_755_119_659_77),
    ("giri/min", "rad/s", 0.104_719_755_119_659_77),
    ("obr/min", "rad/s", 0.104_719_755_119_659_77),
    ("r/min", "rad/s", 0.104_719_755_119_659_77),
    ("об/мин", "rad/s", 0.104_719_755_119_659_77),
    ("1/min", "1/s", 1.0 / 60.0),
    ("min^-1", "1/s", 1.0 / 60.0),
    ("Grad/s", "rad/s", 0.017_453_292_519_943_295),
    ("°/sec", "rad/s", 0.017_453_292_519_943_295),
    ("deg./s", "rad/s", 0.017_453_292_519_943_295),
    ("grados", "rad", 0.017_453_292_519_943_295),
    ("degrés", "rad", 0.017_453_292_519_943_295),
    ("rad/seg", "rad/s", 1.0),
    ("µrad", "rad", 1e-6),
    ("arcseconds", "rad", 4.848_136_811_095_36e-6),
    ("deg/s/s", "rad/s^2", 0.017_453_292_519_943_295),
    ("°/s²", "rad/s^2", 0.017_453_292_519_943_295),
    ("rad/sec²", "rad/s^2", 1.0),
    ("m.s-2", "m/s^2", 1.0),
    ("m*s^-2", "m/s^2", 1.0),
    ("m/(s^2)", "m/s^2", 1.0),
    ("m/seg²", "m/s^2", 1.0),
    ("cm/s2", "m/s^2", 0.01),
    ("g's", "m/s^2", 9.806_65),
    ("mg's", "m/s^2", 9.806_65e-3),
    ("km/hr", "m/s", 1.0 / 3.6),
    ("mi/h", "m/s", 0.447_04),
    ("ft/min", "m/s", 0.00508),
    ("inches/sec", "m/s", 0.0254),
    ("Newtonmeter", "N*m", 1.0),
    ("Nmm", "N*m", 1e-3),
    ("N.mm", "N*m", 1e-3),
    ("N·cm", "N*m", 1e-2),
    ("Ncm", "N*m", 1e-2),
    ("kgf·m", "N*m", 9.806_65),
    ("kgf.cm", "N*m", 9.806_65e-2),
    ("oz-in", "N*m", 7.061_551_814_226_043e-3),
    ("lb-ft", "N*m", 1.355_817_948_331_400_4),
    ("lbf.in", "N*m", 0.112_984_829_027_616_7),
    ("in·lbf", "N*m", 0.112_984_829_027_616_7),
    ("Newton", "N", 1.0),
    ("daN", "N", 10.0),
    ("kips", "N", 4_448.221_615_260_5),
    ("klbf", "N", 4_448.221_615_260_5),
    ("gf", "N", 9.806_65e-3),
    ("N/mm²", "Pa", 1e6),
    ("N/mm2", "Pa", 1e6),
    ("kgf/cm²", "Pa", 98_066.5),
    ("kN/mm", "N/m", 1e6),
    ("N/(m/s)", "N*s/m", 1.0),
    ("Ns/m", "N*s/m", 1.0),
    ("Nm/deg", "N*m/rad", 57.295_779_513_082_32),
    ("Nm/°", "N*m/rad", 57.295_779_513_082_32),
    ("V/(rad/s)", "V*s/rad", 1.0),
    ("V/krpm", "V*s/rad", 9.549_296_585_513_72e-3),
    ("Arms", "A", 1.0),
    ("A_rms", "A", 1.0),
    ("Vdc", "V", 1.0),
    ("Vrms", "V", 1.0),
    ("µV", "V", 1e-6),
    ("millivolts", "V", 1e-3),
    ("milliamps", "A", 1e-3),
    ("kOhm", "ohm", 1e3),
    ("mOhm", "ohm", 1e-3),
    ("kg.m2", "kg*m^2", 1.0),
    ("kg-m²", "kg*m^2", 1.0),
    ("slug-ft2", "kg*m^2", 1.355_817_948_331_400_4),
    ("lb·in²", "kg*m^2", 2.926_396_534_292e-4),
    ("kg·cm²", "kg*m^2", 1e-4),
    ("°F", "K", f64::NAN),
    ("deg C", "K", f64::NAN),
    ("Grad C", "K", f64::NAN),
    ("microstrain", "-", 1e-6),
    ("µε", "-", 1e-6),
    ("µm/m", "-", 1e-6),
    ("a.u.", "-", 1.0),
    ("raw", "-", 1.0),
    ("ADC counts", "-", 1.0),
    ("cnt", "-", 1.0),
    ("pulses", "-", 1.0),
    ("sec.", "s", 1.0),
    ("Sek", "s", 1.0),
    ("seg", "s", 1.0),
    ("Std", "s", 3600.0),
    ("nT", "T", 1e-9),
    ("milligauss", "T", 1e-7),
];

/// Files of 50 samples of `a` and `b` at 100 Hz.
fn shapes() -> Vec<(&'static str, String)> {
    let of = |name, text: String| (name, text);
    let lvm = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nX_Columns\tOne\n***End_of_Header***\t\n\t\nChannels\t2\t\nSamples\t50\t50\nY_Unit_Label\tm\tm\n***End_of_Header***\t\t\nX_Value\ta\tb\tComment\n";
    vec![
        of("a file of LabVIEW", format!("{lvm}{}", plain("\t"))),
        of("a line that tells Excel the separator", format!("sep=;\ntime [s];a [m];b [m]\n{}", with_comma(";"))),
        of("units of an oscilloscope", format!("Time,a,b\n(s),(V),(mV)\n\n{}", plain(","))),
        of("units in words", format!("x-axis,a,b\nsecond,Volt,Volt\n{}", plain(","))),
        of("units in a third line", format!("time,a,b\nclock,left arm,right arm\ns,m,m\n{}", plain(","))),
        of(
            "keys and values above",
            format!("Sample rate: 100 Hz\nOperator: K. M.\nDevice: D7\n\ntime,a,b\n{}", plain(",")),
        ),
        of(
            "keys and values in two cells",
            format!("Device,D7\nSerial,00123\nRate,100\ntime [s],a [m],b [m]\n{}", plain(",")),
        ),
        of("groups above names", format!(",IMU,IMU\ntime,a,b\n{}", plain(","))),
        of(
            "leading blanks",
            format!("  time        a        b\n{}", rows(|_, t, a, b| format!("  {t:6.2} {a:9.5} {b:9.5}"))),
        ),
        of("blank behind a semicolon", format!("time [s]; a [m]; b [m]\n{}", plain("; "))),
        of("tab at the end", format!("time\ta\tb\t\n{}", plain("\t").replace('\n', "\t\n"))),
        of("returns alone", format!("time [s],a [m],b [m]\n{}", plain(",")).replace('\n', "\r")),
        of("names in single quotes", format!("'time';'a';'b'\n{}", with_comma(";"))),
        of(
            "a sample number and a clock",
            format!("Sample,Time [s],a [m],b [m]\n{}", rows(|k, t, a, b| format!("{k},{t:.2},{a:.5},{b:.5}"))),
        ),
        of(
            "an empty column",
            format!("time [s],a [m],,b [m]\n{}", rows(|_, t, a, b| format!("{t:.2},{a:.5},,{b:.5}"))),
        ),
        of(
            "a column of words",
            format!(
                "time [s],a [m],enabled,b [m]\n{}",
                rows(|k, t, a, b| format!("{t:.2},{a:.5},{},{b:.5}", if k % 2 == 0 { "true" } else { "false" }))
            ),
        ),
        of(
            "remarks between rows",
            format!(
                "time [s],a [m],b [m]\n{}",
                rows(|k, t, a, b| format!("{}{t:.2},{a:.5},{b:.5}", if k == 20 { "# marker 1\n" } else { "" }))
            ),
        ),
        of(
            "exponents with a comma",
            format!("time;a;b\n{}", rows(|_, t, a, b| format!("{t:.4E};{a:.5E};{b:.5E}").replace('.', ","))),
        ),
        of(
            "exponents with three digits",
            format!("time,a,b\n{}", rows(|_, t, a, b| format!("{t:.2}E+000,{a:.5}E+000,{b:.5}E+000"))),
        ),
        of("zeros behind the end", format!("time [s],a [m],b [m]\n{}{}", plain(","), "\0".repeat(512))),
        of(
            "before a trigger",
            format!("time [s],a [m],b [m]\n{}", rows(|_, t, a, b| format!("{:.2},{a:.5},{b:.5}", t - 0.2))),
        ),
        of(
            "stamps of America",
            format!("Time,a,b\n{}", rows(|_, t, a, b| format!("4/17/2025 5:00:{:05.2} PM,{a:.5},{b:.5}", t + 3.0))),
        ),
        of(
            "stamps of MATLAB",
            format!("Time,a,b\n{}", rows(|_, t, a, b| format!("17-Apr-2025 17:00:{t:05.2},{a:.5},{b:.5}"))),
        ),
        of(
            "stamps of ISO without signs",
            format!("time,a,b\n{}", rows(|_, t, a, b| format!("20250417T1700{t:05.2}Z,{a:.5},{b:.5}"))),
        ),
        of(
            "stamps of Japan",
            format!("時刻,a,b\n{}", rows(|_, t, a, b| format!("2025/04/17 17:00:{t:05.2},{a:.5},{b:.5}"))),
        ),
        of("minutes and seconds", format!("Time,a,b\n{}", rows(|_, t, a, b| format!("00:{t:05.2},{a:.5},{b:.5}")))),
        of(
            "time of day with a comma",
            format!("Uhrzeit;a;b\n{}", rows(|_, t, a, b| format!("17:00:{t:05.2};{a:.5};{b:.5}").replace('.', ","))),
        ),
        of(
            "date, time and a comma",
            format!(
                "Datum;Uhrzeit;a;b\n{}",
                rows(|_, t, a, b| format!("17.04.2025;17:00:{:05.2};{:.5};{:.5}", t, a, b))
                    .replace(";0.", ";0,")
                    .replace(";-0.", ";-0,")
                    .replace(";1.", ";1,")
            ),
        ),
        of(
            "seconds since 1970 with decimals",
            format!("timestamp,a,b\n{}", rows(|_, t, a, b| format!("{:.2},{a:.5},{b:.5}", 1_744_909_200.0 + t))),
        ),
        of(
            "errors of Excel",
            format!(
                "time [s],a [m],b [m],c [m]\n{}",
                rows(|k, t, a, b| format!("{t:.2},{a:.5},{b:.5},{}", if k == 7 { "#DIV/0!" } else { "1" }))
            ),
        ),
        of("units behind an underscore", format!("time_s,a_m,b_m\n{}", plain(","))),
        of("units behind a comma in quotes", format!("\"time, s\",\"a, m\",\"b, m\"\n{}", plain(","))),
    ]
}

#[test]
fn clocks_of_other_loggers_are_known() {
    let is_known = |name: &&&str| {
        let text = format!("\"{name}\";a [m];b [m]\n{}", plain(";"));
        recording::read_with(&file("own_clock.csv", &text), &Intake::default())
            .and_then(recording::series)
            .is_ok_and(|set| set.recording.channels[0].value.len() == 50)
    };
    let refused: Vec<_> = CLOCKS.iter().filter(|name| !is_known(name)).collect();
    println!("own clocks: {} of {} known, not {refused:?}", CLOCKS.len() - refused.len(), CLOCKS.len());
    assert!(20 * refused.len() <= CLOCKS.len(), "{refused:?}");
}

#[test]
fn units_of_other_loggers_are_known_and_convert_by_their_definitions() {
    let mut refused = Vec::new();
    for (spelling, si, one) in UNITS {
        let Some(unit) = recording::units::unit_named(spelling) else {
            refused.push(spelling);
            continue;
        };
        assert_eq!(unit.si, *si, "{spelling}");
        let found = unit.to_si(1.0);
        assert!(one.is_nan() || (found / one - 1.0).abs() < 1e-12, "{spelling}: {found} is not {one}");
    }
    println!("own units: {} of {} known, not {refused:?}", UNITS.len() - refused.len(), UNITS.len());
    assert!(20 * refused.len() <= UNITS.len(), "{refused:?}");
}

#[test]
fn shapes_of_other_loggers_are_read_as_what_they_mean() {
    let shapes = shapes();
    let mut refused = Vec::new();
    for (name, text) in &shapes {
        let path = file(&format!("own_{}.csv", name.replace(' ', "_")), text);
        match recording::read_with(&path, &Intake::default()).and_then(recording::series) {
            Ok(set) => {
                let of = |own: &str| set.recording.channels.iter().find(|channel| channel.name == own);
                let (Some(a), Some(b)) = (of("a"), of("b")) else {
                    refused.push((
                        name,
                        format!("{:?}", set.recording.channels.iter().map(|c| &c.name).collect::<Vec<_>>()),
                    ));
                    continue;
                };
                let is_right = [a, b].iter().all(|channel| {
                    channel.value.len() == 50 && (channel.interval_s().unwrap_or(0.0) - 0.01).abs() < 1e-6
                });
                if !is_right || a.value[0] != 0.0 {
                    refused.push((name, format!("{} samples of {:?} s", a.value.len(), a.interval_s())));
                }
            }
            Err(error) => refused.push((name, error.explain())),
        }
    }
    println!("own shapes: {} of {} read", shapes.len() - refused.len(), shapes.len());
    // `a_m` may be a measured a as well as metres: the file is read, the unit is asked for
    assert!(20 * refused.len() <= shapes.len(), "{refused:#?}");
}
