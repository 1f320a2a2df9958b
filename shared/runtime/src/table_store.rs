//! Parameter tables on disk: two slots a table, written in turn, so that a write cut off at any
//! byte leaves the one before.
//!
//! Slot = magic, layout of the telemetry, generation, partition, table, version, count, values,
//! CRC-32 over all of it. A slot that does not check, or whose values are out of their ranges, is
//! as if it were not there.

use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use telemetry::{PartitionId, TableId, TableValues};

const SLOT_MAGIC: &[u8; 8] = b"obsidtb1";
/// Magic, layout, generation, four numbers of 16 bits.
const HEAD: usize = 8 + 4 + 8 + 4 * 2;
const CRC: usize = 4;

/// Values of a table, as they are kept in files and in checkpoints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredTable {
    /// Whose.
    pub partition: PartitionId,
    /// Which.
    pub table: TableId,
    /// Of the values, chosen by whoever loaded them.
    pub version: u16,
    /// One per field.
    pub values: Vec<f64>,
}

impl StoredTable {
    /// The values, if they are valid in this build.
    #[must_use]
    pub fn checked(&self) -> Option<TableValues> {
        let values = TableValues::checked(self.table, &self.values).ok()?;
        self.table.is_of(self.partition).then_some(values)
    }
}

/// Name of the attachment by which a recording says with which tables its run began.
pub const ATTACHMENT: &str = "tables.json";

/// Tables as the text of [`ATTACHMENT`].
#[must_use]
pub fn to_json(tables: &[StoredTable]) -> String {
    serde_json::to_string(tables).unwrap_or_default()
}

/// Tables of such a text; those that this build does not have, or whose values are out of range,
/// are left out.
#[must_use]
pub fn from_json(text: &[u8]) -> Vec<StoredTable> {
    let tables: Vec<StoredTable> = serde_json::from_slice(text).unwrap_or_default();
    tables.into_iter().filter(|table| table.checked().is_some()).collect()
}

/// Which values of two slots serve.
#[derive(Clone, Debug, PartialEq)]
pub struct Served {
    /// `None`: no slot is whole, the declared default serves.
    pub table: Option<StoredTable>,
    /// Number of the slot that serves.
    pub slot: Option<usize>,
    /// Slots that hold something, and not a table of this build.
    pub damaged: Vec<usize>,
}

/// The slots of all tables below a folder.
#[derive(Clone, Debug)]
pub struct TableStore(PathBuf);

impl TableStore {
    /// Names the folder; touches no file.
    #[must_use]
    pub fn at(folder: &Path) -> Self {
        TableStore(folder.to_path_buf())
    }

    /// File of a slot, 0 or 1.
    #[must_use]
    pub fn slot(&self, partition: PartitionId, table: TableId, slot: usize) -> PathBuf {
        self.0.join(format!("{partition}.{table}.{slot}"))
    }

    /// What serves of a table: the newest slot that is whole.
    #[must_use]
    pub fn load(&self, partition: PartitionId, table: TableId) -> Served {
        let slots = [0, 1].map(|slot| fs::read(self.slot(partition, table, slot)).unwrap_or_default());
        serve([&slots[0], &slots[1]], partition, table)
    }

    /// Writes the slot that does not serve; its number. The other one stays until this one is on
    /// the disk.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn save(&self, table: &StoredTable) -> io::Result<usize> {
        let slots = [0, 1].map(|slot| {
            let bytes = fs::read(self.slot(table.partition, table.table, slot)).unwrap_or_default();
            decode(&bytes, table.partition, table.table).map_or(0, |(generation, _)| generation)
        });
        let older = usize::from(slots[1] < slots[0]);
        let mut file = File::create(self.slot(table.partition, table.table, older))?;
        file.write_all(&encode(table, slots[0].max(slots[1]) + 1))?;
        file.sync_data()?;
        Ok(older)
    }
}

fn serve(slots: [&[u8]; 2], partition: PartitionId, table: TableId) -> Served {
    let read = slots.map(|bytes| decode(bytes, partition, table));
    let damaged = (0..2).filter(|&slot| !slots[slot].is_empty() && read[slot].is_none()).collect();
    let newest = read.into_iter().enumerate().filter_map(|(slot, read)| Some((slot, read?)));
    match newest.max_by_key(|(_, (generation, _))| *generation) {
        Some((slot, (_, table))) => Served { table: Some(table), slot: Some(slot), damaged },
        None => Served { table: None, slot: None, damaged },
    }
}

fn encode(table: &StoredTable, generation: u64) -> Vec<u8> {
    let mut bytes = SLOT_MAGIC.to_vec();
    bytes.extend(telemetry::generation().to_le_bytes());
    bytes.extend(generation.to_le_bytes());
    for number in [table.partition.code(), table.table.code(), table.version, table.values.len() as u16] {
        bytes.extend(number.to_le_bytes());
    }
    table.values.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
    bytes.extend(telemetry::crc32(&bytes).to_le_bytes());
    bytes
}

