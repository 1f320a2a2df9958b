//! Checkpoints: two slots, written in turn, so that a write cut off at any byte leaves the one
//! before.
//!
//! What a partition has that only grows is appended to a file beside them before a slot says how
//! much of it counts; what a kill left behind that is cut off.
//!
//! Slot = magic, format, layout of the telemetry, generation, length, CRC-32, postcard body. A slot
//! that does not check is as if it were not there.

use crate::inbox::Cursors;
use crate::orders::Orders;
use crate::outbox::{Entry, Outbox};
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use telemetry::{PartitionId, TOPICS_MAX};

const MAGIC: &[u8; 8] = b"obsidck1";
const HEAD_BYTES: usize = 8 + 4 + 8 + 8 + 4;

/// Everything that a restarted partition goes on from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Frames done.
    pub frames: u64,
    /// The last frame of the run is among them.
    pub ended: bool,
    /// Partitions that had been given up.
    pub given_up: Vec<PartitionId>,
    /// By topic: last sequence number sent.
    pub seq: [u64; TOPICS_MAX],
    /// By topic: last sequence number taken; and the counters of the inbox.
    pub cursors: Cursors,
    /// Commands and tables.
    pub orders: Orders,
    /// Outputs that a restart sends again.
    pub outbox: Vec<Entry>,
    /// The partition's own state.
    pub state: Vec<u8>,
    /// Bytes of its journal that belong to it.
    pub journal: u64,
}

/// A checkpoint as a partition writes it, without a copy of its parts; the bytes are those of a
/// [`Checkpoint`].
#[derive(Serialize)]
pub struct CheckpointParts<'a> {
    /// As [`Checkpoint::frames`].
    pub frames: u64,
    /// As [`Checkpoint::ended`].
    pub ended: bool,
    /// As [`Checkpoint::given_up`].
    pub given_up: &'a [PartitionId],
    /// As [`Checkpoint::seq`].
    pub seq: &'a [u64; TOPICS_MAX],
    /// As [`Checkpoint::cursors`].
    pub cursors: Cursors,
    /// As [`Checkpoint::orders`].
    pub orders: &'a Orders,
    /// As [`Checkpoint::outbox`].
    pub outbox: Entries<'a>,
    /// As [`Checkpoint::state`].
    #[serde(serialize_with = "as_bytes")]
    pub state: &'a [u8],
    /// As [`Checkpoint::journal`].
    pub journal: u64,
}

/// As one piece: the bytes in the file are those of a sequence, which would be written one by one.
pub(crate) fn as_bytes<S: serde::Serializer>(bytes: impl AsRef<[u8]>, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_bytes(bytes.as_ref())
}

/// The entries of an outbox, in the order in which they were sent.
pub struct Entries<'a>(pub &'a Outbox);

impl Serialize for Entries<'_> {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeSeq;
        let mut sequence = to.serialize_seq(Some(self.0.entries().count()))?;
        self.0.entries().try_for_each(|entry| sequence.serialize_element(entry))?;
        sequence.end()
    }
}

/// Why a checkpoint could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {reason}")]
pub struct CheckpointError {
    path: PathBuf,
    reason: String,
}

/// The two slots of one partition.
#[derive(Debug)]
pub struct Store {
    slots: [PathBuf; 2],
    generation: u64,
    buffer: Vec<u8>,
    journal: Journal,
}

/// The file of what only grows.
#[derive(Debug)]
struct Journal {
    path: PathBuf,
    /// Open once something was appended in this life.
    file: Option<fs::File>,
    bytes: usize,
}

impl Store {
    /// Slots `<folder>/<partition>.{0,1}` and `<folder>/<partition>.journal`.
    #[must_use]
    pub fn new(folder: &Path, partition: &str) -> Self {
        Store {
            slots: [0, 1].map(|slot| folder.join(format!("{partition}.{slot}"))),
            generation: 0,
            buffer: Vec::new(),
            journal: Journal { path: folder.join(format!("{partition}.journal")), file: None, bytes: 0 },
        }
    }

