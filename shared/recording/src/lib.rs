//! Recordings: what comes from files and goes to files. One file per format, one list: [`FORMATS`].
//!
//! What it is: [`read`] finds the format by content and gives an [`Imported`]; [`series`] turns
//! every time record into named channels, [`ReplayFrames`] cuts what has one rate into the frames a
//! source sends, [`write_series`] writes channels. What is wrong with a file is an error that names
//! file, place, value and cure; what was repaired is counted and reported; nothing is filled or
//! guessed.
//!
//! May import: `channels`, `telemetry`, file and format crates. Must never know: links, clocks,
//! partitions, equations.
//!
//! ```
//! use channels::{Channel, Recording};
//!
//! let (time_s, value) = (0..100).map(|k| (f64::from(k) / 50.0, 0.1 * f64::from(k))).unzip();
//! let angle = Channel::new("angle", "rad", time_s, value);
//! let written = Recording { name: "swing".into(), channels: vec![angle] };
//! let path = std::env::temp_dir().join(format!("obsid-swing-{}.csv.gz", std::process::id()));
//! recording::write_series(&written, &path)?;
//! let read = recording::series(recording::read(&path)?)?;
//! assert_eq!(read.recording.channels, written.channels);
//! # std::fs::remove_file(&path).unwrap();
//! # Ok::<(), recording::RecordingError>(())
//! ```
//!
//! Why not JSON schemas in the MCAP? A sample is its own ROS 1 serialisation byte for byte, so the
//! recorder copies memory and every viewer that reads ROS 1 decodes it.
//!
//! Feature `foreign` (default): readers of files that other programs write. Partitions that fly are
//! built without, and link neither SQLite nor HDF5.
#![forbid(unsafe_code)]
// what only readers of the feature call is then not called
#![cfg_attr(not(feature = "foreign"), allow(dead_code))]

#[cfg(feature = "foreign")]
mod array_names;
#[cfg(feature = "foreign")]
mod array_parts;
#[cfg(feature = "foreign")]
mod array_texts;
#[cfg(feature = "foreign")]
mod arrays;
#[cfg(feature = "foreign")]
mod arrow_units;
mod bytes;
mod canonical;
#[cfg(feature = "foreign")]
mod containers;
#[cfg(feature = "foreign")]
mod conventions;
mod conversions;
pub mod csv;
#[cfg(test)]
mod damage;
mod dataset;
mod digest;
mod error;
mod excitation;
#[cfg(feature = "foreign")]
pub mod foreign;
mod function_kind;
#[cfg(feature = "foreign")]
mod hdf5;
#[cfg(feature = "foreign")]
mod hdf5_types;
pub mod intake;
mod map;
#[cfg(feature = "foreign")]
mod matlab;
#[cfg(feature = "foreign")]
mod matlab_elements;
#[cfg(feature = "foreign")]
mod matlab_values;
mod mcap_channels;
mod mcap_chunk;
mod mcap_format;
mod mcap_read;
mod mcap_recorder;
mod mcap_records;
mod mcap_series;
mod mcap_summary;
#[cfg(feature = "foreign")]
mod messages;
#[cfg(feature = "foreign")]
mod netcdf;
#[cfg(feature = "foreign")]
mod npy;
#[cfg(feature = "foreign")]
mod npz;
mod numbers;
#[cfg(feature = "foreign")]
mod parquet;
#[cfg(feature = "foreign")]
mod parquet_encodings;
#[cfg(feature = "foreign")]
mod parquet_pages;
#[cfg(feature = "foreign")]
mod parquet_schema;
#[cfg(feature = "foreign")]
mod parquet_thrift;
#[cfg(feature = "foreign")]
mod parquet_unpack;
#[cfg(feature = "foreign")]
mod python_literal;
mod recognised;
mod replay;
mod replay_run;
mod rows;
mod run;
mod run_series;
mod schema;
mod series;
mod since;
mod spectrum;
mod table;
mod text;
#[cfg(feature = "foreign")]
mod texts;
pub mod timing;
mod uff;
mod uff_columns;
mod uff_dataset;
mod uff_groups;
mod uff_kind;
mod uff_lines;
mod uff_model;
mod uff_nodes;
mod uff_numbers;
mod uff_shapes;
mod uff_write;
#[cfg(feature = "foreign")]
mod ulog;
#[cfg(feature = "foreign")]
mod ulog_formats;
#[cfg(feature = "foreign")]
mod ulog_messages;
#[cfg(feature = "foreign")]
mod ulog_units;
pub mod units;
mod whole_file;
#[cfg(feature = "foreign")]
mod zip;

