//! Frames of a recorded run: what the source sent, in the frames in which it was flown.
//!
//! The recorded ticks say which sequence numbers belong to a frame (architecture D10). Samples that
//! a restarted source sent again are taken once; samples behind the last tick belong to a frame
//! that never closed and are left out.

use crate::canonical::Domains;
use crate::error::RecordingError;
use crate::replay::ReplaySample;
use crate::run::RecordedRun;
use core::ops::Range;
use std::collections::BTreeMap;
use telemetry::{
    ACCELEROMETERS, ACCELEROMETERS_MAX, ACTUATORS, Accelerometers, Actuators, BATCH_MAX, Experiment, Header, IMU, Imu,
    JOINTS, Joints, MODE, Mode, Sample, TICK, TOPICS, Tick, Topic,
};

/// The source's samples of a run, each topic in the order of frames.
#[derive(Debug, Default)]
pub(crate) struct RunFrames {
    frames: u64,
    /// Time of the first frame in the recording: what is replayed begins at 0.
    begin_ns: u64,
    imu: Vec<(u64, Imu)>,
    joints: Vec<(u64, Joints)>,
    actuators: Vec<(u64, Actuators)>,
    batches: Vec<(u64, Batch)>,
    offsets: Vec<u32>,
    values: Vec<f64>,
}

/// A batch without its unused rows: a full one is 6 KiB, mostly empty.
#[derive(Clone, Debug)]
struct Batch {
    t_meas_ns: u64,
    channels: u32,
    interval_ns: u64,
    offsets: Range<usize>,
    values: Range<usize>,
}

impl RunFrames {
    /// The input samples of a recorded run, in frames of `period_ns` [ns], and notes on what was
    /// left aside.
    ///
    /// # Errors
    /// [`RecordingError`] where the run was recorded with another period, or holds no samples to
    /// replay.
    pub fn new(run: &RecordedRun, period_ns: u64) -> Result<(Self, Vec<String>), RecordingError> {
        let ticks: BTreeMap<u64, Tick> = run.of(TICK).map(|(_, tick)| (tick.frame, *tick)).collect();
        let ticks: Vec<Tick> = ticks.into_values().collect();
        check_recorded_period(run, &ticks, period_ns)?;
        let mut notes = Vec::new();
        let within = experiment_frames(run)?;
        let mut frames = RunFrames {
            begin_ns: within.start.saturating_mul(period_ns),
            imu: owned(by_frame(run, IMU, &ticks, period_ns, &mut notes), &within),
            joints: owned(by_frame(run, JOINTS, &ticks, period_ns, &mut notes), &within),
            actuators: owned(by_frame(run, ACTUATORS, &ticks, period_ns, &mut notes), &within),
            ..RunFrames::default()
        };
        let batches = by_frame(run, ACCELEROMETERS, &ticks, period_ns, &mut notes);
        for (frame, batch) in batches.into_iter().filter_map(|(frame, batch)| Some((placed(frame, &within)?, batch))) {
            let batch = frames.compact(batch);
            frames.batches.push((frame, batch));
        }
        frames.frames = [
            ticks.last().map(|tick| tick.frame.min(within.end - 1).saturating_sub(within.start)),
            frames.imu.last().map(|(frame, _)| *frame),
            frames.joints.last().map(|(frame, _)| *frame),
            frames.actuators.last().map(|(frame, _)| *frame),
            frames.batches.last().map(|(frame, _)| *frame),
        ]
        .into_iter()
        .flatten()
        .max()
        .map_or(0, |last| last.saturating_add(1));
        if frames.imu.is_empty() && frames.joints.is_empty() && frames.actuators.is_empty() && frames.batches.is_empty()
        {
            return Err(RecordingError::NothingToReplay {
                file: run.file().into(),
                columns: "no sample of imu, joints, actuators, accelerometers".into(),
                cure: "record the run with `obsid run --record FILE`: a digest needs the results alone, a replay the sensors".into(),
            });
        }
        Ok((frames, notes))
    }

    fn compact(&mut self, batch: &Accelerometers) -> Batch {
        let (rows, channels) =
            ((batch.count as usize).min(BATCH_MAX), (batch.channels as usize).min(ACCELEROMETERS_MAX));
        let (offset_start, value_start) = (self.offsets.len(), self.values.len());
        self.offsets.extend_from_slice(&batch.offset_ns[..rows]);
        batch.acceleration_m_s2[..rows].iter().for_each(|row| self.values.extend_from_slice(&row[..channels]));
        Batch {
            t_meas_ns: batch.header.t_meas_ns,
            channels: channels as u32,
            interval_ns: batch.interval_ns,
            offsets: offset_start..self.offsets.len(),
            values: value_start..self.values.len(),
        }
    }

    fn expand(&self, batch: &Batch) -> Accelerometers {
        let mut sample = Accelerometers {
            header: Header::at(batch.t_meas_ns.saturating_sub(self.begin_ns)),
            count: batch.offsets.len() as u32,
            channels: batch.channels,
            interval_ns: batch.interval_ns,
            offset_ns: [0; BATCH_MAX],
            acceleration_m_s2: [[0.0; ACCELEROMETERS_MAX]; BATCH_MAX],
        };
        sample.offset_ns[..batch.offsets.len()].copy_from_slice(&self.offsets[batch.offsets.clone()]);
        let channels = batch.channels as usize;
        let rows = self.values[batch.values.clone()].chunks_exact(channels.max(1));
        for (row, values) in sample.acceleration_m_s2.iter_mut().zip(rows) {
            row[..channels].copy_from_slice(values);
        }
        sample
    }

    fn at(&self, recorded: &Header) -> Header {
        Header::at(recorded.t_meas_ns.saturating_sub(self.begin_ns))
    }

