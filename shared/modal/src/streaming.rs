//! Fixed-memory streaming covariance that reconstructs the batch block-Hankel Gram matrix exactly.
//!
//! Per sample the lag sums `R_k += y_t y_{t−k}ᵀ`, k = 0 … 2i−1, are updated and the first 2i and
//! last 3i samples kept. The Gram matrix of the block-Hankel matrix with 2i block rows follows by
//! displacement: `G[p,q] = G[p−1,q−1] − y_{p−1} y_{q−1}ᵀ + y_{p−1+Nc} y_{q−1+Nc}ᵀ`, Nc = N − 2i + 1
//! columns. Plain lag covariances would be wrong on a decay (damping error of several hundred per
//! cent); this is the batch result.
//!
//! The stream is kept in 16 to 32 blocks at most. Two neighbours join exactly, because the missing
//! products are those of the tail of the first with the head of the second; when the slots are
//! full, neighbours join and the block length doubles. The blocks serve the spread of estimates
//! along the record; no column of the Gram matrix crosses a segment boundary.
//!
//! Cost per sample: 2 i l² multiply-adds, no allocation.

use serde::{Deserialize, Serialize};

use crate::gram::{Gram, TAIL_LENGTH, lag_sums};
use crate::history::SlidingHistory;
use crate::stretch::Stretch;

/// Slots for blocks of one record; between half of them and all of them are in use on a long
/// record.
const BLOCKS_MAX: usize = 32;
/// Fewer slots when there are many channels, down to this.
const BLOCKS_FLOOR: usize = 16;
/// Elements of the Gram matrices of all blocks: an identification multiplies each of them with its
/// states.
const BLOCK_ELEMENTS: usize = 8 << 20;
/// Complete blocks from which a spread along the record is worth having: χ² of 7 degrees of freedom
/// is within a factor of 2 in 95 %.
const COMPLETE_BLOCKS_MIN: usize = 8;
/// First block length in units of 2i samples: the products lost at a block's border stay below 1/8
/// of its columns.
const FIRST_BLOCK_LENGTH: u64 = 8;

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Block {
    segment: u64,
    /// The tail is written when the block ends.
    sums: Stretch,
}

/// Streaming accumulator of the block-Hankel Gram matrix over one or several segments.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StreamingCovariance {
    channels: usize,
    block_rows: usize,
    block_length: u64,
    blocks: Vec<Block>,
    used: usize,
    segment: u64,
    open: bool,
    history: SlidingHistory,
    discarded_samples: u64,
    /// Samples of the open block, where memory is no concern: its sums are taken when it ends.
    #[serde(skip)]
    deferred: Option<Vec<f64>>,
}

impl StreamingCovariance {
    /// Takes all memory: 16 to 32 blocks of `2il² + 5il` numbers. A segment is open from the start.
    #[must_use]
    pub fn new(channels: usize, block_rows: usize) -> Self {
        let width = 2 * block_rows * channels;
        let blocks = (BLOCK_ELEMENTS / (width * width)).clamp(BLOCKS_FLOOR, BLOCKS_MAX);
        Self::with_blocks(channels, block_rows, blocks)
    }

    /// The same with so many blocks. Of one block it is the newest segment alone (a missing sample
    /// begins a new one), of any length, without a spread along it: what a decay needs, in 99 kB
    /// for ten channels and i = 40.
    #[must_use]
    pub fn with_blocks(channels: usize, block_rows: usize, blocks: usize) -> Self {
        assert!(channels > 0);
        assert!(block_rows > 1);
        assert!(blocks > 0);
        let width = 2 * block_rows * channels;
        let sums = Stretch {
            samples: 0,
            lag_sums: vec![0.0; channels * width],
            head: vec![0.0; width],
            tail: vec![0.0; TAIL_LENGTH * block_rows * channels],
        };
        let empty = Block { segment: 0, sums };
        Self {
            channels,
            block_rows,
            // One block has no neighbour to join: it is never full.
            block_length: if blocks == 1 { u64::MAX } else { FIRST_BLOCK_LENGTH * 2 * block_rows as u64 },
            blocks: vec![empty; blocks],
            used: 1,
            segment: 0,
            open: true,
            history: SlidingHistory::new(channels, TAIL_LENGTH * block_rows),
            discarded_samples: 0,
            deferred: None,
        }
    }

    /// The same for a record in memory: the samples of a block are kept until it ends, and its sums
    /// taken in matrix products, to rounding the same in a tenth of the time.
    #[must_use]
    pub fn deferred(mut self) -> Self {
        self.deferred = Some(Vec::new());
        self
    }

