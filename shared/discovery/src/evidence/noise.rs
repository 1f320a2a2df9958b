//! Numbers of the noise at their greatest posterior, and its curvature.
//!
//! Coordinates are logarithms of standard deviations and inverse hyperbolic tangents of poles; all
//! belong to one record. Their priors: `noise/prior`.

mod prior;

use identification::filter::{Gradient, NoiseModel, Slope};
use identification::fit::{EstimationSession, LinearisedProblem, Normal};
use nalgebra::{Cholesky, DMatrix, DVector};
pub(super) use prior::NoisePrior;

/// Steps to a greatest posterior, how often a step is shortened, and how often unknowns are found
/// again between.
const STEPS_MAX: usize = 12;
const SHORTENINGS_MAX: usize = 5;
const HOLDS_MAX: usize = 3;
/// Decrease of `−2 ln p` that is not worth a step: a tenth of the nat that two models may differ
/// by.
const STEP_GAIN_MIN: f64 = 0.05;
/// Difference of a coordinate over which a slope's change gives its curvature.
const DIFFERENCE: f64 = 0.05;
/// Coordinates up to which curvature is taken by differences: each costs two gradients.
const DIFFERENCED_MAX: usize = 8;
/// Range of poles that the filter takes.
const POLE_RANGE: [f64; 2] = [-0.5, 0.98];
/// Decades below its prior's width in which an unstated disturbance is looked for.
const DECADES: i32 = 4;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Coordinate {
    Sensor(usize),
    Input(usize),
    Pole(usize),
}

/// Noise at its greatest posterior on one linear model.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    pub noise: NoiseModel,
    /// `−2 ln` of likelihood, priors of the unknowns and of the noise.
    pub objective: f64,
}

/// Noise inputs whose size the plant file does not state.
pub(super) fn unstated(session: &EstimationSession<'_>) -> impl Iterator<Item = usize> {
    (0..session.disturbance_sigma.len()).filter(|k| session.disturbance_sigma[*k].is_finite())
}

fn moved(noise: &NoiseModel, coordinate: Coordinate, by: f64) -> NoiseModel {
    let mut moved = noise.clone();
    match coordinate {
        Coordinate::Sensor(k) => moved.sensor_sigma[k] *= libm::exp(by),
        Coordinate::Input(k) => moved.input_sigma[k] *= libm::exp(by),
        Coordinate::Pole(k) => {
            let [low, high] = POLE_RANGE;
            let pole = libm::tanh(libm::atanh(moved.pole[k]) + by).clamp(low, high);
            moved.pole[k] = if pole == 0.0 { 1e-6 } else { pole };
        }
    }
    moved
}

/// Unknowns and further columns held where they explain most under one noise.
struct Held<'e, 'p> {
    session: &'e EstimationSession<'p>,
    linearised: &'e LinearisedProblem,
    prior: &'e NoisePrior,
    coordinates: Vec<Coordinate>,
    left: Vec<f64>,
    theta: Vec<f64>,
    /// `|x|²` of the further columns' priors.
    beside: f64,
}

/// `−2 ln p` and its slopes.
struct Here {
    value: f64,
    first: DVector<f64>,
    second: DVector<f64>,
}

impl Held<'_, '_> {
    fn here(&self, noise: &NoiseModel) -> Option<Here> {
        let (found, unknowns) = self.linearised.gradient(self.session, (&self.left, &self.theta), noise)?;
        let all = self.coordinates.iter().map(|coordinate| {
            let (_, prior) = self.prior.of(noise, *coordinate);
            let own = slope(&found, *coordinate);
            (own.first + prior.first, own.second + prior.second)
        });
        let (first, second): (Vec<f64>, Vec<f64>) = all.unzip();
        let value = found.value + unknowns + self.beside + self.prior.price(noise);
        let [first, second] = [first, second].map(DVector::from_vec);
        value.is_finite().then_some(Here { value, first, second })
    }

    fn stepped(&self, noise: &NoiseModel, step: &DVector<f64>, share: f64) -> NoiseModel {
        let all = self.coordinates.iter().zip(step.iter());
        all.fold(noise.clone(), |noise, (coordinate, by)| moved(&noise, *coordinate, share * by))
    }

    /// Quasi-Newton steps (BFGS) from expected second derivatives on.
    fn climbed(&self, start: &NoiseModel) -> Option<(NoiseModel, Here)> {
        let (mut noise, mut here) = (start.clone(), self.here(start)?);
        let n = self.coordinates.len();
        let mut inverse = DMatrix::from_diagonal(&here.second.map(|second| 1.0 / second.max(1.0)));
        for _ in 0..STEPS_MAX {
            let mut step = -(&inverse * &here.first);
            let most = step.amax();
            if most > 1.0 {
                step /= most;
            }
            let promised = -0.5 * here.first.dot(&step);
            if promised < STEP_GAIN_MIN {
                break;
            }
            let mut share = 1.0;
            let mut went = None;
            for _ in 0..SHORTENINGS_MAX {
                let tried = self.stepped(&noise, &step, share);
                match self.here(&tried) {
                    Some(found) if found.value < here.value => {
                        went = Some((tried, found));
                        break;
                    }
                    _ => share *= 0.3,
                }
            }
            let Some((tried, found)) = went else { break };
            let (s, y) = (&step * share, &found.first - &here.first);
            let along = s.dot(&y);
            if along > 1e-8 * s.norm() * y.norm() {
                let left = DMatrix::identity(n, n) - &s * y.transpose() / along;
                inverse = &left * &inverse * left.transpose() + &s * s.transpose() / along;
            }
            (noise, here) = (tried, found);
        }
        Some((noise, here))
    }