    /// Frames from the first to the last sample.
    pub fn frame_count(&self) -> u64 {
        self.frames
    }

    /// Emits the samples of frame `k` with stamps from the beginning of the replay [ns], in the
    /// order IMU, joints, actuators, accelerometers.
    pub fn frame(&self, k: u64, emit: &mut dyn FnMut(ReplaySample)) {
        for (_, imu) in &self.imu[range(&self.imu, k)] {
            emit(ReplaySample::Imu(Imu { header: self.at(&imu.header), ..*imu }));
        }
        for (_, joints) in &self.joints[range(&self.joints, k)] {
            emit(ReplaySample::Joints(Joints { header: self.at(&joints.header), ..*joints }));
        }
        for (_, actuators) in &self.actuators[range(&self.actuators, k)] {
            emit(ReplaySample::Actuators(Actuators { header: self.at(&actuators.header), ..*actuators }));
        }
        for (_, batch) in &self.batches[range(&self.batches, k)] {
            emit(ReplaySample::Accelerometers(self.expand(batch)));
        }
    }

    /// The domains whose sensors and inputs the recording holds.
    pub fn identifiable(&self) -> Domains {
        const RATE_Z: u64 = 1 << 2;
        let valid = self.imu.iter().fold(0, |bits, (_, imu)| bits | imu.valid);
        Domains {
            inertial: valid & RATE_Z != 0 && self.joints.iter().any(|(_, joints)| joints.count >= 2),
            slosh: valid >> 3 != 0 && self.actuators.iter().any(|(_, actuators)| actuators.force_b_n != [0.0; 3]),
            modal: !self.batches.is_empty(),
        }
    }
}

fn range<T>(samples: &[(u64, T)], k: u64) -> Range<usize> {
    samples.partition_point(|(frame, _)| *frame < k)..samples.partition_point(|(frame, _)| *frame <= k)
}

/// The number of `frame` among those that are replayed.
fn placed(frame: u64, within: &Range<u64>) -> Option<u64> {
    within.contains(&frame).then(|| frame - within.start)
}

fn owned<T: Copy>(samples: Vec<(u64, &T)>, within: &Range<u64>) -> Vec<(u64, T)> {
    samples.into_iter().filter_map(|(frame, sample)| Some((placed(frame, within)?, *sample))).collect()
}

/// The frames that are replayed: those of the run's experiment, or all where the recording tells of
/// none.
///
/// An idle vehicle before and behind it would be taken as part of the experiment, and several
/// experiments, each on a system of its own, as one on a system that never was.
fn experiment_frames(run: &RecordedRun) -> Result<Range<u64>, RecordingError> {
    let experiments: BTreeMap<u32, &Mode> =
        run.of(MODE).filter(|(_, mode)| mode.duration_frames > 0).map(|(_, mode)| (mode.generation, mode)).collect();
    let frames = |mode: &Mode| {
        let end = mode.effective_frame.saturating_add(mode.duration_frames);
        mode.effective_frame..end.max(mode.effective_frame.saturating_add(1))
    };
    match experiments.len() {
        0 => Ok(0..u64::MAX),
        1 => Ok(experiments.values().map(|mode| frames(mode)).next().unwrap_or(0..u64::MAX)),
        count => {
            let name = |mode: &&Mode| Experiment::from_code(mode.experiment).map_or("unknown", Experiment::text);
            let of =
                |mode: &&Mode| format!("{} (frames {} to {})", name(mode), frames(mode).start, frames(mode).end - 1);
            let experiments = experiments.values().map(of).collect::<Vec<_>>().join(", ");
            Err(RecordingError::SeveralExperiments { file: run.file().into(), count, experiments })
        }
    }
}

/// Samples of a topic with their frames, in the order of their sequence numbers, each once.
fn by_frame<'r, T: Sample>(
    run: &'r RecordedRun,
    topic: Topic<T>,
    ticks: &[Tick],
    period_ns: u64,
    notes: &mut Vec<String>,
) -> Vec<(u64, &'r T)> {
    let mut samples: BTreeMap<u64, &T> = BTreeMap::new();
    for (_, sample) in run.of(topic) {
        samples.entry(sample.header().seq).or_insert(sample);
    }
    if let (Some(first), Some(last)) = (samples.keys().next(), samples.keys().next_back()) {
        let missing = (last - first).saturating_sub(samples.len() as u64 - 1);
        if missing > 0 {
            notes.push(format!("{missing} sample(s) of `{}` are missing in the recording", TOPICS[topic.id].name));
        }
    }
    let taken = samples.into_iter().filter_map(|(seq, sample)| {
        let frame = if ticks.is_empty() {
            sample.header().t_meas_ns / period_ns
        } else {
            ticks.get(ticks.partition_point(|tick| tick.last_seq[topic.id] < seq))?.frame
        };
        Some((frame, sample))
    });
    let mut taken: Vec<_> = taken.collect();
    // Sequence order is frame order in a recorded run; a foreign time order is brought into it.
    taken.sort_by_key(|(frame, _)| *frame);
    taken
}

/// A run is replayed with the period it was flown with.
fn check_recorded_period(run: &RecordedRun, ticks: &[Tick], period_ns: u64) -> Result<(), RecordingError> {
    let (Some(first), Some(last)) = (ticks.first(), ticks.last()) else { return Ok(()) };
    let frames = last.frame - first.frame;
    let recorded_ns = last.t_ns.saturating_sub(first.t_ns).checked_div(frames).unwrap_or(period_ns);
    if recorded_ns == period_ns {
        return Ok(());
    }
    Err(RecordingError::Period {
        file: run.file().into(),
        period_ns,
        reason: format!("the run was flown with {recorded_ns} ns"),
        cure: format!("replay it with a control period of {} ms", recorded_ns as f64 * 1e-6),
    })
}
