//! What it is: estimation of slosh mass, stiffness and damping on one axis (BP2, 1-D): maximum
//! likelihood over a fixed-memory arc.
//!
//! Every sample goes into the arc as it comes; the likelihood is maximised when an estimate is due.
//! A record that begins late or has a gap leaves the slosh state unknown there, and it is
//! estimated. With a prior (`expected` and `expected_sigma` of the scenario) any thrust will do,
//! station keeping's too: each parameter says whether it was identified, the prior kept, or not
//! excited (`Estimate::identifiability`). All memory is taken at the start.
//!
//! ```no_run
//! use runtime::rundir::RunDir;
//! use telemetry::{PartitionId, TOPICS};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // The folder of a run, as `obsid run` makes it.
//! let folder = std::env::args_os().nth(1).ok_or("no folder of a run")?;
//! let run = RunDir::at(folder.as_ref()).load()?;
//! let partition = slosh_id::connect(&run)?;
//! assert_eq!(partition.id(), PartitionId::SloshId);
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

use estimation::GATE_SIGMAS;
use nalgebra::Vector3;
use physics::slosh::SloshParameters;
use physics::slosh_arc::SloshSample;
use physics::slosh_estimator::{self, SloshError, SloshEstimator, SloshSettings};
use physics::slosh_likelihood::SloshUnknowns;
use physics::slosh_prior::TankPrior;
use plant_file::scenario::{Scenario, SloshKnown};
use runtime::experiment::{ExperimentWindow, Step};
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use serde::{Deserialize, Serialize};
use telemetry::{
    ACTUATORS, Actuators, Domain, ESTIMATE_SLOSH, Experiment, IMU, Imu, Innovation, PartitionId, Sample, SloshEstimate,
    SloshStatus, TopicId,
};

const PARAMETERS: usize = 3;
/// A first sample further than this behind the experiment's begin is late: the slosh state is
/// unknown [intervals].
const LATE_INTERVALS: f64 = 1.5;

#[derive(Clone, Default, Serialize, Deserialize)]
struct State {
    window: ExperimentWindow,
    /// Between the begin of an experiment and its closing estimate.
    is_open: bool,
    rows: u32,
    begin_ns: u64,
    /// Begin of the first interval: times of the arc count from there.
    t_first_ns: Option<u64>,
    /// End of the last interval.
    t_end_ns: u64,
    /// End of the last interval with an acceleration.
    t_measured_ns: u64,
}

/// The partition: fed with thrust and acceleration of an experiment, it publishes estimates of the
/// slosh parameters.
pub struct SloshId {
    state: State,
    estimator: Box<SloshEstimator>,
    known: Option<SloshKnown>,
    replays: bool,
}

/// Builds the partition of `run`.
///
/// # Errors
/// When the scenario cannot be read; values that it lacks are reported by the status of an estimate
/// once an experiment needs them.
pub fn connect(run: &RunConfig) -> Result<Box<dyn Partition>, ConnectError> {
    let scenario = Scenario::read(&run.scenario, &run.files, run.replay.is_some())
        .map_err(ConnectError::of(PartitionId::SloshId))?;
    if let Some(plan) = &scenario.craft {
        let keeper = craft::keeper::Keeper::new(PartitionId::SloshId, Domain::Slosh, plan);
        return Ok(Box::new(keeper.map_err(ConnectError::of(PartitionId::SloshId))?));
    }
    let replays = run.replay.as_ref().is_some_and(|replay| replay.identifies(Domain::Slosh));
    Ok(Box::new(SloshId::new(scenario.slosh.map(|slosh| slosh.known), replays)))
}

impl Partition for SloshId {
    fn id(&self) -> PartitionId {
        PartitionId::SloshId
    }

    fn inputs(&self) -> &'static [TopicId] {
        &[IMU.id, ACTUATORS.id]
    }

    fn frame(&mut self, frame: &Frame<'_>, out: &mut Outputs) {
        let mine: &[Experiment] =
            if self.replays { &[Experiment::Slosh, Experiment::Replay] } else { &[Experiment::Slosh] };
        match self.state.window.step(frame, mine) {
            Step::Idle => {}
            Step::Abort => self.state.is_open = false,
            Step::Begin => {
                self.begin(frame.t_ns);
                self.take(frame.samples(IMU), frame.samples(ACTUATORS));
            }
            Step::Go => {
                self.take(frame.samples(IMU), frame.samples(ACTUATORS));
                if self.state.window.estimate_is_due(frame) {
                    out.publish(ESTIMATE_SLOSH, &self.estimate(frame.number, frame.t_ns, false));
                }
            }
            Step::Close => {
                out.publish(ESTIMATE_SLOSH, &self.estimate(frame.number, frame.t_ns, true));
                // What is closed need not be carried from checkpoint to checkpoint.
                self.state.is_open = false;
            }
        }
    }

    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        runtime::save_state(&(&self.state, self.state.is_open.then_some(&self.estimator)), state)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        let (small, estimator): (State, Option<Box<SloshEstimator>>) = runtime::restore_state(state)?;
        self.state = small;
        if let Some(estimator) = estimator {
            self.estimator = estimator;
        }
        Ok(())
    }
}

