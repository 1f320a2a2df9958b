//! What it is: identification of the modes of flexible appendages (BP3A): streaming SSI-COV over
//! free-decay or operational segments.
//!
//! A segment is open while the excitation is off: behind a known excitation there is a free decay,
//! which output-only identification assumes, and the rows before the first excitation are dropped.
//! Without a known excitation the whole record is operational, in segments that end where it jumps.
//!
//! Excitation is on while the samples say so (`excited`) and anything is commanded: a vehicle may
//! announce an experiment that is silent most of the time, and a measured torque is never zero.
//!
//! Where there are modes, [`telemetry::IdentifiedMode`] states for each its dominant
//! channel, its identity over all estimates and experiments so far, and cautions. Given the
//! appendage's geometry (`[modal.known.appendage]`) the estimate holds five modes at most, with the
//! inertia about the hub's axis that they imply.
//!
//! ```no_run
//! use runtime::rundir::RunDir;
//! use telemetry::{PartitionId, TOPICS};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // The folder of a run, as `obsid run` makes it.
//! let folder = std::env::args_os().nth(1).ok_or("no folder of a run")?;
//! let run = RunDir::at(folder.as_ref()).load()?;
//! let partition = modal_id::connect(&run)?;
//! assert_eq!(partition.id(), PartitionId::ModalId);
//! for topic in partition.inputs() {
//!     println!("{}: {}", TOPICS[*topic].name, TOPICS[*topic].rate);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! May import: modal, estimation, physics, craft, plant_file, runtime, telemetry.
//!
//! Must never know: how a plant is simulated, recordings.
#![forbid(unsafe_code)]

mod advice;
mod decay_rows;
mod inertia;

use advice::Pulse;
use decay_rows::DecayRows;
use estimation::GATE_SIGMAS;
use estimation::consistency::Whiteness;
use modal::methods::Estimate as Found;
use modal::tracking::ModeTracker;
use modal::{Config, ModalError, ModalIdentifier, Mode, OnsetGate};
use physics::appendage;
use plant_file::scenario::{ModalKnown, Scenario};
use runtime::experiment::{ExperimentWindow, Step};
use runtime::pairs::is_excited;
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use serde::{Deserialize, Serialize};
use telemetry::{
    ACCELEROMETERS, ACCELEROMETERS_MAX, ACTUATORS, Accelerometers, Actuators, Domain, ESTIMATE_MODAL, Estimate,
    Experiment, MODES_MAX, ModalEstimate, ModalStatus, PartitionId, Sample, TopicId,
};

/// Modes refitted to a decay.
const _: () = assert!(MODES_MAX == appendage::REFIT_MODES_MAX);
/// Most modes of an estimate that also gives the hub's inertia.
const MODES_WITH_INERTIA: usize = 5;
/// Standard deviations of the mean innovation, or of a block of them, beyond which an unknown input
/// acts.
const LEAK_SIGMA: f64 = 5.0;

#[derive(Clone, Default, Serialize, Deserialize)]
struct State {
    window: ExperimentWindow,
    identifier: Option<ModalIdentifier>,
    gate: OnsetGate,
    /// The record's channels in use, from 0, of so many.
    channels: Vec<usize>,
    available: usize,
    forced: bool,
    rows: u32,
    /// Time of the last row.
    last_t_ns: u64,
    /// There was an excitation: what follows it is a free decay.
    decays: bool,
    /// Rows between excitations; those before the first one do not count.
    free_rows: u32,
    tested: DecayRows,
    pulse: Pulse,
    /// Stays from experiment to experiment.
    tracker: Option<ModeTracker>,
}

/// The partition: fed with accelerations of an experiment, it publishes estimates of the modes.
pub struct ModalId {
    state: State,
    known: ModalKnown,
    replays: bool,
    /// The estimate that the last frame left to be made.
    due: Option<Due>,
}

/// An estimate to be made, and the frame that it is of.
#[derive(Clone, Copy)]
struct Due {
    frame: u64,
    t_ns: u64,
    closing: bool,
}

