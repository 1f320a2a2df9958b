//! The one place of sequence, epoch, gap, duplicate and integrity logic: from arrivals to frames.
//!
//! Arrivals are copied out of shared memory before they are checked (a peer may write in between).
//! What a frame gets depends on sequence and frame numbers alone, never on when something arrived
//! (architecture D1, D4, D6).

use crate::config::Sabotage;
use std::collections::VecDeque;
use telemetry::{
    Delivery, Header, PROGRESS, PartitionId, Progress, Sample, Stamps, TICK, TOPICS, TOPICS_MAX, Tick, Topic, TopicId,
};
use zerocopy::{FromBytes, IntoBytes};

/// Counters of an inbox; they survive restarts in the checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Counters {
    /// Samples delivered to frames.
    pub received: u64,
    /// Sequence numbers that never came.
    pub lost: u64,
    /// Samples dropped because their sequence number had been seen.
    pub duplicates: u64,
    /// Samples dropped for a wrong CRC, a wrong layout, a value that is not finite, or a report in
    /// another partition's name.
    pub bad: u64,
}

/// State of an inbox in a checkpoint: the last sequence number that a frame has taken, per topic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Cursors {
    /// By topic; 0 before the first sample.
    pub taken: [u64; TOPICS_MAX],
    /// Totals since the run began.
    pub counters: Counters,
}

struct Arrival {
    seq: u64,
    /// First frame that may take it (feedback topics).
    due_frame: u64,
    stamps: Stamps,
    slot: usize,
}

/// A producer that has lost its checkpoints numbers its samples from the next multiple on, so that
/// nobody takes them for old ones. How many it lost is not known: the step counts as one.
pub const SEQ_ANEW: u64 = 1 << 32;
/// Samples of a topic in one frame, beyond the ten of its rate.
const DUE_AT_ONCE: usize = 16;

/// Arrivals of one topic that no frame has taken yet, and those of the current frame.
struct Queue {
    topic: TopicId,
    stride: usize,
    slots: Vec<u64>,
    next_slot: usize,
    waiting: VecDeque<Arrival>,
    /// Highest sequence number seen; per source for status topics, which have several producers.
    seen: u64,
    seen_status: [(u32, u64); PartitionId::COUNT],
    /// Arrivals whose header could not be trusted: they stand for sequence numbers that will not
    /// come.
    unreadable: u64,
    due_words: Vec<u64>,
    due_stamps: Vec<Stamps>,
}

impl Queue {
    fn new(topic: TopicId) -> Self {
        let info = &TOPICS[topic];
        let stride = info.size / 8;
        // All that waits may be due at once where a frame takes what has come.
        let due = if info.delivery == Delivery::Status { info.depth } else { DUE_AT_ONCE };
        Queue {
            topic,
            stride,
            // One more than can wait: an arrival is checked in its slot before it displaces
            // another.
            slots: vec![0; stride * (info.depth + 1)],
            next_slot: 0,
            waiting: VecDeque::with_capacity(info.depth),
            seen: 0,
            seen_status: [(0, 0); PartitionId::COUNT],
            unreadable: 0,
            due_words: Vec::with_capacity(stride * due),
            due_stamps: Vec::with_capacity(due),
        }
    }

    fn header(&self, slot: usize) -> Header {
        let bytes = self.slots[slot * self.stride..][..3].as_bytes();
        Header::read_from_bytes(bytes).expect("a header is the first 24 bytes of every sample")
    }

    fn is_new(&mut self, header: &Header, epoch: u32) -> bool {
        if TOPICS[self.topic].delivery != Delivery::Status {
            return header.seq > self.seen;
        }
        let Some(last) = self.seen_status.get_mut(usize::from(header.source)) else { return false };
        let new = (epoch, header.seq) > *last;
        if new {
            *last = (epoch, header.seq);
        }
        new
    }

    fn take(&mut self, arrival: &Arrival) {
        let words = &self.slots[arrival.slot * self.stride..][..self.stride];
        self.due_words.extend_from_slice(words);
        self.due_stamps.push(arrival.stamps);
    }
}

/// All queues of one partition.
pub struct Inbox {
    queues: Vec<Option<Queue>>,
    cursors: Cursors,
    window: u64,
    sabotage: Sabotage,
}

