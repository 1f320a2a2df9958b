//! Passes over all runs, side by side on threads; results are folded in the order of their indices.

use super::FitError;
use super::parallel;
use crate::filter::{Linear, NoiseModel, Propagator, Start, equip, initial_sigmas, linearise, linearise_along, step_s};
use crate::problem::{Problem, Run, Timeline};
use crate::work::Work;
use dynamics::description::Plant;
use dynamics::system::System;

mod cost;
mod floors;
mod start;

pub use start::is_mass;

/// A problem with its timelines.
#[derive(Clone)]
pub struct EstimationSession<'p> {
    pub problem: &'p Problem,
    pub timelines: std::sync::Arc<Vec<Timeline>>,
    pub threads: usize,
    /// Noise as stated, inputs without a number at their floor.
    pub noise: NoiseModel,
    /// Names of the noise inputs.
    pub noise_names: Vec<String>,
    /// Prior standard deviation of the level of a disturbance that the plant does not specify;
    /// infinite where it does.
    pub disturbance_sigma: Vec<f64>,
    /// Per run, names and standard deviations of initial states that the recording hardly shows.
    pub hardly_seen: std::sync::Arc<Vec<Vec<(String, f64)>>>,
    /// Of each run, the same of the states of modes and tanks that the plant's effects add.
    pub added: std::sync::Arc<Vec<Vec<(String, f64)>>>,
    /// First sample of each run in the vector of all.
    pub offsets: Vec<usize>,
    pub samples: usize,
    /// Parts that each step of integration is taken in.
    pub parts: usize,
    /// Linear models and sensitivities are taken by residuals along the trajectory, in one pass.
    pub along: bool,
    /// What all sessions of one diagnosis have computed.
    pub work: std::sync::Arc<Work>,
}

/// The start at the prior has a transient where its largest innovation is this many times that of a
/// start at the posterior. Elsewhere it stays: a wide filter follows what the plant cannot explain
/// yet. Chosen: the largest of 10⁴ normal innovations, 3.9 ± 0.3, varies by less.
const INITIAL_TRANSIENT_RATIO: f64 = 2.0;
/// Largest innovation [standard deviations] that needs no other start: of 10⁵ normal ones, 0.06 lie
/// beyond.
const INNOVATION_SIGMA_MAX: f64 = 5.0;
/// `−2 ln p` by which the start at the posterior may be worse, a factor √e of likelihood. Both are
/// the same as far as the plant is linear about them: beyond, the posterior is that of another
/// plant.
const POSTERIOR_LOSS_MAX: f64 = 1.0;

impl<'p> EstimationSession<'p> {
    /// # Errors
    /// The plant cannot be compiled, a channel has no noise.
    pub fn new(problem: &'p Problem, threads: usize) -> Result<Self, FitError> {
        Self::counted(problem, threads, std::sync::Arc::default())
    }

    /// What is computed is added to `work`.
    ///
    /// # Errors
    /// Those of [`EstimationSession::new`].
    pub fn counted(problem: &'p Problem, threads: usize, work: std::sync::Arc<Work>) -> Result<Self, FitError> {
        let equipped = equip(&problem.plant);
        let system = System::new(&equipped).map_err(|error| FitError::Filter(error.to_string()))?;
        let timelines = timelines(problem, &equipped, &system, 1)?;
        let mut offsets = Vec::new();
        let mut samples = 0;
        for timeline in &timelines {
            offsets.push(samples);
            samples += timeline.value.len();
        }
        let command = |i: &usize| system.inputs()[*i].role == dynamics::system::InputRole::Command;
        let inputs: Vec<usize> = (0..system.inputs().len()).filter(command).collect();
        let noise = NoiseModel::stated(problem, &equipped, &system, &inputs);
        let noise_names = inputs.iter().map(|i| system.inputs()[*i].name.clone()).collect();
        for (sensor, sigma) in problem.plant.sensors.iter().zip(&noise.sensor_sigma) {
            if sigma.is_nan() || *sigma <= 0.0 {
                return Err(FitError::Filter(format!("sensor '{}' states no noise", sensor.name)));
            }
        }
        let timelines = std::sync::Arc::new(timelines);
        let disturbance_sigma = vec![f64::INFINITY; noise.input_sigma.len()];
        let threads = threads.max(1);
        let none = std::sync::Arc::new(vec![Vec::new(); problem.runs.len()]);
        let mut session = Self {
            problem,
            timelines,
            threads,
            noise,
            noise_names,
            disturbance_sigma,
            hardly_seen: none.clone(),
            added: none,
            offsets,
            samples,
            parts: 1,
            along: false,
            work,
        };
        session.added = std::sync::Arc::new(start::added(&session, &system, &session.prior()));
        let runs = parallel(problem.runs.len(), threads, |run| start::hardly_seen(&session, run));
        session.hardly_seen = std::sync::Arc::new(runs);
        let unstated: Vec<usize> =
            (0..session.noise.input_sigma.len()).filter(|k| session.noise.input_sigma[*k] <= 0.0).collect();
        session.set_floors()?;
        session.set_disturbance_priors(&unstated);
        Ok(session)
    }

