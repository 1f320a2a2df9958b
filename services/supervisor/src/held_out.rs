//! Held-out simulation: the last fifth of an experiment, predicted by an estimate that never saw it.
//!
//! The recorder of a domain keeps the rows behind the split frame (80 % of the experiment's length, known from the mode
//! sample) in memory taken once, and the newest estimate made up to the split. At the end the model is simulated over
//! the rows: inertial, the base rate that momentum conservation demands of the measured joints; slosh, a free run from
//! the estimate's own slosh state, driven by the measured force; modal, what a free decay with the estimate's poles
//! leaves over when its amplitudes are refitted.
//!
//! An experiment longer than the memory is thinned evenly: instants are skipped (inertial, modal) or consecutive
//! intervals merged to their means (slosh: exact while the force is constant over the merged interval).
//!
//! *Why not simulate with the closing estimate?* It was fitted to these rows; its error is small by construction.

use nalgebra::SVector;
use physics::appendage::{MODES, Mode, refit_free_decay_residual};
use physics::momentum::{MomentumSample, predict_base_rate};
use physics::slosh::{SloshParameters, SloshPropagator, SloshState};
use serde::{Deserialize, Serialize};
use telemetry::{ACCELEROMETERS_MAX, Estimate, PARAMETERS_MAX};

/// Most rows any recorder holds.
pub const ROWS_MAX: usize = 4096;

/// What the simulation of the held-out rows says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// Root mean square of measured minus simulated.
    pub rms: f64,
    /// What sensor noise alone would give.
    pub noise: f64,
    /// Root mean square of what was measured: an error of this size explains nothing.
    pub signal_rms: f64,
    pub count: u64,
}

/// The experiment to be recorded, from its mode sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Window {
    /// Effective frame of the mode sample.
    pub start_frame: u64,
    pub duration_frames: u64,
    pub generation: u32,
    /// Frames before the split from which rows are kept too: as long as estimates may lie apart (slosh), else 0.
    pub lead_frames: u64,
}

impl Window {
    /// Last frame an estimate may have seen: rows behind it are held out.
    pub fn split_frame(&self) -> u64 {
        self.start_frame + self.duration_frames * 4 / 5
    }

    fn first_kept(&self) -> u64 {
        self.split_frame().saturating_sub(self.lead_frames).max(self.start_frame)
    }

    fn keeps(&self, frame: u64) -> bool {
        frame > self.first_kept() && frame < self.start_frame + self.duration_frames
    }

    fn frames_kept(&self) -> u64 {
        self.start_frame + self.duration_frames - self.first_kept()
    }
}

/// The newest estimate made up to the split.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    pub frame: u64,
    pub count: usize,
    pub values: [f64; PARAMETERS_MAX],
    pub auxiliary: [f64; PARAMETERS_MAX],
}

/// Rows of one experiment behind (and shortly before) its split, and the estimate to be tested on them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Recorder<R> {
    window: Option<Window>,
    candidate: Option<Candidate>,
    /// Frame and row, in order.
    rows: Vec<(u64, R)>,
    capacity: usize,
}

impl<R> Recorder<R> {
    fn new(capacity: usize) -> Self {
        assert!(capacity > 0);
        assert!(capacity <= ROWS_MAX);
        Self { window: None, candidate: None, rows: Vec::with_capacity(capacity), capacity }
    }

    fn begin(&mut self, window: Window) {
        self.rows.clear();
        self.candidate = None;
        self.window = Some(window);
    }

    /// One row in how many, when `rows_per_frame` come.
    fn thinning(&self, rows_per_frame: u64) -> u64 {
        self.window.map_or(1, |window| (window.frames_kept() * rows_per_frame).div_ceil(self.capacity as u64).max(1))
    }

    fn keeps(&self, frame: u64) -> bool {
        self.rows.len() < self.capacity && self.window.is_some_and(|window| window.keeps(frame))
    }

    fn push(&mut self, frame: u64, row: R) {
        if self.keeps(frame) {
            // Memory is taken in `new`; a recorder out of a checkpoint takes it once, here.
            self.rows.reserve_exact(self.capacity - self.rows.len());
            self.rows.push((frame, row));
        }
    }

