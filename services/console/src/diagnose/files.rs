//! `--out DIR`: the files of a diagnosis.

use super::{Diagnosed, object, page};
use crate::Failure;
use crate::recordings::ReportFile;
use discovery::diagnose::Diagnosis;
use std::path::{Path, PathBuf};

const REPORT: &str = "report.html";
const OBJECT: &str = "diagnosis.json";
const AUGMENTED: &str = "augmented.toml";
const NEXT: &str = "next_experiment.toml";

/// Where the files go.
pub struct OutFiles {
    folder: PathBuf,
    report: ReportFile,
}

impl OutFiles {
    /// Makes the folder before the work, and sees that no file which is read would be written over.
    ///
    /// # Errors
    /// [`Failure::Input`].
    pub fn new(folder: &Path, inputs: &[&Path]) -> Result<Self, Failure> {
        let report = ReportFile::new(folder, REPORT)?;
        for name in [REPORT, OBJECT, AUGMENTED, NEXT] {
            let written = folder.join(name);
            let same =
                |input: &&&Path| matches!((input.canonicalize(), written.canonicalize()), (Ok(a), Ok(b)) if a == b);
            if let Some(input) = inputs.iter().find(same) {
                return Err(Failure::Input(miette::miette!(
                    help = "give --out another folder: a diagnosis does not write over what it was made of",
                    "--out {}: it would write over {}",
                    folder.display(),
                    input.display()
                )));
            }
        }
        Ok(OutFiles { folder: folder.to_owned(), report })
    }

    /// Writes the files and puts their paths into the diagnosis; what this diagnosis has not goes,
    /// if an earlier one left it.
    ///
    /// # Errors
    /// [`Failure::Run`] when the file system denies it.
    pub fn write(&self, diagnosed: &mut Diagnosed) -> Result<(), Failure> {
        let augmented = diagnosed.diagnosis.augmented_plant.take();
        let next = diagnosed.diagnosis.next_experiment.take();
        diagnosed.diagnosis.augmented_plant = self.text(AUGMENTED, augmented.as_deref())?;
        diagnosed.diagnosis.next_experiment = self.text(NEXT, next.as_deref())?;
        diagnosed.diagnosis.report = Some(self.report.path());
        let texts = page::Texts { augmented: augmented.as_deref(), next: next.as_deref() };
        let page = page::page(diagnosed, &texts);
        self.text(OBJECT, Some(&format!("{}\n", object::object(diagnosed))))?;
        self.report.write(&page)
    }

    fn text(&self, name: &str, text: Option<&str>) -> Result<Option<String>, Failure> {
        let path = self.folder.join(name);
        let done = match text {
            Some(text) => std::fs::write(&path, text),
            None if path.is_file() => std::fs::remove_file(&path),
            None => Ok(()),
        };
        done.map_err(|error| Failure::Run(format!("{}: {error}", path.display())))?;
        Ok(text.map(|_| path.display().to_string()))
    }
}

/// Without a folder nothing is written: no paths.
pub fn without_files(diagnosis: &mut Diagnosis) {
    (diagnosis.augmented_plant, diagnosis.next_experiment, diagnosis.report) = (None, None, None);
}