    /// Session of the same recordings with another plant of the same channels and inputs, which its
    /// own commands drive.
    ///
    /// # Errors
    /// The plant's noise inputs are others.
    pub fn like<'q>(other: &EstimationSession<'_>, problem: &'q Problem) -> Result<EstimationSession<'q>, FitError> {
        Self::like_at(other, problem, None)
    }

    /// The same where the start of added modes and tanks is what commands do to the plant at
    /// `theta`, not at its priors.
    ///
    /// # Errors
    /// Those of [`EstimationSession::like`].
    pub fn like_at<'q>(
        other: &EstimationSession<'_>,
        problem: &'q Problem,
        theta: Option<&[f64]>,
    ) -> Result<EstimationSession<'q>, FitError> {
        let equipped = equip(&problem.plant);
        let system = System::new(&equipped).map_err(|error| FitError::Filter(error.to_string()))?;
        let command = |i: &usize| system.inputs()[*i].role == dynamics::system::InputRole::Command;
        let inputs = (0..system.inputs().len()).filter(command).count();
        if inputs != other.noise.input_sigma.len() {
            return Err(FitError::Filter("the plant has other inputs".to_owned()));
        }
        let timelines = match has_commands_of(&problem.plant, &other.problem.plant) {
            true => other.timelines.clone(),
            false => std::sync::Arc::new(commanded(other, timelines(problem, &equipped, &system, other.parts)?)?),
        };
        let mut session = EstimationSession {
            problem,
            timelines,
            threads: other.threads,
            noise: other.noise.clone(),
            noise_names: other.noise_names.clone(),
            disturbance_sigma: other.disturbance_sigma.clone(),
            hardly_seen: other.hardly_seen.clone(),
            added: std::sync::Arc::new(vec![Vec::new(); problem.runs.len()]),
            offsets: other.offsets.clone(),
            samples: other.samples,
            parts: other.parts,
            along: other.along,
            work: other.work.clone(),
        };
        let theta = theta.map_or_else(|| session.prior(), <[f64]>::to_vec);
        session.added = std::sync::Arc::new(start::added(&session, &system, &theta));
        Ok(session)
    }

    /// The same session with each integration step taken in `parts`.
    ///
    /// # Errors
    /// The plant cannot be compiled.
    pub fn in_parts(&self, parts: usize) -> Result<Self, FitError> {
        let equipped = equip(&self.problem.plant);
        let system = System::new(&equipped).map_err(|error| FitError::Filter(error.to_string()))?;
        let own = timelines(self.problem, &equipped, &system, parts)?;
        Ok(Self { timelines: std::sync::Arc::new(own), parts, ..self.clone() })
    }

    /// Session of the same plant with other commands and readings at the same instants.
    ///
    /// # Errors
    /// The plant cannot be compiled, or the samples are not as many.
    pub fn at_other_values<'q>(
        other: &EstimationSession<'_>,
        problem: &'q Problem,
    ) -> Result<EstimationSession<'q>, FitError> {
        let mut session = EstimationSession::like(other, problem)?;
        let equipped = equip(&problem.plant);
        let system = System::new(&equipped).map_err(|error| FitError::Filter(error.to_string()))?;
        let own = timelines(problem, &equipped, &system, 1)?;
        if !own.iter().zip(other.timelines.iter()).all(|(a, b)| a.channel == b.channel && a.stamp_s == b.stamp_s) {
            return Err(FitError::Filter("the samples are others".to_owned()));
        }
        session.timelines = std::sync::Arc::new(own);
        Ok(session)
    }

    /// Priors, with the values of unknowns of the same name from elsewhere.
    pub fn start_from(&self, unknowns: &[crate::problem::Unknown], theta: &[f64]) -> Vec<f64> {
        let known = |name: &str| unknowns.iter().position(|unknown| unknown.name == name).map(|at| theta[at]);
        self.problem.unknowns.iter().map(|unknown| known(&unknown.name).unwrap_or(unknown.prior)).collect()
    }

    /// Mean interval between the samples of `channel` in the run that has most of them \[s\].
    pub fn interval_s(&self, channel: usize) -> f64 {
        let stamps = |run: &'p Run| &run.samples[channel].time_s;
        let longest = self.problem.runs.iter().map(stamps).max_by_key(|stamps| stamps.len());
        longest.filter(|stamps| stamps.len() > 1).map_or(self.timelines[0].period_s, |stamps| {
            (stamps[stamps.len() - 1] - stamps[0]) / (stamps.len() - 1) as f64
        })
    }

    /// Prior means of the unknowns, in their order; where every fit starts.
    pub fn prior(&self) -> Vec<f64> {
        self.problem.unknowns.iter().map(|unknown| unknown.prior).collect()
    }

    /// `−2 ln p` of the levels of unstated disturbances.
    pub fn disturbance_price(&self, noise: &NoiseModel) -> f64 {
        noise.input_sigma.iter().zip(&self.disturbance_sigma).map(|(level, sigma)| (level / sigma).powi(2)).sum()
    }

    /// Linear models of all runs at `theta`.
    pub fn linearise(&self, plant: &Plant, theta: &[f64], noise: &NoiseModel) -> Result<Vec<Linear>, FitError> {
        let runs = parallel(self.timelines.len(), self.threads, |run| {
            let instance = self.problem.instance(plant, theta, run);
            // a staircase has no slope: gains are those of its chord
            let smooth = instance.without_staircases();
            let propagator = || Propagator::new(self.problem, run, &smooth, &self.timelines[run]);
            let mut wide = propagator()?;
            let initial = &self.problem.runs[run].initial;
            let sigmas = initial_sigmas(
                &smooth,
                &wide.system,
                initial,
                &[&self.added[run][..], &self.hardly_seen[run]].concat(),
            );
            let fresh = |propagator: &mut Propagator<'_>, start: &Start| {
                // the slopes at events say nothing of a step that is stiff
                let by = if self.along && propagator.finer() == 1 { linearise_along } else { linearise };
                let found = by(propagator, noise, &sigmas, start);
                self.work.add(propagator.work() + propagator.recursion_work());
                found
            };
            let mut linear = fresh(&mut wide, &Start::prior(&sigmas))?;
            let timeline = &self.timelines[run];
            if linear.peak(timeline) > INNOVATION_SIGMA_MAX
                && let Some(start) = Start::posterior(&linear, timeline)
                && let Ok(narrow) = fresh(&mut propagator()?, &start)
                && linear.peak(timeline) > INITIAL_TRANSIENT_RATIO * narrow.peak(timeline)
                && narrow.objective(timeline) < linear.objective(timeline) + POSTERIOR_LOSS_MAX
            {
                linear = narrow;
            }
            if smooth.effects.len() != instance.effects.len() {
                let mut exact = Propagator::new(self.problem, run, &instance, &self.timelines[run])?;
                let map = exact.map_names(&linear).ok_or_else(|| "the variant lacks a state".to_owned())?;
                exact.begin_as(&linear, &map);
                let arrives = exact.pass(&linear.frozen, &map, &mut linear.nu);
                self.work.add(exact.work());
                if !arrives {
                    return Err("the filtered state runs away".to_owned());
                }
                linear.nu.iter_mut().zip(&linear.pull).for_each(|(nu, pull)| *nu += pull);
            }
            Ok(linear)
        });
        runs.into_iter().collect::<Result<Vec<_>, String>>().map_err(FitError::Filter)
    }

    /// Nothing happens in the runs that are not concerned.
    pub(super) fn silence(&self, column: &mut [f64], concerned: &dyn Fn(usize) -> bool) {
        for run in (0..self.timelines.len()).filter(|run| !concerned(*run)) {
            let offset = self.offsets[run];
            column[offset..offset + self.timelines[run].value.len()].fill(0.0);
        }
    }

    /// Innovations of `plant` with the gains of `linears`; runs that `concerned` denies keep theirs
    /// from `linears`.
    pub fn innovations(
        &self,
        plant: &Plant,
        theta: &[f64],
        linears: &[Linear],
        concerned: &dyn Fn(usize) -> bool,
    ) -> Option<Vec<f64>> {
        let mut nu = vec![0.0; self.samples];
        for (run, linear) in linears.iter().enumerate() {
            let part = &mut nu[self.offsets[run]..self.offsets[run] + linear.nu.len()];
            if !concerned(run) {
                part.copy_from_slice(&linear.nu);
                continue;
            }
            let instance = self.problem.instance(plant, theta, run);
            let mut propagator = Propagator::new(self.problem, run, &instance, &self.timelines[run]).ok()?;
            let map = places(&propagator, linear)?;
            propagator.begin_as(linear, &map);
            let arrives = propagator.pass(&linear.frozen, &map, part);
            self.work.add(propagator.work());
            if !arrives {
                return None;
            }
            part.iter_mut().zip(&linear.pull).for_each(|(nu, pull)| *nu += pull);
        }
        Some(nu)
    }
}

