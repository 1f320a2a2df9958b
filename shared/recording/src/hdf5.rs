//! HDF5 files, and MATLAB files of version 7.3, which are HDF5.
//!
//! Arrays of one group and one length are a dataset with the name of the group, its parts joined by
//! points; a table (compound type) is a dataset of its own. The attributes of an array are those of
//! [`crate::conventions`].

use crate::array_texts::TextArray;
use crate::arrays::{self, Array, Arrays, joined};
use crate::bytes::{self, EXPANSION_MAX, bad};
use crate::conventions::{Conventions, Stated, Storage, is_unit};
use crate::dataset::{RawDataset, Wanted};
use crate::error::RecordingError;
use crate::file_name;
use crate::hdf5_types::{self as types, Field};
use crate::intake::origin::if_any;
use crate::numbers::Number;
use crate::texts::Texts;
use hdf5_reader::error::Error;
use hdf5_reader::group::Group;
use hdf5_reader::{Attribute, Dataset, Datatype, Hdf5File, OpenOptions, StringSize};
use std::path::Path;

const CURE: &str =
    "copy the file again; one that other programs open: `h5repack FILE NEW`, or `save(..., '-v7')` in MATLAB";
const HDF5_MAGIC: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Groups inside groups, and groups in all: a damaged file may hold itself.
const GROUP_DEPTH_MAX: usize = 12;
const GROUPS_MAX: usize = 4096;
/// MATLAB writes a page of text in front of the format's own first bytes.
const USER_BLOCK_BYTES: usize = 512;

/// Whether a file is HDF5, behind a page of MATLAB or not.
pub(crate) fn is_hdf5(content: &[u8]) -> bool {
    content.starts_with(HDF5_MAGIC) || content.get(USER_BLOCK_BYTES..).is_some_and(|rest| rest.starts_with(HDF5_MAGIC))
}

/// The wanted datasets of an HDF5 file.
///
/// # Errors
/// The device's; a file that is damaged, or holds no array of two numbers or more.
pub fn datasets(path: &Path, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    datasets_of(&file_name(path), bytes::whole(path)?, wanted)
}

/// The wanted datasets of the content of a file.
pub(crate) fn datasets_of(
    file: &str,
    content: Vec<u8>,
    wanted: &Wanted<'_>,
) -> Result<Vec<RawDataset>, RecordingError> {
    let file_bytes = content.len();
    let budget = file_bytes.saturating_mul(EXPANSION_MAX);
    let options = OpenOptions::default()
        .with_chunk_cache_bytes(0)
        .with_max_chunk_bytes(budget)
        .with_max_read_bytes(budget)
        .with_max_object_header_bytes(content.len());
    let damaged = |reason: Error| bad(file, "the structure of the file", reason.to_string(), CURE);
    let opened = Hdf5File::from_vec_with_options(content, options).map_err(damaged)?;
    let mut walk = Walk { file, file_bytes, budget, groups: 0, arrays: Arrays::default() };
    walk.group(&opened.root_group().map_err(damaged)?, "", GROUP_DEPTH_MAX)?;
    walk.arrays.into_datasets(file, wanted)
}

/// What was read so far.
struct Walk<'a> {
    file: &'a str,
    file_bytes: usize,
    /// Bytes that may still be read.
    budget: usize,
    groups: usize,
    arrays: Arrays,
}

/// An array as it is stored.
struct Stored<'a> {
    dataset: &'a Dataset,
    group: &'a str,
    data: Vec<u8>,
    /// Bytes of one element.
    stride: usize,
    conventions: Conventions,
    /// Attributes that are lists of texts.
    lists: Vec<(String, Vec<String>)>,
    /// MATLAB wrote it.
    is_matlab: bool,
}

