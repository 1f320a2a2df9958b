//! A record of any length in fixed memory: thrust and accelerometer summed in blocks.
//!
//! A block keeps its length, two moments of the force and the velocity gained with its variance.
//! When the arc is full, neighbours are merged and later blocks are twice as long, or the oldest
//! blocks are forgotten: the estimator decides, for summing Δv loses what happens faster than a
//! block. The first moment keeps a thrust edge inside a block exact to second order in (ω × block
//! length).
//!
//! Blocks that do not meet in time belong to different segments: what the thrust did in between is
//! not known, so nothing is known of the slosh state behind the gap either.

use nalgebra::{SMatrix, Vector2};
use serde::{Deserialize, Serialize};

use crate::slosh::ForceMoments;

/// Blocks of the arc that flies; 98 kB.
pub const FLIGHT_CAPACITY: usize = 2048;

/// Segments an arc can hold; one more, and the oldest is forgotten.
pub const SEGMENTS_MAX: usize = 32;

/// Stamps jitter: a sample that misses the end of the last one by less than this part of its
/// interval meets it.
const JITTER: f64 = 0.5;

/// ω × block length up to which a merged block still tells a mode: 21 blocks per period. The force
/// inside a block beyond its two moments moves the slosh by (ωB)³/190 of a thrust edge, and
/// (ωB)²/12 of the information is lost.
pub const RESOLVED_MERGED: f64 = 0.3;

/// The same for blocks of one sample, where the held force is exact: nine tenths of the Nyquist
/// frequency.
pub const RESOLVED_SINGLE: f64 = 0.9 * core::f64::consts::PI;

/// Block lengths closer than this share one transition: sums of equal intervals differ by rounding
/// only.
pub(crate) const SAME_LENGTH: f64 = 1e-12;

/// Thrust held and acceleration averaged over one interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SloshSample {
    pub interval_s: f64,
    pub force_n: f64,
    pub acceleration_m_s2: f64,
    /// White standard deviation of the averaged acceleration: density over √interval. Infinite when
    /// the accelerometer said nothing: the force still drives the slosh.
    pub sigma_m_s2: f64,
}

impl SloshSample {
    /// Thrust alone, known while the accelerometer said nothing.
    pub fn thrust_alone(interval_s: f64, force_n: f64) -> Self {
        Self { interval_s, force_n, acceleration_m_s2: 0.0, sigma_m_s2: f64::INFINITY }
    }

    fn is_usable(&self) -> bool {
        self.interval_s > 0.0
            && self.interval_s.is_finite()
            && self.force_n.is_finite()
            && self.acceleration_m_s2.is_finite()
            && self.sigma_m_s2 > 0.0
    }
}

/// A sample was not used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleRejected {
    /// Samples rejected so far: not finite, of no duration, of no noise, or older than the arc's
    /// end.
    pub rejected: u64,
}

/// Some consecutive samples, summed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SloshBlock {
    pub length_s: f64,
    pub force: ForceMoments,
    /// At the end of the block.
    pub last_force_n: f64,
    pub delta_v_m_s: f64,
    /// Infinite when the velocity gained is not known.
    pub variance_m2_s2: f64,
}

impl SloshBlock {
    fn of(sample: &SloshSample) -> Self {
        let sigma_v = sample.sigma_m_s2 * sample.interval_s;
        Self {
            length_s: sample.interval_s,
            force: ForceMoments { impulse_n_s: sample.force_n * sample.interval_s, first_moment_n_s2: 0.0 },
            last_force_n: sample.force_n,
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
            last_force_n: next.last_force_n,
            delta_v_m_s: self.delta_v_m_s + next.delta_v_m_s,
            variance_m2_s2: self.variance_m2_s2 + next.variance_m2_s2,
        }
    }

    /// Zero when the velocity gained is not known.
    pub(crate) fn weight(&self) -> f64 {
        1.0 / self.variance_m2_s2
    }

    pub(crate) fn is_measured(&self) -> bool {
        self.variance_m2_s2.is_finite()
    }

    pub(crate) fn force_vector(&self) -> Vector2<f64> {
        Vector2::new(self.force.impulse_n_s, self.force.first_moment_n_s2)
    }
}

