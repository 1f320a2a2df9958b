//! Inertial parameters from the conservation of angular momentum: BP1A before capture, nine parameters mated.
//!
//! May import: physics, estimation, runtime, telemetry. Must never know: the plant, recordings.
#![forbid(unsafe_code)]

use nalgebra::{SMatrix, SVector};
use physics::inertial_estimator::{InertialEstimator, InertialSettings};
use physics::momentum::{ChannelSigma, MomentumSample};
use runtime::experiment::{ExperimentWindow, Step};
use runtime::scenario::{ArmExperiment, ArmKnown};
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use serde::{Deserialize, Serialize};
use telemetry::{
    Domain, ESTIMATE_INERTIAL, Estimate, Experiment, IMU, Innovation, JOINTS, PartitionId, Sample, TopicId,
};

/// An estimate goes out every so many frames of an experiment.
const ESTIMATE_EVERY_FRAMES: u64 = 100;
/// Prior: a number to start from, information 1e-6/a².
const PRIOR_RELATIVE_SD: f64 = 1000.0;
/// Innovations beyond this many sigma are counted as not accepted by the record; the estimator uses them all.
const GATE_SIGMA: f64 = 5.0;
const RATE_VALID_Z: u64 = 1 << 2;

/// The estimator of the phase: eight parameters before capture, nine with a target.
#[derive(Clone, Serialize, Deserialize)]
enum Estimator {
    FreeFloating(Box<InertialEstimator<8>>),
    Mated(Box<InertialEstimator<9>>),
}

#[derive(Clone, Default, Serialize, Deserialize)]
struct State {
    window: ExperimentWindow,
    estimator: Option<Estimator>,
    rows: u32,
    last: Option<[f64; 4]>,
}

/// The partition.
pub struct InertialId {
    state: State,
    free_floating: Option<ArmKnown>,
    mated: Option<ArmKnown>,
    replays: bool,
}

/// Builds the partition of `run`.
///
/// # Errors
/// None: what is not known is refused when an experiment asks for it.
pub fn connect(run: &RunConfig) -> Result<Box<dyn Partition>, ConnectError> {
    let known = |arm: &Option<ArmExperiment>| arm.as_ref().map(|arm| arm.known.clone());
    Ok(Box::new(InertialId {
        state: State::default(),
        free_floating: known(&run.scenario.inertial),
        mated: known(&run.scenario.mated),
        replays: run.replay.as_ref().is_some_and(|replay| replay.inertial),
    }))
}

impl Partition for InertialId {
    fn id(&self) -> PartitionId {
        PartitionId::InertialId
    }

