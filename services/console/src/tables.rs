//! `obsid tables`: parameter tables of a run that flies, and of the folder that keeps them.

mod file;

pub use file::{TableFile, read_whole};

use crate::command::{self, Sending};
use crate::{Failure, attach};
use clap::Subcommand;
use runtime::runner::TableReport;
use runtime::table_store::{StoredTable, TableStore};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use telemetry::{Opcode, PartitionId, Sample, TableId, Telecommand};

/// Parameter tables: list, load, validate, activate, dump
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid tables list                            every table and field, with range and unit
  obsid tables dump                            what is in force in the newest run, and what is loaded
  obsid tables dump supervisor guards --json
  obsid tables dump supervisor guards --file > guards.toml   as a file to change
  obsid tables validate guards.toml            ranges; no run is needed
  obsid tables load guards.toml                into the inactive slot
  obsid tables activate guards.toml            from one frame on, with the version that the file states
  obsid tables dump --store /var/lib/obsid     what a folder of slots would serve (obsid run --keep)

A table file:  format = 1
               partition = \"supervisor\"
               table = \"guards\"
               version = 2
               [values]
               safe_dwell_frames = 800

A field that a file leaves out keeps the value in force. A value outside its range is refused with its name, line and
range. An activated table is written to the older of two slots with a checksum: cut off at any byte, the other serves.")]
pub struct Arguments {
    #[command(subcommand)]
    order: Order,
    #[command(flatten)]
    to: Sending,
}

/// What is done.
#[derive(Subcommand)]
enum Order {
    /// Every table and field, with range and unit
    List {
        /// One table alone
        table: Option<String>,
    },
    /// What is in force and what is loaded
    Dump {
        /// Of this partition alone
        partition: Option<String>,
        /// This table alone
        table: Option<String>,
        /// One table as a table file
        #[arg(long, requires = "table")]
        file: bool,
        /// Of a folder that keeps tables beyond runs, in the place of a run
        #[arg(long, value_name = "DIR")]
        store: Option<PathBuf>,
    },
    /// Check a table file; exit code 3 when a value is not valid
    Validate {
        /// Table file (TOML)
        file: PathBuf,
    },
    /// Load a table file into the inactive slot
    Load {
        /// Table file (TOML)
        file: PathBuf,
    },
    /// Put the loaded values in force
    Activate {
        /// Table file (TOML) that was loaded: it states partition, table and version
        file: PathBuf,
    },
}

/// Carries the order out.
///
/// # Errors
/// [`Failure::Input`] for a table that is not valid or when no run flies, [`Failure::Run`] when the
/// run refuses.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let to = &arguments.to;
    match &arguments.order {
        Order::List { table } => list(table.as_deref(), to.json),
        Order::Dump { partition, table, file, store } => {
            let reports = match store {
                Some(folder) => of_store(folder),
                None => of_run(to)?,
            };
            let asked = Asked::new(partition.as_deref(), table.as_deref())?;
            let chosen: Vec<TableReport> = reports.into_iter().filter(|report| asked.names(&report.active)).collect();
            dump(&chosen, *file, to.json)
        }
        Order::Validate { file } => {
            let table = file::read(file, None)?;
            let state =
                if to.json { json!({ "valid": true, "fields": table.stated }).to_string() } else { "valid".into() };
            crate::print(&format!("{state}\n"));
            Ok(())
        }
        Order::Load { file } => {
            let table = file::read(file, Some(&of_run(to)?))?;
            command::show(to, command::send(to, command::of_table(Opcode::LoadTable, &table))?);
            Ok(())
        }
        Order::Activate { file } => {
            let table = file::read(file, None)?;
            let command = command::of_table(Opcode::ActivateTable, &table);
            command::show(to, command::send(to, Telecommand { values: Telecommand::zeroed_at(0).values, ..command })?);
            Ok(())
        }
    }
}

/// Which tables are meant.
struct Asked {
    partition: Option<PartitionId>,
    table: Option<TableId>,
}

impl Asked {
    fn new(partition: Option<&str>, table: Option<&str>) -> Result<Self, Failure> {
        let partition = partition.map(attach::partition).transpose()?;
        Ok(Asked { partition, table: table.map(table_named).transpose()? })
    }

    fn names(&self, of: &StoredTable) -> bool {
        self.partition.is_none_or(|id| id == of.partition) && self.table.is_none_or(|id| id == of.table)
    }
}

