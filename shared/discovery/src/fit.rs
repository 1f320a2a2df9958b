//! Parameters and noise of one plant, estimated on all recordings at once by prediction errors.
//!
//! Levenberg–Marquardt on whitened innovations with frozen gains, priors as further residuals; gains are computed again at each
//! relinearisation. Sensitivities serve until a step does not keep what they promise, past a relinearisation, too; what is concluded is
//! concluded from those of the place itself. Where round after round begins no lower, the fit ends where one began lowest. Noise is estimated apart, on the linear model ([`noise`]): sizes and poles that maximise
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
    pub end: End,
    pub iterations: usize,
    pub board: Board,
}

/// Why a fit ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// No step promises anything.
    Converged,
    /// What steps gain on one linearisation the next one takes away.
    StandsStill,
    OutOfRounds,
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
/// Share of the promised decrease above which sensitivities serve for the next step, too, and damping eases.
const AS_PROMISED: f64 = 0.7;
/// Share below which the next step is damped.
const BROKEN: f64 = 0.25;
/// Relinearisations beyond those asked for, as long as each takes this share off the sum of squares: a start far off is no minimum.
const ROUNDS_MORE: usize = 14;
const FAR: f64 = 0.02;
/// Steps between relinearisations.
const INNER_STEPS: usize = 3;
/// Rounds that begin no lower than one before, from which on none will.
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
/// The first linearisation fails, or a covariance on the way is not positive; later linearisations that fail end it with what is there.
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
    fn grow(&mut self) -> bool {
        self.0 = (10.0 * self.0).max(Self::FIRST);
        self.0 <= Self::MOST
    }

    /// A step has kept this share of its promise.
    fn learn(&mut self, kept: f64) {
        if kept < BROKEN {
            self.0 = (10.0 * self.0).clamp(Self::FIRST, Self::MOST);
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

/// Where a round began lowest, each on its own linearisation.
struct Lowest {
    objective: f64,
    theta: Vec<f64>,
    /// Rounds since that began no lower.
    since: usize,
}

/// What came of a step.
enum Attempt {
    /// It promises next to nothing.
    Small,
    /// None falls, however short or damped.
    Refused,
    Fell {
        by: f64,
        promised: f64,
    },
}

/// A fit on its way.
struct Descent<'a, 'p> {
    engine: &'a Engine<'p>,
    plant: &'a Plant,
    noise: &'a NoiseModel,
    theta: Vec<f64>,
    board: Board,
    damping: Damping,
    lowest: Lowest,
    /// What counts, and what was gained since the board was linearised.
    enough: f64,
    moved: f64,
    end: End,
    iterations: usize,
}

impl<'a, 'p> Descent<'a, 'p> {
    fn new(engine: &'a Engine<'p>, plant: &'a Plant, theta: &[f64], noise: &'a NoiseModel) -> Result<Self, FitError> {
        Ok(Self {
            engine,
            plant,
            noise,
            theta: theta.to_vec(),
            board: Board::new(engine, plant, theta, noise)?,
            damping: Damping::default(),
            lowest: Lowest { objective: f64::INFINITY, theta: theta.to_vec(), since: 0 },
            enough: CONVERGED,
            moved: 0.0,
            end: End::OutOfRounds,
            iterations: 0,
        })
    }

    /// Steps on one linearisation; `goes_on`: another round follows.
    fn round(&mut self, goes_on: &dyn Fn(&Gained) -> bool) -> Result<Gained, FitError> {
        let mut gained = Gained { total: 0.0, enough: self.enough, far: f64::INFINITY };
        let mut stale = self.board.jacobian.is_empty();
        for inner in 0..INNER_STEPS {
            self.iterations += 1;
            if stale {
                self.board.take_jacobian(self.engine, self.plant, &self.theta);
            }
            let normal = self.board.normal(self.engine, &self.theta, self.noise, &[]).ok_or(FitError::NotPositive)?;
            // a plant that is far off moves for ever in units of a noise that it does not reach
            self.enough = CONVERGED * (normal.chi2 / self.board.samples().max(1) as f64).max(1.0);
            (gained.enough, gained.far) = (self.enough, FAR * normal.chi2);
            if inner == 0 && self.stands_still(normal.objective) {
                break;
            }
            let is_true = self.board.has_jacobian(&self.theta);
            match self.attempt(&normal, is_true) {
                Attempt::Small if is_true => {
                    self.end = End::Converged;
                    break;
                }
                Attempt::Small if goes_on(&gained) => break,
                Attempt::Refused if is_true => break,
                Attempt::Small | Attempt::Refused => stale = true,
                Attempt::Fell { by, promised } => {
                    (gained.total, self.moved) = (gained.total + by, self.moved + by);
                    stale = by < AS_PROMISED * promised;
                    if is_true && !self.damping.acts() && by < self.enough {
                        self.end = End::Converged;
                        break;
                    }
                }
            }
        }
        Ok(gained)
    }

    /// One step, damped until it falls; where sensitivities are those of another place (`is_true` is not) it is not the step's fault.
    fn attempt(&mut self, normal: &Normal, is_true: bool) -> Attempt {
        let mut is_last = false;
        loop {
            let Some((step, promised)) = normal.step(self.engine, self.damping.0) else { return Attempt::Refused };
            if promised < self.enough {
                match (self.damping.acts(), is_last) {
                    (false, _) => return Attempt::Small,
                    (true, true) => return Attempt::Refused,
                    // undamped it may promise more
                    (true, false) => (self.damping, is_last) = (Damping::default(), true),
                }
                continue;
            }
            let by = self.search(&step, normal.objective);
            if by > 0.0 {
                if is_true || by > BROKEN * promised {
                    self.damping.learn(by / promised);
                }
                return Attempt::Fell { by, promised };
            }
            if !is_true || !self.damping.grow() {
                return Attempt::Refused;
            }
        }
    }

    /// Round after round has begun no lower: what steps gain on one linearisation the next one takes away. Back to where it was lowest.
    fn stands_still(&mut self, objective: f64) -> bool {
        if objective < self.lowest.objective - self.enough {
            self.lowest = Lowest { objective, theta: self.theta.clone(), since: 0 };
            return false;
        }
        self.lowest.since += 1;
        let stands = self.lowest.since >= PATIENCE;
        if stands {
            self.end = End::StandsStill;
            self.theta.clone_from(&self.lowest.theta);
        }
        stands
    }

    /// A linear model about where it is; sensitivities of the last one serve until they do not keep what they promise.
    fn relinearises(&mut self) -> bool {
        let Ok(fresh) = Board::new(self.engine, self.plant, &self.theta, self.noise) else { return false };
        let last = core::mem::replace(&mut self.board, fresh);
        self.board.take_sensitivities_of(last);
        (self.moved, self.end) = (0.0, End::OutOfRounds);
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

    /// A linearisation of where it has come to, or of where a round began lower.
    fn settles(&mut self) {
        if (self.board.theta != self.theta || self.moved > self.enough) && !self.relinearises() {
            self.theta.clone_from(&self.board.theta);
        }
        let objective = self.board.objective(self.engine, &self.board.nu, &self.theta, self.noise);
        let is_higher = objective.is_none_or(|objective| objective > self.lowest.objective + self.enough);
        if is_higher && self.theta != self.lowest.theta {
            let here = core::mem::replace(&mut self.theta, self.lowest.theta.clone());
            if !self.relinearises() {
                self.theta = here;
            }
        }
    }

    /// Objective, Jacobian and posterior at the end.
    fn finish(mut self) -> Result<Fit, FitError> {
        let end = self.end;
        self.settles();
        let Self { engine, plant, noise, mut theta, mut board, iterations, .. } = self;
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
            end,
            iterations,
            board,
        })
    }
}

#[cfg(test)]
mod tests;
