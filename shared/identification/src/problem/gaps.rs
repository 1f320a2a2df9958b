//! Stretches in which nothing was recorded.
//!
//! A command is held from one stamp to the next. Where rows are lost the command is unknown
//! meanwhile: unless the command is the same before and after, the run is cut there and what
//! follows begins at an unspecified state, as a run of its own. Three rows or fewer are too few for
//! that. A command that is logged when it changes alone is held, too, for longer than usual: there
//! the sensors go on.

use super::{Drive, Run, Samples};
use channels::{Channel, IRREGULAR_GAP_MEDIANS, Role};

/// Samples beside one for every state that a part must have: fewer say little but where it began.
const SPARE: usize = 5;

/// `run` of a plant with so many `states` without the gaps that its commands change over, and what
/// is to be said of it.
pub(super) fn parted(run: Run, states: usize) -> (Vec<Run>, Option<String>) {
    let gaps = gaps(&run);
    if gaps.is_empty() {
        return (vec![run], None);
    }
    let begins = core::iter::once(run.begin_s).chain(gaps.iter().map(|gap| gap[1]));
    let ends = gaps.iter().map(|gap| gap[0]).chain(core::iter::once(run.end_s));
    let parts = begins.zip(ends).enumerate().map(|(part, (begin_s, end_s))| run.part([begin_s, end_s], part > 0));
    let samples = |part: &Run| part.samples.iter().map(|samples| samples.value.len()).sum::<usize>();
    let (kept, short): (Vec<Run>, Vec<Run>) = parts.partition(|part| samples(part) >= states + SPARE);
    // rather those than none
    let kept = if kept.is_empty() { short } else { kept };
    let lost = samples(&run) - kept.iter().map(samples).sum::<usize>();
    let beside = if lost > 0 { format!("; {lost} samples between them are not used") } else { String::new() };
    let note = format!(
        "nothing was recorded over {} gap(s) in which a command changed: what follows each begins anew{beside}",
        gaps.len()
    );
    (kept, Some(note))
}

/// Where a command changed over an interval that is too long for it and for a sensor, and no sensor
/// has a sample where one was due.
fn gaps(run: &Run) -> Vec<[f64; 2]> {
    let sensors: Vec<(&Samples, Vec<[f64; 2]>)> =
        run.samples.iter().map(|samples| (samples, too_long(&samples.time_s).0)).collect();
    let is_silent = |[a, b]: [f64; 2], longest_s: f64| {
        let has_samples = |samples: &Samples| samples.time_s.iter().any(|t| *t > a + longest_s && *t < b);
        let overlaps = |gaps: &[[f64; 2]]| gaps.iter().any(|[c, d]| d.min(b) - c.max(a) > 0.5 * (b - a));
        !sensors.iter().any(|(samples, _)| has_samples(samples)) && sensors.iter().any(|(_, gaps)| overlaps(gaps))
    };
    let mut all: Vec<[f64; 2]> = Vec::new();
    for drive in &run.drives {
        let Drive::Held { time_s, value } = drive else { continue };
        let at = |t: f64| time_s.partition_point(|stamp| *stamp <= t).checked_sub(1).map_or(0.0, |i| value[i]);
        let (gaps, longest_s) = too_long(time_s);
        let within = |gap: &[f64; 2]| gap[0] >= run.begin_s && gap[1] <= run.end_s;
        all.extend(
            gaps.into_iter().filter(|gap| within(gap) && at(gap[0]) != at(gap[1]) && is_silent(*gap, longest_s)),
        );
    }
    all.sort_by(|a, b| a[0].total_cmp(&b[0]));
    // commands of clocks of their own lose the same rows
    all.dedup_by(|next, last| {
        let joins = next[0] < last[1];
        last[1] = if joins { last[1].max(next[1]) } else { last[1] };
        joins
    });
    all
}

/// Intervals between stamps that are too long, and the longest that is not [s].
fn too_long(time_s: &[f64]) -> (Vec<[f64; 2]>, f64) {
    let (name, unit) = (String::new(), String::new());
    let channel = Channel { name, unit, time_s: time_s.to_vec(), value: vec![0.0; time_s.len()], role: Role::Unknown };
    let Some(longest_s) = channel.interval_s().map(|interval_s| IRREGULAR_GAP_MEDIANS * interval_s) else {
        return (Vec::new(), f64::INFINITY);
    };
    let long = time_s.windows(2).filter(|pair| pair[1] - pair[0] > longest_s).map(|pair| [pair[0], pair[1]]);
    (long.collect(), longest_s)
}
