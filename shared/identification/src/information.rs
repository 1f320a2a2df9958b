//! The information of a plant's sensors and commands on its uncertain parameters, before a flight:
//! Fisher information.
//!
//! `F = Jᵀ Σ⁻¹ J + diag(1/σ_prior²)`, `J = ∂y/∂θ` by central differences of noise-free simulations
//! along the commands that the nominal loop gives, `Σ` the covariance of all readings under the
//! noise of sensors and actuators (Kay 1993, Eq. 3.31). Parameters are scaled by their priors, so
//! that `F` is free of units; the directions that the data do not raise above the prior are the
//! combinations that cannot be found. The scaled `J` is factorised, not `F`: a wheel speed known to
//! 1e-9 of its prior would otherwise drown them in rounding.
//!
//! Commands are known as they are recorded; the noise that actuators put on them is
//! whitened as a maximum-likelihood fit in innovation form does. What acts besides
//! makes every sigma larger.

mod weak;
mod whitening;

pub use weak::Blind;

use channels::{Channel, Recording};
use dynamics::description::{Noise, Parameter, Plant, Quantity, Signal, SignalKind};
use dynamics::system::Period;
use estimation::identifiability::Identifiability;
use nalgebra::{DMatrix, DVector};

/// Step of the central difference in prior sigmas: truncation falls with its square, rounding grows
/// with its inverse.
const STEP_SIGMAS: f64 = 1e-3;
/// Where readings bend this share as much as they follow a step, nothing is linear about them:
/// moved up and down at random they come to one.
const BENT: f64 = 0.7;
/// Rows that are folded into the triangle at a time.
const BLOCK_ROWS: usize = 2048;

/// One uncertain number of the plant.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    pub name: String,
    pub unit: String,
    pub value: f64,
    pub prior_sigma: f64,
    /// After the experiment.
    pub sigma: f64,
    /// With every other number known.
    pub sigma_alone: f64,
    pub identifiability: Identifiability,
}

/// The outcome of an experiment, predicted.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// In file order.
    pub parameters: Vec<Expected>,
    pub blind: Vec<Blind>,
    /// Of all channels that count.
    pub samples: usize,
    /// Sensors that state neither noise nor resolution: what they say has no weight here.
    pub without_noise: Vec<String>,
    /// Of the parameters after the experiment, each in its prior sigma.
    covariance: DMatrix<f64>,
}

impl Prediction {
    /// Expected sigma of a function of the parameters with this `gradient` (SI, in the order of
    /// [`Prediction::parameters`]).
    pub fn sigma_of(&self, gradient: &[f64]) -> f64 {
        assert!(gradient.len() == self.parameters.len());
        let scaled = gradient.iter().zip(&self.parameters).map(|(slope, parameter)| slope * parameter.prior_sigma);
        let scaled = DVector::from_iterator(gradient.len(), scaled);
        scaled.dot(&(&self.covariance * &scaled)).max(0.0).sqrt()
    }
}

/// Why nothing can be predicted.
#[derive(Debug, thiserror::Error)]
pub enum InformationError {
    /// Of the simulator.
    #[error(transparent)]
    Simulation(#[from] Box<dyn core::error::Error>),
    /// What a number does is no line even where it moves by a thousandth of its prior sigma.
    #[error(
        "what '{parameter}' does over {duration_s} s cannot be predicted: under its commands alone, its loops cut, the plant runs away; a shorter duration can be"
    )]
    NoLine { parameter: String, duration_s: f64 },
}

/// What a simulator gives, or why it cannot.
pub type Simulated<T> = Result<T, Box<dyn core::error::Error>>;

/// What is called for every control period.
pub type Visit<'v> = &'v mut dyn FnMut(&Period<'_>);

/// An experiment without noise, as a simulator carries it out.
#[derive(Clone, Copy)]
pub struct Simulate<'a> {
    /// What a recording of so many seconds of the plant holds.
    pub record: &'a dyn Fn(&Plant, f64) -> Simulated<Recording>,
    /// Calls the last argument for every control period of that motion.
    pub motion: &'a dyn Fn(&Plant, f64, Visit<'_>) -> Simulated<()>,
}