    /// An estimate of the running experiment; kept when it is the newest that has not seen the held-out rows.
    fn offer(&mut self, estimate: &Estimate) {
        let Some(window) = self.window else { return };
        let usable = estimate.status == 0
            && estimate.innovation.generation == u64::from(window.generation)
            && (window.start_frame..=window.split_frame()).contains(&estimate.frame)
            && self.candidate.is_none_or(|kept| kept.frame <= estimate.frame);
        if usable {
            self.candidate = Some(Candidate {
                frame: estimate.frame,
                count: usize::from(estimate.count).min(PARAMETERS_MAX),
                values: estimate.values,
                auxiliary: estimate.auxiliary,
            });
        }
    }

    /// Estimate and held-out frame limit, when there is something to test.
    fn subject(&self) -> Option<(Candidate, u64)> {
        Some((self.candidate?, self.window?.split_frame()))
    }
}

/// Sums of squares on the way to a [`HeldOut`].
#[derive(Default)]
struct Errors {
    error_squares: f64,
    signal_squares: f64,
    count: u64,
}

impl Errors {
    fn push(&mut self, measured: f64, simulated: f64) {
        self.error_squares += (measured - simulated) * (measured - simulated);
        self.signal_squares += measured * measured;
        self.count += 1;
    }

    fn finish(&self, noise: f64) -> Option<HeldOut> {
        let mean = |squares: f64| (squares / self.count as f64).sqrt();
        (self.count > 0).then(|| HeldOut {
            rms: mean(self.error_squares),
            noise,
            signal_rms: mean(self.signal_squares),
            count: self.count,
        })
    }
}

/// Held-out momentum samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InertialHeldOut {
    recorder: Recorder<MomentumSample>,
    rows_per_frame: u64,
    offered: u64,
    noise_rad_s: f64,
}

impl InertialHeldOut {
    /// `noise_rad_s`: standard deviation of one gyro sample minus its prediction when the model is perfect.
    pub fn new(capacity: usize, rows_per_frame: u64, noise_rad_s: f64) -> Self {
        Self { recorder: Recorder::new(capacity), rows_per_frame, offered: 0, noise_rad_s }
    }

    /// A prediction needs no row before the split: the window's lead is not used.
    pub fn begin(&mut self, window: Window) {
        self.recorder.begin(Window { lead_frames: 0, ..window });
        self.offered = 0;
    }

    pub fn offer(&mut self, estimate: &Estimate) {
        self.recorder.offer(estimate);
    }

    pub fn push(&mut self, frame: u64, sample: &MomentumSample) {
        if !self.recorder.keeps(frame) || !sample.is_finite() {
            return;
        }
        if self.offered.is_multiple_of(self.recorder.thinning(self.rows_per_frame)) {
            self.recorder.push(frame, *sample);
        }
        self.offered += 1;
    }

    /// Base rate predicted from the joints, against the gyro. `None` without a candidate or rows, or when the candidate
    /// has no positive inertia in a posture that occurred.
    pub fn close(&self, h_nms: f64) -> Option<HeldOut> {
        let (candidate, _) = self.recorder.subject()?;
        let mut errors = Errors::default();
        for (_, sample) in &self.recorder.rows {
            errors.push(sample.omega0_z_rad_s, predicted_base_rate(&candidate, h_nms, sample)?);
        }
        errors.finish(self.noise_rad_s)
    }
}

/// With eight parameters, or nine when the estimate has them.
fn predicted_base_rate(candidate: &Candidate, h_nms: f64, sample: &MomentumSample) -> Option<f64> {
    let (angle, rate) = (sample.joint_angle_rad, sample.joint_rate_rad_s);
    match candidate.count {
        8 => predict_base_rate(&SVector::<f64, 8>::from_fn(|i, _| candidate.values[i]), h_nms, angle, rate),
        9 => predict_base_rate(&SVector::<f64, 9>::from_fn(|i, _| candidate.values[i]), h_nms, angle, rate),
        _ => None,
    }
}

/// Force and mean acceleration over some consecutive intervals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct SloshRow {
    begin_s: f64,
    duration_s: f64,
    impulse_n_s: f64,
    velocity_change_m_s: f64,
    samples: u64,
}

impl SloshRow {
    fn end_s(&self) -> f64 {
        self.begin_s + self.duration_s
    }

