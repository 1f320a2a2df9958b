//! All coordinates of the noise at once along the gradient of the likelihood: quasi-Newton steps
//! (BFGS) from expected second derivatives on.
//!
//! Unknowns and columns are held where they explain most, and found again at each end of the way,
//! until that moves it no more. White noise gets a pole where the slope along it says that one is
//! worth its price; one that is not in the end is removed: it would only make the filter larger.

use super::{Coordinate, POLE_MAX, POLE_MIN, SWEPT, Search, begun, moved};
use crate::filter::{Gradient, NoiseModel, Slope};
use crate::fit::{EstimationSession, LinearisedProblem};
use nalgebra::{DMatrix, DVector};

/// How often unknowns and columns are found again, and steps to each end for every sweep of a
/// search.
const HOLDS_MAX: usize = 3;
const STEPS_PER_SWEEP: usize = 4;
/// Largest step of a coordinate, and of the first one of a pole.
const STRIDE: f64 = 1.0;
const POLE_STRIDE: f64 = 0.6;
/// How often a step is shortened, between which shares of itself, and the share of the promised
/// gain that it must keep.
const SHORTENINGS_MAX: usize = 6;
const SHORTENING: [f64; 2] = [0.05, 0.5];
const GAIN_SHARE_MIN: f64 = 1e-2;
/// Second derivative of a weak prior on the logarithm of a size: a factor e.
const LOOSE_PRIOR_CURVATURE: f64 = 2.0;
/// Gain in `−2 ln p` below which a pole is rejected: what chance gives a parameter that is not
/// there (AIC).
const POLE_PRICE: f64 = 2.0;

