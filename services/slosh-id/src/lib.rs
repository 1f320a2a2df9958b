//! Slosh mass, stiffness and damping on one axis (BP2, 1-D): maximum likelihood over a fixed-memory arc.
//!
//! May import: physics, estimation, runtime, telemetry. Must never know: the plant, recordings.
#![forbid(unsafe_code)]

use physics::slosh_arc::SloshSample;
use physics::slosh_estimator::{SloshError, SloshEstimate, SloshEstimator, SloshSettings};
use physics::slosh_likelihood::SloshUnknowns;
use runtime::experiment::{ExperimentWindow, Step};
use runtime::scenario::SloshKnown;
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use serde::{Deserialize, Serialize};
use telemetry::{
    ACTUATORS, Domain, ESTIMATE_SLOSH, Estimate, Experiment, IMU, Innovation, PartitionId, Sample, TopicId,
};

const PARAMETERS: usize = 3;
/// Residuals beyond this many sigma are counted as not accepted by the record; the estimator uses them all.
const GATE_SIGMA: f64 = 5.0;
/// Places of the two numbers of a refusal in `Estimate::auxiliary`.
const NUMBERS_OF_STATUS: usize = 10;
/// `Estimate::status` when the scenario does not say what has to be known.
const STATUS_NOT_KNOWN: u32 = 1;

#[derive(Clone, Default, Serialize, Deserialize)]
struct State {
    window: ExperimentWindow,
    estimator: Option<Box<SloshEstimator>>,
    rows: u32,
    /// Begin of the first interval: times of the arc count from there.
    t_begin_ns: Option<u64>,
    /// End of the last interval.
    t_end_ns: u64,
    /// End of the last interval with an acceleration.
    t_measured_ns: u64,
}

/// The partition.
pub struct SloshId {
    state: State,
    known: Option<SloshKnown>,
    replays: bool,
}

