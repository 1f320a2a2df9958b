//! Parquet files: one dataset without a name, of the columns that are numbers, truths or times.
//!
//! Times are seconds, dates seconds since 1970 to the 0.2 us that `f64` resolves there; a column of
//! dates leads the rows where there is one only; texts that are all dates or all numbers are such.
//! What is missing is NaN. A list of one length in every row is a column for each place. The metadata
//! that Arrow keeps of a column are those of [`crate::conventions`].

use crate::arrow_units::{self, Field};
use crate::bytes::{self, Bytes, COPY, bad};
use crate::conventions::Storage;
use crate::dataset::{Axis, RawColumn, RawDataset, Wanted};
use crate::error::RecordingError;
use crate::file_name;
use crate::intake::origin::if_any;
use crate::parquet_pages::{Chunk, Pages};
use crate::parquet_schema::{self as schema, Leaf, Meaning};
use crate::parquet_thrift::{self as thrift, Value};
use std::collections::BTreeMap;
use std::path::Path;

const PARQUET_MAGIC: &[u8] = b"PAR1";
/// Length of the metadata, and the last bytes of the file.
const FOOTER_END_BYTES: usize = 8;
/// What a file of any size may expand to: a column of one value has a few bytes.
const EXPANDED_MIN: usize = 64 << 20;

/// Elements of a list that become columns.
const LIST_MAX: usize = 64;

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
    let budget = content.len().saturating_mul(bytes::EXPANSION_MAX).saturating_add(EXPANDED_MIN);
    let fields = fields(&metadata);
    let mut reading = Reading { file, content, budget, fields, found: RawDataset::default(), dates: Vec::new() };
    let mut left_out = Vec::new();
    for (place, leaf) in leaves.iter().enumerate() {
        let read = match &leaf.meaning {
            Ok(_) => reading.column(&metadata, place, leaf)?,
            Err(reason) => Err(reason.clone()),
        };
        match read {
            Ok(column) => reading.add(column, leaf),
            Err(reason) => left_out.push(format!("`{}` ({reason})", leaf.name)),
        }
    }
    let Reading { found: mut dataset, dates, .. } = reading;
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

/// What was read so far.
struct Reading<'a> {
    file: &'a str,
    content: &'a [u8],
    /// Bytes that the columns may still have.
    budget: usize,
    fields: BTreeMap<String, Field>,
    found: RawDataset,
    /// Places of the columns of dates.
    dates: Vec<usize>,
}

impl Reading<'_> {
    /// The column of all row groups, or why it is left out.
    fn column(&mut self, metadata: &Value, place: usize, leaf: &Leaf) -> Result<Result<Pages, String>, RecordingError> {
        let mut all = Pages::default();
        for group in metadata.list(4) {
            let chunk = chunk(self.file, self.content, group, place, leaf, self.budget)?;
            let bytes = chunk.count().saturating_mul(size_of::<f64>());
            self.budget = self.budget.checked_sub(bytes).ok_or_else(|| {
                let found = "it states a length that is absurd for this file";
                bad(self.file, format!("column `{}`", leaf.name), found, COPY)
            })?;
            match chunk.read() {
                Ok(pages) => all.extend(pages),
                // what is a channel in few files costs no other
                Err(_) if leaf.is_text() => return Ok(Err("text or bytes".into())),
                Err(error) if leaf.is_optional() => return Ok(Err(error.without_file(self.file))),
                Err(error) => return Err(error),
            }
        }
        if leaf.is_text() && !all.is_number() {
            return Ok(Err("text or bytes".into()));
        }
        Ok(Ok(all))
    }

    /// Adds a column, or one for each place of lists of one length.
    fn add(&mut self, mut pages: Pages, leaf: &Leaf) {
        let (unit, is_date) = self.stated(&mut pages, leaf);
        let Pages { values, rest, starts, .. } = pages;
        let column = |name: String, values: Vec<f64>, rest: Vec<f64>| RawColumn {
            name,
            unit: unit.clone(),
            values,
            rest: if_any(rest),
        };
        if !leaf.is_list {
            if is_date {
                self.dates.push(self.found.columns.len());
            }
            self.found.columns.push(column(leaf.name.clone(), values, rest));
            return;
        }
        let Some(width) = width_of(&starts) else {
            self.found.notes.push(format!("left out: `{}` (lists of varying length)", leaf.name));
            return;
        };
        let each = |of: &[f64], at: usize| of.iter().skip(at).step_by(width).copied().collect::<Vec<f64>>();
        for at in 0..width {
            let name = format!("{}[{at}]", leaf.name);
            self.found.columns.push(column(name, each(&values, at), each(&rest, at)));
        }
    }

    /// Applies what is stated of a column; gives its unit, and whether it holds dates.
    fn stated(&mut self, pages: &mut Pages, leaf: &Leaf) -> (Option<String>, bool) {
        let field = self.fields.get(&leaf.name).cloned().unwrap_or_default();
        let meaning = leaf.meaning.as_ref().ok();
        let is_date = meaning.is_some_and(|meaning| meaning.is_date) || pages.is_date();
        if is_date || meaning.is_some_and(|meaning| meaning.is_time) {
            return (Some("s".into()), is_date);
        }
        pages.rest.resize(pages.values.len(), 0.0);
        if let Some(per_s) = field.duration_per_s {
            pages.values.iter_mut().chain(&mut pages.rest).for_each(|value| *value /= per_s);
            return (Some("s".into()), false);
        }
        let storage = meaning.map_or(Storage::Double, Meaning::storage);
        let applied = field.conventions.apply(&leaf.name, storage, &mut pages.values, &mut pages.rest);
        self.found.notes.extend(applied.notes);
        (applied.unit, applied.is_date)
    }
}

/// Elements of every list, where all have as many, and no more than can be columns.
fn width_of(starts: &[bool]) -> Option<usize> {
    let width = starts.iter().skip(1).position(|starts| *starts).map_or(starts.len(), |at| at + 1);
    let is_even = starts.iter().enumerate().all(|(at, starts)| *starts == at.is_multiple_of(width));
    ((1..=LIST_MAX).contains(&width) && starts.len().is_multiple_of(width) && is_even).then_some(width)
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

/// What Arrow keeps of the columns, by their names.
fn fields(metadata: &Value) -> BTreeMap<String, Field> {
    let mut pairs = metadata.list(5).iter();
    let schema = pairs.find(|pair| pair.text(1).as_deref() == Some("ARROW:schema"));
    schema.and_then(|pair| pair.text(2)).map(|schema| arrow_units::fields(&schema)).unwrap_or_default()
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
    if rows != Some(chunk.count()) && !leaf.is_list {
        return Err(wrong(format!("it has {} values in a group of {rows:?} rows", chunk.count())));
    }
    Ok(chunk)
}

#[cfg(test)]
mod tests;
