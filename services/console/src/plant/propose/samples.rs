//! Rates, lengths and noise of channels, for the lines of a proposal.

use channels::{Channel, Recording};

/// Values of the channel in the part where it has most.
pub fn longest<'p>(channel: &Channel, parts: &'p [Recording]) -> &'p [f64] {
    let of = |part: &'p Recording| part.channel_named(&channel.name).map(|found| found.value.as_slice());
    parts.iter().filter_map(of).max_by_key(|values| values.len()).unwrap_or(&[])
}

/// Sample period of the fastest channel, and the length of all parts.
pub fn rates(parts: &[Recording]) -> (f64, f64) {
    let steps = parts.iter().flat_map(|part| &part.channels).map(|channel| median_step(&channel.time_s));
    let period_s = steps.filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    let length = |part: &Recording| {
        let ends = part.channels.iter().filter_map(|channel| Some(channel.time_s.last()? - channel.time_s.first()?));
        ends.fold(0.0, f64::max)
    };
    let period_s = if period_s.is_finite() { period_s } else { 0.01 };
    (period_s, parts.iter().map(|part| length(part) + period_s).sum())
}

/// The upper of the two in the middle: a step that the file has, with its digits. Half way between
/// two, as `estimation::quantiles` gives it, may be a period that no channel has.
pub fn median_step(time_s: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}
