//! The Kalman filters of BP2 from a start that is wrong by 45 %: unscented, one pass and two, and
//! extended.
//!
//! The extended filter is a baseline in `[r, ṙ, ln ms, ln ks, ln cs]`, sensitivities by central
//! differences. It shows what the linearisation at a poor start costs, and that its covariance does
//! not say so.

use super::PARAMETERS;
use crate::campaign::Answer;
use crate::slosh_filter::{FilteredSlosh, SLOSH_STATES, SloshFilter, SloshPrior, filter_twice};
use nalgebra::{Matrix3, SMatrix, SVector, Vector1, Vector2, Vector3};
use physics::slosh::{SloshParameters, SloshPropagator, SloshState};
use physics::slosh_arc::SloshSample;

/// Of the truth: where the filters begin.
const START: f64 = 0.55;

/// The sums of so many samples are filtered: the information is in the sums.
const SAMPLES_SUMMED: usize = 5;

/// Twelve decades about one: beyond, a divergent filter's numbers say nothing.
const LOG_MAX: f64 = 27.0;

/// Prior of the filters before the first sample.
pub(super) fn prior(truth: &Vector3<f64>) -> SloshPrior {
    let start = truth * START;
    SloshPrior {
        parameters: SloshParameters { slosh_mass_kg: start[0], stiffness_n_m: start[1], damping_n_s_m: start[2] },
        log_sigma: Vector3::new(0.6, 0.6, 1.0),
        state_sigma: Vector2::new(1e-3, 1e-4),
        bias_sigma_m_s2: 0.0,
    }
}

/// What the filters are given.
pub(super) fn summed(record: &[SloshSample]) -> Vec<SloshSample> {
    summed_by(record, SAMPLES_SUMMED)
}

/// Sums of neighbouring samples, as samples of longer intervals.
pub(super) fn summed_by(record: &[SloshSample], count: usize) -> Vec<SloshSample> {
    let sum = |group: &[SloshSample]| {
        let interval_s: f64 = group.iter().map(|sample| sample.interval_s).sum();
        let mean = |of: fn(&SloshSample) -> f64| {
            group.iter().map(|sample| of(sample) * sample.interval_s).sum::<f64>() / interval_s
        };
        SloshSample {
            interval_s,
            force_n: mean(|sample| sample.force_n),
            acceleration_m_s2: mean(|sample| sample.acceleration_m_s2),
            sigma_m_s2: group[0].sigma_m_s2 / (group.len() as f64).sqrt(),
        }
    };
    record.chunks(count).map(sum).collect()
}

pub(super) fn one_pass(record: &[SloshSample], base_mass_kg: f64, prior: &SloshPrior) -> Option<FilteredSlosh> {
    let mut filter = SloshFilter::<SLOSH_STATES>::new(base_mass_kg, prior);
    record.iter().try_for_each(|sample| filter.step(sample).map(|_| ())).ok()?;
    Some(filter.estimate())
}

/// Filters of the bank at work, mean over the samples of a record.
pub(super) fn filters_at_work(record: &[SloshSample], base_mass_kg: f64, prior: &SloshPrior) -> f64 {
    let mut filter = SloshFilter::<SLOSH_STATES>::new(base_mass_kg, prior);
    let count = |sample: &SloshSample| {
        let at_work = filter.filters();
        filter.step(sample).map_or(0, |_| at_work)
    };
    record.iter().map(count).sum::<usize>() as f64 / record.len() as f64
}

/// The second of two passes.
pub(super) fn two_passes(record: &[SloshSample], base_mass_kg: f64, prior: &SloshPrior) -> Option<FilteredSlosh> {
    filter_twice::<SLOSH_STATES>(record, base_mass_kg, prior).ok().map(|[_, second]| second)
}

