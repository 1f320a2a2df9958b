//! The reset log: every restart of a partition, over all runs that keep it, in a ring of records.
//!
//! Record = CRC-32 over the rest, partition, number, time, epoch, cause. A record that does not
//! check is left out; the others stay readable.

use crate::life::Life;
use crate::sys;
use rustix::fs::{FlockOperation, flock};
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use telemetry::PartitionId;

const RESET_BYTES: usize = 32;
/// A restart a minute for almost three days; 128 kB.
pub const RECORDS: u64 = 4096;
const NAME: &str = "resets";

/// A restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reset {
    /// Counted from 1 over all runs.
    pub number: u64,
    /// When, since 1970-01-01 UTC \[ns\].
    pub unix_ns: u64,
    /// Who.
    pub partition: PartitionId,
    /// How often it had been started before in its run.
    pub epoch: u32,
    /// What ended the life before: 0 unknown, 1 to 255 signal, 256 + exit code.
    pub cause: u32,
}

impl Reset {
    fn encode(&self) -> [u8; RESET_BYTES] {
        let mut record = [0; RESET_BYTES];
        record[4..6].copy_from_slice(&self.partition.code().to_le_bytes());
        record[8..16].copy_from_slice(&self.number.to_le_bytes());
        record[16..24].copy_from_slice(&self.unix_ns.to_le_bytes());
        record[24..28].copy_from_slice(&self.epoch.to_le_bytes());
        record[28..].copy_from_slice(&self.cause.to_le_bytes());
        let crc = telemetry::crc32(&record[4..]);
        record[..4].copy_from_slice(&crc.to_le_bytes());
        record
    }

    fn decode(record: &[u8]) -> Option<Self> {
        let word = |at: usize| Some(u32::from_le_bytes(*record.get(at..)?.first_chunk()?));
        let long = |at: usize| Some(u64::from_le_bytes(*record.get(at..)?.first_chunk()?));
        let is_whole = word(0)? == telemetry::crc32(record.get(4..)?);
        let partition = PartitionId::from_code(u16::try_from(word(4)?).ok()?)?;
        let reset = Reset { number: long(8)?, unix_ns: long(16)?, partition, epoch: word(24)?, cause: word(28)? };
        (is_whole && reset.number > 0).then_some(reset)
    }
}

/// The log in the folder that a run keeps things in.
#[must_use]
pub fn file(folder: &Path) -> PathBuf {
    folder.join(NAME)
}

/// Notes that `partition` begins another life now.
///
/// # Errors
/// When the file system refuses.
pub fn append(path: &Path, partition: PartitionId, life: Life) -> io::Result<()> {
    let file = File::options().read(true).write(true).create(true).truncate(false).open(path)?;
    // Two partitions may be restarted at once; the lock goes with the file.
    flock(&file, FlockOperation::LockExclusive)?;
    let number = whole(&std::fs::read(path)?).map(|reset| reset.number).max().unwrap_or(0) + 1;
    let reset = Reset { number, unix_ns: sys::unix_ns(), partition, epoch: life.epoch, cause: life.cause };
    file.write_all_at(&reset.encode(), (number - 1) % RECORDS * RESET_BYTES as u64)
}

fn whole(bytes: &[u8]) -> impl Iterator<Item = Reset> {
    bytes.chunks_exact(RESET_BYTES).filter_map(Reset::decode)
}

/// The whole records of a log, the oldest first; none of a file that is not there.
#[must_use]
pub fn read(path: &Path) -> Vec<Reset> {
    let mut all: Vec<Reset> = whole(&std::fs::read(path).unwrap_or_default()).collect();
    all.sort_by_key(|reset| reset.number);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reset(number: u64) -> Reset {
        let partition = PartitionId::ALL[number as usize % PartitionId::COUNT];
        Reset { number, unix_ns: number << 40, partition, epoch: number as u32, cause: 9 }
    }

    #[test]
    fn a_log_cut_or_damaged_at_any_byte_gives_every_record_that_is_whole() {
        let bytes: Vec<u8> = (1..=3).flat_map(|number| reset(number).encode()).collect();
        for cut in 0..=bytes.len() {
            assert_eq!(whole(&bytes[..cut]).count(), cut / RESET_BYTES, "cut at byte {cut}");
            if cut < bytes.len() {
                let mut wrong = bytes.clone();
                wrong[cut] ^= 0x10;
                let left: Vec<Reset> = whole(&wrong).collect();
                let expected: Vec<Reset> =
                    (1..=3).filter(|k| *k as usize != cut / RESET_BYTES + 1).map(reset).collect();
                assert_eq!(left, expected, "byte {cut} is wrong");
            }
        }
    }

    #[test]
    fn the_log_counts_over_runs_and_never_grows_beyond_its_ring() {
        let path = std::env::temp_dir().join(format!("obsid-resets-{}", std::process::id()));
        let full: Vec<u8> = (1..=RECORDS).flat_map(|number| reset(number).encode()).collect();
        std::fs::write(&path, full).unwrap();
        let life = Life { epoch: 3, cause: 11, parent: None };
        (0..2).for_each(|_| append(&path, PartitionId::ModalId, life).unwrap());
        let all = read(&path);
        let size = std::fs::metadata(&path).unwrap().len();
        std::fs::remove_file(&path).unwrap();
        assert_eq!((all.len() as u64, size), (RECORDS, RECORDS * RESET_BYTES as u64));
        assert_eq!((all[0].number, all.last().unwrap().number), (3, RECORDS + 2), "the oldest went");
        let newest = all.last().unwrap();
        assert_eq!((newest.partition, newest.epoch, newest.cause), (PartitionId::ModalId, 3, 11));
    }
}
