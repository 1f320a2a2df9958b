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
//! What two or three blocks hold against the others' word is no skewness but chance: Hall's
//! interval takes the place of Student's only where the blocks agree with their sum:
//! `Σ ±√|d| / √Σ|d|` (of variance one under random signs) of its sign and beyond the quantile.

use crate::filter::{Linear, NoiseModel, gains, whiten};
use crate::fit::EstimationSession;
use dynamics::description::Plant;

mod begun;
mod free_run;
mod gain;

pub use begun::begun;
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
    let (a, b) = (terms(session, before)?, terms(after.0, after.1)?);
    Some(blocks(&a.iter().zip(&b).map(|((t, a), (_, b))| (*t, b - a)).collect::<Vec<_>>(), block_s(session)))
}

/// Length of a block \[s\]: two seconds, a few samples at least, a thirtieth of the recorded time
/// at most.
pub fn block_s(session: &EstimationSession<'_>) -> f64 {
    BLOCK_S.max(4.0 * session.timelines[0].period_s).min((session.problem.duration_s() / 30.0).max(1e-9))
}

/// Time over all runs and log-likelihood of every instant.
pub type Terms = Vec<(f64, f64)>;

/// Log-likelihood of every instant.
fn terms(session: &EstimationSession<'_>, predictor: Predictor<'_>) -> Option<Terms> {
    let linears = session.linearise(predictor.plant, predictor.theta, predictor.noise).ok()?;
    Some(instants(session, &linears, predictor.noise)?.0)
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