    /// Starts a segment; columns of the Gram matrix never reach back over this boundary.
    pub fn open_segment(&mut self) {
        self.close_segment();
        self.segment += 1;
        self.open = true;
        self.start_block();
    }

    /// Ends the segment; samples are ignored until the next [`Self::open_segment`].
    pub fn close_segment(&mut self) {
        if self.open {
            self.finish_block();
            self.open = false;
        }
    }

    /// Adds one sample of all channels. A sample with a value that is not finite ends the segment
    /// and begins another.
    pub fn push(&mut self, sample: &[f64]) {
        assert_eq!(sample.len(), self.channels);
        if !self.open {
            return;
        }
        if sample.iter().any(|y| !y.is_finite()) {
            self.discarded_samples += 1;
            self.open_segment();
            return;
        }
        if self.blocks[self.used - 1].sums.samples == self.block_length {
            self.finish_block();
            self.start_block();
        }
        self.history.push(sample);
        let width = 2 * self.block_rows * self.channels;
        let sums = &mut self.blocks[self.used - 1].sums;
        if sums.samples < 2 * self.block_rows as u64 {
            let at = sums.samples as usize * self.channels;
            sums.head[at..at + self.channels].copy_from_slice(sample);
        }
        sums.samples += 1;
        if let Some(samples) = &mut self.deferred {
            samples.extend_from_slice(sample);
            return;
        }
        let lagged = &self.history.newest_first()[..width];
        for (row, &y) in sums.lag_sums.chunks_exact_mut(width).zip(sample) {
            for (sum, &y_lagged) in row.iter_mut().zip(lagged) {
                *sum += y * y_lagged;
            }
        }
    }

    /// Memory of the sums and samples kept \[bytes\].
    #[must_use]
    pub fn bytes(&self) -> usize {
        let numbers = |block: &Block| {
            [&block.sums.lag_sums, &block.sums.head, &block.sums.tail].map(Vec::len).iter().sum::<usize>()
        };
        size_of::<f64>() * (self.blocks.iter().map(numbers).sum::<usize>() + self.history.numbers())
    }

    /// Number of samples in the sums.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.blocks[..self.used].iter().map(|block| block.sums.samples).sum()
    }

    /// Samples dropped: not finite, or of the shortest segment when more segments than blocks had
    /// to be kept.
    #[must_use]
    pub fn discarded_samples(&self) -> u64 {
        self.discarded_samples
    }

    /// Gram matrix of all segments, equal to the batch product to rounding.
    #[must_use]
    pub fn gram(&self) -> Gram {
        let mut gram = Gram::zeros(self.channels, self.block_rows);
        let mut joined: Option<Block> = None;
        for index in 0..self.used {
            let block = self.finished(index);
            joined = Some(match joined.take() {
                Some(mut first) if first.segment == block.segment => {
                    join(&mut first.sums, &block.sums, self.channels, self.block_rows);
                    first
                }
                Some(first) => {
                    gram.add(&first.sums);
                    block
                }
                None => block,
            });
        }
        if let Some(last) = joined {
            gram.add(&last.sums);
        }
        gram
    }

    /// The complete blocks (each of one common length), for the spread along the record; none when
    /// these are few.
    #[must_use]
    pub fn complete_blocks(&self) -> Vec<Stretch> {
        let is_complete = |block: &Block| block.sums.samples == self.block_length;
        if self.blocks[..self.used].iter().filter(|block| is_complete(block)).count() < COMPLETE_BLOCKS_MIN {
            return Vec::new();
        }
        (0..self.used)
            .filter(|&index| is_complete(&self.blocks[index]))
            .map(|index| self.finished(index).sums)
            .collect()
    }

    fn finished(&self, index: usize) -> Block {
        let mut block = self.blocks[index].clone();
        if self.open && index + 1 == self.used {
            block.sums.tail.copy_from_slice(self.history.newest_first());
            self.take_deferred(&mut block);
        }
        block
    }

    fn finish_block(&mut self) {
        let mut block = std::mem::take(&mut self.blocks[self.used - 1]);
        block.sums.tail.copy_from_slice(self.history.newest_first());
        self.take_deferred(&mut block);
        self.blocks[self.used - 1] = block;
        self.deferred.iter_mut().for_each(Vec::clear);
        self.history.clear();
    }

    /// The sums of the open block, where they are taken at its end.
    fn take_deferred(&self, block: &mut Block) {
        if let Some(samples) = self.deferred.as_ref().filter(|samples| !samples.is_empty()) {
            block.sums.lag_sums = lag_sums(samples, self.channels, 2 * self.block_rows);
        }
    }

    fn start_block(&mut self) {
        if self.blocks[self.used - 1].sums.samples == 0 {
            self.blocks[self.used - 1].segment = self.segment;
            return;
        }
        if self.used == self.blocks.len() {
            self.make_room();
        }
        let block = &mut self.blocks[self.used];
        block.segment = self.segment;
        block.sums.samples = 0;
        block.sums.lag_sums.fill(0.0);
        block.sums.head.fill(0.0);
        block.sums.tail.fill(0.0);
        self.used += 1;
    }

    /// Joins neighbours of one segment and doubles the block length; if no two are neighbours,
    /// drops the shortest segment.
    fn make_room(&mut self) {
        let mut kept = 0;
        let mut index = 0;
        while index < self.used {
            self.blocks.swap(kept, index);
            if index + 1 < self.used && self.blocks[kept].segment == self.blocks[index + 1].segment {
                let (front, back) = self.blocks.split_at_mut(kept + 1);
                join(&mut front[kept].sums, &back[index - kept].sums, self.channels, self.block_rows);
                index += 1;
            }
            index += 1;
            kept += 1;
        }
        if kept == self.used {
            let shortest = (0..kept).min_by_key(|&k| self.blocks[k].sums.samples).expect("there are blocks");
            self.discarded_samples += self.blocks[shortest].sums.samples;
            self.blocks[shortest..kept].rotate_left(1);
            kept -= 1;
        } else {
            self.block_length *= 2;
        }
        self.used = kept;
    }
}

