//! Identity of a run: one hash over every estimate, mode and verdict (architecture D7).
//!
//! "Same result" means equal digests of the whole published stream: the last value of a forgetting
//! filter hides what was lost on the way. Stamps (epoch, wall time) do not enter, so a run with
//! killed and restarted partitions has the digest of the undisturbed one.

use crate::error::RecordingError;
use crate::run::RecordedRun;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use telemetry::{Header, TOPICS, TopicId, is_result};
use zerocopy::FromBytes;

const HEADER: usize = size_of::<Header>();

/// Hash of a run's results, and how many of each topic there were.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Digest {
    /// BLAKE3, 64 hexadecimal digits.
    pub hex: String,
    /// Samples per topic, by name, duplicates counted once.
    pub counts: BTreeMap<&'static str, u64>,
}

/// Collects result samples in any order.
#[derive(Default)]
pub struct DigestBuilder {
    /// By topic and sequence number: time of measurement and body.
    samples: BTreeMap<(TopicId, u64), (u64, Vec<u8>)>,
}

impl DigestBuilder {
    /// A digest of no samples yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a sample; topics that are no results are ignored, re-sent samples are counted once.
    ///
    /// # Errors
    /// [`RecordingError::DigestConflict`] when a number was sent twice with different data,
    /// [`RecordingError::SampleSize`].
    pub fn add(&mut self, topic: TopicId, payload: &[u8]) -> Result<(), RecordingError> {
        if !is_result(topic) {
            return Ok(());
        }
        let info = &TOPICS[topic];
        let header = Header::read_from_prefix(payload).ok().filter(|_| payload.len() == info.size);
        let Some((header, body)) = header else {
            let (found, expected) = (payload.len(), info.size);
            return Err(RecordingError::SampleSize { topic: info.name.into(), found, expected });
        };
        match self.samples.entry((topic, header.seq)) {
            Entry::Vacant(entry) => {
                entry.insert((header.t_meas_ns, body.to_vec()));
                Ok(())
            }
            Entry::Occupied(entry) => {
                let (t_meas_ns, first) = entry.get();
                let differs = first.iter().zip(body).position(|(a, b)| a != b).map(|at| HEADER + at);
                let time_differs = (*t_meas_ns != header.t_meas_ns).then_some(core::mem::offset_of!(Header, t_meas_ns));
                match time_differs.or(differs) {
                    None => Ok(()),
                    Some(byte) => Err(RecordingError::DigestConflict { topic: info.name, seq: header.seq, byte }),
                }
            }
        }
    }

    /// Hashes topic name, seq, t_meas and body of every sample, in the order (frame, topic, seq).
    #[must_use]
    pub fn finish(&self) -> Digest {
        // Every result has its frame right behind the header.
        let frame = |body: &[u8]| u64::from_le_bytes(*body.first_chunk().expect("a result begins with its frame"));
        let mut order: Vec<_> =
            self.samples.iter().map(|((topic, seq), (t, body))| (frame(body), *topic, *seq, *t, body)).collect();
        order.sort_by_key(|(frame, topic, seq, ..)| (*frame, *topic, *seq));
        let mut hasher = blake3::Hasher::new();
        let mut counts = BTreeMap::new();
        for (_, topic, seq, t_meas_ns, body) in order {
            let name = TOPICS[topic].name;
            hasher.update(&(name.len() as u64).to_le_bytes());
            hasher.update(name.as_bytes());
            hasher.update(&seq.to_le_bytes());
            hasher.update(&t_meas_ns.to_le_bytes());
            hasher.update(body);
            *counts.entry(name).or_insert(0) += 1;
        }
        Digest { hex: hasher.finalize().to_hex().to_string(), counts }
    }
}

/// Digest of a recorded run.
///
/// # Errors
/// As [`DigestBuilder::add`].
pub fn digest(run: &RecordedRun) -> Result<Digest, RecordingError> {
    let mut builder = DigestBuilder::new();
    for sample in run.samples() {
        builder.add(sample.topic, sample.payload)?;
    }
    Ok(builder.finish())
}
