//! Covariance recursion: gains and innovation covariances of any noise on one linear model.
//!
//! Samples of one event are taken up one after the other, which needs no factorisation and gives its numbers all the same:
//!
//! ```text
//! v_a = P h_a / √s_a,   s_a = h_aᵀ P h_a + R_a,   P ← P − v_a v_aᵀ;   V = [v_0 v_1 …] = P Hᵀ L⁻ᵀ,   L_ab = h_aᵀ v_b,   K = V L⁻¹
//! ```
//!
//! The recursion is compiled for every small size of z by itself ([`Row`]); larger ones share one.

use super::linear::Linear;
use super::{Layout, NoiseModel};
use crate::problem::Timeline;

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
const WHITE_SHARE: f64 = 1e-2;

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

    fn numbers(&self) -> &[f64] {
        self
    }

    fn numbers_mut(&mut self) -> &mut [f64] {
        self
    }

    fn taken(&mut self) -> Self {
        *self
    }
}

impl Row for Vec<f64> {
    fn zeros(size: usize) -> Self {
        vec![0.0; size]
    }

    fn numbers(&self) -> &[f64] {
        self
    }

    fn numbers_mut(&mut self) -> &mut [f64] {
        self
    }

    fn taken(&mut self) -> Self {
        core::mem::take(self)
    }
}

/// Gains of `noise` on `linear`; `None` where a covariance is not positive.
pub fn gains(linear: &Linear, timeline: &Timeline, noise: &NoiseModel) -> Option<Gains> {
    let mut layout = linear.layout.clone();
    layout.colours = 0;
    layout.colour_of = noise
        .pole
        .iter()
        .map(|pole| {
            let place = (*pole != 0.0).then_some(layout.colours);
            layout.colours += usize::from(place.is_some());
            place
        })
        .collect();
    let recurse = match layout.len() {
        1 => recurse::<[f64; 1]>,
        2 => recurse::<[f64; 2]>,
        3 => recurse::<[f64; 3]>,
        4 => recurse::<[f64; 4]>,
        5 => recurse::<[f64; 5]>,
        6 => recurse::<[f64; 6]>,
        7 => recurse::<[f64; 7]>,
        8 => recurse::<[f64; 8]>,
        9 => recurse::<[f64; 9]>,
        10 => recurse::<[f64; 10]>,
        11 => recurse::<[f64; 11]>,
        12 => recurse::<[f64; 12]>,
        _ => recurse::<Vec<f64>>,
    };
    recurse(linear, timeline, noise, layout)
}

fn recurse<R: Row>(linear: &Linear, timeline: &Timeline, noise: &NoiseModel, layout: Layout) -> Option<Gains> {
    let mut recursion = Recursion::<R>::new(&layout, &linear.initial_sigma);
    let same_as_frozen = layout.colours == 0 && linear.noise == *noise && linear.is_wide;
    let (n, m) = (layout.tangent, layout.noise_inputs.len());
    let row_len = linear.row_len();
    let events = timeline.events.len();
    let mut out = Gains {
        pole: noise.pole.clone(),
        same_as_frozen,
        gain: Vec::with_capacity(timeline.value.len() * layout.len()),
        factor: Vec::with_capacity(timeline.value.len()),
        first: Vec::with_capacity(events),
        factor_first: Vec::with_capacity(events),
        ..Gains::default()
    };
    let mut roots = Product::default();
    for (k, event) in timeline.events.iter().enumerate() {
        recursion.renew(event.reset, noise);
        out.first.push(out.gain.len());
        out.factor_first.push(out.factor.len());
        if event.count > 0 {
            let samples = event.first..event.first + event.count;
            let rows = &linear.measurement[event.first * row_len..(event.first + event.count) * row_len];
            let channels = &timeline.channel[samples.clone()];
            if !recursion.update(noise, channels, rows, (&linear.decay[samples.clone()], &linear.slope[samples])) {
                return None;
            }
            out.gain.extend_from_slice(&recursion.gain);
            out.factor.extend_from_slice(&recursion.factor);
            recursion.factor.iter().step_by(event.count + 1).for_each(|root| roots.times(*root));
        }
        if event.begins_mean {
            recursion.begin_mean();
        }
        if k + 1 < events {
            recursion.propagate(&linear.transition[k * n * (n + m)..(k + 1) * n * (n + m)]);
        }
    }
    out.layout = layout;
    out.log_determinant = 2.0 * roots.ln();
    out.log_determinant.is_finite().then_some(out)
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
    /// `F P`, rows of the state.
    moved: Vec<R>,
}

/// `sum += factor · x`.
#[inline(always)]
fn add(sum: &mut [f64], factor: f64, x: &[f64]) {
    sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += factor * x);
}

