//! What it is: decisions on a run: which experiment is flown when, which model is accepted, and
//! whether the target is on the arm.
//!
//! ```no_run
//! use runtime::rundir::RunDir;
//! use telemetry::{PartitionId, TOPICS};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // The folder of a run, as `obsid run` makes it.
//! let folder = std::env::args_os().nth(1).ok_or("no folder of a run")?;
//! let run = RunDir::at(folder.as_ref()).load()?;
//! let partition = supervisor::connect(&run)?;
//! assert_eq!(partition.id(), PartitionId::Supervisor);
//! for topic in partition.inputs() {
//!     println!("{}: {}", TOPICS[*topic].name, TOPICS[*topic].rate);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! May import: telemetry, estimation, physics, craft, plant_file, runtime.
//!
//! Must never know: how a plant is simulated, another service, a clock, a file.
//!
//! | file | subject |
//! |---|---|
//! | `mode` | the mode table and the machine that evaluates it, once a frame |
//! | `validation` | two verdicts on a model: complete, adequate |
//! | `guards_table` | limits of the mode table as a parameter table |
//! | `held_out` | the last fifth of an experiment, simulated with an estimate that never saw it |
//! | `inertia` | inertia by the modes against that by the momentum |
//! | `contact` | contact detected from a jump of the momentum, or of the base rate |
//! | `verdicts` | verdicts on experiments that give no model |
//! | `mission` | plan, needs and predicted sigmas of the scenario |
//! | `joint` | one craft through all its arcs: generations of messages, their tests, the verdict |
//! | `measured` | quantities from the samples of a frame: base rate, live sensors, held-out rows |

#![forbid(unsafe_code)]

pub mod contact;
mod guards_table;
pub mod held_out;
pub mod inertia;
mod joint;
mod measured;
mod mission;
pub mod mode;
#[cfg(test)]
#[path = "../../../shared/estimation/src/seeded_noise.rs"]
mod seeded_noise;
#[cfg(test)]
mod specimen;
pub mod validation;
mod verdicts;

use contact::{ContactDetector, FreeArm};
use inertia::Inertias;
use measured::Measured;
use mission::Mission;
use mode::{ContactMeasure, ModeMachine, Situation, Stimulus};
use plant_file::scenario::Scenario;
use runtime::experiment::ExperimentWindow;
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use serde::{Deserialize, Serialize};
use telemetry::{
    ACCELEROMETERS, ACTUATORS, AnyEstimate, COMPARISON_INERTIA, Domain, ESTIMATE_INERTIAL, ESTIMATE_MODAL,
    ESTIMATE_SLOSH, IMU, JOINTS, MODE, ModeState, Opcode, PartitionId, Phase, Reason, TableId, TableValues, TopicId,
    VERDICT, Verdict,
};
use verdicts::{Ledger, NoModel};

/// An accepted model of the phase before capture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Accepted {
    frame: u64,
    sigma_over_need: Option<f64>,
}

#[derive(Clone, Serialize, Deserialize)]
struct State {
    machine: ModeMachine,
    started: bool,
    window: ExperimentWindow,
    accepted: [Option<Accepted>; 3],
    lost: [bool; 3],
    source_lost: bool,
    measured: Measured,
    /// Newest model of the free arm, accepted or not.
    free_arm: Option<FreeArm>,
    /// While the target is in reach.
    contact: Option<ContactDetector>,
    ledger: Ledger,
    inertias: Inertias,
}

/// Stimuli and verdicts of one frame: more than there are phases and orders.
const IN_A_FRAME: usize = 16;

/// The partition: consumes samples and estimates, publishes modes, verdicts and inertia
/// comparisons.
pub struct Supervisor {
    mission: Mission,
    state: State,
    /// Room of a frame, so that none takes memory.
    stimuli: Vec<Stimulus>,
    missing: Vec<NoModel>,
}