    fn add(&mut self, interval_s: f64, force_n: f64, acceleration_m_s2: f64) {
        self.duration_s += interval_s;
        self.impulse_n_s += force_n * interval_s;
        self.velocity_change_m_s += acceleration_m_s2 * interval_s;
        self.samples += 1;
    }
}

/// Held-out force and acceleration on the slosh axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SloshHeldOut {
    recorder: Recorder<SloshRow>,
    frame_period_s: f64,
    base_mass_kg: f64,
    noise_m_s2: f64,
    open: Option<SloshRow>,
}

impl SloshHeldOut {
    /// `noise_m_s2`: standard deviation of one accelerometer sample.
    pub fn new(capacity: usize, frame_period_s: f64, base_mass_kg: f64, noise_m_s2: f64) -> Self {
        assert!(base_mass_kg > 0.0);
        assert!(frame_period_s > 0.0);
        Self { recorder: Recorder::new(capacity), frame_period_s, base_mass_kg, noise_m_s2, open: None }
    }

    /// Set the window's lead to the longest time between two estimates, else none may be early enough for its rows.
    pub fn begin(&mut self, window: Window) {
        self.recorder.begin(window);
        self.open = None;
    }

    pub fn offer(&mut self, estimate: &Estimate) {
        self.recorder.offer(estimate);
    }

    /// One interval from `begin_s` on: force held, mean acceleration measured.
    pub fn push(&mut self, frame: u64, begin_s: f64, interval_s: f64, force_n: f64, acceleration_m_s2: f64) {
        if !self.recorder.keeps(frame) || !(begin_s * interval_s * force_n * acceleration_m_s2).is_finite() {
            return;
        }
        let samples_per_row = self.samples_per_row(interval_s);
        let mut row = self.open.take().unwrap_or(SloshRow { begin_s, ..SloshRow::default() });
        row.add(interval_s, force_n, acceleration_m_s2);
        if row.samples >= samples_per_row {
            self.recorder.push(frame, row);
        } else {
            self.open = Some(row);
        }
    }

    /// Merges so many intervals that the rows of the whole window fit.
    fn samples_per_row(&self, interval_s: f64) -> u64 {
        let Some(window) = self.recorder.window else { return 1 };
        let samples = window.frames_kept() as f64 * self.frame_period_s / interval_s;
        (samples / self.recorder.capacity as f64).ceil().max(1.0) as u64
    }

    /// No interval is missing or doubled: a free run cannot jump.
    fn contiguous(&self) -> bool {
        /// Of a row: stamps may jitter by this much, a missing interval is more.
        const JITTER: f64 = 0.2;
        let fits = |pair: &[(u64, SloshRow)]| {
            let (row, next) = (&pair[0].1, &pair[1].1);
            (next.begin_s - row.end_s()).abs() <= JITTER * row.duration_s / row.samples as f64
        };
        self.recorder.rows.windows(2).all(fits)
    }

    /// Free run from the candidate's slosh state at the end of its arc (`auxiliary` 0 to 2: displacement, rate, time).
    /// `None` without a candidate whose time is covered, when an interval is missing, or when the slosh mass is not
    /// positive.
    pub fn close(&self) -> Option<HeldOut> {
        let (candidate, split_frame) = self.recorder.subject()?;
        let [m_s, k_s, c_s] = [candidate.values[0], candidate.values[1], candidate.values[2]];
        let [displacement_m, velocity_m_s, from_s] =
            [candidate.auxiliary[0], candidate.auxiliary[1], candidate.auxiliary[2]];
        let first = &self.recorder.rows.first()?.1;
        let slack_s = 0.5 * first.duration_s / first.samples as f64;
        if !(first.begin_s <= from_s + slack_s && self.contiguous() && m_s > 0.0) {
            return None;
        }
        let parameters = SloshParameters { slosh_mass_kg: m_s, stiffness_n_m: k_s, damping_n_s_m: c_s };
        let mut free_run =
            SloshPropagator::new(parameters, self.base_mass_kg, SloshState { displacement_m, velocity_m_s });
        let (mut errors, mut samples) = (Errors::default(), 0);
        let split_s = split_frame as f64 * self.frame_period_s;
        for (_, row) in self.recorder.rows.iter().filter(|(_, row)| row.end_s() > from_s + slack_s) {
            // The candidate's arc may end inside a merged row: only the part behind it is run through.
            let behind_s = (row.end_s() - from_s).min(row.duration_s);
            let simulated = free_run.step(behind_s, row.impulse_n_s / row.duration_s);
            if row.begin_s > split_s {
                errors.push(row.velocity_change_m_s / row.duration_s, simulated);
                samples += row.samples;
            }
        }
        let merged = samples as f64 / errors.count.max(1) as f64;
        errors.finish(self.noise_m_s2 / merged.max(1.0).sqrt())
    }
}