    /// Appends what `journal` holds beyond what was appended before; the slot that is saved next
    /// says that it counts.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn append(&mut self, journal: &[u8]) -> Result<(), CheckpointError> {
        let own = &mut self.journal;
        let Some(fresh) = journal.get(own.bytes..).filter(|fresh| !fresh.is_empty()) else { return Ok(()) };
        let path = &own.path;
        let fail = |error: std::io::Error| CheckpointError { path: path.clone(), reason: error.to_string() };
        if own.file.is_none() {
            let file = fs::File::options().create(true).append(true).open(path).map_err(fail)?;
            file.set_len(own.bytes as u64).map_err(fail)?;
            own.file = Some(file);
        }
        if let Some(file) = &mut own.file {
            file.write_all(fresh).map_err(fail)?;
        }
        own.bytes = journal.len();
        Ok(())
    }

    /// The journal as it was at `checkpoint`; later bytes are cut off when more is appended.
    ///
    /// # Errors
    /// When fewer bytes are there than the checkpoint says.
    pub fn journal(&mut self, checkpoint: &Checkpoint) -> Result<Vec<u8>, CheckpointError> {
        let bytes = checkpoint.journal as usize;
        let mut journal = if bytes == 0 { Vec::new() } else { fs::read(&self.journal.path).unwrap_or_default() };
        if journal.len() < bytes {
            let reason = format!("{} bytes, the checkpoint says {bytes}", journal.len());
            return Err(CheckpointError { path: self.journal.path.clone(), reason });
        }
        journal.truncate(bytes);
        (self.journal.file, self.journal.bytes) = (None, bytes);
        Ok(journal)
    }

    /// Takes memory for checkpoints of so many bytes.
    pub fn reserve(&mut self, bytes: usize) {
        self.buffer.reserve(bytes);
    }

    /// Whether there is a slot, whole or not: a partition that restarts and finds none whole begins
    /// anew.
    #[must_use]
    pub fn exists(&self) -> bool {
        self.slots.iter().any(|path| path.exists())
    }

    /// Removes both slots and the journal: the next life begins without a checkpoint.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn clear(&mut self) -> std::io::Result<()> {
        (self.generation, self.journal.file, self.journal.bytes) = (0, None, 0);
        for path in self.slots.iter().chain([&self.journal.path]) {
            match fs::remove_file(path) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        Ok(())
    }

    /// The newest checkpoint that is whole; later writes go on after its generation.
    ///
    /// # Errors
    /// Never for a damaged slot; only when a whole slot holds a body of another build.
    pub fn load(&self) -> Result<Option<Checkpoint>, CheckpointError> {
        let newest = self
            .slots
            .iter()
            .filter_map(|path| Some((read_slot(path)?, path)))
            .max_by_key(|((generation, _), _)| *generation);
        let Some(((_, body), path)) = newest else { return Ok(None) };
        let checkpoint = postcard::from_bytes(&body)
            .map_err(|error| CheckpointError { path: path.clone(), reason: error.to_string() })?;
        Ok(Some(checkpoint))
    }

    /// Writes the older slot; the newer one stays until this one is whole.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn save(&mut self, checkpoint: &impl Serialize) -> Result<(), CheckpointError> {
        let slot = self.encode(checkpoint)?;
        self.write(slot, self.buffer.len())
    }

    /// Drill: writes so many thousandths only.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn save_torn(&mut self, checkpoint: &impl Serialize, permille: u32) -> Result<(), CheckpointError> {
        let slot = self.encode(checkpoint)?;
        let bytes = self.buffer.len() as u64 * u64::from(permille.min(1000)) / 1000;
        self.write(slot, bytes as usize)
    }

    fn encode(&mut self, checkpoint: &impl Serialize) -> Result<usize, CheckpointError> {
        if self.generation == 0 {
            self.generation = self
                .slots
                .iter()
                .filter_map(|path| read_slot(path))
                .map(|(generation, _)| generation)
                .max()
                .unwrap_or(0);
        }
        self.generation += 1;
        let slot = (self.generation % 2) as usize;
        let path = &self.slots[slot];
        let fail = |error: postcard::Error| CheckpointError { path: path.clone(), reason: error.to_string() };
        let mut buffer = core::mem::take(&mut self.buffer);
        buffer.clear();
        buffer.resize(HEAD_BYTES, 0);
        buffer = postcard::to_extend(checkpoint, buffer).map_err(fail)?;
        let (head, body) = buffer.split_at_mut(HEAD_BYTES);
        head[..8].copy_from_slice(MAGIC);
        head[8..12].copy_from_slice(&telemetry::generation().to_le_bytes());
        head[12..20].copy_from_slice(&self.generation.to_le_bytes());
        head[20..28].copy_from_slice(&(body.len() as u64).to_le_bytes());
        let crc = checksum(&head[..28], body);
        head[28..32].copy_from_slice(&crc.to_le_bytes());
        self.buffer = buffer;
        Ok(slot)
    }

    fn write(&self, slot: usize, bytes: usize) -> Result<(), CheckpointError> {
        let path = &self.slots[slot];
        let fail = |error: std::io::Error| CheckpointError { path: path.clone(), reason: error.to_string() };
        // Over the slot's old bytes: to give its pages back and to take new ones costs as much as
        // to fill them. The length changes last; what is cut off before that fails its check.
        let mut file = fs::File::options().create(true).truncate(false).write(true).open(path).map_err(fail)?;
        file.write_all(&self.buffer[..bytes]).and_then(|()| file.set_len(bytes as u64)).map_err(fail)
    }
}

