//! What it is: estimation of the arm's inertial parameters, eight before capture (BP1A) and nine
//! mated: from the conservation of angular momentum and, where torques are measured, from the
//! equations of motion, which need no momentum. After capture it also estimates the target's own
//! parameters.
//!
//! ```no_run
//! use runtime::rundir::RunDir;
//! use telemetry::{PartitionId, TOPICS};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // The folder of a run, as `obsid run` makes it.
//! let folder = std::env::args_os().nth(1).ok_or("no folder of a run")?;
//! let run = RunDir::at(folder.as_ref()).load()?;
//! let partition = inertial_id::connect(&run)?;
//! assert_eq!(partition.id(), PartitionId::InertialId);
//! for topic in partition.inputs() {
//!     println!("{}: {}", TOPICS[*topic].name, TOPICS[*topic].rate);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! May import: physics, estimation, craft, plant_file, runtime, telemetry.
//!
//! Must never know: how a plant is simulated, recordings.
#![forbid(unsafe_code)]

mod target;

use estimation::GATE_SIGMAS;
use estimation::identifiability::Identifiability;
use nalgebra::{SMatrix, SVector};
use physics::arm_live::{LiveEstimators, LiveSettings, SCALE_SD};
use physics::consider::SensorSheet;
use physics::dynamic_equation::ArmSample;
use physics::inertial_estimator::InertialSettings;
use physics::momentum::{ChannelSigma, MomentumSample, is_physically_consistent};
use plant_file::scenario::{ArmExperiment, ArmKnown, Scenario};
use runtime::experiment::{ExperimentWindow, Step};
use runtime::pairs::rates_with_joints;
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use serde::{Deserialize, Serialize};
use telemetry::{
    Domain, ESTIMATE_INERTIAL, ESTIMATE_INERTIAL_TORQUE, ESTIMATE_TARGET, Estimate, Experiment, IMU, Imu,
    InertialEstimate, InertialStatus, Innovation, JOINTS, Joints, PartitionId, Sample, TopicId,
};

/// Time between two estimates of an experiment [frames].
const ESTIMATE_EVERY_FRAMES: u64 = 100;
/// Rows whose median interval is the sample interval: a single one may be late, or the first of a
/// recording.
const FIRST_ROWS: usize = 11;
/// Bits of `Joints::torque_valid` that the equations of motion need.
const BOTH_TORQUES: u64 = 0b11;
/// Standard deviation of the prior over the parameter: a starting value with information 1e-6/a².
const PRIOR_RELATIVE_SD: f64 = 1000.0;

/// The estimators of the phase: eight parameters before capture, nine with a target. In place: an
/// experiment takes no memory.
#[derive(Clone, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)]
enum Estimators {
    FreeFloating(LiveEstimators<8, 13>),
    Mated(LiveEstimators<9, 14>),
}

#[derive(Clone, Default, Serialize, Deserialize)]
struct State {
    window: ExperimentWindow,
    estimators: Option<Estimators>,
    /// Rows of an experiment that wait until their interval is known.
    first: [FirstRow; FIRST_ROWS],
    waiting: usize,
    rows: u32,
    last: Option<(u64, estimation::Innovation)>,
    /// The last estimate before capture: what the target's is taken from.
    before: Option<target::Before>,
}

/// A row, its time and the interval that its gyro averages over.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct FirstRow {
    t_ns: u64,
    interval_s: f64,
    sample: ArmSample,
}

/// The partition: fed with rates, joint angles and torques of an experiment, it publishes estimates
/// of the arm and of the target.
pub struct InertialId {
    state: State,
    free_floating: Option<ArmKnown>,
    mated: Option<ArmKnown>,
    replays: bool,
}

