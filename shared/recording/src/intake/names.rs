//! Headers of columns as programs write them: `name [unit]`, `name (unit)`, `name / unit`,
//! `name, unit`, `name_unit`.

use super::clock;
use super::quantities::{ending_of, in_view_of, is_unit_of};
use crate::units::unit_named;
use std::collections::HashMap;

/// A header divided.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Heading {
    /// Name without unit.
    pub name: String,
    /// Text of the unit, known or not, where one is stated.
    pub unit: Option<String>,
}

/// `name [unit]`; the text in the bracket at the end is the unit unless it is the index of an
/// array.
pub(crate) fn bracketed(text: &str) -> (&str, Option<&str>) {
    let text = text.trim();
    match text.strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) {
        Some((_, index)) if index.trim().bytes().all(|b| b.is_ascii_digit() || b == b',') && !index.is_empty() => {
            (text, None)
        }
        Some((name, unit)) => (name.trim(), Some(unit.trim())),
        None => (text, None),
    }
}

/// Name and unit of a header. A bracket states a unit, known or not; a parenthesis, a slash, a
/// comma and an ending state one where it is known and can be that of the name.
pub(crate) fn heading(text: &str) -> Heading {
    let Heading { name, unit } = divided(&cleaned(text));
    let unit = unit.map(|unit| in_view_of(&name, &unit));
    Heading { name, unit }
}

/// Headers of one table. Where several differ in the bracket alone and one of these is no unit,
/// none is: `Temp (in)`, `Temp (out)`. A letter at the end that several differ in is no unit
/// either.
pub(crate) fn headings<'a>(texts: impl Iterator<Item = &'a str>) -> Vec<Heading> {
    let texts: Vec<String> = texts.map(cleaned).collect();
    let mut labelled: HashMap<&str, (usize, bool)> = HashMap::new();
    for (name, word) in texts.iter().filter_map(|text| parted(text)) {
        let (count, has_label) = labelled.entry(name).or_default();
        *count += 1;
        *has_label |= word != "?" && (unit_named(&in_view_of(name, word)).is_none() || is_number(word));
    }
    let of_labels = |text: &str| {
        let (count, has_label) = parted(text).and_then(|(name, _)| labelled.get(name)).copied().unwrap_or_default();
        count > 1 && has_label
    };
    let mut lettered: HashMap<&str, usize> = HashMap::new();
    texts.iter().filter_map(|text| without_letter(text)).for_each(|stem| *lettered.entry(stem).or_default() += 1);
    let of_letters =
        |text: &str| without_letter(text).and_then(|stem| lettered.get(stem)).is_some_and(|count| *count > 1);
    let is_clock = |of: Heading| clock::rank(&of.name).is_some() && of.unit.is_some_and(|unit| unit == "s");
    let divided_by_slashes = texts.iter().filter_map(|text| slashed(text)).any(is_clock);
    let of = |text: &String| {
        let is_label = of_labels(text) || of_letters(text);
        let by_slash = slashed(text).filter(|_| divided_by_slashes);
        if is_label { Heading { name: text.clone(), unit: None } } else { by_slash.unwrap_or_else(|| heading(text)) }
    };
    texts.iter().map(of).collect()
}

/// `I/mA`: name and unit of a table whose clock is divided so, `time/s`.
fn slashed(text: &str) -> Option<Heading> {
    let (name, unit) = text.split_once('/').map(|(name, unit)| (name.trim(), unit.trim()))?;
    let is_unit = !unit.is_empty() && !is_number(unit) && unit_named(&in_view_of(name, unit)).is_some();
    let is_name = !name.is_empty() && !name.contains(['[', '(', ' ', ',']);
    (is_unit && is_name).then(|| Heading { name: name.into(), unit: Some(in_view_of(name, unit)) })
}

/// The name before a letter at its end: `temp` of `temp_C`, which `temp_A` makes a third sensor.
fn without_letter(text: &str) -> Option<&str> {
    let (stem, letter) = text.rsplit_once('_')?;
    (letter.chars().count() == 1).then_some(stem)
}

fn is_number(word: &str) -> bool {
    word.bytes().all(|byte| byte.is_ascii_digit())
}

