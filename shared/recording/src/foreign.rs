//! Recordings of other programs: MCAP files, ROS 1 bags and rosbag2 recordings.
//!
//! Every topic is a dataset. Numbers of its messages are columns, named by their path in the
//! message; time is the stamp of the header, or the time of logging. What a writer that was stopped
//! left whole is read, and a note says what is missing.

mod bag;
mod bzip2;
mod damaged;
mod input;
mod mcap;
mod rosbag2;
mod topics;
mod unpack;

use crate::dataset::{RawDataset, Wanted};
use crate::error::RecordingError;
use std::path::Path;

/// The datasets of an MCAP file of any program: one a topic, by name.
///
/// # Errors
/// [`RecordingError::BadContainer`] when nothing of the file is read; the device's.
pub fn mcap_datasets(path: &Path, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    mcap::datasets(path, wanted)
}

/// The datasets of a ROS 1 bag: one a topic, by name.
///
/// # Errors
/// [`RecordingError::BadContainer`] when nothing of the file is read; the device's.
pub fn bag_datasets(path: &Path, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    bag::datasets(path, wanted)
}

/// The datasets of a rosbag2 recording, its database or its folder: one a topic, by name.
///
/// # Errors
/// [`RecordingError::BadContainer`] when nothing of the file is read; the device's.
pub fn rosbag2_datasets(path: &Path, wanted: &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError> {
    rosbag2::datasets(path, wanted)
}

/// Whether obsid recorded the MCAP file at `path`: it says so, or its first schema does.
///
/// # Errors
/// The device's.
pub fn is_own_mcap(path: &Path) -> Result<bool, RecordingError> {
    mcap::is_own(path)
}
