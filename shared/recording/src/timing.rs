//! The time axis of a table: rate, jitter, gaps. What is repaired is counted, what is ambiguous is
//! rejected.
//!
//! A gap (interval above 1.5 medians) is reported and never filled. A lasting change of the
//! interval and an uneven sampling are errors: every method behind this crate assumes one rate.

use crate::error::{Place, RecordingError, rounded};
use channels::{EvenClock, GAP_MEDIANS, Stamps};

/// Lasting change of the interval, and jitter (95 % of the intervals), up to which a recording has
/// one rate.
pub const INTERVAL_CHANGE_MAX: f64 = 0.2;
/// Longest recording [s]; integer nanoseconds reach 18 times further.
const DURATION_MAX_S: f64 = 1e9;
/// Shortest part whose median interval is compared: a median of 16 stands 7 gaps.
const PART_MIN: usize = 16;

/// Samples missing between two rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Row (from 0) after which it lies.
    pub after_row: usize,
    /// Line of the file at which it ends.
    pub line: u64,
    pub start_s: f64,
    pub length_s: f64,
}

/// What the time column says about the sampling.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// Mean of the regular intervals (those that are no gap); less sensitive to rounded stamps than
    /// the median.
    pub interval_s: f64,
    pub interval_median_s: f64,
    /// 95th percentile of |interval / median - 1| over the regular intervals.
    pub jitter: f64,
    /// Largest |interval / median - 1| over the regular intervals.
    pub jitter_max: f64,
    pub gaps: Vec<Gap>,
    /// Rows that stood twice and were dropped.
    pub duplicates: u64,
}

impl Timing {
    /// The repairs in words, empty when nothing was repaired.
    #[must_use]
    pub fn repairs(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if self.duplicates > 0 {
            lines.push(format!("{} row(s) stood twice and were dropped once", self.duplicates));
        }
        let longest = self.gaps.iter().max_by(|a, b| a.length_s.total_cmp(&b.length_s));
        if let Some(Gap { length_s, start_s, line, .. }) = longest {
            let missing: f64 = self.gaps.iter().map(|gap| (gap.length_s / self.interval_s).round() - 1.0).sum();
            let several = match self.gaps.len() {
                1 => String::new(),
                count => format!("{count} gaps, {missing} rows missing; the longest a "),
            };
            lines.push(format!(
                "{several}gap of {} s from {} s (line {line}): reported, not filled",
                rounded(*length_s),
                rounded(*start_s)
            ));
        }
        lines
    }
}

/// Whether an increasing time column has two rows at least and a length that can be right;
/// `lines[i]` is the line of row `i`.
pub(crate) fn check_extent(file: &str, time_s: &[f64], lines: &[u64]) -> Result<(), RecordingError> {
    let (Some(first), Some(last)) = (time_s.first(), time_s.last()) else {
        return Err(RecordingError::TooFewRows { file: file.into(), line: 1, rows: 0 });
    };
    if time_s.len() < 2 {
        return Err(RecordingError::TooFewRows { file: file.into(), line: lines[0], rows: time_s.len() });
    }
    let duration_s = last - first;
    if duration_s > DURATION_MAX_S {
        return Err(RecordingError::TooLong {
            place: place(file, lines[lines.len() - 1]),
            value: duration_s,
            limit: DURATION_MAX_S,
        });
    }
    Ok(())
}

fn place(file: &str, line: u64) -> Box<Place> {
    Box::new(Place { file: file.into(), line, column: 1, name: "time".into() })
}

