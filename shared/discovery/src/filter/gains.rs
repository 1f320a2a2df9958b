//! Covariance recursion: gains and innovation covariances of any noise on one linear model.

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
    let mut recursion = Recursion::new(&layout, &linear.initial_sigma);
    let same_as_frozen = layout.colours == 0 && linear.noise == *noise && linear.is_wide;
    let (n, m) = (layout.tangent, layout.noise_inputs.len());
    let row_len = linear.row_len();
    let mut out = Gains { pole: noise.pole.clone(), same_as_frozen, ..Gains::default() };
    let events = timeline.events.len();
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
            for i in 0..event.count {
                out.log_determinant += 2.0 * libm::log(recursion.factor[i * event.count + i]);
            }
        }
        if event.begins_mean {
            recursion.begin_mean();
        }
        if k + 1 < events {
            recursion.propagate(&linear.transition[k * n * (n + m)..(k + 1) * n * (n + m)]);
        }
    }
    out.layout = layout;
    out.log_determinant.is_finite().then_some(out)
}

/// Covariance of z and scratch of its recursion.
pub(super) struct Recursion {
    layout: Layout,
    size: usize,
    p: Vec<f64>,
    /// Rows of z × samples.
    pub gain: Vec<f64>,
    /// Lower Cholesky factor of S.
    pub factor: Vec<f64>,
    ph: Vec<f64>,
    h: Vec<f64>,
    work: Vec<f64>,
}

impl Recursion {
    pub fn new(layout: &Layout, initial_sigma: &[f64]) -> Self {
        let size = layout.len();
        let mut p = vec![0.0; size * size];
        for (i, sigma) in initial_sigma.iter().enumerate() {
            p[i * size + i] = sigma * sigma;
        }
        Self {
            layout: layout.clone(),
            size,
            p,
            gain: Vec::new(),
            factor: Vec::new(),
            ph: Vec::new(),
            h: Vec::new(),
            work: vec![0.0; size * size],
        }
    }

    fn clear(&mut self, i: usize, variance: f64) {
        for j in 0..self.size {
            self.p[i * self.size + j] = 0.0;
            self.p[j * self.size + i] = 0.0;
        }
        self.p[i * self.size + i] = variance;
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
        let (n, s, at) = (self.layout.clone, self.size, self.layout.clone_at());
        for i in 0..n {
            for j in 0..s {
                self.p[(at + i) * s + j] = self.p[i * s + j];
            }
        }
        for i in 0..n {
            for j in 0..s {
                self.p[j * s + at + i] = self.p[j * s + i];
            }
        }
    }

