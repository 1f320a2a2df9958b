//! Table files: values by name, checked against their ranges, each error at its line.

use crate::Failure;
use crate::toml_file::TomlFile;
use runtime::runner::TableReport;
use runtime::table_store::StoredTable;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use telemetry::{PartitionId, TableFault, TableId, TableValues};
use toml::Spanned;

const CURE: &str = "see `obsid tables --help` for a table file, `obsid tables list` for every field and range";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: u32,
    partition: Spanned<PartitionId>,
    table: Spanned<TableId>,
    version: u16,
    #[serde(default)]
    values: BTreeMap<Spanned<String>, Spanned<f64>>,
}

/// A table file.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFile {
    /// Whose table.
    pub partition: PartitionId,
    /// Which one.
    pub table: TableId,
    /// Of the values.
    pub version: u16,
    /// One per field; those that the file leaves out are in force, or the lowest of their range.
    pub values: Vec<f64>,
    /// Fields that the file states.
    pub stated: usize,
}

/// Reads and checks a table file; what it leaves out is taken from `in_force`.
///
/// # Errors
/// [`Failure::Input`] with file, line, field, value and range.
pub fn read(file: &Path, in_force: Option<&[TableReport]>) -> Result<TableFile, Failure> {
    let source = TomlFile::read(file, CURE)?;
    let parsed: File = source.parsed(|parsed: &File| parsed.format)?;
    let at = |span, message| source.at(span, message);
    let (partition, table) = (*parsed.partition.get_ref(), *parsed.table.get_ref());
    if !table.is_of(partition) {
        return Err(at(parsed.table.span(), format!("{partition} has no table '{table}'")));
    }
    let base = in_force.unwrap_or_default().iter().map(|report| &report.active);
    let base = base.into_iter().find(|own| (own.partition, own.table) == (partition, table));
    let mut values = match base {
        Some(stored) => stored.values.clone(),
        None => table.fields().iter().map(|field| field.lowest).collect(),
    };
    for (key, value) in &parsed.values {
        let Some(index) = table.fields().iter().position(|field| field.name == key.get_ref()) else {
            return Err(at(key.span(), format!("{table} has no field '{}'", key.get_ref())));
        };
        values[index] = *value.get_ref();
    }
    TableValues::checked(table, &values).map_err(|fault| {
        let of =
            |field: &str| parsed.values.iter().find(|(key, _)| key.get_ref() == field).map(|(_, value)| value.span());
        let span = if let TableFault::Value { field, .. } = &fault { of(field.name) } else { None };
        at(span.unwrap_or_else(|| parsed.table.span()), fault.to_string())
    })?;
    Ok(TableFile { partition, table, version: parsed.version, values, stated: parsed.values.len() })
}

/// Reads a table file that states every field, so that nothing depends on what is in force.
///
/// # Errors
/// As [`read`]; names a field that is missing.
pub fn read_whole(file: &Path) -> Result<TableFile, Failure> {
    let table = read(file, None)?;
    if table.stated == table.values.len() {
        return Ok(table);
    }
    Err(Failure::Input(miette::miette!(
        help = "`obsid tables dump PARTITION TABLE --file` writes one with every field",
        "{}: states {} of the {} fields of {}: in a sequence each is stated",
        file.display(),
        table.stated,
        table.values.len(),
        table.table
    )))
}

/// A table as a file, its version one higher.
pub fn text(table: &StoredTable) -> String {
    let (partition, name, version) = (table.partition, table.table, table.version.saturating_add(1));
    let mut text =
        format!("format = 1\npartition = \"{partition}\"\ntable = \"{name}\"\nversion = {version}\n\n[values]\n");
    for (field, value) in table.table.fields().iter().zip(&table.values) {
        let _ = writeln!(text, "{} = {value}  # {}: {}", field.name, field.unit, field.what);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "format = 1\npartition = \"supervisor\"\ntable = \"guards\"\nversion = 2\n[values]\n";

    fn answer(name: &str, text: &str) -> Result<TableFile, String> {
        let path = std::env::temp_dir().join(format!("obsid-table-{name}-{}.toml", std::process::id()));
        std::fs::write(&path, text).unwrap();
        let read = read_whole(&path);
        std::fs::remove_file(&path).unwrap();
        read.map_err(|failure| match failure {
            Failure::Input(report) => report.to_string(),
            other => other.to_string(),
        })
    }

    #[test]
    fn a_bad_value_is_refused_with_line_name_value_and_range() {
        let wrong = [
            ("base_rate_limit_rad_s = -0.5", "base_rate_limit_rad_s = -0.5 rad/s: must be 0.000000001 to 1000"),
            ("settle_frames = 2.5", "settle_frames = 2.5 frames: must be a whole number from 0 to"),
            ("settle_frames = nan", "settle_frames = NaN"),
            ("dwell = 3", "guards has no field 'dwell'"),
        ];
        for (line, says) in wrong {
            let refusal = answer("wrong", &format!("{HEAD}{line}\n")).unwrap_err();
            assert!(refusal.contains(".toml:6:") && refusal.contains(says), "{refusal}");
        }
        let other = answer("other", &HEAD.replace("supervisor", "slosh-id")).unwrap_err();
        assert!(other.contains("slosh-id has no table 'guards'"), "{other}");
    }

    #[test]
    fn a_table_written_as_a_file_is_read_back_bit_by_bit_with_the_next_version() {
        let values = vec![0.1 + 0.2, 1.0, 2.0, 3.0, 4.0, 5.0];
        let stored = StoredTable {
            partition: PartitionId::Supervisor,
            table: TableId::Guards,
            version: 6,
            values: values.clone(),
        };
        let back = answer("back", &text(&stored)).unwrap();
        assert_eq!((back.version, back.values), (7, values));
        let part = answer("part", &format!("{HEAD}settle_frames = 2\n")).unwrap_err();
        assert!(part.contains("states 1 of the 6 fields"), "{part}");
    }
}
