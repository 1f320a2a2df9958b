//! Sizes and colours of the noise: what the data sheets say, and what the data say.

use dynamics::description::{Noise, Plant};
use dynamics::system::System;

use crate::problem::Problem;

/// Noise of a whole problem; shared by all recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseModel {
    /// Standard deviation of each noise input, held between switches [SI unit of the input].
    pub input_sigma: Vec<f64>,
    /// Of each channel, per sample [SI unit of the channel].
    pub sensor_sigma: Vec<f64>,
    /// Pole of each channel's noise per sample; zero: white.
    pub pole: Vec<f64>,
    /// Of each channel's stamps \[s\]: adds the reading's slope times it; zero: none.
    pub jitter_s: Vec<f64>,
}

impl NoiseModel {
    /// As the plant states it. Noise inputs without a number are zero here; a fit gives them a
    /// floor.
    pub fn stated(problem: &Problem, equipped: &Plant, system: &System, noise_inputs: &[usize]) -> Self {
        let actuator = |input: &usize| &equipped.actuators[system.inputs()[*input].actuator];
        let input_sigma = noise_inputs.iter().map(|input| actuator(input).noise.value).collect();
        let sensor_sigma =
            (0..equipped.sensors.len()).map(|channel| sensor_sigma(problem, equipped, channel)).collect();
        Self {
            input_sigma,
            sensor_sigma,
            pole: vec![0.0; equipped.sensors.len()],
            jitter_s: vec![0.0; equipped.sensors.len()],
        }
    }

    /// Every standard deviation `factor` times as large.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        let sizes = scaled.input_sigma.iter_mut().chain(&mut scaled.sensor_sigma).chain(&mut scaled.jitter_s);
        sizes.for_each(|sigma| *sigma *= factor);
        scaled
    }
}

/// White part of coloured noise, as a share of its standard deviation: keeps covariances positive,
/// and is 1e-4 of the variance.
pub(super) const WHITE_SHARE: f64 = 1e-2;

fn sensor_sigma(problem: &Problem, plant: &Plant, channel: usize) -> f64 {
    let sensor = &plant.sensors[channel];
    let interval = || {
        let samples = problem.runs.iter().map(|run| &run.samples[channel]).find(|s| s.time_s.len() > 1);
        samples.map_or(1.0, |s| (s.time_s[s.time_s.len() - 1] - s.time_s[0]) / (s.time_s.len() - 1) as f64)
    };
    let white = match sensor.noise {
        Noise::PerSample(sigma) => sigma.value,
        Noise::Density(density) => density.value / interval().sqrt(),
    };
    let step = sensor.resolution.value;
    (white * white + step * step / 12.0).sqrt()
}
