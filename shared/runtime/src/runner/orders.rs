//! Commands and tables of a partition: taken at the port, released with a frame, carried out with a
//! frame.
//!
//! A command that the port has taken is in a checkpoint before anybody hears of it. A supervisor
//! that dies earlier has accepted nothing, and the ground sends the same key again; one that dies
//! later sends it again out of its outbox.

use super::{RunError, Runner};
use crate::link::Link;
use crate::orders::{self, Answer, Orders};
use crate::table_store::{StoredTable, TableStore};
use serde::Serialize;
use std::path::PathBuf;
use telemetry::{
    EventCode, Header, Opcode, PartitionId, Refusal, TELECOMMAND, TableFault, TableId, TableValues, Telecommand,
};
use zerocopy::IntoBytes;

/// Where tables go.
#[derive(Clone, Debug)]
pub struct TablePlaces {
    /// Slots of the tables that were activated.
    pub slots: TableStore,
    /// What is in force, as JSON, for `obsid tables`.
    pub report: PathBuf,
}

/// Counters and places of commands; what a checkpoint holds is in [`Orders`].
#[derive(Default)]
pub(super) struct Desk {
    pub orders: Orders,
    /// Those of the run that are the mode table's are obeyed.
    pub obeys_mode: bool,
    /// Accepted since the last checkpoint: said once they are in one.
    accepted: Vec<(Telecommand, u64)>,
    /// Released since the last checkpoint: sent once they are in one.
    unsent: Vec<Telecommand>,
    pub executed: u32,
    pub refused: u32,
    pub places: Option<TablePlaces>,
    members: Vec<PartitionId>,
    /// Tables at start, without any command.
    defaults: Vec<StoredTable>,
}

/// One table of a partition, as `obsid tables` shows it.
#[derive(Clone, Debug, PartialEq, Serialize, serde::Deserialize)]
pub struct TableReport {
    /// In force.
    pub active: StoredTable,
    /// The declared default is in force.
    pub is_default: bool,
    /// In the inactive slot.
    pub loaded: Option<StoredTable>,
}

impl<L: Link> Runner<L> {
    /// What is in force at the start: the checkpoint's tables, else the run's, else the declared
    /// defaults.
    pub(super) fn begin_orders(&mut self, run: &crate::RunConfig, orders: Orders, is_fresh: bool) {
        self.desk.orders = orders;
        self.desk.orders.reserve();
        self.desk.accepted.reserve(orders::KEYS);
        self.desk.unsent.reserve(orders::KEYS);
        self.desk.members.clone_from(&run.partitions);
        self.desk.obeys_mode = self.partition.as_ref().is_some_and(|partition| partition.obeys_mode_commands());
        for &table in TableId::ALL {
            if let Some(values) = self.in_force(table) {
                self.desk.defaults.push(self.stored(table, 0, &values));
            }
        }
        if is_fresh {
            for table in run.tables.iter().filter(|table| table.partition == self.id) {
                self.desk.orders.activate(table.clone());
            }
            if self.id == PartitionId::Supervisor {
                self.desk.orders.take_stored(&run.commands);
            }
        }
        for table in self.desk.orders.active.clone() {
            if let Some(values) = table.checked() {
                self.put_in_force(table.table, &values);
            }
        }
    }

    /// Keeps activated tables in files from now on.
    pub fn keep_tables(&mut self, places: TablePlaces) {
        self.desk.places = Some(places);
        self.report_tables();
    }

    fn stored(&self, table: TableId, version: u16, values: &TableValues) -> StoredTable {
        StoredTable { partition: self.id, table, version, values: values.as_slice().to_vec() }
    }

    fn in_force(&self, table: TableId) -> Option<TableValues> {
        match table {
            TableId::Monitor => self.monitor_table(),
            table => self.partition.as_ref().and_then(|partition| partition.table(table)),
        }
    }

    fn put_in_force(&mut self, table: TableId, values: &TableValues) {
        match table {
            TableId::Monitor => self.configure_monitor(values),
            table => self.partition.iter_mut().for_each(|partition| partition.activate(table, values)),
        }
    }

