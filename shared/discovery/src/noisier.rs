//! Plants of tests whose sensors are noisier than stated.

use dynamics::description::{Noise, Plant};

/// Sensor noise times `factor`.
pub fn of_higher_variance(plant: &Plant, factor: f64) -> Plant {
    let mut noisy = plant.clone();
    for sensor in &mut noisy.sensors {
        match &mut sensor.noise {
            Noise::PerSample(q) | Noise::Density(q) => q.value *= factor,
        }
    }
    noisy
}
