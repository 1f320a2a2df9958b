//! Free runs: a plant left to itself behind the stretch that gives its initial state.

use super::Predictor;
use crate::dot::dot;
use crate::filter::{Frozen, NoiseModel, Propagator, initial_sigmas};
use crate::fit::EstimationSession;
use crate::problem::Timeline;
use dynamics::system::System;
use estimation::levenberg_marquardt::{Quadratic, Settings, minimise};
use nalgebra::{DMatrix, DVector, Dyn};
use serde::Serialize;

/// Share of a run that gives its initial state, and its most instants.
const FIRST_SHARE: f64 = 0.15;
const FIRST_EVENTS_MAX: usize = 2000;
/// One channel of a free run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ChannelFit {
    pub name: String,
    pub rms: f64,
    pub fit_percent: f64,
}

/// Free run of every channel over all runs, initial states from the first stretches.
pub fn free_run(session: &EstimationSession<'_>, predictor: Predictor<'_>) -> Vec<ChannelFit> {
    let channels = session.problem.plant.sensors.len();
    let mut sums = vec![[0.0f64; 4]; channels];
    for run in 0..session.timelines.len() {
        let timeline = &session.timelines[run];
        let Some((residual, first)) = free_residual(session, predictor, run) else {
            for sum in &mut sums {
                sum[0] = f64::NAN;
            }
            continue;
        };
        for event in timeline.events.iter().skip(first) {
            for sample in event.first..event.first + event.count {
                let sum = &mut sums[timeline.channel[sample]];
                let y = timeline.value[sample];
                sum[0] += residual[sample] * residual[sample];
                sum[1] += 1.0;
                sum[2] += y;
                sum[3] += y * y;
            }
        }
    }
    let sensors = &session.problem.plant.sensors;
    (sensors.iter().zip(&sums))
        .filter(|(_, sum)| sum[1] > 0.0)
        .map(|(sensor, sum)| {
            let spread = (sum[3] - sum[2] * sum[2] / sum[1]).max(0.0);
            let fit = if spread > 0.0 { 100.0 * (1.0 - (sum[0] / spread).sqrt()) } else { f64::NEG_INFINITY };
            ChannelFit { name: sensor.name.clone(), rms: (sum[0] / sum[1]).sqrt(), fit_percent: fit }
        })
        .collect()
}

/// Residuals of the free run and the first event behind the stretch that gave the initial state.
pub fn free_residual(
    session: &EstimationSession<'_>,
    predictor: Predictor<'_>,
    run: usize,
) -> Option<(Vec<f64>, usize)> {
    let timeline = &session.timelines[run];
    let (_, x0) = initial_state(session, predictor, run)?;
    let instance = session.problem.instance(predictor.plant, predictor.theta, run);
    let mut propagator = Propagator::new(session.problem, run, &instance, timeline).ok()?;
    propagator.x0 = x0;
    let mut nu = vec![0.0; timeline.value.len()];
    propagator.pass(&Frozen::of_free_run(timeline.events.len()), &[], &mut nu).then_some((nu, first_stretch(timeline)))
}

/// Events of the stretch that gives the initial state.
fn first_stretch(timeline: &Timeline) -> usize {
    let events = timeline.events.len();
    ((events as f64 * FIRST_SHARE) as usize).clamp(events.min(8), FIRST_EVENTS_MAX.max(8)).min(events)
}

/// The state that a run begins in, as the free run of its first stretch has it, and the system
/// whose state it is.
pub(super) fn initial_state(
    session: &EstimationSession<'_>,
    predictor: Predictor<'_>,
    run: usize,
) -> Option<(System, Vec<f64>)> {
    let timeline = &session.timelines[run];
    let instance = session.problem.instance(predictor.plant, predictor.theta, run);
    let stretch = head(timeline, first_stretch(timeline));
    let mut propagator = Propagator::new(session.problem, run, &instance, &stretch).ok()?;
    let sigmas = initial_sigmas(&instance, &propagator.system, &session.problem.runs[run].initial, &[]);
    let x0 = initial(&mut propagator, &sigmas, predictor.noise)?;
    Some((propagator.system, x0))
}

fn head(timeline: &Timeline, events: usize) -> Timeline {
    let mut head = timeline.clone();
    head.events.truncate(events);
    let samples = head.events.last().map_or(0, |event| event.first + event.count);
    head.channel.truncate(samples);
    head.value.truncate(samples);
    head.stamp_s.truncate(samples);
    head.interval_s.truncate(samples);
    head
}

