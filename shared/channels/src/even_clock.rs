//! The even clock behind stamps that are coarser than it, delivered in packets, or absent for some
//! rows.
//!
//! A source that samples every T takes sample k at `t_0 + m_k T`, m a counter that skips what was
//! lost. Its stamps are off that line by no more than what made them wrong: less than the quantum q
//! where they were rounded or cut to multiples of q, less than the longest silence where rows wait
//! for their packet. A clock that is uneven leaves any such bound: its stamps are a random walk
//! about the line, and one whose steps scatter by σ stays within a width w for n rows with a
//! probability near `exp(−n (π σ / w)² / 2)`. For a walk of half a quantum a row and 64 rows that
//! is below 10⁻³⁰ within w = q, and 10⁻⁷ within w = 2 q.
//!
//! Outages are no waits: rows that were lost among packets are counted first (`packets`), and
//! the bound is the longest wait at which nothing was lost.

mod packets;
#[cfg(test)]
mod tests;

use packets::{Kind, Packets, kinds};

/// Rows that show an even clock; see the module's law.
const ROWS_MIN: usize = 64;
/// Stamps off the line by less than this share of a step need no repair.
const EXACT_SHARE: f64 = 1e-3;
/// Share of the rows that come less than a quarter of a step behind the one before, where rows come
/// in packets: half of them in packets of two; of rows at random, `1 − e^(−1/4)`, 0.22.
const PACKED_SHARE_MIN: f64 = 0.4;
/// Steps of the seldom length, at least, among rounded stamps: as many at random places lie so
/// evenly with a probability of `16! / 16¹⁶`, 10⁻⁶. A row that stands twice is no rounding.
const CYCLES_MIN: f64 = 16.0;
/// Share to which the bounds of the stamps off a line are found.
const LINE_PRECISION: f64 = 1e-3;
/// Rows by which stamps may be off in addition where rows were lost among packets: how many is
/// known to one row at each loss.
const LOST_ROWS_UNKNOWN: f64 = 2.0;
/// Mean number of rows between losses among packets, at least: a walk is no clock with losses.
const ROWS_PER_RUN_MIN: f64 = 32.0;
/// Units in the last place that a stamp is off its decimal number, and a difference of two.
const ROUNDING_ULPS: f64 = 4.0;

/// What made the stamps of an even clock wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stamps {
    /// They are right.
    Right,
    /// They are multiples of a quantum \[s\].
    Rounded(f64),
    /// Rows wait for a packet, at most for this time \[s\].
    Packed(f64),
}

/// An even clock and the row of it at which each stamp belongs.
#[derive(Clone, Debug, PartialEq)]
pub struct EvenClock {
    /// Time of row 0 \[s\].
    pub start_s: f64,
    /// Time from row to row \[s\].
    pub interval_s: f64,
    /// Row of each stamp, ascending from 0; a row that no stamp has is missing.
    pub rows: Vec<usize>,
    /// What is wrong with the stamps.
    pub stamps: Stamps,
    /// Largest distance of a stamp from its row's time \[s\].
    pub off_s: f64,
}

impl EvenClock {
    /// The even clock behind `stamps_s`, ascending \[s\]; stamps may be equal. `None` for fewer
    /// than 64, and where no even clock explains them.
    ///
    /// Which rows are missing is seen where the stamps are finer than half a step; of coarser ones
    /// and of packets where the stamps behind a loss stay late. Stamps that are whole steps of a
    /// clock are taken for right with rows missing, not for those of a slower clock rounded to
    /// them.
    ///
    /// ```
    /// use channels::{EvenClock, Stamps};
    ///
    /// // 300 Hz, written to the millisecond
    /// let stamps: Vec<f64> = (0..900).map(|k| (1e3 * f64::from(k) / 300.0).round() / 1e3).collect();
    /// let clock = EvenClock::of(&stamps).unwrap();
    /// assert!((1.0 / clock.interval_s - 300.0).abs() < 0.01);
    /// assert!(matches!(clock.stamps, Stamps::Rounded(q) if (q - 1e-3).abs() < 1e-9));
    /// ```
    #[must_use]
    pub fn of(stamps_s: &[f64]) -> Option<Self> {
        let n = stamps_s.len();
        let (first, last) = (*stamps_s.first()?, *stamps_s.last()?);
        let ascending = stamps_s.windows(2).all(|pair| pair[1] >= pair[0]);
        if n < ROWS_MIN || !ascending || !(last - first).is_finite() || last <= first {
            return None;
        }
        let ulps = ROUNDING_ULPS * f64::EPSILON * first.abs().max(last.abs());
        let time: Vec<f64> = stamps_s.iter().map(|stamp| stamp - first).collect();
        let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let quantum = quantum(&steps, ulps);
        let of = Explanation { first, ulps, time: &time, steps: &steps, quantum };
        // stamps that are right go before any that are wrong
        let counted = counted(&time, &steps, quantum).and_then(|rows| of.explained(rows, of.longest_s(), 0.0));
        counted
            .filter(|clock| clock.missing() <= n || clock.rows_per_run() >= ROWS_MIN as f64)
            .filter(|clock| clock.stamps == Stamps::Right || quantum.is_none_or(|q| q < 0.5 * clock.interval_s))
            .or_else(|| of.packets())
    }

