//! Covariance recursion: gains and innovation covariances of any noise on one linear model.
//!
//! Samples of one event are taken up one after the other, which needs no factorisation and gives its numbers all the same:
//!
//! ```text
//! v_a = P h_a / √s_a,   s_a = h_aᵀ P h_a + R_a,   P ← P − v_a v_aᵀ;   V = [v_0 v_1 …] = P Hᵀ L⁻ᵀ,   L_ab = h_aᵀ v_b,   K = V L⁻¹
//! ```
//!
//! The recursion is compiled for every few sizes of z by itself ([`Row`]), rows filled up with zeros to whole vectors; large ones share one.

use super::linear::Linear;
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

/// White part of coloured noise, as a share of its standard deviation: keeps covariances positive.
pub(super) const WHITE_SHARE: f64 = 1e-2;

/// Rows are whole fours of numbers.
pub(super) const QUAD: usize = 4;

/// `$f`, compiled for the size of z.
macro_rules! by_size {
    ($size:expr, $f:ident) => {
        match $size.div_ceil($crate::filter::gains::QUAD) {
            0 | 1 => $f::<[f64; 4]>,
            2 => $f::<[f64; 8]>,
            3 => $f::<[f64; 12]>,
            4 => $f::<[f64; 16]>,
            5 => $f::<[f64; 20]>,
            6 => $f::<[f64; 24]>,
            _ => $f::<Vec<f64>>,
        }
    };
}
pub(super) use by_size;

/// Numbers beside each other, one for every entry of z.
pub(super) trait Row {
    fn zeros(size: usize) -> Self;
    fn numbers(&self) -> &[f64];
    fn numbers_mut(&mut self) -> &mut [f64];
    /// The numbers, out of their place: they come back when they are done.
    fn taken(&mut self) -> Self;
}

impl<const S: usize> Row for [f64; S] {
    fn zeros(_: usize) -> Self {
        [0.0; S]
    }

    #[inline(always)]
    fn numbers(&self) -> &[f64] {
        self
    }

    #[inline(always)]
    fn numbers_mut(&mut self) -> &mut [f64] {
        self
    }

    #[inline(always)]
    fn taken(&mut self) -> Self {
        *self
    }
}

impl Row for Vec<f64> {
    fn zeros(size: usize) -> Self {
        vec![0.0; size]
    }

    #[inline(always)]
    fn numbers(&self) -> &[f64] {
        self
    }

    #[inline(always)]
    fn numbers_mut(&mut self) -> &mut [f64] {
        self
    }

    #[inline(always)]
    fn taken(&mut self) -> Self {
        core::mem::take(self)
    }
}

/// Who is told the gains of some events.
type Told<'t> = &'t mut dyn FnMut(&mut Gains, Range<usize>);

/// Gains of `noise` on `linear`; `None` where a covariance is not positive.
pub fn gains(linear: &Linear, timeline: &Timeline, noise: &NoiseModel) -> Option<Gains> {
    let mut whole = Gains::default();
    let log_determinant =
        gains_in_parts(linear, timeline, noise, usize::MAX, &mut |part, _| whole = core::mem::take(part))?;
    Some(Gains { log_determinant, ..whole })
}