    /// `ln det` of half the second derivatives of `−2 ln p` at a greatest posterior: by differences
    /// of its slopes, expected ones where these are not positive.
    fn log_curvature(&self, noise: &NoiseModel, here: &Here) -> f64 {
        let n = self.coordinates.len();
        let expected = || here.second.iter().map(|second| libm::log((0.5 * second).max(1e-12))).sum::<f64>();
        if n > DIFFERENCED_MAX {
            return expected();
        }
        let mut matrix = DMatrix::zeros(n, n);
        for (i, coordinate) in self.coordinates.iter().enumerate() {
            let side = |by: f64| self.here(&moved(noise, *coordinate, by));
            let (Some(up), Some(down)) = (side(DIFFERENCE), side(-DIFFERENCE)) else { return expected() };
            matrix.set_column(i, &((up.first - down.first) / (4.0 * DIFFERENCE)));
        }
        let matrix = 0.5 * (&matrix + matrix.transpose());
        Cholesky::new(matrix).map_or_else(expected, |factor| {
            2.0 * factor.l_dirty().diagonal().iter().map(|l| libm::log(*l)).sum::<f64>()
        })
    }
}

fn slope(found: &Gradient, coordinate: Coordinate) -> Slope {
    match coordinate {
        Coordinate::Sensor(k) => found.sensor[k],
        Coordinate::Input(k) => found.input[k],
        Coordinate::Pole(k) => found.pole[k],
    }
}

/// A linear problem with further columns, each per standard deviation of a normal prior.
#[derive(Clone, Copy)]
pub(super) struct Linearly<'a> {
    pub session: &'a EstimationSession<'a>,
    pub linearised: &'a LinearisedProblem,
    pub theta: &'a [f64],
    pub extra: &'a [Vec<f64>],
    /// Room of each further column [prior standard deviations].
    pub room: &'a [[f64; 2]],
}

impl Linearly<'_> {
    /// Normal equations with the priors of all columns.
    pub(super) fn normal(&self, noise: &NoiseModel) -> Option<Normal> {
        let extra: Vec<&Vec<f64>> = self.extra.iter().collect();
        let mut normal = self.linearised.normal(self.session, self.theta, noise, &extra)?;
        for i in normal.unknowns..normal.matrix.nrows() {
            normal.matrix[(i, i)] += 1.0;
        }
        normal.room.extend(self.room);
        Some(normal)
    }

    fn held<'e>(&'e self, noise: &NoiseModel, prior: &'e NoisePrior) -> Option<Held<'e, 'e>> {
        let (_, x) = self.normal(noise)?.least()?;
        let mut left = self.linearised.nu.clone();
        for (column, x) in self.linearised.jacobian.iter().chain(self.extra).zip(&x) {
            left.iter_mut().zip(column).for_each(|(left, c)| *left -= c * x);
        }
        let unknowns = self.session.problem.unknowns.iter().zip(&x);
        let theta: Vec<f64> = self.theta.iter().zip(unknowns).map(|(t, (u, x))| t + x * u.sigma).collect();
        let beside = x[theta.len()..].iter().map(|x| x * x).sum();
        let coordinates = prior.coordinates();
        let (session, linearised) = (self.session, self.linearised);
        Some(Held { session, linearised, prior, coordinates, left, theta, beside })
    }

    /// Noise of greatest posterior from `start`, unknowns and columns free.
    pub(super) fn settled(&self, start: &NoiseModel, prior: &NoisePrior) -> Option<Settled> {
        let mut best = Settled { noise: prior.begun(start), objective: f64::INFINITY };
        for _ in 0..HOLDS_MAX {
            let held = self.held(&best.noise, prior)?;
            let (noise, here) = held.climbed(&best.noise)?;
            let gained = best.objective - here.value;
            best = Settled { noise, objective: here.value };
            if gained < STEP_GAIN_MIN {
                break;
            }
        }
        Some(best)
    }

    /// `ln` of the noise's share of the evidence: its prior at `noise` and the width of its
    /// posterior.
    pub(super) fn log_width(&self, noise: &NoiseModel, prior: &NoisePrior) -> Option<f64> {
        let held = self.held(noise, prior)?;
        let here = held.here(noise)?;
        Some(-0.5 * prior.price(noise) - 0.5 * held.log_curvature(noise, &here))
    }

    /// The same by expected second derivatives alone.
    pub(super) fn log_width_expected(&self, noise: &NoiseModel, prior: &NoisePrior) -> Option<f64> {
        let here = self.held(noise, prior)?.here(noise)?;
        let curvature: f64 = here.second.iter().map(|second| libm::log((0.5 * second).max(1e-12))).sum();
        Some(-0.5 * prior.price(noise) - 0.5 * curvature)
    }

    /// Free unstated disturbances off their floors, where that explains more.
    pub(super) fn scanned(&self, start: &NoiseModel, prior: &NoisePrior) -> Option<NoiseModel> {
        let held = self.held(start, prior)?;
        let mut best = (start.clone(), held.here(start)?.value);
        let free = |k: &usize| prior.level_sigma[*k].is_finite() && !prior.holds(*k);
        for k in (0..start.input_sigma.len()).filter(free) {
            for decade in 0..DECADES {
                let mut tried = best.0.clone();
                tried.input_sigma[k] = prior.level_sigma[k] * libm::pow(10.0, -f64::from(decade));
                match held.here(&tried) {
                    Some(found) if found.value < best.1 => best = (tried, found.value),
                    _ => {}
                }
            }
        }
        Some(best.0)
    }
}

#[cfg(test)]
mod tests;