/// Name and word in the bracket or parenthesis at the end.
fn parted(text: &str) -> Option<(&str, &str)> {
    let (name, word) = match bracketed(text) {
        (name, Some(unit)) => (name, unit),
        (_, None) => text.strip_suffix(')').and_then(parenthesised)?,
    };
    let simple = !word.is_empty() && word.chars().all(char::is_alphanumeric);
    (simple && !name.trim().is_empty()).then(|| (name.trim(), word.trim()))
}

/// Name and unit of a header without marks.
fn divided(text: &str) -> Heading {
    // `Rate / (rad/s)`
    let bare = |name: &str| name.trim().trim_end_matches(['/', ',']).trim().to_owned();
    let stated = |name: &str, unit: &str| Heading { name: bare(name), unit: Some(unit.trim().into()) };
    if let (name, Some(unit)) = bracketed(text) {
        return match unit {
            "?" => Heading { name: name.into(), unit: None },
            unit => stated(name, unit),
        };
    }
    let known = |unit: &str| !unit.trim().is_empty() && unit_named(unit).is_some();
    // `w [N·m] (filtered)`
    if let Some((name, unit, rest)) = in_the_middle(text).filter(|(_, unit, _)| known(unit) && !is_number(unit)) {
        return stated(&format!("{} {}", name.trim(), rest.trim()), unit);
    }
    if let Some((name, unit)) = text
        .strip_suffix(')')
        .and_then(parenthesised)
        .filter(|(name, unit)| (is_unit_of(name, unit) || is_since(unit)) && !name.trim().is_empty())
    {
        return stated(name, unit);
    }
    for separator in [" / ", ", ", " in "] {
        if let Some((name, unit)) = text.rsplit_once(separator).filter(|(_, unit)| known(unit)) {
            return stated(name, unit);
        }
    }
    // `in s`, the axis of an oscilloscope
    if let Some(unit) = text.strip_prefix("in ").filter(|unit| known(unit)) {
        return stated("", unit);
    }
    // `Rate,rad/s` in a file that no comma divides
    if let Some((name, unit)) = text.split_once(',').filter(|(name, unit)| known(unit) && !name.trim().is_empty()) {
        return stated(name, unit);
    }
    // `Temp °C`, `speed m/s`: a word with a sign of units
    let is_sign = |c: char| matches!(c, '°' | 'º' | '℃' | '/' | '%' | '²' | '·' | '^' | 'µ' | 'Ω');
    let of_signs = |(_, unit): &(&str, &str)| unit.contains(is_sign) && known(unit);
    if let Some((name, unit)) = text.rsplit_once(' ').filter(of_signs).filter(|(name, _)| !name.trim().is_empty()) {
        return stated(name, unit);
    }
    Heading { name: text.into(), unit: ending(text) }
}

/// Whether a text is a unit of time that names its zero: `ms since boot`.
fn is_since(text: &str) -> bool {
    text.split_once(" since ").and_then(|(unit, _)| unit_named(unit)).is_some_and(|unit| unit.si == "s")
}

/// `name [unit] rest` and `name (unit) rest`, cut at the bracket.
fn in_the_middle(text: &str) -> Option<(&str, &str, &str)> {
    let cut = |open, close, again| {
        let (name, behind): (&str, &str) = text.split_once(open)?;
        let (unit, rest) = behind.split_once(close)?;
        (!rest.trim().is_empty() && !rest.contains(['[', again])).then_some((name, unit, rest))
    };
    // one letter may be a label: `mode (A) speed`
    let is_unit = |name, unit: &str| is_unit_of(name, unit) && !is_number(unit) && (unit.len() > 1 || unit == "s");
    let rounded = || cut(" (", ") ", '(').filter(|(name, unit, _)| is_unit(name, unit));
    cut(" [", "] ", '[').or_else(rounded)
}

/// `name (unit` cut at the bracket that the end closes: `x (m/(s*N)` is `x` and `m/(s*N`.
fn parenthesised(rest: &str) -> Option<(&str, &str)> {
    let mut depth = 0;
    for (at, c) in rest.char_indices().rev() {
        match c {
            ')' => depth += 1,
            '(' if depth == 0 => return Some((&rest[..at], &rest[at + 1..])),
            '(' => depth -= 1,
            _ => {}
        }
    }
    None
}