fn table_named(name: &str) -> Result<TableId, Failure> {
    let names = || TableId::ALL.iter().map(|id| id.text()).collect::<Vec<_>>().join(", ");
    TableId::named(name).ok_or_else(|| Failure::Usage(format!("no table is called '{name}'; there are {}", names())))
}

fn list(table: Option<&str>, json: bool) -> Result<(), Failure> {
    let asked = table.map(table_named).transpose()?;
    let tables = TableId::ALL.iter().filter(|table| asked.is_none_or(|one| one == **table));
    if json {
        let tables: Vec<Value> = tables.map(|table| crate::icd::table(*table)).collect();
        crate::print(&format!("{}\n", json!({ "tables": tables })));
        return Ok(());
    }
    let mut text = String::new();
    for table in tables {
        let whose: Vec<&str> = PartitionId::ALL.iter().filter(|id| table.is_of(**id)).map(|id| id.text()).collect();
        let _ = writeln!(text, "{table}: {}", whose.join(", "));
        for field in table.fields() {
            let range = format!("{} to {}", field.lowest, field.highest);
            let _ = writeln!(text, "  {:<26} {:<7} {range:<20} {}", field.name, field.unit, field.what);
        }
    }
    crate::print(&text);
    Ok(())
}

/// What the partitions of a run have left.
fn of_run(to: &Sending) -> Result<Vec<TableReport>, Failure> {
    let dir = attach::living(to.run.clone())?;
    let read = |&id: &PartitionId| -> Vec<TableReport> {
        let text = std::fs::read(dir.tables(id)).unwrap_or_default();
        serde_json::from_slice(&text).unwrap_or_default()
    };
    Ok(PartitionId::ALL.iter().flat_map(read).collect())
}

/// What a folder of slots serves; of slots that cannot serve, how many there are.
fn of_store(folder: &Path) -> Vec<TableReport> {
    stored_tables(folder).into_iter().map(|active| TableReport { active, is_default: false, loaded: None }).collect()
}

/// The tables that a folder keeps, as a run begins with them; damaged slots are reported.
pub fn stored_tables(folder: &Path) -> Vec<StoredTable> {
    let store = TableStore::at(folder);
    let mut found = Vec::new();
    for &partition in PartitionId::ALL {
        for &table in TableId::ALL.iter().filter(|table| table.is_of(partition)) {
            let served = store.load(partition, table);
            for slot in served.damaged {
                let serves = served.table.as_ref().map_or("the declared default", |_| "the other slot");
                let file = store.slot(partition, table, slot);
                crate::tell(&format!("{}: damaged, or of another build: {serves} serves", file.display()));
            }
            found.extend(served.table);
        }
    }
    found
}

fn dump(reports: &[TableReport], as_file: bool, json: bool) -> Result<(), Failure> {
    if json {
        let tables: Vec<Value> = reports.iter().map(object).collect();
        crate::print(&format!("{}\n", json!({ "tables": tables })));
        return Ok(());
    }
    for report in reports {
        let text = if as_file { file::text(&report.active) } else { lines(report) };
        crate::print(&text);
    }
    if reports.is_empty() {
        crate::tell("no such table");
    }
    Ok(())
}

fn named(table: &StoredTable) -> Value {
    let fields = table.table.fields().iter().zip(&table.values);
    let values: serde_json::Map<String, Value> =
        fields.map(|(field, value)| (field.name.to_string(), json!(value))).collect();
    let crc = table.checked().map(|values| format!("{:08x}", values.crc32(table.table, table.version)));
    json!({ "version": table.version, "crc32": crc, "values": values })
}

fn object(report: &TableReport) -> Value {
    let active = &report.active;
    json!({
        "partition": active.partition.text(), "table": active.table.text(), "default": report.is_default,
        "active": named(active), "loaded": report.loaded.as_ref().map(named),
    })
}

fn lines(report: &TableReport) -> String {
    let active = &report.active;
    let which = if report.is_default { "declared default".into() } else { format!("version {}", active.version) };
    let mut text = format!("{} {}: {which}\n", active.partition, active.table);
    for (index, field) in active.table.fields().iter().enumerate() {
        let value = active.values.get(index).copied().unwrap_or(f64::NAN);
        let loaded = report.loaded.as_ref().and_then(|table| Some((table.version, *table.values.get(index)?)));
        let loaded = loaded.filter(|(_, other)| *other != value);
        let loaded =
            loaded.map(|(version, other)| format!("  (loaded, version {version}: {other})")).unwrap_or_default();
        let _ = writeln!(text, "  {:<26} {value} {}{loaded}", field.name, field.unit);
    }
    text
}
