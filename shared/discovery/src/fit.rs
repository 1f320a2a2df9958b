//! Parameters and noise of one plant, estimated on all recordings at once by prediction errors.
//!
//! Levenberg–Marquardt on whitened innovations with frozen gains, priors as further residuals; gains are computed again at each
//! relinearisation. Noise is estimated apart, on the linear model ([`noise`]): sizes and poles that maximise
//! `ln p = −½ (Σ ln |S| + |r|² + |θ − θ₀|²_prior)`, the parameters being maximised along.

mod afar;
pub mod board;
pub mod bounded;
pub mod engine;
pub mod noise;
mod start;
mod white;

pub use afar::fit_from_afar;
pub use board::{Board, Normal};
pub use engine::{Engine, parallel};
pub use white::White;

use crate::filter::NoiseModel;
use plant::description::Plant;

/// A fitted plant.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Description with the effects it was fitted with; parameters stand at their priors, estimates in `theta`.
    pub plant: Plant,
    pub theta: Vec<f64>,
    /// Posterior standard deviation, as the noise model has it.
    pub sigma: Vec<f64>,
    /// Share of the prior's standard deviation that is left.
    pub ratio: Vec<f64>,
    /// `−2 ln p` up to a constant of the data.
    pub objective: f64,
    pub noise: NoiseModel,
    /// Whitened innovations' mean square.
    pub chi2_per_sample: f64,
    pub converged: bool,
    pub iterations: usize,
    pub board: Board,
}

/// A fit that did not work out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    #[error("the plant cannot predict this recording: {0}")]
    Filter(String),
    #[error("the covariance of the innovations is not positive; the noise that is stated may be zero")]
    NotPositive,
}

/// What remains of a prior counts as not found above this.
pub const NOT_FOUND_RATIO: f64 = 0.98;
/// Decrease of `−2 ln p` that ends the iteration, at noise of the size that the residuals have: a tenth of a standard error.
const CONVERGED: f64 = 1e-2;
/// Share of the promised decrease above which sensitivities serve for the next step, too.
const AS_PROMISED: f64 = 0.7;
/// Share below which the next step is damped.
const BROKEN: f64 = 0.25;
/// Relinearisations beyond those asked for, as long as each takes this share off the sum of squares: a start far off is no minimum.
const ROUNDS_MORE: usize = 14;
const FAR: f64 = 0.02;
/// Steps between relinearisations, and rounds in a row that may begin no lower than one before.
const INNER_STEPS: usize = 3;
const PATIENCE: usize = 2;

/// Relinearisations of a fit.
#[derive(Clone, Copy, Debug)]
pub struct Rounds {
    most: usize,
    /// So many more, as long as each takes its share off the sum of squares.
    more: usize,
}

impl Rounds {
    /// No more than these wherever it started: steps towards the minimum, not the minimum.
    pub const fn at_most(most: usize) -> Self {
        Self { most, more: 0 }
    }

    /// The same however far off the start was.
    #[must_use]
    pub const fn without_more(self) -> Self {
        Self::at_most(self.most)
    }
}

/// So many, some more where the start was far off.
impl From<usize> for Rounds {
    fn from(most: usize) -> Self {
        Self { most, more: ROUNDS_MORE }
    }
}

/// Fits `plant` from `theta` under `noise` with at most `rounds` relinearisations.
///
/// # Errors
/// The first linearisation fails; later failures end the iteration with what is there.
pub fn fit(
    engine: &Engine<'_>,
    plant: &Plant,
    theta: &[f64],
    noise: &NoiseModel,
    rounds: impl Into<Rounds>,
) -> Result<Fit, FitError> {
    let rounds = rounds.into();
    let mut descent = Descent::new(engine, plant, theta, noise)?;
    for round in 0..rounds.most + rounds.more {
        let is_asked_for = round + 1 < rounds.most;
        let goes_on = |gained: &Gained| gained.total > if is_asked_for { gained.enough } else { gained.far };
        let gained = descent.round(&goes_on)?;
        if !goes_on(&gained) || !descent.relinearises() {
            break;
        }
    }
    descent.finish()
}

/// Share that every diagonal entry of the normal equations grows by: short steps go along what the recording tells, not along what it leaves open.
#[derive(Clone, Copy, Debug, Default)]
struct Damping(f64);

impl Damping {
    const FIRST: f64 = 1e-2;
    const LEAST: f64 = 1e-6;
    const MOST: f64 = 1e3;

    fn acts(self) -> bool {
        self.0 > 0.0
    }

    /// False where that is of no use any more.
    fn grows(&mut self) -> bool {
        self.0 = (10.0 * self.0).max(Self::FIRST);
        self.0 <= Self::MOST
    }

    /// A step has kept this share of its promise.
    fn learn(&mut self, kept: f64) {
        if kept < BROKEN {
            self.grows();
        } else if kept > AS_PROMISED {
            self.0 = if self.0 > Self::LEAST { 0.1 * self.0 } else { 0.0 };
        }
    }
}

/// What a round has gained, and what a round must gain for another one.
struct Gained {
    total: f64,
    enough: f64,
    far: f64,
}

/// A fit on its way.
struct Descent<'a, 'p> {
    engine: &'a Engine<'p>,
    plant: &'a Plant,
    noise: &'a NoiseModel,
    theta: Vec<f64>,
    board: Board,
    damping: Damping,
    /// Least objective that a round began with, where, and how many have begun no lower since.
    lowest: (f64, Vec<f64>, usize),
    converged: bool,
    iterations: usize,
}