/// Appends `second` to `first` as if the samples had come without a break.
fn join(first: &mut Stretch, second: &Stretch, l: usize, block_rows: usize) {
    let rows = 2 * block_rows;
    let width = rows * l;
    let (n_1, n_2) = (first.samples.min(rows as u64) as usize, second.samples.min(rows as u64) as usize);
    let depth = TAIL_LENGTH * block_rows;
    let newer = second.samples.min(depth as u64) as usize;
    for (sum, other) in first.lag_sums.iter_mut().zip(&second.lag_sums) {
        *sum += other;
    }
    for k in 1..rows {
        for t in k.saturating_sub(n_1)..k.min(n_2) {
            let back = k - t - 1;
            for a in 0..l {
                for b in 0..l {
                    first.lag_sums[a * width + k * l + b] += second.head[t * l + a] * first.tail[back * l + b];
                }
            }
        }
    }
    let from_second = (rows - n_1).min(n_2);
    first.head[n_1 * l..(n_1 + from_second) * l].copy_from_slice(&second.head[..from_second * l]);
    first.tail.copy_within(0..(depth - newer) * l, newer * l);
    first.tail[..newer * l].copy_from_slice(&second.tail[..newer * l]);
    first.samples += second.samples;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::Noise;
    use faer::Mat;

    fn batch_gram(segments: &[Vec<Vec<f64>>], l: usize, i: usize) -> Mat<f64> {
        let size = 2 * i * l;
        let mut gram = Mat::zeros(size, size);
        for segment in segments {
            for t in 0..(segment.len() + 1).saturating_sub(2 * i) {
                let column: Vec<f64> = segment[t..t + 2 * i].concat();
                for c in 0..size {
                    for r in 0..size {
                        gram[(r, c)] += column[r] * column[c];
                    }
                }
            }
        }
        gram
    }

    #[test]
    fn sums_taken_when_a_block_ends_are_those_taken_sample_by_sample() {
        let (l, i) = (3, 4);
        let mut noise = Noise::new(11);
        let mut streams = [StreamingCovariance::new(l, i), StreamingCovariance::new(l, i).deferred()];
        for t in 0..5000 {
            let sample: Vec<f64> = (0..l).map(|_| if t == 1700 { f64::NAN } else { noise.normal() }).collect();
            streams.iter_mut().for_each(|stream| stream.push(&sample));
        }
        let [one_by_one, deferred] = streams;
        assert_eq!(one_by_one.samples(), deferred.samples());
        assert!(relative_difference(&deferred.gram().matrix, &one_by_one.gram().matrix) < 1e-13);
        let (blocks, others) = (deferred.complete_blocks(), one_by_one.complete_blocks());
        assert!(blocks.len() == others.len() && blocks.len() > 8, "{}", blocks.len());
        for (block, other) in blocks.iter().zip(&others) {
            let size = other.lag_sums.iter().map(|sum| sum.abs()).fold(0.0, f64::max);
            assert!(block.lag_sums.iter().zip(&other.lag_sums).all(|(a, b)| (a - b).abs() < 1e-13 * size));
            assert!(block.head == other.head && block.tail == other.tail);
        }
    }

    fn relative_difference(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
        (a - b).norm_l2() / b.norm_l2()
    }

    fn decaying_record(noise: &mut Noise, samples: usize, l: usize) -> Vec<Vec<f64>> {
        (0..samples)
            .map(|t| {
                (0..l)
                    .map(|c| libm::exp(-0.01 * t as f64) * libm::sin(0.1 * t as f64 + c as f64) + 0.1 * noise.normal())
                    .collect()
            })
            .collect()
    }

    #[test]
    fn streaming_gram_equals_the_batch_gram_over_any_number_of_joined_blocks_and_segments() {
        let mut noise = Noise::new(1);
        for lengths in [&[9usize][..], &[10], &[640], &[77, 3, 200], &[3000, 1, 11, 90], &[5000]] {
            let (l, i) = (3, 5);
            let mut streaming = StreamingCovariance::new(l, i);
            let mut segments = Vec::new();
            for (index, &length) in lengths.iter().enumerate() {
                if index > 0 {
                    streaming.open_segment();
                }
                let segment = decaying_record(&mut noise, length, l);
                segment.iter().for_each(|sample| streaming.push(sample));
                segments.push(segment);
            }
            let (gram, batch) = (streaming.gram(), batch_gram(&segments, l, i));
            if lengths == [9] {
                assert_eq!(gram.columns, 0); // 9 samples cannot fill one column of 10
                continue;
            }
            // Rounding of a few thousand products.
            assert!(relative_difference(&gram.matrix, &batch) < 1e-12, "{lengths:?}");
            assert_eq!(streaming.discarded_samples(), 0);
        }
    }

    #[test]
    fn a_sample_that_is_not_finite_ends_the_segment_instead_of_poisoning_the_sums() {
        let mut noise = Noise::new(2);
        let (l, i) = (2, 4);
        let (first, second) = (decaying_record(&mut noise, 100, l), decaying_record(&mut noise, 60, l));
        let mut streaming = StreamingCovariance::new(l, i);
        first.iter().for_each(|sample| streaming.push(sample));
        streaming.push(&[f64::NAN, 0.0]);
        second.iter().for_each(|sample| streaming.push(sample));
        let batch = batch_gram(&[first, second], l, i);
        assert!(relative_difference(&streaming.gram().matrix, &batch) < 1e-12);
        assert_eq!(streaming.discarded_samples(), 1);
    }

    #[test]
    fn more_segments_than_slots_drop_the_shortest_and_count_it() {
        let mut noise = Noise::new(3);
        let (l, i) = (1, 3);
        let mut streaming = StreamingCovariance::new(l, i);
        let mut kept = Vec::new();
        for index in 0..BLOCKS_MAX + 1 {
            if index > 0 {
                streaming.open_segment();
            }
            let segment = decaying_record(&mut noise, if index == 4 { 10 } else { 20 + index }, l);
            segment.iter().for_each(|sample| streaming.push(sample));
            if index != 4 {
                kept.push(segment);
            }
        }
        assert_eq!(streaming.discarded_samples(), 10);
        assert!(relative_difference(&streaming.gram().matrix, &batch_gram(&kept, l, i)) < 1e-12);
    }

    #[test]
    fn one_block_holds_the_newest_segment_of_any_length_in_less_than_100_kb() {
        assert!(StreamingCovariance::with_blocks(10, 40, 1).bytes() < 100_000);
        let mut noise = Noise::new(6);
        let (l, i) = (2, 4);
        let (first, second) = (decaying_record(&mut noise, 500, l), decaying_record(&mut noise, 3000, l));
        let mut streaming = StreamingCovariance::with_blocks(l, i, 1);
        first.iter().for_each(|sample| streaming.push(sample));
        streaming.open_segment();
        second.iter().for_each(|sample| streaming.push(sample));
        assert_eq!((streaming.samples(), streaming.discarded_samples()), (3000, 500));
        assert!(streaming.complete_blocks().is_empty());
        assert!(relative_difference(&streaming.gram().matrix, &batch_gram(&[second], l, i)) < 1e-12);
    }

    #[test]
    fn a_state_read_back_from_bytes_continues_to_the_same_bits() {
        let mut noise = Noise::new(4);
        let record = decaying_record(&mut noise, 2000, 2);
        let mut whole = StreamingCovariance::new(2, 6);
        record.iter().for_each(|sample| whole.push(sample));
        let mut part = StreamingCovariance::new(2, 6);
        record[..777].iter().for_each(|sample| part.push(sample));
        let bytes = postcard::to_allocvec(&part).unwrap();
        let mut resumed: StreamingCovariance = postcard::from_bytes(&bytes).unwrap();
        record[777..].iter().for_each(|sample| resumed.push(sample));
        assert_eq!(postcard::to_allocvec(&resumed).unwrap(), postcard::to_allocvec(&whole).unwrap());
    }
}
