//! Slosh mass, stiffness and damping on one axis (BP2, 1-D): maximum likelihood over a fixed-memory arc.
//!
//! May import: physics, estimation, runtime, telemetry. Must never know: the plant, recordings.
#![forbid(unsafe_code)]

use physics::slosh_arc::SloshSample;
use physics::slosh_estimator::{SloshEstimate, SloshEstimator, SloshSettings};
use physics::slosh_likelihood::SloshUnknowns;
use runtime::experiment::{ExperimentWindow, Step};
use runtime::scenario::SloshKnown;
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use serde::{Deserialize, Serialize};
use telemetry::{
    ACTUATORS, Domain, ESTIMATE_SLOSH, Estimate, Experiment, IMU, Innovation, PartitionId, Sample, TopicId,
};

const PARAMETERS: usize = 3;

#[derive(Clone, Default, Serialize, Deserialize)]
struct State {
    window: ExperimentWindow,
    estimator: Option<Box<SloshEstimator>>,
    rows: u32,
    /// End of the last interval.
    t_end_ns: u64,
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
            let unknowns =
                if known.starts_at_rest == Some(true) { SloshUnknowns::Parameters } else { SloshUnknowns::ParametersStateBias };
            Box::new(SloshEstimator::new(SloshSettings { base_mass_kg: known.m_0_kg, unknowns }))
        });
        self.state = State { window: self.state.window, estimator, rows: 0, t_end_ns: 0 };
    }

    /// Pairs force and acceleration of the same interval.
    fn take(&mut self, frame: &Frame<'_>) {
        let (Some(estimator), Some(known)) = (&mut self.state.estimator, &self.known) else { return };
        let axis = known.axis.index();
        let forces = frame.samples(ACTUATORS);
        for imu in frame.samples(IMU).iter().filter(|imu| imu.valid >> (3 + axis) & 1 == 1) {
            let Some(force) = forces.iter().find(|force| force.header.t_meas_ns == imu.header.t_meas_ns) else {
                continue;
            };
            let sample = SloshSample {
                interval_s: imu.interval_s,
                force_n: force.force_b_n[axis],
                acceleration_m_s2: imu.acceleration_b_m_s2[axis],
                sigma_m_s2: known.accelerometer_vrw_m_s_sqrt_h / 60.0 / imu.interval_s.sqrt(),
            };
            if estimator.push(&sample).is_ok() {
                self.state.rows += 1;
                self.state.t_end_ns = imu.header.t_meas_ns + (imu.interval_s * 1e9).round() as u64;
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
            Some(Ok(estimate)) => fill(&mut sample, &estimate, self.state.t_end_ns),
            Some(Err(_)) => sample.status = 2,
            None => sample.status = 1,
        }
        out.publish(ESTIMATE_SLOSH, &sample);
    }
}

fn fill(sample: &mut Estimate, estimate: &SloshEstimate, t_end_ns: u64) {
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
    sample.auxiliary[2] = t_end_ns as f64 * 1e-9;
    sample.nis_mean = estimate.chi_square_per_degree();
    sample.nis_count = estimate.degrees_of_freedom as f64;
    for (scale, verdict) in estimate.whiteness.verdicts().iter().enumerate() {
        sample.block_length[scale] = verdict.block_samples.into();
        sample.block_z[scale] = verdict.z_score;
    }
    sample.innovation = Innovation { t_ns: t_end_ns, variance: 1.0, accepted: 1, ..sample.innovation };
}