    fn inputs(&self) -> &'static [TopicId] {
        &[IMU.id, JOINTS.id]
    }

    fn frame(&mut self, frame: &Frame<'_>, out: &mut Outputs) {
        let mine: &[Experiment] = match self.replays {
            true => &[Experiment::Inertial, Experiment::MatedInertial, Experiment::Replay],
            false => &[Experiment::Inertial, Experiment::MatedInertial],
        };
        match self.state.window.step(frame, mine) {
            Step::Idle => {}
            Step::Abort => self.state.estimator = None,
            Step::Begin => {
                self.begin();
                self.take(frame);
            }
            Step::Go => {
                self.take(frame);
                if (self.state.window.elapsed(frame) + 1).is_multiple_of(ESTIMATE_EVERY_FRAMES) {
                    self.publish(frame, false, out);
                }
            }
            Step::Close => {
                self.publish(frame, true, out);
                // What is closed need not be carried from checkpoint to checkpoint.
                self.state.estimator = None;
            }
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

impl InertialId {
    /// A fresh estimator for the phase that begins; none where momentum or prior are not known.
    fn begin(&mut self) {
        let mated = self.state.window.experiment == Experiment::MatedInertial;
        let free = self.free_floating.as_ref().filter(|_| !mated);
        self.state.estimator = match (free, self.mated.as_ref()) {
            (Some(known), _) => {
                InertialEstimator::new(&settings::<8>(known)).ok().map(|e| Estimator::FreeFloating(Box::new(e)))
            }
            (None, Some(known)) => {
                InertialEstimator::new(&settings::<9>(known)).ok().map(|e| Estimator::Mated(Box::new(e)))
            }
            (None, None) => None,
        };
        self.state.rows = 0;
        self.state.last = None;
    }

    /// Pairs rates and joints of the same time; a sample without its partner is not used.
    fn take(&mut self, frame: &Frame<'_>) {
        let joints = frame.samples(JOINTS);
        for imu in frame.samples(IMU).iter().filter(|imu| imu.valid & RATE_VALID_Z != 0) {
            let Some(joints) = joints.iter().find(|j| j.header.t_meas_ns == imu.header.t_meas_ns && j.count >= 2)
            else {
                continue;
            };
            let sample = MomentumSample {
                omega0_z_rad_s: imu.omega_bi_b_rad_s[2],
                joint_rate_rad_s: [joints.rate_rad_s[0], joints.rate_rad_s[1]],
                joint_angle_rad: [joints.angle_rad[0], joints.angle_rad[1]],
            };
            let innovation = match &mut self.state.estimator {
                Some(Estimator::FreeFloating(estimator)) => estimator.push(&sample),
                Some(Estimator::Mated(estimator)) => estimator.push(&sample),
                None => return,
            };
            if let Ok(innovation) = innovation {
                self.state.rows += 1;
                self.state.last = Some([imu.header.t_meas_ns as f64, innovation.innovation, innovation.variance, 0.0]);
            }
        }
    }

    fn publish(&mut self, frame: &Frame<'_>, closing: bool, out: &mut Outputs) {
        let mut sample = Estimate::zeroed_at(frame.t_ns);
        sample.frame = frame.number;
        sample.domain = Domain::Inertial.code();
        sample.phase = self.state.window.phase().code();
        sample.closing = u16::from(closing);
        match &self.state.estimator {
            Some(Estimator::FreeFloating(estimator)) => fill(&mut sample, estimator),
            Some(Estimator::Mated(estimator)) => fill(&mut sample, estimator),
            None => sample.status = 1,
        }
        sample.innovation = self.innovation();
        out.publish(ESTIMATE_INERTIAL, &sample);
    }

    fn innovation(&self) -> Innovation {
        let [t_ns, innovation, variance, _] = self.state.last.unwrap_or([0.0, 0.0, 1.0, 0.0]);
        let test_ratio = innovation * innovation / (GATE_SIGMA * GATE_SIGMA * variance);
        Innovation {
            t_ns: t_ns as u64,
            innovation,
            variance,
            test_ratio,
            gate: GATE_SIGMA,
            accepted: u32::from(test_ratio <= 1.0),
            rows: self.state.rows,
            generation: self.state.window.generation.into(),
        }
    }
}

fn settings<const P: usize>(known: &ArmKnown) -> InertialSettings<P> {
    let gyro = known.gyro_arw_deg_sqrt_h.to_radians() / 60.0 * known.rate_hz.sqrt();
    InertialSettings {
        h_nms: known.h_cm_nms,
        sigma_h_nms: known.h_cm_sigma_nms,
        sigma: ChannelSigma {
            omega0_rad_s: gyro,
            joint_rate_rad_s: [known.joint_rate_sigma_rad_s; 2],
            joint_angle_rad: [known.joint_angle_sigma_rad; 2],
        },
        prior_alpha: SVector::from_fn(|i, _| known.prior.get(i).copied().unwrap_or(0.0)),
        prior_relative_sd: PRIOR_RELATIVE_SD,
    }
}

fn fill<const P: usize>(sample: &mut Estimate, estimator: &InertialEstimator<P>) {
    let Ok(estimate) = estimator.estimate() else {
        sample.status = 2;
        return;
    };
    let (alpha, covariance): (SVector<f64, P>, SMatrix<f64, P, P>) = (estimate.alpha, estimate.covariance);
    sample.count = P as u16;
    for i in 0..P {
        sample.values[i] = alpha[i];
        for j in 0..P {
            sample.covariance[i][j] = covariance[(i, j)];
        }
    }
    sample.consistent = u32::from(estimate.consistent);
    sample.nis_mean = estimate.nis.per_degree().unwrap_or(0.0);
    sample.nis_count = estimate.nis.count() as f64;
    for (scale, verdict) in estimate.whiteness.verdicts().iter().enumerate() {
        sample.block_length[scale] = verdict.block_samples.into();
        sample.block_z[scale] = verdict.z_score;
    }
}