/// Builds the partition of `run`.
///
/// # Errors
/// When the scenario cannot be read; values that it lacks are reported by the status of an estimate
/// once an experiment needs them.
pub fn connect(run: &RunConfig) -> Result<Box<dyn Partition>, ConnectError> {
    let scenario = Scenario::read(&run.scenario, &run.files, run.replay.is_some())
        .map_err(ConnectError::of(PartitionId::InertialId))?;
    if let Some(plan) = &scenario.craft {
        let keeper = craft::keeper::Keeper::new(PartitionId::InertialId, Domain::Inertial, plan);
        return Ok(Box::new(keeper.map_err(ConnectError::of(PartitionId::InertialId))?));
    }
    let known = |arm: &Option<ArmExperiment>| arm.as_ref().map(|arm| arm.known.clone());
    Ok(Box::new(InertialId {
        state: State::default(),
        free_floating: known(&scenario.inertial),
        mated: known(&scenario.mated),
        replays: run.replay.as_ref().is_some_and(|replay| replay.identifies(Domain::Inertial)),
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
            Step::Abort => self.state.estimators = None,
            Step::Begin => {
                self.state.estimators = None;
                (self.state.waiting, self.state.rows, self.state.last) = (0, 0, None);
                self.take(frame);
            }
            Step::Go => {
                self.take(frame);
                if (self.state.window.elapsed(frame) + 1).is_multiple_of(ESTIMATE_EVERY_FRAMES) {
                    self.publish(frame, false, out);
                }
            }
            Step::Close => {
                self.take_first();
                self.publish(frame, true, out);
                self.weigh_target(frame, out);
                // What is closed need not be carried from checkpoint to checkpoint.
                self.state.estimators = None;
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
    /// The first rows say over what interval the gyro averages, and with it how noisy it is: then
    /// the estimators are made.
    fn take(&mut self, frame: &Frame<'_>) {
        for (imu, joints) in rates_with_joints(frame) {
            self.take_row(imu, joints);
        }
    }

    fn take_row(&mut self, imu: &Imu, joints: &Joints) {
        let motion = MomentumSample {
            omega0_z_rad_s: imu.omega_bi_b_rad_s[2],
            joint_rate_rad_s: [joints.rate_rad_s[0], joints.rate_rad_s[1]],
            joint_angle_rad: [joints.angle_rad[0], joints.angle_rad[1]],
        };
        // a torque that was not measured is no number: it interrupts the filter, not the momentum
        let measured = joints.torque_valid & BOTH_TORQUES == BOTH_TORQUES;
        let torque_n_m = if measured { [joints.torque_nm[0], joints.torque_nm[1]] } else { [f64::NAN; 2] };
        let (t_ns, sample) = (imu.header.t_meas_ns, ArmSample { motion, torque_n_m });
        if self.state.waiting < FIRST_ROWS {
            self.state.first[self.state.waiting] = FirstRow { t_ns, interval_s: imu.interval_s, sample };
            self.state.waiting += 1;
            if self.state.waiting == FIRST_ROWS {
                self.take_first();
            }
        } else {
            self.push(t_ns, &sample);
        }
    }

    /// Makes the estimators from the rows that wait, and gives them these; of a record that is
    /// shorter, at its end.
    fn take_first(&mut self) {
        let rows = self.state.first;
        let rows = &rows[..self.state.waiting];
        if rows.is_empty() || self.state.estimators.is_some() {
            return;
        }
        self.make_estimators(median(rows.iter().map(|row| row.interval_s)));
        rows.iter().for_each(|row| self.push(row.t_ns, &row.sample));
    }

    fn push(&mut self, t_ns: u64, sample: &ArmSample) {
        let innovation = match &mut self.state.estimators {
            Some(Estimators::FreeFloating(live)) => live.push(t_ns, sample),
            Some(Estimators::Mated(live)) => live.push(t_ns, sample),
            None => return,
        };
        if let Ok(innovation) = innovation {
            self.state.rows += 1;
            self.state.last = Some((t_ns, innovation));
        }
    }

    fn is_mated(&self) -> bool {
        self.state.window.experiment == Experiment::MatedInertial
    }

    /// Values that the scenario specifies for the present phase.
    fn known(&self) -> Option<&ArmKnown> {
        self.free_floating.as_ref().filter(|_| !self.is_mated()).or(self.mated.as_ref())
    }

    /// The scenario specifies momentum and prior.
    fn has_momentum_and_prior(&self) -> bool {
        let known = self.known();
        known.is_some_and(|known| known.h_cm_sigma_nms < known.h_cm_nms.abs() && known.prior.iter().any(|a| *a != 0.0))
    }

    /// Eight parameters before capture, nine with a target; none where momentum or prior are not
    /// known.
    fn make_estimators(&mut self, interval_s: f64) {
        let eight = !self.is_mated() && self.free_floating.is_some();
        self.state.estimators =
            self.known().filter(|_| interval_s > 0.0 && self.has_momentum_and_prior()).and_then(|known| {
                if eight {
                    LiveEstimators::new(&settings(known, interval_s)).ok().map(Estimators::FreeFloating)
                } else {
                    LiveEstimators::new(&settings(known, interval_s)).ok().map(Estimators::Mated)
                }
            });
    }

    fn empty(&self, frame: &Frame<'_>, closing: bool) -> InertialEstimate {
        let mut sample = InertialEstimate::zeroed_at(frame.t_ns);
        let estimate = &mut sample.estimate;
        (estimate.frame, estimate.domain) = (frame.number, Domain::Inertial.code());
        (estimate.phase, estimate.closing) = (self.state.window.phase().code(), u16::from(closing));
        sample
    }

    fn publish(&mut self, frame: &Frame<'_>, closing: bool, out: &mut Outputs) {
        let (mut sample, mut torque) = (self.empty(frame, closing), self.empty(frame, closing));
        let why = if self.has_momentum_and_prior() { InertialStatus::NoSamples } else { InertialStatus::NotKnown };
        match (&self.state.estimators, self.known()) {
            (Some(Estimators::FreeFloating(live)), Some(known)) => {
                fill(&mut sample, live, known);
                fill_torque(&mut torque, live, known);
                // a record that was aborted, or has no known momentum and prior, does not replace
                // an earlier one
                let before = closing.then(|| target::Before::of(live, &sheet(known))).flatten();
                self.state.before = before.or(self.state.before);
            }
            (Some(Estimators::Mated(live)), Some(known)) => {
                fill(&mut sample, live, known);
                fill_torque(&mut torque, live, known);
            }
            _ => [&mut sample, &mut torque].into_iter().for_each(|none| none.estimate.status = why.code().into()),
        }
        sample.estimate.innovation = self.innovation();
        torque.estimate.innovation.generation = self.state.window.generation.into();
        out.publish(ESTIMATE_INERTIAL, &sample);
        out.publish(ESTIMATE_INERTIAL_TORQUE, &torque);
    }

    /// After capture, where the arm's data sheet is stated.
    fn weigh_target(&self, frame: &Frame<'_>, out: &mut Outputs) {
        let (Some(Estimators::Mated(after)), Some(known)) = (&self.state.estimators, self.known()) else { return };
        let Some(chaser) = &known.chaser else { return };
        for mut sample in
            target::samples(chaser, known.target.as_ref(), self.state.before.as_ref(), (after, &sheet(known)))
        {
            sample.header = telemetry::Header::at(frame.t_ns);
            sample.frame = frame.number;
            out.publish(ESTIMATE_TARGET, &sample);
        }
    }

    fn innovation(&self) -> Innovation {
        let Some((t_ns, last)) = self.state.last else {
            return Innovation {
                gate: GATE_SIGMAS,
                generation: self.state.window.generation.into(),
                ..Innovation::default()
            };
        };
        Innovation {
            t_ns,
            innovation: last.innovation,
            variance: last.variance,
            test_ratio: last.test_ratio,
            gate: GATE_SIGMAS,
            accepted: u32::from(last.test_ratio <= 1.0),
            rows: self.state.rows,
            generation: self.state.window.generation.into(),
        }
    }
}

/// Of at most [`FIRST_ROWS`] intervals, the upper of the two in the middle; one that is no interval
/// does not count. 0: there is none. An interval that was measured, not one half way between two as
/// of `estimation::quantiles`: of a row in time and a late one it must not be the mean.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sorted, mut count) = ([f64::INFINITY; FIRST_ROWS], 0);
    for (slot, value) in sorted.iter_mut().zip(values.filter(|value| value.is_finite() && *value > 0.0)) {
        *slot = value;
        count += 1;
    }
    sorted.sort_by(f64::total_cmp);
    if count > 0 { sorted[count / 2] } else { 0.0 }
}

fn settings<const P: usize>(known: &ArmKnown, interval_s: f64) -> LiveSettings<P> {
    let momentum = InertialSettings {
        h_nms: known.h_cm_nms,
        sigma_h_nms: known.h_cm_sigma_nms,
        sigma: ChannelSigma::from_data_sheet(
            known.gyro_arw_deg_sqrt_h,
            interval_s,
            known.joint_rate_sigma_rad_s,
            known.joint_angle_sigma_rad,
        ),
        prior_alpha: SVector::from_fn(|i, _| known.prior.get(i).copied().unwrap_or(0.0)),
        prior_relative_sd: known.prior_relative_sd.unwrap_or(PRIOR_RELATIVE_SD),
    };
    LiveSettings {
        momentum,
        torque_sigma_n_m: known.joint_torque_sigma_nm,
        torque_scale_sd: known.joint_torque_scale_sigma,
        interval_ns: (interval_s * 1e9).round().max(1.0) as u64,
    }
}

fn sheet(known: &ArmKnown) -> SensorSheet {
    let stated = &known.sheet;
    SensorSheet {
        gyro_bias_rad_s: stated.gyro_bias_rad_s,
        gyro_scale: stated.gyro_scale,
        joint_rate_scale: [stated.joint_rate_scale; 2],
        joint_zero_rad: [stated.joint_zero_rad; 2],
        latency_s: stated.latency_s,
    }
}

fn put<const P: usize>(sample: &mut Estimate, alpha: &SVector<f64, P>, covariance: &SMatrix<f64, P, P>) {
    sample.count = P as u16;
    for i in 0..P {
        sample.values[i] = alpha[i];
        for j in 0..P {
            sample.covariance[i][j] = covariance[(i, j)];
        }
    }
    sample.consistent = u32::from(is_physically_consistent(alpha));
}

/// The momentum's estimate, the systematic error that the sensors' data sheet allows (NaN: not
/// known), and the identifiability against the prior.
fn fill<const P: usize, const X: usize>(sample: &mut InertialEstimate, live: &LiveEstimators<P, X>, known: &ArmKnown) {
    let common = &mut sample.estimate;
    let Ok(estimate) = live.estimate() else {
        common.status = InertialStatus::NotExcited.code().into();
        return;
    };
    put(common, &estimate.alpha, &estimate.covariance);
    common.nis_mean = estimate.nis.per_degree().unwrap_or(0.0);
    common.nis_count = estimate.nis.count() as f64;
    for (scale, verdict) in estimate.whiteness.verdicts().iter().enumerate() {
        common.block_length[scale] = verdict.block_samples.into();
        common.block_z[scale] = verdict.z_score;
    }
    let prior = live.prior_sd();
    for i in 0..P {
        common.identifiability[i] = Identifiability::of(estimate.noise_covariance[(i, i)].sqrt(), prior[i]).code();
    }
    let consider = live.consider(&sheet(known));
    for (i, sigma) in sample.consider_sigma_kg_m2.iter_mut().take(P).enumerate() {
        *sigma = consider.map_or(f64::NAN, |consider| consider[(i, i)].sqrt());
    }
}

/// The torques' estimate. The effect of systematic errors that the sensors' data sheet states is
/// not known (NaN).
fn fill_torque<const P: usize, const X: usize>(
    sample: &mut InertialEstimate,
    live: &LiveEstimators<P, X>,
    known: &ArmKnown,
) {
    let common = &mut sample.estimate;
    let (Some(filter), Some(estimate)) = (live.filter(), live.torque()) else {
        common.status = InertialStatus::NoTorques.code().into();
        return;
    };
    put(common, &estimate.alpha, &estimate.covariance);
    common.nis_mean = filter.nis().per_degree().unwrap_or(0.0);
    common.nis_count = filter.nis().count() as f64;
    let states_none = sheet(known) == SensorSheet::default();
    sample.consider_sigma_kg_m2[..P].fill(if states_none { 0.0 } else { f64::NAN });
    // the filter begins once the shape is found; what it may keep of its start is the common scale
    let scale_variance =
        estimate.alpha.dot(&(estimate.covariance * estimate.alpha)) / estimate.alpha.norm_squared().powi(2);
    let scale = Identifiability::of(scale_variance.sqrt(), SCALE_SD);
    common.identifiability[..P].fill(scale.code());
}

#[cfg(test)]
mod tests;