/// Builds the partition of `run`.
///
/// # Errors
/// None: what is not known is refused when an experiment asks for it.
pub fn connect(run: &RunConfig) -> Result<Box<dyn Partition>, ConnectError> {
    Ok(Box::new(SloshId {
        state: State::default(),
        known: run.scenario.slosh.as_ref().map(|slosh| slosh.known.clone()),
        replays: run.replay.as_ref().is_some_and(|replay| replay.slosh),
    }))
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
            Step::Abort => self.state.estimator = None,
            Step::Begin => {
                self.begin();
                self.take(frame);
            }
            Step::Go => {
                self.take(frame);
                if self.state.window.estimate_is_due(frame) {
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

impl SloshId {
    fn begin(&mut self) {
        let estimator = self.known.as_ref().map(|known| {
            // Not known to be at rest is not at rest: the state is then estimated with the rest.
            let unknowns = match known.starts_at_rest {
                Some(true) => SloshUnknowns::Parameters,
                _ => SloshUnknowns::ParametersStateBias,
            };
            Box::new(SloshEstimator::new(SloshSettings { base_mass_kg: known.m_0_kg, unknowns }))
        });
        self.state = State { window: self.state.window, estimator, ..State::default() };
    }

    /// Pairs force and acceleration of the same interval. An acceleration that is not valid leaves the force, which
    /// still drives the slosh (`runtime::pairs` would leave out both, and that is a gap).
    fn take(&mut self, frame: &Frame<'_>) {
        let State { estimator: Some(estimator), rows, t_begin_ns, t_end_ns, t_measured_ns, .. } = &mut self.state
        else {
            return;
        };
        let Some(known) = &self.known else { return };
        let axis = known.axis.index();
        let forces = frame.samples(ACTUATORS);
        for imu in frame.samples(IMU) {
            let begin_ns = imu.header.t_meas_ns;
            let Some(force) = forces.iter().find(|force| force.header.t_meas_ns == begin_ns) else { continue };
            let (interval_s, force_n) = (imu.interval_s, force.force_b_n[axis]);
            let is_measured = imu.valid >> (3 + axis) & 1 == 1;
            let sample = if is_measured {
                SloshSample {
                    interval_s,
                    force_n,
                    acceleration_m_s2: imu.acceleration_b_m_s2[axis],
                    sigma_m_s2: known.accelerometer_vrw_m_s_sqrt_h / 60.0 / interval_s.sqrt(),
                }
            } else {
                SloshSample::thrust_alone(interval_s, force_n)
            };
            // Seconds since the first interval, negative for a stamp from before it: the arc refuses that one.
            let begin_s = begin_ns as i64 - *t_begin_ns.get_or_insert(begin_ns) as i64;
            if estimator.push_at(begin_s as f64 * 1e-9, &sample).is_ok() {
                *t_end_ns = begin_ns + (interval_s * 1e9).round() as u64;
                if is_measured {
                    *rows += 1;
                    *t_measured_ns = *t_end_ns;
                }
            }
        }
    }

    fn publish(&mut self, frame: &Frame<'_>, closing: bool, out: &mut Outputs) {
        let mut sample = Estimate::zeroed_at(frame.t_ns);
        sample.frame = frame.number;
        sample.domain = Domain::Slosh.code();
        sample.phase = self.state.window.phase().code();
        sample.closing = u16::from(closing);
        sample.innovation.rows = self.state.rows;
        sample.innovation.generation = self.state.window.generation.into();
        match self.state.estimator.as_mut().map(|estimator| estimator.estimate()) {
            Some(Ok(estimate)) => {
                fill(&mut sample, &estimate);
                sample.auxiliary[2] = self.state.t_end_ns as f64 * 1e-9;
                sample.innovation = Innovation {
                    t_ns: self.state.t_measured_ns,
                    ..innovation(estimate.last_residual, &sample.innovation)
                };
            }
            Some(Err(error)) => refuse(&mut sample, &error),
            None => sample.status = STATUS_NOT_KNOWN,
        }
        out.publish(ESTIMATE_SLOSH, &sample);
    }
}

/// The last block's residual in units of its standard deviation: its variance is one by construction.
fn innovation(residual: f64, counts: &Innovation) -> Innovation {
    let test_ratio = residual * residual / (GATE_SIGMA * GATE_SIGMA);
    let accepted = u32::from(test_ratio <= 1.0);
    Innovation { innovation: residual, variance: 1.0, test_ratio, gate: GATE_SIGMA, accepted, ..*counts }
}

/// Codes of `telemetry::status_text` and the two numbers that prove them.
fn refuse(sample: &mut Estimate, error: &SloshError) {
    let (status, numbers) = match *error {
        SloshError::ArcTooShort { got, need } => (2, [got as f64, need as f64]),
        SloshError::NoSloshFound { gain, threshold } => (3, [gain, threshold]),
        SloshError::NotConverged { iterations, step_sigmas } => (4, [f64::from(iterations), step_sigmas]),
        SloshError::Fragmented { usable, need } => (5, [usable as f64, need as f64]),
        SloshError::ModeNotResolved { omega_times_block, limit } => (6, [omega_times_block, limit]),
    };
    sample.status = status;
    sample.auxiliary[NUMBERS_OF_STATUS..NUMBERS_OF_STATUS + 2].copy_from_slice(&numbers);
}

fn fill(sample: &mut Estimate, estimate: &SloshEstimate) {
    let parameters = &estimate.hypothesis.parameters;
    let values = [parameters.slosh_mass_kg, parameters.stiffness_n_m, parameters.damping_n_s_m];
    sample.count = PARAMETERS as u16;
    sample.values[..PARAMETERS].copy_from_slice(&values);
    for i in 0..PARAMETERS {
        for j in 0..PARAMETERS {
            sample.covariance[i][j] = estimate.covariance[(i, j)];
        }
    }
    sample.consistent = u32::from(values.iter().all(|value| *value > 0.0));
    sample.auxiliary[0] = estimate.state_at_end.displacement_m;
    sample.auxiliary[1] = estimate.state_at_end.velocity_m_s;
    sample.auxiliary[3] = estimate.hypothesis.bias_m_s2;
    sample.nis_mean = estimate.chi_square_per_degree();
    sample.nis_count = estimate.degrees_of_freedom as f64;
    for (scale, verdict) in estimate.whiteness.verdicts().iter().enumerate() {
        sample.block_length[scale] = verdict.block_samples.into();
        sample.block_z[scale] = verdict.z_score;
    }
}
