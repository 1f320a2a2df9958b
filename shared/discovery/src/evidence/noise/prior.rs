//! Priors of the numbers of the noise.
//!
//! | number | prior |
//! |---|---|
//! | sensor | lognormal about its stated size, [`SENSOR_SPREAD`] |
//! | stated disturbance | lognormal about its stated size, [`DISTURBANCE_SPREAD`] |
//! | unstated disturbance of a set | half-normal, a share of the forces at work (the session's) |
//! | pole of a coloured channel | normal, [`POLE_PRIOR`] |
//!
//! An unstated disturbance is a hypothesis: a model without it has it at its floor, which no record
//! shows. Free in every model it would take for nothing what a law has to pay for.
//!
//! A half-normal level l of width s has the density `2/√(2π) (l/s) exp(−(l/s)²/2)` over `ln l`. Its
//! factor l/s keeps Laplace's method off the boundary: where the prior bounds the level, it is
//! short of the integral by 0.15 nats.

use super::{Coordinate, unstated};
use crate::evidence::decide::{DISTURBANCE_SPREAD, NOISE_SIGMA, POLE_PRIOR, SENSOR_SPREAD};
use crate::evidence::hypothesis::Hypothesis;
use identification::filter::{NoiseModel, Slope};
use identification::fit::EstimationSession;

/// Share of a free disturbance's prior width below which a fit does not begin: the least that it is
/// looked for at.
const LEVEL_LEAST: f64 = 1e-3;

/// Which channels are coloured, and what the numbers are relative to.
#[derive(Clone, Debug)]
pub(in crate::evidence) struct NoisePrior {
    stated: NoiseModel,
    /// Of an unstated disturbance; infinite of a stated one.
    pub(super) level_sigma: Vec<f64>,
    coloured: Vec<usize>,
    /// Disturbances at their stated size or at their floor.
    held: Vec<usize>,
}

impl NoisePrior {
    /// Of a model: coloured channels and unstated disturbances are those of its set.
    pub(in crate::evidence) fn new(session: &EstimationSession<'_>, set: &[Hypothesis]) -> Self {
        let (stated, level_sigma) = (session.noise.clone(), session.disturbance_sigma.clone());
        let of = |own: &Hypothesis| if let Hypothesis::Coloured(channel) = own { Some(*channel) } else { None };
        let is_member = |k: &usize| set.iter().any(|own| matches!(own, Hypothesis::Disturbance(own, _) if own == k));
        let held = unstated(session).filter(|k| !is_member(k)).collect();
        Self { stated, level_sigma, coloured: set.iter().filter_map(of).collect(), held }
    }

    /// The same with these disturbances held, too.
    pub(in crate::evidence) fn holding(mut self, more: &[usize]) -> Self {
        self.held.extend(more);
        self
    }

    /// A disturbance is held.
    pub(in crate::evidence) fn holds(&self, input: usize) -> bool {
        self.held.contains(&input)
    }

    pub(super) fn coordinates(&self) -> Vec<Coordinate> {
        let sensors = (0..self.stated.sensor_sigma.len()).map(Coordinate::Sensor);
        let free = |k: &usize| !self.held.contains(k);
        let inputs = (0..self.stated.input_sigma.len()).filter(free).map(Coordinate::Input);
        sensors.chain(inputs).chain(self.coloured.iter().copied().map(Coordinate::Pole)).collect()
    }

    /// `−2 ln` of the prior's density of one coordinate, up to `ln 2π`, and its derivatives.
    pub(super) fn of(&self, noise: &NoiseModel, coordinate: Coordinate) -> (f64, Slope) {
        let normal = |off: f64, sigma: f64| {
            let z = off / sigma;
            (z * z + 2.0 * libm::log(sigma), Slope { first: 2.0 * z / sigma, second: 2.0 / (sigma * sigma) })
        };
        match coordinate {
            Coordinate::Sensor(k) => {
                normal(libm::log(noise.sensor_sigma[k] / self.stated.sensor_sigma[k]), SENSOR_SPREAD)
            }
            Coordinate::Input(k) if self.level_sigma[k].is_infinite() => {
                normal(libm::log(noise.input_sigma[k] / self.stated.input_sigma[k]), DISTURBANCE_SPREAD)
            }
            Coordinate::Input(k) => {
                let share = noise.input_sigma[k] / self.level_sigma[k];
                let square = share * share;
                let value = square - 2.0 * libm::log(share) - 2.0 * core::f64::consts::LN_2;
                (value, Slope { first: 2.0 * square - 2.0, second: 4.0 * square })
            }
            Coordinate::Pole(k) => {
                let pole = noise.pole[k];
                let (value, slope) = normal(pole - POLE_PRIOR[0], POLE_PRIOR[1]);
                let turn = 1.0 - pole * pole;
                let first = slope.first * turn + 4.0 * pole;
                (value - 2.0 * libm::log(turn), Slope { first, second: slope.second * turn * turn + 4.0 * turn })
            }
        }
    }

    /// `−2 ln` of the prior's density of all coordinates.
    pub(in crate::evidence) fn price(&self, noise: &NoiseModel) -> f64 {
        self.coordinates().into_iter().map(|coordinate| self.of(noise, coordinate).0).sum()
    }

    /// A sensor or a stated disturbance lies beyond [`NOISE_SIGMA`] of its prior.
    pub(in crate::evidence) fn is_off(&self, noise: &NoiseModel) -> bool {
        let off = |own: f64, stated: f64, spread: f64| libm::log(own / stated).abs() > NOISE_SIGMA * spread;
        let sensors = noise.sensor_sigma.iter().zip(&self.stated.sensor_sigma);
        let inputs = noise.input_sigma.iter().zip(&self.stated.input_sigma).zip(&self.level_sigma);
        sensors.clone().any(|(own, stated)| off(*own, *stated, SENSOR_SPREAD))
            || inputs
                .filter(|(_, level)| level.is_infinite())
                .any(|((own, stated), _)| off(*own, *stated, DISTURBANCE_SPREAD))
    }

    /// Noise to start from: poles of coloured channels at the mean of their prior, none of others;
    /// held disturbances where they are held, free ones off their floors.
    pub(in crate::evidence) fn begun(&self, noise: &NoiseModel) -> NoiseModel {
        let mut begun = noise.clone();
        for k in 0..begun.input_sigma.len() {
            let (level, stated) = (self.level_sigma[k], self.stated.input_sigma[k]);
            if self.held.contains(&k) {
                begun.input_sigma[k] = stated;
            } else if level.is_finite() && begun.input_sigma[k] < LEVEL_LEAST * level {
                begun.input_sigma[k] = level;
            }
        }
        for k in 0..begun.pole.len() {
            let is_coloured = self.coloured.contains(&k);
            begun.pole[k] = match (is_coloured, begun.pole[k] != 0.0) {
                (true, true) => begun.pole[k],
                (true, false) => POLE_PRIOR[0],
                (false, _) => 0.0,
            };
        }
        begun
    }
}