/// Fixed-memory record. `CAPACITY` must be even.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SloshArc<const CAPACITY: usize = FLIGHT_CAPACITY> {
    /// One block per column: length, impulse, first moment, Δv, variance, last force.
    columns: SMatrix<f64, 6, CAPACITY>,
    complete: usize,
    open: SloshBlock,
    open_samples: u64,
    samples_per_block: u64,
    samples: u64,
    rejected: u64,
    /// Of all blocks held.
    duration_s: f64,
    /// Of all samples.
    taken_s: f64,
    /// End of the last sample by its own stamp; `None` before the first.
    end_s: Option<f64>,
    /// Number of the first block of each segment, the first one's zero.
    starts: [u32; SEGMENTS_MAX],
    segments: usize,
    /// True when the beginning of the record is no longer held.
    forgot_the_start: bool,
}

impl<const CAPACITY: usize> Default for SloshArc<CAPACITY> {
    fn default() -> Self {
        const { assert!(CAPACITY >= 4 && CAPACITY.is_multiple_of(2)) }
        Self {
            columns: SMatrix::zeros(),
            complete: 0,
            open: SloshBlock::default(),
            open_samples: 0,
            samples_per_block: 1,
            samples: 0,
            rejected: 0,
            duration_s: 0.0,
            taken_s: 0.0,
            end_s: None,
            starts: [0; SEGMENTS_MAX],
            segments: 1,
            forgot_the_start: false,
        }
    }
}

impl<const CAPACITY: usize> SloshArc<CAPACITY> {
    /// A sample that begins where the last one ended. A full arc is merged first.
    ///
    /// # Errors
    /// As [`Self::push_at`].
    pub fn push(&mut self, sample: &SloshSample) -> Result<(), SampleRejected> {
        self.push_at(self.end_s.unwrap_or(0.0), sample)
    }

    /// A sample that begins at `begin_s`; a gap before it begins a new segment. A full arc is
    /// merged first.
    ///
    /// # Errors
    /// [`SampleRejected`] for a sample that is not finite, has no duration or no sigma, or begins
    /// before the arc's end; the arc is untouched.
    pub fn push_at(&mut self, begin_s: f64, sample: &SloshSample) -> Result<(), SampleRejected> {
        let gap_s = begin_s - self.end_s.unwrap_or(begin_s);
        // A stamp that is not a number compares as neither: it is rejected.
        let in_order = gap_s > -JITTER * sample.interval_s;
        if !(sample.is_usable() && in_order && begin_s.is_finite()) {
            self.rejected += 1;
            return Err(SampleRejected { rejected: self.rejected });
        }
        if gap_s > JITTER * sample.interval_s {
            self.begin_segment();
        }
        if self.is_full() {
            self.merge();
        }
        let block = SloshBlock::of(sample);
        self.open = if self.open_samples == 0 { block } else { self.open.followed_by(&block) };
        self.open_samples += 1;
        self.samples += 1;
        self.duration_s += sample.interval_s;
        self.taken_s += sample.interval_s;
        self.end_s = Some(begin_s + sample.interval_s);
        if self.open_samples >= self.samples_per_block {
            self.close_block();
        }
        Ok(())
    }

    /// Samples taken since the beginning, forgotten ones included.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Of all blocks held; gaps do not count.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Blocks to compute with; an incomplete last one counts.
    pub fn len(&self) -> usize {
        self.complete + usize::from(self.open_samples > 0)
    }

    /// Whether no sample has been used.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// True when the next sample needs room: see [`Self::merge`] and [`Self::forget_oldest`].
    pub fn is_full(&self) -> bool {
        self.complete == CAPACITY
    }

    /// Parts of the record without a gap.
    pub fn segments(&self) -> usize {
        self.segments
    }

    /// True when the slosh state at the first block is not the one at the beginning of the record.
    pub fn has_forgotten_the_start(&self) -> bool {
        self.forgot_the_start
    }

