//! The simulated vehicle: which system runs in which mode, and the samples its sensors give.

use crate::systems;
use plant::appendage::{AppendageState, AppendageTruth, rectangular_pulse_nm};
use plant::arm::{ArmState, FreeFloatingArm};
use plant::noise::Stream;
use plant::slosh::{SloshState, SloshTruth, sine_force_n};
use runtime::experiment::ExperimentWindow;
use runtime::{Frame, Outputs, RunConfig, Scenario};
use serde::{Deserialize, Serialize};
use telemetry::{
    ACCELEROMETERS, ACTUATORS, Accelerometers, Actuators, Experiment, IMU, Imu, JOINTS, Joints, Mode, ModeState, Sample,
};

/// Without an experiment the sensors are read every so many frames.
const IDLE_EVERY_FRAMES: u64 = 10;
/// After the command to capture, the grasp takes this long.
const GRASP_AFTER_FRAMES: u64 = 200;
const RATE_VALID_Z: u64 = 1 << 2;
const ACCELERATION_VALID_X: u64 = 1 << 3;

/// Which system is simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Which {
    #[default]
    Idle,
    Appendage,
    Slosh,
    Arm,
    /// Approaching the target with the arm held; the target is on after the grasp.
    Grasp,
    MatedArm,
}

/// Everything that changes in a simulation.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SimulationState {
    which: Which,
    generation: u32,
    entered_frame: u64,
    inhibited: bool,
    grasped: bool,
    arm: Option<ArmState>,
    slosh: Option<SloshState>,
    appendage: Option<AppendageState>,
}

impl SimulationState {
    /// No excitation until the next mode.
    pub fn inhibit(&mut self) {
        self.inhibited = true;
    }

    /// Takes the simulators' states into the checkpoint.
    pub fn keep(&mut self, simulation: &Simulation) {
        self.arm = simulation.arm.as_ref().map(FreeFloatingArm::state);
        self.slosh = simulation.slosh.as_ref().map(SloshTruth::state);
        self.appendage = simulation.appendage.as_ref().map(AppendageTruth::state);
    }
}

/// The simulators of the present mode; rebuilt from scenario and state after a restart.
pub struct Simulation {
    scenario: Scenario,
    seed: u64,
    period_s: f64,
    idle_gyro: Stream,
    arm: Option<FreeFloatingArm>,
    slosh: Option<SloshTruth>,
    appendage: Option<AppendageTruth>,
}

impl Simulation {
    pub fn new(run: &RunConfig) -> Self {
        Simulation {
            scenario: run.scenario.clone(),
            seed: run.seed,
            period_s: run.scenario.period_ns() as f64 * 1e-9,
            idle_gyro: Stream::new(run.seed, "idle.gyro.z"),
            arm: None,
            slosh: None,
            appendage: None,
        }
    }

    /// The mode that takes effect decides which system is simulated from now on.
    pub fn enter(&mut self, state: &mut SimulationState, mode: &Mode) {
        let next = match (ModeState::from_code(mode.state), Experiment::from_code(mode.experiment)) {
            (_, Some(Experiment::Modal)) => Which::Appendage,
            (_, Some(Experiment::Slosh)) => Which::Slosh,
            (_, Some(Experiment::Inertial)) => Which::Arm,
            (Some(ModeState::Capture), _) => Which::Grasp,
            (Some(ModeState::MatedSettle | ModeState::MatedInertial), _) => Which::MatedArm,
            _ => Which::Idle,
        };
        let continues =
            matches!((state.which, next), (Which::Grasp | Which::MatedArm, Which::MatedArm)) && self.arm.is_some();
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

    /// Continues from a checkpoint.
    pub fn restore(&mut self, state: &SimulationState) {
        self.build(state);
        if let (Some(arm), Some(state)) = (&mut self.arm, state.arm) {
            arm.restore(state);
        }
        if let (Some(slosh), Some(state)) = (&mut self.slosh, state.slosh) {
            slosh.restore(state);
        }
        if let (Some(appendage), Some(state)) = (&mut self.appendage, &state.appendage) {
            appendage.restore(state);
        }
    }

    /// Fresh simulators; a repeated experiment has its own noise.
    fn build(&mut self, state: &SimulationState) {
        let stream = |name: &str| format!("{name}.{}", state.generation);
        let (scenario, seed, period_s) = (&self.scenario, self.seed, self.period_s);
        let arm = |which: &Option<_>, grasped, name| {
            which.as_ref().map(|arm| systems::arm(arm, grasped, period_s, seed, &stream(name)))
        };
        (self.arm, self.slosh, self.appendage) = (None, None, None);
        match state.which {
            Which::Idle => {}
            Which::Appendage => {
                self.appendage =
                    scenario.modal.as_ref().and_then(|modal| systems::appendage(modal, seed, &stream("modal")))
            }
            Which::Slosh => {
                self.slosh = scenario.slosh.as_ref().and_then(|slosh| systems::slosh(slosh, seed, &stream("slosh")))
            }
            Which::Arm => self.arm = arm(&scenario.inertial, false, "inertial"),
            Which::Grasp | Which::MatedArm if state.grasped => self.arm = arm(&scenario.mated, true, "mated"),
            Which::Grasp | Which::MatedArm => self.arm = arm(&scenario.mated, false, "grasp"),
        }
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
            Which::Appendage if open => self.appendage_frame(window.elapsed(frame), excited, frame.t_ns, out),
            Which::Slosh if open => self.slosh_frame(window.elapsed(frame), excited, frame.t_ns, out),
            Which::Arm if open => self.arm_frame(excited, frame.t_ns, out),
            Which::Grasp => {
                self.grasp_when_due(state, frame.number);
                self.arm_frame(false, frame.t_ns, out);
            }
            Which::MatedArm => self.arm_frame(excited, frame.t_ns, out),
            _ => self.idle_frame(frame, out),
        }
    }

