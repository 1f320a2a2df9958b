//! Where the pass starts: at the initial state that the whole recording suggests, with gains that
//! are no larger than it needs.
//!
//! A filter that starts at the prior's mean with the prior's width finds what the first readings
//! hardly tell by swings many times the noise, which the next readings undo, exactly so under the
//! numbers that the gains were made for. Sensitivities to those numbers, gains frozen, would be
//! those of the swings. So the initial state is estimated first (fixed-point smoothing on the
//! linear model of the wide filter) and the pass runs once more from there with the posterior's
//! width:
//!
//! ```text
//! E[x₀ − x̄₀ | Y] = P₀ Cᵀ r,   cov = P₀ − P₀ CᵀC P₀
//! C = L⁻¹ ∂ν/∂x₀,  r = L⁻¹ ν   (the wide filter's)
//! ```
//!
//! The likelihood stays that of the prior: [`super::whiten`] turns innovations of any frozen filter
//! into those of the wide one, and what the prior's mean differs from the start ([`Linear::pull`])
//! is added as the linear model has it.

use super::gains::gains;
use super::linear::Linear;
use super::whiten::{reading_difference, whiten};
use crate::dot::dot;
use crate::problem::Timeline;

/// Start of a pass: change from the mean of the prior, and standard deviations that its gains begin
/// with.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    pub change: Vec<f64>,
    pub sigma: Vec<f64>,
}

/// A start that leaves more than this share of every width (a ninth of the variance) is not narrow
/// enough to differ. Chosen, not derived.
const NARROWED_SHARE: f64 = 1.0 / 3.0;
/// Least width, as a share of the prior's: what rounding leaves of a difference.
const SIGMA_SHARE_MIN: f64 = 1e-6;

impl Start {
    /// At the prior.
    pub fn prior(sigma: &[f64]) -> Self {
        Self { change: vec![0.0; sigma.len()], sigma: sigma.to_vec() }
    }

    /// Posterior of the initial state after the whole run; `None` where nothing is narrowed, or the
    /// model fails.
    pub fn posterior(linear: &Linear, timeline: &Timeline) -> Option<Self> {
        let n = linear.layout.tangent;
        let unit = |i: usize| (0..n).map(|j| f64::from(u8::from(i == j))).collect::<Vec<f64>>();
        let mut columns: Vec<Vec<f64>> = (0..n).map(|i| response(linear, timeline, &unit(i))).collect();
        columns.push(linear.nu.clone());
        let found = gains(linear, timeline, &linear.noise)?;
        whiten(linear, timeline, &found, &mut columns.iter_mut().map(|column| &mut column[..]).collect::<Vec<_>>());
        let r = columns.pop()?;
        // what the readings miss by, where the numbers are still wrong, is not the initial state's
        let off = (dot(&r, &r) / r.len().max(1) as f64).sqrt().max(1.0);
        let prior = &linear.initial_sigma;
        let change: Vec<f64> = prior.iter().zip(&columns).map(|(sigma, c)| sigma * sigma * dot(c, &r)).collect();
        let left = |(sigma, c): (&f64, &Vec<f64>)| {
            (1.0 - sigma * sigma * dot(c, c)).max(SIGMA_SHARE_MIN * SIGMA_SHARE_MIN).sqrt() * off
        };
        let left: Vec<f64> = prior.iter().zip(&columns).map(left).collect();
        let sigma = prior.iter().zip(&left).map(|(sigma, left)| sigma * left.min(1.0)).collect();
        let narrowed = left.iter().any(|left| *left < NARROWED_SHARE) && change.iter().all(|change| change.is_finite());
        narrowed.then_some(Self { change, sigma })
    }
}

/// Innovations of the frozen filter were the true initial state off by `error`.
pub fn response(linear: &Linear, timeline: &Timeline, error: &[f64]) -> Vec<f64> {
    let layout = &linear.layout;
    let (n, m) = (layout.tangent, layout.noise_inputs.len());
    let len = n + m;
    let mut e = vec![[0.0]; layout.len()];
    e.iter_mut().zip(error).for_each(|(e, error)| e[0] = *error);
    let mut next = vec![0.0; n];
    let mut nu = vec![0.0; timeline.value.len()];
    for (k, event) in timeline.events.iter().enumerate() {
        for i in (0..m).filter(|i| event.reset >> layout.noise_inputs[*i].min(63) & 1 == 1) {
            e[n + i] = [0.0];
        }
        let samples = event.first..event.first + event.count;
        for sample in samples.clone() {
            nu[sample] = reading_difference(linear, timeline, (layout, &linear.noise.pole), sample, &mut e)[0];
        }
        let gain = linear.frozen.gain[linear.frozen.first[k]..].chunks_exact(event.count.max(1));
        for (e, gain) in e.iter_mut().zip(gain).filter(|_| event.count > 0) {
            e[0] -= dot(gain, &nu[samples.clone()]);
        }
        if event.begins_mean && layout.clone > 0 {
            e.copy_within(..n, layout.clone_at());
        }
        if k + 1 < timeline.events.len() {
            for (row, next) in linear.transition[k * n * len..(k + 1) * n * len].chunks_exact(len).zip(&mut next) {
                *next = row.iter().zip(&e).map(|(f, e)| f * e[0]).sum();
            }
            e.iter_mut().zip(&next).for_each(|(e, next)| e[0] = *next);
        }
    }
    nu
}