/// Extended Kalman filter over the same model; nothing when it leaves the numbers.
pub(super) fn extended(record: &[SloshSample], base_mass_kg: f64, prior: &SloshPrior) -> Option<FilteredSlosh> {
    let SloshParameters { slosh_mass_kg: m, stiffness_n_m: k, damping_n_s_m: c } = prior.parameters;
    let mut mean = SVector::<f64, SLOSH_STATES>::from([0.0, 0.0, m.ln(), k.ln(), c.ln()]);
    let (s, l) = (prior.state_sigma, prior.log_sigma);
    let sigma = SVector::<f64, SLOSH_STATES>::from([s[0], s[1], l[0], l[1], l[2]]);
    let mut covariance = SMatrix::<f64, SLOSH_STATES, SLOSH_STATES>::from_diagonal(&sigma.component_mul(&sigma));
    for sample in record {
        let observe = |x: &SVector<f64, SLOSH_STATES>| Vector1::new(moved(base_mass_kg, sample, x).1);
        let propagate = |x: &SVector<f64, SLOSH_STATES>| moved(base_mass_kg, sample, x).0;
        let (h, noise) = (slope(&mean, observe), sample.sigma_m_s2 * sample.sigma_m_s2);
        let cross = covariance * h.transpose();
        let gain = cross / ((h * cross)[0] + noise);
        mean += gain * (sample.acceleration_m_s2 - observe(&mean)[0]);
        let kept = SMatrix::<f64, SLOSH_STATES, SLOSH_STATES>::identity() - gain * h;
        covariance = kept * covariance * kept.transpose() + gain * gain.transpose() * noise;
        let f = slope(&mean, propagate);
        mean = propagate(&mean);
        covariance = f * covariance * f.transpose();
        if !mean.iter().all(|value| value.is_finite() && value.abs() < 1e6) {
            return None;
        }
    }
    let value = Vector3::new(mean[2], mean[3], mean[4]).map(f64::exp);
    let scale = Matrix3::from_diagonal(&value);
    let logarithms: Matrix3<f64> = covariance.fixed_view::<3, 3>(2, 2).into();
    Some(FilteredSlosh {
        parameters: SloshParameters { slosh_mass_kg: value[0], stiffness_n_m: value[1], damping_n_s_m: value[2] },
        covariance: scale * logarithms * scale,
        state: SloshState { displacement_m: mean[0], velocity_m_s: mean[1] },
    })
}

/// The state after the interval of a sample, and the mean acceleration over it.
fn moved(
    base_mass_kg: f64,
    sample: &SloshSample,
    state: &SVector<f64, SLOSH_STATES>,
) -> (SVector<f64, SLOSH_STATES>, f64) {
    let [slosh_mass_kg, stiffness_n_m, damping_n_s_m] = [2, 3, 4].map(|i| state[i].clamp(-LOG_MAX, LOG_MAX).exp());
    let tank = SloshParameters { slosh_mass_kg, stiffness_n_m, damping_n_s_m };
    let start = SloshState { displacement_m: state[0], velocity_m_s: state[1] };
    let mut motion = SloshPropagator::new(tank, base_mass_kg, start);
    let acceleration = motion.step(sample.interval_s, sample.force_n);
    let mut next = *state;
    (next[0], next[1]) = (motion.state().displacement_m, motion.state().velocity_m_s);
    (next, acceleration)
}

/// Central differences; the states are of order one or enter linearly.
fn slope<const Y: usize>(
    at: &SVector<f64, SLOSH_STATES>,
    map: impl Fn(&SVector<f64, SLOSH_STATES>) -> SVector<f64, Y>,
) -> SMatrix<f64, Y, SLOSH_STATES> {
    const STEP: f64 = 1e-5;
    let mut slope = SMatrix::<f64, Y, SLOSH_STATES>::zeros();
    for i in 0..SLOSH_STATES {
        let (mut plus, mut minus) = (*at, *at);
        plus[i] += STEP;
        minus[i] -= STEP;
        slope.set_column(i, &((map(&plus) - map(&minus)) / (2.0 * STEP)));
    }
    slope
}

pub(super) fn answer(found: Option<FilteredSlosh>, truth: &Vector3<f64>) -> Answer {
    let Some(found) = found else { return Answer::none(PARAMETERS) };
    super::answer(&found.parameters, &found.covariance, truth)
}
