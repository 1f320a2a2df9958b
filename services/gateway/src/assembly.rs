//! From samples as they arrive to frames: sorted by time, closed by a watermark.
//!
//! A frame closes when a sample has come that lies the lateness limit behind its end. What a frame
//! holds is therefore a function of the order of arrival alone; and samples that are at most the
//! limit out of order give the same frames in any order (architecture D10).

use runtime::feed::FeedCounts;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use telemetry::{
    ACCELEROMETERS, ACCELEROMETERS_MAX, Accelerometers, BATCH_MAX, Header, JOINTS, Joints, TOPICS, TopicId,
};
use zerocopy::FromBytes;

/// A sample that waits for its frame to close.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Held {
    /// Time of measurement, on the driver's clock \[ns\].
    pub t_ns: u64,
    /// Of the topic.
    pub topic: TopicId,
    /// As the driver wrote it.
    pub bytes: Vec<u8>,
}

/// When a frame closes.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    /// Length of a frame \[ns\].
    pub period_ns: u64,
    /// A frame waits until the newest sample lies so far behind its end \[ns\].
    pub lateness_ns: u64,
    /// After so long without a sample frames close by the clock \[ns\].
    pub silence_ns: u64,
    /// A sample further ahead of the newest one is not believed: its watermark would make every
    /// later sample late \[ns\].
    pub ahead_ns: u64,
}

/// Samples of frames that are not closed, and what became of the others.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Assembly {
    /// Begin of frame 0 on the driver's clock \[ns\]: the frame boundary before the first sample.
    origin_ns: Option<u64>,
    newest_ns: u64,
    /// Frames closed so far.
    closed: u64,
    /// In the order of (t_ns, topic).
    held: VecDeque<Held>,
    counts: FeedCounts,
    #[serde(skip)]
    spare: Vec<Vec<u8>>,
}

impl Assembly {
    /// Begin of frame 0 on the driver's clock \[ns\]; 0 before the first sample.
    pub fn origin_ns(&self) -> u64 {
        self.origin_ns.unwrap_or(0)
    }

    /// Frames closed so far.
    pub fn closed(&self) -> u64 {
        self.closed
    }

    /// What became of the samples.
    pub fn counts_mut(&mut self) -> &mut FeedCounts {
        &mut self.counts
    }

    /// Samples that wait.
    pub fn held(&self) -> usize {
        self.held.len()
    }

    /// Takes a sample that arrived after a silence of `quiet_ns`.
    pub fn offer(&mut self, topic: TopicId, bytes: &[u8], timing: &Timing, quiet_ns: u64) {
        self.counts.received += 1;
        let Some(t_ns) = time_of_sound(topic, bytes) else {
            self.counts.bad += 1;
            return;
        };
        let ahead_ns = self.newest_ns.saturating_add(timing.ahead_ns + quiet_ns);
        if self.origin_ns.is_some() && t_ns > ahead_ns {
            self.counts.bad += 1;
            return;
        }
        let origin_ns = *self.origin_ns.get_or_insert(t_ns - t_ns % timing.period_ns);
        // Late is what the samples before it have closed, whether or not the frame has been sent:
        // the order of arrival decides, not how fast frames are consumed.
        let passed = self.newest_ns.saturating_sub(origin_ns + timing.lateness_ns) / timing.period_ns;
        let frame = t_ns.checked_sub(origin_ns).map(|since| since / timing.period_ns);
        let Some(frame) = frame.filter(|frame| *frame >= self.closed.max(passed)) else {
            self.counts.late += 1;
            return;
        };
        let end_ns = origin_ns + (frame + 1) * timing.period_ns;
        let in_frame = self.held.range(self.behind(end_ns - timing.period_ns)..self.behind(end_ns));
        let (mut same, mut count) = (false, 0);
        for held in in_frame.filter(|held| held.topic == topic) {
            (same, count) = (same || held.t_ns == t_ns, count + 1);
        }
        if same {
            self.counts.duplicates += 1;
        } else if count >= TOPICS[topic].per_frame {
            self.counts.surplus += 1;
        } else {
            self.newest_ns = self.newest_ns.max(t_ns);
            let mut copy = self.spare.pop().unwrap_or_default();
            copy.extend_from_slice(bytes);
            let place = self.held.partition_point(|held| (held.t_ns, held.topic) < (t_ns, topic));
            self.held.insert(place, Held { t_ns, topic, bytes: copy });
        }
    }

    /// Index of the first sample that is not before `t_ns`.
    fn behind(&self, t_ns: u64) -> usize {
        self.held.partition_point(|held| held.t_ns < t_ns)
    }

    /// Whether the next frame can be closed after a silence of `quiet_ns`.
    pub fn is_complete(&self, timing: &Timing, quiet_ns: u64) -> bool {
        let by_clock_ns = quiet_ns.saturating_sub(timing.silence_ns);
        self.origin_ns.is_some_and(|origin_ns| {
            let end_ns = origin_ns + (self.closed + 1) * timing.period_ns;
            self.newest_ns + by_clock_ns >= end_ns + timing.lateness_ns
        })
    }

    /// Closes the next frame and moves its samples to `formed`, oldest first.
    pub fn close(&mut self, timing: &Timing, formed: &mut Vec<Held>) {
        self.spare.extend(formed.drain(..).map(|held| held.bytes));
        self.spare.iter_mut().for_each(Vec::clear);
        self.closed += 1;
        let end_ns = self.origin_ns() + self.closed * timing.period_ns;
        let count = self.behind(end_ns);
        formed.extend(self.held.drain(..count));
        self.counts.empty_frames += u64::from(formed.is_empty());
    }

    /// Goes on behind a frame that an earlier life has closed.
    pub fn resume(&mut self, closed: u64, origin_ns: u64, counts: FeedCounts, timing: &Timing) {
        (self.closed, self.origin_ns, self.counts) = (closed, Some(origin_ns), counts);
        let end_ns = origin_ns + closed * timing.period_ns;
        self.held.drain(..self.behind(end_ns));
        // The frame was closed: its samples had come.
        self.newest_ns = self.newest_ns.max(end_ns);
    }
}

/// Time of a sample whose values can be used.
fn time_of_sound(topic: TopicId, bytes: &[u8]) -> Option<u64> {
    let (header, _) = Header::read_from_prefix(bytes).ok()?;
    let is_finite = |word: &[u8]| word.try_into().is_ok_and(|word| f64::from_le_bytes(word).is_finite());
    let floats = TOPICS[topic].fields.iter().filter(|field| field.ros == "float64");
    let finite = floats.flat_map(|field| bytes[field.offset..field.offset + field.size].chunks_exact(8)).all(is_finite);
    let counts_fit = if topic == JOINTS.id {
        Joints::read_from_bytes(bytes).is_ok_and(|joints| joints.count as usize <= joints.angle_rad.len())
    } else if topic == ACCELEROMETERS.id {
        Accelerometers::read_from_bytes(bytes).is_ok_and(|batch| {
            (1..=BATCH_MAX).contains(&(batch.count as usize))
                && (1..=ACCELEROMETERS_MAX).contains(&(batch.channels as usize))
        })
    } else {
        true
    };
    (finite && counts_fit).then_some(header.t_meas_ns)
}

#[cfg(test)]
mod tests;
