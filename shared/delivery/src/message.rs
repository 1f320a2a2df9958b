//! What goes over the line: a CRC-32, then one message.

use crate::StreamId;
use serde::{Deserialize, Serialize};

/// Of this file's format.
pub const PROTOCOL: u16 = 1;
const CRC_BYTES: usize = size_of::<u32>();

/// The number that a producer gave a sample: contiguous, in every life (`epoch`) greater than
/// before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Mark {
    /// Life of the producer; 0 where its numbers go on over its lives.
    pub epoch: u32,
    /// From 1 on.
    pub seq: u64,
}

/// Where an end's samples come from.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// The producers of another origin have another one, and number from 1 again.
    pub number: u64,
    /// What the other end needs to know of it; empty for an end without samples.
    pub about: Vec<u8>,
}

/// Both ends send all of them. `life` is that of the end whose samples the message speaks of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Message {
    /// Who is there, once a second. Samples are taken of nobody who has not said it. `finished`: no
    /// sample will come, and every one was acknowledged.
    Hello { protocol: u16, life: u64, finished: bool, origin: Origin, generation: u32, layouts: Vec<u32> },
    /// Sample `number` of a stream. Those before `first` will not come (again); `before` is the
    /// mark of the last one of them.
    /// `sent_ms` is the sender's clock, which the answer repeats.
    Data {
        life: u64,
        stream: StreamId,
        number: u64,
        sent_ms: u64,
        first: u64,
        before: Mark,
        mark: Mark,
        payload: Vec<u8>,
    },
    /// Every sample of the stream through this one has arrived or was declared lost; bit k of
    /// `held`: so has sample `through + 2 + k`. `echo_ms` is of the sample that is answered.
    /// `by` is the life of the end that has them.
    Received { by: u64, life: u64, stream: StreamId, through: u64, held: u32, echo_ms: u64 },
}

impl Message {
    pub fn to_bytes(&self) -> Vec<u8> {
        let body = postcard::to_extend(self, vec![0; CRC_BYTES]);
        let mut bytes = body.expect("a message has no field that its codec refuses");
        let crc = crc32fast::hash(&bytes[CRC_BYTES..]);
        bytes[..CRC_BYTES].copy_from_slice(&crc.to_le_bytes());
        bytes
    }

    /// `None` for what is damaged or is no message.
    pub fn from_bytes(bytes: &[u8]) -> Option<Message> {
        let (crc, body) = bytes.split_first_chunk::<CRC_BYTES>()?;
        if u32::from_le_bytes(*crc) != crc32fast::hash(body) {
            return None;
        }
        postcard::take_from_bytes(body).ok().filter(|(_, rest)| rest.is_empty()).map(|(message, _)| message)
    }
}

#[cfg(test)]
mod tests {
    use super::{Mark, Message};

    #[test]
    fn a_message_with_one_wrong_bit_or_of_another_length_is_none() {
        let mark = Mark { epoch: 2, seq: 9 };
        let message = Message::Data {
            life: 3,
            stream: 4,
            number: 7,
            sent_ms: 1,
            first: 5,
            before: mark,
            mark,
            payload: vec![1, 2, 3],
        };
        let bytes = message.to_bytes();
        assert_eq!(Message::from_bytes(&bytes), Some(message));
        for bit in 0..bytes.len() * 8 {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Message::from_bytes(&damaged), None, "bit {bit}");
        }
        for length in 0..bytes.len() {
            assert_eq!(Message::from_bytes(&bytes[..length]), None, "{length} bytes");
        }
        assert_eq!(Message::from_bytes(&[&bytes[..], &[0]].concat()), None);
    }
}