    /// To the next event: `P ← F P Fᵀ`, F the identity but for the rows of the state.
    pub fn propagate(&mut self, transition: &[f64]) {
        let (n, m, s) = (self.layout.tangent, self.layout.noise_inputs.len(), self.size);
        let len = n + m;
        let work = &mut self.work[..n * s];
        for i in 0..n {
            let row = &transition[i * len..(i + 1) * len];
            let out = &mut work[i * s..(i + 1) * s];
            out.fill(0.0);
            for (k, f) in row.iter().enumerate() {
                if *f != 0.0 {
                    for (out, p) in out.iter_mut().zip(&self.p[k * s..(k + 1) * s]) {
                        *out += f * p;
                    }
                }
            }
        }
        self.p[..n * s].copy_from_slice(&self.work[..n * s]);
        // columns: rows beyond n by symmetry, the corner by a second product
        for i in 0..n {
            for j in n..s {
                self.p[j * s + i] = self.p[i * s + j];
            }
        }
        for i in 0..n {
            for j in i..n {
                let row = &transition[j * len..(j + 1) * len];
                let sum: f64 = row.iter().zip(&self.work[i * s..i * s + len]).map(|(f, p)| f * p).sum();
                self.p[i * s + j] = sum;
                self.p[j * s + i] = sum;
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
        let (s, count) = (self.size, channels.len());
        let row_len = rows.len() / count;
        for (slot, channel) in channels.iter().enumerate() {
            self.colour(noise, *channel);
            self.lag(*channel, &rows[slot * row_len..(slot + 1) * row_len], decay[slot]);
        }
        self.h.clear();
        self.h.resize(count * s, 0.0);
        for (slot, channel) in channels.iter().enumerate() {
            self.fill_row(slot, *channel, &rows[slot * row_len..(slot + 1) * row_len]);
        }
        self.ph.clear();
        self.ph.resize(s * count, 0.0);
        for i in 0..s {
            let p = &self.p[i * s..(i + 1) * s];
            for slot in 0..count {
                let h = &self.h[slot * s..(slot + 1) * s];
                self.ph[i * count + slot] = p.iter().zip(h).map(|(p, h)| p * h).sum();
            }
        }
        self.factor.clear();
        self.factor.resize(count * count, 0.0);
        for (a, channel) in channels.iter().enumerate() {
            for b in 0..=a {
                let sum: f64 = (0..s).map(|i| self.h[a * s + i] * self.ph[i * count + b]).sum();
                self.factor[a * count + b] = sum;
            }
            let sigma = noise.sensor_sigma[*channel];
            let white = if self.layout.colour_of[*channel].is_some() { WHITE_SHARE * sigma } else { sigma };
            let early = noise.jitter_s[*channel] * slope[a];
            self.factor[a * count + a] += white * white + early * early;
        }
        if !cholesky(&mut self.factor, count) {
            return false;
        }
        self.absorb(count);
        true
    }

    fn colour(&mut self, noise: &NoiseModel, channel: usize) {
        let Some(place) = self.layout.colour_of[channel] else { return };
        let (at, s, a) = (self.layout.colours_at() + place, self.size, noise.pole[channel]);
        let sigma = noise.sensor_sigma[channel];
        if self.p[at * s + at] == 0.0 {
            // stationary from the first sample on
            self.p[at * s + at] = sigma * sigma;
        }
        for j in 0..s {
            self.p[at * s + j] *= a;
            self.p[j * s + at] *= a;
        }
        self.p[at * s + at] += (1.0 - a * a) * sigma * sigma;
    }

    fn lag(&mut self, channel: usize, row: &[f64], decay: f64) {
        let Some(place) = self.layout.lag_of[channel] else { return };
        let (at, s) = (self.layout.lags_at() + place, self.size);
        let mut mixed: Vec<f64> = (0..s).map(|j| decay * self.p[at * s + j]).collect();
        for (i, h) in self.expand(row) {
            for (j, mixed) in mixed.iter_mut().enumerate() {
                *mixed += (1.0 - decay) * h * self.p[i * s + j];
            }
        }
        let own = decay * mixed[at] + self.expand(row).map(|(i, h)| (1.0 - decay) * h * mixed[i]).sum::<f64>();
        for (j, mixed) in mixed.iter().enumerate() {
            self.p[at * s + j] = *mixed;
            self.p[j * s + at] = *mixed;
        }
        self.p[at * s + at] = own;
    }

    /// Places in z of the numbers of a row of measurement.
    fn expand<'r>(&self, row: &'r [f64]) -> impl Iterator<Item = (usize, f64)> + use<'r> {
        let (before, clone_at) = (self.layout.tangent + self.layout.noise_inputs.len(), self.layout.clone_at());
        row.iter().enumerate().map(move |(i, h)| (if i < before { i } else { clone_at + i - before }, *h))
    }

    fn fill_row(&mut self, slot: usize, channel: usize, row: &[f64]) {
        let s = self.size;
        if let Some(place) = self.layout.lag_of[channel] {
            self.h[slot * s + self.layout.lags_at() + place] = 1.0;
        } else {
            for (i, h) in self.expand(row) {
                self.h[slot * s + i] = h;
            }
        }
        if let Some(place) = self.layout.colour_of[channel] {
            self.h[slot * s + self.layout.colours_at() + place] = 1.0;
        }
    }

    /// `V = P Hᵀ L⁻ᵀ`, `K = V L⁻¹`, `P ← P − V Vᵀ`.
    fn absorb(&mut self, count: usize) {
        let s = self.size;
        self.gain.clear();
        self.gain.resize(s * count, 0.0);
        for i in 0..s {
            let v = &mut self.ph[i * count..(i + 1) * count];
            for a in 0..count {
                let known: f64 = (0..a).map(|b| self.factor[a * count + b] * v[b]).sum();
                v[a] = (v[a] - known) / self.factor[a * count + a];
            }
            let k = &mut self.gain[i * count..(i + 1) * count];
            for a in (0..count).rev() {
                let known: f64 = (a + 1..count).map(|b| self.factor[b * count + a] * k[b]).sum();
                k[a] = (v[a] - known) / self.factor[a * count + a];
            }
        }
        for i in 0..s {
            for j in i..s {
                let taken: f64 = (0..count).map(|a| self.ph[i * count + a] * self.ph[j * count + a]).sum();
                let left = self.p[i * s + j] - taken;
                self.p[i * s + j] = left;
                self.p[j * s + i] = left;
            }
            self.p[i * s + i] = self.p[i * s + i].max(0.0);
        }
    }
}

/// Lower factor in place; false where not positive.
fn cholesky(a: &mut [f64], n: usize) -> bool {
    for j in 0..n {
        let sum: f64 = (0..j).map(|k| a[j * n + k] * a[j * n + k]).sum();
        let d = a[j * n + j] - sum;
        if !(d > 0.0 && d.is_finite()) {
            return false;
        }
        a[j * n + j] = d.sqrt();
        for i in j + 1..n {
            let sum: f64 = (0..j).map(|k| a[i * n + k] * a[j * n + k]).sum();
            a[i * n + j] = (a[i * n + j] - sum) / a[j * n + j];
        }
    }
    true
}
