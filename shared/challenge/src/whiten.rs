//! Differences between records in units of their noise.
//!
//! Without noise at the inputs a difference is divided by the sensors' noise (a quantiser adds
//! step² / 12). With it the plants here are linear, and the innovations of a Kalman filter of their
//! own matrices are white: `x⁺ = A x + K e`, `e = y − C x`, `S = C P Cᵀ + D Q Dᵀ + R`,
//! `K = (A P Cᵀ + B Q Dᵀ) S⁻¹`. The initial state is left to the projection: P begins at zero.

use crate::motion::Rig;
use nalgebra::{DMatrix, DVector};

/// Whitens differences of records, `[sensor][sample]`.
pub struct Whitener {
    sigma: Vec<f64>,
    filter: Option<Filter>,
}

struct Filter {
    a: DMatrix<f64>,
    c: DMatrix<f64>,
    /// Per sample: gain, inverse of the factor of S.
    steps: Vec<(DMatrix<f64>, DMatrix<f64>)>,
}

impl Whitener {
    /// `rig` is nominal; `sigma` per sensor, `input_sigma` per input and period.
    #[must_use]
    pub fn new(rig: &Rig, sigma: &[f64], input_sigma: &[f64], (period_s, samples): (f64, usize)) -> Self {
        let quiet = input_sigma.iter().all(|sigma| *sigma == 0.0);
        let filter = if quiet { None } else { filter(rig, sigma, input_sigma, period_s, samples) };
        Self { sigma: sigma.to_vec(), filter }
    }

    /// The whitened difference: samples in order, all sensors of a sample together.
    ///
    /// Noise as stated becomes independent with unit variance; the squared norm is the
    /// noncentrality of a test.
    #[must_use]
    pub fn whiten(&self, difference: &[Vec<f64>]) -> Vec<f64> {
        let samples = difference.first().map_or(0, Vec::len);
        let mut white = Vec::with_capacity(samples * difference.len());
        let Some(filter) = &self.filter else {
            for k in 0..samples {
                white.extend(difference.iter().zip(&self.sigma).map(|(list, sigma)| list[k] / sigma));
            }
            return white;
        };
        let mut x = DVector::zeros(filter.a.nrows());
        for (k, (gain, factor)) in filter.steps.iter().enumerate().take(samples) {
            let y = DVector::from_iterator(difference.len(), difference.iter().map(|list| list[k]));
            let e = y - &filter.c * &x;
            x = &filter.a * &x + gain * &e;
            white.extend((factor * e).iter());
        }
        white
    }
}

/// One period of `rig` from state `x` under `u`, and its readings at the beginning.
fn period(rig: &Rig, x: &[f64], u: &[f64], period_s: f64) -> (Vec<f64>, Vec<f64>) {
    let n = rig.equations.dof();
    let mut motion = rig.begin(&x[..n], &x[n..]);
    let y = rig.read(&motion, u);
    rig.advance(&mut motion, u, period_s);
    (motion.x[..2 * n].to_vec(), y)
}

fn filter(rig: &Rig, sigma: &[f64], input_sigma: &[f64], period_s: f64, samples: usize) -> Option<Filter> {
    let (states, inputs) = (2 * rig.equations.dof(), input_sigma.len());
    let unit = |size: usize, at: usize| (0..size).map(|i| if i == at { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
    let from = |x: Vec<f64>, u: Vec<f64>| period(rig, &x, &u, period_s);
    let of_states: Vec<_> = (0..states).map(|i| from(unit(states, i), vec![0.0; inputs])).collect();
    let of_inputs: Vec<_> = (0..inputs).map(|j| from(vec![0.0; states], unit(inputs, j))).collect();
    let a = DMatrix::from_fn(states, states, |r, c| of_states[c].0[r]);
    let c = DMatrix::from_fn(sigma.len(), states, |r, c| of_states[c].1[r]);
    let b = DMatrix::from_fn(states, inputs, |r, c| of_inputs[c].0[r] * input_sigma[c]);
    let d = DMatrix::from_fn(sigma.len(), inputs, |r, c| of_inputs[c].1[r] * input_sigma[c]);
    let r = DMatrix::from_diagonal(&DVector::from_iterator(sigma.len(), sigma.iter().map(|s| s * s)));
    let mut p = DMatrix::zeros(states, states);
    let mut steps = Vec::with_capacity(samples);
    for _ in 0..samples {
        let s = &c * &p * c.transpose() + &d * d.transpose() + &r;
        let factor = s.clone().cholesky()?;
        let gain = (&a * &p * c.transpose() + &b * d.transpose()) * factor.inverse();
        p = &a * &p * a.transpose() + &b * b.transpose() - &gain * &s * gain.transpose();
        p = 0.5 * (&p + p.transpose());
        steps.push((gain, factor.l().try_inverse()?));
    }
    Some(Filter { a, c, steps })
}