pub use canonical::{CHANNELS, ChannelInfo, Channels, Domains};
pub use conversions::{segments, series};
pub use dataset::{Axis, RawColumn, RawDataset, Wanted};
pub use digest::{Digest, DigestBuilder, digest};
pub use error::{MapPlace, Place, RecordingError};
pub use function_kind::FunctionKind;
pub use intake::{Assignment, Intake, ListedChannel, ListedDataset, TimeColumn};
pub use map::ChannelMap;
pub use mcap_format::write_mcap;
pub use mcap_recorder::{McapRecorder, Recovered};
pub use mcap_series::write_series_mcap;
pub use replay::{ReplayFrames, ReplaySample};
pub use run::{Attachment, RecordedRun, RecordedSample, read_mcap, read_mcap_topics};
pub use series::{Restart, Segments, SeriesSet, check};
pub use spectrum::Spectrum;
pub use table::{Column, Table};
pub use timing::{Gap, Timing};
pub use uff::{groups, read_group};
pub use uff_groups::UffGroup;
pub use uff_model::{Node, NodeShape, TraceLine, UffHeader, UffMode, UffModel, read_model};
pub use uff_write::write_model;

use channels::Recording;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// A recording in memory.
#[derive(Debug)]
pub enum Imported {
    /// Columns over one time axis of one rate.
    Table(Table),
    /// Samples of an obsid run.
    Run(RecordedRun),
    /// Channels with sample times of their own.
    Series(SeriesSet),
    /// Several recordings one after another.
    Segments(Segments),
    /// Columns over frequency.
    Spectrum(Spectrum),
}

impl Imported {
    /// Where a repair or a doubt about the whole file is noted; the samples of a run carry theirs.
    pub(crate) fn notes_mut(&mut self) -> &mut Vec<String> {
        match self {
            Imported::Table(table) => &mut table.notes,
            Imported::Series(set) => &mut set.notes,
            Imported::Segments(segments) => &mut segments.parts.last_mut().expect("a file has a recording").notes,
            Imported::Spectrum(spectrum) => &mut spectrum.notes,
            Imported::Run(_) => unreachable!("a run is not read from text"),
        }
    }
}

/// A file format.
pub trait Format: Sync {
    /// Also its extension.
    fn name(&self) -> &'static str;
    /// Whether a file that begins with `head` is of this format.
    fn sniff(&self, head: &[u8]) -> bool;
    /// The datasets of a file: one, as it is read, for a format that does not say more.
    ///
    /// # Errors
    /// As [`Format::read`].
    fn list(&self, path: &Path, intake: &Intake) -> Result<Vec<ListedDataset>, RecordingError> {
        listed(self.read(path, intake)?)
    }
    /// Reads a file, with what is said beside it.
    ///
    /// # Errors
    /// Whatever makes a number of the file uncertain.
    fn read(&self, path: &Path, intake: &Intake) -> Result<Imported, RecordingError>;
    /// # Errors
    /// The device's, and [`RecordingError::NotWritable`] for what the format cannot hold.
    fn write(&self, imported: &Imported, path: &Path) -> Result<(), RecordingError>;
}

/// All formats, the more certain sniffers first.
pub static FORMATS: &[&dyn Format] = &[
    &mcap_format::Mcap,
    #[cfg(feature = "foreign")]
    &containers::ULOG,
    #[cfg(feature = "foreign")]
    &containers::ROS_BAG,
    #[cfg(feature = "foreign")]
    &containers::ROSBAG_2,
    #[cfg(feature = "foreign")]
    &containers::MATLAB,
    #[cfg(feature = "foreign")]
    &containers::HDF5,
    #[cfg(feature = "foreign")]
    &containers::NETCDF,
    #[cfg(feature = "foreign")]
    &containers::NPZ,
    #[cfg(feature = "foreign")]
    &containers::NPY,
    #[cfg(feature = "foreign")]
    &containers::PARQUET,
    #[cfg(feature = "foreign")]
    &containers::JSON,
    &uff::Uff,
    &csv::Csv,
];

/// Reads a recording of any format in [`FORMATS`]; the content decides, not the extension.
///
/// # Errors
/// The format's, or [`RecordingError::UnknownFormat`].
pub fn read(path: &Path) -> Result<Imported, RecordingError> {
    read_with(path, &Intake::default())
}

