//! Frozen parameters on a recording that they were not fitted to.
//!
//! The initial state of each run comes from its first stretch by least squares on the free run. Two
//! measures: free run (rms and fit % = 100 (1 − |e| / |y − mean y|) per channel behind that
//! stretch) and the gain in one-step log-likelihood, summed in blocks of 2 s whose scatter gives
//! its standard error. Confirmed: its 95 % interval is above zero; rejected: below. A few blocks
//! may hold most of a gain (the swing that a free law governs), so the interval is Hall's for
//! skewed means (J. R. Statist. Soc. B 54, 1992): with κ = skewness / √n
//!
//! ```text
//! g(t) = t + κ t²/3 + κ² t³/27 + κ/6 = ((1 + κ t/3)³ − 1)/κ + κ/6   is Student's where t is not
//! ```
//!
//! An effect is also rejected if its gain falls significantly short of the gain that it predicts:
//! the augmented plant expects `½ |δ|²`, `δ` the whitened difference between what both predict. Of
//! numbers known to `P`, by which its prediction moves as `J`, that is uncertain to
//! `√(δᵀ J P Jᵀ δ)` (an amplitude known to one part in d: to `2/d` of it): where the interval does
//! not reach what three of these leave, and nothing is confirmed, the law does not hold there.
//!
//! What two or three blocks hold against the others' word is no skewness but chance: Hall's
//! interval takes the place of Student's only where the blocks agree with their sum:
//! `Σ ±√|d| / √Σ|d|` (of variance one under random signs) of its sign and beyond the quantile.

use crate::filter::{Linear, NoiseModel, gains, whiten};
use crate::fit::EstimationSession;
use dynamics::description::Plant;

mod free_run;
mod gain;

pub use free_run::{ChannelFit, free_residual, free_run};
pub use gain::{Gain, Status, blocks};

/// Length of a block \[s\]; at least this many blocks are made, at most so many seconds apart.
pub const BLOCK_S: f64 = 2.0;

/// A plant with all its numbers, as a predictor.
#[derive(Clone, Copy)]
pub struct Predictor<'a> {
    pub plant: &'a Plant,
    pub theta: &'a [f64],
    pub noise: &'a NoiseModel,
}

/// Log-likelihood of `after` above that of `before` on all runs of `session`, in blocks.
pub fn gain(
    session: &EstimationSession<'_>,
    before: Predictor<'_>,
    after: (&EstimationSession<'_>, Predictor<'_>),
) -> Option<Gain> {
    let (a, white_before) = terms(session, before)?;
    let (b, white_after) = terms(after.0, after.1)?;
    let apart = white_before.iter().zip(&white_after).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
    let gain = blocks(&a.iter().zip(&b).map(|((t, a), (_, b))| (*t, b - a)).collect::<Vec<_>>(), block_s(session));
    Some(Gain { expected: 0.5 * apart, ..gain })
}

/// Standard deviation of what the augmented plant predicts, `moved` being that plant with its
/// parameters off by each column of a root of their covariance: exact where predictions are linear
/// in them. The parameters of one recording stay as they were fitted, so that it is rather too
/// large.
///
/// Cost: a prediction for each.
pub fn expected_gain_sigma(
    (session, before): (&EstimationSession<'_>, Predictor<'_>),
    (augmented, after): (&EstimationSession<'_>, Predictor<'_>),
    moved: &[Plant],
) -> Option<f64> {
    let white = |session: &EstimationSession<'_>, predictor: Predictor<'_>| Some(terms(session, predictor)?.1);
    let (before, own) = (white(session, before)?, white(augmented, after)?);
    let mut variance = 0.0;
    for plant in moved {
        let off = white(augmented, Predictor { plant, ..after })?;
        let along = before.iter().zip(&own).zip(&off).map(|((before, own), off)| (before - own) * (own - off));
        variance += along.sum::<f64>().powi(2);
    }
    Some(variance.sqrt())
}

/// Log-likelihood of all runs under the predictor's own noise.
pub fn loglik(session: &EstimationSession<'_>, predictor: Predictor<'_>) -> Option<f64> {
    Some(terms(session, predictor)?.0.iter().map(|(_, term)| term).sum())
}

/// Length of a block \[s\]: two seconds, a few samples at least, a thirtieth of the recorded time
/// at most.
pub fn block_s(session: &EstimationSession<'_>) -> f64 {
    BLOCK_S.max(4.0 * session.timelines[0].period_s).min((session.problem.duration_s() / 30.0).max(1e-9))
}

/// Time over all runs and log-likelihood of every instant.
pub type Terms = Vec<(f64, f64)>;

/// Log-likelihood of every instant, and the whitened innovations.
fn terms(session: &EstimationSession<'_>, predictor: Predictor<'_>) -> Option<(Terms, Vec<f64>)> {
    let linears = session.linearise(predictor.plant, predictor.theta, predictor.noise).ok()?;
    instants(session, &linears, predictor.noise)
}

/// Time over all runs \[s\] and log-likelihood of every instant of linear models under `noise`, and
/// the whitened innovations; `None` where a covariance is not positive.
pub fn instants(session: &EstimationSession<'_>, linears: &[Linear], noise: &NoiseModel) -> Option<(Terms, Vec<f64>)> {
    let (mut list, mut white) = (Vec::new(), Vec::new());
    let mut origin = 0.0;
    for (linear, timeline) in linears.iter().zip(session.timelines.iter()) {
        let found = gains(linear, timeline, noise)?;
        let mut r = linear.nu.clone();
        whiten(linear, timeline, &found, &mut [&mut r]);
        let first = timeline.events.first().map_or(0.0, |event| event.t_s);
        let mut last = first;
        for (k, event) in timeline.events.iter().enumerate().filter(|(_, event)| event.count > 0) {
            let samples = &r[event.first..event.first + event.count];
            let factor = &found.factor[found.factor_first[k]..];
            let scale: f64 = (0..event.count).map(|i| libm::log(factor[i * event.count + i])).sum();
            list.push((origin + event.t_s - first, -0.5 * samples.iter().map(|r| r * r).sum::<f64>() - scale));
            last = event.t_s;
        }
        origin += last - first + 10.0 * BLOCK_S;
        white.append(&mut r);
    }
    Some((list, white))
}
