//! Free runs: a plant left to itself behind the stretch that gives its initial state.

use super::Predictor;
use crate::dot::dot;
use crate::filter::{Frozen, NoiseModel, Propagator, initial_sigmas};
use crate::fit::EstimationSession;
use crate::problem::Timeline;
use nalgebra::{Cholesky, DMatrix, DVector};
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
    let instance = session.problem.instance(predictor.plant, predictor.theta, run);
    let events = timeline.events.len();
    let first = ((events as f64 * FIRST_SHARE) as usize).clamp(events.min(8), FIRST_EVENTS_MAX.max(8)).min(events);
    let stretch = head(timeline, first);
    let mut propagator = Propagator::new(session.problem, run, &instance, &stretch).ok()?;
    let sigmas = initial_sigmas(&instance, &propagator.system, &session.problem.runs[run].initial, &[]);
    let x0 = initial(&mut propagator, &sigmas, predictor.noise)?;
    let mut propagator = Propagator::new(session.problem, run, &instance, timeline).ok()?;
    propagator.x0 = x0;
    let mut nu = vec![0.0; timeline.value.len()];
    propagator.pass(&Frozen::of_free_run(timeline.events.len()), &[], &mut nu).then_some((nu, first))
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

/// Initial state by Levenberg–Marquardt on the free run of a stretch, from the filter's first
/// estimates.
fn initial(propagator: &mut Propagator<'_>, sigmas: &[f64], noise: &NoiseModel) -> Option<Vec<f64>> {
    let n = sigmas.len();
    let prior = propagator.x0.clone();
    let frozen = Frozen::of_free_run(propagator.timeline.events.len());
    let weight: Vec<f64> = propagator.timeline.channel.iter().map(|c| 1.0 / noise.sensor_sigma[*c]).collect();
    let residual = |propagator: &mut Propagator<'_>, x0: &[f64]| -> Option<Vec<f64>> {
        propagator.x0.copy_from_slice(x0);
        let mut nu = vec![0.0; propagator.timeline.value.len()];
        let ok = propagator.pass(&frozen, &[], &mut nu);
        nu.iter_mut().zip(&weight).for_each(|(nu, w)| *nu *= w);
        (ok && nu.iter().all(|v| v.is_finite())).then_some(nu)
    };
    let mut x = prior.clone();
    let mut r = residual(propagator, &x)?;
    let mut away = vec![0.0; n];
    let cost = |r: &[f64], away: &[f64]| {
        r.iter().map(|v| v * v).sum::<f64>() + away.iter().zip(sigmas).map(|(a, s)| (a / s).powi(2)).sum::<f64>()
    };
    let mut damping = 1e-3;
    for _ in 0..25 {
        let mut columns = Vec::with_capacity(n);
        for i in 0..n {
            let step = 1e-4 * sigmas[i].min(1.0);
            let mut delta = vec![0.0; n];
            delta[i] = step;
            let mut moved = x.clone();
            propagator.system.retract(&x, &delta, &mut moved);
            let shifted = residual(propagator, &moved)?;
            columns.push(shifted.iter().zip(&r).map(|(a, b)| (b - a) / step * sigmas[i]).collect::<Vec<f64>>());
        }
        let before = cost(&r, &away);
        let mut gained = 0.0;
        for _ in 0..6 {
            let matrix = DMatrix::from_fn(n, n, |i, j| {
                let product = dot(&columns[i], &columns[j]) + f64::from(u8::from(i == j));
                if i == j { product * (1.0 + damping) } else { product }
            });
            let right = DVector::from_fn(n, |i, _| dot(&columns[i], &r) - away[i] / sigmas[i]);
            let step = Cholesky::new(matrix)?.solve(&right);
            let delta: Vec<f64> = step.iter().zip(sigmas).map(|(s, sigma)| s * sigma).collect();
            let mut moved = x.clone();
            propagator.system.retract(&x, &delta, &mut moved);
            let mut moved_away = vec![0.0; n];
            propagator.system.difference(&prior, &moved, &mut moved_away);
            if let Some(fresh) = residual(propagator, &moved) {
                let after = cost(&fresh, &moved_away);
                if after < before {
                    gained = before - after;
                    (x, r, away) = (moved, fresh, moved_away);
                    damping = (damping * 0.1).max(1e-9);
                    break;
                }
            }
            damping *= 10.0;
        }
        if gained < 1e-6 * before + 1e-6 {
            break;
        }
    }
    Some(x)
}
