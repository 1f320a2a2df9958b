//! The simulated vehicle: which system runs in which mode, and the samples its sensors give.

use crate::systems::{self, Setting, SystemsError};
use crate::vehicle::Vehicle;
use dynamics::noise::Stream;
use plant_file::scenario::Scenario;
use runtime::experiment::ExperimentWindow;
use runtime::{Frame, Outputs, RunConfig};
use serde::{Deserialize, Serialize};
use simulation::SimulatorState;
use std::fmt::Write as _;
use telemetry::{
    ACCELEROMETERS, ACTUATORS, Accelerometers, Actuators, Experiment, IMU, Imu, JOINTS, Joints, Mode, ModeState, Sample,
};

/// Without an experiment the sensors are read every so many frames.
const IDLE_EVERY_FRAMES: u64 = 10;
/// After the command to capture, the grasp takes this long.
const GRASP_AFTER_FRAMES: u64 = 200;
/// Accelerometers on the appendage of the vehicle at rest.
const IDLE_ACCELEROMETERS: u32 = 10;
const RATE_VALID_Z: u64 = 1 << 2;
const ACCELERATION_VALID_X: u64 = 1 << 3;
/// The longest name and ten digits.
const STREAM_BYTES: usize = 20;

/// Which system is simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Which {
    #[default]
    Idle,
    Appendage,
    Tank,
    Arm,
    /// Approaching the target with the arm held; the target is on after the grasp.
    Grasp,
    MatedArm,
    /// The arc of this number of the one craft.
    Craft(u32),
}

/// What changes in a simulation beside the vehicle.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SimulationState {
    which: Which,
    generation: u32,
    entered_frame: u64,
    inhibited: bool,
    grasped: bool,
}

/// Beginning of the names of a vehicle's noise.
fn name(state: &SimulationState) -> &'static str {
    match state.which {
        Which::Idle => "idle",
        Which::Appendage => "modal",
        Which::Tank => "slosh",
        Which::Arm => "inertial",
        Which::Grasp | Which::MatedArm if state.grasped => "mated",
        Which::Grasp | Which::MatedArm => "grasp",
        Which::Craft(_) => "craft",
    }
}

/// Whether it is the arm that takes the target.
fn is_mated(which: Which) -> bool {
    matches!(which, Which::Grasp | Which::MatedArm)
}

impl SimulationState {
    /// No excitation until the next mode.
    pub fn inhibit(&mut self) {
        self.inhibited = true;
    }
}

/// A vehicle as it is built, and whether its target is on.
type Ready = (Which, bool, Option<Vehicle>);

/// The vehicle of the present mode; rebuilt from scenario and state after a restart.
pub struct Simulation {
    scenario: Scenario,
    seed: u64,
    period_s: f64,
    idle_gyro: Stream,
    vehicle: Option<Vehicle>,
    /// Built before the flight, each for the first experiment that asks for it: to build one takes
    /// memory and time.
    ready: Vec<Ready>,
    /// Room for the name of a vehicle's noise.
    stream: String,
}

impl Simulation {
    /// # Errors
    /// An experiment of the scenario cannot be simulated.
    pub fn new(run: &RunConfig, scenario: Scenario) -> Result<Self, SystemsError> {
        let mut simulation = Simulation {
            period_s: scenario.period_ns() as f64 * 1e-9,
            scenario,
            seed: run.seed,
            idle_gyro: Stream::new(run.seed, "idle.gyro.z"),
            vehicle: None,
            ready: Vec::new(),
            stream: String::with_capacity(STREAM_BYTES),
        };
        let arcs = simulation.scenario.craft.as_ref().map_or(0, |craft| craft.arcs.len());
        let arcs = (0..arcs).map(|arc| (Which::Craft(arc as u32), false));
        let experiments = [Which::Appendage, Which::Tank, Which::Arm, Which::Grasp].map(|which| (which, false));
        for (which, grasped) in experiments.into_iter().chain([(Which::MatedArm, true)]).chain(arcs) {
            let vehicle = simulation.vehicle(which, grasped)?;
            simulation.ready.push((which, grasped, vehicle));
        }
        Ok(simulation)
    }

    /// The mode that takes effect decides which system is simulated from now on.
    pub fn enter(&mut self, state: &mut SimulationState, mode: &Mode) {
        let experiment = Experiment::from_code(mode.experiment).filter(|experiment| *experiment != Experiment::None);
        let arc = self.scenario.craft.as_ref().and(experiment).map(|_| mode.generation.saturating_sub(1));
        let next = match (ModeState::from_code(mode.state), Experiment::from_code(mode.experiment)) {
            _ if arc.is_some() => Which::Craft(arc.unwrap_or(0)),
            (_, Some(Experiment::Modal)) => Which::Appendage,
            (_, Some(Experiment::Slosh)) => Which::Tank,
            (_, Some(Experiment::Inertial)) => Which::Arm,
            (Some(ModeState::Capture), _) => Which::Grasp,
            (Some(ModeState::MatedSettle | ModeState::MatedInertial), _) => Which::MatedArm,
            _ => Which::Idle,
        };
        let continues =
            matches!((state.which, next), (Which::Grasp | Which::MatedArm, Which::MatedArm)) && self.vehicle.is_some();
        state.which = next;
        state.entered_frame = mode.effective_frame;
        state.inhibited = false;
        if continues {
            return;
        }
        state.generation = mode.generation;
        state.grasped = next == Which::MatedArm;
        self.build(state);
    }

