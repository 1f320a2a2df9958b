//! Texts of other programs that are no tables, known by their first lines.

use super::motion_capture::motion_capture;
use crate::intake::clock::rank;
use crate::intake::names::heading;

/// What a text is, and what to export instead.
pub(crate) struct Foreign {
    pub what: &'static str,
    pub cure: &'static str,
}

/// How many lines are looked at.
const LINES: usize = 40;

/// What the text is that begins with these lines; `None` of what may be a table.
pub(crate) fn foreign(ahead: &[(u64, String)]) -> Option<Foreign> {
    let lines: Vec<&str> = ahead.iter().take(LINES).map(|(_, text)| text.trim()).collect();
    let most = |is: &dyn Fn(&str) -> bool| 10 * lines.iter().filter(|line| is(line)).count() >= 8 * lines.len().max(1);
    let first = |is: &dyn Fn(&str) -> bool| lines.first().is_some_and(|line| is(line));
    let any = |is: &dyn Fn(&str) -> bool| lines.iter().any(|line| is(line));
    let kinds: [(bool, &'static str, &'static str); 13] = [
        (
            most(&is_toml) && any(&|line| line.starts_with('[') || line.contains(" = \"")),
            "a TOML file, as plant files and maps are",
            "give a recording here, and this file as --plant FILE or --map FILE",
        ),
        (
            any(&is_ardupilot),
            "an ArduPilot log as text, with messages of many kinds",
            "export one message as CSV, as mavlogdump.py --format csv --types IMU does",
        ),
        (
            most(&is_mavlogdump),
            "a listing of mavlogdump.py, with a message in each line",
            "run mavlogdump.py --format csv --types IMU, or give the log as MCAP or ULog",
        ),
        (
            most(&is_line_protocol),
            "line protocol of InfluxDB",
            "export the query as CSV, with columns _time, _field and _value",
        ),
        (
            most(&is_candump),
            "a listing of CAN frames by candump",
            "decode it with its DBC into a CSV of signals, as cantools decode or asammdf do",
        ),
        (
            any(&|line| line.starts_with("base hex") || line.starts_with("base dec")),
            "CAN frames in Vector's ASC",
            "decode it with its DBC into a CSV of signals, as asammdf does",
        ),
        (most(&is_nmea), "sentences of NMEA 0183", "decode them into a CSV with a column for each quantity"),
        (
            any(&|line| line == "---") && most(&is_yaml),
            "a listing of messages as YAML, as `ros2 topic echo` prints them",
            "record a bag (ros2 bag record), or print with ros2 topic echo --csv and add a header",
        ),
        (
            most(&is_pairs) && !are_alike(&lines),
            "keys and values in each line, not the same in every line",
            "write a row of numbers for each time below one row of names",
        ),
        (
            first(&is_vicon) && motion_capture(ahead).is_none(),
            "an export of Vicon with a table for each kind of data and no times",
            "export one table as CSV with one row of names, `name [unit]`, and a column `time [s]`",
        ),
        (
            first(&|line| line.starts_with("Format Version,") && line.contains("Frame Rate"))
                && motion_capture(ahead).is_none(),
            "an export of OptiTrack with names in several rows",
            "keep one row of names, `name [unit]`, with the column `Time (Seconds)`",
        ),
        (
            lines.len() == ahead.len() && are_rows_of_channels(&lines),
            "a table with a channel in each row and its name in front",
            "turn it: in Python `pandas.read_csv(IN, header=None, index_col=0).T.to_csv(OUT, index=False)`",
        ),
        (first(&|line| line.starts_with("<?xml") || line.starts_with("<html")), "XML", "export a table as CSV"),
    ];
    kinds.into_iter().find(|(is, ..)| *is).map(|(_, what, cure)| Foreign { what, cure })
}

/// `[[body]]`, `mass = "2 kg"`, `# a remark`
fn is_toml(line: &str) -> bool {
    let is_key = |key: &str| {
        !key.is_empty() && key.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | '"' | ':'))
    };
    line.starts_with('#')
        || (line.starts_with('[') && line.contains(']') && !line.contains(','))
        || line.split_once(" = ").is_some_and(|(key, value)| is_key(key.trim()) && !value.is_empty())
}

