//! A recording over frequency: what an analyser exports when the time record is gone.

use crate::error::{Place, RecordingError};
use crate::table::Column;

/// An imported spectrum: columns over one frequency axis, as the file names them
/// (`accelerance_real [m/s^2/N]`, …).
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Name of the file, for messages.
    pub file: String,
    /// Frequencies of the lines \[Hz\], from 0, strictly increasing.
    pub frequency_hz: Vec<f64>,
    pub columns: Vec<Column>,
    /// Repairs and doubts, for the reader of a report.
    pub notes: Vec<String>,
}

impl Spectrum {
    /// Place of the column of exactly this name.
    #[must_use]
    pub fn column_named(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }

    /// The error where a time record is needed.
    pub(crate) fn refusal(file: &str) -> RecordingError {
        let place = Place { file: file.into(), line: 1, column: 1, name: "frequency [Hz]".into() };
        let cure = "this is a spectrum, not a time record: nothing can be replayed from it; give the recording it was computed from";
        RecordingError::NoTimeColumn { place: Box::new(place), cure: cure.into() }
    }
}