/// Builds the supervisor of `run`.
///
/// # Errors
/// When the scenario cannot be read, or a need names a parameter that its domain does not have.
pub fn connect(run: &RunConfig) -> Result<Box<dyn Partition>, ConnectError> {
    let scenario = Scenario::read(&run.scenario, &run.files, run.replay.is_some())
        .map_err(ConnectError::of(PartitionId::Supervisor))?;
    if let Some(craft) = &scenario.craft {
        let is_diagnosed = run.partitions.contains(&PartitionId::Diagnosis);
        let joint = joint::JointSupervisor::new(&scenario, craft, run.window_frames, is_diagnosed);
        return Ok(Box::new(joint.map_err(ConnectError::of(PartitionId::Supervisor))?));
    }
    let mission = Mission::new(run, &scenario).map_err(ConnectError::of(PartitionId::Supervisor))?;
    let state = State {
        machine: ModeMachine::new(mission.plan, run.window_frames),
        started: false,
        window: ExperimentWindow::default(),
        accepted: [None; 3],
        lost: [false; 3],
        source_lost: false,
        measured: Measured::new(&mission),
        free_arm: None,
        contact: None,
        ledger: Ledger::default(),
        inertias: Inertias::default(),
    };
    let (stimuli, missing) = (Vec::with_capacity(IN_A_FRAME), Vec::with_capacity(IN_A_FRAME));
    Ok(Box::new(Supervisor { mission, state, stimuli, missing }))
}

impl Partition for Supervisor {
    fn id(&self) -> PartitionId {
        PartitionId::Supervisor
    }

    fn inputs(&self) -> &'static [TopicId] {
        &[
            IMU.id,
            JOINTS.id,
            ACTUATORS.id,
            ACCELEROMETERS.id,
            ESTIMATE_INERTIAL.id,
            ESTIMATE_SLOSH.id,
            ESTIMATE_MODAL.id,
        ]
    }

    fn frame(&mut self, frame: &Frame<'_>, out: &mut Outputs) {
        self.note_lost(frame, out);
        self.state.window.step(frame, &[]);
        self.state.measured.take(frame, &self.state.window, &self.mission);
        self.watch_contact(frame);
        let mut stimuli = core::mem::take(&mut self.stimuli);
        stimuli.clear();
        if !self.state.started {
            self.state.started = true;
            stimuli.push(Stimulus::Start);
        }
        stimuli.extend(frame.mode_commands().filter_map(ordered));
        let modal = frame.samples(ESTIMATE_MODAL).iter().map(AnyEstimate::Modal);
        let slosh = frame.samples(ESTIMATE_SLOSH).iter().map(AnyEstimate::Slosh);
        let inertial = frame.samples(ESTIMATE_INERTIAL).iter().map(AnyEstimate::Inertial);
        for estimate in modal.chain(slosh).chain(inertial) {
            stimuli.extend(self.judge(estimate, frame, out));
        }
        let situation = self.situation(frame);
        let decision = self.state.machine.evaluate(frame.number, &stimuli, &situation);
        self.stimuli = stimuli;
        if let Some(decision) = &decision {
            out.publish(MODE, &decision.sample(frame.t_ns));
        }
        let (machine, plan) = (&self.state.machine, &self.mission.plan);
        let mut missing = core::mem::take(&mut self.missing);
        missing.clear();
        self.state.ledger.missing(decision.as_ref(), machine, plan, &situation, &mut missing);
        for &(domain, phase, why) in &missing {
            self.publish_verdict(&validation::no_model(domain, phase, why, frame.number, frame.t_ns), out);
        }
        self.missing = missing;
    }

    fn obeys_mode_commands(&self) -> bool {
        true
    }

    fn table(&self, table: TableId) -> Option<TableValues> {
        (table == TableId::Guards).then(|| guards_table::of(&self.mission.plan)).flatten()
    }

    fn activate(&mut self, table: TableId, values: &TableValues) {
        if table == TableId::Guards {
            guards_table::put(&mut self.mission.plan, values);
            self.state.machine.set_limits(&self.mission.plan);
        }
    }

    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        runtime::save_state(&self.state, state)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        self.state = runtime::restore_state(state)?;
        Ok(())
    }
}

impl Supervisor {
    /// A partition that was given up leaves a verdict on what it will not deliver.
    fn note_lost(&mut self, frame: &Frame<'_>, out: &mut Outputs) {
        for lost in frame.urgent.iter().filter_map(runtime::pacing::given_up) {
            self.state.source_lost |= lost == PartitionId::SensorSim;
            let Some(domain) = domain_of(lost) else { continue };
            let index = usize::from(domain.code());
            if !core::mem::replace(&mut self.state.lost[index], true) {
                let (phase, why) = (self.state.window.phase(), (Reason::PartitionLost, 0.0, 0.0));
                self.publish_verdict(&validation::no_model(domain, phase, why, frame.number, frame.t_ns), out);
            }
        }
    }

