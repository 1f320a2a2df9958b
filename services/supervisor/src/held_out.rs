//! Held-out simulation: the last fifth of an experiment, predicted by an estimate from the rows
//! before it.
//!
//! The recorder of a domain keeps the rows behind the split frame (80 % of the experiment's length,
//! known from the mode sample) in memory taken once, and the newest estimate made up to the split.
//! At the end the model is simulated over the rows: inertial, the base rate that momentum
//! conservation demands of the measured joints; slosh, a free run from the estimate's own slosh
//! state, driven by the measured force; modal, the residual of a free decay with the estimate's
//! poles when its amplitudes are refitted.
//!
//! An experiment longer than the memory is thinned evenly: instants are skipped (inertial, modal)
//! or consecutive intervals merged to their means (slosh: exact while the force is constant over
//! the merged interval). How many rows will come follows from the interval of the first one.
//!
//! *Why not simulate with the closing estimate?* It was fitted to these rows; its error is small by
//! construction.

mod inertial;
mod modal;
mod slosh;

use serde::{Deserialize, Serialize};
use telemetry::{Estimate, PARAMETERS_MAX};

pub use inertial::InertialHeldOut;
pub use modal::ModalHeldOut;
pub use slosh::SloshHeldOut;

/// Most rows any recorder holds.
pub const ROWS_MAX: usize = 4096;

/// Result of the simulation of the held-out rows, in the unit of the measurement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// Root mean square of measured minus simulated.
    pub rms: f64,
    /// The rms error that sensor noise alone would give.
    pub noise: f64,
    /// Root mean square of what was measured, about its mean: a model that predicts the mean errs
    /// by as much.
    pub signal_rms: f64,
    /// Values compared.
    pub count: u64,
}

/// The experiment to be recorded, from its mode sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Window {
    /// Effective frame of the mode sample.
    pub start_frame: u64,
    /// Length of the experiment.
    pub duration_frames: u64,
    /// Experiment counter: estimates of another one are not simulated.
    pub generation: u32,
    /// Length of a frame.
    pub frame_period_s: f64,
    /// Frames before the split from which rows are kept too: as long as estimates may lie apart
    /// (slosh), else 0.
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

    /// Length of what is kept.
    fn kept_s(&self) -> f64 {
        (self.start_frame + self.duration_frames - self.first_kept()) as f64 * self.frame_period_s
    }
}

/// The newest estimate made up to the split.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Frame after which it was made.
    pub frame: u64,
    /// Parameters in use.
    pub count: usize,
    /// In the units and order of the domain's parameters.
    pub values: [f64; PARAMETERS_MAX],
}

/// Rows of one experiment behind (and shortly before) its split, and the estimate to be tested on
/// them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Recorder<R> {
    window: Option<Window>,
    candidate: Option<Candidate>,
    /// Frame and row, in order.
    rows: Vec<(u64, R)>,
    capacity: usize,
    /// One row in how many, from the first row on.
    stride: Option<u64>,
    offered: u64,
}

impl<R> Recorder<R> {
    fn new(capacity: usize) -> Self {
        assert!(capacity > 0);
        assert!(capacity <= ROWS_MAX);
        Self { window: None, candidate: None, rows: Vec::with_capacity(capacity), capacity, stride: None, offered: 0 }
    }

    fn begin(&mut self, window: Window) {
        self.forget();
        self.window = Some(window);
    }

    fn forget(&mut self) {
        self.rows.clear();
        (self.window, self.candidate, self.stride, self.offered) = (None, None, None, 0);
    }

    /// One row in how many when they come every `interval_s`, so that all of them fit; decided by
    /// the first.
    fn stride(&mut self, interval_s: f64) -> u64 {
        let (kept_s, capacity) = (self.window.map_or(0.0, |window| window.kept_s()), self.capacity as f64);
        // A row of the length is lost where the interval does not divide it: rounding alone must
        // not double the stride.
        *self.stride.get_or_insert_with(|| (kept_s / interval_s / capacity - 1e-9).ceil().max(1.0) as u64)
    }

    /// Whether the next of the rows that come every `interval_s` is one to keep; counts it.
    fn chooses(&mut self, frame: u64, interval_s: f64) -> bool {
        if !(self.keeps(frame) && interval_s > 0.0) {
            return false;
        }
        let chosen = self.offered.is_multiple_of(self.stride(interval_s));
        self.offered += 1;
        chosen
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

    /// An estimate of the running experiment; kept, and `true`, when it is the newest that has not
    /// seen the held-out rows.
    fn offer(&mut self, estimate: &Estimate) -> bool {
        let Some(window) = self.window else { return false };
        let usable = estimate.status == 0
            && estimate.innovation.generation == u64::from(window.generation)
            && (window.start_frame..=window.split_frame()).contains(&estimate.frame)
            && self.candidate.is_none_or(|kept| kept.frame <= estimate.frame);
        if usable {
            self.candidate = Some(Candidate {
                frame: estimate.frame,
                count: usize::from(estimate.count).min(PARAMETERS_MAX),
                values: estimate.values,
            });
        }
        usable
    }

    /// Estimate and held-out frame limit, when there is something to test.
    fn subject(&self) -> Option<(Candidate, u64)> {
        Some((self.candidate?, self.window?.split_frame()))
    }
}

/// Sums on the way to a [`HeldOut`].
#[derive(Default)]
struct Errors {
    error_squares: f64,
    signal_mean: f64,
    /// Squared deviations from the mean (Welford).
    signal_squares: f64,
    count: u64,
}

impl Errors {
    fn push(&mut self, measured: f64, simulated: f64) {
        self.error_squares += (measured - simulated) * (measured - simulated);
        self.count += 1;
        let deviation = measured - self.signal_mean;
        self.signal_mean += deviation / self.count as f64;
        self.signal_squares += deviation * (measured - self.signal_mean);
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

#[cfg(test)]
mod tests;