    fn grasp_when_due(&mut self, state: &mut SimulationState, frame: u64) {
        if !state.grasped && frame >= state.entered_frame + GRASP_AFTER_FRAMES {
            state.grasped = true;
            self.build(state);
        }
    }

    fn arm_frame(&mut self, excited: bool, t_ns: u64, out: &mut Outputs) {
        let Some(arm) = &mut self.arm else { return };
        let measured = arm.step(excited);
        let mut imu = Imu::zeroed_at(t_ns);
        imu.interval_s = self.period_s;
        imu.omega_bi_b_rad_s[2] = measured.omega0_z_rad_s;
        imu.valid = RATE_VALID_Z;
        out.publish(IMU, &imu);
        let mut joints = Joints::zeroed_at(t_ns);
        joints.count = 2;
        joints.angle_rad[..2].copy_from_slice(&measured.joint_angle_rad);
        joints.rate_rad_s[..2].copy_from_slice(&measured.joint_rate_rad_s);
        joints.torque_nm[..2].copy_from_slice(&measured.joint_torque_nm);
        out.publish(JOINTS, &joints);
    }

    /// An interval's sample goes out in its last frame: it is known only then.
    fn slosh_frame(&mut self, elapsed: u64, excited: bool, t_ns: u64, out: &mut Outputs) {
        let (Some(truth), Some(experiment)) = (&mut self.slosh, &self.scenario.slosh) else { return };
        let interval_s = experiment.known.interval_s;
        let every = self.scenario.frames(interval_s).max(1);
        if !(elapsed + 1).is_multiple_of(every) {
            return;
        }
        let begin_s = (elapsed + 1 - every) as f64 * self.period_s;
        let commanded =
            sine_force_n(begin_s + 0.5 * interval_s, experiment.force_amplitude_n, experiment.force_frequency_hz);
        let measured = truth.step(if excited { commanded } else { 0.0 });
        let begin_ns = t_ns - (every - 1) * self.scenario.period_ns();
        let axis = experiment.known.axis.index();
        let mut actuators = Actuators::zeroed_at(begin_ns);
        actuators.interval_s = interval_s;
        actuators.force_b_n[axis] = measured.force_n;
        actuators.excited = u64::from(excited);
        out.publish(ACTUATORS, &actuators);
        let mut imu = Imu::zeroed_at(begin_ns);
        imu.interval_s = interval_s;
        imu.acceleration_b_m_s2[axis] = measured.acceleration_m_s2;
        imu.valid = ACCELERATION_VALID_X << axis;
        out.publish(IMU, &imu);
    }

    fn appendage_frame(&mut self, elapsed: u64, excited: bool, t_ns: u64, out: &mut Outputs) {
        let (Some(truth), Some(experiment)) = (&mut self.appendage, &self.scenario.modal) else { return };
        let rate_hz = systems::array_rate_hz(experiment);
        let rows = (rate_hz * self.period_s).round() as u32;
        let interval_ns = (1e9 / rate_hz).round() as u64;
        let mut batch = Accelerometers::zeroed_at(t_ns);
        (batch.count, batch.channels, batch.interval_ns) = (rows, plant::appendage::SENSORS as u32, interval_ns);
        let mut torque_nm = 0.0;
        for row in 0..rows as usize {
            let t_s = elapsed as f64 * self.period_s + row as f64 / rate_hz;
            let commanded = rectangular_pulse_nm(t_s, experiment.torque_nm, experiment.pulse_s);
            torque_nm = if excited { commanded } else { 0.0 };
            let measured = truth.step(torque_nm);
            batch.offset_ns[row] = row as u32 * interval_ns as u32;
            batch.acceleration_m_s2[row][..plant::appendage::SENSORS].copy_from_slice(&measured.acceleration_m_s2);
        }
        let mut actuators = Actuators::zeroed_at(t_ns);
        actuators.interval_s = self.period_s;
        actuators.torque_b_nm[2] = torque_nm;
        actuators.excited = u64::from(excited);
        out.publish(ACTUATORS, &actuators);
        out.publish(ACCELEROMETERS, &batch);
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
        (batch.count, batch.channels, batch.interval_ns) = (1, plant::appendage::SENSORS as u32, frame.period_ns);
        out.publish(ACCELEROMETERS, &batch);
    }
}
