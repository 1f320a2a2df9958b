//! The time between two rows as the lines above them state it: `Sample Interval,1e-02`,
//! `# Sample rate: 100 Hz`, `XInc:,1.0E-02`, `tInc = 1e-6`, a column `Increment` beside the rows.

use super::dialect::Dialect;
use super::header::unmarked;
use super::number::number;
use super::quantity::quantity;
use crate::intake::names::heading;
use crate::text::printable;
use crate::units::{Unit, unit_named};

/// The time between two rows, and where it is stated.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Interval {
    pub seconds: f64,
    /// As the file states it, for a note.
    pub stated: String,
    /// Position of the key in its line.
    pub at: usize,
    /// The whole number that is stated without a unit, where it may be milliseconds as well.
    pub without_unit: Option<u64>,
}

/// What a key says of its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Says {
    Interval,
    Rate,
}

/// What the lines above the rows say; `None` where they say nothing, or two things.
pub(super) fn stated_interval(above: &[(u64, String)], dialect: Dialect) -> Option<Interval> {
    let lines: Vec<(u64, Vec<String>)> =
        above.iter().map(|(line, text)| (*line, dialect.split_quoted(unmarked(text)))).collect();
    let mut found: Vec<Interval> = Vec::new();
    for (at, (line, cells)) in lines.iter().enumerate() {
        let below = lines.get(at + 1).map(|(_, cells)| cells);
        let whole = heading_and_value(unmarked(&above[at].1)).filter(|_| cells.len() == 1 || dialect.separator == b' ');
        let pairs = cells.iter().enumerate().filter_map(|(k, cell)| Some((k, pair(cells, k, cell, below)?)));
        let pairs = pairs.chain(whole.map(|pair| (0, pair)));
        found.extend(pairs.filter_map(|(at, (key, value))| interval(*line, at, &key, &value, dialect)));
    }
    let first = found.first()?.clone();
    let alike = |other: &Interval| (other.seconds / first.seconds - 1.0).abs() < 1e-6;
    found.iter().all(alike).then_some(first)
}

/// Key and value of a cell: within it, in the next cell that is not empty, or in the one below.
fn pair(cells: &[String], k: usize, cell: &str, below: Option<&Vec<String>>) -> Option<(String, String)> {
    if let Some(pair) = heading_and_value(cell) {
        return Some(pair);
    }
    says(cell)?;
    let starts_a_number = |value: &&String| value.contains(|c: char| c.is_ascii_digit());
    let next = (k + 1..cells.len()).find(|at| !cells[*at].trim().is_empty());
    if let Some(at) = next.filter(|at| starts_a_number(&&cells[*at])) {
        // `Sample Rate,1,kHz`
        let unit = cells.get(at + 1).filter(|unit| unit_of_ending(unit).is_some()).map_or("", String::as_str);
        return Some((cell.to_owned(), format!("{} {unit}", cells[at]).trim().to_owned()));
    }
    Some((cell.to_owned(), below?.get(k).filter(starts_a_number)?.clone()))
}

/// `key: value` and `key = value`.
fn heading_and_value(text: &str) -> Option<(String, String)> {
    // `Recording rate 100 Hz`
    let by_number = || text.find(|c: char| c.is_ascii_digit()).map(|at| text.split_at(at));
    let (key, value) = text.split_once(['=', ':']).or_else(by_number)?;
    (says(key).is_some() && !value.trim().is_empty()).then(|| (key.trim().to_owned(), value.trim().to_owned()))
}

fn interval(line: u64, at: usize, key: &str, value: &str, dialect: Dialect) -> Option<Interval> {
    let says = says(key)?;
    // `Analog:0.01`
    let text = value.rsplit_once(':').map_or(value, |(_, value)| value).trim();
    let of_samples = OF_SAMPLES.iter().find_map(|unit| text.strip_suffix(unit));
    let text = of_samples.map_or_else(|| text.to_owned(), |value| format!("{value}Hz"));
    let text = text.as_str();
    let stated = quantity(text, dialect.signs);
    let number = number(text, dialect.signs).or(stated.map(|stated| stated.value))?;
    let ending =
        || key.rsplit_once('_').filter(|(_, unit)| unit_of_ending(unit).is_some()).map(|(_, unit)| unit.into());
    let unit = stated.map(|stated| stated.unit.to_owned()).or_else(|| heading(key).unit).or_else(ending);
    let open = unit.is_none() && says == Says::Interval && !is_of_instruments(key);
    if unit.is_none() && needs_unit(key) {
        return None;
    }
    let without_unit = text.parse().ok().filter(|whole| open && *whole > 0);
    let unit =
        unit.as_deref().and_then(unit_named).or_else(|| unit_named(if says == Says::Rate { "Hz" } else { "s" }))?;
    let seconds = seconds(number, unit)?;
    let stated = format!("line {line}: `{} {}`", printable(key), printable(value));
    Some(Interval { seconds, stated, at, without_unit })
}

