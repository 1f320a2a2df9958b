//! The unit of times whose file states none, by their size and their steps.

use super::clock::EPOCH_S;
use super::day_counts;
use crate::units::{Unit, unit_named};

/// Sampling intervals that a stamp since 1970 can have [s]: a number that counts something else is
/// seldom read as such a stamp with such steps.
const EPOCH_INTERVAL_S: core::ops::Range<f64> = 1e-6..1000.0;

/// The unit of times whose file states none, and a note that says so.
///
/// # Errors
/// Whole numbers that may be milliseconds as well as counts: what each unit would mean.
pub(crate) fn guessed(name: &str, samples: &[f64]) -> Result<(Unit, String), (String, String)> {
    let known = |symbol: &str| unit_named(symbol).expect("a unit of the table");
    let mut steps: Vec<f64> = samples.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let step = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let units = ["s", "ms", "us", "ns"].map(known);
    if let Some(first) = samples.first() {
        let epoch =
            |unit: &&Unit| EPOCH_S.contains(&unit.to_si(*first)) && EPOCH_INTERVAL_S.contains(&unit.to_si(step));
        if let Some(unit) = units.iter().find(epoch) {
            let note = format!("`{name}` states no unit: its numbers are {} since 1970", unit.symbol);
            return Ok((*unit, note));
        }
    }
    if day_counts::is_named(name) {
        return Ok((known("d"), format!("`{name}` counts days from a zero that is not known")));
    }
    if day_counts::may_be_parts_of_a_day(samples, step) {
        let as_seconds = short(1.0 / step);
        let found = format!(
            "`{name}` states no unit, and its numbers may be parts of a day as spreadsheets keep times: the rate is \
             {as_seconds} Hz as seconds, {} Hz as days",
            short(1.0 / known("d").to_si(step))
        );
        return Err((found, format!("say the unit: --time-column {name}:d, or {name}:s")));
    }
    if samples.iter().any(|value| value.fract() != 0.0) || samples.is_empty() {
        return Ok((units[0], format!("`{name}` states no unit: seconds are assumed")));
    }
    let rates = units.iter().map(|unit| format!("{} Hz as {}", short(1.0 / unit.to_si(step)), unit.symbol));
    let some: Vec<String> = samples.iter().take(3).map(|value| format!("{value}")).collect();
    let found = format!(
        "`{name}` states no unit, and whole numbers ({}, …) do not tell it: the rate is {}",
        some.join(", "),
        rates.collect::<Vec<_>>().join(", ")
    );
    Err((
        found,
        format!("say the unit: --time-column {name}:us (or s, ms, ns; {name}:100Hz for a counter at that rate)"),
    ))
}

fn short(value: f64) -> String {
    if (1e-3..1e6).contains(&value) { format!("{}", (value * 1e3).round() / 1e3) } else { format!("{value:.3e}") }
}

/// Why times such as 1.4E+018 tell nothing, if they are such.
pub(crate) fn hopeless(samples: &[f64]) -> Option<String> {
    let repeated = samples.windows(2).filter(|pair| pair[0] == pair[1]).count();
    let large = samples.first().is_some_and(|first| first.abs() > 1e9);
    let lost = || samples.iter().all(|value| has_few_digits(*value));
    (large && samples.len() > 3 && 2 * repeated > samples.len() && lost()).then(|| {
        format!(
            "most rows have the same time as the row before ({:e}, {:e}, …): the digits that tell the rows apart were lost",
            samples[0], samples[1]
        )
    })
}

/// Whether a number has no more digits than a spreadsheet leaves of a long one, seven.
fn has_few_digits(value: f64) -> bool {
    format!("{value:.6e}").parse() == Ok(value)
}
