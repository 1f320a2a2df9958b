//! Held-out test of the inertial model: the base rate that momentum conservation demands of the
//! measured joints.

use super::{Candidate, Errors, HeldOut, Recorder, Window};
use nalgebra::SVector;
use physics::momentum::{MomentumSample, predict_base_rate};
use serde::{Deserialize, Serialize};
use telemetry::Estimate;

/// Held-out momentum samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InertialHeldOut {
    pub(super) recorder: Recorder<MomentumSample>,
    /// Of the first row: it says how noisy the gyro is.
    interval_s: Option<f64>,
}

impl InertialHeldOut {
    /// Takes memory for `capacity` rows.
    pub fn new(capacity: usize) -> Self {
        Self { recorder: Recorder::new(capacity), interval_s: None }
    }

    /// A prediction needs no row before the split: the window's lead is not used.
    pub fn begin(&mut self, window: Window) {
        self.recorder.begin(Window { lead_frames: 0, ..window });
        self.interval_s = None;
    }

    /// Takes an estimate made up to the split; the newest one is simulated.
    pub fn offer(&mut self, estimate: &Estimate) {
        self.recorder.offer(estimate);
    }

    /// A sample of a gyro that averages over `interval_s`.
    pub fn push(&mut self, frame: u64, interval_s: f64, sample: &MomentumSample) {
        if sample.is_finite() && self.recorder.chooses(frame, interval_s) {
            self.interval_s.get_or_insert(interval_s);
            self.recorder.push(frame, *sample);
        }
    }

    /// Base rate predicted from the joints, against the gyro, whose noise over an interval is
    /// `noise_rad_s`. `None` without a candidate or rows, or when the candidate has no positive
    /// inertia in a posture that occurred.
    pub fn close(&self, h_nms: f64, noise_rad_s: impl Fn(f64) -> f64) -> Option<HeldOut> {
        let (candidate, _) = self.recorder.subject()?;
        let mut errors = Errors::default();
        for (_, sample) in &self.recorder.rows {
            errors.push(sample.omega0_z_rad_s, predicted_base_rate(&candidate, h_nms, sample)?);
        }
        errors.finish(noise_rad_s(self.interval_s?))
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
