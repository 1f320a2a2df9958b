//! What it is: the source of all sensor samples: simulates the sensors of the experiment in effect,
//! or replays a recording, frame by frame.
//!
//! ```no_run
//! use runtime::rundir::RunDir;
//! use telemetry::PartitionId;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // The folder of a run, as `obsid run` makes it.
//! let folder = std::env::args_os().nth(1).ok_or("no folder of a run")?;
//! let run = RunDir::at(folder.as_ref()).load()?;
//! let mut source = sensor_sim::connect(&run)?;
//! assert_eq!(source.id(), PartitionId::SensorSim);
//! assert!(source.inputs().is_empty());
//! let mut checkpoint = Vec::new();
//! source.save(&mut checkpoint)?;
//! source.restore(&checkpoint)?;
//! # Ok(())
//! # }
//! ```
//!
//! May import: dynamics, plant_file, simulation, recording, runtime, telemetry.
//!
//! Must never know: estimators, and the closed-form models that they use.
#![forbid(unsafe_code)]

pub mod craft;
mod simulation;
pub mod systems;
mod vehicle;
mod wrench;

use ::simulation::SimulatorState;
use plant_file::scenario::Scenario;
use recording::{ChannelMap, ReplayFrames, ReplaySample};
use runtime::experiment::ExperimentWindow;
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use serde::{Deserialize, Serialize};
use simulation::{Simulation, SimulationState};
use telemetry::{ACCELEROMETERS, ACTUATORS, Command, Experiment, Header, IMU, JOINTS, PartitionId, TopicId};

/// State of a checkpoint.
#[derive(Clone, Default, Serialize, Deserialize)]
struct State {
    window: ExperimentWindow,
    /// First frame behind the run: the plan has ended and every sample has been consumed.
    last_frame: Option<u64>,
    simulation: SimulationState,
}

/// The source partition: without inputs of its own, the only one that opens frames.
pub struct SensorSim {
    state: State,
    simulation: Simulation,
    replay: Option<ReplayFrames>,
    window_frames: u64,
}

/// Builds the source of `run`.
///
/// # Errors
/// When the scenario, the plant it names, the recording or its channel map cannot be read, or the
/// plant cannot be simulated.
pub fn connect(run: &RunConfig) -> Result<Box<dyn Partition>, ConnectError> {
    let replay = run.replay.as_ref().map(|_| read_recording(run)).transpose()?;
    let scenario = Scenario::read(&run.scenario, &run.files, run.replay.is_some())
        .map_err(ConnectError::of(PartitionId::SensorSim))?;
    let simulation = Simulation::new(run, scenario).map_err(ConnectError::of(PartitionId::SensorSim))?;
    Ok(Box::new(SensorSim { state: State::default(), simulation, replay, window_frames: run.window_frames }))
}

fn read_recording(run: &RunConfig) -> Result<ReplayFrames, ConnectError> {
    let fail = |reason: String| ConnectError { partition: PartitionId::SensorSim, reason };
    let config = run.replay.as_ref().ok_or_else(|| fail("no recording".into()))?;
    let said = config.channel_map.as_deref().map(|text| ChannelMap::of_replay("map", text)).transpose();
    let (intake, map) = said.map_err(|error| fail(error.to_string()))?.unwrap_or_default();
    let imported = recording::read_with(&config.path, &intake).map_err(|error| fail(error.to_string()))?;
    ReplayFrames::new(&imported, map.as_ref(), run.period_ns).map_err(|error| fail(error.to_string()))
}

/// A partition that an experiment needs was given up: nothing is excited until the next mode. None
/// needs the one that says what a refused model lacks.
fn ends_excitation(command: &Command) -> bool {
    runtime::pacing::given_up(command).is_some_and(|lost| lost != PartitionId::Diagnosis)
}

impl Partition for SensorSim {
    fn id(&self) -> PartitionId {
        PartitionId::SensorSim
    }

    fn inputs(&self) -> &'static [TopicId] {
        &[]
    }

    fn frame(&mut self, frame: &Frame<'_>, out: &mut Outputs) {
        if frame.urgent.iter().any(ends_excitation) {
            self.state.simulation.inhibit();
        }
        if let Some(mode) = frame.new_mode() {
            self.state.window.step(frame, &[]);
            self.simulation.enter(&mut self.state.simulation, mode);
            if mode.ended == 1 {
                // Results of the last frames are on their way for one more window.
                self.state.last_frame = Some(frame.number + self.window_frames);
            }
        }
        let window = self.state.window;
        match &self.replay {
            Some(replay) if window.experiment == Experiment::Replay && frame.number < window.end_frame => {
                let begin_ns = window.begin_frame * frame.period_ns;
                replay.frame(frame.number - window.begin_frame, &mut |sample| publish_replayed(sample, begin_ns, out));
            }
            Some(_) => {}
            None => self.simulation.frame(&mut self.state.simulation, &window, frame, out),
        }
        if self.state.last_frame.is_some_and(|last| frame.number >= last) {
            out.end();
        }
    }

    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        runtime::save_state(&(&self.state, self.simulation.vehicle_state()), state)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        let (state, vehicle): (State, Option<SimulatorState>) = runtime::restore_state(state)?;
        self.state = state;
        let restored = self.simulation.restore(&self.state.simulation, vehicle.as_ref());
        restored.map_err(|error| StateError::Other(error.to_string()))
    }
}

fn publish_replayed(sample: ReplaySample, begin_ns: u64, out: &mut Outputs) {
    let later = |header: Header| Header::at(begin_ns + header.t_meas_ns);
    match sample {
        ReplaySample::Imu(mut sample) => {
            sample.header = later(sample.header);
            out.publish(IMU, &sample);
        }
        ReplaySample::Joints(mut sample) => {
            sample.header = later(sample.header);
            out.publish(JOINTS, &sample);
        }
        ReplaySample::Actuators(mut sample) => {
            sample.header = later(sample.header);
            out.publish(ACTUATORS, &sample);
        }
        ReplaySample::Accelerometers(mut sample) => {
            sample.header = later(sample.header);
            out.publish(ACCELEROMETERS, &sample);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use telemetry::Sample;

    #[test]
    fn losing_what_diagnoses_ends_no_excitation_and_losing_an_estimator_does() {
        let lost = |id: PartitionId| Command {
            opcode: runtime::pacing::GIVEN_UP,
            argument: id.code().into(),
            ..Command::zeroed_at(0)
        };
        assert!(!ends_excitation(&lost(PartitionId::Diagnosis)));
        assert!(ends_excitation(&lost(PartitionId::SloshId)) && ends_excitation(&lost(PartitionId::InertialId)));
        assert!(!ends_excitation(&Command::zeroed_at(0)));
    }
}