impl Inbox {
    /// An inbox for `inputs`, to go on after `cursors`.
    #[must_use]
    pub fn new(inputs: &[TopicId], cursors: Cursors, window: u64, sabotage: Sabotage) -> Self {
        let mut queues: Vec<Option<Queue>> = (0..TOPICS.len()).map(|_| None).collect();
        for &topic in inputs {
            let mut queue = Queue::new(topic);
            queue.seen = cursors.taken[topic];
            queues[topic] = Some(queue);
        }
        Inbox { queues, cursors, window, sabotage }
    }

    /// For the checkpoint: [`Inbox::new`] goes on behind them.
    #[must_use]
    pub fn cursors(&self) -> Cursors {
        self.cursors
    }

    /// Totals since the run began, over all restarts.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.cursors.counters
    }

    /// Takes one arrival: copy, check, then queue it or count the reason for dropping it. Returns
    /// whether it was queued.
    pub fn arrive(&mut self, topic: TopicId, stamps: &Stamps, payload: &[u8]) -> bool {
        let (window, sabotage) = (self.window, self.sabotage);
        let counters = &mut self.cursors.counters;
        let Some(queue) = self.queues[topic].as_mut() else { return false };
        let depth = TOPICS[topic].depth;
        let slot = queue.next_slot;
        let copy = queue.slots[slot * queue.stride..][..queue.stride].as_mut_bytes();
        if payload.len() != copy.len() {
            counters.bad += 1;
            return false;
        }
        copy.copy_from_slice(payload);
        if sabotage != Sabotage::SkipCrc && telemetry::crc32(copy) != stamps.crc32 {
            counters.bad += 1;
            queue.unreadable += 1;
            return false;
        }
        let header = queue.header(slot);
        if header.layout != TOPICS[topic].layout {
            counters.bad += 1;
            queue.unreadable += 1;
            return false;
        }
        if topic == PROGRESS.id && !is_of_its_sender(&header, queue.slots[slot * queue.stride..].as_bytes()) {
            counters.bad += 1;
            return false;
        }
        if !queue.is_new(&header, stamps.epoch) && sabotage != Sabotage::NoDedupe {
            counters.duplicates += 1;
            return false;
        }
        let delivery = TOPICS[topic].delivery;
        if delivery != Delivery::Status {
            let gap = header.seq.saturating_sub(queue.seen.saturating_add(1));
            // numbered anew: far beyond the last one, and not far beyond a multiple
            let is_anew = gap >= SEQ_ANEW / 2 && header.seq >= SEQ_ANEW && header.seq % SEQ_ANEW < SEQ_ANEW / 2;
            let missed = if is_anew { 1 } else { gap };
            counters.lost = counters.lost.saturating_add(missed);
            queue.seen = queue.seen.max(header.seq);
            // What could not be read stood before this one; it must not stand for a number that is
            // still to come.
            queue.unreadable = 0;
        }
        if delivery == Delivery::Source
            && !is_finite(topic, queue.slots[slot * queue.stride..][..queue.stride].as_bytes())
        {
            counters.bad += 1;
            return false;
        }
        let due_frame = match delivery {
            Delivery::Feedback => queue.slots[slot * queue.stride + 3].saturating_add(window),
            Delivery::Source | Delivery::Status => 0,
        };
        if queue.waiting.len() == depth {
            // The pacing window makes this impossible for data; a stalled consumer of status
            // samples keeps the newest.
            queue.waiting.pop_front();
            counters.lost += u64::from(delivery != Delivery::Status);
        }
        queue.waiting.push_back(Arrival { seq: header.seq, due_frame, stamps: *stamps, slot });
        queue.next_slot = (slot + 1) % (depth + 1);
        true
    }

    /// The newest arrival of a topic that no frame has taken.
    #[must_use]
    pub fn newest<T: Sample>(&self, topic: Topic<T>) -> Option<T> {
        let queue = self.queues[topic.id].as_ref()?;
        let words = &queue.slots[queue.waiting.back()?.slot * queue.stride..][..queue.stride];
        T::read_from_bytes(words.as_bytes()).ok()
    }

    /// The oldest tick that no frame has taken.
    #[must_use]
    pub fn next_tick(&self) -> Option<Tick> {
        let queue = self.queues[TICK.id].as_ref()?;
        let arrival = queue.waiting.front()?;
        let words = &queue.slots[arrival.slot * queue.stride..][..queue.stride];
        Tick::read_from_bytes(words.as_bytes()).ok()
    }

    /// Highest sequence number seen on a topic.
    #[must_use]
    pub fn seen(&self, topic: TopicId) -> u64 {
        self.queues[topic].as_ref().map_or(u64::MAX, |queue| queue.seen.saturating_add(queue.unreadable))
    }

    /// Whether everything that `last_seq` covers has arrived (history may still be on its way after
    /// a restart).
    #[must_use]
    pub fn has_all(&self, last_seq: &[u64; TOPICS_MAX]) -> bool {
        (0..TOPICS.len()).all(|topic| self.seen(topic) >= last_seq[topic])
    }

    /// Moves what belongs to frame `number` from the queues to the frame.
    pub fn collect(&mut self, number: u64, last_seq: &[u64; TOPICS_MAX]) {
        let by_arrival = self.sabotage == Sabotage::DrainByTopic;
        for queue in self.queues.iter_mut().flatten() {
            queue.due_words.clear();
            queue.due_stamps.clear();
            let (topic, delivery) = (queue.topic, TOPICS[queue.topic].delivery);
            while let Some(arrival) = queue.waiting.front() {
                let due = match delivery {
                    Delivery::Source if topic == TICK.id => queue.due_stamps.is_empty(),
                    Delivery::Source => by_arrival || arrival.seq <= last_seq[topic],
                    Delivery::Feedback => by_arrival || arrival.due_frame <= number,
                    Delivery::Status => true,
                };
                if !due {
                    break;
                }
                let arrival = queue.waiting.pop_front().expect("front was just seen");
                queue.take(&arrival);
                self.cursors.taken[topic] = self.cursors.taken[topic].max(arrival.seq);
                self.cursors.counters.received += 1;
            }
        }
    }

    /// The current frame's samples of `topic`.
    pub(crate) fn due<T: Sample>(&self, topic: Topic<T>) -> &[T] {
        let Some(queue) = self.queues[topic.id].as_ref() else { return &[] };
        <[T]>::ref_from_bytes(queue.due_words.as_bytes()).expect("whole samples, 8-byte aligned")
    }

    /// Stamps and payloads of the current frame's samples of `topic`.
    pub(crate) fn due_raw(&self, topic: TopicId) -> impl Iterator<Item = (&Stamps, &[u8])> {
        self.queues[topic].iter().flat_map(|queue| {
            queue.due_stamps.iter().zip(queue.due_words.chunks_exact(queue.stride).map(IntoBytes::as_bytes))
        })
    }

    /// Times of send of the current frame's source samples.
    pub(crate) fn sent_ns(&self) -> impl Iterator<Item = u64> {
        let data = |queue: &&Queue| TOPICS[queue.topic].delivery == Delivery::Source;
        self.queues.iter().flatten().filter(data).flat_map(|queue| queue.due_stamps.iter().map(|stamps| stamps.sent_ns))
    }
}