/// Noise that minimises `−2 ln p` over noise, unknowns and `extra` columns from `start`; returns it
/// with that minimum.
///
/// Cost: normal equations for each hold; about three likelihoods of one column a step, however many
/// coordinates there are.
pub(super) fn climbed(
    (session, linearised): (&EstimationSession<'_>, &LinearisedProblem),
    (theta, extra): (&[f64], &[&Vec<f64>]),
    start: &NoiseModel,
    list: Vec<Coordinate>,
    search: Search,
) -> Option<(NoiseModel, f64)> {
    let hold = |noise: &NoiseModel| Held::new((session, linearised), theta, extra, noise);
    let mut held = hold(start)?;
    let size = linearised.linears.first().map_or(0, |linear| linear.layout.len());
    let (noise, least) = begun(session, search, size, (start, held.least), &|noise| held.value(noise));
    let mut climb = Climb::new(&list, noise, least);
    for _ in 0..HOLDS_MAX {
        let before = held.least;
        climb.go(&held, STEPS_PER_SWEEP * search.sweeps);
        if climb.without_idle_poles(&held) {
            climb.go(&held, STEPS_PER_SWEEP);
        }
        let Some(again) = hold(&climb.noise) else { break };
        held = again;
        climb.least = held.least;
        if before - held.least < SWEPT {
            break;
        }
    }
    Some((climb.noise, climb.least))
}

/// Unknowns and further columns held where they explain most under one noise.
struct Held<'e, 'p> {
    session: &'e EstimationSession<'p>,
    linearised: &'e LinearisedProblem,
    /// What they leave of the raw innovations, and where the unknowns are.
    left: Vec<f64>,
    theta: Vec<f64>,
    /// `−2 ln p` there under that noise: least over unknowns and columns.
    least: f64,
}

impl<'e, 'p> Held<'e, 'p> {
    fn new(
        (session, linearised): (&'e EstimationSession<'p>, &'e LinearisedProblem),
        theta: &[f64],
        extra: &[&Vec<f64>],
        noise: &NoiseModel,
    ) -> Option<Self> {
        let (least, x) = linearised.normal(session, theta, noise, extra)?.least()?;
        let mut left = linearised.nu.clone();
        for (column, x) in linearised.jacobian.iter().chain(extra.iter().copied()).zip(&x) {
            left.iter_mut().zip(column).for_each(|(left, c)| *left -= c * x);
        }
        let unknowns = session.problem.unknowns.iter().zip(&x);
        let theta = theta.iter().zip(unknowns).map(|(theta, (unknown, x))| theta + x * unknown.sigma).collect();
        Some(Self { session, linearised, left, theta, least: least + session.disturbance_price(noise) })
    }

    /// `−2 ln p` under another noise.
    fn value(&self, noise: &NoiseModel) -> Option<f64> {
        let value = self.linearised.objective(self.session, &self.left, &self.theta, noise)?;
        Some(value + self.session.disturbance_price(noise))
    }

    /// The same with its slopes.
    fn gradient(&self, noise: &NoiseModel) -> Option<Gradient> {
        let (mut found, prior) = self.linearised.gradient(self.session, (&self.left, &self.theta), noise)?;
        found.value += prior + self.session.disturbance_price(noise);
        let levels = noise.input_sigma.iter().zip(&self.session.disturbance_sigma);
        for (slope, (level, sigma)) in found.input.iter_mut().zip(levels) {
            let price = (level / sigma).powi(2);
            *slope += Slope { first: 2.0 * price, second: 4.0 * price };
        }
        Some(found)
    }
}

/// Where the way has come to.
struct Climb<'l> {
    list: &'l [Coordinate],
    noise: NoiseModel,
    least: f64,
    /// Poles of channels that turned out to be none.
    idle: Vec<usize>,
}

impl<'l> Climb<'l> {
    fn new(list: &'l [Coordinate], noise: NoiseModel, least: f64) -> Self {
        Self { list, noise, least, idle: Vec::new() }
    }

    /// At most so many steps, until none promises anything.
    fn go(&mut self, held: &Held<'_, '_>, steps: usize) {
        let Some(mut here) = held.gradient(&self.noise) else { return };
        let mut metric: Option<(Vec<Coordinate>, Metric)> = None;
        for _ in 0..steps {
            let moves = self.moves(&here);
            let slopes: Vec<Slope> = moves.iter().map(|c| along(&here, *c)).collect();
            let first = DVector::from_iterator(slopes.len(), slopes.iter().map(|slope| slope.first));
            // what is moved has changed
            metric = metric.filter(|(of, _)| *of == moves);
            let is_fresh = metric.is_none();
            let (_, own) = metric.get_or_insert_with(|| (moves.clone(), Metric::new(&slopes)));
            own.learn(&first);
            let step = own.step(&first);
            let promised = -0.5 * first.dot(&step);
            let went = if promised < SWEPT { None } else { self.moved_by(held, &moves, &step, promised) };
            match went {
                Some((made, found)) => {
                    own.went(made, first);
                    here = found;
                }
                None if promised >= SWEPT && !is_fresh => metric = None,
                // sizes are as good as they get
                None => match self.take_up_poles(held, &here) {
                    Some(found) => (here, metric) = (found, None),
                    None => return,
                },
            }
        }
    }

    /// What is moved: every size, jitters and poles that are there; a pole at its bound not beyond
    /// it.
    fn moves(&self, here: &Gradient) -> Vec<Coordinate> {
        let jitters = (0..self.noise.jitter_s.len()).map(Coordinate::Jitter);
        let is_free = |coordinate: &Coordinate| match *coordinate {
            Coordinate::Input(_) | Coordinate::Sensor(_) => true,
            Coordinate::Jitter(k) => self.noise.jitter_s[k] > 0.0,
            Coordinate::Pole(k) => {
                let (pole, slope) = (self.noise.pole[k], here.pole[k].first);
                let leaves = pole >= POLE_MAX && slope < 0.0 || pole <= POLE_MIN && slope > 0.0;
                pole != 0.0 && !leaves
            }
        };
        self.list.iter().copied().chain(jitters).filter(is_free).collect()
    }

    /// The largest share of `step` that keeps what it promises is gone, shortened along parabolas;
    /// what was gone, and the slopes there.
    fn moved_by(
        &mut self,
        held: &Held<'_, '_>,
        moves: &[Coordinate],
        step: &DVector<f64>,
        promised: f64,
    ) -> Option<(DVector<f64>, Gradient)> {
        let mut share = 1.0;
        for _ in 0..SHORTENINGS_MAX {
            let by = moves.iter().zip(step);
            let tried = by.fold(self.noise.clone(), |noise, (coordinate, by)| moved(&noise, *coordinate, share * by));
            let found = held.gradient(&tried);
            let value = found.as_ref().map_or(f64::INFINITY, |found| found.value);
            if let Some(found) = found.filter(|_| value < self.least - GAIN_SHARE_MIN * share * promised) {
                let made = DVector::from_iterator(
                    step.len(),
                    moves.iter().zip(step).map(|(coordinate, by)| match *coordinate {
                        Coordinate::Pole(k) => libm::atanh(tried.pole[k]) - libm::atanh(self.noise.pole[k]),
                        _ => share * by,
                    }),
                );
                (self.noise, self.least) = (tried, value);
                return Some((made, found));
            }
            // least of the parabola through the value here, its slope and the value there
            let bend = (value - self.least) / share + 2.0 * promised;
            let [least, most] = SHORTENING;
            share *= (promised / bend).clamp(least, most);
            if share * promised < SWEPT {
                break;
            }
        }
        None
    }

    /// Takes up poles where white noise says that they are worth it; the slopes there, if there are
    /// any.
    fn take_up_poles(&mut self, held: &Held<'_, '_>, here: &Gradient) -> Option<Gradient> {
        let before = self.noise.clone();
        for coordinate in self.list {
            let Coordinate::Pole(k) = *coordinate else { continue };
            let slope = here.pole[k];
            let is_worth = slope.first.powi(2) > 2.0 * POLE_PRICE * slope.second.max(f64::MIN_POSITIVE);
            if self.noise.pole[k] != 0.0 || self.idle.contains(&k) || !is_worth {
                continue;
            }
            let by = (-slope.first / slope.second).clamp(-POLE_STRIDE, POLE_STRIDE);
            let tried = moved(&self.noise, *coordinate, by);
            match held.value(&tried) {
                Some(value) if value < self.least => (self.noise, self.least) = (tried, value),
                _ => self.idle.push(k),
            }
        }
        if self.noise == before { None } else { held.gradient(&self.noise) }
    }

    /// Poles that gain less than their price are removed; whether any was.
    fn without_idle_poles(&mut self, held: &Held<'_, '_>) -> bool {
        let before = self.idle.len();
        for coordinate in self.list {
            let Coordinate::Pole(k) = *coordinate else { continue };
            if self.noise.pole[k] == 0.0 {
                continue;
            }
            let mut without = self.noise.clone();
            without.pole[k] = 0.0;
            if let Some(value) = held.value(&without).filter(|value| *value < self.least + POLE_PRICE) {
                (self.noise, self.least) = (without, value);
                self.idle.push(k);
            }
        }
        self.idle.len() > before
    }
}

fn along(here: &Gradient, coordinate: Coordinate) -> Slope {
    match coordinate {
        Coordinate::Input(k) => here.input[k],
        Coordinate::Sensor(k) => here.sensor[k],
        Coordinate::Pole(k) => here.pole[k],
        Coordinate::Jitter(k) => here.jitter[k],
    }
}

/// Inverse of the second derivatives, learnt step by step (BFGS).
struct Metric {
    inverse: DMatrix<f64>,
    /// Last step and the slopes where it began.
    last: Option<(DVector<f64>, DVector<f64>)>,
}

impl Metric {
    fn new(slopes: &[Slope]) -> Self {
        let second = DVector::from_iterator(
            slopes.len(),
            slopes.iter().map(|slope| 1.0 / (slope.second + LOOSE_PRIOR_CURVATURE)),
        );
        Self { inverse: DMatrix::from_diagonal(&second), last: None }
    }

    fn went(&mut self, step: DVector<f64>, first: DVector<f64>) {
        self.last = Some((step, first));
    }

    /// What the slopes at the end of the last step tell of the second derivatives along it.
    fn learn(&mut self, first: &DVector<f64>) {
        let Some((s, before)) = self.last.take() else { return };
        let y = first - before;
        let along = s.dot(&y);
        if along <= 1e-8 * s.norm() * y.norm() {
            return;
        }
        let n = s.len();
        let left = DMatrix::identity(n, n) - &s * y.transpose() / along;
        self.inverse = &left * &self.inverse * left.transpose() + &s * s.transpose() / along;
    }

    /// Downhill, no coordinate farther than [`STRIDE`].
    fn step(&self, first: &DVector<f64>) -> DVector<f64> {
        let step = -(&self.inverse * first);
        let most = step.amax();
        if most > STRIDE { step * (STRIDE / most) } else { step }
    }
}

#[cfg(test)]
mod tests;
