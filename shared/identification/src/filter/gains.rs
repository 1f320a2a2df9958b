//! Gains and innovation covariances of any noise on one linear model.

use super::linear::Linear;
use super::recursion::{Recursion, Tape};
use super::rows::{Row, by_size};
use super::wide::wide;
use super::{Layout, NoiseModel};
use crate::problem::Timeline;
use core::ops::Range;

/// Gains of one run under one noise, innovations' Cholesky factors, and their log-determinant.
#[derive(Clone, Debug, Default)]
pub struct Gains {
    pub layout: Layout,
    /// Per event, rows of z × samples.
    pub gain: Vec<f64>,
    pub first: Vec<usize>,
    /// Per event, samples × samples, lower.
    pub factor: Vec<f64>,
    pub factor_first: Vec<usize>,
    /// `Σ ln |S|`.
    pub log_determinant: f64,
    pub pole: Vec<f64>,
    /// Same gains as the frozen pass: its innovations need only be scaled.
    pub same_as_frozen: bool,
}

/// Receives the gains of some events.
type Receive<'t> = &'t mut dyn FnMut(&mut Gains, Range<usize>);

/// Gains of `noise` on `linear`; `None` where a covariance is not positive.
pub fn gains(linear: &Linear, timeline: &Timeline, noise: &NoiseModel) -> Option<Gains> {
    let mut whole = Gains::default();
    let log_determinant =
        gains_in_parts(linear, timeline, noise, usize::MAX, &mut |part, _| whole = core::mem::take(part))?;
    Some(Gains { log_determinant, ..whole })
}

/// Gains of `each` events after the other, handed on as they are found: places in a part count from
/// its own first event. Returns `Σ ln |S|`.
pub fn gains_in_parts(
    linear: &Linear,
    timeline: &Timeline,
    noise: &NoiseModel,
    each: usize,
    receive: Receive<'_>,
) -> Option<f64> {
    let layout = coloured(&linear.layout, noise);
    by_size!(layout.len(), recurse)((linear, timeline, noise), layout, each, (None, receive))
}

/// Median over the run of the standard deviation of every number of the state, as it is predicted;
/// `None` where a covariance is not positive.
pub fn state_sigmas(linear: &Linear, timeline: &Timeline, noise: &NoiseModel) -> Option<Vec<f64>> {
    let layout = coloured(&linear.layout, noise);
    let (n, events) = (layout.tangent, timeline.events.len());
    let mut recursion = Recursion::<Vec<f64>>::new(&layout, &linear.initial_sigma);
    let (mut part, mut roots) = (Gains { layout, ..Gains::default() }, Product::default());
    let mut sigmas = vec![Vec::with_capacity(events); n];
    let mut here = vec![0.0; n];
    for k in 0..events {
        part.clear();
        recursion.advance((linear, timeline, noise), k..k + 1, &mut part, &mut roots).then_some(())?;
        recursion.write_sigmas(&mut here);
        sigmas.iter_mut().zip(&here).for_each(|(all, sigma)| all.push(*sigma));
    }
    let median = |mut all: Vec<f64>| {
        let middle = all.len() / 2;
        all.select_nth_unstable_by(middle, f64::total_cmp);
        all[middle]
    };
    (events > 0).then(|| sigmas.into_iter().map(median).collect())
}

/// `layout` with a place for the colour of every channel that has one.
pub(super) fn coloured(layout: &Layout, noise: &NoiseModel) -> Layout {
    let mut layout = Layout { colours: 0, ..layout.clone() };
    let place = |pole: &f64| {
        let place = (*pole != 0.0).then_some(layout.colours);
        layout.colours += usize::from(place.is_some());
        place
    };
    layout.colour_of = noise.pole.iter().map(place).collect();
    layout
}