/// Gains of `each` events after the other, told as they are found: places in a part count from its own first event. Returns `Σ ln |S|`.
pub fn gains_in_parts(
    linear: &Linear,
    timeline: &Timeline,
    noise: &NoiseModel,
    each: usize,
    told: Told<'_>,
) -> Option<f64> {
    let layout = coloured(&linear.layout, noise);
    by_size!(layout.len(), recurse)((linear, timeline, noise), layout, each, (None, told))
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
    (tape, told): (Option<&mut Tape>, Told<'_>),
) -> Option<f64> {
    let mut recursion = Recursion::<R>::new(&layout, &linear.initial_sigma);
    recursion.tape = tape.is_some().then(Tape::default);
    let same_as_frozen = layout.colours == 0 && linear.noise == *noise && linear.is_wide;
    let mut part = Gains { pole: noise.pole.clone(), same_as_frozen, layout, ..Gains::default() };
    let mut roots = Product::default();
    let events = timeline.events.len();
    let mut begin = 0;
    while begin < events {
        let range = begin..begin.saturating_add(each).min(events);
        begin = range.end;
        part.clear();
        let is_positive = wide(
            #[inline(always)]
            || recursion.advance((linear, timeline, noise), range.clone(), &mut part, &mut roots),
        );
        if !is_positive {
            return None;
        }
        told(&mut part, range);
    }
    if let (Some(tape), Some(written)) = (tape, recursion.tape) {
        *tape = written;
    }
    let log_determinant = 2.0 * roots.ln();
    log_determinant.is_finite().then_some(log_determinant)
}

/// What a recursion leaves for the way back: rows of z, filled up to whole vectors.
#[derive(Default)]
pub(super) struct Tape {
    /// Of every sample its row of measurement, `v` and `√s`.
    pub h: Vec<f64>,
    pub v: Vec<f64>,
    pub root: Vec<f64>,
    /// Of every sample whose channel has a colour: column of P at the colour before it moves on; zeros where it begins.
    pub colour: Vec<f64>,
}

impl Gains {
    fn clear(&mut self) {
        self.gain.clear();
        self.factor.clear();
        self.first.clear();
        self.factor_first.clear();
    }
}

/// Product of many numbers, kept where it neither overflows nor vanishes: few logarithms for all of them.
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

/// Covariance of z and scratch of its recursion.
pub(super) struct Recursion<R> {
    layout: Layout,
    size: usize,
    /// P by rows.
    p: Vec<R>,
    /// Rows of z × samples.
    pub gain: Vec<f64>,
    /// Lower Cholesky factor of S.
    pub factor: Vec<f64>,
    /// Per sample of the event: row of measurement, `v`, column of the gain.
    h: Vec<R>,
    v: Vec<R>,
    k: Vec<R>,
    /// `F P`, rows of the state, and the columns of F.
    moved: Vec<R>,
    columns: Vec<R>,
    tape: Option<Tape>,
}

/// `sum += factor · x`.
#[inline(always)]
pub(super) fn add(sum: &mut [f64], factor: f64, x: &[f64]) {
    for (sum, x) in sum.iter_mut().zip(x) {
        *sum += factor * x;
    }
}

/// `sum += Σ shareᵢ · rowᵢ`: as many numbers at once as the processor has room for.
#[inline(always)]
pub(super) fn combine<R: Row>(sum: &mut [f64], shares: &[f64], rows: &[R]) {
    let mut at = 0;
    while at + 4 * QUAD <= sum.len() {
        stretch::<4, R>(sum, shares, rows, at);
        at += 4 * QUAD;
    }
    if at + 2 * QUAD <= sum.len() {
        stretch::<2, R>(sum, shares, rows, at);
        at += 2 * QUAD;
    }
    if at + QUAD <= sum.len() {
        stretch::<1, R>(sum, shares, rows, at);
    }
}

/// [`combine`] of the `Q` fours of numbers from `at` on.
#[inline(always)]
fn stretch<const Q: usize, R: Row>(sum: &mut [f64], shares: &[f64], rows: &[R], at: usize) {
    let sum = &mut sum[at..at + Q * QUAD];
    let mut sums = [[0.0; QUAD]; Q];
    sums.iter_mut().zip(sum.chunks_exact(QUAD)).for_each(|(own, sum)| own.copy_from_slice(sum));
    for (share, row) in shares.iter().zip(rows) {
        for (own, x) in sums.iter_mut().zip(row.numbers()[at..at + Q * QUAD].chunks_exact(QUAD)) {
            for (own, x) in own.iter_mut().zip(x) {
                *own += share * x;
            }
        }
    }
    sum.chunks_exact_mut(QUAD).zip(&sums).for_each(|(sum, own)| sum.copy_from_slice(own));
}

#[inline(always)]
pub(super) fn product(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; QUAD];
    for (a, b) in a.chunks_exact(QUAD).zip(b.chunks_exact(QUAD)) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

impl<R: Row> Recursion<R> {
    pub fn new(layout: &Layout, initial_sigma: &[f64]) -> Self {
        let size = layout.len();
        let zeros = |count: usize| (0..count).map(|_| R::zeros(size.next_multiple_of(QUAD))).collect::<Vec<R>>();
        let mut p = zeros(size);
        for (i, sigma) in initial_sigma.iter().enumerate() {
            p[i].numbers_mut()[i] = sigma * sigma;
        }
        let moved = zeros(layout.tangent);
        let columns = zeros(layout.tangent + layout.noise_inputs.len());
        let (gain, factor) = (Vec::new(), Vec::new());
        let (h, v, k, tape) = (zeros(0), zeros(0), zeros(0), None);
        Self { layout: layout.clone(), size, p, gain, factor, h, v, k, moved, columns, tape }
    }

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
            self.renew(event.reset, noise);
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

    #[inline(always)]
    fn clear(&mut self, i: usize, variance: f64) {
        self.p[i].numbers_mut().fill(0.0);
        for row in &mut self.p {
            row.numbers_mut()[i] = 0.0;
        }
        self.p[i].numbers_mut()[i] = variance;
    }

    /// Standard deviations of the state and of the noise inputs.
    pub fn sigmas(&self) -> Vec<f64> {
        let count = self.layout.tangent + self.layout.noise_inputs.len();
        (0..count).map(|i| self.p[i].numbers()[i].sqrt()).collect()
    }

    /// Fresh actuator noise.
    #[inline(always)]
    pub fn renew(&mut self, reset: u64, noise: &NoiseModel) {
        for k in 0..self.layout.noise_inputs.len() {
            if reset >> self.layout.noise_inputs[k].min(63) & 1 == 1 {
                self.clear(self.layout.noise_at() + k, noise.input_sigma[k] * noise.input_sigma[k]);
            }
        }
    }

    /// The clone becomes the state.
    #[inline(always)]
    pub fn begin_mean(&mut self) {
        let (n, at) = (self.layout.clone, self.layout.clone_at());
        for i in 0..n {
            let state = self.p[i].taken();
            self.p[at + i].numbers_mut().copy_from_slice(state.numbers());
            self.p[i] = state;
        }
        self.p.iter_mut().for_each(|row| row.numbers_mut().copy_within(..n, at));
    }

    /// To the next event: `P ← F P Fᵀ`, F the identity but for the rows of the state.
    #[inline(always)]
    pub fn propagate(&mut self, transition: &[f64]) {
        let n = self.layout.tangent;
        let len = n + self.layout.noise_inputs.len();
        for (moved, row) in self.moved.iter_mut().zip(transition.chunks_exact(len.max(1))) {
            let mut sum = moved.taken();
            sum.numbers_mut().fill(0.0);
            combine(sum.numbers_mut(), row, &self.p);
            *moved = sum;
        }
        for (i, row) in transition.chunks_exact(len.max(1)).enumerate() {
            for (column, f) in self.columns.iter_mut().zip(row) {
                column.numbers_mut()[i] = *f;
            }
        }
        // rows of the state by the columns of F, what is beside the state as it is
        for (i, moved) in self.moved.iter().enumerate() {
            let moved = moved.numbers();
            let mut sum = self.p[i].taken();
            sum.numbers_mut().fill(0.0);
            combine(sum.numbers_mut(), moved, &self.columns);
            sum.numbers_mut()[n..].copy_from_slice(&moved[n..]);
            self.p[i] = sum;
        }
        for i in 0..n {
            let row = self.p[i].taken();
            for (p, own) in self.p[i + 1..].iter_mut().zip(&row.numbers()[i + 1..]) {
                p.numbers_mut()[i] = *own;
            }
            self.p[i] = row;
        }
    }

    /// Coloured noise and lags move on, then the measurement: `gain`, `factor` and P.
    #[inline(always)]
    pub fn update(
        &mut self,
        noise: &NoiseModel,
        channels: &[usize],
        rows: &[f64],
        (decay, slope): (&[f64], &[f64]),
    ) -> bool {
        let count = channels.len();
        let row_len = rows.len() / count;
        while self.h.len() < count {
            let size = self.size.next_multiple_of(QUAD);
            [&mut self.h, &mut self.v, &mut self.k].into_iter().for_each(|list| list.push(R::zeros(size)));
        }
        self.factor.clear();
        self.factor.resize(count * count, 0.0);
        for (slot, channel) in channels.iter().enumerate() {
            self.colour(noise, *channel);
            self.lag(*channel, &rows[slot * row_len..(slot + 1) * row_len], decay[slot]);
        }
        for (slot, channel) in channels.iter().enumerate() {
            self.fill_row(slot, *channel, &rows[slot * row_len..(slot + 1) * row_len]);
            let sigma = noise.sensor_sigma[*channel];
            let white = if self.layout.colour_of[*channel].is_some() { WHITE_SHARE * sigma } else { sigma };
            let early = noise.jitter_s[*channel] * slope[slot];
            if !self.absorb(slot, count, white * white + early * early) {
                return false;
            }
        }
        for (i, row) in self.p.iter_mut().enumerate() {
            row.numbers_mut()[i] = row.numbers()[i].max(0.0);
        }
        self.solve(count);
        true
    }

    #[inline(always)]
    fn colour(&mut self, noise: &NoiseModel, channel: usize) {
        let Some(place) = self.layout.colour_of[channel] else { return };
        let (at, a) = (self.layout.colours_at() + place, noise.pole[channel]);
        let sigma = noise.sensor_sigma[channel];
        if let Some(tape) = &mut self.tape {
            tape.colour.extend_from_slice(self.p[at].numbers());
        }
        if self.p[at].numbers()[at] == 0.0 {
            // stationary from the first sample on
            self.p[at].numbers_mut()[at] = sigma * sigma;
        }
        for p in self.p[at].numbers_mut() {
            *p *= a;
        }
        for row in &mut self.p {
            row.numbers_mut()[at] *= a;
        }
        self.p[at].numbers_mut()[at] += (1.0 - a * a) * sigma * sigma;
    }

    #[inline(always)]
    fn lag(&mut self, channel: usize, row: &[f64], decay: f64) {
        let Some(place) = self.layout.lag_of[channel] else { return };
        let at = self.layout.lags_at() + place;
        let mut mixed = self.p[at].taken();
        mixed.numbers_mut().iter_mut().for_each(|p| *p *= decay);
        // what the lag takes in lies before and behind it
        for (i, h) in self.layout.places(row) {
            add(mixed.numbers_mut(), (1.0 - decay) * h, self.p[i].numbers());
        }
        let own = decay * mixed.numbers()[at]
            + self.layout.places(row).map(|(i, h)| (1.0 - decay) * h * mixed.numbers()[i]).sum::<f64>();
        mixed.numbers_mut()[at] = own;
        self.p[at] = mixed;
        for j in 0..self.size {
            self.p[j].numbers_mut()[at] = self.p[at].numbers()[j];
        }
    }

    #[inline(always)]
    fn fill_row(&mut self, slot: usize, channel: usize, row: &[f64]) {
        let h = self.h[slot].numbers_mut();
        h.fill(0.0);
        if let Some(place) = self.layout.lag_of[channel] {
            h[self.layout.lags_at() + place] = 1.0;
        } else {
            self.layout.places(row).for_each(|(i, own)| h[i] = own);
        }
        if let Some(place) = self.layout.colour_of[channel] {
            h[self.layout.colours_at() + place] = 1.0;
        }
    }

    /// Takes up one sample of variance `own`: its `v`, its row of the factor and P; false where its innovation's variance is not positive.
    #[inline(always)]
    fn absorb(&mut self, slot: usize, count: usize, own: f64) -> bool {
        let mut v = self.v[slot].taken();
        v.numbers_mut().fill(0.0);
        let h = self.h[slot].numbers();
        combine(v.numbers_mut(), h, &self.p);
        let variance = product(h, v.numbers()) + own;
        if !(variance > 0.0 && variance.is_finite()) {
            return false;
        }
        let root = variance.sqrt();
        self.factor[slot * count + slot] = root;
        if let Some(tape) = &mut self.tape {
            tape.h.extend_from_slice(h);
            tape.root.push(root);
        }
        let share = 1.0 / root;
        for v in v.numbers_mut() {
            *v *= share;
        }
        for (before, factor) in self.v[..slot].iter().zip(&mut self.factor[slot * count..]) {
            *factor = product(h, before.numbers());
        }
        for (p, taken) in self.p.iter_mut().zip(v.numbers()) {
            add(p.numbers_mut(), -taken, v.numbers());
        }
        if let Some(tape) = &mut self.tape {
            tape.v.extend_from_slice(v.numbers());
        }
        self.v[slot] = v;
        true
    }

    /// `K = V L⁻¹`, from the last sample to the first.
    #[inline(always)]
    fn solve(&mut self, count: usize) {
        self.gain.clear();
        self.gain.resize(self.size * count, 0.0);
        for a in (0..count).rev() {
            let mut k = self.k[a].taken();
            k.numbers_mut().copy_from_slice(self.v[a].numbers());
            for (b, later) in self.k.iter().enumerate().take(count).skip(a + 1) {
                add(k.numbers_mut(), -self.factor[b * count + a], later.numbers());
            }
            let share = 1.0 / self.factor[a * count + a];
            for (k, gain) in k.numbers_mut().iter_mut().zip(self.gain.chunks_exact_mut(count)) {
                *k *= share;
                gain[a] = *k;
            }
            self.k[a] = k;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;
    use nalgebra::{Cholesky, DMatrix};

    /// Taken up one by one, samples of one event have the gain and the factor of the joint update, and so has what is left of P.
    fn one_by_one_is_the_joint_update<R: Row>(count: usize) {
        let (n, m, s) = (3, 1, 4);
        let drawn = |seed: u64, rows: usize, columns: usize| {
            DMatrix::from_row_slice(rows, columns, &Noise::new(seed).series(rows * columns, 1.0))
        };
        let layout = Layout {
            tangent: n,
            noise_inputs: vec![0; m],
            lag_of: vec![None; count],
            colour_of: vec![None; count],
            ..Layout::default()
        };
        let mut recursion = Recursion::<R>::new(&layout, &vec![1.0; n]);
        let root = drawn(1, s, s);
        let p = &root * root.transpose();
        for i in 0..s {
            (0..s).for_each(|j| recursion.p[i].numbers_mut()[j] = p[(i, j)]);
        }
        let h = drawn(2, count, s);
        let noise = NoiseModel {
            input_sigma: vec![1.0; m],
            sensor_sigma: (0..count).map(|c| 0.3 + 0.2 * c as f64).collect(),
            pole: vec![0.0; count],
            jitter_s: (0..count).map(|c| 0.1 * c as f64).collect(),
        };
        let slope: Vec<f64> = (0..count).map(|c| 1.0 + c as f64).collect();
        let channels: Vec<usize> = (0..count).collect();
        let rows: Vec<f64> = h.transpose().iter().copied().collect();
        assert!(recursion.update(&noise, &channels, &rows, (&vec![0.0; count], &slope)));
        let variance = |c: usize| noise.sensor_sigma[c].powi(2) + (noise.jitter_s[c] * slope[c]).powi(2);
        let covariance =
            &h * &p * h.transpose() + DMatrix::from_fn(count, count, |i, j| if i == j { variance(i) } else { 0.0 });
        let gain = &p * h.transpose() * covariance.clone().try_inverse().unwrap();
        let factor = Cholesky::new(covariance.clone()).unwrap().l();
        let left = &p - &gain * &covariance * gain.transpose();
        let apart = |a: &DMatrix<f64>, b: &DMatrix<f64>| (a - b).amax();
        assert!(apart(&DMatrix::from_row_slice(s, count, &recursion.gain), &gain) < 1e-10);
        assert!(apart(&DMatrix::from_row_slice(count, count, &recursion.factor), &factor) < 1e-10);
        assert!(apart(&DMatrix::from_fn(s, s, |i, j| recursion.p[i].numbers()[j]), &left) < 1e-10);
    }

    #[test]
    fn samples_of_an_event_taken_up_one_by_one_are_the_joint_update() {
        for count in 1..=4 {
            one_by_one_is_the_joint_update::<[f64; 4]>(count);
            one_by_one_is_the_joint_update::<Vec<f64>>(count);
        }
    }

    #[test]
    fn a_product_of_many_numbers_has_the_sum_of_their_logarithms() {
        let numbers: Vec<f64> = (0..2000).map(|k| libm::exp(150.0 * libm::sin(k as f64))).collect();
        let mut product = Product::default();
        numbers.iter().for_each(|x| product.times(*x));
        let sum: f64 = numbers.iter().map(|x| libm::log(*x)).sum();
        assert!((product.ln() - sum).abs() < 1e-8 * numbers.len() as f64, "{} {sum}", product.ln());
    }
}
