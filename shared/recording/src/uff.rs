//! Universal files (UFF): functions at nodes, dataset 58 in text and in binary (58b), units of
//! dataset 164.
//!
//! What analysers and modal software of every make exchange: time responses become a table or
//! channels, frequency responses and spectra a [`crate::Spectrum`], complex ones as pairs of
//! columns `NAME_real`, `NAME_imag`. A name is made of quantity, node and direction:
//! `acceleration_12z`, `accelerance_12z_3z` (response at 12 by force at 3). Functions of one kind
//! over one abscissa are a group; where several could be meant, one is chosen by name
//! ([`read_group`]). Spectra of outputs are magnitudes. Datasets of other numbers are counted and
//! left out here; [`crate::read_model`] reads geometry and shapes. Read only: CSV holds the same
//! with every digit.
//!
//! Source: University of Cincinnati SDRL, Universal File Datasets 58, 58b, 164.

use crate::error::RecordingError;
use crate::intake::Intake;
use crate::intake::join::applied;
use crate::intake::listing::ListedDataset;
use crate::uff_columns::FileUnits;
use crate::uff_dataset::{Function, read_function};
use crate::uff_groups::{UffGroup, all, named, unasked};
use crate::uff_lines::Text;
use crate::{Format, Imported, file_name, listed as listed_imported};
use std::collections::BTreeMap;
use std::path::Path;

/// The universal file format.
pub struct Uff;

impl Format for Uff {
    fn name(&self) -> &'static str {
        "uff"
    }

    fn sniff(&self, head: &[u8]) -> bool {
        let mut lines = head.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii).skip_while(|line| line.is_empty());
        let dataset = |line: &[u8]| {
            let digits = line.iter().take_while(|byte| byte.is_ascii_digit()).count();
            (1..=4).contains(&digits) && line.get(digits).is_none_or(|next| *next == b'b' || *next == b' ')
        };
        lines.next() == Some(b"-1") && lines.next().is_some_and(dataset)
    }

    fn read(&self, path: &Path, intake: &Intake) -> Result<Imported, RecordingError> {
        let (file, contents) = (file_name(path), contents_of(path)?);
        let imported = match &intake.dataset {
            Some(name) => named(&file, &contents, name)?,
            None => unasked(&file, &contents, intake.clocks_of_their_own)?,
        };
        applied(imported, intake)
    }

    fn list(&self, path: &Path, _: &Intake) -> Result<Vec<ListedDataset>, RecordingError> {
        let mut all = Vec::new();
        for group in groups(path)? {
            for mut dataset in listed_imported(group.imported)? {
                dataset.name.clone_from(&group.name);
                all.push(dataset);
            }
        }
        Ok(all)
    }

    fn write(&self, imported: &Imported, path: &Path) -> Result<(), RecordingError> {
        let what = match imported {
            Imported::Table(_) => "a table (it is read only)",
            Imported::Run(_) => "a recorded run",
            Imported::Series(_) => "channels (it is read only)",
            Imported::Segments(_) => "several recordings",
            Imported::Spectrum(_) => "a spectrum (it is read only)",
        };
        Err(RecordingError::NotWritable { file: file_name(path), format: self.name(), what })
    }
}

/// Everything that was found in a file.
#[derive(Default)]
pub(crate) struct Contents {
    pub functions: Vec<Function>,
    pub units: FileUnits,
    /// How many datasets of each number were left out.
    pub others: BTreeMap<String, usize>,
}

/// Every group of functions of a universal file, in the order in which they begin.
///
/// # Errors
/// Whatever makes a number of the file uncertain.
pub fn groups(path: &Path) -> Result<Vec<UffGroup>, RecordingError> {
    all(&file_name(path), &contents_of(path)?)
}

/// The group `name` of a universal file; the error of a name that is not there lists all.
///
/// # Errors
/// Another name, what is wrong with the file, and functions that hold no resonances.
pub fn read_group(path: &Path, name: &str) -> Result<Imported, RecordingError> {
    named(&file_name(path), &contents_of(path)?, name)
}

fn contents_of(path: &Path) -> Result<Contents, RecordingError> {
    contents(Text::new(&file_name(path), &bytes_of(path)?))
}

/// The bytes of a file.
///
/// # Errors
/// The device's.
pub(crate) fn bytes_of(path: &Path) -> Result<Vec<u8>, RecordingError> {
    std::fs::read(path).map_err(|reason| RecordingError::Io { file: file_name(path), action: "read", reason })
}

fn contents(mut text: Text<'_>) -> Result<Contents, RecordingError> {
    let mut contents = Contents::default();
    while let Some(line) = text.next_line() {
        if line.trim().is_empty() {
            continue;
        }
        let (id, number) = text.open_dataset(&line)?;
        match id.as_str() {
            "58" | "58b" => {
                contents.functions.push(read_function(&mut text, &number)?);
                text.close_dataset()?;
            }
            _ => {
                let second = text.skip_dataset()?;
                match Some(second).filter(|_| id == "164").and_then(|line| units(&line)) {
                    Some(units) => contents.units = Some(units),
                    None => *contents.others.entry(id).or_default() += 1,
                }
            }
        }
    }
    Ok(contents)
}

/// Units of length and force in the second line of dataset 164, per SI unit.
pub(crate) fn units(line: &str) -> FileUnits {
    let factors = line.replace(['D', 'd'], "E");
    let mut factors = factors.split_whitespace().map_while(|word| word.parse::<f64>().ok());
    let (length, force) = (factors.next()?, factors.next()?);
    let factor = |x: f64| x > 0.0 && x.is_finite();
    (factor(length) && factor(force)).then_some((length, force))
}

/// What datasets of other numbers there are, for a note.
pub(crate) fn listed(others: &BTreeMap<String, usize>) -> String {
    let all: Vec<String> = others.iter().map(|(number, count)| format!("{number} ({count})")).collect();
    all.join(", ")
}
