//! Parquet files: one dataset without a name, of the columns that are numbers, truths or times.
//!
//! Times are seconds, dates seconds since 1970 to the 0.2 us that `f64` resolves there; a column of
//! dates leads the rows where there is one only. What is missing is NaN. The metadata `unit` or
//! `units` that Arrow keeps of a column is its unit.

use crate::arrow_units;
use crate::bytes::{self, Bytes, COPY, bad};
use crate::dataset::{Axis, RawColumn, RawDataset, Wanted};
use crate::error::RecordingError;
use crate::file_name;
use crate::parquet_pages::Chunk;
use crate::parquet_schema::{self as schema, Leaf};
use crate::parquet_thrift::{self as thrift, Value};
use std::collections::BTreeMap;
use std::path::Path;

const PARQUET_MAGIC: &[u8] = b"PAR1";
/// Length of the metadata, and the last bytes of the file.
const FOOTER_END_BYTES: usize = 8;
/// What a file of any size may expand to: a column of one value has a few bytes.
const EXPANDED_MIN: usize = 64 << 20;

/// The dataset of a Parquet file, where it is wanted.
///
/// # Errors
/// The device's; a file that is damaged or encrypted, or has no column of numbers.
pub fn datasets(path: &Path, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    let content = bytes::whole(path)?;
    datasets_of(&file_name(path), &content, wanted)
}

fn datasets_of(file: &str, content: &[u8], wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    let metadata = metadata(file, content)?;
    if !wanted("") {
        return Ok(Vec::new());
    }
    let leaves = schema::leaves(file, metadata.list(2))?;
    let mut units = units(&metadata);
    let mut dataset = RawDataset::default();
    let mut left_out = Vec::new();
    let mut dates = Vec::new();
    let mut budget = content.len().saturating_mul(bytes::EXPANSION_MAX).saturating_add(EXPANDED_MIN);
    for (place, leaf) in leaves.iter().enumerate() {
        let meaning = match &leaf.meaning {
            Ok(meaning) => *meaning,
            Err(reason) => {
                left_out.push(format!("`{}` ({reason})", leaf.name));
                continue;
            }
        };
        let (mut values, mut rest) = (Vec::new(), Vec::new());
        for group in metadata.list(4) {
            let chunk = chunk(file, content, group, place, leaf, budget)?;
            let bytes = chunk.count().saturating_mul(size_of::<f64>());
            budget = budget.checked_sub(bytes).ok_or_else(|| {
                bad(file, format!("column `{}`", leaf.name), "it states a length that is absurd for this file", COPY)
            })?;
            let (more, rest_of_more) = chunk.read()?;
            if !rest_of_more.is_empty() {
                rest.resize(values.len(), 0.0);
                rest.extend(rest_of_more);
            }
            values.extend(more);
        }
        if meaning.is_date {
            dates.push(dataset.columns.len());
        }
        let unit = if meaning.is_time { Some("s".to_string()) } else { units.remove(&leaf.name) };
        dataset.columns.push(RawColumn { name: leaf.name.clone(), unit, values, rest });
    }
    if dataset.columns.is_empty() {
        let found = format!("no column of numbers is in the file; left out: {}", left_out.join(", "));
        return Err(bad(file, "the schema", found, "write the channels as columns of numbers"));
    }
    if let [only] = dates[..] {
        dataset.axis = Axis::Time(only);
    }
    if !left_out.is_empty() {
        dataset.notes.push(format!("left out: {}", left_out.join(", ")));
    }
    Ok(vec![dataset])
}

/// The structure at the end of the file.
fn metadata(file: &str, content: &[u8]) -> Result<Value, RecordingError> {
    let mut bytes = Bytes::new(file, "", content);
    bytes.go_to(content.len().saturating_sub(FOOTER_END_BYTES));
    let at = bytes.at();
    let length = bytes.u32("the end")? as usize;
    match bytes.take(PARQUET_MAGIC.len(), "the end")? {
        PARQUET_MAGIC => {}
        b"PARE" => return Err(bytes.error("the file is encrypted", "write the file again without encryption")),
        _ => return Err(bytes.error("the file does not end as Parquet does, it is cut", COPY)),
    }
    let start = at.checked_sub(length);
    let start = start.ok_or_else(|| bytes.error(format!("the metadata are stated to have {length} bytes"), COPY))?;
    bytes.go_to(start);
    thrift::structure(&mut bytes.split(length, "the metadata")?)
}

/// Units by name of the column.
fn units(metadata: &Value) -> BTreeMap<String, String> {
    let mut pairs = metadata.list(5).iter();
    let schema = pairs.find(|pair| pair.text(1).as_deref() == Some("ARROW:schema"));
    schema.and_then(|pair| pair.text(2)).map(|schema| arrow_units::units(&schema)).unwrap_or_default()
}

/// One column of a row group.
fn chunk<'a>(
    file: &'a str,
    content: &'a [u8],
    group: &Value,
    place: usize,
    leaf: &Leaf,
    limit: usize,
) -> Result<Chunk<'a>, RecordingError> {
    let wrong = |found: String| bad(file, format!("column `{}`", leaf.name), found, COPY);
    let column = group.list(1).get(place).and_then(|column| column.get(3));
    let column = column.ok_or_else(|| wrong("a row group does not have it".into()))?;
    let chunk = Chunk::open(file, content, column, leaf, limit)?;
    let rows = group.size(3);
    if rows != Some(chunk.count()) {
        return Err(wrong(format!("it has {} values in a group of {rows:?} rows", chunk.count())));
    }
    Ok(chunk)
}

#[cfg(test)]
mod tests;