/// As [`read`], with what is said beside the file.
///
/// # Errors
/// As [`read`], and those of what is said: a column, a channel, a dataset that is not there.
pub fn read_with(path: &Path, intake: &Intake) -> Result<Imported, RecordingError> {
    format_of(path)?.read(path, intake)
}

/// Name of the format of a file.
///
/// # Errors
/// What is no file, an empty one, and [`RecordingError::UnknownFormat`].
pub fn format_name(path: &Path) -> Result<&'static str, RecordingError> {
    format_of(path).map(|format| format.name())
}

/// The datasets of a file with their channels.
///
/// # Errors
/// As [`read`], but for what a choice would cure.
pub fn list(path: &Path, intake: &Intake) -> Result<Vec<ListedDataset>, RecordingError> {
    format_of(path)?.list(path, intake)
}

/// A folder with a part of a rosbag2.
#[cfg(feature = "foreign")]
fn holds_a_bag(folder: &Path) -> bool {
    let is_part = |entry: std::fs::DirEntry| entry.path().extension().is_some_and(|end| end == "db3" || end == "mcap");
    std::fs::read_dir(folder).into_iter().flatten().flatten().any(is_part)
}

/// A recording as a listing.
pub(crate) fn listed(imported: Imported) -> Result<Vec<ListedDataset>, RecordingError> {
    match imported {
        Imported::Spectrum(spectrum) => Ok(vec![ListedDataset::of_spectrum("", &spectrum)]),
        imported => {
            let parts = segments(imported)?;
            let name = |k: usize| if parts.len() > 1 { format!("part {}", k + 1) } else { String::new() };
            Ok(parts.iter().enumerate().map(|(k, set)| ListedDataset::of_series(&name(k), set)).collect())
        }
    }
}

/// Formats that are read, for the error of a file of another.
#[cfg(feature = "foreign")]
const READ: &str =
    "give CSV or its kin, a universal file (UFF 58), MCAP, a ROS bag, ULog, MATLAB, HDF5, netCDF, NPZ, Parquet or JSON";
/// What to give to a program that was built without the readers of other programs' files.
#[cfg(not(feature = "foreign"))]
const READ: &str = "this partition reads CSV, UFF and obsid's own MCAP; `obsid replay` without --images reads more";

fn format_of(path: &Path) -> Result<&'static dyn Format, RecordingError> {
    let io = |action| move |source| RecordingError::Io { file: file_name(path), action, reason: source };
    let regular = std::fs::metadata(path).map_err(io("open"))?;
    let unknown =
        |found: String, cure: &str| RecordingError::UnknownFormat { file: file_name(path), found, cure: cure.into() };
    #[cfg(feature = "foreign")]
    if regular.is_dir() && holds_a_bag(path) {
        return Ok(&containers::ROSBAG_2);
    }
    if !regular.is_file() {
        let what = if regular.is_dir() { "a folder" } else { "a pipe or a device" };
        return Err(unknown(format!("this is {what}, not a file"), "give the path of a recording"));
    }
    let mut head = Vec::new();
    File::open(path).map_err(io("open"))?.take(512).read_to_end(&mut head).map_err(io("read"))?;
    if head.is_empty() {
        return Err(RecordingError::Empty { file: file_name(path) });
    }
    if let Some((found, cure)) = recognised::recognised(&head) {
        return Err(unknown(format!("this is {found}"), cure));
    }
    FORMATS.iter().find(|format| format.sniff(&head)).copied().ok_or_else(|| {
        let first = &head[..head.len().min(8)];
        unknown(format!("not a known format, the first bytes are {first:02x?}"), READ)
    })
}

/// Writes channels in the format that the name of the file asks for: `.mcap`, `.csv` or `.csv.gz`.
/// The file is there whole or not at all, and holds the channels and nothing on how they were made.
/// Gives notes on what the format rounded.
///
/// # Errors
/// Another name, what the format cannot hold ([`check`]), the device's.
pub fn write_series(recording: &Recording, path: &Path) -> Result<Vec<String>, RecordingError> {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    if name.ends_with(".mcap") {
        write_series_mcap(recording, path)
    } else if name.ends_with(".csv") || name.ends_with(".csv.gz") {
        csv::write_series_csv(recording, path).map(|()| Vec::new())
    } else {
        Err(RecordingError::UnknownFormat {
            file: file_name(path),
            found: "the name says no format that is written".into(),
            cure: "end it in .mcap, .csv or .csv.gz".into(),
        })
    }
}

/// A file's name for messages: the path as it was given.
pub(crate) fn file_name(path: &Path) -> String {
    path.display().to_string()
}