    /// Rows that have no stamp.
    #[must_use]
    pub fn missing(&self) -> usize {
        self.rows.last().map_or(0, |last| last + 1) - self.rows.len()
    }

    /// Mean number of rows between gaps. A clock that has more rows missing than present shows only
    /// where a run of rows could show it alone; shorter runs are packets.
    fn rows_per_run(&self) -> f64 {
        let gaps = self.rows.windows(2).filter(|pair| pair[1] > pair[0] + 1).count();
        self.rows.len() as f64 / (gaps + 1) as f64
    }

    /// Time of the row of stamp `i` \[s\].
    #[must_use]
    pub fn time_s(&self, i: usize) -> f64 {
        self.start_s + self.rows[i] as f64 * self.interval_s
    }
}

/// Stamps, and what may explain them.
struct Explanation<'s> {
    /// First stamp.
    first: f64,
    ulps: f64,
    /// Stamps since the first.
    time: &'s [f64],
    steps: &'s [f64],
    quantum: Option<f64>,
}

impl Explanation<'_> {
    fn longest_s(&self) -> f64 {
        self.steps.iter().copied().fold(0.0, f64::max)
    }

    /// The even clock on which the stamps have these rows, none of them late by more than `wait_s`
    /// and `slack` rows.
    fn explained(&self, rows: Vec<usize>, wait_s: f64, slack: f64) -> Option<EvenClock> {
        let line = Line::of(&rows, self.time);
        let range = line.high - line.low;
        let slack_s = slack * line.slope;
        let rounded = |quantum: &f64| {
            range <= (1.0 + LINE_PRECISION) * quantum + self.ulps + slack_s
                && cycles(line.slope, *quantum, &rows) >= CYCLES_MIN
        };
        let stamps = if range <= EXACT_SHARE * line.slope {
            Stamps::Right
        } else if let Some(quantum) = self.quantum.filter(rounded) {
            Stamps::Rounded(quantum)
        } else if packed(self.steps, line.slope) && range <= wait_s - 0.5 * line.slope + slack_s {
            Stamps::Packed(wait_s)
        } else {
            return None;
        };
        let start_s = self.first + 0.5 * (line.low + line.high);
        Some(EvenClock { start_s, interval_s: line.slope, rows, stamps, off_s: 0.5 * range })
    }

    /// The even clock of rows in packets, some of which may be lost.
    fn packets(&self) -> Option<EvenClock> {
        let kinds = kinds(self.steps, self.ulps);
        if kinds.is_empty() {
            return self.explained((0..self.time.len()).collect(), self.longest_s(), 0.0);
        }
        // the steps that leave least are those from packet to packet
        let found = kinds.into_iter().filter_map(|kind| self.packets_of(kind));
        found.min_by(|one, other| one.off_s.total_cmp(&other.off_s))
    }

    fn packets_of(&self, kind: Kind) -> Option<EvenClock> {
        let Packets { rows, wait_s } = Packets::of(self.time, self.steps, kind)?;
        let is_lossy = rows.last().is_some_and(|last| last + 1 > rows.len());
        let slack = if is_lossy { LOST_ROWS_UNKNOWN } else { 0.0 };
        let clock = self.explained(rows, wait_s, slack)?;
        (!is_lossy || clock.rows_per_run() >= ROWS_PER_RUN_MIN).then_some(clock)
    }
}

