//! The last outputs of a partition, kept so that a restart can send them again, identical
//! (architecture D6).

use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use telemetry::{Delivery, MODE, PartitionId, TELECOMMAND, TOPICS, TopicId};

/// One output; trailing zeros (unused rows of a batch, unused parameters) are not stored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Frame it was sent with.
    pub frame: u64,
    /// Topic it was sent on.
    pub topic: TopicId,
    #[serde(serialize_with = "crate::checkpoint::as_bytes")]
    trimmed: Vec<u8>,
}

impl Entry {
    /// The payload as it was sent.
    #[must_use]
    pub fn payload(&self) -> Vec<u8> {
        let mut payload = self.trimmed.clone();
        payload.resize(TOPICS[self.topic].size, 0);
        payload
    }
}

/// Outputs of the last W frames (results: 2 W), and the last modes however old: the newest mode
/// serves late joiners.
#[derive(Debug, Default)]
pub struct Outbox {
    modes: VecDeque<Entry>,
    recent: VecDeque<Entry>,
    window: u64,
    /// By topic: memory of entries that were forgotten, for those to come.
    spare: Vec<Vec<Vec<u8>>>,
}

/// Results of one topic within the time for which they are kept: they come 100 frames apart, a
/// window has 100 at most, and an experiment closes between two of them.
const RESULTS_KEPT: usize = 8;

impl Outbox {
    /// Takes up the entries of a checkpoint, in the order in which they were sent; `window` is the
    /// pacing window \[frames\].
    #[must_use]
    pub fn from_entries(entries: Vec<Entry>, window: u64) -> Self {
        let (modes, recent): (Vec<_>, Vec<_>) = entries.into_iter().partition(|entry| entry.topic == MODE.id);
        let spare = TOPICS.iter().map(|_| Vec::new()).collect();
        Outbox { modes: modes.into(), recent: recent.into(), window, spare }
    }

    /// Takes the memory that outputs of `producer` will need, so that none is taken later.
    pub fn reserve(&mut self, producer: PartitionId) {
        let mut entries = 0;
        for (topic, info) in TOPICS.iter().enumerate().filter(|(_, info)| info.producers == producer.text()) {
            let count = match info.delivery {
                Delivery::Source => info.per_frame * (self.window as usize + 2),
                Delivery::Feedback if topic == MODE.id || topic == TELECOMMAND.id => info.depth + 1,
                Delivery::Feedback => RESULTS_KEPT,
                Delivery::Status => 0,
            };
            entries += count;
            self.spare[topic].reserve(count);
            while self.spare[topic].len() < count {
                self.spare[topic].push(Vec::with_capacity(info.size));
            }
        }
        self.recent.reserve(entries);
        self.modes.reserve(TOPICS[MODE.id].depth + 1);
    }

    /// The pacing window \[frames\].
    #[must_use]
    pub fn window(&self) -> u64 {
        self.window
    }

    /// Bytes of all entries, about.
    #[must_use]
    pub fn reserved_bytes(&self) -> usize {
        self.spare.iter().flatten().map(Vec::capacity).sum()
    }

    fn recycle(&mut self, entry: Entry) {
        if let Some(spare) = self.spare.get_mut(entry.topic) {
            spare.push(entry.trimmed);
        }
    }

    /// Stores the payload that was sent on `topic` in `frame`. Of the modes the oldest is dropped
    /// once the topic's depth is reached.
    pub fn keep(&mut self, frame: u64, topic: TopicId, payload: &[u8]) {
        let used = payload.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
        let mut trimmed = self.spare.get_mut(topic).and_then(Vec::pop).unwrap_or_default();
        trimmed.clear();
        trimmed.extend_from_slice(&payload[..used]);
        let entry = Entry { frame, topic, trimmed };
        if topic != MODE.id {
            return self.recent.push_back(entry);
        }
        if self.modes.len() == TOPICS[MODE.id].depth
            && let Some(oldest) = self.modes.pop_front()
        {
            self.recycle(oldest);
        }
        self.modes.push_back(entry);
    }

