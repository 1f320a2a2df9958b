//! One recording by many clocks: what `obsid diagnose` answers does not depend on how its times are
//! written.

use crate::desk::Folder;
use serde_json::Value;
use std::fmt::Write;

/// Duration of the recording [s] and effort of a diagnosis.
const DURATION_S: &str = "2";
const EFFORT: &str = "quick";
/// Part of a parameter, of its standard deviation and of a fit by which answers may differ: a stamp
/// in the afternoon is a double of 7 ps, one in minutes has twelve decimals.
const ROUNDING: f64 = 1e-4;

/// A recording as text: of times [s] and angles [rad].
type Written = fn(&[(f64, f64)]) -> String;

/// Names of the clocks, and the file of a recording with each.
const CLOCKS: [(&str, Written); 13] = [
    ("milliseconds", |rows| column("t_ms", rows, |t| format!("{:.0}", t * 1e3))),
    ("nanoseconds since 1970", |rows| column("timestamp", rows, |t| format!("{}", 1_709_650_798_000_000_000 + ns(t)))),
    ("seconds since 1970", |rows| column("time", rows, |t| format!("{:.2}", 1_709_650_798.0 + t))),
    ("ISO 8601", |rows| column("time", rows, |t| format!("2024-03-05T14:59:{:06.3}Z", 50.0 + t))),
    ("time of day", |rows| {
        format!("Date: 2024-03-05\n{}", column("time", rows, |t| format!("14:59:{:06.3}", 50.0 + t)))
    }),
    ("ISO durations", |rows| column("elapsed", rows, |t| format!("PT{t:.2}S"))),
    (".NET ticks", |rows| column("Ticks", rows, |t| format!("{}", 638_452_478_980_000_000 + ns(t) / 100))),
    ("Windows file times", |rows| column("timestamp", rows, |t| format!("{}", 133_541_246_980_000_000 + ns(t) / 100))),
    ("minutes", |rows| column("min", rows, |t| format!("{:.12}", t / 60.0))),
    ("hours", |rows| column("Hours", rows, |t| format!("{:.14}", t / 3600.0))),
    ("TwinCAT", |rows| {
        let above = "Name\tscope\n\nName\tangle\nData-Type\tREAL64\nSampleTime[ms]\t10\nUnit\trad\n\n";
        format!("{above}{}", joined(rows, |t, angle| format!("{:.0}\t{angle:.9}", t * 1e3)))
    }),
    ("MSR", |rows| {
        let above = "*CREATOR;MSR 6\n*STARTTIME;05.03.2024;15:04:58\n*TIMEDELTA;0.01;s\n*CHANNEL;TIME;angle\n*UNIT;SEC;rad\n*DATA\n";
        format!("{above}{}", joined(rows, |t, angle| format!("{t:.2};{angle:.9}")))
    }),
    ("rows at a rate", |rows| {
        format!("Cadence: 100 Hz\nangle [rad]\tspare [V]\n{}", joined(rows, |_, angle| format!("{angle:.9}\t1.5")))
    }),
];

/// Clocks of files that do not call the angle by its name and unit, and what the user says of it:
/// a terminal's stamps, and motion capture, whose channels are markers.
const SAID: [(&str, Written, &str); 3] = [
    (
        "time of day in brackets",
        |rows| {
            rows.iter().fold(String::new(), |mut text, (t, angle)| {
                writeln!(text, "[14:59:{:06.3}] angle={angle:.9}, spare=1", 50.0 + t).unwrap();
                text
            })
        },
        "angle = angle [rad]",
    ),
    (
        "Qualisys",
        |rows| {
            let above = format!(
                "NO_OF_FRAMES\t{}\nNO_OF_CAMERAS\t8\nFREQUENCY\t100\nDATA_INCLUDED\t3D\nMARKER_NAMES\ttip\nTRAJECTORY_TYPES\tMeasured\n",
                rows.len()
            );
            format!("{above}{}", joined(rows, |_, angle| format!("{angle:.9}\t1.5\t2.5")))
        },
        "angle = tip.x [rad]",
    ),
    (
        "trc",
        |rows| {
            let above = format!(
                "PathFileType\t4\t(X/Y/Z)\tswing.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n100\t100\t{}\t1\tmm\n\
             Frame#\tTime\ttip\t\t\t\n\t\tX1\tY1\tZ1\t\n\n",
                rows.len()
            );
            let mut frame = 0;
            let row = |t: f64, angle: f64| {
                frame += 1;
                format!("{frame}\t{t:.2}\t{angle:.9}\t1.5\t2.5")
            };
            format!("{above}{}", joined(rows, row))
        },
        "angle = tip.x [rad]",
    ),
];

