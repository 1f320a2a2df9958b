//! Durations with their units: those of ISO 8601, `PT1M1.5S`, and what programs print, `1m1.5s`.

use super::{DAY_NS, Stamp, of_ns};

const SECOND_NS: i64 = 1_000_000_000;

/// The stamp of a duration since the beginning.
pub(super) fn of(cell: &str) -> Option<Stamp> {
    let (negative, cell) = cell.strip_prefix('-').map_or((false, cell), |rest| (true, rest));
    let ns = match cell.strip_prefix(['P', 'p']) {
        Some(rest) => of_iso(rest)?,
        None => of_parts(cell, &UNITS)?,
    };
    of_ns(if negative { -ns } else { ns })
}

/// Days before a `T`, hours, minutes and seconds behind it.
fn of_iso(text: &str) -> Option<i128> {
    let (days, time) = text.split_once(['T', 't']).unwrap_or((text, ""));
    let part = |text: &str, units| if text.is_empty() { Some(0) } else { of_parts(&text.to_lowercase(), units) };
    let ns = part(days, &UNITS[..2])? + part(time, &UNITS[2..8])?;
    (days.len() + time.len() > 0).then_some(ns)
}

/// Units as they follow each other, and their nanoseconds.
const UNITS: [(&str, i64); 11] = [
    ("w", 7 * DAY_NS),
    ("d", DAY_NS),
    ("h", 3600 * SECOND_NS),
    ("min", 60 * SECOND_NS),
    ("m", 60 * SECOND_NS),
    ("sec", SECOND_NS),
    ("s", SECOND_NS),
    ("ms", 1_000_000),
    ("us", 1000),
    ("µs", 1000),
    ("ns", 1),
];

/// Numbers with units, each unit shorter than the one before.
fn of_parts(text: &str, units: &[(&str, i64)]) -> Option<i128> {
    let (mut rest, mut total, mut last) = (text.trim(), 0, i64::MAX);
    while !rest.is_empty() {
        let digits = rest.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | ','))).filter(|at| *at > 0)?;
        let (number, behind) = rest.split_at(digits);
        let letters = behind.trim_start();
        let end = letters.find(|c: char| !c.is_alphabetic()).unwrap_or(letters.len());
        let (_, ns) = units.iter().find(|(unit, _)| *unit == &letters[..end]).filter(|(_, ns)| *ns < last)?;
        total += of_number(number, *ns)?;
        (rest, last) = (letters[end..].trim_start(), *ns);
    }
    (last < i64::MAX).then_some(total)
}

/// Nanoseconds of a number of units, the digits before its sign exact.
fn of_number(number: &str, ns: i64) -> Option<i128> {
    let (whole, part) = number.split_once(['.', ',']).unwrap_or((number, ""));
    let part: f64 = format!("0.{part}0").parse().ok()?;
    let whole: i128 = if whole.is_empty() { 0 } else { whole.parse().ok()? };
    Some(whole.checked_mul(ns.into())? + (part * ns as f64).round() as i128)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_duration_is_the_sum_of_its_parts() {
        let ns =
            |cell: &str| of(cell).map(|stamp| i128::from(stamp.day) * i128::from(DAY_NS) + i128::from(stamp.within_ns));
        let cases = [
            ("PT1.5S", 1_500_000_000),
            ("PT0S", 0),
            ("P0DT0H1M1.25S", 61_250_000_000),
            ("P1DT2H", 93_600_000_000_000),
            ("-PT0,25S", -250_000_000),
            ("pt10m", 600_000_000_000),
            ("1m1.5s", 61_500_000_000),
            ("1h 2 min 3 s", 3_723_000_000_000),
            ("250.5ms", 250_500_000),
            ("1d2h", 93_600_000_000_000),
        ];
        for (cell, expected) in cases {
            assert_eq!(ns(cell), Some(expected), "{cell}");
        }
        for cell in ["P", "PT", "PT1", "P1M", "1s2m", "1.2.3s", "5x", "", "12", "m", "1m1m"] {
            assert_eq!(ns(cell), None, "{cell}");
        }
    }
}
