//! Closed loops as they would have run without noise: where the columns of their recordings are taken.
//!
//! The recorded command of a loop answers the noise of the sensors it reads, and so do the filtered states. A column taken along them is
//! not independent of the innovations that it is projected on: with coloured noise the score invents physics. Along the loop simulated
//! without noise it is, and differs from the other by what noise does to the effect.

use crate::problem::{Drive, Problem, Run, Samples};
use crate::series::interpolate;
use plant::description::{Noise, Plant, Quantity};
use plant::simulation::Simulator;

/// Share of a reading's own variation that the simulation may miss; a loop that does not follow its recording is none we know.
const MISSED_MAX: f64 = 0.3;

/// `problem` with commands and readings of `plant`'s loops at `theta`, without noise; `None` where nothing is recorded in a loop that the
/// plant knows, or where the simulation is not near the recording.
pub fn noise_free(problem: &Problem, plant: &Plant, theta: &[f64]) -> Option<Problem> {
    let mut clean = problem.clone();
    let mut any = false;
    for (index, run) in problem.runs.iter().enumerate() {
        let closed = |drive: &(usize, &Drive)| {
            let name = &plant.actuators[drive.0].name;
            matches!(drive.1, Drive::Held { .. }) && plant.controllers.iter().any(|c| c.actuator == *name)
        };
        if run.drives.iter().enumerate().any(|drive| closed(&drive)) {
            clean.runs[index] = simulated(&quiet(problem.instance(plant, theta, index)), run)?;
            any = true;
        }
    }
    any.then_some(clean)
}

/// The plant without noise and steps of quantisation.
fn quiet(mut plant: Plant) -> Plant {
    plant.segments.clear();
    plant.actuators.iter_mut().for_each(|actuator| actuator.noise = Quantity::known(0.0));
    for sensor in &mut plant.sensors {
        sensor.noise = Noise::default();
        sensor.resolution = Quantity::known(0.0);
    }
    plant.effects.retain(|effect| effect.kind != "sensor_quantisation");
    plant
}

/// The run as `plant` simulates it from its initial state; loops forget where they began.
fn simulated(plant: &Plant, run: &Run) -> Option<Run> {
    let mut simulator = Simulator::new(plant, 0, &plant.name).ok()?;
    simulator.restart(run.begin_s, &run.initial).ok()?;
    let mut commands: Vec<Samples> = vec![Samples::default(); plant.actuators.len()];
    let mut readings: Vec<Samples> = vec![Samples::default(); plant.sensors.len()];
    let push = |list: &mut Samples, t: f64, value: f64| {
        list.time_s.push(t);
        list.value.push(value);
    };
    while simulator.time_s() < run.end_s + plant.simulation.period_s {
        let row = simulator.step();
        commands.iter_mut().zip(&row.commands).for_each(|(list, u)| push(list, row.time_s, *u));
        row.samples.iter().for_each(|sample| push(&mut readings[sample.channel], sample.time_s, sample.value));
        simulator.check_finite().ok()?;
    }
    let mut clean = run.clone();
    for (drive, command) in clean.drives.iter_mut().zip(&commands) {
        if let Drive::Held { time_s, value } = drive {
            // what holds just after the stamp
            let at =
                |t: &f64| command.time_s.partition_point(|own| *own <= t + 1e-9 * plant.simulation.period_s).max(1);
            *value = time_s.iter().map(|t| command.value[at(t) - 1]).collect();
        }
    }
    for (samples, reading) in clean.samples.iter_mut().zip(&readings) {
        let recorded = core::mem::take(&mut samples.value);
        samples.value = samples.time_s.iter().map(|t| interpolate(&reading.time_s, &reading.value, *t)).collect();
        if missed(&recorded, &samples.value) > MISSED_MAX {
            return None;
        }
    }
    Some(clean)
}

/// rms of the difference over rms of the variation.
fn missed(recorded: &[f64], simulated: &[f64]) -> f64 {
    let mean = recorded.iter().sum::<f64>() / recorded.len().max(1) as f64;
    let variation: f64 = recorded.iter().map(|y| (y - mean) * (y - mean)).sum();
    let apart: f64 = recorded.iter().zip(simulated).map(|(y, s)| (y - s) * (y - s)).sum();
    if variation > 0.0 { (apart / variation).sqrt() } else { 0.0 }
}
