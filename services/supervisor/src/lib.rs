//! Supervisor: which experiment is flown when, which model is believed, and whether the target is on the arm.
//!
//! May import: telemetry, estimation, physics, runtime. Must never know: how a plant is simulated, another service, a
//! clock, a file.
//!
//! | file | subject |
//! |---|---|
//! | `mode` | the mode table and the machine that evaluates it, once a frame |
//! | `validation` | two verdicts on a model: complete, adequate |
//! | `held_out` | the last fifth of an experiment, simulated with an estimate that never saw it |
//! | `contact` | contact recognised from momentum, or from the ninth parameter |
//! | `mission` | from the scenario to the plan, the needs and the predictions |
//! | `measured` | what the samples of a frame say: base rate, who is alive, rows held out |

#![forbid(unsafe_code)]

pub mod contact;
pub mod held_out;
mod measured;
mod mission;
pub mod mode;
#[cfg(test)]
mod seeded_noise;
pub mod validation;

use contact::{ContactDetector, FalseAlarm, FreeArm};
use measured::Measured;
use mission::Mission;
use mode::{ContactMeasure, ModeMachine, Situation, Stimulus};
use nalgebra::{SMatrix, SVector};
use runtime::experiment::ExperimentWindow;
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use serde::{Deserialize, Serialize};
use telemetry::{
    ACCELEROMETERS, ACTUATORS, Domain, ESTIMATE_INERTIAL, ESTIMATE_MODAL, ESTIMATE_SLOSH, Estimate, IMU, JOINTS, MODE,
    ModeState, PartitionId, Phase, Reason, TopicId, VERDICT,
};

/// False alarms of the momentum test: one in a thousand captures of up to 1e5 samples.
const MOMENTUM_FALSE_ALARM: FalseAlarm = FalseAlarm { probability: 1e-3, samples: 1e5 };
/// False alarms of the ninth parameter: one in a thousand over the looks of a mated experiment.
const NINTH_FALSE_ALARM: FalseAlarm = FalseAlarm { probability: 1e-3, samples: 1e3 };

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
    free_arm: Option<FreeArm>,
    contact: ContactDetector,
}

/// The partition.
pub struct Supervisor {
    mission: Mission,
    state: State,
}

/// Builds the supervisor of `run`.
///
/// # Errors
/// When a need names a parameter that its domain does not have.
pub fn connect(run: &RunConfig) -> Result<Box<dyn Partition>, ConnectError> {
    let fail = |reason| ConnectError { partition: PartitionId::Supervisor, reason };
    let mission = Mission::new(run).map_err(fail)?;
    let state = State {
        machine: ModeMachine::new(mission.plan, run.window_frames),
        started: false,
        window: ExperimentWindow::default(),
        accepted: [None; 3],
        lost: [false; 3],
        source_lost: false,
        measured: Measured::new(&mission),
        free_arm: None,
        contact: ContactDetector::new(MOMENTUM_FALSE_ALARM, NINTH_FALSE_ALARM),
    };
    Ok(Box::new(Supervisor { mission, state }))
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
        let mut stimuli = Vec::new();
        if !self.state.started {
            self.state.started = true;
            stimuli.push(Stimulus::Start);
        }
        for estimate in
            [ESTIMATE_MODAL, ESTIMATE_SLOSH, ESTIMATE_INERTIAL].into_iter().flat_map(|topic| frame.samples(topic))
        {
            stimuli.extend(self.judge(estimate, frame, out));
        }
        let situation = self.situation(frame);
        if let Some(decision) = self.state.machine.evaluate(frame.number, &stimuli, &situation) {
            out.publish(MODE, &decision.sample(frame.t_ns));
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
            let domain = match lost {
                PartitionId::InertialId => Domain::Inertial,
                PartitionId::SloshId => Domain::Slosh,
                PartitionId::ModalId => Domain::Modal,
                PartitionId::SensorSim => {
                    self.state.source_lost = true;
                    continue;
                }
                PartitionId::Supervisor | PartitionId::Recorder => continue,
            };
            let index = usize::from(domain.code());
            if !core::mem::replace(&mut self.state.lost[index], true) {
                let phase = self.state.window.phase();
                out.publish(
                    VERDICT,
                    &validation::no_model(domain, phase, Reason::PartitionLost, frame.number, frame.t_ns),
                );
            }
        }
    }

    /// Estimates are offered to the held-out test; the last one of an experiment is judged.
    fn judge(&mut self, estimate: &Estimate, frame: &Frame<'_>, out: &mut Outputs) -> Option<Stimulus> {
        let domain = Domain::from_code(estimate.domain)?;
        let phase = Phase::from_code(estimate.phase)?;
        self.state.measured.offer(domain, estimate);
        if estimate.closing == 0 {
            return None;
        }
        let held_out = self.state.measured.close(domain, phase, &self.mission);
        let need = self.mission.need(domain, phase);
        let verdict = validation::validate(estimate, held_out.as_ref(), need, frame.number, frame.t_ns);
        out.publish(VERDICT, &verdict);
        if verdict.accepted == 1 && phase != Phase::Mated {
            let sigma_over_need = validation::sigma_over_need(estimate, need);
            self.state.accepted[usize::from(domain.code())] = Some(Accepted { frame: frame.number, sigma_over_need });
            self.keep_free_arm(domain, estimate);
        }
        let generation = estimate.innovation.generation as u32;
        Some(Stimulus::Verdict { domain, generation, accepted: verdict.accepted == 1 })
    }

    /// The model against which contact shows.
    fn keep_free_arm(&mut self, domain: Domain, estimate: &Estimate) {
        let Some(known) = self.mission.inertial.as_ref().filter(|_| domain == Domain::Inertial && estimate.count == 8)
        else {
            return;
        };
        self.state.free_arm = Some(FreeArm {
            alpha: SVector::from_fn(|i, _| estimate.values[i]),
            covariance: SMatrix::from_fn(|i, j| estimate.covariance[i][j]),
            h_nms: known.h_nms,
            sigma: known.sigma,
        });
    }

    /// Contact is looked for while the target is in reach.
    fn watch_contact(&mut self, frame: &Frame<'_>) {
        if !matches!(self.state.window.state, ModeState::ApproachHold | ModeState::Capture) {
            return;
        }
        let Some(arm) = &self.state.free_arm else { return };
        if self.state.window.state == ModeState::Capture {
            for (_, sample) in self.state.measured.momentum() {
                self.state.contact.push(frame.number, &arm.residual(sample));
            }
        }
    }

    fn situation(&self, frame: &Frame<'_>) -> Situation {
        let state = &self.state;
        let mut situation = Situation {
            base_rate_rad_s: state.measured.base_rate_rad_s(),
            contact: state
                .contact
                .contact()
                .map(|contact| ContactMeasure { statistic: contact.statistic, limit: contact.limit }),
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
