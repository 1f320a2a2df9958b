//! MATLAB files of the versions 4 to 7.3.
//!
//! Vectors of one length are a dataset, a structure is one of its own, `s.inner` for one inside
//! another and `s[0]`, `s[1]` for an array of them. What is no array of numbers is named in a note.
//! Version 7.3 is HDF5.

use crate::arrays::Arrays;
use crate::bytes::{self, Bytes};
use crate::dataset::{RawDataset, Wanted};
use crate::error::RecordingError;
use crate::matlab_elements::{self as elements, Element};
use crate::matlab_values as values;
use crate::{file_name, hdf5};
use std::path::Path;

/// Bytes of text, of an offset, of the version and of the mark of the order of bytes.
const MATLAB_HEADER_BYTES: usize = 128;
const CURE: &str = "save it again in MATLAB: `save('NAME.mat', ..., '-v7')`";

/// Whether a file begins as MATLAB writes it.
pub fn is_matlab(head: &[u8]) -> bool {
    head.starts_with(b"MATLAB") || level4::is_level4(head)
}

/// The wanted datasets of a MATLAB file.
///
/// # Errors
/// The device's; a file that is damaged, or holds no array of two numbers or more.
pub fn datasets(path: &Path, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    let content = bytes::whole(path)?;
    let file = file_name(path);
    if hdf5::is_hdf5(&content) {
        return hdf5::datasets_of(&file, content, wanted);
    }
    datasets_of(&file, &content, wanted)
}

fn datasets_of(file: &str, content: &[u8], wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    let mut bytes = Bytes::new(file, "", content);
    if level4::is_level4(content) {
        return level4::arrays(file, content)?.into_datasets(file, wanted);
    }
    bytes.take(MATLAB_HEADER_BYTES - 4, "the header")?;
    let version = bytes.take(2, "the header")?;
    let order = bytes.take(2, "the header")?;
    bytes.big_endian = match order {
        b"IM" => false,
        b"MI" => true,
        _ => return Err(bytes.error(format!("the mark of the order of bytes is {order:02x?}"), CURE)),
    };
    if version != if bytes.big_endian { [1, 0] } else { [0, 1] } {
        return Err(bytes.error(format!("version {version:02x?} of the format is not read"), CURE));
    }
    let mut arrays = Arrays::default();
    let mut budget = content.len().saturating_mul(bytes::EXPANSION_MAX);
    while bytes.left() > 0 {
        let element = elements::next(&mut bytes)?;
        match element.kind {
            elements::COMPRESSED => compressed(file, element, &mut budget, &mut arrays)?,
            elements::MATRIX => values::read(element.data, &mut arrays)?,
            other => {
                return Err(bytes.error(format!("an element of type {other} stands where a variable is due"), CURE));
            }
        }
    }
    arrays.into_datasets(file, wanted)
}

/// A variable in a zlib stream.
fn compressed(file: &str, element: Element<'_>, budget: &mut usize, arrays: &mut Arrays) -> Result<(), RecordingError> {
    let part = format!("variable at byte {}, expanded, ", element.at);
    let big_endian = element.data.big_endian;
    let data = elements::inflated(element, budget)?;
    let mut bytes = Bytes::new(file, &part, &data);
    bytes.big_endian = big_endian;
    let inner = elements::next(&mut bytes)?;
    if inner.kind != elements::MATRIX {
        return Err(bytes.error(format!("an element of type {} stands where a variable is due", inner.kind), CURE));
    }
    values::read(inner.data, arrays)
}

pub(crate) mod level4;
#[cfg(test)]
mod tests;
