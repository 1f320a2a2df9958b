//! A ring of frames as they were formed, in a file: the page cache keeps what a killed process
//! wrote, so that the next one sends the same frames under the same numbers.

use super::FeedCounts;
use std::fs::{File, OpenOptions};
use std::os::unix::fs::FileExt;
use std::path::Path;
use telemetry::{Delivery, TICK, TOPICS, TopicId};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Most samples of all topics in a frame.
const SAMPLES_MAX: usize = {
    let (mut count, mut topic) = (0, 0);
    while topic < telemetry::TOPIC_TABLE.len() {
        let info = &telemetry::TOPIC_TABLE[topic];
        if matches!(info.delivery, Delivery::Source) && topic != TICK.id {
            count += info.per_frame;
        }
        topic += 1;
    }
    count
};

/// Room for the fullest frame \[8-byte words\]: its samples, each behind the number of its topic.
const SLOT_WORDS: usize = {
    let (mut bytes, mut topic) = (0, 0);
    while topic < telemetry::TOPIC_TABLE.len() {
        let info = &telemetry::TOPIC_TABLE[topic];
        if matches!(info.delivery, Delivery::Source) && topic != TICK.id {
            bytes += info.per_frame * info.size;
        }
        topic += 1;
    }
    bytes / 8 + SAMPLES_MAX + HEAD_WORDS
};

const HEAD_WORDS: usize = size_of::<Head>() / 8;
const SLOT_BYTES: u64 = 8 * SLOT_WORDS as u64;

#[derive(Clone, Copy, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C)]
struct Head {
    /// Counted from 1, so that 0 marks an empty slot.
    frame: u64,
    origin_ns: u64,
    counts: [u64; 7],
    bytes: u32,
    crc32: u32,
}

/// The ring; it holds so many of the newest frames.
pub struct Journal {
    file: File,
    slots: u64,
    slot: Vec<u8>,
}

impl Journal {
    /// Opens the ring, and makes it where there is none.
    ///
    /// # Errors
    /// When the file cannot be opened.
    pub fn open(path: &Path, slots: u64) -> std::io::Result<Self> {
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)?;
        Ok(Journal { file, slots, slot: Vec::with_capacity(8 * SLOT_WORDS) })
    }

    /// Writes a frame: its samples, what was counted until it closed.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn write<'a>(
        &mut self,
        frame: u64,
        origin_ns: u64,
        counts: &FeedCounts,
        samples: impl Iterator<Item = (TopicId, &'a [u8])>,
    ) -> std::io::Result<()> {
        let head_bytes = size_of::<Head>();
        self.slot.clear();
        self.slot.resize(head_bytes, 0);
        for (topic, sample) in samples {
            self.slot.extend_from_slice(&(topic as u64).to_le_bytes());
            self.slot.extend_from_slice(sample);
        }
        let bytes = (self.slot.len() - head_bytes) as u32;
        let mut head = Head { frame: frame + 1, origin_ns, counts: words(counts), bytes, crc32: 0 };
        head.crc32 = crc32(&head, &self.slot[head_bytes..]);
        self.slot[..head_bytes].copy_from_slice(head.as_bytes());
        self.file.write_all_at(&self.slot, self.place(frame))
    }

    /// The samples of a frame, with origin and counts; `None` when the ring does not hold it whole.
    pub fn read(&mut self, frame: u64, sink: &mut dyn FnMut(TopicId, &[u8])) -> Option<(u64, FeedCounts)> {
        let head_bytes = size_of::<Head>();
        self.slot.resize(8 * SLOT_WORDS, 0);
        let place = self.place(frame);
        let read = read_as_much(&self.file, &mut self.slot, place);
        let (head, _) = Head::read_from_prefix(self.slot.get(..read)?).ok()?;
        let samples = self.slot.get(head_bytes..head_bytes + head.bytes as usize)?;
        if head.frame != frame + 1 || head.crc32 != crc32(&Head { crc32: 0, ..head }, samples) {
            return None;
        }
        let mut rest = samples;
        while let Some((topic, behind)) = rest.split_at_checked(8) {
            let topic = usize::try_from(u64::from_le_bytes(topic.try_into().ok()?)).ok()?;
            let (sample, behind) = behind.split_at_checked(TOPICS.get(topic)?.size)?;
            sink(topic, sample);
            rest = behind;
        }
        Some((head.origin_ns, counts(&head.counts)))
    }

    fn place(&self, frame: u64) -> u64 {
        frame % self.slots * SLOT_BYTES
    }
}