/// Events of every run.
fn timelines(problem: &Problem, equipped: &Plant, system: &System, parts: usize) -> Result<Vec<Timeline>, FitError> {
    let lags: Vec<f64> = problem.plant.sensors.iter().map(|sensor| lag_s(&problem.plant, sensor)).collect();
    let initial = |run: &Run| system.initial_state(&strip(&problem.plant, run), &|_| None);
    let timeline = |run: &Run| {
        let x0 = initial(run).map_err(|error| FitError::Filter(error.to_string()))?;
        Ok(Timeline::new(equipped, system, run, &lags, (step_s(system, &x0), parts)))
    };
    problem.runs.iter().map(timeline).collect()
}

/// `own`, where it has the samples of `other` in their order: a delay of another plant that shifts
/// them by whole intervals makes others of them.
fn commanded(other: &EstimationSession<'_>, own: Vec<Timeline>) -> Result<Vec<Timeline>, FitError> {
    let all = own.iter().zip(other.timelines.iter());
    let is_same = |(a, b): (&Timeline, &Timeline)| a.channel == b.channel && a.stamp_s == b.stamp_s;
    if all.clone().all(is_same) { Ok(own) } else { Err(FitError::Filter("the samples are others".to_owned())) }
}

/// The commands that `plant` states are those of `other`. Rows of inputs hold them: a number of a
/// command that is no unknown acts by its row alone.
fn has_commands_of(plant: &Plant, other: &Plant) -> bool {
    plant.actuators.iter().map(|own| &own.command).eq(other.actuators.iter().map(|own| &own.command))
}

/// Places of the frozen filter's z in that of `propagator`.
fn places(propagator: &Propagator<'_>, linear: &Linear) -> Option<Vec<usize>> {
    if propagator.layout == linear.layout {
        Some((0..linear.layout.len()).collect())
    } else {
        propagator.map_names(linear)
    }
}

fn strip(plant: &Plant, run: &Run) -> dynamics::description::Initial {
    let mut initial = run.initial.clone();
    initial.values.retain(|value| {
        !plant.actuators.iter().any(|a| match &a.kind {
            dynamics::description::ActuatorKind::PrescribedJoint { joint, .. } => {
                value.coordinate == format!("joint:{joint}")
            }
            _ => false,
        })
    });
    initial
}

fn lag_s(plant: &Plant, sensor: &dynamics::description::Sensor) -> f64 {
    let source = sensor.source.as_ref().and_then(|name| plant.sources.iter().find(|source| source.name == *name));
    sensor.delay_s.value + source.map_or(0.0, |source| source.clock_offset_s.value)
}
