//! Held-out test of the slosh model: a free run of the tank, driven by the measured force.

use super::{Errors, HeldOut, Recorder, Window};
use physics::slosh::{SloshParameters, SloshPropagator, SloshState};
use serde::{Deserialize, Serialize};
use telemetry::SloshEstimate;

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

/// Where the free run begins: the slosh state at the end of the candidate's arc.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct ArcEnd {
    t_s: f64,
    state: SloshState,
    accelerometer_bias_m_s2: f64,
}

impl ArcEnd {
    fn of(sample: &SloshEstimate) -> Self {
        let state = SloshState { displacement_m: sample.displacement_m, velocity_m_s: sample.rate_m_s };
        Self { t_s: sample.arc_end_s, state, accelerometer_bias_m_s2: sample.accelerometer_bias_m_s2 }
    }
}

/// Held-out force and acceleration on the slosh axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SloshHeldOut {
    recorder: Recorder<SloshRow>,
    /// Of the recorder's candidate.
    arc_end: ArcEnd,
    base_mass_kg: f64,
    velocity_random_walk_m_s_sqrt_s: f64,
    /// Of the first sample: it says how noisy the accelerometer is.
    interval_s: Option<f64>,
    open: Option<SloshRow>,
}

impl SloshHeldOut {
    /// Takes memory for `capacity` rows. `base_mass_kg` is the mass without the slosh mass; the
    /// accelerometer's white noise is given as the random walk of its integral [m/s/√s].
    pub fn new(capacity: usize, base_mass_kg: f64, velocity_random_walk_m_s_sqrt_s: f64) -> Self {
        assert!(base_mass_kg > 0.0);
        let (recorder, arc_end) = (Recorder::new(capacity), ArcEnd::default());
        Self { recorder, arc_end, base_mass_kg, velocity_random_walk_m_s_sqrt_s, interval_s: None, open: None }
    }

    /// A new experiment. The window's lead must be the longest time between two estimates, so that
    /// the rows reach back to the end of an estimate's arc.
    pub fn begin(&mut self, window: Window) {
        self.recorder.begin(window);
        (self.open, self.interval_s) = (None, None);
    }

    /// Takes an estimate made up to the split, with the slosh state at the end of its arc: the free
    /// run of the newest one begins there.
    pub fn offer(&mut self, sample: &SloshEstimate) {
        if self.recorder.offer(&sample.estimate) {
            self.arc_end = ArcEnd::of(sample);
        }
    }

    /// One interval from `begin_s` on: force held, mean acceleration measured.
    pub fn push(&mut self, frame: u64, begin_s: f64, interval_s: f64, force_n: f64, acceleration_m_s2: f64) {
        let finite = (begin_s * interval_s * force_n * acceleration_m_s2).is_finite();
        if !(self.recorder.keeps(frame) && finite && interval_s > 0.0) {
            return;
        }
        self.interval_s.get_or_insert(interval_s);
        let samples_per_row = self.recorder.stride(interval_s);
        let mut row = self.open.take().unwrap_or(SloshRow { begin_s, ..SloshRow::default() });
        row.add(interval_s, force_n, acceleration_m_s2);
        if row.samples >= samples_per_row {
            self.recorder.push(frame, row);
        } else {
            self.open = Some(row);
        }
    }

    /// No interval is missing or doubled: a free run cannot jump.
    fn contiguous(&self) -> bool {
        /// Largest gap between a row's end and the next one's begin [sample intervals]; a missing
        /// sample leaves one.
        const JOIN_MISMATCH_MAX: f64 = 0.2;
        let fits = |pair: &[(u64, SloshRow)]| {
            let (row, next) = (&pair[0].1, &pair[1].1);
            (next.begin_s - row.end_s()).abs() <= JOIN_MISMATCH_MAX * row.duration_s / row.samples as f64
        };
        self.recorder.rows.windows(2).all(fits)
    }

    /// Free run from the candidate's slosh state at the end of its arc, against what was measured
    /// less the bias. `None` without a candidate whose time is covered, when an interval is
    /// missing, or when the slosh mass is not positive.
    pub fn close(&self) -> Option<HeldOut> {
        let (candidate, split_frame) = self.recorder.subject()?;
        let [m_s, k_s, c_s] = [candidate.values[0], candidate.values[1], candidate.values[2]];
        let ArcEnd { t_s: from_s, state, accelerometer_bias_m_s2: bias_m_s2 } = self.arc_end;
        let first = &self.recorder.rows.first()?.1;
        let slack_s = 0.5 * first.duration_s / first.samples as f64;
        if !(first.begin_s <= from_s + slack_s && self.contiguous() && m_s > 0.0) {
            return None;
        }
        let parameters = SloshParameters { slosh_mass_kg: m_s, stiffness_n_m: k_s, damping_n_s_m: c_s };
        let mut free_run = SloshPropagator::new(parameters, self.base_mass_kg, state);
        let (mut errors, mut samples) = (Errors::default(), 0);
        let split_s = split_frame as f64 * self.recorder.window?.frame_period_s;
        for (_, row) in self.recorder.rows.iter().filter(|(_, row)| row.end_s() > from_s + slack_s) {
            // The candidate's arc may end inside a merged row: only the part behind it is run
            // through.
            let behind_s = (row.end_s() - from_s).min(row.duration_s);
            let simulated = free_run.step(behind_s, row.impulse_n_s / row.duration_s);
            if row.begin_s > split_s {
                errors.push(row.velocity_change_m_s / row.duration_s - bias_m_s2, simulated);
                samples += row.samples;
            }
        }
        let merged = samples as f64 / errors.count.max(1) as f64;
        errors.finish(self.velocity_random_walk_m_s_sqrt_s / (self.interval_s? * merged.max(1.0)).sqrt())
    }
}