/// Of the fit of an initial state: a decrease of χ² by a millionth of it, or of a millionth of a
/// standard deviation squared, changes no prediction.
const START: Settings =
    Settings { iterations_max: 40, step_sigmas: 1e-3, gain_share: 1e-6, rounding: (0.0, 0.0), damping_max: 1e3 };

/// A state, how far it is from the prior's mean [prior standard deviations], and its residuals.
struct Started {
    x: Vec<f64>,
    away: DVector<f64>,
    residual: Vec<f64>,
}

/// Initial state by Levenberg–Marquardt on the free run of a stretch, from the filter's first
/// estimates; its unknowns are changes of state in prior standard deviations.
fn initial(propagator: &mut Propagator<'_>, sigmas: &[f64], noise: &NoiseModel) -> Option<Vec<f64>> {
    let weight: Vec<f64> = propagator.timeline.channel.iter().map(|c| 1.0 / noise.sensor_sigma[*c]).collect();
    let mut free =
        FreeRun { frozen: Frozen::of_free_run(propagator.timeline.events.len()), weight, sigmas, propagator };
    let prior = free.propagator.x0.clone();
    let start = Started { residual: free.residual(&prior)?, away: DVector::zeros(sigmas.len()), x: prior.clone() };
    let quadratic = free.quadratic(&start)?;
    let found = minimise((start, quadratic), &START, |from, step, below| {
        let there = free.started(&prior, free.moved(&from.x, step))?;
        if there.chi_square() >= below {
            return None;
        }
        let quadratic = free.quadratic(&there)?;
        Some((there, quadratic))
    });
    Some(found.point.x)
}

impl Started {
    fn chi_square(&self) -> f64 {
        dot(&self.residual, &self.residual) + self.away.norm_squared()
    }
}

/// A stretch as it runs from any initial state.
struct FreeRun<'p, 't> {
    propagator: &'p mut Propagator<'t>,
    sigmas: &'p [f64],
    frozen: Frozen,
    /// Of every sample, over its standard deviation.
    weight: Vec<f64>,
}

impl FreeRun<'_, '_> {
    /// Measured less predicted, over the standard deviations; `None` where the run diverges.
    fn residual(&mut self, x0: &[f64]) -> Option<Vec<f64>> {
        self.propagator.x0.copy_from_slice(x0);
        let mut nu = vec![0.0; self.weight.len()];
        let ok = self.propagator.pass(&self.frozen, &[], &mut nu);
        nu.iter_mut().zip(&self.weight).for_each(|(nu, w)| *nu *= w);
        (ok && nu.iter().all(|v| v.is_finite())).then_some(nu)
    }

    fn moved(&self, x: &[f64], step: &DVector<f64>) -> Vec<f64> {
        let delta: Vec<f64> = step.iter().zip(self.sigmas).map(|(s, sigma)| s * sigma).collect();
        let mut moved = x.to_vec();
        self.propagator.system.retract(x, &delta, &mut moved);
        moved
    }

    fn started(&mut self, prior: &[f64], x: Vec<f64>) -> Option<Started> {
        let mut away = vec![0.0; self.sigmas.len()];
        self.propagator.system.difference(prior, &x, &mut away);
        let away = DVector::from_fn(away.len(), |i, _| away[i] / self.sigmas[i]);
        Some(Started { residual: self.residual(&x)?, away, x })
    }

    /// By differences of a ten-thousandth of a standard deviation, of a unit where that is less.
    fn quadratic(&mut self, at: &Started) -> Option<Quadratic<Dyn>> {
        let n = self.sigmas.len();
        let mut columns = Vec::with_capacity(n);
        for i in 0..n {
            let step = 1e-4 * (1.0 / self.sigmas[i]).min(1.0);
            let mut delta = DVector::zeros(n);
            delta[i] = step;
            let shifted = self.residual(&self.moved(&at.x, &delta))?;
            columns.push(shifted.iter().zip(&at.residual).map(|(a, b)| (b - a) / step).collect::<Vec<f64>>());
        }
        Some(Quadratic {
            chi_square: at.chi_square(),
            information: DMatrix::from_fn(n, n, |i, j| dot(&columns[i], &columns[j]) + f64::from(u8::from(i == j))),
            gradient: DVector::from_fn(n, |i, _| dot(&columns[i], &at.residual) - at.away[i]),
        })
    }
}