fn is_ardupilot(line: &str) -> bool {
    line.starts_with("FMT, ") && line.split(',').count() > 4
}

/// `2024-03-05 14:59:58.00: IMU {TimeUS : 5000000, GyrX : 0.001}`
fn is_mavlogdump(line: &str) -> bool {
    line.ends_with('}') && line.contains(" {") && line.contains(" : ")
}

/// `imu,host=a gyro_z=0.1,torque=1 1709650798000000000`
fn is_line_protocol(line: &str) -> bool {
    let words: Vec<&str> = line.split(' ').collect();
    let [of, fields, stamp] = words[..] else { return false };
    let are_fields = fields.split(',').all(|field| field.contains('='));
    are_fields && !of.is_empty() && stamp.len() >= 10 && stamp.bytes().all(|byte| byte.is_ascii_digit())
}

/// `(1709650798.000000) can0 1A0#0001020304050607`
fn is_candump(line: &str) -> bool {
    line.starts_with('(')
        && line.contains(") ")
        && line.split_whitespace().last().is_some_and(|frame| frame.contains('#'))
}

/// `$GPGGA,123519,…*47`
fn is_nmea(line: &str) -> bool {
    line.starts_with(['$', '!']) && line.len() > 9 && line.get(line.len() - 3..).is_some_and(|end| end.starts_with('*'))
}

fn is_yaml(line: &str) -> bool {
    line == "---"
        || line.starts_with("- ")
        || line.split_once(':').is_some_and(|(key, value)| {
            key.chars().all(|c| c.is_alphanumeric() || c == '_') && (value.is_empty() || value.starts_with(' '))
        })
}

/// `t=0.01 gyro_z=0.3 torque=-0.1`
fn is_pairs(line: &str) -> bool {
    let words = || line.split([' ', ',', ';', '\t']).filter(|word| !word.is_empty());
    let is_pair = |word: &str| word.split_once('=').is_some_and(|(key, value)| !key.is_empty() && !value.is_empty());
    words().count() > 1 && words().all(is_pair)
}

/// Whether the keys of the last lines are the same.
fn are_alike(lines: &[&str]) -> bool {
    let keys = |line: &str| -> Vec<String> {
        let words = line.split([' ', ',', ';', '\t']).filter(|word| !word.is_empty());
        words.map(|word| word.split('=').next().unwrap_or_default().to_owned()).collect()
    };
    let behind_first = lines.get(1..).unwrap_or_default();
    behind_first.windows(2).all(|pair| keys(pair[0]) == keys(pair[1]))
}

/// `time,0,0.01,0.02,…` above `torque,1.5,1.6,1.7,…`
fn are_rows_of_channels(lines: &[&str]) -> bool {
    const SAMPLES_MIN: usize = 8;
    let divided = |line: &&str| -> Option<(String, usize)> {
        let mut cells = line.split([',', ';', '\t']).map(str::trim).filter(|cell| !cell.is_empty());
        let name = cells.next().filter(|name| name.parse::<f64>().is_err())?;
        let samples: Option<Vec<f64>> = cells.map(|cell| cell.parse().ok()).collect();
        Some((heading(name).name, samples?.len()))
    };
    let Some(rows) = lines.iter().map(divided).collect::<Option<Vec<_>>>() else { return false };
    let clocks = rows.iter().filter(|(name, _)| rank(name).is_some()).count();
    let alike = rows.iter().all(|(_, samples)| *samples >= SAMPLES_MIN && *samples == rows[0].1);
    rows.len() > 1 && clocks == 1 && alike
}

fn is_vicon(line: &str) -> bool {
    let name = line.trim_end_matches(',').trim();
    matches!(name, "Trajectories" | "Devices" | "Joints" | "Model Outputs" | "Segments" | "Bones" | "Events")
}
