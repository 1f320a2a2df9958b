//! A whole record: every channel that a file would hold.

use super::{SimulationError, Simulator};
use channels::{Channel, Recording};
use dynamics::description::{Initial, Plant};
use dynamics::system::Period;

/// Simulates `plant` for `duration_s` and keeps what a recording holds: the commands of recorded
/// actuators, then all sensors, under the plant's name and with unknown roles, as a file would give
/// them. Segments restart with their own initial state at their own beginning; what lies between
/// them is not recorded. `progress` is called with the share that is done.
///
/// # Errors
/// See [`SimulationError`].
pub fn record(
    plant: &Plant,
    seed: u64,
    duration_s: f64,
    progress: &mut dyn FnMut(f64),
) -> Result<Recording, SimulationError> {
    let mut simulator = Simulator::new(plant, seed, &plant.name)?;
    let mut recording = Recording { name: plant.name.clone(), channels: empty_channels(plant, &simulator) };
    let recorded: Vec<usize> = (0..plant.actuators.len()).filter(|index| plant.actuators[*index].recorded).collect();
    for (begin_s, end_s, initial) in spans(plant, duration_s) {
        if let Some(initial) = initial {
            simulator.restart(begin_s, initial)?;
        }
        let periods = libm::ceil((end_s - begin_s) / plant.simulation.period_s - 1e-9).max(0.0) as u64;
        for k in 0..periods {
            if k.is_multiple_of(100) {
                progress((begin_s + k as f64 * plant.simulation.period_s) / duration_s);
            }
            simulator.step();
            simulator.check_finite()?;
            let row = simulator.row();
            for (channel, actuator) in recording.channels.iter_mut().zip(&recorded) {
                push(channel, row.time_s, row.commands[*actuator]);
            }
            for sample in &row.samples {
                push(&mut recording.channels[recorded.len() + sample.channel], sample.time_s, sample.value);
            }
        }
    }
    progress(1.0);
    Ok(recording)
}

/// Calls `visit` for every control period of the motion that [`record`] would have of `plant` with
/// seed zero.
///
/// # Errors
/// As [`record`].
pub fn motion(plant: &Plant, duration_s: f64, visit: &mut dyn FnMut(&Period<'_>)) -> Result<(), SimulationError> {
    let mut simulator = Simulator::new(plant, 0, &plant.name)?;
    let system = simulator.system().clone();
    for (begin_s, end_s, initial) in spans(plant, duration_s) {
        if let Some(initial) = initial {
            simulator.restart(begin_s, initial)?;
        }
        let periods = libm::ceil((end_s - begin_s) / plant.simulation.period_s - 1e-9).max(0.0) as u64;
        for k in 0..periods {
            let truth = simulator.truth();
            let (begin_s, state) = (truth.time_s, truth.state.to_vec());
            let inputs = simulator.step().inputs.clone();
            simulator.check_finite()?;
            let (restarts, last, end_s) = (k == 0, k + 1 == periods, simulator.time_s());
            visit(&Period { system: &system, restarts, last, begin_s, end_s, state: &state, inputs: &inputs });
        }
    }
    Ok(())
}

fn push(channel: &mut Channel, time_s: f64, value: f64) {
    channel.time_s.push(time_s);
    channel.value.push(value);
}

/// Empty channels in the order of a recording.
fn empty_channels(plant: &Plant, simulator: &Simulator) -> Vec<Channel> {
    let channel = |name: &str, unit: &str| Channel::new(name, unit, Vec::new(), Vec::new());
    let inputs = simulator.system().inputs();
    let command = |index: usize| {
        let stated = super::inputs::stated_input(plant, inputs, index);
        channel(&plant.actuators[index].name, stated.map_or("", |input| input.unit))
    };
    let commands = (0..plant.actuators.len()).filter(|index| plant.actuators[*index].recorded).map(command);
    commands.chain(simulator.system().outputs().iter().map(|output| channel(&output.name, output.unit))).collect()
}

/// Begin, end and initial state of every part of the record; without segments it is one part in the
/// plant's own initial state.
pub(crate) fn spans(plant: &Plant, duration_s: f64) -> Vec<(f64, f64, Option<&Initial>)> {
    if plant.segments.is_empty() {
        return vec![(0.0, duration_s, None)];
    }
    let begin = |index: usize| plant.segments.get(index).map_or(duration_s, |segment| segment.begin_s.value);
    let mut spans = Vec::with_capacity(plant.segments.len());
    for (index, segment) in plant.segments.iter().enumerate() {
        let end_s = segment.end_s.map_or(begin(index + 1), |end| end.value).min(duration_s);
        spans.push((segment.begin_s.value, end_s, Some(&segment.initial)));
    }
    spans
}
