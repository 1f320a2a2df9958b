//! Stretches in which nothing was recorded.
//!
//! A command is held from one stamp to the next. Where rows are lost nobody knows what was commanded meanwhile: unless the command is the same
//! before and after, the run is cut there and what follows begins where nobody stated, as a run of its own.

use super::{Drive, Run};
use crate::series::{Channel, GAP_MEDIANS, IRREGULAR_GAP_MEDIANS};

/// Samples beside one for every state that a part must have: fewer say little but where it began.
const SPARE: usize = 5;

/// `run` of a plant with so many `states` without the gaps that its commands change over; how many there were.
pub(super) fn parted(run: Run, states: usize) -> (Vec<Run>, usize) {
    let gaps: Vec<[f64; 2]> = gaps(&run).into_iter().filter(|gap| is_commanded(&run, *gap)).collect();
    if gaps.is_empty() {
        return (vec![run], 0);
    }
    let begins = core::iter::once(run.begin_s).chain(gaps.iter().map(|gap| gap[1]));
    let ends = gaps.iter().map(|gap| gap[0]).chain(core::iter::once(run.end_s));
    let parts = begins.zip(ends).enumerate().map(|(part, (begin_s, end_s))| run.part([begin_s, end_s], part > 0));
    let samples = |part: &Run| part.samples.iter().map(|samples| samples.value.len()).sum::<usize>();
    let (kept, short): (Vec<Run>, Vec<Run>) = parts.partition(|part| samples(part) >= states + SPARE);
    // rather those than none
    (if kept.is_empty() { short } else { kept }, gaps.len())
}

/// Intervals without any stamp, longer than the densest channel has them.
fn gaps(run: &Run) -> Vec<[f64; 2]> {
    let commands = run.drives.iter().filter_map(|drive| match drive {
        Drive::Held { time_s, .. } => Some(time_s),
        _ => None,
    });
    let stamps: Vec<&Vec<f64>> = run.samples.iter().map(|samples| &samples.time_s).chain(commands).collect();
    let longest = |time_s: &&Vec<f64>| longest_interval_s(time_s);
    let Some(longest_s) = stamps.iter().filter_map(longest).min_by(f64::total_cmp) else { return Vec::new() };
    let within = |t: &f64| (run.begin_s..=run.end_s).contains(t);
    let mut all: Vec<f64> = stamps.iter().flat_map(|time_s| time_s.iter().copied()).filter(within).collect();
    all.sort_by(f64::total_cmp);
    all.windows(2).filter(|pair| pair[1] - pair[0] > longest_s).map(|pair| [pair[0], pair[1]]).collect()
}

/// Longest interval between stamps that is none too long.
fn longest_interval_s(time_s: &[f64]) -> Option<f64> {
    let channel = Channel {
        name: String::new(),
        unit: String::new(),
        time_s: time_s.to_vec(),
        value: vec![0.0; time_s.len()],
        role: crate::series::Role::Unknown,
    };
    let medians = if channel.irregular() { IRREGULAR_GAP_MEDIANS } else { GAP_MEDIANS };
    Some(medians * channel.interval_s()?)
}

/// Some command is another after the gap than before it.
fn is_commanded(run: &Run, [begin_s, end_s]: [f64; 2]) -> bool {
    run.drives.iter().any(|drive| match drive {
        Drive::Held { time_s, value } => {
            let at = |t: f64| time_s.partition_point(|stamp| *stamp <= t).checked_sub(1).map_or(0.0, |i| value[i]);
            at(begin_s) != at(end_s)
        }
        _ => false,
    })
}
