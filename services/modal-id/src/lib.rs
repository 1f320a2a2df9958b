//! Modes of flexible appendages (BP3A): streaming SSI-COV over free-decay or operational segments.
//!
//! A segment is open while no torque or force is commanded: with a known excitation the decay behind it is what
//! output-only identification assumes. Without actuator samples the whole record is one operational segment.
//! May import: modal, physics, runtime, telemetry. Must never know: the plant, recordings.
#![forbid(unsafe_code)]

use estimation::consistency::Whiteness;
use modal::{Config, ModalIdentifier, Mode};
use physics::appendage;
use runtime::experiment::{ExperimentWindow, Step};
use runtime::scenario::ModalKnown;
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use telemetry::{
    ACCELEROMETERS, ACCELEROMETERS_MAX, ACTUATORS, Accelerometers, Domain, ESTIMATE_MODAL, Estimate, Experiment,
    PARAMETERS_MAX, PartitionId, Sample, TopicId,
};

const MODES_MAX: usize = PARAMETERS_MAX / 2;
/// Rows of a free decay on which the model is tested.
const TESTED_ROWS: usize = 512;

#[derive(Clone, Default, Serialize, Deserialize)]
struct State {
    window: ExperimentWindow,
    identifier: Option<ModalIdentifier>,
    forced: bool,
    rows: u32,
    /// Time of the last row.
    last_t_ns: u64,
    /// The open segment follows a commanded excitation: it is a free decay.
    decays: bool,
    /// Newest rows of the open segment.
    recent: VecDeque<f64>,
}

/// The partition.
pub struct ModalId {
    state: State,
    known: ModalKnown,
    replays: bool,
}

/// Builds the partition of `run`.
///
/// # Errors
/// None.
pub fn connect(run: &RunConfig) -> Result<Box<dyn Partition>, ConnectError> {
    Ok(Box::new(ModalId {
        state: State::default(),
        known: run.scenario.modal.as_ref().map(|modal| modal.known.clone()).unwrap_or_default(),
        replays: run.replay.as_ref().is_some_and(|replay| replay.modal),
    }))
}

impl Partition for ModalId {
    fn id(&self) -> PartitionId {
        PartitionId::ModalId
    }