/// Whether a progress report speaks of the partition that sent it. What opens frames and what ends
/// a run is believed of nobody else.
fn is_of_its_sender(header: &Header, payload: &[u8]) -> bool {
    Progress::read_from_prefix(payload).is_ok_and(|(progress, _)| progress.partition == u32::from(header.source))
}

/// Whether every floating-point field of a sample is a number: NaN and infinity are never
/// measurements.
fn is_finite(topic: TopicId, payload: &[u8]) -> bool {
    TOPICS[topic].fields.iter().filter(|field| field.ros == "float64").all(|field| {
        payload[field.offset..field.offset + field.size]
            .chunks_exact(8)
            .all(|bytes| f64::from_le_bytes(bytes.try_into().expect("chunks of 8 bytes")).is_finite())
    })
}

#[cfg(test)]
mod tests {
    use super::{Counters, Cursors, Inbox};
    use crate::config::Sabotage;
    use telemetry::{
        ESTIMATE_INERTIAL, IMU, Imu, InertialEstimate, PROGRESS, PartitionId, Progress, Sample, Stamps, TICK, TOPICS,
        TOPICS_MAX, Tick, Topic,
    };

    const WINDOW: u64 = 20;

    fn inbox(sabotage: Sabotage) -> Inbox {
        Inbox::new(&[TICK.id, IMU.id, ESTIMATE_INERTIAL.id, PROGRESS.id], Cursors::default(), WINDOW, sabotage)
    }

