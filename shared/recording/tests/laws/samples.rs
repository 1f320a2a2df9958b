//! Sealed samples of every topic, filled with numbers that show where they belong.

use crate::Numbers;
use recording::RecordedRun;
use telemetry::{Header, Sample, Stamps, TOPICS, Topic, TopicId, TopicVisitor, crc32, for_each_topic};

/// A payload with header, and its stamps.
pub fn seal<T: Sample>(topic: Topic<T>, mut sample: T, seq: u64, epoch: u32) -> (TopicId, Stamps, Vec<u8>) {
    let header = sample.header_mut();
    (header.layout, header.seq) = (TOPICS[topic.id].layout, seq);
    let payload = sample.as_bytes().to_vec();
    let stamps = Stamps { epoch, crc32: crc32(&payload), sent_ns: 1_000_000 * seq + u64::from(epoch) };
    (topic.id, stamps, payload)
}

/// A sample of any type, all its words random finite numbers.
pub fn random<T: Sample>(numbers: &mut Numbers, t_meas_ns: u64) -> T {
    let mut bytes = vec![0; size_of::<T>()];
    for word in bytes.chunks_exact_mut(8) {
        word.copy_from_slice(&numbers.unit().to_le_bytes());
    }
    let mut sample = T::read_from_bytes(&bytes).unwrap();
    *sample.header_mut() = Header::at(t_meas_ns);
    sample
}

struct Everything {
    run: RecordedRun,
    numbers: Numbers,
    seq: u64,
}

impl TopicVisitor for Everything {
    fn visit<T: Sample>(&mut self, topic: Topic<T>, _: &'static telemetry::TopicInfo) {
        let sample: T = random(&mut self.numbers, self.seq * 10_000_000);
        let (id, stamps, payload) = seal(topic, sample, self.seq, 0);
        self.run.push(id, &stamps, &payload).unwrap();
    }
}

/// `rounds` samples of every topic, in memory.
pub fn everything(rounds: u64) -> RecordedRun {
    let mut all = Everything { run: RecordedRun::new("memory"), numbers: Numbers(11), seq: 0 };
    for seq in 1..=rounds {
        all.seq = seq;
        for_each_topic(&mut all);
    }
    all.run
}

/// Topic, stamps and bytes of every sample.
pub fn listed(run: &RecordedRun) -> Vec<(TopicId, Stamps, Vec<u8>)> {
    run.samples().map(|sample| (sample.topic, *sample.stamps, sample.payload.to_vec())).collect()
}