    /// In order of time, the incomplete last one included.
    pub fn blocks(&self) -> impl Iterator<Item = SloshBlock> + '_ {
        self.blocks_of((0, self.len()))
    }

    /// Blocks `from..until`; the incomplete one is the last.
    pub(crate) fn blocks_of(&self, (from, until): (usize, usize)) -> impl Iterator<Item = SloshBlock> + '_ {
        let open = (until > self.complete).then_some(self.open);
        (from..until.min(self.complete)).map(|i| self.block(i)).chain(open)
    }

    /// First block of segment `i` and the one behind its last.
    pub(crate) fn segment(&self, i: usize) -> (usize, usize) {
        let end = if i + 1 < self.segments { self.starts[i + 1] as usize } else { self.len() };
        (self.starts[i] as usize, end)
    }

    /// Length of a complete block of the first segment, which is the longest; of what there is
    /// before one is complete.
    pub fn block_length_s(&self) -> f64 {
        if self.complete > 0 { self.columns[(0, 0)] } else { self.open.length_s }
    }

    /// Mean interval times samples per block: what a complete block is long, zero before the first
    /// sample.
    pub fn resolution_s(&self) -> f64 {
        self.samples_per_block as f64 * self.taken_s / self.samples.max(1) as f64
    }

    /// The fastest mode these blocks tell; infinite before the first sample.
    pub fn resolved_rad_s(&self) -> f64 {
        self.resolved_product() / self.resolution_s()
    }

    /// Largest ω × block length at which a mode is resolved: [`RESOLVED_SINGLE`] or
    /// [`RESOLVED_MERGED`].
    pub fn resolved_product(&self) -> f64 {
        if self.samples_per_block == 1 { RESOLVED_SINGLE } else { RESOLVED_MERGED }
    }

    /// Makes room by summing pairs of blocks of the same segment; the oldest are forgotten when
    /// gaps leave no pairs.
    pub fn merge(&mut self) {
        let (mut read, mut write, mut segment) = (0, 0, 0);
        while read < self.complete {
            let end = if segment + 1 < self.segments { self.starts[segment + 1] as usize } else { self.complete };
            self.starts[segment] = write as u32;
            while read < end {
                let mut block = self.block(read);
                if read + 1 < end {
                    block = block.followed_by(&self.block(read + 1));
                }
                self.store(write, &block);
                read += 2;
                write += 1;
            }
            read = end;
            segment += 1;
        }
        if segment < self.segments {
            self.starts[segment] = write as u32; // The open block's segment has no complete block yet.
        }
        self.complete = write;
        self.samples_per_block *= 2;
        if self.is_full() {
            self.forget_oldest(CAPACITY / 4);
        }
    }

    /// Makes room by dropping the oldest `blocks`: the state at the start of what is left is then
    /// unknown.
    pub fn forget_oldest(&mut self, blocks: usize) {
        let dropped = blocks.min(self.complete);
        self.duration_s -= (0..dropped).map(|i| self.columns[(0, i)]).sum::<f64>();
        for i in dropped..self.complete {
            let kept = self.block(i);
            self.store(i - dropped, &kept);
        }
        self.complete -= dropped;
        let gone = self.starts[1..self.segments].iter().filter(|start| **start as usize <= dropped).count();
        self.starts.copy_within(gone..self.segments, 0);
        self.segments -= gone;
        for start in &mut self.starts[..self.segments] {
            *start = start.saturating_sub(dropped as u32);
        }
        self.forgot_the_start = true;
    }

    fn begin_segment(&mut self) {
        if self.open_samples > 0 {
            if self.is_full() {
                self.merge();
            }
            self.close_block();
        }
        if self.segments == SEGMENTS_MAX {
            self.forget_oldest(self.starts[1] as usize);
        }
        self.starts[self.segments] = self.complete as u32;
        self.segments += 1;
    }

    fn block(&self, i: usize) -> SloshBlock {
        let c = self.columns.column(i);
        SloshBlock {
            length_s: c[0],
            force: ForceMoments { impulse_n_s: c[1], first_moment_n_s2: c[2] },
            delta_v_m_s: c[3],
            variance_m2_s2: c[4],
            last_force_n: c[5],
        }
    }

    fn store(&mut self, i: usize, block: &SloshBlock) {
        let force = &block.force;
        let column = [
            block.length_s,
            force.impulse_n_s,
            force.first_moment_n_s2,
            block.delta_v_m_s,
            block.variance_m2_s2,
            block.last_force_n,
        ];
        self.columns.set_column(i, &column.into());
    }

    fn close_block(&mut self) {
        let block = self.open;
        self.store(self.complete, &block);
        self.complete += 1;
        self.open_samples = 0;
        self.open = SloshBlock::default();
    }
}

#[cfg(test)]
mod tests;
