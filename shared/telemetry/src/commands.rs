//! Commands from the ground: one record, stamped in one place with the frame in which it takes
//! effect.

use crate::header::Header;
use crate::layout::record;
use crate::names::coded;
use crate::{PartitionId, TABLE_VALUES_MAX};
#[cfg(feature = "iceoryx2")]
use iceoryx2::prelude::ZeroCopySend;

/// `Telecommand::partition`: to every partition of the run.
pub const EVERY_PARTITION: u16 = u16::MAX;
/// Keys are arguments of events, which carry whole numbers up to this one exactly.
pub const KEY_MAX: u64 = (1 << 53) - 1;

coded! {
    /// What a command orders.
    Opcode {
        /// Nothing: the addressee answers with the key.
        Ping = 1 "ping",
        Safe = 2 "make safe",
        Resume = 3 "resume",
        AllowCapture = 4 "allow capture",
        /// Values go into the inactive slot.
        LoadTable = 5 "load table",
        ValidateTable = 6 "validate table",
        /// The inactive slot becomes the active one with this frame.
        ActivateTable = 7 "activate table",
        ClearCounters = 8 "clear counters",
    }
}

impl Opcode {
    /// Whether the mode table answers it, and therefore the supervisor alone.
    #[must_use]
    pub const fn is_of_mode(self) -> bool {
        matches!(self, Self::Safe | Self::Resume | Self::AllowCapture)
    }

    /// Whether it names a table.
    #[must_use]
    pub const fn is_of_table(self) -> bool {
        matches!(self, Self::LoadTable | Self::ValidateTable | Self::ActivateTable)
    }
}

coded! {
    /// Why a command is not carried out.
    Refusal {
        NotWhole = 1 "length, layout or checksum is wrong",
        UnknownCommand = 2 "no such command",
        UnknownPartition = 3 "no such partition in this run",
        NotForIt = 4 "this partition does not have that command or table",
        SequenceOld = 5 "its sequence number is not above the last one",
        KeyTooLarge = 6 "its key is above 2^52 - 1, or 0",
        QueueFull = 7 "too many commands wait",
        OutOfRange = 8 "a value of the table is out of its range",
        NothingLoaded = 9 "no table of that version is loaded",
        DelayTooLong = 10 "its delay is longer than a million frames",
    }
}

record! {
    /// A command, as a ground program sends it and as partitions receive it. What the port fills in
    /// is 0 in what is sent to it.
    Telecommand {
        header: Header, "-", "-", "header; layout is checked at the port";
        frame: u64, "-", "-", "frame in which the port released it, by the port";
        effective_frame: u64, "-", "-", "frame in which it is carried out, by the port";
        key: u64, "-", "-", "idempotence key, 1 to 2^52 - 1; above it the commands of rules. A repeated one is executed once";
        sequence: u32, "-", "-", "counter of the ground, above that of every command before";
        delay_frames: u32, "-", "-", "released so many frames after it was accepted, or later";
        opcode: u16, "-", "-", "code of Opcode";
        partition: u16, "-", "-", "addressee, code of PartitionId; 65535: every partition";
        table: u16, "-", "-", "table commands: code of TableId";
        version: u16, "-", "-", "table commands: version of the values";
        count: u32, "-", "-", "load table: values in use";
        reserved: u32, "-", "-", "0";
        values: [f64; TABLE_VALUES_MAX], "of the table's fields", "-", "load table: one per field, in their order";
        crc32: u32, "-", "-", "CRC-32 (IEEE) over key to values";
        reserved_too: u32, "-", "-", "0";
    }
}

crate::seal::sealed!(Telecommand, key);

impl Telecommand {
    /// Whether `partition` is to carry it out.
    #[must_use]
    pub fn is_for(&self, partition: PartitionId) -> bool {
        self.partition == EVERY_PARTITION || self.partition == partition.code()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sample;

    #[test]
    fn a_command_with_any_wrong_bit_is_not_intact_and_its_release_changes_nothing() {
        let sealed = Telecommand { key: 7, opcode: 1, ..Telecommand::zeroed_at(0) }.sealed();
        assert!(sealed.is_intact());
        assert!(Telecommand { frame: 9, effective_frame: 109, ..sealed }.is_intact());
        let mut values = sealed.values;
        values[TABLE_VALUES_MAX - 1] = f64::from_bits(1);
        assert!(!Telecommand { values, ..sealed }.is_intact());
        assert!(!Telecommand { delay_frames: 1, ..sealed }.is_intact());
    }

    #[test]
    fn a_command_reaches_its_addressee_alone_unless_it_names_every_partition() {
        let ping = Telecommand { partition: PartitionId::SloshId.code(), ..Telecommand::zeroed_at(0) };
        assert!(ping.is_for(PartitionId::SloshId) && !ping.is_for(PartitionId::ModalId));
        assert!(Telecommand { partition: EVERY_PARTITION, ..ping }.is_for(PartitionId::ModalId));
    }
}
