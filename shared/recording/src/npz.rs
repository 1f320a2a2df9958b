//! NumPy files: one array (`.npy`), or a zip archive of arrays with names (`.npz`).
//!
//! Arrays of one length are a dataset, a structured array is one of its own. Dates are seconds
//! since 1970, to the 0.2 us that `f64` resolves there.

use crate::arrays::Arrays;
use crate::bytes::{self, Bytes};
use crate::dataset::{RawDataset, Wanted};
use crate::error::RecordingError;
use crate::{file_name, npy, recognised, zip};
use std::path::Path;

/// The wanted datasets of a `.npy` or `.npz` file.
///
/// # Errors
/// The device's; a file that is damaged, or holds no array of two numbers or more.
pub fn datasets(path: &Path, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    let content = bytes::whole(path)?;
    datasets_of(&file_name(path), &content, wanted)
}

fn datasets_of(file: &str, content: &[u8], wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    let mut arrays = Arrays::default();
    if content.starts_with(npy::NPY_MAGIC) {
        npy::read(Bytes::new(file, "", content), "", &mut arrays)?;
        // An array alone has no name, and a column needs one.
        for array in arrays.arrays.iter_mut().filter(|array| array.name.is_empty()) {
            array.name = "array".into();
        }
        return arrays.into_datasets(file, wanted);
    }
    let mut budget = content.len().saturating_mul(bytes::EXPANSION_MAX);
    let entries = zip::entries(file, content)?;
    if !entries.iter().any(|entry| entry.name.ends_with(".npy")) {
        let names: Vec<&str> = entries.iter().map(|entry| entry.name.as_str()).collect();
        let (found, cure) = recognised::archive(&names);
        return Err(RecordingError::UnknownFormat { file: file.into(), found, cure });
    }
    for entry in entries {
        let Some(name) = entry.name.strip_suffix(".npy") else {
            arrays.leave_out(entry.name, "no NumPy array");
            continue;
        };
        let data = entry.read(file, content, &mut budget)?;
        let part = format!("`{}`, ", entry.name);
        npy::read(Bytes::new(file, &part, &data), name, &mut arrays)?;
    }
    arrays.into_datasets(file, wanted)
}

#[cfg(test)]
mod tests;
