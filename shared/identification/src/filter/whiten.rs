//! Innovations of the frozen filter as those of the filter for another noise, whitened.
//!
//! Both filters run on the same linear model; their states differ by d:
//!
//! ```text
//! ν' = ν − H d − v̂',   d ← d + K' ν' − K ν,   d ← F d,   r = L'⁻¹ ν'
//! ```
//!
//! The map ν → r is linear, and the same for innovations and for columns of sensitivities.

use super::Layout;
use super::gains::{Gains, gains};
use super::linear::Linear;
use super::wide::wide;
use crate::problem::Timeline;
use core::ops::Range;

/// Columns that go through the recursion side by side: each alone waits for its own last sum.
pub const LANES: usize = 8;
/// Events that are taken at a time: their numbers stay near the processor.
pub const PART: usize = 64;

/// The same component of every column.
pub type Lane<const W: usize> = [f64; W];

/// Whitens `columns` (each as long as the samples of the run) in place.
pub fn whiten(linear: &Linear, timeline: &Timeline, gains: &Gains, columns: &mut [&mut [f64]]) {
    for bundle in columns.chunks_mut(LANES) {
        match bundle.len() {
            1 => in_place::<1>(linear, timeline, gains, bundle),
            2 => in_place::<2>(linear, timeline, gains, bundle),
            3 | 4 => in_place::<4>(linear, timeline, gains, bundle),
            _ => in_place::<LANES>(linear, timeline, gains, bundle),
        }
    }
}

impl Linear {
    /// `−2 ln p` of the run under the noise of the pass; infinite where it has none.
    pub fn objective(&self, timeline: &Timeline) -> f64 {
        let Some(found) = gains(self, timeline, &self.noise) else { return f64::INFINITY };
        let mut r = self.nu.clone();
        whiten(self, timeline, &found, &mut [&mut r]);
        found.log_determinant + r.iter().map(|r| r * r).sum::<f64>()
    }
}

fn in_place<const W: usize>(linear: &Linear, timeline: &Timeline, gains: &Gains, columns: &mut [&mut [f64]]) {
    let mut apart = Apart::<W>::new(&gains.layout, timeline);
    let mut rows: Vec<Lane<W>> = Vec::new();
    for begin in (0..timeline.events.len()).step_by(PART) {
        let events = begin..(begin + PART).min(timeline.events.len());
        let samples = samples(timeline, &events);
        beside(columns, samples.clone(), &mut rows);
        apart.whiten((linear, timeline), (gains, 0), events, &mut rows);
        for (w, column) in columns.iter_mut().enumerate() {
            column[samples.clone()].iter_mut().zip(&rows).for_each(|(white, row)| *white = row[w]);
        }
    }
}

/// Samples of `events`.
pub fn samples(timeline: &Timeline, events: &Range<usize>) -> Range<usize> {
    let last = &timeline.events[events.end - 1];
    timeline.events[events.start].first..last.first + last.count
}

/// Stretches of columns beside each other; zeros where there are fewer than lanes.
pub fn beside<const W: usize>(columns: &[impl AsRef<[f64]>], samples: Range<usize>, rows: &mut Vec<Lane<W>>) {
    rows.clear();
    rows.resize(samples.len(), [0.0; W]);
    for (w, column) in columns.iter().enumerate() {
        rows.iter_mut().zip(&column.as_ref()[samples.clone()]).for_each(|(row, number)| row[w] = *number);
    }
}

/// What the states of both filters differ by, column by column, between one stretch of events and
/// the next.
pub struct Apart<const W: usize> {
    d: Vec<Lane<W>>,
    next: Vec<Lane<W>>,
    old: Vec<Lane<W>>,
}

impl<const W: usize> Apart<W> {
    /// Workspace for `W` columns over the events of a timeline.
    pub fn new(layout: &Layout, timeline: &Timeline) -> Self {
        let most = timeline.events.iter().map(|event| event.count).max().unwrap_or(0);
        let zeros = |count: usize| vec![[0.0; W]; count];
        Self { d: zeros(layout.len()), next: zeros(layout.tangent), old: zeros(most) }
    }

    /// Whitens the `rows` of the samples of `events` in place; `gains` count from event `from`.
    pub fn whiten(
        &mut self,
        (linear, timeline): (&Linear, &Timeline),
        (gains, from): (&Gains, usize),
        events: Range<usize>,
        rows: &mut [Lane<W>],
    ) {
        wide(
            #[inline(always)]
            || self.go_on((linear, timeline), (gains, from), events, rows),
        );
    }

