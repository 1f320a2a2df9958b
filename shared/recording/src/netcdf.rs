//! netCDF of the classic formats: CDF-1, CDF-2 and CDF-5. One of version 4 is HDF5.

use crate::arrays::{self, Array, Arrays};
use crate::bytes::{self, COPY, bad};
use crate::conventions::{Conventions, Stated, Storage};
use crate::dataset::{RawDataset, Wanted};
use crate::error::RecordingError;
use crate::file_name;
use crate::intake::origin::{if_any, split};
use crate::numbers::Number;
use netcdf_reader::classic::ClassicFile;
use netcdf_reader::{Error, NcAttrValue, NcAttribute, NcFormat, NcType, NcVariable};
use std::path::Path;

/// The wanted datasets of a file.
///
/// # Errors
/// The device's; a file that is damaged, or holds no array of two numbers or more.
pub fn datasets(path: &Path, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    datasets_of(&file_name(path), bytes::whole(path)?, wanted)
}

fn datasets_of(file: &str, content: Vec<u8>, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    // no two arrays share bytes: together they are no longer than the file
    let mut budget = content.len() as u64;
    let damaged = |place: String| move |reason: Error| bad(file, place, reason.to_string(), COPY);
    let format = match content.get(3) {
        Some(1) => NcFormat::Classic,
        Some(2) => NcFormat::Offset64,
        _ => NcFormat::Cdf5,
    };
    let opened = ClassicFile::from_vec(content, format).map_err(damaged("the structure of the file".into()))?;
    let root = opened.root_group();
    let mut arrays = Arrays::default();
    for attribute in &root.attributes {
        if let (true, Some(value)) = (arrays::is_rate_or_interval(&attribute.name), attribute.value.as_f64()) {
            let name = attribute.name.clone();
            arrays.arrays.push(Array { name, values: vec![value], ..Array::default() });
        }
    }
    for variable in &root.variables {
        let name = variable.name().to_owned();
        let Some((storage, number)) = stored(variable.dtype()) else {
            arrays.leave_out(name, "text");
            continue;
        };
        let place = || format!("array `{name}`");
        let stated = variable.shape().iter().fold(number.width() as u64, |all, length| all.saturating_mul(*length));
        budget = budget.checked_sub(stated).ok_or_else(|| {
            bad(file, place(), format!("it states {stated} bytes, more than the file has left"), COPY)
        })?;
        let (values, rest) = numbers(&opened, variable).map_err(damaged(place()))?;
        add(&mut arrays, variable, (storage, number), values, rest);
    }
    arrays.into_datasets(file, wanted)
}

/// How the elements of an array are stored; `None` of texts.
fn stored(of: &NcType) -> Option<(Storage, Number)> {
    let number = match of {
        NcType::Byte => Number::Signed(1),
        NcType::Short => Number::Signed(2),
        NcType::Int => Number::Signed(4),
        NcType::Int64 => Number::Signed(8),
        NcType::UByte => Number::Unsigned(1),
        NcType::UShort => Number::Unsigned(2),
        NcType::UInt => Number::Unsigned(4),
        NcType::UInt64 => Number::Unsigned(8),
        NcType::Float => return Some((Storage::Single, Number::Float(4))),
        NcType::Double => return Some((Storage::Double, Number::Float(8))),
        _ => return None,
    };
    Some((Storage::Whole(number.width()), number))
}

/// The elements, and what an `f64` does not hold of each.
fn numbers(file: &ClassicFile, variable: &NcVariable) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let name = variable.name();
    match variable.dtype() {
        NcType::Int64 => Ok(file.read_variable::<i64>(name)?.iter().map(|value| split(i128::from(*value))).unzip()),
        NcType::UInt64 => Ok(file.read_variable::<u64>(name)?.iter().map(|value| split(i128::from(*value))).unzip()),
        _ => {
            let values: Vec<f64> = file.read_variable_as_f64(name)?.iter().copied().collect();
            let rest = vec![0.0; values.len()];
            Ok((values, rest))
        }
    }
}

fn add(
    arrays: &mut Arrays,
    variable: &NcVariable,
    (storage, number): (Storage, Number),
    mut values: Vec<f64>,
    mut rest: Vec<f64>,
) {
    let conventions = Conventions::of(variable.attributes().iter().filter_map(stated));
    if conventions.number(number) != number {
        let wrap = (8.0 * number.width() as f64).exp2();
        values.iter_mut().filter(|value| **value < 0.0).for_each(|value| *value += wrap);
    }
    let name = variable.name().to_owned();
    let applied = conventions.apply(&name, storage, &mut values, &mut rest);
    arrays.notes.extend(applied.notes.into_iter().map(|note| (String::new(), note)));
    arrays.arrays.push(Array {
        name,
        unit: applied.unit,
        shape: variable.shape().iter().map(|length| *length as usize).collect(),
        is_time: applied.is_date,
        values,
        rest: if_any(rest),
        ..Array::default()
    });
}

fn stated(attribute: &NcAttribute) -> Option<(String, Stated)> {
    let stated = match &attribute.value {
        NcAttrValue::Chars(text) => Stated::Text(text.clone()),
        value => Stated::Numbers(value.as_f64_vec()?),
    };
    Some((attribute.name.clone(), stated))
}
