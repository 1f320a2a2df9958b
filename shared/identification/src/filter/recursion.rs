//! Covariance recursion of a filter on one linear model.
//!
//! Samples of one event are taken up one after the other, which needs no factorisation and gives
//! its numbers all the same:
//!
//! ```text
//! v_a = P h_a / √s_a,   s_a = h_aᵀ P h_a + R_a,   P ← P − v_a v_aᵀ
//! V = [v_0 v_1 …] = P Hᵀ L⁻ᵀ,   L_ab = h_aᵀ v_b,   K = V L⁻¹
//! ```
//!
//! The recursion is compiled for every few sizes of z by itself ([`Row`]), rows filled up with
//! zeros to whole vectors; large ones share one.

use super::noise_model::WHITE_SHARE;
use super::rows::{QUAD, Row, add, combine, product};
use super::{Layout, NoiseModel};
use crate::problem::Event;

/// Covariance of z and scratch of its recursion.
pub(super) struct Recursion<R> {
    pub(super) layout: Layout,
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
    pub(super) tape: Option<Tape>,
}

/// What a recursion leaves for the way back: rows of z, filled up to whole vectors.
#[derive(Default)]
pub(super) struct Tape {
    /// Of every sample its row of measurement, `v` and `√s`.
    pub h: Vec<f64>,
    pub v: Vec<f64>,
    pub root: Vec<f64>,
    /// Of every sample whose channel has a colour: column of P at the colour before it moves on;
    /// zeros where it begins.
    pub colour: Vec<f64>,
}

impl<R: Row> Recursion<R> {
    /// The filter before the first event; `initial_sigma` are the standard deviations of the
    /// initial state, in its units.
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

    #[inline(always)]
    fn clear(&mut self, i: usize, variance: f64) {
        self.p[i].numbers_mut().fill(0.0);
        for row in &mut self.p {
            row.numbers_mut()[i] = 0.0;
        }
        self.p[i].numbers_mut()[i] = variance;
    }

    /// Standard deviations of the state and of the noise inputs.
    pub fn write_sigmas(&self, out: &mut [f64]) {
        out.iter_mut().zip(&self.p).enumerate().for_each(|(i, (sigma, row))| *sigma = row.numbers()[i].sqrt());
    }

    /// Fresh actuator noise.
    #[inline(always)]
    pub fn renew(&mut self, event: &Event, noise: &NoiseModel) {
        for k in 0..self.layout.noise_inputs.len() {
            let input = self.layout.noise_inputs[k].min(63);
            if event.reset >> input & 1 == 1 {
                let is_quiet = event.quiet >> input & 1 == 1;
                let variance = if is_quiet { 0.0 } else { noise.input_sigma[k] * noise.input_sigma[k] };
                self.clear(self.layout.noise_at() + k, variance);
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
            let own = &mut sum.numbers_mut()[..n.next_multiple_of(QUAD)];
            own.fill(0.0);
            combine(own, moved, &self.columns);
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
        self.make_room(count);
        self.factor.clear();
        self.factor.resize(count * count, 0.0);
        for (slot, channel) in channels.iter().enumerate() {
            self.colour(noise, *channel);
            self.lag(*channel, &rows[slot * row_len..(slot + 1) * row_len], decay[slot]);
        }
        for (slot, channel) in channels.iter().enumerate() {
            self.fill_row(slot, *channel, &rows[slot * row_len..(slot + 1) * row_len]);
            let own = self.own(noise, *channel, slope[slot]);
            if !self.absorb(slot, count, own) {
                return false;
            }
        }
        for (i, row) in self.p.iter_mut().enumerate() {
            row.numbers_mut()[i] = row.numbers()[i].max(0.0);
        }
        self.solve(count);
        true
    }

    fn make_room(&mut self, count: usize) {
        while self.h.len() < count {
            let size = self.size.next_multiple_of(QUAD);
            [&mut self.h, &mut self.v, &mut self.k].into_iter().for_each(|list| list.push(R::zeros(size)));
        }
    }

    /// Coloured noise and lags move on, and the readings are not taken up: the variance of each.
    pub fn spread(
        &mut self,
        noise: &NoiseModel,
        channels: &[usize],
        rows: &[f64],
        (decay, slope): (&[f64], &[f64]),
    ) -> Vec<f64> {
        let row_len = rows.len() / channels.len();
        self.make_room(1);
        for (slot, channel) in channels.iter().enumerate() {
            self.colour(noise, *channel);
            self.lag(*channel, &rows[slot * row_len..(slot + 1) * row_len], decay[slot]);
        }
        let of = |(slot, channel): (usize, &usize)| {
            self.fill_row(0, *channel, &rows[slot * row_len..(slot + 1) * row_len]);
            let own = self.own(noise, *channel, slope[slot]);
            let (h, v) = (self.h[0].numbers(), self.v[0].numbers_mut());
            v.fill(0.0);
            combine(v, h, &self.p);
            product(h, v) + own
        };
        channels.iter().enumerate().map(of).collect()
    }

    /// The covariance of another recursion of the same layout.
    pub fn take_covariance(&mut self, other: &Self) {
        self.p.iter_mut().zip(&other.p).for_each(|(p, other)| p.numbers_mut().copy_from_slice(other.numbers()));
    }

    /// Variance of a reading beside what z has of it.
    #[inline(always)]
    fn own(&self, noise: &NoiseModel, channel: usize, slope: f64) -> f64 {
        let sigma = noise.sensor_sigma[channel];
        let white = if self.layout.colour_of[channel].is_some() { WHITE_SHARE * sigma } else { sigma };
        let early = noise.jitter_s[channel] * slope;
        white * white + early * early
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

    /// Takes up one sample of variance `own`: its `v`, its row of the factor and P; false where its
    /// innovation's variance is not positive.
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

    /// Taken up one by one, samples of one event have the gain and the factor of the joint update,
    /// and so has what is left of P.
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
}
