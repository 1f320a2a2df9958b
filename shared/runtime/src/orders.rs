//! What was ordered: the checks of the ground port, commands that wait for their frame, and the
//! tables in force. All of it is in the checkpoint.

use crate::table_store::StoredTable;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use telemetry::{
    EVERY_PARTITION, KEY_MAX, Layout, Opcode, PartitionId, Refusal, Sample, TELECOMMAND, TOPICS, TableFault, TableId,
    TableValues, Telecommand,
};
use zerocopy::{FromBytes, IntoBytes};

/// Keys by which a repeated command is known.
pub(crate) const KEYS: usize = 64;
/// Commands that wait for their frame.
const ORDERS_WAITING_MAX: usize = 64;
const DELAY_MAX_FRAMES: u32 = 1_000_000;
/// Of the topic's buffer, which a consumer two windows behind must find unbroken: two places are
/// left for rounding.
const UNDERWAY_MAX: u64 = TOPICS_DEPTH - 2;
const TOPICS_DEPTH: u64 = telemetry::TOPIC_TABLE[TELECOMMAND.id].depth as u64;

/// Keys above this one are those of commands that rules made.
const OWN_KEYS: u64 = KEY_MAX / 2;

/// A command and the frame before which it is not released.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredCommand {
    /// Counted from 0.
    pub frame: u64,
    /// A [`Telecommand`].
    pub bytes: Vec<u8>,
}

/// Orders of one partition; only the supervisor has commands that wait.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Orders {
    last_sequence: u32,
    keys: VecDeque<u64>,
    waiting: VecDeque<StoredCommand>,
    /// Commands that rules made.
    own: u64,
    next_release: u64,
    /// In force.
    pub active: Vec<StoredTable>,
    /// Loaded and not in force.
    pub loaded: Vec<StoredTable>,
}

/// What a port did with a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// It waits for its frame.
    Accepted(Telecommand),
    /// Its key is known: it is not executed again.
    Repeated(Telecommand),
    /// Nothing was changed. The command is `None` where it could not be read.
    Refused(Option<Telecommand>, Refusal, Option<TableFault>),
}

/// Reads a command out of a copy of what somebody sent.
fn read(bytes: &[u8]) -> Option<Telecommand> {
    let command = Telecommand::read_from_bytes(bytes).ok()?;
    (command.header.layout == Telecommand::HASH && command.is_intact()).then_some(command)
}

/// Values of a `load table`.
///
/// # Errors
/// Names the first field whose value is not valid.
pub fn values_of(command: &Telecommand, table: TableId) -> Result<TableValues, TableFault> {
    let count = command.count as usize;
    let expected = table.fields().len();
    let values = command.values.get(..count).ok_or(TableFault::Count { found: count, expected })?;
    TableValues::checked(table, values)
}

impl Orders {
    /// Of the sequence numbers that were accepted, the last.
    #[must_use]
    pub fn last_sequence(&self) -> u32 {
        self.last_sequence
    }

    /// Takes the memory that commands need.
    pub fn reserve(&mut self) {
        self.keys.reserve(KEYS + 1);
        self.waiting.reserve(ORDERS_WAITING_MAX);
    }

    /// A stored sequence: waits from the beginning of the run. Its commands were checked where they
    /// were read.
    pub fn take_stored(&mut self, commands: &[StoredCommand]) {
        for stored in commands {
            if let Some(command) = read(&stored.bytes) {
                self.note(&command);
                self.wait(stored.clone());
            }
        }
    }

    /// Checks what came at `frame`, and has it wait if all is in order. `obeys_mode`: this
    /// supervisor answers commands of the mode table.
    pub fn take(&mut self, bytes: &[u8], frame: u64, run: &[PartitionId], obeys_mode: bool) -> Answer {
        let Some(command) = read(bytes) else { return Answer::Refused(None, Refusal::NotWhole, None) };
        if self.keys.contains(&command.key) {
            return Answer::Repeated(command);
        }
        if let Err((refusal, fault)) = self.check(&command, run, obeys_mode) {
            return Answer::Refused(Some(command), refusal, fault);
        }
        self.note(&command);
        let frame = frame + u64::from(command.delay_frames);
        self.wait(StoredCommand { frame, bytes: bytes.to_vec() });
        Answer::Accepted(command)
    }

    /// Has a command of a rule wait: it has no sequence number, and a key that no ground program
    /// gives.
    pub fn take_own(
        &mut self,
        (opcode, to): (Opcode, u16),
        frame: u64,
        run: &[PartitionId],
        obeys_mode: bool,
    ) -> Answer {
        self.own += 1;
        let command =
            Telecommand { opcode: opcode.code(), partition: to, key: OWN_KEYS + self.own, ..Telecommand::zeroed_at(0) };
        if let Err((refusal, fault)) = check_content(&command, run, obeys_mode) {
            return Answer::Refused(Some(command), refusal, fault);
        }
        if self.waiting.len() >= ORDERS_WAITING_MAX {
            return Answer::Refused(Some(command), Refusal::QueueFull, None);
        }
        self.note(&command);
        self.wait(StoredCommand { frame, bytes: datagram(command) });
        Answer::Accepted(command)
    }