impl<'a, 'p> Descent<'a, 'p> {
    fn new(engine: &'a Engine<'p>, plant: &'a Plant, theta: &[f64], noise: &'a NoiseModel) -> Result<Self, FitError> {
        let board = Board::new(engine, plant, theta, noise)?;
        let (damping, lowest) = (Damping::default(), (f64::INFINITY, theta.to_vec(), 0));
        let theta = theta.to_vec();
        Ok(Self { engine, plant, noise, theta, board, damping, lowest, converged: false, iterations: 0 })
    }

    /// Steps on one linearisation; `goes_on`: another round follows.
    fn round(&mut self, goes_on: &dyn Fn(&Gained) -> bool) -> Result<Gained, FitError> {
        let mut gained = Gained { total: 0.0, enough: CONVERGED, far: f64::INFINITY };
        let mut stale = self.board.jacobian.is_empty();
        for inner in 0..INNER_STEPS {
            self.iterations += 1;
            if stale {
                self.board.take_jacobian(self.engine, self.plant, &self.theta);
            }
            let normal = self.board.normal(self.engine, &self.theta, self.noise, &[]).ok_or(FitError::NotPositive)?;
            // a plant that is far off moves for ever in units of a noise that it does not reach
            gained.enough = CONVERGED * (normal.chi2 / self.board.samples().max(1) as f64).max(1.0);
            gained.far = FAR * normal.chi2;
            if inner == 0 && self.stands_still(normal.objective, gained.enough) {
                break;
            }
            let Some((step, promised)) = normal.step(self.engine, self.damping.0) else { break };
            let is_true = self.board.has_jacobian(&self.theta);
            if promised < gained.enough {
                if self.damping.acts() {
                    self.damping = Damping::default();
                } else if is_true {
                    self.converged = true;
                    break;
                } else if goes_on(&gained) {
                    break;
                } else {
                    stale = true;
                }
                continue;
            }
            let kept = self.search(&step, normal.objective);
            if kept <= 0.0 {
                if is_true && !self.damping.grows() {
                    break;
                }
                stale = true;
                continue;
            }
            gained.total += kept;
            self.damping.learn(kept / promised);
            stale = kept < AS_PROMISED * promised;
            if kept < gained.enough {
                self.converged = true;
                break;
            }
        }
        Ok(gained)
    }

    /// Round after round has begun no lower: what steps gain on one linearisation the next one takes away. Back to where it was lowest.
    fn stands_still(&mut self, objective: f64, enough: f64) -> bool {
        let (least, at, since) = &mut self.lowest;
        if objective < *least - enough {
            self.lowest = (objective, self.theta.clone(), 0);
            return false;
        }
        *since += 1;
        let stands = *since >= PATIENCE;
        if stands {
            self.theta.clone_from(at);
            self.converged = true;
        }
        stands
    }

    /// A linear model about where it is; sensitivities of the last one serve until they do not keep what they promise.
    fn relinearises(&mut self) -> bool {
        let Ok(fresh) = Board::new(self.engine, self.plant, &self.theta, self.noise) else { return false };
        let last = core::mem::replace(&mut self.board, fresh);
        self.board.take_sensitivities_of(last);
        self.converged = false;
        true
    }

    /// Shortens the step until the objective falls; goes there and returns by how much, zero where it does not.
    fn search(&mut self, step: &[f64], before: f64) -> f64 {
        let mut share = 1.0;
        for _ in 0..4 {
            let along = self.theta.iter().zip(step).zip(&self.engine.problem.unknowns);
            let moved: Vec<f64> = along.map(|((t, s), u)| (t + share * s).clamp(u.low, u.high)).collect();
            let nu = self.engine.innovations(self.plant, &moved, &self.board.linears, &|_| true);
            let after = nu.as_ref().and_then(|nu| self.board.objective(self.engine, nu, &moved, self.noise));
            if let (Some(nu), Some(after)) = (nu, after)
                && after < before
            {
                self.board.nu = nu;
                self.board.theta.clone_from(&moved);
                self.theta = moved;
                return before - after;
            }
            share *= 0.4;
        }
        0.0
    }

    /// Objective, Jacobian and posterior on a fresh linearisation.
    fn finish(self) -> Result<Fit, FitError> {
        let Self { engine, plant, noise, mut theta, board, converged, iterations, .. } = self;
        let fresh = |board: &Board| Board::new(engine, plant, &theta, noise).map(|fresh| fresh.with_steps_of(board));
        let mut board = if board.theta == theta { board } else { fresh(&board).unwrap_or(board) };
        board.take_jacobian(engine, plant, &theta);
        let normal = board.normal(engine, &theta, noise, &[]).ok_or(FitError::NotPositive)?;
        let sigma = normal.sigmas(engine);
        let unknowns = &engine.problem.unknowns;
        let ratio = sigma.iter().zip(unknowns).map(|(s, u)| s / u.sigma).collect();
        theta.iter_mut().zip(unknowns).for_each(|(t, u)| *t = t.clamp(u.low, u.high));
        Ok(Fit {
            plant: plant.clone(),
            theta,
            sigma,
            ratio,
            objective: normal.objective,
            noise: noise.clone(),
            chi2_per_sample: normal.chi2 / board.samples().max(1) as f64,
            converged,
            iterations,
            board,
        })
    }
}

#[cfg(test)]
mod tests;
