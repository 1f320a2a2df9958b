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
use super::gains::Gains;
use super::linear::Linear;
use crate::problem::Timeline;

/// Columns that go through the recursion side by side: each alone waits for its own last sum.
const LANES: usize = 8;

/// Whitens `columns` (each as long as the samples of the run) in place.
pub fn whiten(linear: &Linear, timeline: &Timeline, gains: &Gains, columns: &mut [&mut [f64]]) {
    if gains.same_as_frozen {
        return columns.iter_mut().for_each(|column| scale(timeline, gains, column));
    }
    for bundle in columns.chunks_mut(LANES) {
        let whitened = match bundle.len() {
            1 => side_by_side::<1>,
            2 => side_by_side::<2>,
            3 => side_by_side::<3>,
            4 => side_by_side::<4>,
            5 => side_by_side::<5>,
            6 => side_by_side::<6>,
            7 => side_by_side::<7>,
            _ => side_by_side::<LANES>,
        };
        whitened(linear, timeline, gains, bundle);
    }
}

fn side_by_side<const W: usize>(linear: &Linear, timeline: &Timeline, gains: &Gains, columns: &mut [&mut [f64]]) {
    together::<W>(linear, timeline, gains, columns.try_into().expect("a bundle is as wide as its length says"));
}

fn scale(timeline: &Timeline, gains: &Gains, column: &mut [f64]) {
    for (k, event) in timeline.events.iter().enumerate() {
        if event.count > 0 {
            let factor = &gains.factor[gains.factor_first[k]..];
            solve(factor, &mut column[event.first..event.first + event.count]);
        }
    }
}

/// `L⁻¹ b` in place.
fn solve(factor: &[f64], b: &mut [f64]) {
    let n = b.len();
    for a in 0..n {
        let known: f64 = (0..a).map(|i| factor[a * n + i] * b[i]).sum();
        b[a] = (b[a] - known) / factor[a * n + a];
    }
}

/// One number of every column.
pub(super) type Lane<const W: usize> = [f64; W];

/// `sum += factor · x`, column by column.
fn add<const W: usize>(sum: &mut Lane<W>, factor: f64, x: &Lane<W>) {
    sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += factor * x);
}

fn product<const W: usize>(row: &[f64], x: &[Lane<W>]) -> Lane<W> {
    let mut sum = [0.0; W];
    row.iter().zip(x).for_each(|(factor, x)| add(&mut sum, *factor, x));
    sum
}

fn together<const W: usize>(linear: &Linear, timeline: &Timeline, gains: &Gains, columns: &mut [&mut [f64]; W]) {
    let layout = &gains.layout;
    let (n, m, c, s) = (layout.tangent, layout.noise_inputs.len(), layout.clone, layout.len());
    let len = n + m;
    let mut d = vec![[0.0; W]; s];
    let mut next = vec![[0.0; W]; n];
    let most = timeline.events.iter().map(|event| event.count).max().unwrap_or(0);
    let (mut old, mut new) = (vec![[0.0; W]; most], vec![[0.0; W]; most]);
    for (k, event) in timeline.events.iter().enumerate() {
        for i in 0..m {
            if event.reset >> layout.noise_inputs[i].min(63) & 1 == 1 {
                d[n + i] = [0.0; W];
            }
        }
        if event.count > 0 {
            let (old, new) = (&mut old[..event.count], &mut new[..event.count]);
            for slot in 0..event.count {
                let sample = event.first + slot;
                let felt = felt(linear, timeline, (layout, &gains.pole), sample, &mut d);
                for (w, column) in columns.iter().enumerate() {
                    old[slot][w] = column[sample];
                    new[slot][w] = column[sample] - felt[w];
                }
            }
            correct(linear, gains, k, &mut d, (old, new));
            let factor = &gains.factor[gains.factor_first[k]..];
            for (w, column) in columns.iter_mut().enumerate() {
                let white = &mut column[event.first..event.first + event.count];
                white.iter_mut().zip(&*new).for_each(|(white, new)| *white = new[w]);
                solve(factor, white);
            }
        }
        if event.begins_mean && c > 0 {
            d.copy_within(..n, layout.clone_at());
        }
        if k + 1 < timeline.events.len() {
            let transition = &linear.transition[k * n * len..(k + 1) * n * len];
            for (i, next) in next.iter_mut().enumerate() {
                *next = product(&transition[i * len..(i + 1) * len], &d);
            }
            d[..n].copy_from_slice(&next);
        }
    }
}

/// `H d + v̂` of a sample; lags and coloured noise move on.
pub(super) fn felt<const W: usize>(
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
    let mut felt = product(own, d);
    add(&mut felt, 1.0, &product(clone, &d[layout.clone_at()..]));
    if let Some(place) = layout.lag_of[channel] {
        let lagged = &mut d[layout.lags_at() + place];
        let decay = linear.decay[sample];
        lagged.iter_mut().zip(felt).for_each(|(d, felt)| *d = decay * *d + (1.0 - decay) * felt);
        felt = *lagged;
    }
    if let Some(place) = layout.colour_of[channel] {
        let colour = &mut d[layout.colours_at() + place];
        colour.iter_mut().for_each(|d| *d *= pole[channel]);
        let colour = *colour;
        add(&mut felt, 1.0, &colour);
    }
    felt
}

/// `d ← d + K' ν' − K ν` at event `k`.
fn correct<const W: usize>(
    linear: &Linear,
    gains: &Gains,
    k: usize,
    d: &mut [Lane<W>],
    (old, new): (&[Lane<W>], &[Lane<W>]),
) {
    let count = new.len();
    let gain = &gains.gain[gains.first[k]..];
    let frozen = &linear.frozen.gain[linear.frozen.first[k]..];
    for (i, d) in d.iter_mut().enumerate() {
        for slot in 0..count {
            add(d, gain[i * count + slot], &new[slot]);
            if i < linear.frozen.rows {
                add(d, -frozen[i * count + slot], &old[slot]);
            }
        }
    }
}
