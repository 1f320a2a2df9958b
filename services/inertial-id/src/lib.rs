//! Inertial parameters from the conservation of angular momentum: BP1A before capture, nine parameters mated.
//!
//! May import: physics, estimation, runtime, telemetry. Must never know: the plant, recordings.
#![forbid(unsafe_code)]

use nalgebra::{SMatrix, SVector};
use physics::inertial_estimator::{InertialEstimator, InertialSettings};
use physics::momentum::{ChannelSigma, MomentumSample};
use runtime::experiment::{ExperimentWindow, Step};
use runtime::pairs::rates_with_joints;
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
/// Innovations beyond this many sigma are marked as not accepted in the record; the estimator uses them all.
const GATE_SIGMA: f64 = estimation::GATE_SIGMAS;
/// `Estimate::status`, see `telemetry::status_text`.
const NOT_KNOWN: u32 = 1;
const NOT_EXCITED: u32 = 2;
const NO_SAMPLES: u32 = 3;

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
    last: Option<(u64, estimation::Innovation)>,
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
                self.state = State { window: self.state.window, ..State::default() };
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
    /// The first sample says over what interval the gyro averages, and with it how noisy it is: then the estimator is made.
    fn take(&mut self, frame: &Frame<'_>) {
        for (imu, joints) in rates_with_joints(frame) {
            let sample = MomentumSample {
                omega0_z_rad_s: imu.omega_bi_b_rad_s[2],
                joint_rate_rad_s: [joints.rate_rad_s[0], joints.rate_rad_s[1]],
                joint_angle_rad: [joints.angle_rad[0], joints.angle_rad[1]],
            };
            if self.state.rows == 0 {
                self.state.estimator = self.fresh_estimator(imu.interval_s);
            }
            let innovation = match &mut self.state.estimator {
                Some(Estimator::FreeFloating(estimator)) => estimator.push(&sample),
                Some(Estimator::Mated(estimator)) => estimator.push(&sample),
                None => return,
            };
            if let Ok(innovation) = innovation {
                self.state.rows += 1;
                self.state.last = Some((imu.header.t_meas_ns, innovation));
            }
        }
    }

    /// Eight parameters before capture, nine with a target; none where momentum or prior are not known.
    fn fresh_estimator(&self, interval_s: f64) -> Option<Estimator> {
        let mated = self.state.window.experiment == Experiment::MatedInertial;
        let free = self.free_floating.as_ref().filter(|_| !mated);
        match (free, self.mated.as_ref()) {
            (Some(known), _) => InertialEstimator::new(&settings::<8>(known, interval_s))
                .ok()
                .map(|e| Estimator::FreeFloating(Box::new(e))),
            (None, Some(known)) => {
                InertialEstimator::new(&settings::<9>(known, interval_s)).ok().map(|e| Estimator::Mated(Box::new(e)))
            }
            (None, None) => None,
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
            None if self.free_floating.is_none() && self.mated.is_none() => sample.status = NOT_KNOWN,
            None => sample.status = NO_SAMPLES,
        }
        sample.innovation = self.innovation();
        out.publish(ESTIMATE_INERTIAL, &sample);
    }

    fn innovation(&self) -> Innovation {
        let Some((t_ns, last)) = self.state.last else {
            return Innovation {
                gate: GATE_SIGMA,
                generation: self.state.window.generation.into(),
                ..Innovation::default()
            };
        };
        Innovation {
            t_ns,
            innovation: last.innovation,
            variance: last.variance,
            test_ratio: last.test_ratio,
            gate: GATE_SIGMA,
            accepted: u32::from(last.test_ratio <= 1.0),
            rows: self.state.rows,
            generation: self.state.window.generation.into(),
        }
    }
}

fn settings<const P: usize>(known: &ArmKnown, interval_s: f64) -> InertialSettings<P> {
    InertialSettings {
        h_nms: known.h_cm_nms,
        sigma_h_nms: known.h_cm_sigma_nms,
        sigma: ChannelSigma::from_data_sheet(
            known.gyro_arw_deg_sqrt_h,
            interval_s,
            known.joint_rate_sigma_rad_s,
            known.joint_angle_sigma_rad,
        ),
        prior_alpha: SVector::from_fn(|i, _| known.prior.get(i).copied().unwrap_or(0.0)),
        prior_relative_sd: PRIOR_RELATIVE_SD,
    }
}

fn fill<const P: usize>(sample: &mut Estimate, estimator: &InertialEstimator<P>) {
    let Ok(estimate) = estimator.estimate() else {
        sample.status = NOT_EXCITED;
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