    /// Drops entries that every consumer must have received when `frames_done` frames are done.
    pub fn forget_before(&mut self, frames_done: u64) {
        while self.recent.front().is_some_and(|oldest| oldest.frame + self.kept_frames(oldest.topic) < frames_done) {
            let oldest = self.recent.pop_front();
            oldest.into_iter().for_each(|entry| self.recycle(entry));
        }
    }

    /// A consumer may be W frames behind; a result waits W frames more in its inbox, which no
    /// checkpoint holds.
    fn kept_frames(&self, topic: TopicId) -> u64 {
        match TOPICS[topic].delivery {
            Delivery::Feedback => 2 * self.window,
            Delivery::Source | Delivery::Status => self.window,
        }
    }

    /// Per topic in the order in which they were sent.
    pub fn entries(&self) -> impl Iterator<Item = &Entry> {
        self.modes.iter().chain(&self.recent)
    }
}

#[cfg(test)]
mod tests {
    use super::Outbox;
    use telemetry::{ESTIMATE_INERTIAL, IMU, Imu, InertialEstimate, MODE, Mode, Sample, TICK, TOPICS, Tick};
    use zerocopy::IntoBytes;

    const WINDOW: u64 = 20;

    fn empty() -> Outbox {
        Outbox::from_entries(Vec::new(), WINDOW)
    }

    #[test]
    fn an_output_comes_back_byte_identical_whatever_its_zeros() {
        let mut outbox = empty();
        let mut samples = [Imu::zeroed_at(0), Imu::zeroed_at(5), Imu::zeroed_at(6)];
        samples[1].omega_bi_b_rad_s = [0.0, 1.0, 0.0];
        samples[2].valid = 1 << 56; // the last byte of the record
        samples.iter().for_each(|sample| outbox.keep(0, IMU.id, sample.as_bytes()));
        let text = postcard::to_extend(&outbox.entries().cloned().collect::<Vec<_>>(), Vec::new()).unwrap();
        let back = Outbox::from_entries(postcard::from_bytes(&text).unwrap(), WINDOW);
        for (entry, sample) in back.entries().zip(&samples) {
            assert_eq!(entry.payload(), sample.as_bytes());
        }
        assert_eq!(back.entries().count(), samples.len());
    }

    #[test]
    fn samples_are_kept_one_window_results_two_and_the_last_modes_for_ever() {
        let mut outbox = empty();
        for frame in 0..100 {
            outbox.keep(frame, IMU.id, Imu::zeroed_at(frame).as_bytes());
            outbox.keep(frame, TICK.id, Tick::zeroed_at(frame).as_bytes());
            outbox.forget_before(frame + 1);
        }
        // The slowest consumer has checkpointed 100 − W frames: it needs frame 80 first.
        assert_eq!(outbox.entries().map(|entry| entry.frame).min(), Some(80));
        let mut outbox = empty();
        for frame in 0..100 {
            outbox.keep(frame, ESTIMATE_INERTIAL.id, InertialEstimate::zeroed_at(frame).as_bytes());
            outbox.keep(frame, MODE.id, Mode::zeroed_at(frame).as_bytes());
            outbox.forget_before(frame + 1);
        }
        outbox.forget_before(1000);
        let modes: Vec<u64> =
            outbox.entries().filter(|entry| entry.topic == MODE.id).map(|entry| entry.frame).collect();
        assert_eq!(modes, (100 - TOPICS[MODE.id].depth as u64..100).collect::<Vec<_>>());
        assert_eq!(outbox.entries().count(), modes.len());
    }

    #[test]
    fn a_result_is_kept_until_no_restarted_consumer_can_ask_for_it() {
        // Producer at 100 frames; consumer checkpointed 80 = 100 − W; the result due in frame 80
        // was made in 80 − W.
        let mut outbox = empty();
        for frame in 0..100 {
            outbox.keep(frame, ESTIMATE_INERTIAL.id, InertialEstimate::zeroed_at(frame).as_bytes());
        }
        outbox.forget_before(100);
        assert_eq!(outbox.entries().next().map(|entry| entry.frame), Some(100 - 2 * WINDOW));
    }
}
