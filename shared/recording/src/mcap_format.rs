//! MCAP, the one recording format: every sample with its stamps, described by ROS 1 schemas.
//!
//! A message is the bytes of [`telemetry::Stamps`] followed by those of the sample; log time = time
//! of send, publish time = time of measurement, sequence = low 32 bits of `seq`.

#[cfg(feature = "foreign")]
use crate::containers;
use crate::error::RecordingError;
#[cfg(feature = "foreign")]
use crate::foreign;
use crate::intake::Intake;
use crate::intake::join::applied;
use crate::intake::listing::ListedDataset;
use crate::mcap_recorder::McapRecorder;
use crate::mcap_series::{read_imported, write_series_mcap};
use crate::run::RecordedRun;
use crate::whole_file::replace;
use crate::{Format, Imported, file_name, listed};
use std::path::Path;

/// The MCAP format.
pub struct Mcap;

impl Format for Mcap {
    fn name(&self) -> &'static str {
        "mcap"
    }

    fn sniff(&self, head: &[u8]) -> bool {
        // A file cut within the magic is still a truncated MCAP, not an unknown file.
        !head.is_empty()
            && (head.starts_with(mcap::MAGIC) || (head.len() < mcap::MAGIC.len() && mcap::MAGIC.starts_with(head)))
    }

    fn read(&self, path: &Path, intake: &Intake) -> Result<Imported, RecordingError> {
        // what is damaged beyond recognition is worded as obsid's own
        #[cfg(feature = "foreign")]
        if !foreign::is_own_mcap(path).unwrap_or(true) {
            return containers::read(foreign::mcap_datasets, path, intake).map_err(|error| of_damage(path, error));
        }
        applied(read_imported(path)?, intake)
    }

    fn list(&self, path: &Path, intake: &Intake) -> Result<Vec<ListedDataset>, RecordingError> {
        #[cfg(feature = "foreign")]
        if !foreign::is_own_mcap(path).unwrap_or(true) {
            return containers::list(foreign::mcap_datasets, path, intake);
        }
        #[cfg(not(feature = "foreign"))]
        let _ = intake;
        listed(read_imported(path)?)
    }

    fn write(&self, imported: &Imported, path: &Path) -> Result<(), RecordingError> {
        let not_writable = |what| RecordingError::NotWritable { file: file_name(path), format: self.name(), what };
        match imported {
            Imported::Run(run) => write_mcap(run, path),
            // The notes say by how much times were rounded; who wants them calls the function.
            Imported::Series(set) => write_series_mcap(&set.recording, path).map(|_| ()),
            Imported::Table(_) => Err(not_writable("a table")),
            Imported::Segments(_) => Err(not_writable("several recordings")),
            Imported::Spectrum(_) => Err(not_writable("a spectrum")),
        }
    }
}

/// The damage of a file that is cut before it says whose it is, rather than that nothing is in it.
#[cfg(feature = "foreign")]
fn of_damage(path: &Path, error: RecordingError) -> RecordingError {
    match (error, read_imported(path)) {
        (
            RecordingError::BadContainer { .. },
            Err(damage @ (RecordingError::McapTruncated { .. } | RecordingError::McapCorrupt { .. })),
        ) => damage,
        (error, _) => error,
    }
}

/// Writes a run as a complete file.
///
/// # Errors
/// The device's.
pub fn write_mcap(run: &RecordedRun, path: &Path) -> Result<(), RecordingError> {
    replace(path, |temporary| {
        let mut recorder = McapRecorder::create(temporary)?;
        recorder.path = path.into();
        for (name, values) in run.metadata() {
            recorder.metadata(name, values)?;
        }
        for attachment in run.attachments() {
            recorder.attach(&attachment.name, &attachment.media_type, &attachment.bytes)?;
        }
        for sample in run.samples() {
            recorder.write(sample.topic, sample.stamps, sample.payload)?;
        }
        recorder.finish()
    })
}