/// Rates by what is counted.
const OF_SAMPLES: &[&str] = &[
    "samples/sec",
    "samples/s",
    "Samples/s",
    "samples per second",
    "scans/sec",
    "scans/s",
    "points/s",
    "pts/s",
    "Sa/s",
    "S/s",
];

/// Keys that name an interval or a rate where a unit says so alone.
const WITH_UNIT: &[&str] = &[
    "sampling",
    "rate",
    "period",
    "periode",
    "messrate",
    "odr",
    "outputdatarate",
    "outputrate",
    "cadence",
    "cadencia",
];

fn needs_unit(key: &str) -> bool {
    WITH_UNIT.contains(&plain(&heading(key.trim()).name).as_str())
}

fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// Whether instruments alone write a key: in seconds, whatever the number.
fn is_of_instruments(key: &str) -> bool {
    let letters = plain(key);
    ["xinc", "tinc", "deltax", "dx", "wfincrement", "waveformincrement", "increment", "deltat"]
        .iter()
        .any(|word| letters.starts_with(word))
}

fn seconds(number: f64, unit: Unit) -> Option<f64> {
    let value = unit.to_si(number);
    let seconds = match unit.si {
        "s" => value,
        "Hz" | "1/s" => 1.0 / value,
        _ => return None,
    };
    (seconds.is_finite() && seconds > 0.0).then_some(seconds)
}

/// The unit in which a key ends, one of time or of rates.
fn unit_of_ending(text: &str) -> Option<Unit> {
    unit_named(text.trim()).filter(|unit| matches!(unit.si, "s" | "Hz" | "1/s"))
}

/// Whether a key names the time between two samples, or their rate.
fn says(key: &str) -> Option<Says> {
    let name = heading(key.trim().trim_end_matches([':', '='])).name;
    let name = name.split(['[', '(']).next().unwrap_or_default();
    let plain = plain(name);
    // `sample_rate_hz`
    let of_unit = name.rsplit_once('_').filter(|(_, unit)| unit_of_ending(unit).is_some());
    if let Some(says) = of_unit.and_then(|(name, _)| says(name)) {
        return Some(says);
    }
    if plain.chars().count() > 40 {
        return None;
    }
    let is_of = |words: &[&str]| words.iter().any(|word| plain == *word || (word.len() > 8 && plain.ends_with(word)));
    if is_of(INTERVALS) || name.trim() == "Ts" {
        Some(Says::Interval)
    } else if is_of(RATES) || WITH_UNIT.contains(&plain.as_str()) {
        Some(Says::Rate)
    } else {
        None
    }
}

const INTERVALS: &[&str] = &[
    "interval",
    "increment",
    "xinc",
    "xincr",
    "xincrement",
    "tinc",
    "tincr",
    "timeincrement",
    "timestep",
    "timeinterval",
    "dt",
    "dx",
    "deltax",
    "deltat",
    "wfincrement",
    "waveformincrement",
    "sampleinterval",
    "samplinginterval",
    "sampleperiod",
    "samplingperiod",
    "sampletime",
    "samplingtime",
    "scaninterval",
    "loginterval",
    "logginginterval",
    "recordinginterval",
    "abtastintervall",
    "abtastzeit",
];

const RATES: &[&str] = &[
    "fs",
    "samplespersecond",
    "samplerate",
    "samplesrate",
    "samplingrate",
    "samplefrequency",
    "samplingfrequency",
    "samplefreq",
    "samplingfreq",
    "updaterate",
    "acquisitionrate",
    "acquisitionfrequency",
    "frequencyofacquisition",
    "fréquencedacquisition",
    "frequencedacquisition",
    "fréquencedéchantillonnage",
    "frequencedechantillonnage",
    "frecuenciademuestreo",
    "frequenzadicampionamento",
    "frequênciadeamostragem",
    "частотадискретизации",
    "采样频率",
    "采样率",
    "datarate",
    "framerate",
    "scanrate",
    "lograte",
    "loggingrate",
    "recordingrate",
    "abtastrate",
    "abtastfrequenz",
];
