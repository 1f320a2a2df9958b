//! Tempering: what a gain in log-likelihood is worth where innovations are not independent.
//!
//! Of two models a and b with innovations ν of covariance S, the gain of an instant given what came
//! before, and its mean if a is right, are
//!
//! ```text
//! δ_k = ln p_a(y_k) − ln p_b(y_k)
//! κ_k = ½ (tr S_b⁻¹ S_a − n + mᵀ S_b⁻¹ m) + ½ ln |S_b| / |S_a|,   m = ν_b − ν_a
//! D = Σ δ_k,   V = long-run variance of Σ (δ_k − κ_k) by Bartlett's window of n^{1/3} instants
//! gain that counts: D min(1, 2 D / V)
//! ```
//!
//! a being the model that gains. If a is right `δ − κ` are martingale differences and V ≈ 2 D (the
//! likelihood ratio of two normal models has twice its mean for variance). The variance about κ,
//! not about the mean over the record, is taken: a brief effect gains in few instants, which is no
//! sign of noise that remembers.

use identification::filter::{Linear, NoiseModel, gains, whiten};
use identification::fit::EstimationSession;
use identification::held_out::BLOCK_S;

/// Innovations of every instant, with their covariance's lower factor L (row by row), under one
/// model.
#[derive(Clone, Debug, Default)]
pub(super) struct Instants {
    pub times_s: Vec<f64>,
    pub log_likelihood: Vec<f64>,
    nu: Vec<f64>,
    factor: Vec<f64>,
    /// Readings of each.
    count: Vec<usize>,
}

impl Instants {
    /// Of linear models of all runs under `noise`; `None` where a covariance is not positive.
    pub(super) fn new(session: &EstimationSession<'_>, linears: &[Linear], noise: &NoiseModel) -> Option<Self> {
        let mut all = Self::default();
        let mut origin = 0.0;
        for (linear, timeline) in linears.iter().zip(session.timelines.iter()) {
            let found = gains(linear, timeline, noise)?;
            let mut r = linear.nu.clone();
            whiten(linear, timeline, &found, &mut [&mut r]);
            let first = timeline.events.first().map_or(0.0, |event| event.t_s);
            for (k, event) in timeline.events.iter().enumerate().filter(|(_, event)| event.count > 0) {
                let own = &found.factor[found.factor_first[k]..][..event.count * event.count];
                all.push(origin + event.t_s - first, &r[event.first..event.first + event.count], own);
            }
            origin += timeline.events.last().map_or(0.0, |event| event.t_s - first) + 10.0 * BLOCK_S;
        }
        Some(all)
    }

    fn push(&mut self, t_s: f64, white: &[f64], factor: &[f64]) {
        let n = white.len();
        let row = |i: usize| &factor[i * n..i * n + i + 1];
        let log: f64 = (0..n).map(|i| libm::log(factor[i * n + i])).sum();
        self.times_s.push(t_s);
        self.log_likelihood.push(-0.5 * white.iter().map(|r| r * r).sum::<f64>() - log);
        self.nu.extend((0..n).map(|i| row(i).iter().zip(white).map(|(l, r)| l * r).sum::<f64>()));
        self.factor.extend_from_slice(factor);
        self.count.push(n);
    }

    /// Of all readings.
    pub(super) fn sum(&self) -> f64 {
        self.log_likelihood.iter().sum()
    }

    /// `D` against `other`, and the gain that counts; of a loss the same of the other's gain.
    pub(super) fn tempered(&self, other: &Self) -> [f64; 2] {
        let whole = self.sum() - other.sum();
        if whole < 0.0 {
            return other.tempered(self).map(|gain| -gain);
        }
        let own = self.log_likelihood.iter().zip(&other.log_likelihood).zip(self.expected(other));
        let variance = long_run_variance(&own.map(|((a, b), expected)| a - b - expected).collect::<Vec<_>>());
        let share = if variance > 0.0 { (2.0 * whole / variance).min(1.0) } else { 1.0 };
        [whole, whole * share]
    }

