//! Tempering: what a gain in log-likelihood is worth where innovations are not independent.
//!
//! Of two models a and b with innovations ν of covariance S, a being the one that gains, the gain
//! of an instant is `δ_k = ln p_a(y_k) − ln p_b(y_k)`, and the part of it that chance turns either
//! way is the product of a's innovation with what b predicts otherwise:
//!
//! ```text
//! c_k = ν_aᵀ S_b⁻¹ m,   m = ν_b − ν_a
//! D = Σ δ_k,   V = long-run variance of Σ c_k by Bartlett's window of n^{1/3} instants
//! gain that counts: D max(0, min(1, 2 D / V))       the ratio over settled instants
//! ```
//!
//! If a is right the c are martingale differences and V ≈ Σ mᵀ S_b⁻¹ m ≤ 2 D (the likelihood ratio
//! of two normal models has twice its mean for variance). A brief effect gains in few instants,
//! which is no sign of noise that remembers: its mean is no part of c. The expected squares of ν_a,
//! `tr S_b⁻¹ S_a`, are no such sign either: of several readings of one state they are seen at the
//! width of their noise. Nor is the start of states that a has and b has not: until a has found
//! them, what it says too much goes one way for some instants; settled instants lie behind that, in
//! each run. A gain that no settled instant has is that of a start, and counts as nothing.

use identification::filter::{Linear, NoiseModel, gains, whiten};
use identification::fit::EstimationSession;
use identification::held_out::BLOCK_S;

/// What a start may still cost that counts as settled: one nat, within which two models are the
/// same.
const SETTLED_NATS: f64 = 1.0;

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
    /// Instants of each run.
    runs: Vec<usize>,
    /// Numbers of state of the model.
    states: usize,
}

impl Instants {
    /// Of linear models of all runs under `noise`; `None` where a covariance is not positive.
    pub(super) fn new(session: &EstimationSession<'_>, linears: &[Linear], noise: &NoiseModel) -> Option<Self> {
        let states = linears.first().map_or(0, |linear| linear.layout.tangent);
        let mut all = Self { states, ..Self::default() };
        let mut origin = 0.0;
        for (linear, timeline) in linears.iter().zip(session.timelines.iter()) {
            let found = gains(linear, timeline, noise)?;
            let mut r = linear.nu.clone();
            whiten(linear, timeline, &found, &mut [&mut r]);
            let first = timeline.events.first().map_or(0.0, |event| event.t_s);
            let before = all.count.len();
            for (k, event) in timeline.events.iter().enumerate().filter(|(_, event)| event.count > 0) {
                let own = &found.factor[found.factor_first[k]..][..event.count * event.count];
                all.push(origin + event.t_s - first, &r[event.first..event.first + event.count], own);
            }
            all.runs.push(all.count.len() - before);
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
        let settled = self.beside(other);
        let gain: f64 = settled.iter().map(|(gain, _)| gain).sum();
        let crossed: Vec<f64> = settled.iter().map(|(_, crossed)| *crossed).collect();
        let variance = long_run_variance(&crossed);
        let share = if variance > 0.0 { (2.0 * gain / variance).clamp(0.0, 1.0) } else { 1.0 };
        // what a start gains counts as what follows it does, where anything does
        let counted = if gain < SETTLED_NATS { gain.clamp(0.0, whole) } else { whole };
        [whole, share * counted]
    }

    /// δ and c of every settled instant, this model being a.
    fn beside(&self, other: &Self) -> Vec<(f64, f64)> {
        let (mut sample, mut place) = (0, 0);
        let (mut list, mut wider) = (Vec::with_capacity(self.count.len()), Vec::with_capacity(self.count.len()));
        for (k, n) in self.count.iter().copied().enumerate() {
            let [ours, theirs] = [&self.factor, &other.factor].map(|factor| &factor[place..place + n * n]);
            let width = |factor: &[f64]| (0..n).map(|i| libm::log(factor[i * n + i])).sum::<f64>();
            let own = &self.nu[sample..sample + n];
            let m = other.nu[sample..sample + n].iter().zip(own).map(|(other, own)| other - own).collect();
            let (own, m) = (solved(theirs, own.to_vec()), solved(theirs, m));
            let crossed = own.iter().zip(&m).map(|(own, m)| own * m).sum();
            list.push((self.log_likelihood[k] - other.log_likelihood[k], crossed));
            wider.push(width(ours) - width(theirs));
            (sample, place) = (sample + n, place + n * n);
        }
        if self.states <= other.states {
            return list;
        }
        let (mut settled, mut begin) = (Vec::with_capacity(list.len()), 0);
        for run in self.runs.iter().copied() {
            settled.extend_from_slice(&list[begin + settled_from(&wider[begin..begin + run])..begin + run]);
            begin += run;
        }
        settled
    }
}

/// The instant of a run from which on a model has found its states, which is wider than another by
/// so many nats at each: what it still pays for not knowing them, beyond what it always pays, is
/// below [`SETTLED_NATS`].
fn settled_from(wider: &[f64]) -> usize {
    let half = wider.len() / 2;
    let usual = wider[half..].iter().sum::<f64>() / (wider.len() - half).max(1) as f64;
    let mut paid = 0.0;
    let last_unknown = (0..half).rev().find(|k| {
        paid = (paid + wider[*k] - usual.max(0.0)).max(0.0);
        paid > SETTLED_NATS
    });
    last_unknown.map_or(0, |k| k + 1)
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
        all.runs.push(all.count.len());
        all
    }