    /// The port: takes what a ground program sent, and answers by an event.
    ///
    /// # Errors
    /// When the link refuses the event.
    pub fn take_command(&mut self, bytes: &[u8]) -> Result<(), RunError> {
        let (frame, obeys_mode) = (self.frames_done, self.desk.obeys_mode);
        match self.desk.orders.take(bytes, frame, &self.desk.members, obeys_mode) {
            Answer::Accepted(command) => {
                self.desk.accepted.push((command, frame));
                Ok(())
            }
            // One that no checkpoint holds yet is said to be accepted when one does.
            Answer::Repeated(command) if self.desk.accepted.iter().any(|(other, _)| other.key == command.key) => Ok(()),
            Answer::Repeated(command) => self.say_accepted(&command, frame),
            Answer::Refused(command, refusal, fault) => self.refuse(command.as_ref(), refusal, fault),
        }
    }

    /// The port: takes a command that a rule made.
    ///
    /// # Errors
    /// When the link refuses the event.
    pub fn take_own_command(&mut self, opcode: Opcode, to: u16) -> Result<(), RunError> {
        let (frame, obeys_mode) = (self.frames_done, self.desk.obeys_mode);
        match self.desk.orders.take_own((opcode, to), frame, &self.desk.members, obeys_mode) {
            Answer::Refused(command, refusal, fault) => self.refuse(command.as_ref(), refusal, fault),
            Answer::Accepted(command) | Answer::Repeated(command) => {
                self.desk.accepted.push((command, frame));
                Ok(())
            }
        }
    }

    fn say_accepted(&mut self, command: &Telecommand, frame: u64) -> Result<(), RunError> {
        let not_before = frame + u64::from(command.delay_frames);
        let numbers = [command.key as f64, command.opcode.into(), command.sequence.into(), not_before as f64];
        self.event(EventCode::CommandAccepted, &numbers)
    }

    fn refuse(
        &mut self,
        command: Option<&Telecommand>,
        refusal: Refusal,
        fault: Option<TableFault>,
    ) -> Result<(), RunError> {
        self.desk.refused = self.desk.refused.saturating_add(1);
        let (key, opcode, table) = command.map_or((0, 0, 0), |one| (one.key, one.opcode, one.table));
        if let Some(TableFault::Value { index, value, .. }) = fault {
            self.event(EventCode::TableRefused, &[table.into(), index as f64, value])?;
        }
        let last = self.desk.orders.last_sequence();
        self.event(EventCode::CommandRefused, &[key as f64, opcode.into(), refusal.code().into(), last.into()])
    }

    /// Port: commands that are due leave with this frame; they are sent with the next checkpoint.
    pub(super) fn release_commands(&mut self, frame: u64) {
        let window = self.outbox.window();
        let Some(mut command) = self.desk.orders.release(frame, window) else { return };
        let topic = TELECOMMAND.id;
        self.seq[topic] += 1;
        command.header = Header {
            layout: telemetry::TOPICS[topic].layout,
            source: self.id.code(),
            flags: 0,
            seq: self.seq[topic],
            t_meas_ns: frame * self.period_ns,
        };
        self.outbox.keep(frame, topic, command.as_bytes());
        self.desk.unsent.push(command);
    }

    /// A checkpoint holds what was accepted and what was released: now it can be known.
    pub(super) fn send_released(&mut self) -> Result<(), RunError> {
        for index in 0..self.desk.unsent.len() {
            let command = self.desk.unsent[index];
            let stamps = self.stamps(command.as_bytes());
            self.link.publish(TELECOMMAND.id, &stamps, command.as_bytes())?;
            self.bytes_sent += size_of::<Telecommand>() as u64;
        }
        for index in 0..self.desk.accepted.len() {
            let (command, frame) = self.desk.accepted[index];
            self.say_accepted(&command, frame)?;
        }
        self.desk.unsent.clear();
        self.desk.accepted.clear();
        Ok(())
    }

    /// Every partition: what takes effect with this frame, before the partition sees it.
    pub(super) fn carry_out_commands(&mut self, frame: u64) -> Result<(), RunError> {
        for index in 0..self.inbox.due(TELECOMMAND).len() {
            let command = self.inbox.due(TELECOMMAND)[index];
            if command.is_for(self.id) {
                self.carry_out(&command, frame)?;
            }
        }
        Ok(())
    }