/// What had been counted when the newest frame closed that the ring in file `path` holds.
#[must_use]
pub fn newest_counts(path: &Path) -> Option<FeedCounts> {
    let slots = std::fs::metadata(path).ok()?.len().div_ceil(SLOT_BYTES);
    let mut journal = Journal::open(path, slots.max(1)).ok()?;
    let mut newest: Option<u64> = None;
    for slot in 0..slots {
        let mut frame = [0; 8];
        journal.file.read_exact_at(&mut frame, slot * SLOT_BYTES).ok()?;
        newest = newest.max(u64::from_le_bytes(frame).checked_sub(1));
    }
    journal.read(newest?, &mut |_, _| ()).map(|(_, counts)| counts)
}

fn crc32(head: &Head, samples: &[u8]) -> u32 {
    telemetry::crc32(head.as_bytes()) ^ telemetry::crc32(samples)
}

fn words(counts: &FeedCounts) -> [u64; 7] {
    let FeedCounts { received, late, duplicates, surplus, bad, empty_frames, strangers } = *counts;
    [received, late, duplicates, surplus, bad, empty_frames, strangers]
}

fn counts(words: &[u64; 7]) -> FeedCounts {
    let [received, late, duplicates, surplus, bad, empty_frames, strangers] = *words;
    FeedCounts { received, late, duplicates, surplus, bad, empty_frames, strangers }
}

/// Up to the end of the file.
fn read_as_much(file: &File, bytes: &mut [u8], place: u64) -> usize {
    let mut read = 0;
    while let Ok(count @ 1..) = file.read_at(&mut bytes[read..], place + read as u64) {
        read += count;
    }
    read
}

#[cfg(test)]
mod tests {
    use super::{FeedCounts, Journal, SLOT_BYTES, newest_counts};
    use std::os::unix::fs::FileExt;
    use telemetry::{ACCELEROMETERS, IMU, TOPICS};

    #[test]
    fn a_frame_is_read_back_whole_or_not_at_all() {
        let path = std::env::temp_dir().join(format!("obsid-journal-{}", std::process::id()));
        let mut journal = Journal::open(&path, 4).unwrap();
        let counts = FeedCounts { received: 7, late: 1, ..FeedCounts::default() };
        let of = |topic: usize, fill: u8| (topic, vec![fill; TOPICS[topic].size]);
        let sent = [of(IMU.id, 1), of(IMU.id, 2), of(ACCELEROMETERS.id, 3)];
        for frame in 0..6 {
            journal.write(frame, 40, &counts, sent.iter().map(|(topic, bytes)| (*topic, &bytes[..]))).unwrap();
        }
        let mut got = Vec::new();
        assert_eq!(journal.read(5, &mut |topic, bytes| got.push((topic, bytes.to_vec()))), Some((40, counts)));
        assert_eq!(got, sent);
        assert_eq!(journal.read(1, &mut |_, _| ()), None, "frame 5 took its place");
        assert_eq!(newest_counts(&path), Some(counts));
        let place = SLOT_BYTES + 100;
        journal.file.write_all_at(&[9], place).unwrap();
        assert_eq!(journal.read(5, &mut |_, _| ()), None, "a flipped byte");
        std::fs::remove_file(path).unwrap();
    }
}