/// Held-out accelerometer rows of a free decay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModalHeldOut {
    /// Time of each row [s].
    recorder: Recorder<f64>,
    /// Rows of `channels` values, one after the other, as the refit takes them.
    accelerations_m_s2: Vec<f64>,
    rows_per_frame: u64,
    offered: u64,
    channels: usize,
    noise_m_s2: f64,
}

impl ModalHeldOut {
    /// `noise_m_s2`: standard deviation of one accelerometer sample.
    pub fn new(capacity: usize, rows_per_frame: u64, channels: usize, noise_m_s2: f64) -> Self {
        assert!(channels > 0);
        assert!(channels <= ACCELEROMETERS_MAX);
        let accelerations_m_s2 = Vec::with_capacity(capacity * channels);
        let recorder = Recorder::new(capacity);
        Self { recorder, accelerations_m_s2, rows_per_frame, offered: 0, channels, noise_m_s2 }
    }

    /// A refit needs no row before the split: the window's lead is not used.
    pub fn begin(&mut self, window: Window) {
        self.recorder.begin(Window { lead_frames: 0, ..window });
        self.accelerations_m_s2.clear();
        self.offered = 0;
    }

    pub fn offer(&mut self, estimate: &Estimate) {
        self.recorder.offer(estimate);
    }

    /// A row with a value that is not finite leaves a gap, and a record with a gap is not refitted.
    pub fn push(&mut self, frame: u64, time_s: f64, acceleration_m_s2: &[f64; ACCELEROMETERS_MAX]) {
        if !self.recorder.keeps(frame) {
            return;
        }
        let row = &acceleration_m_s2[..self.channels];
        let chosen = self.offered.is_multiple_of(self.recorder.thinning(self.rows_per_frame));
        self.offered += 1;
        if chosen && row.iter().all(|value| value.is_finite()) {
            self.recorder.push(frame, time_s);
            let room = self.recorder.capacity * self.channels;
            self.accelerations_m_s2.reserve_exact(room.saturating_sub(self.accelerations_m_s2.len()));
            self.accelerations_m_s2.extend_from_slice(row);
        }
    }

    /// Poles of the candidate held fixed, amplitudes and a constant refitted per channel. `None` without a candidate of
    /// exactly two modes, when rows are missing, or when they are too few to refit.
    pub fn close(&self) -> Option<HeldOut> {
        let (candidate, _) = self.recorder.subject()?;
        if candidate.count != 2 * MODES {
            return None;
        }
        let modes: [Mode; MODES] = core::array::from_fn(|k| Mode {
            frequency_hz: candidate.values[2 * k],
            damping_ratio: candidate.values[2 * k + 1],
        });
        let rate_hz = self.uniform_rate_hz()?;
        let left = refit_free_decay_residual(&modes, &self.accelerations_m_s2, self.channels, rate_hz).ok()?;
        Some(HeldOut {
            rms: left.residual_rms_m_s2,
            noise: self.noise_m_s2,
            signal_rms: left.signal_rms_m_s2,
            count: self.accelerations_m_s2.len() as u64,
        })
    }

    /// Rate of the rows kept; `None` when they are not evenly spaced.
    fn uniform_rate_hz(&self) -> Option<f64> {
        /// Of an interval: a tenth of it moves a row by less than its neighbour, a whole one is a gap.
        const JITTER: f64 = 0.1;
        let rows = &self.recorder.rows;
        let (first, last) = (rows.first()?.1, rows.last()?.1);
        let interval_s = (last - first) / rows.len().checked_sub(1)? as f64;
        let even = rows.windows(2).all(|pair| (pair[1].1 - pair[0].1 - interval_s).abs() < JITTER * interval_s);
        (even && interval_s > 0.0).then(|| 1.0 / interval_s)
    }
}

#[cfg(test)]
mod tests;
