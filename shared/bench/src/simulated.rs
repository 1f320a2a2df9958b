//! Truth of the benchmark problems: plants that come with the program, and what is stated of their
//! sensors.

use crate::plants;
use dynamics::description::{Noise, Plant, Quantity, Sensor};
use simulation::Simulator;
use simulation::sensor::random_walk_sample_sigma;

/// The plant of that name that comes with the program.
pub(super) fn built_in(name: &str) -> Plant {
    let text = plants::built_in(name).expect("the benchmarks' plants are built in");
    plant_file::parse(name, text).expect("the plants that come with the program are tested").plant
}

/// The same plant with perfect sensors.
#[must_use]
pub fn without_noise(plant: &Plant) -> Plant {
    let mut perfect = plant.clone();
    for sensor in &mut perfect.sensors {
        sensor.noise = Noise::PerSample(Quantity::known(0.0));
        sensor.resolution = Quantity::known(0.0);
    }
    perfect
}

/// Index of a channel.
///
/// # Panics
/// The plant has no such sensor: it is not the benchmark's.
pub(super) fn channel(plant: &Plant, name: &str) -> usize {
    let found = plant.sensors.iter().position(|sensor| sensor.name == name);
    found.unwrap_or_else(|| panic!("the plant '{}' has no sensor '{name}'", plant.name))
}

/// Standard deviation of one sample of a channel; quantisation adds lsb²/12.
pub(super) fn sample_sigma(plant: &Plant, name: &str) -> f64 {
    let Sensor { noise, resolution, period_s, .. } = &plant.sensors[channel(plant, name)];
    let interval_s = period_s.map_or(plant.simulation.period_s, |period| period.value);
    let white = match noise {
        Noise::PerSample(sigma) => sigma.value,
        Noise::Density(density) => random_walk_sample_sigma(density.value, interval_s),
    };
    (white * white + resolution.value * resolution.value / 12.0).sqrt()
}

/// A number of the plant by its name, SI.
///
/// # Panics
/// The plant has no such number: it is not the benchmark's.
pub(super) fn number(plant: &Plant, name: &str) -> f64 {
    let found = plant.parameters().into_iter().find(|parameter| parameter.name == name);
    found.unwrap_or_else(|| panic!("the plant '{}' has no number '{name}'", plant.name)).value
}

/// Control periods of the whole experiment.
pub(super) fn periods(plant: &Plant) -> usize {
    (plant.simulation.duration_s / plant.simulation.period_s).round() as usize
}

/// Record number `record` of `plant`; noise belongs to (seed, record number, sensor).
///
/// # Panics
/// The plant cannot be simulated: it is not the benchmark's.
pub(super) fn simulator(plant: &Plant, seed: u64, record: usize) -> Simulator {
    let built = Simulator::new(plant, seed, &format!("record{record}.{}", plant.name));
    built.unwrap_or_else(|error| panic!("{}: {error}", plant.name))
}
