//! Held-out test of a modal model: the residual of a free decay with its poles when the amplitudes
//! are refitted.

use super::{HeldOut, Recorder, Window};
use physics::appendage::{Mode, REFIT_MODES_MAX, refit_free_decay_residual};
use serde::{Deserialize, Serialize};
use telemetry::{ACCELEROMETERS_MAX, Estimate, PARAMETERS_MAX};

/// Held-out accelerometer rows of a free decay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModalHeldOut {
    /// Time of each row [s].
    pub(super) recorder: Recorder<f64>,
    /// Rows of `channels` values, one after the other, as the refit takes them.
    pub(super) accelerations_m_s2: Vec<f64>,
    channels: Vec<usize>,
    noise_m_s2: f64,
}

impl ModalHeldOut {
    /// With room for `capacity` rows of `channels_max` channels. `noise_m_s2`: standard deviation
    /// of one accelerometer sample.
    pub fn new(capacity: usize, channels_max: usize, noise_m_s2: f64) -> Self {
        assert!(channels_max <= ACCELEROMETERS_MAX);
        let accelerations_m_s2 = Vec::with_capacity(capacity * channels_max);
        let channels = Vec::with_capacity(channels_max);
        Self { recorder: Recorder::new(capacity), accelerations_m_s2, channels, noise_m_s2 }
    }

    /// `channels`: those used, numbered from 0. A refit needs no row before the split: the window's
    /// lead is not used.
    pub fn begin(&mut self, window: Window, channels: impl Iterator<Item = usize>) {
        self.forget();
        self.channels.extend(channels);
        assert!(self.channels.iter().all(|&channel| channel < ACCELEROMETERS_MAX));
        self.recorder.begin(Window { lead_frames: 0, ..window });
    }

    /// As before the first experiment.
    pub fn forget(&mut self) {
        self.recorder.forget();
        self.channels.clear();
        self.accelerations_m_s2.clear();
    }

    /// An experiment is recorded.
    pub fn has_begun(&self) -> bool {
        !self.channels.is_empty()
    }

    /// Takes an estimate made up to the split; the newest one is simulated.
    pub fn offer(&mut self, estimate: &Estimate) {
        self.recorder.offer(estimate);
    }

    /// One of the rows that come every `interval_s`. A row with a value that is not finite leaves a
    /// gap, and a record with a gap is not refitted.
    pub fn push(&mut self, frame: u64, time_s: f64, interval_s: f64, acceleration_m_s2: &[f64; ACCELEROMETERS_MAX]) {
        let finite = self.channels.iter().all(|&channel| acceleration_m_s2[channel].is_finite());
        if self.recorder.chooses(frame, interval_s) && finite {
            self.recorder.push(frame, time_s);
            let room = self.recorder.capacity * self.channels.len();
            self.accelerations_m_s2.reserve_exact(room.saturating_sub(self.accelerations_m_s2.len()));
            self.accelerations_m_s2.extend(self.channels.iter().map(|&channel| acceleration_m_s2[channel]));
        }
    }

    /// Poles of the candidate held fixed, amplitudes and a constant refitted per channel. `None`
    /// without a candidate with a mode, when rows are missing, or when they are too few to refit.
    pub fn close(&self) -> Option<HeldOut> {
        let (candidate, _) = self.recorder.subject()?;
        let mut modes = [Mode::default(); PARAMETERS_MAX / 2];
        let pairs = candidate.values[..candidate.count].chunks_exact(2);
        let count = pairs.len();
        for (mode, pair) in modes.iter_mut().zip(pairs) {
            *mode = Mode { frequency_hz: pair[0], damping_ratio: pair[1] };
        }
        if !(1..=REFIT_MODES_MAX).contains(&count) {
            return None;
        }
        let rate_hz = self.uniform_rate_hz()?;
        let channels = self.channels.len();
        let left = refit_free_decay_residual(&modes[..count], &self.accelerations_m_s2, channels, rate_hz).ok()?;
        Some(HeldOut {
            rms: left.residual_rms_m_s2,
            noise: self.noise_m_s2,
            signal_rms: left.signal_rms_m_s2,
            count: self.accelerations_m_s2.len() as u64,
        })
    }

    /// Rate of the rows kept; `None` when they are not evenly spaced.
    fn uniform_rate_hz(&self) -> Option<f64> {
        /// Largest deviation of a row's time from an even grid [intervals]; a missing row deviates
        /// by one.
        const GRID_DEVIATION_MAX: f64 = 0.1;
        let rows = &self.recorder.rows;
        let (first, last) = (rows.first()?.1, rows.last()?.1);
        let interval_s = (last - first) / rows.len().checked_sub(1)? as f64;
        let even =
            rows.windows(2).all(|pair| (pair[1].1 - pair[0].1 - interval_s).abs() < GRID_DEVIATION_MAX * interval_s);
        (even && interval_s > 0.0).then(|| 1.0 / interval_s)
    }
}
