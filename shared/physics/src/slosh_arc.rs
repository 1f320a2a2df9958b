//! A record of any length in fixed memory: thrust and accelerometer summed in blocks.
//!
//! A block keeps its length, two moments of the force and the velocity gained with its variance. When the arc is full,
//! neighbours are merged and later blocks are twice as long. Summing Δv loses only what happens faster than a block; the
//! first moment keeps a thrust edge inside a block exact to second order in (ω × block length).

use nalgebra::{SMatrix, Vector2};
use serde::{Deserialize, Serialize};

use crate::slosh::ForceMoments;

/// Blocks of the arc that flies; 82 kB.
pub const FLIGHT_CAPACITY: usize = 2048;

/// Thrust held and acceleration averaged over one interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SloshSample {
    pub interval_s: f64,
    pub force_n: f64,
    pub acceleration_m_s2: f64,
    /// White standard deviation of the averaged acceleration: density over √interval.
    pub sigma_m_s2: f64,
}

impl SloshSample {
    fn is_usable(&self) -> bool {
        self.interval_s > 0.0
            && self.interval_s.is_finite()
            && self.force_n.is_finite()
            && self.acceleration_m_s2.is_finite()
            && self.sigma_m_s2 > 0.0
            && self.sigma_m_s2.is_finite()
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleRejected {
    /// Samples refused so far: not finite, or of no duration, or of no noise.
    pub rejected: u64,
}

/// Some consecutive samples, summed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SloshBlock {
    pub length_s: f64,
    pub force: ForceMoments,
    pub delta_v_m_s: f64,
    pub variance_m2_s2: f64,
}

impl SloshBlock {
    fn of(sample: &SloshSample) -> Self {
        let sigma_v = sample.sigma_m_s2 * sample.interval_s;
        Self {
            length_s: sample.interval_s,
            force: ForceMoments { impulse_n_s: sample.force_n * sample.interval_s, first_moment_n_s2: 0.0 },
            delta_v_m_s: sample.acceleration_m_s2 * sample.interval_s,
            variance_m2_s2: sigma_v * sigma_v,
        }
    }

    /// This block followed by `next`; first moments move to the middle of the whole.
    fn followed_by(&self, next: &Self) -> Self {
        let (a, b) = (&self.force, &next.force);
        let first_moment_n_s2 = a.first_moment_n_s2 + b.first_moment_n_s2 - a.impulse_n_s * next.length_s / 2.0
            + b.impulse_n_s * self.length_s / 2.0;
        Self {
            length_s: self.length_s + next.length_s,
            force: ForceMoments { impulse_n_s: a.impulse_n_s + b.impulse_n_s, first_moment_n_s2 },
            delta_v_m_s: self.delta_v_m_s + next.delta_v_m_s,
            variance_m2_s2: self.variance_m2_s2 + next.variance_m2_s2,
        }
    }

    pub(crate) fn force_vector(&self) -> Vector2<f64> {
        Vector2::new(self.force.impulse_n_s, self.force.first_moment_n_s2)
    }
}

/// Fixed-memory record. `CAPACITY` must be even.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SloshArc<const CAPACITY: usize = FLIGHT_CAPACITY> {
    /// One block per column: length, impulse, first moment, Δv, variance.
    columns: SMatrix<f64, 5, CAPACITY>,
    complete: usize,
    open: SloshBlock,
    open_samples: u64,
    samples_per_block: u64,
    samples: u64,
    rejected: u64,
    duration_s: f64,
}

impl<const CAPACITY: usize> Default for SloshArc<CAPACITY> {
    fn default() -> Self {
        const { assert!(CAPACITY >= 2 && CAPACITY.is_multiple_of(2)) }
        Self {
            columns: SMatrix::zeros(),
            complete: 0,
            open: SloshBlock::default(),
            open_samples: 0,
            samples_per_block: 1,
            samples: 0,
            rejected: 0,
            duration_s: 0.0,
        }
    }
}

impl<const CAPACITY: usize> SloshArc<CAPACITY> {
    /// # Errors
    /// [`SampleRejected`] for a sample that is not finite or has no duration or no sigma; the arc is untouched.
    pub fn push(&mut self, sample: &SloshSample) -> Result<(), SampleRejected> {
        if !sample.is_usable() {
            self.rejected += 1;
            return Err(SampleRejected { rejected: self.rejected });
        }
        let block = SloshBlock::of(sample);
        self.open = if self.open_samples == 0 { block } else { self.open.followed_by(&block) };
        self.open_samples += 1;
        self.samples += 1;
        self.duration_s += sample.interval_s;
        if self.open_samples == self.samples_per_block {
            self.close_block();
        }
        Ok(())
    }

