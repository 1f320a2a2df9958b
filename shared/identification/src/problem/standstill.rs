//! Channels that stand still although noise is stated on them.
//!
//! With white noise of σ between quantisation steps of q all of n readings are equal with a
//! probability of at most `P(|N(0, σ)| < q/2)^(n−1)`.

use dynamics::description::{Noise, Plant, Sensor};

/// A reading that never changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standstill {
    pub reading: f64,
    pub samples: usize,
    /// Noise that the plant states on each sample [unit of the channel].
    pub sigma: f64,
    /// Chance of it at most.
    pub p: f64,
}

/// The constant reading over all `stretches` of one channel, each its times and readings; `None`
/// where a reading changes or no noise is stated.
pub fn standstill(plant: &Plant, sensor: &Sensor, stretches: &[(&[f64], &[f64])]) -> Option<Standstill> {
    let period_s = period_s(plant, sensor);
    let sigma = sample_sigma(plant, sensor);
    let mut readings = stretches.iter().flat_map(|(_, values)| *values);
    let reading = *readings.next()?;
    if sigma.is_nan() || sigma <= 0.0 || readings.any(|value| *value != reading) {
        return None;
    }
    // a sensor slower than the record repeats its last reading
    let renewed = |times: &[f64]| match times {
        [first, .., last] => ((times.len() - 1) as f64).min((last - first) / period_s * (1.0 + 1e-9)),
        _ => 0.0,
    };
    let changes: f64 = stretches.iter().map(|(times, _)| libm::floor(renewed(times))).sum();
    let alike = libm::erf(0.5 * sensor.resolution.value / sigma / 2.0_f64.sqrt());
    let samples = stretches.iter().map(|(_, values)| values.len()).sum();
    Some(Standstill { reading, samples, sigma, p: libm::pow(alike, changes) })
}

/// Standard deviation of the noise that the plant states on each sample of `sensor`
/// [unit of the channel].
pub fn sample_sigma(plant: &Plant, sensor: &Sensor) -> f64 {
    match sensor.noise {
        Noise::PerSample(q) => q.value,
        Noise::Density(q) => q.value / period_s(plant, sensor).sqrt(),
    }
}

/// Step of the plant's record of one sensor \[s\].
pub fn period_s(plant: &Plant, sensor: &Sensor) -> f64 {
    sensor.period_s.map_or(plant.simulation.period_s, |period| period.value)
}