    fn check(
        &self,
        command: &Telecommand,
        run: &[PartitionId],
        obeys_mode: bool,
    ) -> Result<(), (Refusal, Option<TableFault>)> {
        let refuse = |refusal| Err((refusal, None));
        if command.key == 0 || command.key > OWN_KEYS {
            return refuse(Refusal::KeyTooLarge);
        }
        if command.sequence <= self.last_sequence {
            return refuse(Refusal::SequenceOld);
        }
        if command.delay_frames > DELAY_MAX_FRAMES {
            return refuse(Refusal::DelayTooLong);
        }
        check_content(command, run, obeys_mode)?;
        if self.waiting.len() >= ORDERS_WAITING_MAX { refuse(Refusal::QueueFull) } else { Ok(()) }
    }

    fn note(&mut self, command: &Telecommand) {
        self.last_sequence = self.last_sequence.max(command.sequence);
        self.keys.push_back(command.key);
        if self.keys.len() > KEYS {
            self.keys.pop_front();
        }
    }

    /// In the order of frames; those of one frame in the order in which they came.
    fn wait(&mut self, command: StoredCommand) {
        let at = self.waiting.partition_point(|other| other.frame <= command.frame);
        self.waiting.insert(at, command);
    }

    /// The next command that is due in `frame`, stamped with the frame in which it takes effect
    /// (architecture D4). They come so far apart that the topic's buffer holds all that a consumer
    /// may have to catch up with.
    pub fn release(&mut self, frame: u64, window: u64) -> Option<Telecommand> {
        let due = self.waiting.front().is_some_and(|first| first.frame <= frame) && frame >= self.next_release;
        let command = due.then(|| self.waiting.pop_front()).flatten().and_then(|stored| read(&stored.bytes))?;
        self.next_release = frame + (2 * window).div_ceil(UNDERWAY_MAX);
        Some(Telecommand { frame, effective_frame: frame + window, ..command })
    }

    /// The table in force; `None`: the declared default.
    #[must_use]
    pub fn active(&self, table: TableId) -> Option<&StoredTable> {
        self.active.iter().find(|stored| stored.table == table)
    }

    /// The table that waits for its activation.
    #[must_use]
    pub fn loaded(&self, table: TableId) -> Option<&StoredTable> {
        self.loaded.iter().find(|stored| stored.table == table)
    }

    /// Puts values into the inactive slot.
    pub fn load(&mut self, table: StoredTable) {
        put(&mut self.loaded, table);
    }

    /// Puts values in force.
    pub fn activate(&mut self, table: StoredTable) {
        put(&mut self.active, table);
    }
}

fn put(tables: &mut Vec<StoredTable>, table: StoredTable) {
    tables.retain(|other| other.table != table.table);
    tables.push(table);
}

/// Everything about a command that does not depend on what came before it.
///
/// # Errors
/// Why it cannot be carried out in this run.
pub fn check_content(
    command: &Telecommand,
    run: &[PartitionId],
    obeys_mode: bool,
) -> Result<(), (Refusal, Option<TableFault>)> {
    let refuse = |refusal| Err((refusal, None));
    let Some(opcode) = Opcode::from_code(command.opcode) else { return refuse(Refusal::UnknownCommand) };
    let addressee = PartitionId::from_code(command.partition).filter(|id| run.contains(id));
    if addressee.is_none() && command.partition != EVERY_PARTITION {
        return refuse(Refusal::UnknownPartition);
    }
    if opcode.is_of_mode() && !(obeys_mode && addressee == Some(PartitionId::Supervisor)) {
        return refuse(Refusal::NotForIt);
    }
    if !opcode.is_of_table() {
        return Ok(());
    }
    let Some(table) = TableId::from_code(command.table) else { return refuse(Refusal::NotForIt) };
    if !run.iter().filter(|&&id| command.is_for(id)).all(|&id| table.is_of(id)) {
        return refuse(Refusal::NotForIt);
    }
    if opcode == Opcode::LoadTable {
        values_of(command, table).map_err(|fault| (Refusal::OutOfRange, Some(fault)))?;
    }
    Ok(())
}

/// The bytes of `command` as a ground program sends them.
#[must_use]
pub fn datagram(command: Telecommand) -> Vec<u8> {
    let mut command = command.sealed();
    command.header.layout = TOPICS[TELECOMMAND.id].layout;
    command.as_bytes().to_vec()
}
