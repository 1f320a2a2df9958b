//! Noise of a recording: as stated in the plant file, or different in one respect.

use crate::bench::Bench;
use crate::random::Draw;
use dynamics::description::{Noise, Plant};
use serde::{Deserialize, Serialize};

/// Difference between the true noise and the stated one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NoiseKind {
    Right,
    #[serde(rename = "sensor_louder")]
    SensorNoiseHigher,
    Ar03,
    Ar08,
    ActuatorDouble,
    Quantised,
    StampJitter,
    /// Noise as stated, and beside it 1 to 3 % of the signal that no law of the catalogue makes.
    Remainder,
}

/// Every kind but [`NoiseKind::Right`].
pub const WRONG: [NoiseKind; 6] = [
    NoiseKind::SensorNoiseHigher,
    NoiseKind::Ar03,
    NoiseKind::Ar08,
    NoiseKind::ActuatorDouble,
    NoiseKind::Quantised,
    NoiseKind::StampJitter,
];

/// Standard deviation of one sample of each sensor.
#[must_use]
pub fn sensor_sigma(plant: &Plant, period_s: f64) -> Vec<f64> {
    let sigma = |noise: &Noise| match noise {
        Noise::PerSample(sigma) => sigma.value,
        Noise::Density(density) => density.value / period_s.sqrt(),
    };
    plant.sensors.iter().map(|sensor| sigma(&sensor.noise)).collect()
}

/// Standard deviation of one sample of each input, in the order of the actuators.
#[must_use]
pub fn input_sigma(plant: &Plant) -> Vec<f64> {
    plant.actuators.iter().map(|actuator| actuator.noise.value).collect()
}

/// Lists of noise for one recording.
pub struct Disturbance {
    pub kind: NoiseKind,
    pub inputs: Vec<Vec<f64>>,
    pub sensors: Vec<Vec<f64>>,
    pub resolution: Vec<f64>,
    /// Per sample: error of the time stamp \[s\].
    pub stamps: Vec<f64>,
}

/// Draws the noise of recording `name` of a case.
#[must_use]
pub fn disturbance(bench: &Bench, plant: &Plant, kind: NoiseKind, (seed, case): (u64, u64), name: &str) -> Disturbance {
    let stream = |what: &str| Draw::new(seed, case, &format!("{name}/{what}"));
    let factor = if kind == NoiseKind::SensorNoiseHigher { 1.3 } else { 1.0 };
    let double = if kind == NoiseKind::ActuatorDouble { 2.0 } else { 1.0 };
    let pole: f64 = match kind {
        NoiseKind::Ar03 => 0.3,
        NoiseKind::Ar08 => 0.8,
        _ => 0.0,
    };
    let coloured = |sigma: f64, mut draw: Draw| -> Vec<f64> {
        let mut state = draw.normal();
        let mut next = || {
            let value = sigma * state;
            state = pole * state + (1.0 - pole * pole).sqrt() * draw.normal();
            value
        };
        (0..bench.samples).map(|_| next()).collect()
    };
    let white =
        |sigma: f64, mut draw: Draw| -> Vec<f64> { (0..bench.samples).map(|_| sigma * draw.normal()).collect() };
    let sigmas = sensor_sigma(plant, bench.period_s);
    let sensors = plant.sensors.iter().zip(&sigmas).map(|(s, sigma)| coloured(factor * sigma, stream(&s.name)));
    let inputs = plant.actuators.iter().map(|a| white(double * a.noise.value, stream(&a.name)));
    let coarse = if kind == NoiseKind::Quantised { 4.0 } else { 0.0 };
    let resolution = plant.sensors.iter().zip(&sigmas).map(|(s, sigma)| s.resolution.value.max(coarse * sigma));
    let mut draw = stream("stamps");
    let limit = 0.45 * bench.period_s;
    let mut off = || match kind {
        NoiseKind::StampJitter => (0.05 * bench.period_s * draw.normal()).clamp(-limit, limit),
        _ => 0.0,
    };
    // the first stamp is the beginning of the recording
    let stamps = (0..bench.samples).map(|k| if k == 0 { 0.0 } else { off() }).collect();
    Disturbance { kind, inputs: inputs.collect(), sensors: sensors.collect(), resolution: resolution.collect(), stamps }
}