    /// `sample` as sequence number `seq` of its producer's life `epoch`.
    fn wire<T: Sample>(topic: Topic<T>, epoch: u32, seq: u64, mut sample: T) -> (Stamps, Vec<u8>) {
        sample.header_mut().layout = TOPICS[topic.id].layout;
        sample.header_mut().seq = seq;
        let payload = sample.as_bytes().to_vec();
        (Stamps { epoch, crc32: telemetry::crc32(&payload), sent_ns: 0 }, payload)
    }

    fn imu(inbox: &mut Inbox, epoch: u32, seq: u64) -> bool {
        let (stamps, payload) = wire(IMU, epoch, seq, Imu::zeroed_at(seq));
        inbox.arrive(IMU.id, &stamps, &payload)
    }

    /// Sequence numbers that a frame gets whose tick covers `last` inertial samples.
    fn taken(inbox: &mut Inbox, frame: u64, last: u64) -> Vec<u64> {
        inbox.collect(frame, &covers(last));
        inbox.due(IMU).iter().map(|sample| sample.header.seq).collect()
    }

    fn covers(last: u64) -> [u64; TOPICS_MAX] {
        let mut last_seq = [0; TOPICS_MAX];
        last_seq[IMU.id] = last;
        last_seq
    }

    #[test]
    fn a_frame_takes_what_its_tick_covers_and_leaves_the_rest() {
        let mut inbox = inbox(Sabotage::None);
        (1..=5).for_each(|seq| assert!(imu(&mut inbox, 0, seq)));
        assert_eq!(taken(&mut inbox, 0, 3), [1, 2, 3]);
        assert_eq!(taken(&mut inbox, 1, 3), [0_u64; 0]);
        assert_eq!(taken(&mut inbox, 2, 5), [4, 5]);
        assert_eq!(inbox.counters(), Counters { received: 5, ..Counters::default() });
    }

    #[test]
    fn a_gap_is_counted_and_the_frame_goes_on() {
        let mut inbox = inbox(Sabotage::None);
        for seq in [1, 2, 6] {
            imu(&mut inbox, 0, seq);
        }
        assert!(inbox.has_all(&covers(6)));
        assert_eq!(taken(&mut inbox, 0, 6), [1, 2, 6]);
        assert_eq!(inbox.counters(), Counters { received: 3, lost: 3, ..Counters::default() });
    }

    #[test]
    fn a_frame_waits_for_what_its_tick_covers() {
        let mut inbox = inbox(Sabotage::None);
        imu(&mut inbox, 0, 1);
        assert!(!inbox.has_all(&covers(2)));
        imu(&mut inbox, 0, 2);
        assert!(inbox.has_all(&covers(2)));
    }

    #[test]
    fn sequence_numbers_seen_before_are_dropped_also_in_a_new_epoch() {
        let mut inbox = inbox(Sabotage::None);
        for (epoch, seq) in [(0, 1), (0, 2), (0, 2), (1, 1), (1, 2), (1, 3)] {
            imu(&mut inbox, epoch, seq);
        }
        assert_eq!(taken(&mut inbox, 0, 3), [1, 2, 3]);
        assert_eq!(inbox.counters(), Counters { received: 3, duplicates: 3, ..Counters::default() });
    }

    #[test]
    fn the_dedupe_law_is_red_without_dedupe() {
        let mut inbox = inbox(Sabotage::NoDedupe);
        [1, 2, 2].iter().for_each(|&seq| assert!(imu(&mut inbox, 0, seq)));
        assert_eq!(taken(&mut inbox, 0, 2), [1, 2, 2]);
    }

    #[test]
    fn a_restarted_inbox_goes_on_after_what_was_taken_not_after_what_had_arrived() {
        let mut before = inbox(Sabotage::None);
        (1..=5).for_each(|seq| assert!(imu(&mut before, 0, seq)));
        taken(&mut before, 0, 3);
        let mut after = Inbox::new(&[TICK.id, IMU.id], before.cursors(), WINDOW, Sabotage::None);
        (1..=6).for_each(|seq| assert_eq!(imu(&mut after, 0, seq), seq > 3));
        assert_eq!(taken(&mut after, 1, 6), [4, 5, 6]);
        assert_eq!(after.counters(), Counters { received: 6, duplicates: 3, ..Counters::default() });
    }