/// Predicts what `duration_s` of the plant's own experiment tells of every number with a prior.
///
/// # Errors
/// The simulator's; [`InformationError::NoLine`] where the plant runs away once its loops are cut.
///
/// Cost: two simulations a parameter. `progress` receives the share done.
pub fn predict(
    plant: &Plant,
    duration_s: f64,
    simulate: Simulate<'_>,
    progress: &mut dyn FnMut(f64),
) -> Result<Prediction, InformationError> {
    let quiet = quiet(plant);
    let nominal = (simulate.record)(&quiet, duration_s)?;
    let experiment = Experiment {
        open: open_loop(&quiet, &nominal),
        weight: weights(plant, &nominal),
        nominal,
        duration_s,
        simulate,
    };
    // what is only noise is not in the mean, and the quiet plant does not list it
    let uncertain: Vec<(Parameter, f64)> =
        quiet.parameters().into_iter().filter_map(|p| p.sigma.map(|sigma| (p, sigma))).collect();
    let mut columns = Vec::with_capacity(uncertain.len());
    for (done, (parameter, sigma)) in uncertain.iter().enumerate() {
        columns.push(experiment.sensitivity(parameter, *sigma)?);
        progress((done + 1) as f64 / uncertain.len() as f64);
    }
    whitening::whiten(plant, &quiet, (&experiment.nominal, &experiment.weight), (duration_s, simulate), &mut columns)?;
    Ok(experiment.outcome(plant, &uncertain, &columns))
}

/// The plant without noise, quantisation and jitter.
fn quiet(plant: &Plant) -> Plant {
    let zero = Quantity::known(0.0);
    let mut quiet = plant.clone();
    quiet.simulation.jitter_s = 0.0;
    for actuator in &mut quiet.actuators {
        // the loops are opened along the commands of their actuators
        (actuator.noise, actuator.recorded) = (zero, true);
    }
    for sensor in &mut quiet.sensors {
        (sensor.noise, sensor.resolution) = (Noise::PerSample(zero), zero);
    }
    quiet
}

/// The same plant with its loops cut: controllers only say where it starts, commands are those of
/// `nominal`.
fn open_loop(quiet: &Plant, nominal: &Recording) -> Plant {
    let zero = Quantity::known(0.0);
    let mut open = quiet.clone();
    for controller in &mut open.controllers {
        (controller.kp, controller.ki, controller.kd, controller.feed_forward) = (zero, zero, zero, zero);
        let Some(channel) = nominal.channels.iter().find(|channel| channel.name == controller.actuator) else {
            continue;
        };
        let held = SignalKind::Table { time_s: channel.time_s.clone(), value: channel.value.clone(), smooth: false };
        let actuator = open.actuators.iter_mut().find(|actuator| actuator.name == controller.actuator);
        if let Some(actuator) = actuator {
            actuator.command = vec![Signal { kind: held, begin_s: zero, end_s: None }];
        }
    }
    open
}

/// 1/σ of each sensor channel of a recording, in its order; 0 for commands and for channels without
/// noise.
fn weights(plant: &Plant, recording: &Recording) -> Vec<f64> {
    let of = |name: &str| {
        let sensor = plant.sensors.iter().find(|sensor| sensor.name == name)?;
        let period_s = sensor.period_s.map_or(plant.simulation.period_s, |period| period.value);
        let white = match sensor.noise {
            Noise::PerSample(sigma) => sigma.value,
            Noise::Density(density) => density.value / period_s.sqrt(),
        };
        let step = sensor.resolution.value;
        let variance = white * white + step * step / 12.0;
        (variance > 0.0).then(|| 1.0 / variance.sqrt())
    };
    recording.channels.iter().map(|channel| of(&channel.name).unwrap_or(0.0)).collect()
}

/// What is simulated again with one number moved.
struct Experiment<'a> {
    simulate: Simulate<'a>,
    open: Plant,
    nominal: Recording,
    weight: Vec<f64>,
    duration_s: f64,
}