    pub fn samples(&self) -> u64 {
        self.samples
    }

    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Blocks to compute with; an incomplete last one counts.
    pub fn len(&self) -> usize {
        self.complete + usize::from(self.open_samples > 0)
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// In order of time, the incomplete last one included.
    pub fn blocks(&self) -> impl Iterator<Item = SloshBlock> + '_ {
        let open = (self.open_samples > 0).then_some(self.open);
        (0..self.complete).map(|i| self.block(i)).chain(open)
    }

    /// Length of a complete block; the mean length before the first is complete.
    pub fn block_length_s(&self) -> f64 {
        if self.complete > 0 { self.columns[(0, 0)] } else { self.open.length_s }
    }

    fn block(&self, i: usize) -> SloshBlock {
        let c = self.columns.column(i);
        SloshBlock {
            length_s: c[0],
            force: ForceMoments { impulse_n_s: c[1], first_moment_n_s2: c[2] },
            delta_v_m_s: c[3],
            variance_m2_s2: c[4],
        }
    }

    fn store(&mut self, i: usize, block: &SloshBlock) {
        let force = &block.force;
        let column =
            [block.length_s, force.impulse_n_s, force.first_moment_n_s2, block.delta_v_m_s, block.variance_m2_s2];
        self.columns.set_column(i, &column.into());
    }

    fn close_block(&mut self) {
        let block = self.open;
        self.store(self.complete, &block);
        self.complete += 1;
        self.open_samples = 0;
        if self.complete == CAPACITY {
            for i in 0..CAPACITY / 2 {
                let merged = self.block(2 * i).followed_by(&self.block(2 * i + 1));
                self.store(i, &merged);
            }
            self.complete = CAPACITY / 2;
            self.samples_per_block *= 2;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(k: u32) -> SloshSample {
        let t = f64::from(k);
        SloshSample {
            interval_s: 0.1,
            force_n: 44.0 * libm::sin(0.07 * t),
            acceleration_m_s2: 0.01 * libm::cos(0.03 * t),
            sigma_m_s2: 4.2e-4,
        }
    }

    #[test]
    fn sums_and_moments_survive_every_merge() {
        let mut small = SloshArc::<16>::default();
        let (mut impulse, mut moment, mut delta_v, mut variance) = (0.0, 0.0, 0.0, 0.0);
        for k in 0..1000 {
            let one = sample(k);
            small.push(&one).expect("finite");
            let mid = (f64::from(k) + 0.5) * 0.1;
            impulse += one.force_n * 0.1;
            moment += one.force_n * 0.1 * mid;
            delta_v += one.acceleration_m_s2 * 0.1;
            variance += 4.2e-5 * 4.2e-5;
        }
        let mut start = 0.0;
        let mut found = [0.0; 4];
        for block in small.blocks() {
            let mid = start + block.length_s / 2.0;
            found[0] += block.force.impulse_n_s;
            found[1] += block.force.impulse_n_s * mid + block.force.first_moment_n_s2;
            found[2] += block.delta_v_m_s;
            found[3] += block.variance_m2_s2;
            start += block.length_s;
        }
        assert!(small.len() <= 16 && (start - 100.0).abs() < 1e-9);
        for (value, expected) in found.into_iter().zip([impulse, moment, delta_v, variance]) {
            assert!((value - expected).abs() < 1e-10 * expected.abs().max(1.0)); // rounding of 1000 sums
        }
    }

    #[test]
    fn broken_samples_are_counted_and_leave_no_trace() {
        let mut arc = SloshArc::<16>::default();
        arc.push(&sample(1)).expect("finite");
        let before: SloshBlock = arc.blocks().next().expect("one");
        for broken in [
            SloshSample { acceleration_m_s2: f64::NAN, ..sample(2) },
            SloshSample { interval_s: 0.0, ..sample(2) },
            SloshSample { interval_s: -0.1, ..sample(2) },
            SloshSample { sigma_m_s2: 0.0, ..sample(2) },
        ] {
            assert!(arc.push(&broken).is_err());
        }
        assert_eq!((arc.samples(), arc.rejected, arc.len()), (1, 4, 1));
        assert_eq!(arc.blocks().next(), Some(before));
    }

    #[test]
    fn a_checkpoint_continues_bit_for_bit() {
        let mut original = SloshArc::<64>::default();
        for k in 0..777 {
            original.push(&sample(k)).expect("finite");
        }
        let bytes = postcard::to_stdvec(&original).expect("plain numbers");
        let mut restored: SloshArc<64> = postcard::from_bytes(&bytes).expect("own bytes");
        for k in 777..1500 {
            original.push(&sample(k)).expect("finite");
            restored.push(&sample(k)).expect("finite");
        }
        assert_eq!(original, restored);
    }
}
