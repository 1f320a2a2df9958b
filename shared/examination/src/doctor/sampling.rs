//! How the samples of a channel relate to the rows: values that are held, channels that are late.

use super::content::is_input;
use super::{Check, Finding, Severity, short, usable};
use crate::delay::{Delay, delays};
use crate::held::held;
use channels::{Channel, Recording, Uniform};

/// Fewest rows of channels that are compared.
const ROWS_MIN: usize = 1024;

/// A measured channel whose values stand for several rows.
pub fn held_values(channel: &Channel) -> Option<Finding> {
    let interval_s = channel.interval_s().filter(|_| !is_input(channel))?;
    let found = held(&on_rows(channel, interval_s)?)?;
    let (rate, logged) = (1.0 / (interval_s * found.rows_per_value), 1.0 / interval_s);
    Some(
        Finding::new(Check::Held, Severity::Warning, &channel.name, rate, "Hz")
            .because(format!(
                "each value stands for {} rows: updated at {} Hz, logged at {} Hz; the first fresh one is in row {}",
                short(found.rows_per_value),
                short(rate),
                short(logged),
                found.fresh_rows.first().map_or(0, |row| row + 1)
            ))
            .cure("use the rows with fresh values only: what lies above half the update rate is folded below it, and repeated above"),
    )
}

/// The values at the rows of their even clock, NaN where there is none; `None` where most rows would
/// be empty.
fn on_rows(channel: &Channel, interval_s: f64) -> Option<Vec<f64>> {
    let (first, last) = (*channel.time_s.first()?, *channel.time_s.last()?);
    let row = |time: f64| libm::round((time - first) / interval_s) as usize;
    let rows = row(last) + 1;
    if rows > 2 * channel.value.len() {
        return None;
    }
    let mut values = vec![f64::NAN; rows];
    for (time, value) in channel.time_s.iter().zip(&channel.value) {
        if let Some(slot) = values.get_mut(row(*time)) {
            *slot = *value;
        }
    }
    Some(values)
}

/// Measured channels of one unit and one clock that are later than most of them; those of `held` are
/// late by their holding and stay out.
pub fn late(recording: &Recording, held: &[String]) -> Vec<Finding> {
    let channels = usable(recording, ROWS_MIN);
    let compared: Vec<(&Channel, Uniform)> = channels
        .into_iter()
        .filter(|c| !is_input(c) && !held.contains(&c.name) && !["", "-", "not stated", "?"].contains(&c.unit.as_str()))
        .filter_map(|c| c.uniform().filter(|u| !u.interpolated).map(|u| (c, u)))
        .collect();
    let mut findings = Vec::new();
    let mut done = vec![false; compared.len()];
    for first in 0..compared.len() {
        if done[first] {
            continue;
        }
        let like = |k: &usize| {
            let ((a, x), (b, y)) = (&compared[first], &compared[*k]);
            a.unit == b.unit && (x.start_s, x.dt_s, x.value.len()) == (y.start_s, y.dt_s, y.value.len())
        };
        let group: Vec<usize> = (first..compared.len()).filter(like).collect();
        group.iter().for_each(|k| done[*k] = true);
        let values: Vec<&[f64]> = group.iter().map(|k| compared[*k].1.value.as_slice()).collect();
        let dt_s = compared[first].1.dt_s;
        for (k, delay) in group.iter().zip(delays(&values, dt_s)) {
            let others: Vec<&str> = group.iter().filter(|j| *j != k).map(|j| compared[*j].0.name.as_str()).collect();
            findings.extend(delay.map(|delay| late_by(compared[*k].0, &others, delay, dt_s)));
        }
    }
    findings
}

fn late_by(channel: &Channel, others: &[&str], delay: Delay, dt_s: f64) -> Finding {
    let way = if delay.delay_s > 0.0 { "later" } else { "earlier" };
    Finding::new(Check::Delay, Severity::Warning, &channel.name, delay.delay_s, "s")
        .with(others)
        .sigma(delay.sigma_s)
        .because(format!(
            "its phase against the other channels in {} is a straight line over frequency: {} samples {way}",
            channel.unit,
            short(delay.delay_s.abs() / dt_s)
        ))
        .cure("shift its stamps by that much; frequencies and damping stand, shapes and what relates channels do not")
}