    /// Of the vehicle, for a checkpoint: the bytes of an `Option<SimulatorState>`.
    pub fn vehicle_state(&self) -> impl Serialize + '_ {
        self.vehicle.as_ref().map(Vehicle::state)
    }

    /// Continues from a checkpoint.
    ///
    /// # Errors
    /// The checkpoint is of another scenario.
    pub fn restore(
        &mut self,
        state: &SimulationState,
        vehicle: Option<&SimulatorState>,
    ) -> Result<(), simulation::SimulationError> {
        self.build(state);
        match (&mut self.vehicle, vehicle) {
            (Some(vehicle), Some(state)) => vehicle.restore(state),
            _ => Ok(()),
        }
    }

    /// A fresh vehicle; a repeated experiment has its own noise.
    fn build(&mut self, state: &SimulationState) {
        // Held on the way to the target or moved with it, the arm that takes it is one vehicle.
        let same = |which: Which| which == state.which || (is_mated(which) && is_mated(state.which));
        let ready = self
            .ready
            .iter_mut()
            .find(|(which, grasped, vehicle)| vehicle.is_some() && same(*which) && *grasped == state.grasped);
        let mut vehicle = match ready {
            Some((_, _, vehicle)) => vehicle.take(),
            None => self.vehicle(state.which, state.grasped).expect("this vehicle was built once at the start"),
        };
        self.stream.clear();
        let _ = write!(self.stream, "{}.{}", name(state), state.generation);
        if let Some(vehicle) = &mut vehicle {
            vehicle.draw_from(self.seed, &self.stream);
        }
        self.vehicle = vehicle;
    }

    /// The vehicle of a system, with noise of no experiment's stream.
    fn vehicle(&self, which: Which, grasped: bool) -> Result<Option<Vehicle>, SystemsError> {
        let setting = Setting { frame_s: self.period_s, seed: self.seed, stream: "" };
        let Scenario { modal, slosh, inertial, mated, craft, .. } = &self.scenario;
        let built = match which {
            Which::Idle => None,
            Which::Appendage => modal.as_ref().map(|modal| systems::appendage(modal, setting)),
            Which::Tank => slosh.as_ref().map(|slosh| systems::tank(slosh, setting)),
            Which::Arm => inertial.as_ref().map(|arm| systems::arm(arm, true, setting)),
            Which::Craft(arc) => craft.as_ref().map(|craft| systems::of_arc(craft, arc as usize, setting)),
            Which::Grasp | Which::MatedArm => mated.as_ref().map(|arm| systems::arm(arm, grasped, setting)),
        };
        built.transpose().map(Option::flatten)
    }

    /// The samples of one frame.
    pub fn frame(
        &mut self,
        state: &mut SimulationState,
        window: &ExperimentWindow,
        frame: &Frame<'_>,
        out: &mut Outputs,
    ) {
        let open = window.experiment != Experiment::None && frame.number < window.end_frame;
        let excited = open && !state.inhibited;
        match state.which {
            Which::Appendage | Which::Tank | Which::Arm | Which::Craft(_) if open => {
                self.vehicle_frame(window.elapsed(frame), excited, frame.t_ns, out);
            }
            Which::Grasp => {
                self.grasp_when_due(state, frame.number);
                self.vehicle_frame(frame.number.saturating_sub(state.entered_frame), false, frame.t_ns, out);
            }
            Which::MatedArm => {
                self.vehicle_frame(frame.number.saturating_sub(state.entered_frame), excited, frame.t_ns, out);
            }
            _ => self.idle_frame(frame, out),
        }
    }

    fn grasp_when_due(&mut self, state: &mut SimulationState, frame: u64) {
        if !state.grasped && frame >= state.entered_frame + GRASP_AFTER_FRAMES {
            state.grasped = true;
            self.build(state);
        }
    }

    /// A control period's samples go out in its last frame: they are known only then.
    fn vehicle_frame(&mut self, elapsed: u64, excited: bool, t_ns: u64, out: &mut Outputs) {
        let Some(vehicle) = &mut self.vehicle else { return };
        let frames = vehicle.frames();
        if (elapsed + 1).is_multiple_of(frames) {
            vehicle.step(excited, t_ns - (frames - 1) * self.scenario.period_ns(), out);
        }
    }

    /// The vehicle at rest: its sensors are alive and show noise.
    fn idle_frame(&self, frame: &Frame<'_>, out: &mut Outputs) {
        if !frame.number.is_multiple_of(IDLE_EVERY_FRAMES) {
            return;
        }
        let known =
            self.scenario.inertial.as_ref().or(self.scenario.mated.as_ref()).map(|arm| arm.known.gyro_arw_deg_sqrt_h);
        let sigma = known.unwrap_or(0.0).to_radians() / 60.0 / self.period_s.sqrt();
        let mut imu = Imu::zeroed_at(frame.t_ns);
        imu.interval_s = self.period_s;
        imu.omega_bi_b_rad_s[2] = sigma * self.idle_gyro.normal(frame.number);
        imu.valid = RATE_VALID_Z | ACCELERATION_VALID_X;
        out.publish(IMU, &imu);
        let mut joints = Joints::zeroed_at(frame.t_ns);
        joints.count = 2;
        out.publish(JOINTS, &joints);
        let mut actuators = Actuators::zeroed_at(frame.t_ns);
        actuators.interval_s = self.period_s;
        out.publish(ACTUATORS, &actuators);
        let mut batch = Accelerometers::zeroed_at(frame.t_ns);
        (batch.count, batch.channels, batch.interval_ns) = (1, IDLE_ACCELEROMETERS, frame.period_ns);
        out.publish(ACCELEROMETERS, &batch);
    }
}
