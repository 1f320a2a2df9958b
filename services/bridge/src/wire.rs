//! Samples as payloads of streams: stamps, then the sample as shared memory has it.

use delivery::{Mark, OWN_STREAMS, StreamId};
use serde::{Deserialize, Serialize};
use telemetry::{Delivery, EVENT, Header, PartitionId, Stamps, TOPICS, TopicId, is_result};
use zerocopy::{FromBytes, IntoBytes};

/// Commands to the run at the far end, as its port takes them.
pub const COMMANDS: StreamId = OWN_STREAMS;

/// Sources of a topic have their own streams.
const SOURCES: StreamId = 64;
const _: () = assert!(TOPICS_FIT && PartitionId::COUNT < SOURCES as usize);
const TOPICS_FIT: bool = telemetry::TOPIC_TABLE.len() * (SOURCES as usize) < OWN_STREAMS as usize;
const STAMPS: usize = size_of::<Stamps>();

/// What a mirror is made of, as JSON in the origin of a run's samples.
#[derive(Debug, Serialize, Deserialize)]
pub struct About {
    pub name: String,
    pub period_ns: u64,
    pub window_frames: u64,
    pub partitions: Vec<PartitionId>,
}

/// Results and events.
#[must_use]
pub fn default_topics() -> Vec<TopicId> {
    (0..TOPICS.len()).filter(|&topic| is_result(topic) || topic == EVENT.id).collect()
}

/// A sample whose size, layout and checksum are right.
pub struct Sound {
    pub stream: StreamId,
    pub mark: Mark,
    pub stamps: Stamps,
    pub topic: TopicId,
    pub source: u16,
}

/// Checks a sample; `None` for one that is damaged or laid out otherwise.
pub fn sound(topic: TopicId, stamps: &Stamps, payload: &[u8]) -> Option<Sound> {
    let info = TOPICS.get(topic)?;
    let (header, _) = Header::read_from_prefix(payload).ok()?;
    let is_whole = payload.len() == info.size && header.layout == info.layout;
    let is_sound = is_whole && header.source < SOURCES && telemetry::crc32(payload) == stamps.crc32;
    // A result is numbered over all lives of its producer; a report in each one.
    let epoch = if info.delivery == Delivery::Status { stamps.epoch } else { 0 };
    is_sound.then_some(Sound {
        stream: topic as StreamId * SOURCES + header.source,
        mark: Mark { epoch, seq: header.seq },
        stamps: *stamps,
        topic,
        source: header.source,
    })
}

/// Topic and source of a stream of samples.
pub fn topic_and_source(stream: StreamId) -> (TopicId, u16) {
    (TopicId::from(stream / SOURCES), stream % SOURCES)
}

pub fn to_bytes(stamps: &Stamps, payload: &[u8]) -> Vec<u8> {
    [stamps.as_bytes(), payload].concat()
}

/// A sample of the line, checked again: between the producer and here nothing has changed it.
pub fn from_bytes(stream: StreamId, bytes: &[u8]) -> Option<(Sound, &[u8])> {
    let (stamps, payload) = bytes.split_at_checked(STAMPS)?;
    let stamps = Stamps::read_from_bytes(stamps).ok()?;
    let sound = sound(topic_and_source(stream).0, &stamps, payload)?;
    (sound.stream == stream).then_some((sound, payload))
}

#[cfg(test)]
mod tests {
    use super::{default_topics, from_bytes, sound, to_bytes};
    use telemetry::{ESTIMATE_SLOSH, IMU, PartitionId, Sample, SloshEstimate, Stamps, TICK, TOPICS, is_carried};
    use zerocopy::IntoBytes;

    #[test]
    fn a_sample_with_one_wrong_bit_is_not_sound_on_either_end() {
        let mut sample = SloshEstimate::zeroed_at(7);
        sample.header.layout = TOPICS[ESTIMATE_SLOSH.id].layout;
        (sample.header.source, sample.header.seq) = (PartitionId::SloshId.code(), 3);
        let payload = sample.as_bytes();
        let stamps = Stamps { epoch: 1, crc32: telemetry::crc32(payload), sent_ns: 5 };
        let whole = sound(ESTIMATE_SLOSH.id, &stamps, payload).unwrap();
        assert_eq!((whole.mark.epoch, whole.mark.seq), (0, 3));
        let bytes = to_bytes(&stamps, payload);
        assert_eq!(from_bytes(whole.stream, &bytes).unwrap().1, payload);
        assert!(from_bytes(whole.stream + 1, &bytes).is_none(), "another source's stream");
        for bit in 0..payload.len() * 8 {
            let mut damaged = bytes.clone();
            damaged[16 + bit / 8] ^= 1 << (bit % 8);
            assert!(from_bytes(whole.stream, &damaged).is_none(), "bit {bit}");
        }
        assert!(from_bytes(whole.stream, &bytes[..40]).is_none());
    }

    #[test]
    fn results_and_reports_are_carried_and_sensors_are_not() {
        assert!(default_topics().into_iter().all(is_carried));
        assert!(!is_carried(IMU.id) && !is_carried(TICK.id));
    }
}