impl Walk<'_> {
    fn group(&mut self, group: &Group, name: &str, depth: usize) -> Result<(), RecordingError> {
        self.groups += 1;
        if depth == 0 || self.groups > GROUPS_MAX {
            let found = format!("more than {GROUP_DEPTH_MAX} groups in groups, or more than {GROUPS_MAX}");
            return Err(bad(self.file, format!("group `{name}`"), found, CURE));
        }
        let damaged = |reason: Error| bad(self.file, format!("group `{name}`"), reason.to_string(), CURE);
        let (mut groups, mut datasets) = group.members().map_err(damaged)?;
        let attributes = group.attributes().map_err(damaged)?;
        let states_rate = |attribute: &&Attribute| {
            attribute.shape.iter().all(|length| *length == 1) && arrays::is_rate_or_interval(&attribute.name)
        };
        for scalar in attributes.iter().filter(states_rate) {
            if let Ok(value) = scalar.read_as_f64() {
                let (group, name) = (name.into(), scalar.name.clone());
                self.arrays.arrays.push(Array { group, name, values: vec![value], ..Array::default() });
            }
        }
        datasets.sort_by_key(|dataset| dataset.address());
        for dataset in &datasets {
            self.dataset(dataset, name)?;
        }
        groups.sort_by_key(Group::address);
        for group in &groups {
            let own = joined(name, group.name());
            // Where MATLAB keeps cells and objects.
            if matches!(group.name(), "#refs#" | "#subsystem#") {
                continue;
            }
            match matlab_class(&group.attributes().unwrap_or_default()).as_deref() {
                None | Some("struct") => self.group(group, &own, depth - 1)?,
                Some(class) => self.arrays.leave_out(own, types::matlab_reason(class)),
            }
        }
        Ok(())
    }

    fn dataset(&mut self, dataset: &Dataset, group: &str) -> Result<(), RecordingError> {
        let name = joined(group, dataset.name());
        let attributes = dataset.attributes();
        let class = matlab_class(&attributes);
        if attributes.iter().any(|attribute| attribute.name == "MATLAB_empty") {
            self.arrays.leave_out(name, "empty");
            return Ok(());
        }
        if let Some(class) = class.as_deref().filter(|class| !types::is_numeric(class)) {
            self.arrays.leave_out(name, types::matlab_reason(class));
            return Ok(());
        }
        if is_bare_dimension(&attributes) {
            self.arrays.leave_out(name, "a dimension without values");
            return Ok(());
        }
        let fields = match types::fields(dataset.dtype()) {
            Ok(fields) => fields,
            Err(reason) => {
                match self.texts(dataset) {
                    Some(texts) => {
                        let (group, name) = (group.to_owned(), dataset.name().to_owned());
                        self.arrays.texts.push(TextArray { group, name, texts });
                    }
                    None => self.arrays.leave_out(name, reason),
                }
                return Ok(());
            }
        };
        let data = self.bytes(dataset, &name)?;
        let conventions = Conventions::of(attributes.iter().filter_map(stated));
        let stride = dataset.raw_element_size().unwrap_or(1).max(1);
        let lists = attributes.iter().filter_map(texts_of).collect();
        let stored = Stored { dataset, group, data, stride, conventions, lists, is_matlab: class.is_some() };
        let count = fields.len();
        for (place, field) in fields.into_iter().enumerate() {
            self.field(field, (place, count), &stored);
        }
        Ok(())
    }

    /// The texts of a vector, or a text alone.
    fn texts(&mut self, dataset: &Dataset) -> Option<Texts> {
        let size = dataset.raw_byte_len().ok()?;
        self.budget = self.budget.checked_sub(size)?;
        if dataset.shape().len() > 1 || self.heap_bytes(dataset)? > self.file_bytes {
            return None;
        }
        let mut texts = Texts::default();
        dataset.read_strings().ok()?.iter().for_each(|text| texts.push(text));
        Some(texts)
    }

    /// Bytes of the texts of variable length to which an array refers: more than the file has are
    /// one text many times over.
    fn heap_bytes(&self, dataset: &Dataset) -> Option<usize> {
        let references = match dataset.dtype() {
            Datatype::VarLen { .. } | Datatype::String { size: StringSize::Variable, .. } => dataset.read_raw_bytes(),
            _ => return Some(0),
        };
        let stride = dataset.raw_element_size().ok().filter(|stride| *stride >= 4)?;
        let length = |reference: &[u8]| u32::from_le_bytes([reference[0], reference[1], reference[2], reference[3]]);
        Some(references.ok()?.chunks_exact(stride).map(|reference| length(reference) as usize).sum())
    }

    /// The numbers as they are stored.
    fn bytes(&mut self, dataset: &Dataset, name: &str) -> Result<Vec<u8>, RecordingError> {
        let damaged = |reason: Error| bad(self.file, format!("array `{name}`"), reason.to_string(), CURE);
        let size = dataset.raw_byte_len().map_err(damaged)?;
        if size > self.budget {
            let found = format!("it states {size} bytes, absurd for this file");
            return Err(bad(self.file, format!("array `{name}`"), found, CURE));
        }
        let data = dataset.read_raw_bytes().map_err(damaged)?;
        self.budget -= size;
        Ok(data)
    }

    /// Adds one field of the elements of an array, at its place among so many.
    fn field(&mut self, field: Field, (place, count): (usize, usize), stored: &Stored<'_>) {
        let Stored { dataset, group, data, stride, conventions, lists, is_matlab } = stored;
        let is_table = !field.name.is_empty();
        let own = dataset.name().to_string();
        let (group, name) =
            if field.name.is_empty() { (group.to_string(), own) } else { (joined(group, &own), field.name.clone()) };
        let Some(number) = field.number.map(|number| conventions.number(number)) else {
            self.arrays.leave_out(joined(&group, &name), "no number");
            return;
        };
        let each = field.shape.iter().product::<usize>();
        let (offset, width) = (field.offset, number.width());
        let value = |element: &[u8], place: usize| {
            let bytes = element.get(offset + place * width..).unwrap_or_default();
            (number.value(bytes, field.big_endian), number.rest(bytes, field.big_endian))
        };
        let elements = data.chunks_exact(*stride).flat_map(|element| (0..each).map(move |place| (element, place)));
        let (mut values, mut rest): (Vec<f64>, Vec<f64>) =
            elements.map(|(element, place)| value(element, place)).unzip();
        let own = conventions.of_field(
            is_table,
            lists
                .iter()
                .find(|(name, texts)| is_unit(name) && texts.len() == count)
                .and_then(|(_, texts)| texts.get(place)),
        );
        let applied = own.apply(&joined(&group, &name), storage(number), &mut values, &mut rest);
        self.arrays.notes.extend(applied.notes.into_iter().map(|note| (group.clone(), note)));
        let rest = if_any(rest);
        let mut shape: Vec<usize> = dataset.shape().iter().map(|length| *length as usize).collect();
        if *is_matlab {
            // MATLAB's first index is the last one here, and changes fastest.
            shape.reverse();
        }
        shape.extend(&field.shape);
        let (unit, column_major, is_time) = (applied.unit, *is_matlab, applied.is_date);
        self.arrays.arrays.push(Array {
            group,
            name,
            unit,
            shape,
            column_major,
            is_time,
            values,
            rest,
            lists: if is_table { Vec::new() } else { lists.clone() },
            ..Array::default()
        });
    }
}