fn ns(t: f64) -> u64 {
    (t * 1e9).round() as u64
}

fn joined(rows: &[(f64, f64)], mut row: impl FnMut(f64, f64) -> String) -> String {
    rows.iter().map(|(t, angle)| row(*t, *angle) + "\n").collect()
}

fn column(name: &str, rows: &[(f64, f64)], stamp: fn(f64) -> String) -> String {
    format!("{name},angle [rad]\n{}", joined(rows, |t, angle| format!("{},{angle:.9}", stamp(t))))
}

/// A swing with dry friction that the plant file lacks.
fn swing(folder: &Folder) -> Vec<(f64, f64)> {
    let hidden = "joint_coulomb@joint:pivot force=0.05";
    folder
        .ask(&["simulate", "pendulum", "--hide", hidden, "--duration", DURATION_S, "--seed", "3", "--out", "swing.csv"])
        .ends_with(0);
    let text = String::from_utf8(folder.bytes("swing.csv")).unwrap();
    let row = |line: &str| {
        let (time, angle) = line.split_once(',').unwrap();
        (time.parse().unwrap(), angle.parse().unwrap())
    };
    text.lines().skip(1).map(row).collect()
}

/// The answer to a recording as it is written: verdict, names, and what may differ by rounding.
fn answer(folder: &Folder, name: &str, text: &str, channel: Option<&str>) -> (String, Vec<f64>) {
    folder.file("clock.csv", text);
    let said = channel.iter().flat_map(|channel| ["--channel", channel]);
    let arguments =
        ["diagnose", "clock.csv", "--plant", "pendulum", "--effort", EFFORT, "--trust-labels", "--quiet", "--json"];
    let all: Vec<&str> = arguments.into_iter().chain(said).collect();
    let result = folder.ask(&all).ends_with(0).object();
    assert_eq!(result["recordings"][0]["rate_hz"].as_f64().map(f64::round), Some(100.0), "{name}: {result}");
    let effects = result["effects"].as_array().unwrap();
    let named = |effect: &Value| format!("{}@{}", effect["kind"], effect["site"]);
    let numbers = |effect: &Value| -> Vec<f64> {
        let parameters = effect["parameters"].as_array().unwrap();
        parameters.iter().flat_map(|own| [own["value"].as_f64().unwrap(), own["sigma"].as_f64().unwrap()]).collect()
    };
    let names: Vec<String> = effects.iter().map(named).collect();
    let fits = result["held_out"]["channels"].as_array().unwrap();
    let fits = fits.iter().map(|channel| channel["fit_percent_after"].as_f64().unwrap());
    (format!("{} {}", result["verdict"], names.join(", ")), effects.iter().flat_map(numbers).chain(fits).collect())
}

#[test]
fn the_answer_to_a_recording_does_not_depend_on_how_its_times_are_written() {
    let folder = Folder::new("clocks");
    let rows = swing(&folder);
    let seconds = column("time [s]", &rows, |t| format!("{t:.2}"));
    let (said, numbers) = answer(&folder, "seconds", &seconds, None);
    assert!(said.contains("joint_coulomb"), "{said}");
    let clocks = CLOCKS.iter().map(|(name, written)| (*name, *written, None));
    let said_of = SAID.iter().map(|(name, written, channel)| (*name, *written, Some(*channel)));
    for (name, written, channel) in clocks.chain(said_of) {
        let (other, others) = answer(&folder, name, &written(&rows), channel);
        assert_eq!(other, said, "{name}");
        for (own, number) in others.iter().zip(&numbers) {
            assert!((own - number).abs() <= ROUNDING * number.abs(), "{name}: {others:?}, in seconds {numbers:?}");
        }
    }
}