/// The quantum of which all steps are multiples, if it shows: steps differ, and the difference of
/// the nearest two that differ divides all.
fn quantum(steps: &[f64], ulps: f64) -> Option<f64> {
    let mut different: Vec<f64> = steps.to_vec();
    different.sort_unstable_by(f64::total_cmp);
    different.dedup_by(|b, a| *b - *a <= ulps);
    let apart = different.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let least = different.iter().copied().find(|step| *step > ulps)?;
    let rough = apart.min(least);
    if rough <= 8.0 * ulps {
        return None;
    }
    // its error grows with the multiple: take it from the largest step
    let largest = *different.last()?;
    let quantum = largest / libm::round(largest / rough);
    let tolerance = (2.0 * ulps).max(1e-6 * quantum);
    let multiple = |step: &f64| (step - quantum * libm::round(step / quantum)).abs() <= tolerance;
    different.iter().all(multiple).then_some(quantum)
}

/// Rows counted by the steps, each the nearest number of intervals; `None` where stamps are too
/// coarse to count by.
fn counted(time: &[f64], steps: &[f64], quantum: Option<f64>) -> Option<Vec<usize>> {
    let mut sorted: Vec<f64> = steps.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let median = sorted[(sorted.len() - 1) / 2];
    let single: Vec<f64> = sorted.into_iter().filter(|step| *step > 0.0 && *step <= 1.5 * median).collect();
    if single.is_empty() {
        return None;
    }
    let mut interval = single.iter().sum::<f64>() / single.len() as f64;
    let mut rows = Vec::new();
    for _ in 0..3 {
        // a step is off by a quantum at most, and half an interval decides
        if quantum.is_some_and(|quantum| quantum > 0.5 * interval && quantum < 0.99 * interval) || interval <= 0.0 {
            return None;
        }
        let mut row = 0;
        rows = vec![0];
        for step in steps {
            row += libm::round(step / interval) as usize;
            rows.push(row);
        }
        if row == 0 || rows.windows(2).any(|pair| pair[0] == pair[1]) {
            return None;
        }
        interval = Line::of(&rows, time).slope;
    }
    Some(rows)
}

/// How often the clock passes by a quantum: steps of the seldom one of two lengths.
fn cycles(interval: f64, quantum: f64, rows: &[usize]) -> f64 {
    let part = interval / quantum - libm::round(interval / quantum);
    part.abs() * rows[rows.len() - 1] as f64
}

/// Whether rows come in packets.
fn packed(steps: &[f64], interval: f64) -> bool {
    let close = steps.iter().filter(|step| **step < 0.25 * interval).count();
    close as f64 >= PACKED_SHARE_MIN * steps.len() as f64
}

/// `time ≈ slope row`, and between which bounds what is left lies.
struct Line {
    slope: f64,
    low: f64,
    high: f64,
}

impl Line {
    /// The line whose bounds are narrowest. Their distance is a convex function of the slope, so it
    /// is halved to from both sides of the least-squares slope.
    fn of(rows: &[usize], time: &[f64]) -> Line {
        let n = rows.len() as f64;
        let middle = rows.iter().map(|row| *row as f64).sum::<f64>() / n;
        let (mut above, mut below) = (0.0, 0.0);
        for (row, time) in rows.iter().zip(time) {
            above += (*row as f64 - middle) * time;
            below += (*row as f64 - middle) * (*row as f64 - middle);
        }
        let least_squares = above / below;
        let at = |slope: f64| {
            let mut line = Line { slope, low: f64::INFINITY, high: f64::NEG_INFINITY };
            for (row, time) in rows.iter().zip(time) {
                let off = time - slope * *row as f64;
                (line.low, line.high) = (line.low.min(off), line.high.max(off));
            }
            line
        };
        let width = |line: &Line| line.high - line.low;
        let mut best = at(least_squares);
        let span = rows[rows.len() - 1] as f64;
        let mut reach = 2.0 * width(&best) / span;
        // to 2⁻¹² of the bounds' first distance
        for _ in 0..14 {
            for slope in [best.slope - reach, best.slope + reach] {
                let line = at(slope);
                if width(&line) < width(&best) {
                    best = line;
                }
            }
            reach *= 0.5;
        }
        best
    }
}