/// Over head and body: a flipped bit in the generation would make the older slot win.
fn checksum(head: &[u8], body: &[u8]) -> u32 {
    telemetry::crc32(body) ^ telemetry::crc32(head)
}

/// Whether the bytes of a slot are a whole checkpoint of this build.
#[must_use]
pub fn is_whole(slot: &[u8]) -> bool {
    parse_slot(slot).is_some()
}

/// Generation and body of a slot that is whole and of this build.
fn read_slot(path: &Path) -> Option<(u64, Vec<u8>)> {
    let bytes = fs::read(path).ok()?;
    parse_slot(&bytes).map(|(generation, body)| (generation, body.to_vec()))
}

fn parse_slot(bytes: &[u8]) -> Option<(u64, &[u8])> {
    let (head, body) = bytes.split_at_checked(HEAD_BYTES)?;
    let word = |at: usize| Some(u64::from_le_bytes(head.get(at..at + 8)?.try_into().ok()?));
    let half = |at: usize| Some(u32::from_le_bytes(head.get(at..at + 4)?.try_into().ok()?));
    // The length first: most cuts end there.
    let whole = &head[..8] == MAGIC
        && word(20)? == body.len() as u64
        && half(8)? == telemetry::generation()
        && half(28)? == checksum(&head[..28], body);
    whole.then_some((word(12)?, body))
}

#[cfg(test)]
mod tests {
    use super::{Checkpoint, Store};

    /// A test's own folder, gone when the test is.
    struct Folder(std::path::PathBuf);