impl SloshId {
    fn new(known: Option<SloshKnown>, replays: bool) -> Self {
        Self { state: State::default(), estimator: fresh(known.as_ref(), false), known, replays }
    }

    fn begin(&mut self, begin_ns: u64) {
        let window = self.state.window;
        self.state = State { window, is_open: true, begin_ns, ..State::default() };
        self.renew(true);
    }

    /// Begins with nothing, in the memory there is.
    fn renew(&mut self, saw_the_begin: bool) {
        if let Some(known) = &self.known {
            *self.estimator = estimator(known, saw_the_begin);
        }
    }

    /// Pairs force and acceleration of the same interval. An acceleration that is not valid leaves
    /// the force, which still drives the slosh (`runtime::pairs` would leave out both, and that is
    /// a gap).
    fn take(&mut self, imus: &[Imu], forces: &[Actuators]) {
        let Some((axis, vrw)) = self.known.as_ref().map(|k| (k.axis.index(), k.accelerometer_vrw_m_s_sqrt_h)) else {
            return;
        };
        for imu in imus {
            let begin_ns = imu.header.t_meas_ns;
            let Some(force) = forces.iter().find(|force| force.header.t_meas_ns == begin_ns) else { continue };
            let (interval_s, force_n) = (imu.interval_s, force.force_b_n[axis]);
            let is_measured = imu.valid >> (3 + axis) & 1 == 1;
            let sample = if is_measured {
                let (acceleration_m_s2, sigma_m_s2) = (imu.acceleration_b_m_s2[axis], vrw / 60.0 / interval_s.sqrt());
                SloshSample { interval_s, force_n, acceleration_m_s2, sigma_m_s2 }
            } else {
                SloshSample::thrust_alone(interval_s, force_n)
            };
            let first_ns = self.first(begin_ns, interval_s);
            // Seconds since the first interval, negative for a stamp from before it: the arc
            // refuses that one.
            let begin_s = begin_ns as i64 - first_ns as i64;
            if self.estimator.push_at(begin_s as f64 * 1e-9, &sample).is_ok() {
                self.state.t_end_ns = begin_ns + (interval_s * 1e9).round() as u64;
                if is_measured {
                    self.state.rows += 1;
                    self.state.t_measured_ns = self.state.t_end_ns;
                }
            }
        }
    }

    /// Begin of the first interval; when this one is it and comes late, the estimator learns that
    /// the start is not known.
    fn first(&mut self, begin_ns: u64, interval_s: f64) -> u64 {
        if let Some(first_ns) = self.state.t_first_ns {
            return first_ns;
        }
        if begin_ns.saturating_sub(self.state.begin_ns) as f64 * 1e-9 > LATE_INTERVALS * interval_s {
            self.renew(false);
        }
        self.state.t_first_ns = Some(begin_ns);
        begin_ns
    }

    fn estimate(&mut self, frame: u64, t_ns: u64, closing: bool) -> SloshEstimate {
        let mut sample = SloshEstimate::zeroed_at(t_ns);
        let common = &mut sample.estimate;
        (common.frame, common.domain) = (frame, Domain::Slosh.code());
        (common.phase, common.closing) = (self.state.window.phase().code(), u16::from(closing));
        common.innovation = Innovation {
            rows: self.state.rows,
            gate: GATE_SIGMAS,
            generation: self.state.window.generation.into(),
            ..Innovation::default()
        };
        if self.known.is_none() {
            common.status = SloshStatus::NotKnown.code().into();
            return sample;
        }
        match self.estimator.estimate() {
            Ok(estimate) => {
                fill(&mut sample, &estimate);
                sample.arc_end_s = self.state.t_end_ns as f64 * 1e-9;
                sample.estimate.innovation.t_ns = self.state.t_measured_ns;
            }
            Err(error) => refuse(&mut sample, &error),
        }
        sample
    }
}

