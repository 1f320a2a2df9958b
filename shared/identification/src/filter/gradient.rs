//! Gradient of `−2 ln p` with respect to every number of the noise, by one pass of the filter and
//! one back.
//!
//! On the way back r is the gradient of `ln p` with respect to the state, given what lies ahead,
//! and N the covariance of r over all recordings (the disturbance smoother: de Jong, Biometrika 76,
//! 1989; Koopman & Shephard, Biometrika 79, 1992). Sample by sample, as [`super::gains`] has them
//! (e whitened):
//!
//! ```text
//! k = v / √s,  u = (e − vᵀ r) / √s,  q = N k,  D = 1/s + kᵀ q       ∂(−2 ln p)/∂R = D − u²
//! r ← r + h u,  N ← N − h qᵀ − q hᵀ + D h hᵀ
//! r ← Fᵀ r,     N ← Fᵀ N F                                          ∂(−2 ln p)/∂Q = N − r rᵀ
//! ```
//!
//! A pole of white noise (size σ, consecutive samples u⁻ and u) has the slope
//! `−2 σ² Σ (u⁻ u − cov(u⁻, u))`, `cov(u⁻, u) = −k⁻ᵀ g`, where g begins as `h D − q` and goes back
//! as r does. Expected second derivatives neglect what different instants have in common.

use super::gains::{coloured, recurse};
use super::recursion::Tape;
use super::rows::{QUAD, Row, add, by_size};
use super::whiten::{Apart, PART, samples};
use super::wide::wide;
use super::{Layout, Linear, NoiseModel};
use crate::problem::Timeline;
use core::ops::AddAssign;
use way_back::Back;

mod way_back;

/// First derivative and expected second one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slope {
    pub first: f64,
    pub second: f64,
}

/// `−2 ln p`, and its slopes along the logarithms of standard deviations and jitters and along the
/// inverse hyperbolic tangents of poles.
#[derive(Clone, Debug, Default)]
pub struct Gradient {
    pub value: f64,
    pub input: Vec<Slope>,
    pub sensor: Vec<Slope>,
    pub pole: Vec<Slope>,
    pub jitter: Vec<Slope>,
}

impl AddAssign for Slope {
    fn add_assign(&mut self, other: Self) {
        self.first += other.first;
        self.second += other.second;
    }
}

impl Slope {
    /// Of a variance `size` whose slope is `N − r²`, along the logarithm of its root.
    #[inline(always)]
    fn of_variance(size: f64, n: f64, r: f64) -> Self {
        Self { first: 2.0 * size * (n - r * r), second: (2.0 * size * n).powi(2) }
    }
}

impl Gradient {
    fn zeros(inputs: usize, channels: usize) -> Self {
        let zeros = |count| vec![Slope::default(); count];
        Self {
            value: 0.0,
            input: zeros(inputs),
            sensor: zeros(channels),
            pole: zeros(channels),
            jitter: zeros(channels),
        }
    }
}

impl AddAssign for Gradient {
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        let add = |own: &mut Vec<Slope>, other: Vec<Slope>| own.iter_mut().zip(other).for_each(|(a, b)| *a += b);
        add(&mut self.input, other.input);
        add(&mut self.sensor, other.sensor);
        add(&mut self.pole, other.pole);
        add(&mut self.jitter, other.jitter);
    }
}

/// Of innovations `nu` of the frozen filter of `linear` under `noise`; `None` where a covariance is
/// not positive.
///
/// Cost: about three recursions of the covariance; two rows of z a sample are kept meanwhile.
pub fn gradient(linear: &Linear, timeline: &Timeline, noise: &NoiseModel, nu: &[f64]) -> Option<Gradient> {
    let layout = coloured(&linear.layout, noise);
    let mut tape = Tape::default();
    let mut rows: Vec<[f64; 1]> = nu.iter().map(|nu| [*nu]).collect();
    let mut apart = Apart::<1>::new(&layout, timeline);
    let log_determinant = by_size!(layout.len(), recurse)(
        (linear, timeline, noise),
        layout.clone(),
        PART,
        (Some(&mut tape), &mut |gains, events| {
            let own = &mut rows[samples(timeline, &events)];
            apart.whiten((linear, timeline), (gains, events.start), events, own);
        }),
    )?;
    let white: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    let mut found = by_size!(layout.len(), back)((linear, timeline, noise), layout, &tape, &white);
    found.value = log_determinant + white.iter().map(|e| e * e).sum::<f64>();
    found.value.is_finite().then_some(found)
}

/// The way back over the whole run.
fn back<R: Row>(
    (linear, timeline, noise): (&Linear, &Timeline, &NoiseModel),
    layout: Layout,
    tape: &Tape,
    white: &[f64],
) -> Gradient {
    let means = colour_means(timeline, noise, &layout, (tape, white));
    let mut back = Back::<R>::new(layout, noise);
    wide(
        #[inline(always)]
        || back.go((linear, timeline, noise), (tape, white), &means),
    );
    back.found
}

/// Of every sample whose channel has a colour, the filter's mean of it before it moves on.
fn colour_means(timeline: &Timeline, noise: &NoiseModel, layout: &Layout, (tape, white): (&Tape, &[f64])) -> Vec<f64> {
    let (stride, at) = (layout.len().next_multiple_of(QUAD), layout.colours_at());
    let mut mean = vec![0.0; layout.colours];
    let mut before = Vec::new();
    for event in &timeline.events {
        let samples = event.first..event.first + event.count;
        for channel in &timeline.channel[samples.clone()] {
            if let Some(place) = layout.colour_of[*channel] {
                before.push(mean[place]);
                mean[place] *= noise.pole[*channel];
            }
        }
        for sample in samples {
            add(&mut mean, white[sample], &tape.v[sample * stride + at..]);
        }
    }
    before
}

#[cfg(test)]
mod tests;
