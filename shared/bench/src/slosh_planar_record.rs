//! Data of a flight in the plane: samples, the noise of their sensors, and how thrusters follow
//! their commands.

use nalgebra::Vector2;

use crate::slosh_planar::Wrench;
use crate::slosh_planar_scan::PlanarSample;

/// Accelerations along x and y, rate.
pub(crate) const CHANNELS: usize = 3;

/// White standard deviation of a sample; infinite leaves a channel out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarNoise {
    pub acceleration_m_s2: f64,
    pub rate_rad_s: f64,
}

impl PlanarNoise {
    pub(crate) fn weights(&self) -> [f64; CHANNELS] {
        [self.acceleration_m_s2, self.acceleration_m_s2, self.rate_rad_s].map(|sigma| 1.0 / (sigma * sigma))
    }
}

/// A record with what is known of its sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarRecord<'a> {
    pub samples: &'a [PlanarSample],
    pub interval_s: f64,
    pub noise: PlanarNoise,
    /// Force commanded before the first sample, zero of a craft at rest: what late thrusters still
    /// do.
    pub force_before_n: Vector2<f64>,
}

impl<'a> PlanarRecord<'a> {
    /// A record of a craft without thrust before.
    pub fn new(samples: &'a [PlanarSample], interval_s: f64, noise: PlanarNoise) -> Self {
        Self { samples, interval_s, noise, force_before_n: Vector2::zeros() }
    }

    /// Its samples from one to before another.
    #[must_use]
    pub fn part(&self, from: usize, until: usize) -> Self {
        let force_before_n = self.before(from).wrench.force_n;
        Self { samples: &self.samples[from..until], force_before_n, ..*self }
    }

    /// The sample before sample k.
    fn before(&self, k: usize) -> PlanarSample {
        let held = Wrench { force_n: self.force_before_n, torque_n_m: 0.0 };
        k.checked_sub(1).map_or(PlanarSample { wrench: held, ..PlanarSample::default() }, |k| self.samples[k])
    }
}

/// What the thrusters along x and y make of a command: `scale (f(t − delay))`; the torque is as
/// commanded. A delay needs commands held over each sample: of sums of samples with edges within,
/// the delayed mean is not determined by mean and line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarThrust {
    pub scale: Vector2<f64>,
    /// Less than an interval.
    pub delay_s: Vector2<f64>,
}

impl Default for PlanarThrust {
    fn default() -> Self {
        Self { scale: Vector2::repeat(1.0), delay_s: Vector2::zeros() }
    }
}

impl PlanarThrust {
    /// Whether a late command of this record is known.
    ///
    /// # Errors
    /// [`PlanarError::DelayedSums`].
    pub fn check(&self, record: &PlanarRecord<'_>) -> Result<(), PlanarError> {
        let is_known = record.samples.iter().all(|sample| self.is_prompt(sample));
        is_known.then_some(()).ok_or(PlanarError::DelayedSums)
    }

    /// Along each axis prompt, or held.
    fn is_prompt(&self, sample: &PlanarSample) -> bool {
        self.delay_s.component_mul(&sample.wrench_change.force_n) == Vector2::zeros()
    }

    /// What acts at the beginning, in the middle and at the end of interval k; `None` where a
    /// command with edges within comes late.
    pub(crate) fn acting(&self, record: &PlanarRecord<'_>, k: usize) -> Option<[Wrench; 3]> {
        let (sample, before) = (&record.samples[k], record.before(k));
        if !(self.is_prompt(sample) && self.is_prompt(&before)) {
            return None;
        }
        let edge_n = sample.wrench.force_n - before.wrench.force_n;
        let late = self.delay_s / record.interval_s;
        let late_n = edge_n.component_mul(&late);
        // First moment of an edge that comes late: an edge of one at x has the line 6 x (1 − x).
        let bent_n = edge_n.component_mul(&late.map(|x| 6.0 * x * (1.0 - x)));
        let scaled = |wrench: &Wrench, late_n: Vector2<f64>| Wrench {
            force_n: (wrench.force_n - late_n).component_mul(&self.scale),
            ..*wrench
        };
        let mean = scaled(&sample.wrench, late_n);
        let change = scaled(&sample.wrench_change, -bent_n);
        Some([mean.plus(&change, -0.5), mean, mean.plus(&change, 0.5)])
    }
}

/// Why there is no estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanarError {
    /// The start is no craft, or some number leaves no trace in this record.
    NotObserved,
    /// Thrusters with a delay, and samples that sum over edges of their commands.
    DelayedSums,
    /// More lines (1/T) in the band than are searched.
    BandTooWide { lines: f64, most: usize },
    /// Fewer samples than twice the numbers.
    TooShort { got: usize, need: usize },
}

#[cfg(test)]
mod tests;