/// An attribute that is a text or a few numbers.
fn stated(attribute: &Attribute) -> Option<(String, Stated)> {
    const NUMBERS_MAX: u64 = 16;
    if let Ok(text) = attribute.read_string() {
        return Some((attribute.name.clone(), Stated::Text(text)));
    }
    let field = match &types::fields(&attribute.datatype).ok()?[..] {
        [field] if field.shape.is_empty() => field.clone(),
        _ => return None,
    };
    let count = attribute.num_elements().ok().filter(|count| *count <= NUMBERS_MAX)? as usize;
    let number = field.number?;
    let bytes = attribute.raw_data.get(..count * number.width())?;
    Some((attribute.name.clone(), Stated::Numbers(number.values(bytes, field.big_endian))))
}

/// An attribute that is a list of texts.
fn texts_of(attribute: &Attribute) -> Option<(String, Vec<String>)> {
    let texts = attribute.read_strings().ok().filter(|texts| texts.len() > 1)?;
    Some((attribute.name.clone(), texts))
}

/// How a number is stored.
fn storage(number: Number) -> Storage {
    match number {
        Number::Float(8) => Storage::Double,
        Number::Float(_) => Storage::Single,
        Number::Signed(width) | Number::Unsigned(width) => Storage::Whole(width),
    }
}

/// Whether netCDF keeps the length of a dimension here and no values.
fn is_bare_dimension(attributes: &[Attribute]) -> bool {
    let name = attributes.iter().find(|attribute| attribute.name == "NAME");
    let text = name.and_then(|name| name.read_string().ok());
    text.is_some_and(|text| text.starts_with("This is a netCDF dimension but not a netCDF variable"))
}

fn matlab_class(attributes: &[Attribute]) -> Option<String> {
    attributes.iter().find(|attribute| attribute.name == "MATLAB_class")?.read_string().ok()
}

#[cfg(test)]
mod tests;