    #[inline(always)]
    fn go_on(
        &mut self,
        (linear, timeline): (&Linear, &Timeline),
        (gains, from): (&Gains, usize),
        events: Range<usize>,
        rows: &mut [Lane<W>],
    ) {
        let layout = &gains.layout;
        let (n, m) = (layout.tangent, layout.noise_inputs.len());
        let (len, first) = (n + m, timeline.events[events.start].first);
        for k in events {
            let event = &timeline.events[k];
            let own = &mut rows[event.first - first..event.first - first + event.count];
            let factor = &gains.factor[gains.factor_first[k - from]..];
            if gains.same_as_frozen {
                solve(factor, own);
                continue;
            }
            for i in 0..m {
                if event.reset >> layout.noise_inputs[i].min(63) & 1 == 1 {
                    self.d[n + i] = [0.0; W];
                }
            }
            if event.count > 0 {
                let old = &mut self.old[..event.count];
                old.copy_from_slice(own);
                for (slot, row) in own.iter_mut().enumerate() {
                    let difference =
                        reading_difference(linear, timeline, (layout, &gains.pole), event.first + slot, &mut self.d);
                    add(row, -1.0, &difference);
                }
                let gain = &gains.gain[gains.first[k - from]..];
                let frozen = &linear.frozen.gain[linear.frozen.first[k]..];
                correct((gain, frozen, linear.frozen.rows), &mut self.d, (old, own));
                solve(factor, own);
            }
            if event.begins_mean && layout.clone > 0 {
                self.d.copy_within(..n, layout.clone_at());
            }
            if k + 1 < timeline.events.len() {
                let transition = &linear.transition[k * n * len..(k + 1) * n * len];
                for (next, row) in self.next.iter_mut().zip(transition.chunks_exact(len.max(1))) {
                    *next = product(row, &self.d);
                }
                self.d[..n].copy_from_slice(&self.next);
            }
        }
    }
}

/// `L⁻¹ b` in place.
#[inline(always)]
fn solve<const W: usize>(factor: &[f64], b: &mut [Lane<W>]) {
    let n = b.len();
    for a in 0..n {
        let (known, rest) = b.split_at_mut(a);
        let left = product(&factor[a * n..a * n + a], known);
        let own = &mut rest[0];
        for (own, left) in own.iter_mut().zip(left) {
            *own = (*own - left) / factor[a * n + a];
        }
    }
}

/// `sum += factor · x`, column by column.
#[inline(always)]
fn add<const W: usize>(sum: &mut Lane<W>, factor: f64, x: &Lane<W>) {
    for (sum, x) in sum.iter_mut().zip(x) {
        *sum += factor * x;
    }
}

#[inline(always)]
fn product<const W: usize>(row: &[f64], x: &[Lane<W>]) -> Lane<W> {
    let mut sum = [0.0; W];
    for (factor, x) in row.iter().zip(x) {
        add(&mut sum, *factor, x);
    }
    sum
}

/// `H d + v̂` of a sample; lags and coloured noise move on.
#[inline(always)]
pub(super) fn reading_difference<const W: usize>(
    linear: &Linear,
    timeline: &Timeline,
    (layout, pole): (&Layout, &[f64]),
    sample: usize,
    d: &mut [Lane<W>],
) -> Lane<W> {
    let len = layout.tangent + layout.noise_inputs.len();
    let row_len = len + layout.clone;
    let channel = timeline.channel[sample];
    let (own, clone) = linear.measurement[sample * row_len..(sample + 1) * row_len].split_at(len);
    let mut difference = product(own, d);
    add(&mut difference, 1.0, &product(clone, &d[layout.clone_at()..]));
    if let Some(place) = layout.lag_of[channel] {
        let lagged = &mut d[layout.lags_at() + place];
        let decay = linear.decay[sample];
        for (d, difference) in lagged.iter_mut().zip(difference) {
            *d = decay * *d + (1.0 - decay) * difference;
        }
        difference = *lagged;
    }
    if let Some(place) = layout.colour_of[channel] {
        let colour = &mut d[layout.colours_at() + place];
        for d in &mut *colour {
            *d *= pole[channel];
        }
        let colour = *colour;
        add(&mut difference, 1.0, &colour);
    }
    difference
}

/// `d ← d + K' ν' − K ν`; K has `rows` rows.
#[inline(always)]
fn correct<const W: usize>(
    (gain, frozen, rows): (&[f64], &[f64], usize),
    d: &mut [Lane<W>],
    (old, new): (&[Lane<W>], &[Lane<W>]),
) {
    let count = new.len();
    for (i, d) in d.iter_mut().enumerate() {
        for slot in 0..count {
            add(d, gain[i * count + slot], &new[slot]);
            if i < rows {
                add(d, -frozen[i * count + slot], &old[slot]);
            }
        }
    }
}