impl Experiment<'_> {
    /// `∂y/∂θ σ_prior`, all weighted channels one below the other.
    fn sensitivity(&self, parameter: &Parameter, sigma: f64) -> Result<DVector<f64>, InformationError> {
        let simulate = |value: f64| {
            let mut moved = self.open.clone();
            moved.set_parameter(&parameter.name, value).expect("the name is one that the plant listed");
            (self.simulate.record)(&moved, self.duration_s)
        };
        let step = STEP_SIGMAS * sigma;
        let (above, below) = (simulate(parameter.value + step)?, simulate(parameter.value - step)?);
        let mut column = Vec::new();
        let scale = 1.0 / (2.0 * STEP_SIGMAS);
        for (i, _) in self.weight.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let change = difference(&above.channels[i], &below.channels[i], &self.nominal.channels[i]);
            column.extend(change.map(|change| scale * change));
        }
        if self.is_bent(&above, &below) {
            return Err(InformationError::NoLine { parameter: parameter.name.clone(), duration_s: self.duration_s });
        }
        Ok(DVector::from_vec(column))
    }

    /// Over a step up and one down readings bend by what can be seen, and nearly as much as they
    /// follow: `|y₊ − 2 y + y₋|` against `|y₊ − y₋|`.
    fn is_bent(&self, above: &Recording, below: &Recording) -> bool {
        let (mut follows, mut bends) = (0.0, 0.0);
        for (i, weight) in self.weight.iter().enumerate() {
            let (above, below, nominal) = (&above.channels[i], &below.channels[i], &self.nominal.channels[i]);
            let both = above.value.len().min(below.value.len());
            let steps = difference(above, nominal, nominal).zip(difference(nominal, below, nominal));
            for (up, down) in steps.take(both) {
                follows += (weight * (up + down)).powi(2);
                bends += (weight * (up - down)).powi(2);
            }
        }
        // per prior sigma, as columns are: what no sensor could read bends by rounding alone
        bends > (2.0 * STEP_SIGMAS).powi(2) && bends > BENT * BENT * follows
    }

    fn outcome(&self, plant: &Plant, uncertain: &[(Parameter, f64)], columns: &[DVector<f64>]) -> Prediction {
        let n = uncertain.len();
        let svd = triangle(columns).svd(false, true);
        let directions = svd.v_t.expect("the right factor is computed");
        // of the posterior, in units of the prior
        let variance = svd.singular_values.map(|s| 1.0 / (1.0 + s * s));
        let covariance = directions.tr_mul(&DMatrix::from_diagonal(&variance)) * &directions;
        let parameters = uncertain.iter().enumerate().map(|(i, (parameter, sigma))| {
            let ratio = covariance[(i, i)].sqrt();
            Expected {
                name: parameter.name.clone(),
                unit: parameter.unit.clone(),
                value: parameter.value,
                prior_sigma: *sigma,
                sigma: sigma * ratio,
                sigma_alone: sigma / (1.0 + columns[i].norm_squared()).sqrt(),
                identifiability: Identifiability::of(ratio, 1.0),
            }
        });
        let unseen: Vec<usize> =
            (0..n).filter(|i| Identifiability::of(variance[*i].sqrt(), 1.0) == Identifiability::NotExcited).collect();
        Prediction {
            parameters: parameters.collect(),
            blind: weak::combinations(directions.select_rows(&unseen), uncertain, &covariance),
            samples: columns.first().map_or(0, DVector::len),
            without_noise: self.without_noise(plant),
            covariance,
        }
    }

    fn without_noise(&self, plant: &Plant) -> Vec<String> {
        let weighted = |name: &str| {
            let found = self.nominal.channels.iter().zip(&self.weight).find(|(channel, _)| channel.name == name);
            found.is_some_and(|(_, weight)| *weight > 0.0)
        };
        plant.sensors.iter().map(|sensor| &sensor.name).filter(|name| !weighted(name)).cloned().collect()
    }
}

/// Difference of two records of a channel at equal *stamps*: a clock that is off moves the stamps,
/// not the values. As many as `nominal` has samples; where a record lacks one, it says nothing.
fn difference<'a>(above: &'a Channel, below: &'a Channel, nominal: &'a Channel) -> impl Iterator<Item = f64> + 'a {
    (0..nominal.value.len()).map(move |k| {
        let (Some(a), Some(b)) = (above.value.get(k), below.value.get(k)) else { return 0.0 };
        let stamps_s = above.time_s[k] - below.time_s[k];
        let drift = if stamps_s == 0.0 { 0.0 } else { slope(nominal, k) * stamps_s };
        a - b - drift
    })
}

/// Rate of a channel at sample `k`, central where there are neighbours.
fn slope(channel: &Channel, k: usize) -> f64 {
    let (before, after) = (k.saturating_sub(1), (k + 1).min(channel.value.len() - 1));
    let length_s = channel.time_s[after] - channel.time_s[before];
    if length_s > 0.0 { (channel.value[after] - channel.value[before]) / length_s } else { 0.0 }
}

/// `R` of the QR factorisation of `columns`, block by block: the Jacobian is never copied whole.
fn triangle(columns: &[DVector<f64>]) -> DMatrix<f64> {
    let n = columns.len();
    let rows = columns.first().map_or(0, DVector::len);
    let mut r = DMatrix::zeros(n, n);
    for begin in (0..rows).step_by(BLOCK_ROWS) {
        let block = BLOCK_ROWS.min(rows - begin);
        let stacked = DMatrix::from_fn(n + block, n, |i, j| if i < n { r[(i, j)] } else { columns[j][begin + i - n] });
        r = stacked.qr().r();
    }
    r
}

#[cfg(test)]
mod tests;
