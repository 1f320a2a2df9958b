//! A recorded channel and its simulation at the same times.
//!
//! The recorded values are never interpolated: where the stamps are irregular, a cubic through white noise would colour it and the noise under the
//! difference could no longer be told. The simulated channel is read at the recorded stamps.

use super::SAMPLES_MIN;
use crate::series::{Channel, IRREGULAR_GAP_MEDIANS, interpolate};

/// Share of a step within which two stamps are the same.
const SAME_STAMP_SHARE: f64 = 1e-6;
/// Stamps even to this share of a step count as equal steps.
const EVEN_SHARE: f64 = 1e-3;

/// Real and simulated at common times.
pub(super) struct Pair {
    pub(super) time_s: Vec<f64>,
    /// Mean step.
    pub(super) dt_s: f64,
    pub(super) real: Vec<f64>,
    pub(super) simulated: Vec<f64>,
    pub(super) simulation: Simulation,
    pub(super) resampling: String,
}

/// The simulated channel with stamps that increase.
pub(super) struct Simulation {
    time_s: Vec<f64>,
    value: Vec<f64>,
}

impl Simulation {
    fn new(channel: &Channel) -> Self {
        let mut own = Self { time_s: Vec::new(), value: Vec::new() };
        for i in channel.finite() {
            if own.time_s.last().is_none_or(|t| channel.time_s[i] > *t) {
                own.time_s.push(channel.time_s[i]);
                own.value.push(channel.value[i]);
            }
        }
        own
    }

    fn span_s(&self) -> Option<(f64, f64)> {
        Some((*self.time_s.first()?, *self.time_s.last()?))
    }

    /// Value at `t_s`, held outside.
    pub(super) fn at(&self, t_s: f64) -> f64 {
        interpolate(&self.time_s, &self.value, t_s)
    }

    /// The sample at `t_s`, where there is one.
    fn sample(&self, t_s: f64, tolerance_s: f64) -> Option<f64> {
        let near = self.time_s.partition_point(|s| *s < t_s - tolerance_s).min(self.time_s.len() - 1);
        ((self.time_s[near] - t_s).abs() <= tolerance_s).then(|| self.value[near])
    }
}

/// `None` below [`SAMPLES_MIN`] common samples.
pub(super) fn pair(real: &Channel, simulated: &Channel) -> Option<Pair> {
    let stretch = real.longest_stretch(IRREGULAR_GAP_MEDIANS);
    let simulation = Simulation::new(simulated);
    let (first, last) = simulation.span_s()?;
    let n = stretch.len();
    if n < SAMPLES_MIN {
        return None;
    }
    let dt_s = (real.time_s[stretch[n - 1]] - real.time_s[stretch[0]]) / (n - 1) as f64;
    let tolerance_s = SAME_STAMP_SHARE * dt_s;
    let common: Vec<usize> = stretch
        .into_iter()
        .filter(|&i| real.time_s[i] >= first - tolerance_s && real.time_s[i] <= last + tolerance_s)
        .collect();
    if common.len() < SAMPLES_MIN {
        return None;
    }
    let time_s: Vec<f64> = common.iter().map(|&i| real.time_s[i]).collect();
    let samples: Vec<Option<f64>> = time_s.iter().map(|t| simulation.sample(*t, tolerance_s)).collect();
    let exact = samples.iter().all(Option::is_some);
    let read =
        samples.into_iter().zip(&time_s).map(|(sample, t)| sample.unwrap_or_else(|| simulation.at(*t))).collect();
    let resampling = told(&time_s, dt_s, exact, real.value.len());
    let real = common.iter().map(|&i| real.value[i]).collect();
    Some(Pair { time_s, dt_s, real, simulated: read, simulation, resampling })
}

/// How the stamps were brought together, and how much was used.
fn told(time_s: &[f64], dt_s: f64, exact: bool, recorded: usize) -> String {
    let uneven = |(i, t): (usize, &f64)| (t - time_s[0] - i as f64 * dt_s).abs() > EVEN_SHARE * dt_s;
    let mut notes = vec![if time_s.len() < recorded {
        format!(
            "{} of {recorded} recorded samples used: the longest stretch that both hold without a gap of {IRREGULAR_GAP_MEDIANS} median intervals",
            time_s.len()
        )
    } else {
        format!("all {recorded} recorded samples used")
    }];
    if time_s.iter().enumerate().any(uneven) {
        notes.push("real: uneven stamps, each used as it is".into());
    }
    notes.push(if exact {
        "simulated: same stamps, untouched".into()
    } else {
        "simulated: cubic interpolation to the recorded stamps".into()
    });
    notes.join("; ")
}