/// Builds the partition of `run`.
///
/// # Errors
/// When the scenario cannot be read.
pub fn connect(run: &RunConfig) -> Result<Box<dyn Partition>, ConnectError> {
    let scenario = Scenario::read(&run.scenario, &run.files, run.replay.is_some())
        .map_err(ConnectError::of(PartitionId::ModalId))?;
    if let Some(plan) = &scenario.craft {
        let keeper = craft::keeper::Keeper::new(PartitionId::ModalId, Domain::Modal, plan);
        return Ok(Box::new(keeper.map_err(ConnectError::of(PartitionId::ModalId))?));
    }
    Ok(Box::new(ModalId {
        state: State::default(),
        known: scenario.modal.map(|modal| modal.known).unwrap_or_default(),
        replays: run.replay.as_ref().is_some_and(|replay| replay.identifies(Domain::Modal)),
        due: None,
    }))
}

impl Partition for ModalId {
    fn id(&self) -> PartitionId {
        PartitionId::ModalId
    }

    fn inputs(&self) -> &'static [TopicId] {
        &[ACCELEROMETERS.id, ACTUATORS.id]
    }

    fn frame(&mut self, frame: &Frame<'_>, _out: &mut Outputs) {
        let mine: &[Experiment] =
            if self.replays { &[Experiment::Modal, Experiment::Replay] } else { &[Experiment::Modal] };
        match self.state.window.step(frame, mine) {
            Step::Idle => {}
            Step::Abort => self.state.identifier = None,
            Step::Begin => {
                let tracker = self.state.tracker.take();
                self.state = State { window: self.state.window, tracker, ..State::default() };
                self.take(frame);
            }
            Step::Go => {
                self.take(frame);
                if self.state.window.estimate_is_due(frame) {
                    self.due = Some(Due { frame: frame.number, t_ns: frame.t_ns, closing: false });
                }
            }
            Step::Close => self.due = Some(Due { frame: frame.number, t_ns: frame.t_ns, closing: true }),
        }
    }

    fn has_work(&self) -> bool {
        self.due.is_some()
    }

    /// Factorisations of all rates: up to seconds.
    fn work(&mut self, out: &mut Outputs) {
        let Some(due) = self.due.take() else { return };
        let mut sample = self.estimate(due.t_ns, due.closing);
        sample.estimate.frame = due.frame;
        out.publish(ESTIMATE_MODAL, &sample);
        if due.closing {
            // What is closed need not be carried from checkpoint to checkpoint.
            self.state.identifier = None;
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
        self.take_commands(frame.samples(ACTUATORS));
        for batch in frame.samples(ACCELEROMETERS) {
            self.take_batch(batch);
        }
    }

    fn take_commands(&mut self, commands: &[Actuators]) {
        commands.iter().filter(|command| is_excited(command)).for_each(|command| self.state.pulse.excited(command));
        // A frame in which the excitation ends is still an excited one.
        let forced = if commands.is_empty() { self.state.forced } else { commands.iter().any(is_excited) };
        if forced != self.state.forced {
            self.state.forced = forced;
            self.turn_segment();
        }
    }

    fn turn_segment(&mut self) {
        let state = &mut self.state;
        let begins = state.forced && !state.decays;
        state.decays |= state.forced;
        state.tested.begin_segment();
        if !state.forced {
            state.pulse.ended();
        }
        if begins {
            (state.gate, state.free_rows) = (OnsetGate::default(), 0);
        }
        let Some(identifier) = &mut state.identifier else { return };
        if begins {
            *identifier = ModalIdentifier::new(identifier.config().clone());
        }
        if state.forced {
            identifier.close_segment();
        } else {
            identifier.open_segment();
        }
    }

    /// Memory is taken with the first batch, which says how many channels there are.
    fn take_batch(&mut self, batch: &Accelerometers) {
        let available = (batch.channels as usize).min(ACCELEROMETERS_MAX);
        if self.state.identifier.is_none() {
            self.begin_record(available, batch.interval_ns);
        }
        let used = self.state.channels.len();
        let unlike = available != self.state.available
            && !self.known.channels_of(available).eq(self.state.channels.iter().copied());
        if self.state.identifier.is_none() || unlike {
            return;
        }
        let mut row = [0.0; ACCELEROMETERS_MAX];
        for (values, offset_ns) in batch.acceleration_m_s2.iter().zip(batch.offset_ns).take(batch.count as usize) {
            for (used, &channel) in row.iter_mut().zip(&self.state.channels) {
                *used = values[channel];
            }
            self.take_row(&row[..used], batch.header.t_meas_ns + u64::from(offset_ns), batch.interval_ns);
        }
    }

    fn begin_record(&mut self, available: usize, interval_ns: u64) {
        let channels: Vec<usize> = self.known.channels_of(available).collect();
        if channels.is_empty() {
            return;
        }
        let mut config = Config::new(channels.len(), 1e9 / interval_ns.max(1) as f64);
        config.band_hz = self.known.band_hz.map(|[low, high]| (low, high));
        self.state.identifier = Some(ModalIdentifier::new(config));
        self.state.tested = DecayRows::new(channels.len());
        self.state.tracker.get_or_insert_with(|| ModeTracker::new(channels.len()));
        (self.state.channels, self.state.available) = (channels, available);
        self.turn_segment();
    }

    fn take_row(&mut self, row: &[f64], t_ns: u64, interval_ns: u64) {
        let state = &mut self.state;
        let Some(identifier) = &mut state.identifier else { return };
        let gap = state.rows > 0 && t_ns > state.last_t_ns + interval_ns * 3 / 2;
        state.last_t_ns = t_ns;
        state.rows += 1;
        if state.forced {
            return;
        }
        if gap {
            // No column of a Hankel matrix may reach over a gap.
            state.gate.end_segment(identifier);
            identifier.open_segment();
            state.tested.begin_segment();
        }
        state.free_rows += 1;
        if state.decays {
            identifier.push(row);
            state.tested.push(row, t_ns);
        } else {
            state.gate.push(row, identifier);
        }
    }

    fn estimate(&mut self, t_ns: u64, closing: bool) -> ModalEstimate {
        let mut sample = ModalEstimate::zeroed_at(t_ns);
        let common = &mut sample.estimate;
        common.domain = Domain::Modal.code();
        common.phase = self.state.window.phase().code();
        common.closing = u16::from(closing);
        common.innovation.variance = 1.0;
        common.innovation.gate = GATE_SIGMAS;
        common.innovation.rows = self.state.rows;
        common.innovation.generation = self.state.window.generation.into();
        if closing && let Some(identifier) = &mut self.state.identifier {
            self.state.gate.end_segment(identifier);
        }
        match self.state.identifier.as_mut().map(ModalIdentifier::identify) {
            Some(_) if self.state.free_rows == 0 => common.status = ModalStatus::ExcitedThroughout.code().into(),
            Some(Ok(modes)) => self.answer(&mut sample, modes),
            Some(Err(error)) => refuse(&mut sample, &error),
            None => common.status = ModalStatus::NothingToWorkOn.code().into(),
        }
        sample
    }

    /// The modes, what they imply, and how the decay tests them.
    fn answer(&mut self, sample: &mut ModalEstimate, modes: Vec<Mode>) {
        let known = self.known.appendage.as_ref();
        let modes = best_known(modes, if known.is_some() { MODES_WITH_INERTIA } else { MODES_MAX });
        fill(sample, &modes, &self.state.channels);
        if let Some((inertia, sigma)) = known.and_then(|known| inertia::of_modes(known, &modes)) {
            (sample.hub_inertia_kg_m2, sample.hub_inertia_sigma_kg_m2) = (inertia, sigma);
        }
        self.test_decay(&mut sample.estimate);
        self.name(sample, &modes);
    }

    /// Which mode each is, and what to beware of.
    fn name(&mut self, sample: &mut ModalEstimate, modes: &[Mode]) {
        let state = &mut self.state;
        let (Some(identifier), Some(tracker)) = (&state.identifier, &mut state.tracker) else { return };
        let found: Vec<Found> = modes.iter().map(Found::from).collect();
        let common = &sample.estimate;
        let nis_z = (common.nis_mean - 1.0) * (0.5 * common.nis_count).sqrt();
        let tested = common.nis_count > 0.0;
        let leaks = tested && (nis_z > LEAK_SIGMA || common.block_z.iter().any(|z| *z > LEAK_SIGMA));
        let record_s = f64::from(state.free_rows) / identifier.config().sample_rate_hz;
        advice::note(&mut sample.modes, &found, record_s, state.pulse.length_s(), leaks);
        for (mode, identity) in sample.modes.iter_mut().zip(tracker.identities(modes)) {
            mode.identity = identity;
        }
    }

    /// Innovations of a free decay: what its modes leave unexplained of it, against the sensor
    /// noise. An operational record has none: its excitation is not known.
    fn test_decay(&self, sample: &mut Estimate) {
        let Some(config) = self.state.identifier.as_ref().map(ModalIdentifier::config) else { return };
        let (channels, rate_hz, tested) = (config.channels, config.sample_rate_hz, &self.state.tested);
        let modes: [appendage::Mode; MODES_MAX] = core::array::from_fn(|k| appendage::Mode {
            frequency_hz: sample.values[2 * k],
            damping_ratio: sample.values[2 * k + 1],
        });
        let modes = &modes[..usize::from(sample.count) / 2];
        if modes.is_empty() {
            return;
        }
        let sigma = self.known.accelerometer_sigma_m_s2;
        let (mut squares, mut whiteness, mut last) = (0.0, Whiteness::default(), 0.0);
        let time_s = |index| DecayRows::time_s(index, rate_hz);
        let outcome = appendage::for_each_residual(modes, tested.values(), channels, time_s, |residual, _| {
            squares += residual * residual / (sigma * sigma);
            whiteness.push(residual / sigma);
            last = residual;
        });
        // A decay too short to be refitted, or one with a number that is none, leaves no
        // innovations.
        if outcome.is_err() {
            return;
        }
        sample.nis_count = ((tested.len() - appendage::refit_unknowns(modes.len())) * channels) as f64;
        sample.nis_mean = squares / sample.nis_count;
        for (scale, verdict) in whiteness.verdicts().iter().enumerate() {
            sample.block_length[scale] = verdict.block_samples.into();
            sample.block_z[scale] = verdict.z_score;
        }
        let innovation = &mut sample.innovation;
        (innovation.t_ns, innovation.innovation, innovation.variance) = (tested.last_t_ns(), last, sigma * sigma);
        innovation.test_ratio = last * last / (GATE_SIGMAS * GATE_SIGMAS * innovation.variance);
        innovation.accepted = u32::from(innovation.test_ratio <= 1.0);
    }
}