    fn publish_verdict(&mut self, verdict: &Verdict, out: &mut Outputs) {
        if let (Some(domain), Some(phase)) = (Domain::from_code(verdict.domain), Phase::from_code(verdict.phase)) {
            self.state.ledger.note(domain, phase);
        }
        out.publish(VERDICT, verdict);
    }

    /// Estimates are offered to the held-out test; the last one of an experiment is judged.
    fn judge(&mut self, sample: AnyEstimate<'_>, frame: &Frame<'_>, out: &mut Outputs) -> Option<Stimulus> {
        let (domain, estimate) = (sample.domain(), sample.common());
        let phase = Phase::from_code(estimate.phase)?;
        self.state.measured.offer(sample);
        if estimate.closing == 0 {
            return None;
        }
        let held_out = self.state.measured.close(domain, phase, &self.mission);
        let need = self.mission.need(domain, phase);
        let verdict = validation::validate(estimate, held_out, need, frame.number, frame.t_ns);
        let sigma_over_need = validation::sigma_over_need(estimate, need);
        self.publish_verdict(&verdict, out);
        if let Some(compared) = self.state.inertias.take(sample, &verdict, self.mission.modal.appendage.as_ref()) {
            out.publish(COMPARISON_INERTIA, &compared);
        }
        if domain == Domain::Inertial && phase != Phase::Mated {
            // A model that serves to look for contact need not be accepted: its covariance is taken
            // into account.
            self.state.free_arm = FreeArm::of(estimate).or(self.state.free_arm);
        }
        if verdict.accepted == 1 && phase != Phase::Mated {
            self.state.accepted[usize::from(domain.code())] = Some(Accepted { frame: frame.number, sigma_over_need });
        }
        let generation = estimate.innovation.generation as u32;
        Some(Stimulus::Verdict { domain, generation, accepted: verdict.accepted == 1 })
    }

    /// Contact is looked for while the target is in reach, in each mode against a baseline of its
    /// own.
    fn watch_contact(&mut self, frame: &Frame<'_>) {
        if frame.new_mode().is_some() {
            self.state.contact = watches(self.state.window.state).then(|| ContactDetector::new(self.state.free_arm));
        }
        let Some(detector) = &mut self.state.contact else { return };
        for (interval_s, sample) in self.state.measured.momentum() {
            let known = self.mission.arm(Phase::PreCapture);
            let sigma = known.map_or(contact::NOISE_UNKNOWN, |known| known.sigma(*interval_s));
            detector.push(frame.number, sample, &sigma);
        }
    }

    fn situation(&self, frame: &Frame<'_>) -> Situation {
        let state = &self.state;
        let mut situation = Situation {
            base_rate_rad_s: state.measured.base_rate_rad_s(),
            contact: measured_contact(state.contact.as_ref()),
            source_lost: state.source_lost,
            ..Situation::default()
        };
        for &domain in Domain::ALL {
            let index = usize::from(domain.code());
            let of = situation.of_mut(domain);
            of.inputs_alive = state.measured.inputs_alive(domain, frame.number);
            of.accepted_age_frames = state.accepted[index].map(|accepted| frame.number - accepted.frame);
            of.sigma_over_need = state.accepted[index].and_then(|accepted| accepted.sigma_over_need);
            of.predicted_sigma_over_need = self.mission.predicted_sigma_over_need[index];
            of.lost = state.lost[index];
        }
        situation
    }
}

/// What a command of the mode table is to the machine.
const fn ordered(opcode: Opcode) -> Option<Stimulus> {
    match opcode {
        Opcode::Safe => Some(Stimulus::SafeCommand),
        Opcode::Resume => Some(Stimulus::OperatorResume),
        Opcode::AllowCapture => Some(Stimulus::OperatorOverride),
        _ => None,
    }
}

/// The domain that a partition identifies.
const fn domain_of(partition: PartitionId) -> Option<Domain> {
    match partition {
        PartitionId::InertialId => Some(Domain::Inertial),
        PartitionId::SloshId => Some(Domain::Slosh),
        PartitionId::ModalId => Some(Domain::Modal),
        PartitionId::SensorSim | PartitionId::Supervisor | PartitionId::Recorder | PartitionId::Diagnosis => None,
    }
}