/// [`gains_in_parts`], written down on a tape where one is given.
pub(super) fn recurse<R: Row>(
    (linear, timeline, noise): (&Linear, &Timeline, &NoiseModel),
    layout: Layout,
    each: usize,
    (tape, receive): (Option<&mut Tape>, Receive<'_>),
) -> Option<f64> {
    let mut recursion = Recursion::<R>::new(&layout, &linear.initial_sigma);
    recursion.tape = tape.is_some().then(Tape::default);
    let same_as_frozen = layout.colours == 0 && linear.noise == *noise && linear.is_wide;
    let mut part = Gains { pole: noise.pole.clone(), same_as_frozen, layout, ..Gains::default() };
    let mut roots = Product::default();
    let events = timeline.events.len();
    let kept = part.same_as_frozen && tape.is_none() && !linear.factor.is_empty();
    let mut from = 0;
    let mut begin = 0;
    while begin < events {
        let range = begin..begin.saturating_add(each).min(events);
        begin = range.end;
        part.clear();
        if kept {
            from = part.keep((linear, timeline), range.clone(), from, &mut roots);
            receive(&mut part, range);
            continue;
        }
        let is_positive = wide(
            #[inline(always)]
            || recursion.advance((linear, timeline, noise), range.clone(), &mut part, &mut roots),
        );
        if !is_positive {
            return None;
        }
        receive(&mut part, range);
    }
    if let (Some(tape), Some(written)) = (tape, recursion.tape) {
        *tape = written;
    }
    let log_determinant = 2.0 * roots.ln();
    log_determinant.is_finite().then_some(log_determinant)
}

impl Gains {
    /// Gains and factors of `range` as the pass kept them, its factors from place `from` on; the
    /// place behind them.
    fn keep(
        &mut self,
        (linear, timeline): (&Linear, &Timeline),
        range: Range<usize>,
        mut from: usize,
        roots: &mut Product,
    ) -> usize {
        for k in range {
            let count = timeline.events[k].count;
            self.first.push(self.gain.len());
            self.factor_first.push(self.factor.len());
            let gain = &linear.frozen.gain[linear.frozen.first[k]..];
            self.gain.extend_from_slice(&gain[..linear.frozen.rows * count]);
            self.factor.extend_from_slice(&linear.factor[from..from + count * count]);
            (0..count).for_each(|slot| roots.times(linear.factor[from + slot * (count + 1)]));
            from += count * count;
        }
        from
    }

    fn clear(&mut self) {
        self.gain.clear();
        self.factor.clear();
        self.first.clear();
        self.factor_first.clear();
    }
}

/// Product of many numbers, kept where it neither overflows nor vanishes: few logarithms for all of
/// them.
struct Product {
    ln: f64,
    rest: f64,
}

impl Default for Product {
    fn default() -> Self {
        Self { ln: 0.0, rest: 1.0 }
    }
}

impl Product {
    /// `x` is a square root: its own range leaves room beside that of the rest.
    #[inline(always)]
    fn times(&mut self, x: f64) {
        if !(1e-100..1e100).contains(&self.rest) {
            self.ln += libm::log(self.rest);
            self.rest = 1.0;
        }
        self.rest *= x;
    }

    fn ln(&self) -> f64 {
        self.ln + libm::log(self.rest)
    }
}

impl<R: Row> Recursion<R> {
    /// Goes on over `range`; false where a covariance is not positive.
    #[inline(always)]
    fn advance(
        &mut self,
        (linear, timeline, noise): (&Linear, &Timeline, &NoiseModel),
        range: Range<usize>,
        out: &mut Gains,
        roots: &mut Product,
    ) -> bool {
        let (n, m, row_len) = (self.layout.tangent, self.layout.noise_inputs.len(), linear.row_len());
        for k in range {
            let event = &timeline.events[k];
            self.renew(event, noise);
            out.first.push(out.gain.len());
            out.factor_first.push(out.factor.len());
            if event.count > 0 {
                let samples = event.first..event.first + event.count;
                let rows = &linear.measurement[event.first * row_len..(event.first + event.count) * row_len];
                let channels = &timeline.channel[samples.clone()];
                if !self.update(noise, channels, rows, (&linear.decay[samples.clone()], &linear.slope[samples])) {
                    return false;
                }
                out.gain.extend_from_slice(&self.gain);
                out.factor.extend_from_slice(&self.factor);
                for slot in 0..event.count {
                    roots.times(self.factor[slot * (event.count + 1)]);
                }
            }
            if event.begins_mean {
                self.begin_mean();
            }
            if k + 1 < timeline.events.len() {
                self.propagate(&linear.transition[k * n * (n + m)..(k + 1) * n * (n + m)]);
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_of_many_numbers_has_the_sum_of_their_logarithms() {
        let numbers: Vec<f64> = (0..2000).map(|k| libm::exp(150.0 * libm::sin(k as f64))).collect();
        let mut product = Product::default();
        numbers.iter().for_each(|x| product.times(*x));
        let sum: f64 = numbers.iter().map(|x| libm::log(*x)).sum();
        assert!((product.ln() - sum).abs() < 1e-8 * numbers.len() as f64, "{} {sum}", product.ln());
    }
}