    fn inputs(&self) -> &'static [TopicId] {
        &[ACCELEROMETERS.id, ACTUATORS.id]
    }

    fn frame(&mut self, frame: &Frame<'_>, out: &mut Outputs) {
        let mine: &[Experiment] =
            if self.replays { &[Experiment::Modal, Experiment::Replay] } else { &[Experiment::Modal] };
        match self.state.window.step(frame, mine) {
            Step::Idle => {}
            Step::Abort => self.state.identifier = None,
            Step::Begin => {
                self.state = State { window: self.state.window, ..State::default() };
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
                self.state.identifier = None;
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

impl ModalId {
    fn take(&mut self, frame: &Frame<'_>) {
        for command in frame.samples(ACTUATORS) {
            let forced = command.torque_b_nm.iter().chain(&command.force_b_n).any(|&value| value != 0.0);
            if forced != self.state.forced {
                self.state.forced = forced;
                self.turn_segment();
            }
        }
        for batch in frame.samples(ACCELEROMETERS) {
            self.take_batch(batch);
        }
    }

    fn turn_segment(&mut self) {
        self.state.recent.clear();
        self.state.decays |= self.state.forced;
        let Some(identifier) = &mut self.state.identifier else { return };
        if self.state.forced {
            identifier.close_segment();
        } else {
            identifier.open_segment();
        }
    }

    /// Memory is taken with the first batch, which says how many channels there are.
    fn take_batch(&mut self, batch: &Accelerometers) {
        let available = (batch.channels as usize).min(ACCELEROMETERS_MAX);
        let channels = self.channels(available);
        if channels.is_empty() {
            return;
        }
        if self.state.identifier.is_none() {
            let rate_hz = 1e9 / batch.interval_ns.max(1) as f64;
            let mut config = Config::new(channels.len(), rate_hz);
            config.band_hz = self.known.band_hz.map(|[low, high]| (low, high));
            self.state.identifier = Some(ModalIdentifier::new(config));
            self.turn_segment();
        }
        let Some(identifier) = &mut self.state.identifier else { return };
        if identifier.config().channels != channels.len() {
            return;
        }
        let mut row = [0.0; ACCELEROMETERS_MAX];
        for (values, offset_ns) in batch.acceleration_m_s2.iter().zip(batch.offset_ns).take(batch.count as usize) {
            let t_ns = batch.header.t_meas_ns + u64::from(offset_ns);
            if self.state.rows > 0 && !self.state.forced && t_ns > self.state.last_t_ns + batch.interval_ns * 3 / 2 {
                // No column of a Hankel matrix may reach over a gap.
                identifier.open_segment();
                self.state.recent.clear();
            }
            self.state.last_t_ns = t_ns;
            for (used, &channel) in row.iter_mut().zip(&channels) {
                *used = values[channel];
            }
            identifier.push(&row[..channels.len()]);
            self.state.rows += 1;
            if self.state.decays && !self.state.forced {
                if self.state.recent.len() == TESTED_ROWS * channels.len() {
                    self.state.recent.drain(..channels.len());
                }
                self.state.recent.extend(&row[..channels.len()]);
            }
        }
    }

    /// Channels used, numbered from 0.
    fn channels(&self, available: usize) -> Vec<usize> {
        match self.known.channels.is_empty() {
            true => (0..available).collect(),
            false => {
                self.known.channels.iter().map(|&channel| channel - 1).filter(|&channel| channel < available).collect()
            }
        }
    }

    fn publish(&mut self, frame: &Frame<'_>, closing: bool, out: &mut Outputs) {
        let mut sample = Estimate::zeroed_at(frame.t_ns);
        sample.frame = frame.number;
        sample.domain = Domain::Modal.code();
        sample.phase = self.state.window.phase().code();
        sample.closing = u16::from(closing);
        sample.innovation.rows = self.state.rows;
        sample.innovation.generation = self.state.window.generation.into();
        match self.state.identifier.as_mut().map(ModalIdentifier::identify) {
            Some(Ok(modes)) => {
                fill(&mut sample, modes);
                self.test_decay(&mut sample);
            }
            Some(Err(_)) => sample.status = 2,
            None => sample.status = 1,
        }
        out.publish(ESTIMATE_MODAL, &sample);
    }
}

impl ModalId {
    /// Innovations of a free decay: what its modes leave unexplained in the newest rows, against the sensor noise. An
    /// operational record has none: its excitation is not known.
    fn test_decay(&mut self, sample: &mut Estimate) {
        let Some(config) = self.state.identifier.as_ref().map(ModalIdentifier::config) else { return };
        let (channels, rate_hz) = (config.channels, config.sample_rate_hz);
        if usize::from(sample.count) != 2 * appendage::MODES
            || self.state.recent.len() < 2 * appendage::REFIT_UNKNOWNS * channels
        {
            return;
        }
        let modes = core::array::from_fn(|k| appendage::Mode {
            frequency_hz: sample.values[2 * k],
            damping_ratio: sample.values[2 * k + 1],
        });
        let sigma = self.known.accelerometer_sigma_m_s2;
        let (mut squares, mut whiteness) = (0.0, Whiteness::default());
        let rows = self.state.recent.make_contiguous();
        let tested = appendage::for_each_residual(&modes, rows, channels, rate_hz, |residual, _| {
            squares += residual * residual / (sigma * sigma);
            whiteness.push(residual / sigma);
        });
        if tested.is_ok() {
            sample.nis_count = (rows.len() - appendage::REFIT_UNKNOWNS * channels) as f64;
            sample.nis_mean = squares / sample.nis_count;
            for (scale, verdict) in whiteness.verdicts().iter().enumerate() {
                sample.block_length[scale] = verdict.block_samples.into();
                sample.block_z[scale] = verdict.z_score;
            }
        }
    }
}

/// The modes that are known best, in order of frequency.
fn fill(sample: &mut Estimate, mut modes: Vec<Mode>) {
    let relative = |mode: &Mode| mode.sigma_frequency_hz / mode.frequency_hz;
    modes.sort_by(|a, b| relative(a).total_cmp(&relative(b)));
    modes.truncate(MODES_MAX);
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    sample.count = 2 * modes.len() as u16;
    sample.consistent = u32::from(!modes.is_empty() && modes.iter().all(|mode| mode.damping_ratio > 0.0));
    for (i, mode) in modes.iter().enumerate() {
        sample.values[2 * i] = mode.frequency_hz;
        sample.values[2 * i + 1] = mode.damping_ratio;
        sample.covariance[2 * i][2 * i] = mode.sigma_frequency_hz * mode.sigma_frequency_hz;
        sample.covariance[2 * i + 1][2 * i + 1] = mode.sigma_damping * mode.sigma_damping;
        sample.auxiliary[i] = mode.dominant_channel as f64 + 1.0;
    }
    if modes.is_empty() {
        sample.status = 3;
    }
}