#[inline(always)]
fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl<R: Row> Recursion<R> {
    pub fn new(layout: &Layout, initial_sigma: &[f64]) -> Self {
        let size = layout.len();
        let zeros = |count: usize| (0..count).map(|_| R::zeros(size)).collect::<Vec<R>>();
        let mut p = zeros(size);
        for (i, sigma) in initial_sigma.iter().enumerate() {
            p[i].numbers_mut()[i] = sigma * sigma;
        }
        let moved = zeros(layout.tangent);
        let (gain, factor) = (Vec::new(), Vec::new());
        Self { layout: layout.clone(), size, p, gain, factor, h: zeros(0), v: zeros(0), k: zeros(0), moved }
    }

    fn clear(&mut self, i: usize, variance: f64) {
        self.p[i].numbers_mut().fill(0.0);
        self.p.iter_mut().for_each(|row| row.numbers_mut()[i] = 0.0);
        self.p[i].numbers_mut()[i] = variance;
    }

    /// Fresh actuator noise.
    pub fn renew(&mut self, reset: u64, noise: &NoiseModel) {
        for k in 0..self.layout.noise_inputs.len() {
            if reset >> self.layout.noise_inputs[k].min(63) & 1 == 1 {
                self.clear(self.layout.noise_at() + k, noise.input_sigma[k] * noise.input_sigma[k]);
            }
        }
    }

    /// The clone becomes the state.
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
    pub fn propagate(&mut self, transition: &[f64]) {
        let n = self.layout.tangent;
        let len = n + self.layout.noise_inputs.len();
        for (moved, row) in self.moved.iter_mut().zip(transition.chunks_exact(len.max(1))) {
            let mut sum = moved.taken();
            sum.numbers_mut().fill(0.0);
            for (f, p) in row.iter().zip(&self.p) {
                if *f != 0.0 {
                    add(sum.numbers_mut(), *f, p.numbers());
                }
            }
            *moved = sum;
        }
        // columns: rows beyond the state by symmetry, the corner by a second product
        for (i, moved) in self.moved.iter().enumerate() {
            let moved = moved.numbers();
            for (j, row) in transition.chunks_exact(len).enumerate().skip(i) {
                let sum = product(row, moved);
                self.p[i].numbers_mut()[j] = sum;
                self.p[j].numbers_mut()[i] = sum;
            }
            for (j, own) in moved.iter().enumerate().skip(n) {
                self.p[i].numbers_mut()[j] = *own;
                self.p[j].numbers_mut()[i] = *own;
            }
        }
    }

    /// Coloured noise and lags move on, then the measurement: `gain`, `factor` and P.
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
            [&mut self.h, &mut self.v, &mut self.k].into_iter().for_each(|list| list.push(R::zeros(self.size)));
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

    fn colour(&mut self, noise: &NoiseModel, channel: usize) {
        let Some(place) = self.layout.colour_of[channel] else { return };
        let (at, a) = (self.layout.colours_at() + place, noise.pole[channel]);
        let sigma = noise.sensor_sigma[channel];
        if self.p[at].numbers()[at] == 0.0 {
            // stationary from the first sample on
            self.p[at].numbers_mut()[at] = sigma * sigma;
        }
        self.p[at].numbers_mut().iter_mut().for_each(|p| *p *= a);
        self.p.iter_mut().for_each(|row| row.numbers_mut()[at] *= a);
        self.p[at].numbers_mut()[at] += (1.0 - a * a) * sigma * sigma;
    }

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
    fn absorb(&mut self, slot: usize, count: usize, own: f64) -> bool {
        let mut v = self.v[slot].taken();
        v.numbers_mut().fill(0.0);
        let h = self.h[slot].numbers();
        for (h, p) in h.iter().zip(&self.p) {
            if *h != 0.0 {
                add(v.numbers_mut(), *h, p.numbers());
            }
        }
        let variance = product(h, v.numbers()) + own;
        if !(variance > 0.0 && variance.is_finite()) {
            return false;
        }
        let root = variance.sqrt();
        self.factor[slot * count + slot] = root;
        let share = 1.0 / root;
        v.numbers_mut().iter_mut().for_each(|v| *v *= share);
        for (before, factor) in self.v[..slot].iter().zip(&mut self.factor[slot * count..]) {
            *factor = product(h, before.numbers());
        }
        for (p, taken) in self.p.iter_mut().zip(v.numbers()) {
            add(p.numbers_mut(), -taken, v.numbers());
        }
        self.v[slot] = v;
        true
    }

    /// `K = V L⁻¹`, from the last sample to the first.
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
