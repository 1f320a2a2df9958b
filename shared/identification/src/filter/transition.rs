//! `[Φ | Γ]` from one event to the next.
//!
//! By differences of the very flow; of large plants from slopes in the middle of every step of
//! integration, which are a fourth of its evaluations:
//!
//! ```text
//! [Φ | Γ] = exp(h [A B; 0 0]),   A = ∂f/∂x, B = ∂f/∂w in the middle of the step
//!     error (ω h)²/24 of what A changes by
//! ```
//!
//! One flow of a change of everything at once, as large as the filter's standard deviations are,
//! tells whether that is the flow's own: where a law turns within the step it is not, and all flows
//! are taken.

use super::jacobian::Slopes;
use super::linear::STEP;
use super::propagator::{Mean, Propagator};
use super::wide::wide;

/// Numbers of a change from which slopes are worth their bookkeeping.
const LARGE: usize = 8;
/// Share of a standard deviation that the probe may be off by, and rounding of its flow.
const AGREES: f64 = 0.01;
const ROUNDING: f64 = 1e-14;
/// Powers of the series: those of the method of integration.
const POWERS: usize = 4;

pub(super) struct Transitions {
    /// Numbers of a change of state, and of the noise inputs.
    n: usize,
    m: usize,
    by_slopes: bool,
    delta: Vec<f64>,
    moved: Vec<f64>,
    base: Vec<f64>,
    w: Vec<f64>,
    difference: Vec<f64>,
    middle: Vec<f64>,
    slope: Vec<f64>,
    slope_moved: Vec<f64>,
    /// `h [A | B]`, a power of it, the series of one step, and the product before it.
    rates: Vec<f64>,
    power: Vec<f64>,
    own: Vec<f64>,
    next: Vec<f64>,
}

impl Transitions {
    /// Workspace for the transitions of one propagator; all memory is allocated here.
    pub fn new(propagator: &Propagator<'_>) -> Self {
        let (x, n, m) = (propagator.x0.len(), propagator.layout.tangent, propagator.layout.noise_inputs.len());
        let zeros = |count: usize| vec![0.0; count];
        let matrix = || zeros(n * (n + m));
        Self {
            n,
            m,
            by_slopes: is_by_slopes(propagator),
            delta: zeros(n + m),
            moved: zeros(x),
            base: zeros(x),
            w: zeros(m),
            difference: zeros(n),
            middle: zeros(x),
            slope: zeros(x),
            slope_moved: zeros(x),
            rates: matrix(),
            power: matrix(),
            own: matrix(),
            next: matrix(),
        }
    }

    /// Moves the mean to the event behind `k` and writes `[Φ | Γ]`; `sigmas` of the state and the
    /// noise inputs at `k`.
    pub fn write(
        &mut self,
        propagator: &mut Propagator<'_>,
        k: usize,
        mean: &mut Mean,
        sigmas: &[f64],
        out: &mut [f64],
    ) {
        self.w.copy_from_slice(&mean.w);
        self.base.copy_from_slice(&mean.x);
        if self.by_slopes {
            self.take_slopes(propagator, k, out);
            if self.is_that_of_the_flow(propagator, k, mean, sigmas, out) {
                mean.x.copy_from_slice(&self.base);
                return;
            }
        } else {
            propagator.flow(k, &mut self.base, &self.w);
        }
        self.take_flows(propagator, k, mean, out);
        mean.x.copy_from_slice(&self.base);
    }

    /// Moves the mean to the event behind `k`, where the rates there are to be found.
    pub fn arrive(&mut self, propagator: &mut Propagator<'_>, k: usize, mean: &Mean) -> &[f64] {
        self.w.copy_from_slice(&mean.w);
        self.base.copy_from_slice(&mean.x);
        propagator.flow(k, &mut self.base, &self.w);
        &self.base
    }

    /// Behind [`Transitions::arrive`], [`Transitions::write`] by rates `[A | B]` of the whole
    /// interval.
    pub fn write_by(
        &mut self,
        propagator: &mut Propagator<'_>,
        k: usize,
        mean: &mut Mean,
        (sigmas, slopes): (&[f64], &Slopes),
        out: &mut [f64],
    ) {
        let (n, m, len) = (self.n, self.m, self.n + self.m);
        let (parts, event) = (propagator.parts(k), propagator.timeline.events[k]);
        let h = event.step_s * event.steps as f64 / parts as f64;
        for (i, rates) in self.rates.chunks_exact_mut(len).enumerate() {
            let row = slopes.a[i * n..(i + 1) * n].iter().chain(&slopes.b[i * m..(i + 1) * m]);
            rates.iter_mut().zip(row).for_each(|(rate, slope)| *rate = h * slope);
        }
        let Self { rates, power, next, own, .. } = self;
        wide(
            #[inline(always)]
            || {
                taylor((rates, n, len), power, next, own);
                out.copy_from_slice(own);
                for _ in 1..parts {
                    then((own, n, len), out, next);
                }
            },
        );
        if !self.is_that_of_the_flow(propagator, k, mean, sigmas, out) {
            self.take_flows(propagator, k, mean, out);
        }
        mean.x.copy_from_slice(&self.base);
    }

    /// Of a flow for every number, beside that of the mean in `base`.
    fn take_flows(&mut self, propagator: &mut Propagator<'_>, k: usize, mean: &Mean, out: &mut [f64]) {
        let (n, m) = (self.n, self.m);
        for column in 0..n + m {
            if column < n {
                self.delta.fill(0.0);
                self.delta[column] = STEP;
                propagator.system.retract(&mean.x, &self.delta[..n], &mut self.moved);
            } else {
                self.moved.copy_from_slice(&mean.x);
                self.w[column - n] += STEP;
            }
            propagator.flow(k, &mut self.moved, &self.w);
            if column >= n {
                self.w[column - n] = mean.w[column - n];
            }
            propagator.system.difference(&self.base, &self.moved, &mut self.difference);
            for row in 0..n {
                out[row * (n + m) + column] = self.difference[row] / STEP;
            }
        }
    }

