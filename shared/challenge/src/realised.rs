//! Detectability of an effect in a recording: d, the share that nominal parameters absorb, and the
//! similarity to rivals.
//!
//! The noise-free record with the effect, less the one without it under the same command, whitened
//! ([`crate::whiten`]), is fitted by the sensitivities of all parameters with a prior (which is a
//! row of its own) and of the initial state (free); chord steps follow the curvature until the gain
//! vanishes. `d²` is the energy that no parameter values explain, `kappa = 1 − d² / d₀²` the share
//! that they do. d² is the noncentrality of the ideal test, which knows the direction of the effect
//! and the right noise. Approximations: sensitivities are those of the nominal record; a quantiser
//! is noise.

use crate::bench::{Bench, coordinates};
use crate::equations::Numbers;
use crate::hidden::{Faults, Hidden, Seat};
use crate::machines::machine;
use crate::motion::Rig;
use crate::simulate::{Command, Experiment, Trace, simulate};
use crate::whiten::Whitener;
use nalgebra::{DMatrix, DVector};

/// Share of a prior's sigma over which a sensitivity is taken.
const SHARE: f64 = 1e-3;
/// Change of an initial coordinate over which a sensitivity is taken [rad or m, per second].
const INITIAL: f64 = 1e-5;

/// Chord steps, and the dampings of each: weakly determined parameters must not move far.
const STEPS: usize = 12;
const DAMPINGS: [f64; 5] = [0.0, 1e-6, 1e-4, 1e-2, 1.0];
/// Share of the cost that ends the descent: two percent of d².
const GAIN: f64 = 0.02;

/// Cost, parameters and residual.
type Point = (f64, DVector<f64>, DVector<f64>);

/// The machine of `bench` with `list` hidden in it.
#[must_use]
pub fn rig(bench: &Bench, numbers: &Numbers, list: &[(Hidden, Seat)], inputs: usize, sensors: usize) -> Rig {
    let faults = Faults::of(list, inputs, sensors);
    Rig { equations: machine(bench.plant, numbers, faults.extra), faults }
}

/// One noise-free experiment with its sensitivities; evaluates the detectability of effects.
pub struct Lab<'a> {
    pub bench: &'a Bench,
    pub numbers: Numbers,
    pub experiment: Experiment,
    sensors: Vec<String>,
    inputs: usize,
    /// Name and prior sigma of the parameters.
    priors: Vec<(String, f64)>,
    whitener: Whitener,
    /// Columns: parameters in units of their prior, then the initial state.
    jacobian: DMatrix<f64>,
    normal: DMatrix<f64>,
    /// The nominal record; `None` in a closed loop, where commands depend on readings.
    base: Option<Trace>,
}

/// Detectability of an effect in a recording.
#[derive(Clone, Debug)]
pub struct Realised {
    pub d: f64,
    pub kappa: f64,
    /// Per parameter: bias of the nominal fit in its posterior sigmas.
    pub shifts: Vec<(String, f64)>,
    /// The whitened residual.
    pub direction: DVector<f64>,
}

impl<'a> Lab<'a> {
    /// `experiment` comes without noise; `sigma` per sensor includes quantisation.
    #[must_use]
    pub fn new(
        bench: &'a Bench,
        numbers: &Numbers,
        experiment: Experiment,
        sensors: Vec<String>,
        priors: Vec<(String, f64)>,
        (sigma, input_sigma): (&[f64], &[f64]),
    ) -> Self {
        let inputs = input_sigma.len();
        let nominal = rig(bench, numbers, &[], inputs, sensors.len());
        let whitener = Whitener::new(&nominal, sigma, input_sigma, (experiment.period_s, experiment.samples));
        let mut lab = Self {
            bench,
            numbers: numbers.clone(),
            experiment,
            sensors,
            inputs,
            priors,
            whitener,
            jacobian: DMatrix::zeros(0, 0),
            normal: DMatrix::zeros(0, 0),
            base: None,
        };
        lab.linearise();
        lab
    }

    fn run(&self, list: &[(Hidden, Seat)], numbers: &Numbers, experiment: &Experiment) -> Trace {
        let rig = rig(self.bench, numbers, list, self.inputs, self.sensors.len());
        simulate(&rig, numbers, &self.sensors, experiment)
    }

    /// The experiment with `beta` added to parameters and initial state, under a recorded command.
    fn moved(&self, beta: &DVector<f64>, command: &[Vec<f64>]) -> Trace {
        let mut numbers = self.numbers.clone();
        for ((name, sigma), step) in self.priors.iter().zip(beta.iter()) {
            *numbers.0.entry(name.clone()).or_insert(0.0) += sigma * step;
        }
        let mut experiment = self.experiment.clone();
        experiment.command = Command::Held(command.to_vec());
        let n = coordinates(self.bench, &self.numbers);
        experiment.q.resize(n, 0.0);
        experiment.v.resize(n, 0.0);
        let initial = experiment.q.iter_mut().chain(&mut experiment.v);
        initial.zip(beta.iter().skip(self.priors.len())).for_each(|(x, step)| *x += INITIAL * step);
        self.run(&[], &numbers, &experiment)
    }