/// Generation and values of a slot that is whole and belongs to this table of this partition.
fn decode(bytes: &[u8], partition: PartitionId, table: TableId) -> Option<(u64, StoredTable)> {
    let (body, crc) = bytes.split_at_checked(bytes.len().checked_sub(CRC)?)?;
    let (head, values) = body.split_at_checked(HEAD)?;
    let number = |at: usize| Some(u16::from_le_bytes(*head.get(at..)?.first_chunk()?));
    let is_whole = telemetry::crc32(body).to_le_bytes() == crc
        && head.starts_with(SLOT_MAGIC)
        && head[8..12] == telemetry::generation().to_le_bytes()
        && [number(20)?, number(22)?] == [partition.code(), table.code()]
        && values.len() == 8 * usize::from(number(26)?);
    let generation = u64::from_le_bytes(*head[12..].first_chunk()?);
    let values = values.chunks_exact(8).filter_map(|value| Some(f64::from_le_bytes(*value.first_chunk()?))).collect();
    let stored = StoredTable { partition, table, version: number(24)?, values };
    (is_whole && stored.checked().is_some()).then_some((generation, stored))
}

#[cfg(test)]
mod tests {
    use super::*;

    const OF: (PartitionId, TableId) = (PartitionId::Supervisor, TableId::Guards);

    fn table(version: u16) -> StoredTable {
        let values = vec![0.01 * f64::from(version), 1.0, 2.0, 3.0, 4.0, f64::from(version)];
        StoredTable { partition: OF.0, table: OF.1, version, values }
    }

    fn served(slots: [&[u8]; 2]) -> Option<StoredTable> {
        serve(slots, OF.0, OF.1).table
    }

    #[test]
    fn of_two_slots_cut_at_every_byte_the_newest_whole_one_serves_or_the_default_and_never_a_mix() {
        let (old, new) = (encode(&table(1), 1), encode(&table(2), 2));
        for first in 0..=old.len() {
            for second in 0..=new.len() {
                let expected = match (first == old.len(), second == new.len()) {
                    (_, true) => Some(table(2)),
                    (true, false) => Some(table(1)),
                    (false, false) => None,
                };
                assert_eq!(served([&old[..first], &new[..second]]), expected, "cut at {first} and {second}");
                assert_eq!(served([&new[..second], &old[..first]]), expected, "the other way round");
            }
        }
    }

    #[test]
    fn new_bytes_over_old_ones_up_to_any_byte_are_no_table_of_their_own() {
        // A file system may keep the old length: the head of the new slot over the tail of an old
        // one.
        let (serving, old, new) = (encode(&table(2), 2), encode(&table(1), 1), encode(&table(3), 3));
        for cut in 0..new.len() {
            let mixed = [&new[..cut], &old[cut..]].concat();
            // both are whole where they happen to have the same bytes
            let whole = if mixed == old {
                table(2)
            } else if mixed == new {
                table(3)
            } else {
                table(2)
            };
            assert_eq!(served([&serving, &mixed]), Some(whole), "cut at {cut}");
        }
    }

    #[test]
    fn one_wrong_bit_anywhere_and_the_other_slot_serves() {
        let (old, new) = (encode(&table(1), 1), encode(&table(2), 2));
        for bit in 0..8 * new.len() {
            let mut wrong = new.clone();
            wrong[bit / 8] ^= 1 << (bit % 8);
            let answer = serve([&old, &wrong], OF.0, OF.1);
            assert_eq!((answer.table, answer.damaged), (Some(table(1)), vec![1]), "bit {bit}");
        }
    }

    #[test]
    fn tables_come_back_from_a_recording_bit_by_bit_and_bad_ones_do_not() {
        let exact = StoredTable { values: vec![0.1 + 0.2, 7.0, 7.0, 7.0, 7.0, 7.0], ..table(4) };
        let wild = StoredTable { values: vec![-1.0; 6], ..table(3) };
        let text = to_json(&[table(1), wild, exact.clone()]);
        assert_eq!(from_json(text.as_bytes()), [table(1), exact]);
        assert!(from_json(b"").is_empty());
    }

    #[test]
    fn values_out_of_range_and_tables_of_others_are_not_served_however_whole_their_slot_is() {
        let mut wild = table(2);
        wild.values[0] = -1.0;
        assert_eq!(served([&encode(&table(1), 1), &encode(&wild, 2)]), Some(table(1)));
        assert_eq!(serve([&encode(&table(1), 1), &[]], PartitionId::SloshId, TableId::Guards).table, None);
    }

    #[test]
    fn a_save_leaves_the_slot_that_served() {
        let folder = std::env::temp_dir().join(format!("obsid-tables-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let store = TableStore::at(&folder);
        let saved: Vec<usize> = (1..=5).map(|version| store.save(&table(version)).unwrap()).collect();
        let newest = store.load(OF.0, OF.1);
        fs::write(store.slot(OF.0, OF.1, newest.slot.unwrap()), "torn").unwrap();
        let before = store.load(OF.0, OF.1);
        fs::remove_dir_all(&folder).unwrap();
        assert!(saved.windows(2).all(|pair| pair[0] != pair[1]), "{saved:?}");
        assert_eq!((newest.table, before.table), (Some(table(5)), Some(table(4))));
    }
}
