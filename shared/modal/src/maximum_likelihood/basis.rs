//! Columns of the model that is linear once the poles are known, and their derivatives by the
//! poles.
//!
//! Mode k answers input m with `z' = λ z + u`, exactly between samples:
//! `z_{t+1} = e^{λΔ} z_t + g u_t`, `g = (e^{λΔ} − 1)/λ`. Columns are `Re z`, `Im z` of every pair,
//! `Re e^{λt}`, `Im e^{λt}` of every mode that moves at the start, the inputs themselves (direct
//! term) and a constant (bias). Derivatives: `w = dz/dλ`, which obeys the same recursion,
//! differentiated.

use super::{Feedthrough, Model};
use crate::record::Record;
use faer::c64;

/// Sampled columns, each of `rows` values.
pub(crate) struct Columns {
    pub rows: usize,
    /// All linear columns: those of the modes first.
    pub linear: Vec<f64>,
    /// `Re w`, `Im w` beside each `Re z`, `Im z`, in the same order.
    pub derivative: Vec<f64>,
    /// Pairs of columns per mode.
    pub pairs: usize,
}

/// `e^{λΔ}`.
pub(crate) fn exp(z: c64) -> c64 {
    let (sine, cosine) = libm::sincos(z.im);
    c64::new(cosine, sine) * libm::exp(z.re)
}

impl Columns {
    /// Columns and their derivatives for `poles` over all samples of `record`. Cost: O(samples ·
    /// modes · inputs).
    pub fn new(record: &Record, model: Model, poles: &[c64]) -> Self {
        let rows = record.samples();
        let pairs = record.inputs + usize::from(model.initial_motion);
        let fixed = record.inputs + usize::from(model.bias);
        let mut columns = Columns {
            rows,
            linear: vec![0.0; rows * (2 * pairs * poles.len() + fixed)],
            derivative: vec![0.0; rows * 2 * pairs * poles.len()],
            pairs,
        };
        for (k, pole) in poles.iter().enumerate() {
            for m in 0..record.inputs {
                columns.forced(record, *pole, m, 2 * (k * pairs + m));
            }
            if model.initial_motion {
                columns.free(record, *pole, 2 * (k * pairs + record.inputs));
            }
        }
        let at = 2 * pairs * poles.len() * rows;
        for (m, column) in columns.linear[at..].chunks_exact_mut(rows).enumerate() {
            for (t, x) in column.iter_mut().enumerate() {
                let felt = match model.feedthrough {
                    Feedthrough::SameSample => t,
                    Feedthrough::NextSample => t.saturating_sub(1),
                };
                *x = if m < record.inputs { record.input[felt * record.inputs + m] } else { 1.0 };
            }
        }
        columns
    }

    /// The columns at some of the samples.
    pub fn at(mut self, present: &[usize]) -> Self {
        let rows = self.rows;
        let kept = |columns: &[f64]| -> Vec<f64> {
            columns.chunks_exact(rows).flat_map(|column| present.iter().map(|t| column[*t])).collect()
        };
        (self.linear, self.derivative) = (kept(&self.linear), kept(&self.derivative));
        self.rows = present.len();
        self
    }

    fn pair(&mut self, at: usize) -> [(&mut [f64], &mut [f64]); 2] {
        let rows = self.rows;
        let z = self.linear[at * rows..(at + 2) * rows].split_at_mut(rows);
        let w = self.derivative[at * rows..(at + 2) * rows].split_at_mut(rows);
        [z, w]
    }

    fn forced(&mut self, record: &Record, pole: c64, input: usize, at: usize) {
        let period = 1.0 / record.sample_rate_hz;
        let e = exp(pole * period);
        let g = (e - 1.0) / pole;
        let g_slope = (e * period - g) / pole;
        let inputs = record.inputs;
        let [(z_re, z_im), (w_re, w_im)] = self.pair(at);
        let (mut z, mut w) = (c64::new(0.0, 0.0), c64::new(0.0, 0.0));
        for t in 0..z_re.len() {
            (z_re[t], z_im[t], w_re[t], w_im[t]) = (z.re, z.im, w.re, w.im);
            let u = record.input[t * inputs + input];
            w = e * (w + z * period) + g_slope * u;
            z = e * z + g * u;
        }
    }

    fn free(&mut self, record: &Record, pole: c64, at: usize) {
        let period = 1.0 / record.sample_rate_hz;
        let e = exp(pole * period);
        let [(z_re, z_im), (w_re, w_im)] = self.pair(at);
        let (mut z, mut w) = (c64::new(1.0, 0.0), c64::new(0.0, 0.0));
        for t in 0..z_re.len() {
            (z_re[t], z_im[t], w_re[t], w_im[t]) = (z.re, z.im, w.re, w.im);
            w = e * (w + z * period);
            z = e * z;
        }
    }
}

/// `Re z` and `Im z`, one after the other, of `z_{t+1} = e^{λΔ} z_t + u_t` from rest.
pub(crate) fn driven(sample_rate_hz: f64, pole: c64, source: impl ExactSizeIterator<Item = f64>) -> Vec<f64> {
    let e = exp(pole / sample_rate_hz);
    let mut columns = vec![0.0; 2 * source.len()];
    let (re, im) = columns.split_at_mut(source.len());
    let mut z = c64::new(0.0, 0.0);
    for ((re, im), u) in re.iter_mut().zip(im).zip(source) {
        (*re, *im) = (z.re, z.im);
        z = e * z + u;
    }
    columns
}

/// `Re e^{λt}` and `Im e^{λt}`, one after the other.
pub(crate) fn free_columns(sample_rate_hz: f64, rows: usize, pole: c64) -> Vec<f64> {
    let e = exp(pole / sample_rate_hz);
    let mut columns = vec![0.0; 2 * rows];
    let (re, im) = columns.split_at_mut(rows);
    let mut z = c64::new(1.0, 0.0);
    for (re, im) in re.iter_mut().zip(im) {
        (*re, *im) = (z.re, z.im);
        z *= e;
    }
    columns
}