    #[test]
    fn any_flipped_bit_is_counted_and_dropped_and_the_frame_goes_on() {
        let (stamps, whole) = wire(IMU, 0, 1, Imu::zeroed_at(7));
        for byte in 0..whole.len() {
            let mut inbox = inbox(Sabotage::None);
            let mut damaged = whole.clone();
            damaged[byte] ^= 0x10;
            assert!(!inbox.arrive(IMU.id, &stamps, &damaged));
            assert!(inbox.has_all(&covers(1)), "byte {byte}: the frame waits for a sample that will not come");
            assert_eq!(taken(&mut inbox, 0, 1), [0_u64; 0]);
            assert_eq!(inbox.counters(), Counters { bad: 1, ..Counters::default() }, "byte {byte}");
        }
    }

    #[test]
    fn the_integrity_law_is_red_without_the_crc() {
        let mut inbox = inbox(Sabotage::SkipCrc);
        let (stamps, mut payload) = wire(IMU, 0, 1, Imu::zeroed_at(7));
        payload[32] ^= 0x10;
        assert!(inbox.arrive(IMU.id, &stamps, &payload));
    }

    #[test]
    fn a_damaged_sample_stands_for_no_sample_that_is_still_to_come() {
        let mut inbox = inbox(Sabotage::None);
        let (stamps, mut damaged) = wire(IMU, 0, 1, Imu::zeroed_at(7));
        damaged[40] ^= 1;
        inbox.arrive(IMU.id, &stamps, &damaged);
        imu(&mut inbox, 0, 1);
        assert!(!inbox.has_all(&covers(2)), "sample 2 has not been sent yet");
        imu(&mut inbox, 0, 2);
        assert_eq!(taken(&mut inbox, 0, 2), [1, 2]);
        assert_eq!(inbox.counters(), Counters { received: 2, bad: 1, ..Counters::default() });
    }

    #[test]
    fn another_layout_and_another_size_are_counted_and_dropped() {
        let mut inbox = inbox(Sabotage::None);
        let (_, mut payload) = wire(IMU, 0, 1, Imu::zeroed_at(7));
        payload[0] ^= 1;
        let stamps = Stamps { crc32: telemetry::crc32(&payload), ..Stamps::default() };
        assert!(!inbox.arrive(IMU.id, &stamps, &payload));
        assert!(!inbox.arrive(IMU.id, &stamps, &payload[..40]));
        assert_eq!(inbox.counters().bad, 2);
        assert_eq!(taken(&mut inbox, 0, 1), [0_u64; 0]);
    }