/// Judges a strictly increasing time column; `lines[i]` is the line of row `i`.
pub(crate) fn examine(file: &str, time_s: &[f64], lines: &[u64], duplicates: u64) -> Result<Timing, RecordingError> {
    check_extent(file, time_s, lines)?;
    let place = |row: usize| place(file, lines[row]);
    let intervals: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    check_one_rate(&intervals, time_s, &place)?;

    let median = median(&intervals);
    let is_gap = |interval: f64| interval > GAP_MEDIANS * median;
    let regular: Vec<f64> = intervals.iter().copied().filter(|interval| !is_gap(*interval)).collect();
    let mut deviations: Vec<f64> = regular.iter().map(|interval| (interval / median - 1.0).abs()).collect();
    deviations.sort_by(f64::total_cmp);
    let jitter = deviations[(deviations.len() - 1) * 95 / 100];
    if jitter > INTERVAL_CHANGE_MAX {
        let worst = (0..intervals.len())
            .filter(|i| !is_gap(intervals[*i]))
            .max_by(|a, b| (intervals[*a] - median).abs().total_cmp(&(intervals[*b] - median).abs()))
            .unwrap_or(0);
        return Err(RecordingError::UnsteadyRate {
            place: place(worst + 1),
            value: time_s[worst + 1],
            interval_s: intervals[worst],
            median_s: median,
            jitter_percent: 100.0 * jitter,
            limit_percent: 100.0 * INTERVAL_CHANGE_MAX,
        });
    }
    let gaps = (0..intervals.len()).filter(|i| is_gap(intervals[*i])).map(|i| Gap {
        after_row: i,
        line: lines[i + 1],
        start_s: time_s[i],
        length_s: intervals[i],
    });
    Ok(Timing {
        interval_s: regular.iter().sum::<f64>() / regular.len() as f64,
        interval_median_s: median,
        jitter,
        jitter_max: *deviations.last().expect("half of the intervals are not above the median"),
        gaps: gaps.collect(),
        duplicates,
    })
}

/// Whether more than one interval in twenty is off the median by more than a twentieth: then
/// the stamps may be at fault. Less is a jitter that methods of one rate stand: it moves
/// a signal at a tenth of the Nyquist frequency by `0.05 · 0.1 π`, 1.6 % of its amplitude. Nor is
/// a clock steady on which more time is missing than is there: its rows may come in packets.
pub(crate) fn is_unsteady(time_s: &[f64]) -> bool {
    const STEADY_SHARE: f64 = 0.05;
    let intervals: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if intervals.is_empty() {
        return false;
    }
    let median = median(&intervals);
    let off = intervals.iter().filter(|interval| (*interval - median).abs() > STEADY_SHARE * median).count();
    let missing_s: f64 = intervals.iter().filter(|interval| **interval > GAP_MEDIANS * median).sum();
    let is_there_s = median * intervals.len() as f64;
    off as f64 > STEADY_SHARE * intervals.len() as f64 || missing_s > is_there_s
}

/// What a clock made of the stamps.
pub(crate) fn in_words(clock: &EvenClock) -> String {
    let stamps = match clock.stamps {
        Stamps::Right => "are right".into(),
        Stamps::Rounded(quantum_s) => format!("are rounded to {} s", rounded(quantum_s)),
        Stamps::Packed(wait_s) => format!("are those of packets, up to {} s apart", rounded(wait_s)),
    };
    format!(
        "the stamps {stamps}: all rows lie within {} s of an even clock of {} Hz, which is used instead of them",
        rounded(clock.off_s),
        rounded(1.0 / clock.interval_s)
    )
}

/// Compares the median interval of every part of the recording with that of the first.
fn check_one_rate(
    intervals: &[f64],
    time_s: &[f64],
    place: &dyn Fn(usize) -> Box<Place>,
) -> Result<(), RecordingError> {
    let length = (intervals.len() / 16).clamp(PART_MIN, 4096);
    if intervals.len() < 2 * length {
        return Ok(());
    }
    let before = median(&intervals[..length]);
    let differs = |interval: f64| (interval / before - 1.0).abs() > INTERVAL_CHANGE_MAX;
    for part in 1..intervals.len() / length {
        let after = median(&intervals[part * length..(part + 1) * length]);
        if differs(after) {
            // The change lies in this part or in the one before: where the new interval first
            // stays.
            let start = (part - 1) * length;
            let changed = (start..(part + 1) * length)
                .find(|i| {
                    let stays = &intervals[*i..(i + PART_MIN).min(intervals.len())];
                    differs(intervals[*i]) && differs(median(stays))
                })
                .unwrap_or(part * length);
            return Err(RecordingError::RateChanged {
                place: place(changed + 1),
                value: time_s[changed + 1],
                before_s: before,
                after_s: after,
            });
        }
    }
    Ok(())
}

/// The lower of the two in the middle: an interval that the record has. Half way between two, as
/// `estimation::quantiles` gives it, may be none of two rates, and no interval is then near it.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[(sorted.len() - 1) / 2]
}
