//! The newest samples of a multichannel stream as one contiguous slice, newest first, in fixed
//! memory.
//!
//! A ring would split the slice; instead the window slides towards the front of a buffer twice its
//! length and is copied to the back when it arrives there, so that every lag sum is a plain product
//! of two slices.

use serde::{Deserialize, Serialize};

/// Sliding window over the last `depth` samples of `channels` values each.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct SlidingHistory {
    channels: usize,
    depth: usize,
    cursor: usize,
    buffer: Vec<f64>,
}

impl SlidingHistory {
    pub(crate) fn new(channels: usize, depth: usize) -> Self {
        assert!(channels > 0);
        assert!(depth > 0);
        Self { channels, depth, cursor: depth, buffer: vec![0.0; 2 * depth * channels] }
    }

    pub(crate) fn push(&mut self, sample: &[f64]) {
        let (l, depth) = (self.channels, self.depth);
        if self.cursor == 0 {
            self.buffer.copy_within(0..(depth - 1) * l, (depth + 1) * l);
            self.cursor = depth + 1;
        }
        self.cursor -= 1;
        self.buffer[self.cursor * l..(self.cursor + 1) * l].copy_from_slice(sample);
    }

    /// The last `depth` samples, newest first; zeros for samples not arrived since [`Self::clear`].
    pub(crate) fn newest_first(&self) -> &[f64] {
        &self.buffer[self.cursor * self.channels..(self.cursor + self.depth) * self.channels]
    }

    /// Numbers kept, with the room to slide.
    pub(crate) fn numbers(&self) -> usize {
        self.buffer.len()
    }

    pub(crate) fn clear(&mut self) {
        self.buffer.fill(0.0);
        self.cursor = self.depth;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn window_holds_the_newest_samples_in_reverse_order_however_long_the_stream() {
        let mut history = SlidingHistory::new(2, 3);
        for t in 0..50 {
            history.push(&[f64::from(t), -f64::from(t)]);
            for k in 0..3 {
                let expected = if t >= k { f64::from(t - k) } else { 0.0 };
                assert_eq!(history.newest_first()[2 * k as usize], expected);
                assert_eq!(history.newest_first()[2 * k as usize + 1], -expected);
            }
        }
    }
}
