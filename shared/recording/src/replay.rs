//! A recording as frames: the samples a source sends in each control period.
//!
//! Time is rounded to integer nanoseconds once, relative to the first row; frame `k` holds the rows
//! with `k = floor(t / period)`. Any frame can be asked for at any time, so that a source restarts
//! at a frame.
//!
//! Interval of a sample: the mean regular interval of the recording where its stamps jitter by less
//! than 1 % (then they are the noise of a clock or rounding, and the sampling itself is even), else
//! the time to the next row; behind a gap's first row and at the last row always the mean.
//!
//! A table does not say when an excitation is on: `excited` is derived per row
//! ([`crate::excitation`]). A recorded run says so itself.

use crate::Imported;
use crate::canonical::{
    ACCELERATION, ANGLE, CHANNELS, Channels, Domains, FORCE, JOINT_RATE, JOINT_TORQUE, RATE, TORQUE, WHEEL,
};
use crate::error::RecordingError;
use crate::excitation::Excitation;
use crate::map::ChannelMap;
use crate::replay_run::RunFrames;
use crate::run::RecordedRun;
use crate::spectrum::Spectrum;
use crate::table::Table;
use channels::GAP_MEDIANS;
use core::ops::Range;
use telemetry::{
    ACCELEROMETERS_MAX, ACTUATORS, Accelerometers, Actuators, BATCH_MAX, Header, IMU, Imu, JOINTS, Joints, TOPICS,
};

/// Jitter below which the stamps say nothing about a single interval.
const EVEN_JITTER: f64 = 0.01;

/// A sample of the source. Layout, source and sequence number are left to whoever sends it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "handed over by reference to the stack: a box would allocate per frame")]
pub enum ReplaySample {
    Imu(Imu),
    Joints(Joints),
    Actuators(Actuators),
    Accelerometers(Accelerometers),
}

/// A recording cut into frames.
#[derive(Debug)]
pub struct ReplayFrames {
    source: Source,
    notes: Vec<String>,
}

#[derive(Debug)]
enum Source {
    Table(Box<TableFrames>),
    Run(RunFrames),
}

impl ReplayFrames {
    /// Frames of `period_ns` of any imported recording.
    ///
    /// # Errors
    /// As [`ReplayFrames::from_table`] and [`ReplayFrames::from_run`]; a map together with a run;
    /// channels without one common rate, a file of several recordings, a spectrum.
    pub fn new(imported: &Imported, map: Option<&ChannelMap>, period_ns: u64) -> Result<Self, RecordingError> {
        match (imported, map) {
            (Imported::Table(table), map) => Self::from_table(table, map, period_ns),
            (Imported::Run(run), None) => Self::from_run(run, period_ns),
            (Imported::Run(run), Some(_)) => Err(RecordingError::MapOnRun { file: run.file().into() }),
            (Imported::Series(set), map) => Self::from_table(&set.table()?, map, period_ns),
            (Imported::Segments(segments), _) => Err(segments.refusal()),
            (Imported::Spectrum(spectrum), _) => Err(Spectrum::refusal(&spectrum.file)),
        }
    }

    /// Frames of a table.
    ///
    /// # Errors
    /// No channel found, a map that does not fit, more rows in a frame than a topic carries.
    pub fn from_table(table: &Table, map: Option<&ChannelMap>, period_ns: u64) -> Result<Self, RecordingError> {
        check_period(&table.file, period_ns)?;
        let frames = TableFrames::new(table, map, period_ns)?;
        let notes = table.notes.iter().chain(&frames.notes).cloned().collect();
        Ok(ReplayFrames { source: Source::Table(Box::new(frames)), notes })
    }

    /// Frames of a recorded run: the source's samples, in the frames in which they were flown (the
    /// recorded ticks).
    ///
    /// # Errors
    /// A period other than the recorded one; a run without samples of a source.
    pub fn from_run(run: &RecordedRun, period_ns: u64) -> Result<Self, RecordingError> {
        check_period(run.file(), period_ns)?;
        let (frames, notes) = RunFrames::new(run, period_ns)?;
        Ok(ReplayFrames { source: Source::Run(frames), notes })
    }

    /// Number of frames, the last one holds the last row.
    #[must_use]
    pub fn frame_count(&self) -> u64 {
        match &self.source {
            Source::Table(frames) => frames.frame_count(),
            Source::Run(frames) => frames.frame_count(),
        }
    }

    /// Emits the samples of frame `k` in the order of time; nothing in a gap and behind the end.
    pub fn frame(&self, k: u64, emit: &mut dyn FnMut(ReplaySample)) {
        match &self.source {
            Source::Table(frames) => frames.frame(k, emit),
            Source::Run(frames) => frames.frame(k, emit),
        }
    }

    /// What can be identified from this recording.
    #[must_use]
    pub fn identifiable(&self) -> Domains {
        match &self.source {
            Source::Table(frames) => frames.channels.identifiable(),
            Source::Run(frames) => frames.identifiable(),
        }
    }

