//! A recorded channel and its simulation at the same times.
//!
//! The recorded values are never interpolated: where the stamps are irregular, a cubic through
//! white noise would colour it and the noise under the difference could no longer be estimated. The
//! simulated channel is read at the recorded stamps.

use super::{COMPARED_SAMPLES_MIN, Verdict};
use channels::{Channel, IRREGULAR_GAP_MEDIANS, interpolate, same_unit};

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

/// Both at common times, or why they cannot be compared: units of different quantities, no common
/// time, fewer than [`COMPARED_SAMPLES_MIN`] common samples.
pub(super) fn pair(real: &Channel, simulated: &Channel) -> Result<Pair, (Verdict, String)> {
    let few = || (Verdict::TooShort, format!("cannot be compared: fewer than {COMPARED_SAMPLES_MIN} common samples"));
    // a number without unit may be anything
    let stated = |c: &Channel| !["", "1", "-"].contains(&c.unit.as_str());
    if stated(real) && stated(simulated) && !same_unit(&real.unit, &simulated.unit) {
        return Err((Verdict::Units, other_quantity(real, simulated)));
    }
    let stretch = real.longest_stretch(IRREGULAR_GAP_MEDIANS);
    let simulation = Simulation::new(simulated);
    let (first, last) = simulation.span_s().ok_or_else(few)?;
    if let Some(apart) = no_common_time(real, (first, last)) {
        return Err((Verdict::NoCommonTime, apart));
    }
    let n = stretch.len();
    if n < COMPARED_SAMPLES_MIN {
        return Err(few());
    }
    let dt_s = (real.time_s[stretch[n - 1]] - real.time_s[stretch[0]]) / (n - 1) as f64;
    let tolerance_s = SAME_STAMP_SHARE * dt_s;
    let common: Vec<usize> = stretch
        .into_iter()
        .filter(|&i| real.time_s[i] >= first - tolerance_s && real.time_s[i] <= last + tolerance_s)
        .collect();
    if common.len() < COMPARED_SAMPLES_MIN {
        return Err(few());
    }
    let time_s: Vec<f64> = common.iter().map(|&i| real.time_s[i]).collect();
    let samples: Vec<Option<f64>> = time_s.iter().map(|t| simulation.sample(*t, tolerance_s)).collect();
    let exact = samples.iter().all(Option::is_some);
    let read =
        samples.into_iter().zip(&time_s).map(|(sample, t)| sample.unwrap_or_else(|| simulation.at(*t))).collect();
    let resampling = told(&time_s, dt_s, exact, real.value.len());
    let real = common.iter().map(|&i| real.value[i]).collect();
    Ok(Pair { time_s, dt_s, real, simulated: read, simulation, resampling })
}

fn other_quantity(real: &Channel, simulated: &Channel) -> String {
    format!(
        "cannot be compared: recorded in {}, simulated in {}, units of different quantities; correct the header that is wrong",
        real.unit, simulated.unit
    )
}

/// The sentence where one ends before the other begins.
fn no_common_time(real: &Channel, (first, last): (f64, f64)) -> Option<String> {
    let stamps = || real.finite().into_iter().map(|i| real.time_s[i]);
    let (begin, end) = stamps().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
    if begin > end || (begin <= last && end >= first) {
        return None;
    }
    let side = if begin > last { "recorded" } else { "simulated" };
    let by = (begin - first).abs();
    Some(format!(
        "cannot be compared: no common time, recorded from {begin} to {end} s, simulated from {first} to {last} s; where both begin with the same \
         event, take {by} s off the {side} stamps"
    ))
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