/// Modes in which the target is in reach.
const fn watches(state: ModeState) -> bool {
    matches!(state, ModeState::ApproachHold | ModeState::Capture)
}

fn measured_contact(detector: Option<&ContactDetector>) -> Option<ContactMeasure> {
    let contact = detector?.contact()?;
    Some(ContactMeasure { statistic: contact.statistic, limit: contact.limit })
}

#[cfg(test)]
mod tests {
    use super::*;
    use mode::{ExperimentPlan, Plan};
    use physics::momentum::{ChannelSigma, MomentumSample};
    use seeded_noise::SeededNoise;

    const WINDOW: u64 = 100;
    const GYRO_RAD_S: f64 = 2.6e-4;

    /// Flies approach and capture of an operator's override, no experiment before: the base turns
    /// with `rate_rad_s` of mode, frames since it took effect; a sample every ten frames while
    /// approaching, as the sensors of an idle vehicle give.
    fn approach(rate_rad_s: impl Fn(ModeState, u64) -> f64) -> Vec<(ModeState, mode::Event)> {
        let mated = Some(ExperimentPlan { duration_frames: 100, timeout_frames: 200, retries: 0 });
        let plan = Plan {
            modal: None,
            slosh: None,
            inertial: None,
            capture: true,
            mated,
            replay: None,
            settle_frames: 100,
            hold_timeout_frames: 500,
            capture_timeout_frames: 2000,
            safe_dwell_frames: 10,
            accepted_age_limit_frames: 1000,
            base_rate_limit_rad_s: 1.0,
            operator_override: true,
        };
        let mut machine = ModeMachine::new(plan, WINDOW);
        let mut noise = SeededNoise::new(1);
        let (mut in_force, mut pending) = ((ModeState::Standby, 0), None);
        let (mut detector, mut passed) = (None::<ContactDetector>, Vec::new());
        for frame in 0..5000 {
            if let Some((state, effective)) = pending.filter(|(_, effective)| *effective == frame) {
                in_force = (state, effective);
                detector = watches(state).then(|| ContactDetector::new(None));
            }
            let (state, since) = in_force;
            if state == ModeState::Capture || frame % 10 == 0 {
                let omega0_z_rad_s = rate_rad_s(state, frame - since) + GYRO_RAD_S * noise.normal();
                let sample = MomentumSample { omega0_z_rad_s, ..MomentumSample::default() };
                let sigma = ChannelSigma { omega0_rad_s: GYRO_RAD_S, ..contact::NOISE_UNKNOWN };
                detector.iter_mut().for_each(|detector| _ = detector.push(frame, &sample, &sigma));
            }
            let stimuli = if frame == 0 { vec![Stimulus::Start] } else { Vec::new() };
            let mut situation = Situation {
                contact: measured_contact(detector.as_ref()),
                base_rate_rad_s: 0.1,
                ..Situation::default()
            };
            situation.of_mut(Domain::Inertial).inputs_alive = true;
            if let Some(decision) = machine.evaluate(frame, &stimuli, &situation) {
                pending = Some((decision.to, decision.effective_frame));
                passed.push((decision.to, decision.event));
            }
        }
        passed
    }

    #[test]
    fn capture_by_override_without_any_model_passes_by_contact() {
        // At rest while idle, another system in CAPTURE: no contact by that. Then the grasp slows
        // the base.
        let passed = approach(|state, since| match state {
            ModeState::Capture if since < 200 => 0.17,
            ModeState::Capture => 0.04,
            _ => 0.0,
        });
        let to: Vec<ModeState> = passed.iter().map(|decision| decision.0).collect();
        assert_eq!(to[..3], [ModeState::ApproachHold, ModeState::Capture, ModeState::MatedSettle]);
        assert_eq!(passed[2].1, mode::Event::ContactSeen);
        let without = approach(|state, _| if state == ModeState::Capture { 0.17 } else { 0.0 });
        assert_eq!(without[2], (ModeState::Safe, mode::Event::Timeout), "no grasp, no contact");
    }

    #[test]
    fn contact_while_approaching_is_a_collision_and_makes_safe() {
        let passed = approach(|state, since| if state == ModeState::ApproachHold && since >= 90 { 0.02 } else { 0.0 });
        assert_eq!(passed[2], (ModeState::Safe, mode::Event::ContactSeen));
    }
}