fn refuse(sample: &mut ModalEstimate, error: &ModalError) {
    let status = match *error {
        ModalError::RecordTooShort { samples, need } => {
            (sample.record_samples, sample.record_samples_needed) = (samples, need);
            ModalStatus::RecordTooShort
        }
        ModalError::NoSignal { .. } => ModalStatus::FlatChannels,
        ModalError::DecompositionFailed { .. } => ModalStatus::DecompositionFailed,
    };
    sample.estimate.status = status.code().into();
}

/// The modes that are known best, in order of frequency.
fn best_known(mut modes: Vec<Mode>, most: usize) -> Vec<Mode> {
    let relative = |mode: &Mode| mode.sigma_frequency_hz / mode.frequency_hz;
    modes.sort_by(|a, b| relative(a).total_cmp(&relative(b)));
    modes.truncate(most);
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    modes
}

/// `channels` are the record's channels in use, from 0.
fn fill(sample: &mut ModalEstimate, modes: &[Mode], channels: &[usize]) {
    let common = &mut sample.estimate;
    common.count = 2 * modes.len() as u16;
    common.consistent = u32::from(!modes.is_empty() && modes.iter().all(|mode| mode.damping_ratio > 0.0));
    for (i, mode) in modes.iter().enumerate() {
        let (f, zeta) = (2 * i, 2 * i + 1);
        (common.values[f], common.values[zeta]) = (mode.frequency_hz, mode.damping_ratio);
        common.covariance[f][f] = mode.sigma_frequency_hz * mode.sigma_frequency_hz;
        common.covariance[zeta][zeta] = mode.sigma_damping * mode.sigma_damping;
        let both = mode.correlation * mode.sigma_frequency_hz * mode.sigma_damping;
        (common.covariance[f][zeta], common.covariance[zeta][f]) = (both, both);
        sample.modes[i].dominant_channel = channels[mode.dominant_channel] as u16 + 1;
    }
    if modes.is_empty() {
        common.status = ModalStatus::NoMode.code().into();
    }
}

#[cfg(test)]
mod tests;
