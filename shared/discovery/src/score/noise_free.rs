//! Closed loops simulated without noise: the trajectory along which columns of their recordings are
//! taken.
//!
//! The recorded command of a loop responds to the noise of the sensors it reads, and so do the
//! filtered states. A column taken along them is correlated with the innovations that it is
//! projected on: with coloured noise the score invents physics. Along the loop simulated without
//! noise it is uncorrelated, and differs from the other by the response of the effect to noise.

use channels::interpolate;
use dynamics::description::{Noise, Plant, Quantity};
use identification::problem::{Course, Drive, Problem, Run, Samples};
use simulation::Simulator;

/// Share of a reading's own variation that the simulation may miss; a loop that does not follow its
/// recording is rejected as unknown. Chosen, no derivation.
const LOOP_MISFIT_SHARE_MAX: f64 = 0.3;
/// Ratio of the noise to its stated size that is allowed for. Chosen, no derivation.
const LOOP_NOISE_RATIO_MAX: f64 = 2.0;

/// `problem` with commands and readings of `plant`'s loops at `theta`, without noise; `None` where
/// no loop of the plant is recorded, or where the simulation is not near the recording. `sigma`:
/// noise of one sample of each sensor.
pub fn noise_free(problem: &Problem, plant: &Plant, theta: &[f64], sigma: &[f64]) -> Option<Problem> {
    let mut clean = problem.clone();
    let mut any = false;
    for (index, run) in problem.runs.iter().enumerate() {
        let closed = |drive: &(usize, &Drive)| {
            let name = &plant.actuators[drive.0].name;
            matches!(drive.1, Drive::Held { .. }) && plant.controllers.iter().any(|c| c.actuator == *name)
        };
        if run.drives.iter().any(|drive| matches!(drive, Drive::Motion { course: Course::Recorded(_), .. })) {
            return None;
        }
        if run.drives.iter().enumerate().any(|drive| closed(&drive)) {
            clean.runs[index] = simulated(&quiet(problem.instance(plant, theta, index)), run, sigma)?;
            any = true;
        }
    }
    any.then_some(clean)
}

/// The plant without noise and quantisation.
fn quiet(mut plant: Plant) -> Plant {
    plant.segments.clear();
    plant.actuators.iter_mut().for_each(|actuator| actuator.noise = Quantity::known(0.0));
    for sensor in &mut plant.sensors {
        sensor.noise = Noise::default();
        sensor.resolution = Quantity::known(0.0);
    }
    plant.without_staircases()
}

/// The run as `plant` simulates it from its initial state; loops forget where they began.
fn simulated(plant: &Plant, run: &Run, sigma: &[f64]) -> Option<Run> {
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
    for ((drive, command), actuator) in clean.drives.iter_mut().zip(&commands).zip(&plant.actuators) {
        if let Drive::Held { time_s, value } = drive {
            let recorded = core::mem::take(value);
            // the value just after the stamp
            let at =
                |t: &f64| command.time_s.partition_point(|own| *own <= t + 1e-9 * plant.simulation.period_s).max(1);
            *value = time_s.iter().map(|t| command.value[at(t) - 1]).collect();
            let closed = plant.controllers.iter().any(|controller| controller.actuator == actuator.name);
            // outside the loops the simulation uses the plant's own signal: it must be the recorded
            // one
            if !closed && misses(&recorded, value, 0.0) {
                return None;
            }
        }
    }
    for ((samples, reading), sigma) in clean.samples.iter_mut().zip(&readings).zip(sigma) {
        let recorded = core::mem::take(&mut samples.value);
        if reading.time_s.is_empty() && !recorded.is_empty() {
            return None;
        }
        samples.value = samples.time_s.iter().map(|t| interpolate(&reading.time_s, &reading.value, *t)).collect();
        if misses(&recorded, &samples.value, *sigma) {
            return None;
        }
    }
    Some(clean)
}

/// The difference is more than noise and a share of the variation.
fn misses(recorded: &[f64], simulated: &[f64], sigma: f64) -> bool {
    let count = recorded.len().max(1) as f64;
    let mean = recorded.iter().sum::<f64>() / count;
    let variation: f64 = recorded.iter().map(|y| (y - mean) * (y - mean)).sum();
    let apart: f64 = recorded.iter().zip(simulated).map(|(y, s)| (y - s) * (y - s)).sum();
    apart
        > LOOP_MISFIT_SHARE_MAX * LOOP_MISFIT_SHARE_MAX * variation
            + LOOP_NOISE_RATIO_MAX * LOOP_NOISE_RATIO_MAX * count * sigma * sigma
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{off_priors, plant, problem, recording, sample_sigma};

    fn prior(problem: &Problem) -> Vec<f64> {
        problem.unknowns.iter().map(|unknown| unknown.prior).collect()
    }

    fn sigma(plant: &Plant) -> Vec<f64> {
        plant.sensors.iter().map(|sensor| sample_sigma(plant, &sensor.name).unwrap()).collect()
    }

    #[test]
    fn a_loop_without_noise_is_the_same_whatever_noise_was_recorded() {
        let study = plant("study_case");
        let of = |seed: u64| {
            let recorded = problem(&study, recording(&study, seed, 2.0));
            let clean = noise_free(&recorded, &study, &prior(&recorded), &sigma(&study)).unwrap();
            (recorded, clean)
        };
        let ((a, clean_a), (b, clean_b)) = (of(1), of(2));
        let values = |problem: &Problem| -> Vec<Vec<f64>> {
            problem.runs[0].samples.iter().map(|samples| samples.value.clone()).collect()
        };
        assert_ne!(values(&a), values(&b));
        assert_eq!(values(&clean_a), values(&clean_b));
        let motor = study.actuators.iter().position(|a| a.name == study.controllers[0].actuator).unwrap();
        let command = |problem: &Problem| match &problem.runs[0].drives[motor] {
            Drive::Held { value, .. } => value.clone(),
            other => panic!("{other:?} is not held"),
        };
        assert_ne!(command(&a), command(&b));
        assert_eq!(command(&clean_a), command(&clean_b));
    }

    #[test]
    fn a_loop_that_does_not_follow_its_recording_is_rejected_and_without_a_loop_there_is_none() {
        let study = plant("study_case");
        let recorded = problem(&study, recording(&study, 1, 2.0));
        let mut other = study.clone();
        other.controllers.iter_mut().for_each(|controller| controller.reference.clear());
        assert!(noise_free(&recorded, &other, &prior(&recorded), &sigma(&study)).is_none());
        let open = plant("drive_rig");
        let recorded = problem(&open, recording(&off_priors(&open, 1), 1, 2.0));
        assert!(noise_free(&recorded, &open, &prior(&recorded), &sigma(&open)).is_none());
    }
}