    fn carry_out(&mut self, command: &Telecommand, frame: u64) -> Result<(), RunError> {
        // The same checks as at the port: who believes a peer's memory is no partition.
        let whole = command.is_intact();
        let content = orders::check_content(command, &self.desk.members, self.desk.obeys_mode);
        let fail = |refusal| Err((refusal, None));
        let result = match (whole, content, Opcode::from_code(command.opcode)) {
            (false, ..) => fail(Refusal::NotWhole),
            (_, Err(refusal), _) => Err(refusal),
            (_, _, None) => fail(Refusal::UnknownCommand),
            (_, _, Some(opcode)) => self.execute(opcode, command)?,
        };
        if let Err((refusal, fault)) = result {
            return self.refuse(Some(command), refusal, fault);
        }
        self.desk.executed = self.desk.executed.saturating_add(1);
        self.event(EventCode::CommandExecuted, &[command.key as f64, command.opcode.into(), frame as f64])
    }

    fn execute(
        &mut self,
        opcode: Opcode,
        command: &Telecommand,
    ) -> Result<Result<(), (Refusal, Option<TableFault>)>, RunError> {
        let table = TableId::from_code(command.table).filter(|table| self.in_force(*table).is_some());
        match (opcode, table) {
            // The mode table's are in the frame, for the partition itself.
            (Opcode::Ping | Opcode::Safe | Opcode::Resume | Opcode::AllowCapture, _) => {}
            (Opcode::ClearCounters, _) => {
                (self.desk.executed, self.desk.refused) = (0, 0);
                self.gate.clear();
            }
            (_, None) => return Ok(Err((Refusal::NotForIt, None))),
            (Opcode::LoadTable, Some(table)) => match orders::values_of(command, table) {
                Err(fault) => return Ok(Err((Refusal::OutOfRange, Some(fault)))),
                Ok(values) => {
                    let loaded = self.stored(table, command.version, &values);
                    self.desk.orders.load(loaded);
                    self.event(EventCode::TableLoaded, &[table.code().into(), command.version.into()])?;
                    self.report_tables();
                }
            },
            (Opcode::ValidateTable | Opcode::ActivateTable, Some(table)) => {
                let loaded = self.desk.orders.loaded(table).filter(|loaded| loaded.version == command.version);
                let Some((loaded, values)) = loaded.and_then(|loaded| Some((loaded.clone(), loaded.checked()?))) else {
                    return Ok(Err((Refusal::NothingLoaded, None)));
                };
                if opcode == Opcode::ActivateTable {
                    self.activate(loaded, &values)?;
                }
            }
        }
        Ok(Ok(()))
    }

    fn activate(&mut self, table: StoredTable, values: &TableValues) -> Result<(), RunError> {
        let (id, version) = (table.table, table.version);
        self.put_in_force(id, values);
        let stored = self.desk.places.as_ref().map_or(Ok(0), |places| places.slots.save(&table));
        self.desk.orders.activate(table);
        let crc = values.crc32(id, version);
        self.event(EventCode::TableActivated, &[id.code().into(), version.into(), crc.into()])?;
        if stored.is_err() {
            self.event(EventCode::TableNotStored, &[id.code().into()])?;
        }
        self.report_tables();
        Ok(())
    }

    /// Tables of this partition: what is in force and what is loaded.
    #[must_use]
    pub fn tables(&self) -> Vec<TableReport> {
        let report = |default: &StoredTable| {
            let active = self.desk.orders.active(default.table);
            TableReport {
                active: active.unwrap_or(default).clone(),
                is_default: active.is_none(),
                loaded: self.desk.orders.loaded(default.table).cloned(),
            }
        };
        self.desk.defaults.iter().map(report).collect()
    }

    /// For whoever looks at the run from outside; nothing depends on it.
    fn report_tables(&self) {
        let Some(places) = &self.desk.places else { return };
        if let Ok(text) = serde_json::to_vec(&self.tables()) {
            let fresh = places.report.with_extension("new");
            let _ = std::fs::write(&fresh, text).and_then(|()| std::fs::rename(&fresh, &places.report));
        }
    }
}