/// Without byte-order mark, blanks, quotes and marks of comments.
pub(crate) fn cleaned(text: &str) -> String {
    let text = text.trim_start_matches('\u{feff}').trim().trim_matches(['"', '\'']).trim();
    text.trim_start_matches(['#', '%']).trim().to_owned()
}

/// The unit that a name ends in: `accel_m_s2`, `rate_deg_s`, `time_us`, `torque_Nm`,
/// `accelerometer_m_s2[0]`. One letter ends no name in a unit (`phase_A`, `x_m` for measured), and
/// `gyro_rad` does not say what it seems to: the quantity and the unit contradict each other.
fn ending(text: &str) -> Option<String> {
    let name = text.split_once('[').map_or(text, |(name, _)| name);
    let (stem, candidates) = endings(name)?;
    if let Some(unit) = candidates.last().and_then(|last| ending_of(name, last)) {
        return Some(unit.into());
    }
    let candidate = candidates.iter().find(|unit| SUFFIXES.contains(&unit.as_str()) || squared(unit))?;
    let known = unit_named(&spelled(candidate))?;
    let stem = stem.to_lowercase();
    let rate = ["gyro", "rate", "omega", "vel", "speed"].iter().any(|word| stem.contains(word));
    (!(rate && matches!(known.si, "rad" | "m"))).then(|| spelled(candidate))
}

/// The last one, two and three words of a name behind its first, longest first.
fn endings(name: &str) -> Option<(&str, Vec<String>)> {
    let words: Vec<&str> = name.split(['_', '.', '/']).collect();
    let of = |n: usize| (words.len() > n).then(|| words[words.len() - n..].join("_"));
    let all: Vec<String> = (1..=4).rev().filter_map(of).collect();
    (!all.is_empty()).then_some((name, all))
}

/// Endings that are units and nothing else.
const SUFFIXES: &[&str] = &[
    "us",
    "ms",
    "ns",
    "sec",
    "secs",
    "seconds",
    "usec",
    "msec",
    "nsec",
    "micros",
    "millis",
    "minutes",
    "hours",
    "m_s",
    "m_s2",
    "m_s_2",
    "mps",
    "mps2",
    "m_per_s",
    "m_per_s2",
    "rad",
    "rads",
    "deg",
    "degs",
    "rad_s",
    "rad_s2",
    "rads_s",
    "radps",
    "deg_s",
    "deg_s2",
    "degps",
    "rad_per_s",
    "rad_per_sec",
    "deg_per_s",
    "deg_per_sec",
    "rad_sec",
    "deg_sec",
    "dps",
    "rpm",
    "RPM",
    "Nm",
    "mNm",
    "kNm",
    "N_m",
    "kN",
    "mN",
    "kg",
    "mm",
    "cm",
    "km",
    "mm_s",
    "km_h",
    "kmh",
    "kph",
    "mph",
    "mrad",
    "mrad_s",
    "mV",
    "mA",
    "Pa",
    "kPa",
    "hPa",
    "MPa",
    "mbar",
    "degC",
    "deg_C",
    "Hz",
    "kHz",
    "ohm",
    "percent",
    "pct",
    "mg",
    "uT",
    "mT",
    "nT",
    "volts",
    "amps",
    "meters",
    "radians",
    "degrees",
    "newton",
    "newtons",
];

fn squared(unit: &str) -> bool {
    matches!(unit, "m_s^2" | "rad_s^2" | "deg_s^2" | "m/s^2" | "kg_m2" | "kgm2")
}

/// An ending as a unit: words that are divided by `_`.
fn spelled(ending: &str) -> String {
    match ending {
        "m_s_2" | "mps2" | "m_per_s2" => "m/s^2".into(),
        "radps" => "rad/s".into(),
        "degps" => "deg/s".into(),
        "N_m" => "N*m".into(),
        "kg_m2" | "kgm2" => "kg*m^2".into(),
        "deg_C" | "degC" => "degC".into(),
        other => other.replace("_per_", "/").replace('_', "/"),
    }
}

/// Names in a row, the first twelve of many.
pub(crate) fn listed(names: &[String]) -> String {
    const MOST: usize = 12;
    let some = names.iter().take(MOST).map(|name| crate::text::printable(name)).collect::<Vec<_>>().join(", ");
    if names.len() > MOST { format!("{some}, … ({} in all)", names.len()) } else { some }
}