    impl Folder {
        fn new(test: &str) -> Self {
            let path = std::env::temp_dir().join(format!("obsid-checkpoint-{test}-{}", std::process::id()));
            std::fs::create_dir_all(&path).unwrap();
            Folder(path)
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn a_write_cut_at_any_byte_leaves_the_checkpoint_before() {
        let folder = Folder::new("cut");
        let older = Checkpoint { frames: 25, state: vec![7; 40], ..Checkpoint::default() };
        let newer = Checkpoint { frames: 50, state: vec![9; 40], ..Checkpoint::default() };
        let mut store = Store::new(&folder.0, "any");
        store.save(&older).unwrap();
        store.save(&newer).unwrap();
        let path = folder.0.join("any.0");
        let whole = std::fs::read(&path).unwrap();
        for cut in 0..whole.len() {
            std::fs::write(&path, &whole[..cut]).unwrap();
            assert_eq!(Store::new(&folder.0, "any").load().unwrap().as_ref(), Some(&older), "cut at byte {cut}");
        }
        std::fs::write(&path, &whole).unwrap();
        assert_eq!(Store::new(&folder.0, "any").load().unwrap().as_ref(), Some(&newer));
    }

    #[test]
    fn new_bytes_over_old_ones_up_to_any_byte_leave_the_checkpoint_before() {
        let folder = Folder::new("over");
        let of = |frames, bytes| Checkpoint { frames, state: vec![frames as u8; bytes], ..Checkpoint::default() };
        let (oldest, older, newest) = (of(25, 90), of(50, 40), of(75, 40));
        let mut store = Store::new(&folder.0, "any");
        store.save(&oldest).unwrap();
        let path = folder.0.join("any.1");
        let below = std::fs::read(&path).unwrap();
        store.save(&older).unwrap();
        store.save(&newest).unwrap();
        let whole = std::fs::read(&path).unwrap();
        assert!(whole.len() < below.len(), "the slot has shrunk with its checkpoint");
        assert_eq!(Store::new(&folder.0, "any").load().unwrap().as_ref(), Some(&newest));
        // Killed before the new length: the head of the newest over the tail of the oldest.
        for cut in 0..=whole.len() {
            std::fs::write(&path, [&whole[..cut], &below[cut..]].concat()).unwrap();
            assert_eq!(Store::new(&folder.0, "any").load().unwrap().as_ref(), Some(&older), "cut at byte {cut}");
        }
    }

    #[test]
    fn a_partition_writes_the_bytes_of_the_checkpoint_that_a_restart_reads() {
        let outbox = crate::outbox::Outbox::from_entries(Vec::new(), 20);
        let checkpoint = Checkpoint { frames: 25, state: (0..300).map(|k| k as u8).collect(), ..Checkpoint::default() };
        let parts = super::CheckpointParts {
            frames: checkpoint.frames,
            ended: false,
            given_up: &[],
            seq: &checkpoint.seq,
            cursors: checkpoint.cursors,
            orders: &checkpoint.orders,
            outbox: super::Entries(&outbox),
            state: &checkpoint.state,
            journal: 0,
        };
        assert_eq!(postcard::to_stdvec(&parts).unwrap(), postcard::to_stdvec(&checkpoint).unwrap());
    }

    #[test]
    fn a_journal_comes_back_as_it_was_at_the_checkpoint_and_goes_on_from_there() {
        let folder = Folder::new("journal");
        let mut store = Store::new(&folder.0, "any");
        store.append(b"one").unwrap();
        store.save(&Checkpoint { journal: 3, ..Checkpoint::default() }).unwrap();
        // killed between the journal and its checkpoint
        store.append(b"one two").unwrap();
        let mut again = Store::new(&folder.0, "any");
        let checkpoint = again.load().unwrap().unwrap();
        assert_eq!(again.journal(&checkpoint).unwrap(), b"one");
        again.append(b"one and").unwrap();
        again.append(b"one and").unwrap();
        assert_eq!(std::fs::read(folder.0.join("any.journal")).unwrap(), b"one and");
    }

    #[test]
    fn a_journal_shorter_than_its_checkpoint_says_is_not_taken_up() {
        let folder = Folder::new("short-journal");
        let mut store = Store::new(&folder.0, "any");
        store.append(b"one").unwrap();
        let beyond = Checkpoint { journal: 4, ..Checkpoint::default() };
        assert!(store.journal(&beyond).unwrap_err().to_string().contains("3 bytes"));
    }

    #[test]
    fn a_flipped_bit_is_not_taken_up() {
        let folder = Folder::new("flip");
        let older = Checkpoint { frames: 25, ..Checkpoint::default() };
        let mut store = Store::new(&folder.0, "any");
        store.save(&older).unwrap();
        store.save(&Checkpoint { frames: 50, ..Checkpoint::default() }).unwrap();
        let path = folder.0.join("any.0");
        let whole = std::fs::read(&path).unwrap();
        for byte in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[byte] ^= 4;
            std::fs::write(&path, damaged).unwrap();
            assert_eq!(Store::new(&folder.0, "any").load().unwrap().as_ref(), Some(&older), "byte {byte}");
        }
    }
}