    /// Repairs, doubts and second readings, for the reader of a report.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }
}

fn check_period(file: &str, period_ns: u64) -> Result<(), RecordingError> {
    // A batch counts the time of its rows in 32 bits.
    if period_ns > 0 && period_ns <= u64::from(u32::MAX) {
        return Ok(());
    }
    Err(RecordingError::Period {
        file: file.into(),
        period_ns,
        reason: "a frame lasts 1 ns to 4.29 s".into(),
        cure: "take the control period of the scenario, e.g. 10 ms".into(),
    })
}

/// The channels of a table, by row.
#[derive(Debug)]
struct TableFrames {
    period_ns: u64,
    t_ns: Vec<u64>,
    /// Per row, or one for all.
    interval_ns: Vec<u64>,
    interval_mean_ns: u64,
    channels: Channels,
    columns: Vec<Vec<f64>>,
    imu: bool,
    actuators: bool,
    /// Per row.
    excited: Vec<bool>,
    valid: u64,
    notes: Vec<String>,
}

impl TableFrames {
    fn new(table: &Table, map: Option<&ChannelMap>, period_ns: u64) -> Result<Self, RecordingError> {
        let channels = Channels::find(table, map)?;
        let t_ns: Vec<u64> = table.time_s.iter().map(|t| ((t - table.time_s[0]) * 1e9).round() as u64).collect();
        let actuators = channels.any(FORCE) || channels.any(TORQUE) || channels.any(WHEEL..WHEEL + 1);
        let driven = FORCE.chain(TORQUE).filter_map(|channel| channels.column(channel));
        let excitation = Excitation::find(t_ns.len(), driven.map(|column| table.columns[column].values.as_slice()));
        let valid = RATE.chain(ACCELERATION).enumerate();
        let valid = valid.map(|(bit, channel)| u64::from(channels.column(channel).is_some()) << bit).sum();
        let mut frames = TableFrames {
            period_ns,
            interval_ns: intervals(table, &t_ns),
            interval_mean_ns: (table.timing.interval_s * 1e9).round() as u64,
            t_ns,
            imu: channels.any(RATE) || channels.any(ACCELERATION),
            actuators,
            excited: excitation.on,
            valid,
            notes: channels.notes().to_vec(),
            columns: table.columns.iter().map(|column| column.values.clone()).collect(),
            channels,
        };
        if excitation.operational {
            frames.notes.push(
                "forces or torques act through nearly all of the record: taken as operational, without a free decay"
                    .into(),
            );
        }
        if !(frames.imu || frames.actuators || frames.channels.joints() > 0 || !frames.channels.array().is_empty()) {
            return Err(nothing_to_replay(table));
        }
        frames.check_rate(table)?;
        Ok(frames)
    }

    /// Refuses a recording that has more rows in a frame than a topic carries.
    fn check_rate(&mut self, table: &Table) -> Result<(), RecordingError> {
        let (mut worst, mut found, mut start) = (0, 0, 0);
        while start < self.t_ns.len() {
            let frame = self.t_ns[start] / self.period_ns;
            let rows = self.rows(frame);
            if rows.len() > found {
                (worst, found) = (frame, rows.len());
            }
            start = rows.end;
        }
        // Accelerations that serve as array need no IMU samples beside it.
        let array = !self.channels.array().is_empty();
        if self.imu && array && found > TOPICS[IMU.id].per_frame && !self.channels.any(RATE) {
            self.imu = false;
            self.notes.push("accelerations are too fast for IMU samples: replayed as accelerometer array only".into());
        }
        let streams = [
            ("imu", self.imu, TOPICS[IMU.id].per_frame),
            ("joints", self.channels.joints() > 0, TOPICS[JOINTS.id].per_frame),
            ("actuators", self.actuators, TOPICS[ACTUATORS.id].per_frame),
            ("accelerometers", array, BATCH_MAX),
        ];
        let rate_hz = 1.0 / table.timing.interval_s;
        match streams.into_iter().find(|(_, used, limit)| *used && found > *limit) {
            None => Ok(()),
            Some((stream, _, limit)) => Err(RecordingError::RateTooHigh {
                file: table.file.clone(),
                stream,
                frame: worst,
                found,
                limit,
                rate_hz,
                period_ms: self.period_ns as f64 * 1e-6,
                // A tenth of a millisecond below what just fits.
                period_ms_max: ((limit as f64 * 1e4 / rate_hz).ceil() - 1.0).max(0.0) / 10.0,
            }),
        }
    }

    fn frame_count(&self) -> u64 {
        self.t_ns.last().map_or(0, |last| last / self.period_ns + 1)
    }

    fn rows(&self, k: u64) -> Range<usize> {
        let start = self.t_ns.partition_point(|t| t / self.period_ns < k);
        start..self.t_ns.partition_point(|t| t / self.period_ns <= k)
    }

