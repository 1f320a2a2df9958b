//! Recordings of the deployed plants for tests: effects added, noise changed, numbers moved off
//! their priors.

use crate::noise::Noise as Draw;
use crate::problem::Problem;
use channels::Recording;
use dynamics::description::{Noise, Plant};
use simulation::record;

pub fn plant(name: &str) -> Plant {
    let text = match name {
        "pendulum" => include_str!("../../../deploy/plants/pendulum.toml"),
        "oscillator" => include_str!("../../../deploy/plants/oscillator.toml"),
        "drive_rig" => include_str!("../../../deploy/plants/drive_rig.toml"),
        "double_pendulum" => include_str!("../../../deploy/plants/double_pendulum.toml"),
        "tank_planar" => include_str!("../../../deploy/plants/tank_planar.toml"),
        "hub_appendage" => include_str!("../../../deploy/plants/hub_appendage.toml"),
        "study_case" => include_str!("../../../deploy/plants/study_case.toml"),
        "damper_rig" => include_str!("../../../deploy/plants/damper_rig.toml"),
        "fuel" => include_str!("../../../tests/data/craft/fuel.toml"),
        "ball_drop" => include_str!("../../../deploy/plants/rigs/ball_drop.toml"),
        "six_joint_arm" => include_str!("../../../deploy/plants/rigs/six_joint_arm.toml"),
        other => panic!("no plant {other}"),
    };
    plant_file::parse(name, text).unwrap().plant
}

pub fn recording(plant: &Plant, seed: u64, duration_s: f64) -> Recording {
    let simulated = record(plant, seed, duration_s, &mut |_| {}).unwrap();
    Recording { name: format!("seed_{seed}"), ..simulated }
}

/// Standard deviation of one sample of each sensor.
pub fn sample_sigma(plant: &Plant, name: &str) -> Option<f64> {
    let sensor = plant.sensor(name)?;
    let period = sensor.period_s.map_or(plant.simulation.period_s, |p| p.value);
    Some(match sensor.noise {
        Noise::PerSample(q) => q.value,
        Noise::Density(q) => q.value / period.sqrt(),
    })
}

/// The same recording with AR(1) noise of the stated size in the place of white noise.
pub fn coloured(plant: &Plant, seed: u64, duration_s: f64, pole: f64) -> Recording {
    let mut quiet = plant.clone();
    quiet.sensors.iter_mut().for_each(|sensor| sensor.noise = Noise::default());
    let mut recording = recording(&quiet, seed, duration_s);
    for (k, channel) in recording.channels.iter_mut().enumerate() {
        let Some(sigma) = sample_sigma(plant, &channel.name) else { continue };
        let mut draw = Draw::new(1000 * seed + k as u64);
        let mut v = draw.normal();
        for y in &mut channel.value {
            *y += sigma * v;
            v = pole * v + (1.0 - pole * pole).sqrt() * draw.normal();
        }
    }
    recording
}

/// Numbers with priors drawn from them (at most two standard deviations off, signs kept).
pub fn off_priors(plant: &Plant, seed: u64) -> Plant {
    let mut moved = plant.clone();
    let mut draw = Draw::new(77 + seed);
    for parameter in plant.parameters() {
        let Some(sigma) = parameter.sigma else { continue };
        if parameter.name.starts_with("initial") {
            continue;
        }
        let value = parameter.value + sigma * draw.normal().clamp(-2.0, 2.0);
        let value = if parameter.value > 0.0 { value.max(0.3 * parameter.value) } else { value };
        moved.set_parameter(&parameter.name, value).unwrap();
    }
    moved
}

pub fn with_effect(plant: &Plant, kind: &str, site: &str, values: &[(&str, f64)]) -> Plant {
    let mut with = plant.clone();
    with.add_effect(kind, &site.parse().unwrap(), values).unwrap();
    // most effects are not linear
    with.simulation.integrator = dynamics::description::Integrator::RungeKutta4;
    with
}

pub fn problem(plant: &Plant, recording: Recording) -> Problem {
    Problem::new(plant, &[recording], &[]).unwrap()
}