    #[test]
    fn a_value_that_is_no_number_is_counted_and_dropped_and_is_not_a_gap() {
        for poison in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for axis in 0..3 {
                let mut inbox = inbox(Sabotage::None);
                imu(&mut inbox, 0, 1);
                let mut sample = Imu::zeroed_at(0);
                sample.acceleration_b_m_s2[axis] = poison;
                let (stamps, payload) = wire(IMU, 0, 2, sample);
                assert!(!inbox.arrive(IMU.id, &stamps, &payload));
                imu(&mut inbox, 0, 3);
                assert_eq!(taken(&mut inbox, 0, 3), [1, 3]);
                assert_eq!(inbox.counters(), Counters { received: 2, bad: 1, ..Counters::default() });
            }
        }
    }

    #[test]
    fn a_result_may_hold_nan_and_is_due_one_window_after_its_frame() {
        let mut inbox = inbox(Sabotage::None);
        let mut sample = InertialEstimate::zeroed_at(0);
        sample.estimate.frame = 4;
        (sample.estimate.nis_mean, sample.consider_sigma_kg_m2[0]) = (f64::NAN, f64::NAN);
        let (stamps, payload) = wire(ESTIMATE_INERTIAL, 0, 1, sample);
        assert!(inbox.arrive(ESTIMATE_INERTIAL.id, &stamps, &payload));
        for frame in 0..30 {
            inbox.collect(frame, &[0; TOPICS_MAX]);
            assert_eq!(inbox.due(ESTIMATE_INERTIAL).len(), usize::from(frame == 4 + WINDOW), "frame {frame}");
        }
    }

    fn progress(inbox: &mut Inbox, source: PartitionId, epoch: u32, seq: u64) -> bool {
        let mut sample = Progress::zeroed_at(0);
        (sample.header.source, sample.partition) = (source.code(), source.code().into());
        let (stamps, payload) = wire(PROGRESS, epoch, seq, sample);
        inbox.arrive(PROGRESS.id, &stamps, &payload)
    }

    #[test]
    fn a_status_sample_of_a_new_epoch_is_new_however_small_its_number_and_of_an_old_one_never() {
        let mut inbox = inbox(Sabotage::None);
        let cases =
            [(0, 7, true), (0, 7, false), (1, 1, true), (0, 8, false), (1, 2, true), (1, 2, false), (2, 1, true)];
        for (epoch, seq, new) in cases {
            assert_eq!(progress(&mut inbox, PartitionId::SloshId, epoch, seq), new, "epoch {epoch}, seq {seq}");
        }
        assert!(progress(&mut inbox, PartitionId::ModalId, 0, 1), "each producer counts for itself");
        assert_eq!(inbox.counters().lost, 0, "a gap in a status topic is no loss of data");
    }

    #[test]
    fn a_progress_report_in_the_name_of_another_partition_is_dropped_and_counted() {
        let mut inbox = inbox(Sabotage::None);
        let mut sample = Progress::zeroed_at(0);
        (sample.header.source, sample.partition) = (PartitionId::SloshId.code(), PartitionId::ModalId.code().into());
        let (stamps, payload) = wire(PROGRESS, 0, 1, sample);
        assert!(!inbox.arrive(PROGRESS.id, &stamps, &payload));
        assert_eq!(inbox.counters().bad, 1);
        assert!(inbox.newest(PROGRESS).is_none());
        assert!(progress(&mut inbox, PartitionId::SloshId, 0, 1), "its own report is taken");
    }

    #[test]
    fn the_largest_sequence_number_overflows_no_counter() {
        let mut inbox = inbox(Sabotage::None);
        assert!(imu(&mut inbox, 0, u64::MAX));
        assert!(!imu(&mut inbox, 0, u64::MAX));
        assert_eq!(inbox.seen(IMU.id), u64::MAX);
        assert_eq!(inbox.counters().lost, u64::MAX - 1);
    }

    #[test]
    fn a_full_queue_keeps_the_newest_and_a_rejected_arrival_displaces_nothing() {
        let mut inbox = inbox(Sabotage::None);
        let depth = TOPICS[IMU.id].depth as u64;
        (1..=depth).for_each(|seq| assert!(imu(&mut inbox, 0, seq)));
        assert!(!imu(&mut inbox, 0, depth));
        let (stamps, mut damaged) = wire(IMU, 0, depth + 1, Imu::zeroed_at(7));
        damaged[40] ^= 1;
        assert!(!inbox.arrive(IMU.id, &stamps, &damaged));
        assert!(imu(&mut inbox, 0, depth + 2));
        let expected: Vec<u64> = (2..=depth).chain([depth + 2]).collect();
        assert_eq!(taken(&mut inbox, 0, depth + 2), expected);
    }

    #[test]
    fn ticks_come_one_at_a_time_in_order() {
        let mut inbox = inbox(Sabotage::None);
        for frame in 0..3 {
            let (stamps, payload) = wire(TICK, 0, frame + 1, Tick { frame, ..Tick::zeroed_at(frame) });
            assert!(inbox.arrive(TICK.id, &stamps, &payload));
        }
        for frame in 0..3 {
            assert_eq!(inbox.next_tick().map(|tick| tick.frame), Some(frame));
            inbox.collect(frame, &[0; TOPICS_MAX]);
        }
        assert!(inbox.next_tick().is_none());
    }

    #[test]
    fn a_topic_that_is_not_an_input_is_ignored_and_never_waited_for() {
        let mut inbox = Inbox::new(&[TICK.id], Cursors::default(), WINDOW, Sabotage::None);
        assert!(!imu(&mut inbox, 0, 1));
        assert!(inbox.has_all(&covers(9)));
        assert_eq!(inbox.counters(), Counters::default());
    }
}