    /// Of the slopes in the middle of every step; `base` goes from event to event.
    fn take_slopes(&mut self, propagator: &mut Propagator<'_>, k: usize, out: &mut [f64]) {
        let (n, len) = (self.n, self.n + self.m);
        out.fill(0.0);
        (0..n).for_each(|i| out[i * len + i] = 1.0);
        for part in 0..propagator.parts(k) {
            let (_, h, _) = propagator.part(k, part, &self.w);
            self.moved.copy_from_slice(&self.base);
            propagator.advance(k, part, &mut self.base, &self.w);
            propagator.middle(&self.moved, h, &mut self.middle);
            self.take_rates(propagator, (k, part), h);
            taylor((&self.rates, n, len), &mut self.power, &mut self.next, &mut self.own);
            then((&self.own, n, len), out, &mut self.next);
        }
    }

    /// `h [A | B]` in `middle`.
    fn take_rates(&mut self, propagator: &mut Propagator<'_>, (k, part): (usize, usize), h: f64) {
        let (n, len) = (self.n, self.n + self.m);
        propagator.slope_within(k, part, &self.middle, &self.w, &mut self.slope);
        for column in 0..len {
            let number = if column < n { &mut self.middle[column] } else { &mut self.w[column - n] };
            let before = core::mem::replace(number, *number + STEP);
            propagator.slope_within(k, part, &self.middle, &self.w, &mut self.slope_moved);
            *if column < n { &mut self.middle[column] } else { &mut self.w[column - n] } = before;
            for row in 0..n {
                self.rates[row * len + column] = h * (self.slope_moved[row] - self.slope[row]) / STEP;
            }
        }
    }

    /// A change of everything at once goes the same way by the flow.
    fn is_that_of_the_flow(
        &mut self,
        propagator: &mut Propagator<'_>,
        k: usize,
        mean: &Mean,
        sigmas: &[f64],
        matrix: &[f64],
    ) -> bool {
        let (n, len) = (self.n, self.n + self.m);
        let largest = sigmas.iter().copied().fold(0.0, f64::max);
        if largest <= 0.0 {
            return false;
        }
        for (i, (delta, sigma)) in self.delta.iter_mut().zip(sigmas).enumerate() {
            *delta = STEP * sigma / largest * if i % 3 == 1 { -1.0 } else { 1.0 };
        }
        propagator.system.retract(&mean.x, &self.delta[..n], &mut self.moved);
        self.w.iter_mut().zip(&self.delta[n..]).for_each(|(w, delta)| *w += delta);
        propagator.flow(k, &mut self.moved, &self.w);
        self.w.copy_from_slice(&mean.w);
        propagator.system.difference(&self.base, &self.moved, &mut self.difference);
        (0..n).all(|i| {
            let shares = || matrix[i * len..(i + 1) * len].iter().zip(&self.delta).map(|(f, delta)| f * delta);
            let (sum, square) = shares().fold((0.0, 0.0), |(sum, square), share| (sum + share, square + share * share));
            let off = (self.difference[i] - sum).abs();
            off <= AGREES * f64::sqrt(square) + ROUNDING * (1.0 + self.base[i].abs())
        })
    }
}

/// Of many numbers, none of them of a turn, which is no sum.
fn is_by_slopes(propagator: &Propagator<'_>) -> bool {
    let layout = &propagator.layout;
    layout.tangent + layout.noise_inputs.len() >= LARGE && propagator.x0.len() == layout.tangent
}

/// What was before goes through the step `own`, and its own inputs join.
#[inline(always)]
fn then((own, n, len): (&[f64], usize, usize), out: &mut [f64], next: &mut [f64]) {
    product((own, n, len), out, next);
    for (next, own) in next.chunks_exact_mut(len).zip(own.chunks_exact(len)) {
        next[n..].iter_mut().zip(&own[n..]).for_each(|(next, own)| *next += own);
    }
    out.copy_from_slice(next);
}

/// `[Z⁰ + … + Z⁴/4! | (1 + Z/2 + … + Z³/4!) B]` of `[Z | B]`, `n` rows of `len`: what the method of
/// integration takes of the flow of a linear system.
#[inline(always)]
fn taylor((rates, n, len): (&[f64], usize, usize), power: &mut [f64], next: &mut [f64], out: &mut [f64]) {
    power.copy_from_slice(rates);
    out.copy_from_slice(rates);
    (0..n).for_each(|i| out[i * len + i] += 1.0);
    for k in 2..=POWERS {
        product((rates, n, len), power, next);
        power.iter_mut().zip(&*next).for_each(|(power, next)| *power = next / k as f64);
        out.iter_mut().zip(&*power).for_each(|(out, power)| *out += power);
    }
}

/// The first `n` columns of `a` by `b`, both `n` rows of `len`.
#[inline(always)]
fn product((a, n, len): (&[f64], usize, usize), b: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    for (out, row) in out.chunks_exact_mut(len).zip(a.chunks_exact(len)) {
        for (factor, b) in row[..n].iter().zip(b.chunks_exact(len)).filter(|(factor, _)| **factor != 0.0) {
            out.iter_mut().zip(b).for_each(|(out, b)| *out += factor * b);
        }
    }
}

#[cfg(test)]
mod tests;
