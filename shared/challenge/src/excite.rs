//! Experiments of a bench: seeded commands, references and releases.

use crate::bench::Bench;
use crate::random::Draw;
use crate::simulate::{Command, Loop};
use core::f64::consts::{PI, TAU};
use dynamics::description::Plant;

/// Initial state and command of an experiment, and the plant file that states them.
pub struct Flight {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub command: Command,
    /// With the stated initial state and the control loop of the experiment.
    pub plant: Plant,
}

/// A seeded experiment on `bench` with the nominal `plant`.
///
/// # Panics
/// The bench has no experiment.
#[must_use]
pub fn flight(bench: &Bench, plant: &Plant, draw: &mut Draw) -> Flight {
    let n = bench.samples;
    let still = |command: Vec<Vec<f64>>| Flight {
        q: Vec::new(),
        v: Vec::new(),
        command: Command::Held(command),
        plant: plant.clone(),
    };
    if let Some(gains) = bench.closed {
        let sines = reference(bench.plant, draw);
        let sensor = |name: &str| plant.sensors.iter().position(|sensor| sensor.name == name);
        let closed = Loop {
            kp: gains.kp,
            kd: gains.kd,
            position_sensor: sensor(gains.position_sensor).expect("the bench names a sensor of its plant"),
            rate_sensor: gains.rate_sensor.and_then(sensor),
            sines: sines.clone(),
        };
        let known = crate::bench::with_loop(plant, gains, &sines);
        return Flight { command: Command::Loop(closed), plant: known, ..still(Vec::new()) };
    }
    match bench.plant {
        "pendulum" => release(plant, &[("joint:pivot", [20.0, 60.0])], draw),
        "double_pendulum" => release(plant, &[("joint:pivot_1", [15.0, 45.0]), ("joint:pivot_2", [10.0, 35.0])], draw),
        "drive_rig" => {
            let mut u = multisine(n, bench.period_s, [0.1, 4.0], 12, 0.4 * draw.uniform(0.6, 1.3), draw);
            let (size, hz) = (0.3 * draw.uniform(0.5, 1.5), draw.uniform(0.15, 0.5));
            add_square(&mut u, bench.period_s, size, hz, draw.uniform(0.0, 1.0));
            still(vec![u])
        }
        "oscillator" => still(vec![multisine(n, bench.period_s, [1.0, 18.0], 24, 3.0 * draw.uniform(0.6, 1.3), draw)]),
        "tank_planar" => {
            let burst = |size: f64, begin: f64, draw: &mut Draw| {
                let mut u = vec![0.0; n];
                add_square(&mut u, bench.period_s, size * draw.uniform(0.7, 1.4), draw.uniform(0.009, 0.015), 0.0);
                let (first, last) = ((begin * n as f64) as usize, ((begin + 0.35) * n as f64) as usize);
                u.iter_mut().enumerate().filter(|(k, _)| *k < first || *k >= last).for_each(|(_, u)| *u = 0.0);
                u
            };
            let begins = [draw.uniform(0.0, 0.5), draw.uniform(0.0, 0.3), draw.uniform(0.1, 0.6)];
            still(vec![burst(0.5, begins[0], draw), burst(0.8, begins[1], draw), burst(0.1, begins[2], draw)])
        }
        "hub_appendage" => {
            let mut u = vec![0.0; n];
            let (size, width) = (2.0 * draw.uniform(0.7, 1.5), draw.uniform(0.3, 1.2));
            let again = draw.uniform(1.5, 2.5);
            for (k, u) in u.iter_mut().enumerate() {
                let t = k as f64 * bench.period_s;
                *u = if t < width {
                    size
                } else if t > again && t < again + width {
                    -size
                } else {
                    0.0
                };
            }
            still(vec![u])
        }
        other => panic!("no experiment for '{other}'"),
    }
}

/// Release from stated angles; the true ones differ within their prior.
fn release(plant: &Plant, joints: &[(&str, [f64; 2])], draw: &mut Draw) -> Flight {
    let mut known = plant.clone();
    let mut q = Vec::new();
    for (joint, [low, high]) in joints {
        let stated = draw.sign() * draw.uniform(*low, *high) * PI / 180.0;
        let value = known.initial.values.iter_mut().find(|value| value.coordinate == *joint);
        let value = value.expect("the plant file states the release");
        value.position.value = stated;
        q.push(stated + value.position.sigma.unwrap_or(0.0) * draw.normal().clamp(-2.0, 2.0));
    }
    Flight { v: vec![0.0; q.len()], q, command: Command::Held(vec![Vec::new(); plant.actuators.len()]), plant: known }
}

fn reference(plant: &str, draw: &mut Draw) -> Vec<[f64; 3]> {
    let (size, low, high) = if plant == "drive_rig" { (0.4, 0.2, 1.5) } else { (1.5e-3, 3.5, 8.0) };
    (0..4).map(|_| [size * draw.uniform(0.5, 1.2), draw.log_uniform(low, high), draw.uniform(0.0, TAU)]).collect()
}

/// Sum of `count` sines of random phase between two frequencies [Hz], of the stated root mean
/// square.
fn multisine(n: usize, period_s: f64, [low, high]: [f64; 2], count: usize, rms: f64, draw: &mut Draw) -> Vec<f64> {
    let amplitude = rms * (2.0 / count as f64).sqrt();
    let lines: Vec<(f64, f64)> = (0..count).map(|_| (draw.log_uniform(low, high), draw.uniform(0.0, TAU))).collect();
    let at = |t: f64| lines.iter().map(|(f, p)| amplitude * libm::sin(TAU * f * t + p)).sum();
    (0..n).map(|k| at(k as f64 * period_s)).collect()
}

fn add_square(u: &mut [f64], period_s: f64, size: f64, hz: f64, phase: f64) {
    for (k, u) in u.iter_mut().enumerate() {
        let turn = k as f64 * period_s * hz + phase;
        *u += if turn - libm::floor(turn) < 0.5 { size } else { -size };
    }
}
