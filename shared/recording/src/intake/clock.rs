//! The clock of a recording: which column holds the times, and in what unit.

use super::day_counts;
use crate::error::RecordingError;
use crate::units::{Unit, unit_named};

/// The column of times as the user names it.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeColumn {
    /// Name in the file or number of the column from 1; [`TimeColumn::ROWS`] where rows follow each
    /// other at a constant rate and the file has no clock.
    pub name: String,
    /// Unit of its numbers, to s; `None` where the file states it.
    pub unit: Option<Unit>,
}

impl TimeColumn {
    /// Name that stands for the number of the row.
    pub const ROWS: &'static str = "row";

    /// `NAME`, `NAME:unit`, `NAME:100Hz` (a counter at that rate) or `row:100Hz`.
    ///
    /// # Errors
    /// An empty name, rows without a rate.
    pub fn parse(text: &str) -> Result<Self, RecordingError> {
        let bad = |found: &str| RecordingError::BadOption {
            said: format!("--time-column {text}"),
            found: found.into(),
            cure: "write NAME:unit, as in --time-column stamp:us, counter:100Hz, or row:100Hz where there is no clock"
                .into(),
        };
        let (name, unit) = match text.rsplit_once(':') {
            Some((name, unit)) if unit_of_clock(unit).is_some() => (name, unit_of_clock(unit)),
            Some((_, unit)) if unit_named(unit).is_some() || unit.is_empty() => {
                return Err(bad("the unit is not one of time"));
            }
            _ => (text, None),
        };
        let name = name.trim();
        if name.is_empty() || (name == Self::ROWS && unit.is_none()) {
            return Err(bad(if name.is_empty() { "the name is empty" } else { "rows need a rate" }));
        }
        Ok(TimeColumn { name: name.into(), unit })
    }
}

/// Unit of a clock: of time, or what a count is worth (`100Hz`, `0.01s`).
pub(crate) fn unit_of_clock(text: &str) -> Option<Unit> {
    let text = text.trim();
    let digits =
        text.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | 'e' | 'E' | '-' | '+'))).unwrap_or(text.len());
    let unit = unit_named(&text[digits..])?;
    if digits == 0 {
        return (unit.si == "s").then_some(unit);
    }
    let count = unit.to_si(text[..digits].parse().ok()?);
    let (multiply, divide) = match unit.si {
        "s" => (count, 1.0),
        "Hz" => (1.0, count),
        _ => return None,
    };
    (count.is_finite() && count > 0.0).then(|| Unit::scaled("s", multiply, divide))
}

/// How much a name speaks for a column of times, least first; `None`: it is another
/// channel's.
pub(crate) fn rank(name: &str) -> Option<u8> {
    let plain = words_of(name);
    let words: Vec<&str> = plain.split(' ').collect();
    match words.join(" ").as_str() {
        "time" | "t" | "zeit" | "temps" | "tiempo" => Some(0),
        "elapsed time" | "timestamps" | "time stamp" | "ts" | "datetime" | "date time" | "date and time"
        | "time elapsed" | "seconds elapsed" | "epoch" | "utc" | "unixtime" | "rostime" | "simtime" | "systime" => {
            Some(1)
        }
        "header stamp" | "field header stamp" | "rosbagtimestamp" | "timestamp sample" | "x value" => Some(2),
        word if COUNTED.contains(&word) => Some(4),
        _ if day_counts::is_named(name) => Some(3),
        word if TIMES.contains(&word) || unit_named(word).is_some_and(|unit| is_of_seconds(word, unit)) => Some(1),
        // `time us`, `sim time`, `log time s`: a time word, and units or qualifiers beside it
        _ => {
            let timed = |word: &&str| TIMES.contains(word);
            let beside = |word: &&str| QUALIFIERS.contains(word) || unit_named(word).is_some_and(|unit| unit.si == "s");
            let all = words.iter().all(|word| timed(word) || beside(word));
            // `Time - Voltage_0`, `Zeit  1 - Standardmessrate`
            let bare = |clock: &str| rank(clock.trim_end_matches(|c: char| c.is_ascii_digit())) == Some(0);
            let of_a_channel = name.split_once(" - ").is_some_and(|(clock, _)| bare(clock));
            ((all && words.iter().any(timed) && words.len() <= 4) || of_a_channel).then_some(3)
        }
    }
}

/// Nanoseconds of one count of a column that holds the parts of a second, by its name or unit.
pub(crate) fn part_of_second(name: &str, unit: Option<&str>) -> Option<i64> {
    let words = words_of(name);
    let last = words.rsplit(' ').next().unwrap_or_default();
    let is_of_time =
        |word: &str| word == last || matches!(word, "tv" | "stamp" | "header" | "time" | "t" | "field" | "timestamp");
    if !words.split(' ').all(is_of_time) {
        return None;
    }
    let named = unit.and_then(unit_named).or_else(|| unit_named(last)).filter(|unit| unit.si == "s");
    let ns = named.map(|unit| (unit.to_si(1.0) * 1e9).round() as i64);
    let by_word = match last {
        "nano" | "nanosec" | "nanosecs" | "nsec" | "nsecs" | "nanos" | "nanoseconds" => Some(1),
        "microsec" | "microsecs" | "usec" | "usecs" | "micros" | "microseconds" => Some(1000),
        "millisec" | "msec" | "msecs" | "millis" | "milliseconds" => Some(1_000_000),
        _ => None,
    };
    by_word.or(ns).filter(|ns| (1..=1_000_000).contains(ns))
}