    fn difference(&self, a: &Trace, b: &Trace) -> DVector<f64> {
        let minus = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| a - b).collect();
        let difference: Vec<Vec<f64>> = a.measured.iter().zip(&b.measured).map(minus).collect();
        DVector::from_vec(self.whitener.whiten(&difference))
    }

    fn linearise(&mut self) {
        let unknowns = self.priors.len() + 2 * coordinates(self.bench, &self.numbers);
        let command = self.run(&[], &self.numbers, &self.experiment).command;
        let base = self.moved(&DVector::zeros(unknowns), &command);
        let columns: Vec<DVector<f64>> = (0..unknowns)
            .map(|i| {
                let mut beta = DVector::zeros(unknowns);
                let step = if i < self.priors.len() { SHARE } else { 1.0 };
                beta[i] = step;
                self.difference(&self.moved(&beta, &command), &base) / step
            })
            .collect();
        self.jacobian = DMatrix::from_columns(&columns);
        self.base = matches!(self.experiment.command, Command::Held(_)).then_some(base);
        let mut normal = self.jacobian.transpose() * &self.jacobian;
        for i in 0..unknowns {
            // free unknowns get what keeps the factor regular: a millionth of a millionth of what
            // they show
            normal[(i, i)] += if i < self.priors.len() { 1.0 } else { 1e-10 * normal[(i, i)] + 1e-12 };
        }
        self.normal = normal;
    }

    /// Step towards the least of `|r − J δ|² + |prior (β + δ)|²`, damped by a share of the
    /// curvature, of one where that is less.
    fn step(&self, residual: &DVector<f64>, beta: &DVector<f64>, damping: f64) -> DVector<f64> {
        let mut gradient = self.jacobian.transpose() * residual;
        for i in 0..self.priors.len() {
            gradient[i] -= beta[i];
        }
        let mut damped = self.normal.clone();
        (0..beta.len()).for_each(|i| damped[(i, i)] += damping * damped[(i, i)].max(1.0));
        damped.cholesky().map_or_else(|| DVector::zeros(beta.len()), |factor| factor.solve(&gradient))
    }

    fn cost(&self, residual: &DVector<f64>, beta: &DVector<f64>) -> f64 {
        residual.norm_squared() + beta.rows(0, self.priors.len()).norm_squared()
    }

    /// Chord steps, each damped until the cost falls.
    fn descend(&self, with: &Trace, mut best: Point) -> Point {
        for _ in 0..STEPS {
            let (cost, beta, residual) = &best;
            let tried = DAMPINGS.into_iter().find_map(|damping| {
                let beta = beta + self.step(residual, beta, damping);
                let residual = self.difference(with, &self.moved(&beta, &with.command));
                let tried = self.cost(&residual, &beta);
                (tried < *cost).then_some((tried, beta, residual))
            });
            let Some(better) = tried else { break };
            let done = best.0 - better.0 < GAIN * best.0;
            best = better;
            if done {
                break;
            }
        }
        best
    }

    /// The residual of `list`; `curved`: by re-simulation, until a further step gains less than
    /// `GAIN` of the cost.
    #[must_use]
    pub fn realised(&self, list: &[(Hidden, Seat)], curved: bool) -> Realised {
        let with = self.run(list, &self.numbers, &self.experiment);
        let start = DVector::zeros(self.jacobian.ncols());
        let residual = match &self.base {
            Some(base) => self.difference(&with, base),
            None => self.difference(&with, &self.moved(&start, &with.command)),
        };
        let raw = residual.norm_squared();
        let best = if curved {
            self.descend(&with, (raw, start, residual))
        } else {
            let first = self.step(&residual, &start, 0.0);
            let linear = &residual - &self.jacobian * &first;
            (self.cost(&linear, &first), first, linear)
        };
        let (cost, beta, direction) = best;
        let spread = self.normal.clone().cholesky().map(|factor| factor.inverse());
        let sigma = |i: usize| spread.as_ref().map_or(1.0, |spread| spread[(i, i)].max(0.0).sqrt());
        let shift = |(i, (name, _)): (usize, &(String, f64))| (name.clone(), beta[i] / sigma(i).max(1e-12));
        Realised {
            d: cost.max(0.0).sqrt(),
            kappa: if raw > 0.0 { (1.0 - cost / raw).clamp(0.0, 1.0) } else { 0.0 },
            shifts: self.priors.iter().enumerate().map(shift).collect(),
            direction,
        }
    }
}

/// Cosine between two directions.
#[must_use]
pub fn cosine(a: &DVector<f64>, b: &DVector<f64>) -> f64 {
    let size = a.norm() * b.norm();
    if size > 0.0 { a.dot(b) / size } else { 0.0 }
}