    /// κ of every instant, this model being right.
    fn expected(&self, other: &Self) -> Vec<f64> {
        let (mut sample, mut place) = (0, 0);
        let instant = |n: &usize| {
            let n = *n;
            let (own, theirs) = (&self.factor[place..place + n * n], &other.factor[place..place + n * n]);
            let m = (sample..sample + n).map(|s| other.nu[s] - self.nu[s]).collect();
            let mut square = solved(theirs, m).iter().map(|x| x * x).sum::<f64>() - n as f64;
            let mut log = 0.0;
            for j in 0..n {
                let column = (0..n).map(|i| if i >= j { own[i * n + j] } else { 0.0 }).collect();
                square += solved(theirs, column).iter().map(|x| x * x).sum::<f64>();
                log += libm::log(theirs[j * n + j] / own[j * n + j]);
            }
            (sample, place) = (sample + n, place + n * n);
            0.5 * square + log
        };
        self.count.iter().map(instant).collect()
    }
}

/// `L⁻¹ x`, L lower, row by row.
fn solved(factor: &[f64], mut x: Vec<f64>) -> Vec<f64> {
    let n = x.len();
    for i in 0..n {
        let known: f64 = (0..i).map(|j| factor[i * n + j] * x[j]).sum();
        x[i] = (x[i] - known) / factor[i * n + i];
    }
    x
}

/// Of the sum of a series whose mean is zero, by Bartlett's window.
fn long_run_variance(series: &[f64]) -> f64 {
    let n = series.len();
    let lags = libm::cbrt(n as f64) as usize;
    let product = |lag: usize| -> f64 { series.iter().zip(series.iter().skip(lag)).map(|(a, b)| a * b).sum() };
    let weight = |lag: usize| 1.0 - lag as f64 / (lags + 1) as f64;
    let beside: f64 = (1..=lags).map(|lag| 2.0 * weight(lag) * product(lag)).sum();
    (product(0) + beside).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// One reading an instant, of innovations `nu` and standard deviation one.
    fn model(nu: impl Iterator<Item = f64>) -> Instants {
        let mut all = Instants::default();
        nu.for_each(|nu| all.push(0.0, &[nu], &[1.0]));
        all
    }

    /// Mean share of its gain that a law keeps: `shift(k)` is what it explains of noise of pole
    /// `pole`, with its fitted amplitude.
    fn share(pole: f64, size: f64, shift: impl Fn(usize) -> f64) -> f64 {
        let mut sum = 0.0;
        for seed in 0..40 {
            let mut v = 0.0;
            let white = Noise::new(seed).series(2000, 1.0);
            let noise: Vec<f64> = white
                .iter()
                .map(|r| {
                    v = pole * v + (1.0 - pole * pole).sqrt() * r;
                    v
                })
                .collect();
            let column: Vec<f64> = (0..2000).map(&shift).collect();
            let y: Vec<f64> = noise.iter().zip(&column).map(|(e, c)| e + size * c).collect();
            let own: f64 = y.iter().zip(&column).map(|(y, c)| y * c).sum();
            let fitted = own / column.iter().map(|c| c * c).sum::<f64>();
            let ours = model(y.iter().zip(&column).map(|(y, c)| y - fitted * c));
            let [whole, counts] = ours.tempered(&model(y.iter().copied()));
            sum += counts / whole.max(1e-9) / 40.0;
        }
        sum
    }

    #[test]
    fn a_true_gain_is_kept_be_it_long_or_brief_and_one_of_noise_that_remembers_is_not() {
        // V is estimated to √(2L/n) = 11 %, and a share stops at one
        assert!(share(0.0, 0.3, |_| 1.0) > 0.9);
        // 20 instants of 2000 hold all of it: their own V is estimated to a third
        assert!(share(0.0, 2.0, |k| f64::from(u8::from(k < 20))) > 0.8);
        // nineteen times the variance of white noise, of which the window sees a part
        assert!(share(0.9, 0.0, |_| 1.0) < 0.25);
    }

    #[test]
    fn what_one_gains_the_other_loses() {
        let [a, b] = [1, 2].map(|seed| model(Noise::new(seed).series(300, 1.0).into_iter()));
        let ([d, counts], [back, lost]) = (a.tempered(&b), b.tempered(&a));
        assert!(d == -back && counts == -lost);
    }
}