/// Whether a word for time is among those of a name.
pub(crate) fn has_word(name: &str) -> bool {
    words_of(name).split(' ').any(|word| TIMES.contains(&word)) || day_counts::is_named(name)
}

/// Whether a name says that a column has the time since the row before, as `dt_us` does.
pub(crate) fn is_of_steps(name: &str) -> bool {
    let words = words_of(name);
    let bare = match words.rsplit_once(' ') {
        Some((bare, last)) if unit_named(last).is_some_and(|unit| unit.si == "s") && last != "t" => bare,
        _ => &words,
    };
    matches!(
        bare,
        "dt" | "delta t"
            | "d t"
            | "delta time"
            | "time delta"
            | "timedelta"
            | "deltat"
            | "time step"
            | "timestep"
            | "time diff"
            | "time difference"
            | "diff time"
            | "interval"
            | "time interval"
            | "sample interval"
            | "time since last"
            | "time since last sample"
            | "since last"
    )
}

/// Words that are a unit of time below a second and nothing else: a column called so counts it.
const COUNTED: &[&str] = &[
    "millis",
    "msec",
    "msecs",
    "millisecond",
    "milliseconds",
    "micros",
    "usec",
    "usecs",
    "microsecond",
    "microseconds",
    "nanos",
    "nsec",
    "nsecs",
    "nanosecond",
    "nanoseconds",
];

/// A word that names seconds in full, and nothing shorter than `sec`.
fn is_of_seconds(word: &str, unit: Unit) -> bool {
    unit.si == "s" && unit.to_si(1.0) == 1.0 && word.chars().count() > 2
}

/// Words for the time of a row.
const TIMES: &[&str] = &[
    "time",
    "t",
    "timestamp",
    "stamp",
    "elapsed",
    "uptime",
    "clock",
    "zeit",
    "zeitstempel",
    "messzeit",
    "laufzeit",
    "uhrzeit",
    "temps",
    "horodatage",
    "tiempo",
    "tempo",
    "tid",
    "tijd",
    "aika",
    "czas",
    "čas",
    "idő",
    "zaman",
    "время",
    "时间",
    "时刻",
    "時間",
    "時刻",
    "시간",
];

/// The words of a name in small letters, one blank between them: `logTime_us`, `TimeUS`.
pub(crate) fn words_of(name: &str) -> String {
    let mut plain = String::new();
    let mut small = false;
    for c in name.chars() {
        if (c.is_uppercase() && small) || !c.is_alphanumeric() {
            plain.push(' ');
        }
        small = c.is_lowercase();
        if c.is_alphanumeric() {
            plain.extend(c.to_lowercase());
        }
    }
    plain.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The unit that the name of a clock ends in: `t_s`, `TimeUS`, `stamp_ns`; a name may be one alone,
/// `seconds`.
pub(crate) fn ending(name: &str) -> Option<Unit> {
    let plain = words_of(name);
    let unit = |word| {
        let word = match word {
            "milli" => "ms",
            "micro" => "us",
            "nano" => "ns",
            word => word,
        };
        unit_named(word).filter(|unit| unit.si == "s")
    };
    match plain.rsplit_once(' ') {
        Some((_, last)) => unit(last),
        None => unit(&plain).filter(|unit| is_of_seconds(&plain, *unit) || COUNTED.contains(&plain.as_str())),
    }
}

/// The unit of a column whose name is a unit of time of a minute or more and nothing else: `min`.
pub(crate) fn long_unit(name: &str) -> Option<Unit> {
    unit_named(&words_of(name)).filter(|unit| unit.si == "s" && unit.to_si(1.0) >= 60.0)
}

const QUALIFIERS: &[&str] = &[
    "sim",
    "simulation",
    "log",
    "logging",
    "sample",
    "sampling",
    "system",
    "sys",
    "local",
    "utc",
    "gps",
    "unix",
    "epoch",
    "boot",
    "relative",
    "rel",
    "abs",
    "absolute",
    "mission",
    "elapsed",
    "test",
    "run",
    "header",
    "ros",
    "recv",
    "receive",
    "received",
    "since",
    "start",
    "of",
    "day",
    "monotonic",
    "device",
    "host",
    "measurement",
    "meas",
    "x",
    "date",
    "wall",
    "met",
    "field",
    "msg",
    "secs",
    "float",
    "stamp",
    "total",
    "running",
    "session",
    "record",
    "recording",
    "rosbag",
    "bag",
    "écoulé",
    "ecoule",
    "transcurrido",
    "relativ",
    "relativa",
    "offset",
];

/// Stamps of these years tell their unit by their size [s since 1970]: 2000 to 2100.
pub(crate) const EPOCH_S: core::ops::Range<f64> = 946_684_800.0..4_102_444_800.0;