    fn frame(&self, k: u64, emit: &mut dyn FnMut(ReplaySample)) {
        let rows = self.rows(k);
        for row in rows.clone() {
            if self.imu {
                emit(ReplaySample::Imu(self.imu_sample(row)));
            }
            if self.channels.joints() > 0 {
                emit(ReplaySample::Joints(self.joints_sample(row)));
            }
            if self.actuators {
                emit(ReplaySample::Actuators(self.actuators_sample(row)));
            }
        }
        if !rows.is_empty() && !self.channels.array().is_empty() {
            emit(ReplaySample::Accelerometers(self.batch(rows)));
        }
    }

    fn interval_s(&self, row: usize) -> f64 {
        let interval_ns = self.interval_ns.get(row).copied().unwrap_or(self.interval_mean_ns);
        interval_ns as f64 / 1e9
    }

    /// The channels of a range at one row; absent ones are 0 and not valid.
    fn values<const N: usize>(&self, range: Range<usize>, row: usize) -> [f64; N] {
        core::array::from_fn(|i| self.channels.column(range.start + i).map_or(0.0, |column| self.columns[column][row]))
    }

    fn joint_torques_measured(&self) -> u64 {
        JOINT_TORQUE
            .enumerate()
            .filter(|(_, at)| self.channels.column(*at).is_some())
            .map(|(joint, _)| 1 << joint)
            .sum()
    }

    fn imu_sample(&self, row: usize) -> Imu {
        Imu {
            header: Header::at(self.t_ns[row]),
            interval_s: self.interval_s(row),
            omega_bi_b_rad_s: self.values(RATE, row),
            acceleration_b_m_s2: self.values(ACCELERATION, row),
            valid: self.valid,
        }
    }

    fn joints_sample(&self, row: usize) -> Joints {
        Joints {
            header: Header::at(self.t_ns[row]),
            count: self.channels.joints() as u64,
            angle_rad: self.values(ANGLE, row),
            rate_rad_s: self.values(JOINT_RATE, row),
            torque_nm: self.values(JOINT_TORQUE, row),
            torque_valid: self.joint_torques_measured(),
        }
    }

    fn actuators_sample(&self, row: usize) -> Actuators {
        let [wheel_momentum_nms] = self.values(WHEEL..WHEEL + 1, row);
        Actuators {
            header: Header::at(self.t_ns[row]),
            interval_s: self.interval_s(row),
            force_b_n: self.values(FORCE, row),
            torque_b_nm: self.values(TORQUE, row),
            wheel_momentum_nms,
            excited: u64::from(self.excited[row]),
        }
    }

    fn batch(&self, rows: Range<usize>) -> Accelerometers {
        let array = self.channels.array();
        let t_meas_ns = self.t_ns[rows.start];
        let mut batch = Accelerometers {
            header: Header::at(t_meas_ns),
            count: rows.len() as u32,
            channels: array.len() as u32,
            interval_ns: self.interval_mean_ns,
            offset_ns: [0; BATCH_MAX],
            acceleration_m_s2: [[0.0; ACCELEROMETERS_MAX]; BATCH_MAX],
        };
        for (i, row) in rows.enumerate() {
            batch.offset_ns[i] = (self.t_ns[row] - t_meas_ns) as u32;
            for (value, column) in batch.acceleration_m_s2[i].iter_mut().zip(array) {
                *value = self.columns[*column][row];
            }
        }
        batch
    }
}

/// Intervals per row where the stamps tell them apart, else none.
fn intervals(table: &Table, t_ns: &[u64]) -> Vec<u64> {
    if table.timing.jitter < EVEN_JITTER {
        return Vec::new();
    }
    let gap_ns = GAP_MEDIANS * table.timing.interval_median_s * 1e9;
    let mean = (table.timing.interval_s * 1e9).round() as u64;
    t_ns.windows(2).map(|pair| pair[1] - pair[0]).map(|ns| if ns as f64 > gap_ns { mean } else { ns }).collect()
}

fn nothing_to_replay(table: &Table) -> RecordingError {
    let headers: Vec<String> = table.columns.iter().map(crate::table::Column::header).collect();
    // An example that would be accepted: the first column whose unit some channel has.
    let fits = table.columns.iter().find_map(|column| {
        let channel = CHANNELS.iter().find(|channel| channel.unit == column.unit)?;
        Some(format!(
            "name the columns in a map file (--map): [channels], then {} = \"{}\"",
            channel.name,
            column.header()
        ))
    });
    let names: Vec<&str> = CHANNELS.iter().map(|channel| channel.name).collect();
    let cure = fits.unwrap_or_else(|| format!("no column has the unit of a channel; channels: {}", names.join(", ")));
    RecordingError::NothingToReplay { file: table.file.clone(), columns: headers.join(", "), cure }
}