fn fresh(known: Option<&SloshKnown>, saw_the_begin: bool) -> Box<SloshEstimator> {
    let nothing = SloshSettings { base_mass_kg: 1.0, unknowns: SloshUnknowns::Parameters };
    Box::new(known.map_or_else(|| SloshEstimator::new(nothing), |known| estimator(known, saw_the_begin)))
}

/// Not known to be at rest is not at rest: the state is then estimated with the rest.
fn estimator(known: &SloshKnown, saw_the_begin: bool) -> SloshEstimator {
    let unknowns = match known.starts_at_rest {
        Some(true) if saw_the_begin => SloshUnknowns::Parameters,
        _ => SloshUnknowns::ParametersStateBias,
    };
    let estimator = SloshEstimator::new(SloshSettings { base_mass_kg: known.m_0_kg, unknowns });
    let positive = known.expected.filter(|numbers| numbers.iter().all(|number| *number > 0.0));
    let spread = known.expected_sigma.filter(|numbers| numbers.iter().all(|number| *number > 0.0));
    match (positive, spread) {
        (Some([slosh_mass_kg, stiffness_n_m, damping_n_s_m]), Some(sigma)) => estimator.with_prior(TankPrior {
            parameters: SloshParameters { slosh_mass_kg, stiffness_n_m, damping_n_s_m },
            sigma: Vector3::from(sigma),
        }),
        _ => estimator,
    }
}

/// Why there is no estimate, with the figures that prove it.
fn refuse(sample: &mut SloshEstimate, error: &SloshError) {
    let status = match *error {
        SloshError::ArcTooShort { got, need } => {
            (sample.arc_blocks, sample.arc_blocks_needed) = (got as u64, need as u64);
            SloshStatus::ArcTooShort
        }
        SloshError::NoSloshFound { gain, threshold } => {
            (sample.slosh_gain, sample.slosh_gain_needed) = (gain, threshold);
            SloshStatus::NoSloshFound
        }
        SloshError::NotConverged { iterations, step_sigmas } => {
            (sample.iterations, sample.step_sigma) = (iterations.into(), step_sigmas);
            SloshStatus::NotConverged
        }
        SloshError::Fragmented { usable, need } => {
            (sample.arc_blocks, sample.arc_blocks_needed) = (usable as u64, need as u64);
            SloshStatus::Fragmented
        }
        SloshError::ModeNotResolved { omega_times_block, limit } => {
            (sample.block_phase_rad, sample.block_phase_max_rad) = (omega_times_block, limit);
            SloshStatus::ModeNotResolved
        }
    };
    sample.estimate.status = status.code().into();
}

fn fill(sample: &mut SloshEstimate, found: &slosh_estimator::SloshEstimate) {
    let parameters = &found.hypothesis.parameters;
    let values = [parameters.slosh_mass_kg, parameters.stiffness_n_m, parameters.damping_n_s_m];
    sample.displacement_m = found.state_at_end.displacement_m;
    sample.rate_m_s = found.state_at_end.velocity_m_s;
    sample.accelerometer_bias_m_s2 = found.hypothesis.bias_m_s2;
    let common = &mut sample.estimate;
    common.count = PARAMETERS as u16;
    common.values[..PARAMETERS].copy_from_slice(&values);
    for i in 0..PARAMETERS {
        for j in 0..PARAMETERS {
            common.covariance[i][j] = found.covariance[(i, j)];
        }
    }
    common.consistent = u32::from(values.iter().all(|value| *value > 0.0));
    if let Some(identifiability) = found.identifiability {
        common.identifiability[..PARAMETERS].copy_from_slice(&identifiability.map(|one| one.code()));
    }
    if let Some(newest) = found.innovation {
        let record = &mut common.innovation;
        (record.innovation, record.variance) = (newest.innovation, newest.variance);
        record.test_ratio = newest.innovation * newest.innovation / (GATE_SIGMAS * GATE_SIGMAS * newest.variance);
        record.accepted = u32::from(record.test_ratio <= 1.0);
    }
    common.nis_mean = found.chi_square_per_degree();
    common.nis_count = found.degrees_of_freedom as f64;
    for (scale, verdict) in found.whiteness.verdicts().iter().enumerate() {
        common.block_length[scale] = verdict.block_samples.into();
        common.block_z[scale] = verdict.z_score;
    }
}

#[cfg(test)]
mod tests;