    /// Two runs of 400 instants; a state that one model has is unknown at the start of each and
    /// then found, and what it moves there the model without it does not explain.
    fn of_two_runs(nu: &[f64], with_state: bool) -> Instants {
        let mut all = Instants { states: usize::from(with_state), runs: vec![400, 400], ..Instants::default() };
        for (k, nu) in nu.iter().enumerate() {
            let wide = 1.0 + 8.0 * libm::exp(-((k % 400) as f64) / 10.0);
            let moved = if k % 400 < 40 { wide } else { 0.0 };
            let (width, own) = if with_state { (wide, nu + 0.5 * moved) } else { (1.0, nu + moved) };
            all.push(0.0, &[own / width], &[width]);
        }
        all
    }

    #[test]
    fn every_run_has_a_start_of_its_own_and_a_gain_of_starts_alone_is_none() {
        let nu = Noise::new(9).series(800, 1.0);
        let [ours, theirs] = [true, false].map(|with_state| of_two_runs(&nu, with_state));
        let [whole, counts] = ours.tempered(&theirs);
        assert!(whole > 20.0 && counts < 1.0, "{whole} {counts}");
        let settled = ours.beside(&theirs).len();
        assert!((690..=740).contains(&settled), "{settled}");
        let as_one = Instants { runs: vec![800], ..ours.clone() };
        assert!(as_one.beside(&theirs).len() > settled);
    }

    #[test]
    fn a_start_is_over_where_what_it_costs_is_below_a_nat() {
        let start = |k: usize| 2.0 * libm::exp(-(k as f64) / 10.0);
        let settled =
            |steady: &dyn Fn(usize) -> f64| settled_from(&(0..400).map(|k| start(k) + steady(k)).collect::<Vec<_>>());
        // of an exponential ten times the height is left: below one nat behind ln(20) decays
        for from in [settled(&|_| 0.0), settled(&|_| 0.1)] {
            assert!((29..=31).contains(&from), "{from}");
        }
        assert!((25..=35).contains(&settled(&|k| if k % 2 == 0 { 0.2 } else { -0.2 })));
        // a model of less noise is never the wider one
        assert_eq!(settled(&|_| -3.0), 0);
        assert_eq!(settled(&|k| -0.1 - 0.1 * f64::from(k > 200)), settled(&|_| -0.1));
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

    /// Two readings of one state that begins anywhere: both models see it a little differently.
    #[test]
    fn a_wide_start_costs_a_true_gain_nothing() {
        let (width, other) = (1e4, 1e4 * (1.0 + 1e-2));
        let with_start = |mut nu: Vec<f64>, width: f64| {
            let mut all = Instants::default();
            // covariance of (width x + v, width' x + w), |x| about one, by its lower factor
            all.push(0.0, &[1.0 / width, nu.remove(0)], &[width, 0.0, width, 1.0]);
            nu.iter().for_each(|nu| all.push(0.0, &[*nu], &[1.0]));
            all
        };
        let white = Noise::new(3).series(2000, 1.0);
        let ours = with_start(white.clone(), width);
        let mut theirs = with_start(white.iter().map(|nu| nu + 0.3).collect(), width);
        theirs.factor[2] = other;
        let [whole, counts] = ours.tempered(&theirs);
        assert!(whole > 50.0 && counts > 0.8 * whole, "{whole} {counts}");
    }

    #[test]
    fn what_one_gains_the_other_loses() {
        let [a, b] = [1, 2].map(|seed| model(Noise::new(seed).series(300, 1.0).into_iter()));
        let ([d, counts], [back, lost]) = (a.tempered(&b), b.tempered(&a));
        assert!(d == -back && counts == -lost);
    }
}
