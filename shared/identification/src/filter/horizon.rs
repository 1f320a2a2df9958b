//! Predictions over a horizon: a filter that goes on without its readings for some time, again and
//! again.
//!
//! A plant that integrates is driven away by disturbances alone, however right it is. The run is
//! cut into windows; in each the plant is left to itself from the filtered state at its beginning.
//! On the linear model of a pass, d being what a state differs by from the filtered one of that
//! pass (as in `whiten`), of the filter and of the free run
//!
//! ```text
//! filter:   ν' = ν − H d − v̂',  d ← d + K' ν' − K ν,  d ← F d,   P ← (1 − K' H) P,  P ← F P Fᵀ + Q
//! free run: e = ν − H d',       d' ← d' − K ν,        d' ← F d', P' ← F P' Fᵀ + Q,   E e² = H P' Hᵀ + R
//! window:   d' = d, P' = P
//! ```

use super::gains::coloured;
use super::linear::Linear;
use super::recursion::Recursion;
use super::rows::{Row, by_size};
use super::whiten::reading_difference;
use super::{Layout, NoiseModel};
use crate::dot::dot;
use crate::problem::{Event, Timeline};

/// Of every sample its distance from a free run over a window, and the variance that noise alone
/// gives it; NaN before the first window.
#[derive(Clone, Debug, Default)]
pub struct Ahead {
    pub residual: Vec<f64>,
    pub variance: Vec<f64>,
}

/// Predictions over windows of so many events under `noise`, the first one behind `begin` events,
/// from innovations `nu` of the pass: those of `linear`, or what a parameter changes them by, since
/// distances are linear in them. `None` where a covariance is not positive.
///
/// Cost: two filters.
pub fn ahead(
    (linear, nu): (&Linear, &[f64]),
    timeline: &Timeline,
    noise: &NoiseModel,
    window: usize,
    begin: usize,
) -> Option<Ahead> {
    let layout = coloured(&linear.layout, noise);
    let size = layout.len();
    by_size!(size, run)(&Pass { linear, nu, timeline, noise, layout }, window.max(1), begin)
}

struct Pass<'a> {
    linear: &'a Linear,
    nu: &'a [f64],
    timeline: &'a Timeline,
    noise: &'a NoiseModel,
    layout: Layout,
}

/// What a state differs by, and its covariance.
struct Side<R> {
    d: Vec<[f64; 1]>,
    next: Vec<f64>,
    spread: Recursion<R>,
}

fn run<R: Row>(pass: &Pass<'_>, window: usize, begin: usize) -> Option<Ahead> {
    let (linear, timeline) = (pass.linear, pass.timeline);
    let (mut filter, mut free) = (Side::<R>::new(pass), Side::<R>::new(pass));
    let row_len = linear.row_len();
    let blank = vec![f64::NAN; timeline.value.len()];
    let mut ahead = Ahead { residual: blank.clone(), variance: blank };
    for (k, event) in timeline.events.iter().enumerate() {
        [&mut filter, &mut free].into_iter().for_each(|side| side.renew(pass, event));
        let own = event.first..event.first + event.count;
        if event.count > 0 {
            let rows = &linear.measurement[own.start * row_len..own.end * row_len];
            let channels = &timeline.channel[own.clone()];
            let lags = (&linear.decay[own.clone()], &linear.slope[own.clone()]);
            let spread = free.spread.spread(pass.noise, channels, rows, lags);
            let residual = free.innovations(pass, event);
            if k > begin {
                ahead.residual[own.clone()].copy_from_slice(&residual);
                ahead.variance[own].copy_from_slice(&spread);
            }
            let new = filter.innovations(pass, event);
            if !filter.spread.update(pass.noise, channels, rows, lags) {
                return None;
            }
            let size = pass.layout.len();
            for i in 0..size {
                filter.d[i][0] += dot(&filter.spread.gain[i * event.count..(i + 1) * event.count], &new);
            }
            [&mut filter, &mut free].into_iter().for_each(|side| side.leave(pass, k));
        }
        if k >= begin && (k - begin).is_multiple_of(window) {
            free.d.copy_from_slice(&filter.d);
            free.spread.take_covariance(&filter.spread);
        }
        [&mut filter, &mut free].into_iter().for_each(|side| side.go_on(pass, k));
    }
    Some(ahead)
}

impl<R: Row> Side<R> {
    fn new(pass: &Pass<'_>) -> Self {
        let spread = Recursion::<R>::new(&pass.layout, &pass.linear.initial_sigma);
        Self { d: vec![[0.0]; pass.layout.len()], next: vec![0.0; pass.layout.tangent], spread }
    }

    /// Fresh actuator noise.
    fn renew(&mut self, pass: &Pass<'_>, event: &Event) {
        self.spread.renew(event, pass.noise);
        for (i, input) in pass.layout.noise_inputs.iter().enumerate() {
            if event.reset >> (*input).min(63) & 1 == 1 {
                self.d[pass.layout.noise_at() + i] = [0.0];
            }
        }
    }

    /// `ν − H d` of the samples of an event.
    fn innovations(&mut self, pass: &Pass<'_>, event: &Event) -> Vec<f64> {
        let colour = (&pass.layout, &pass.noise.pole[..]);
        let samples = event.first..event.first + event.count;
        samples
            .map(|s| pass.nu[s] - reading_difference(pass.linear, pass.timeline, colour, s, &mut self.d)[0])
            .collect()
    }

    /// `d ← d − K ν`, of the pass.
    fn leave(&mut self, pass: &Pass<'_>, k: usize) {
        let (event, frozen) = (&pass.timeline.events[k], &pass.linear.frozen);
        let nu = &pass.nu[event.first..event.first + event.count];
        let gain = frozen.gain[frozen.first[k]..].chunks_exact(event.count);
        self.d.iter_mut().zip(gain).take(frozen.rows).for_each(|(d, gain)| d[0] -= dot(gain, nu));
    }

    /// To the next event.
    fn go_on(&mut self, pass: &Pass<'_>, k: usize) {
        let layout = &pass.layout;
        let (n, len) = (layout.tangent, layout.lags_at());
        if pass.timeline.events[k].begins_mean && layout.clone > 0 {
            self.spread.begin_mean();
            self.d.copy_within(..n, layout.clone_at());
        }
        if k + 1 < pass.timeline.events.len() {
            let transition = &pass.linear.transition[k * n * len..(k + 1) * n * len];
            self.spread.propagate(transition);
            for (next, row) in self.next.iter_mut().zip(transition.chunks_exact(len.max(1))) {
                *next = row.iter().zip(&self.d).map(|(f, d)| f * d[0]).sum();
            }
            self.d.iter_mut().zip(&self.next).for_each(|(d, next)| d[0] = *next);
        }
    }
}

#[cfg(test)]
mod tests;
