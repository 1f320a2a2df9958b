//! Files of other programs that hold datasets: logs of flight controllers and robots, arrays,
//! tables.
//!
//! Each format gives its datasets as they were written; what they mean is decided for all of them
//! in [`crate::intake`].

use crate::dataset::{RawDataset, Wanted};
use crate::error::RecordingError;
use crate::intake::join::{is_called, no_such_dataset, recording_of};
use crate::intake::{Intake, ListedDataset};
use crate::messages::json_file;
use crate::{Format, Imported, file_name, foreign, hdf5, matlab, netcdf, npz, parquet, ulog};
use std::path::Path;

/// Reads the datasets of a file.
pub(crate) type Datasets = fn(&Path, &Wanted<'_>) -> Result<Vec<RawDataset>, RecordingError>;

/// A format that is read and not written.
pub struct Container {
    /// Also its extension.
    name: &'static str,
    begins: Begins,
    datasets: Datasets,
}

/// How the first bytes of a file tell its format.
enum Begins {
    /// They are one of these.
    With(&'static [&'static [u8]]),
    As(fn(&[u8]) -> bool),
}

/// PX4 ULog.
pub static ULOG: Container = Container { name: "ulg", begins: Begins::With(&[b"ULog"]), datasets: ulog::datasets };
/// ROS 1 bag.
pub static ROS_BAG: Container =
    Container { name: "bag", begins: Begins::With(&[b"#ROSBAG"]), datasets: foreign::bag_datasets };
/// Database of a rosbag2, or the folder that holds it.
pub static ROSBAG_2: Container =
    Container { name: "db3", begins: Begins::With(&[b"SQLite format 3"]), datasets: foreign::rosbag2_datasets };
/// MATLAB of the versions 4 to 7.3.
pub static MATLAB: Container =
    Container { name: "mat", begins: Begins::As(matlab::is_matlab), datasets: matlab::datasets };
/// netCDF of the classic formats.
pub static NETCDF: Container =
    Container { name: "nc", begins: Begins::With(&[b"CDF\x01", b"CDF\x02", b"CDF\x05"]), datasets: netcdf::datasets };
/// HDF5.
pub static HDF5: Container = Container { name: "h5", begins: Begins::With(&[b"\x89HDF"]), datasets: hdf5::datasets };
/// Arrays of NumPy in an archive.
pub static NPZ: Container = Container { name: "npz", begins: Begins::With(&[b"PK\x03\x04"]), datasets: npz::datasets };
/// An array of NumPy.
pub static NPY: Container = Container { name: "npy", begins: Begins::With(&[b"\x93NUMPY"]), datasets: npz::datasets };
/// Parquet.
pub static PARQUET: Container =
    Container { name: "parquet", begins: Begins::With(&[b"PAR1"]), datasets: parquet::datasets };

/// JSON.
pub static JSON: Container =
    Container { name: "json", begins: Begins::As(json_file::is_json), datasets: json_file::datasets };

impl Format for Container {
    fn name(&self) -> &'static str {
        self.name
    }

    fn sniff(&self, head: &[u8]) -> bool {
        match self.begins {
            Begins::With(magic) => magic.iter().any(|magic| head.starts_with(magic)),
            Begins::As(is_own) => is_own(head),
        }
    }

    fn read(&self, path: &Path, intake: &Intake) -> Result<Imported, RecordingError> {
        read(self.datasets, path, intake)
    }

    fn list(&self, path: &Path, intake: &Intake) -> Result<Vec<ListedDataset>, RecordingError> {
        list(self.datasets, path, intake)
    }

    fn write(&self, _: &Imported, path: &Path) -> Result<(), RecordingError> {
        let what = "anything (it is read only)";
        Err(RecordingError::NotWritable { file: file_name(path), format: self.name, what })
    }
}

/// The recording that a file's datasets are.
pub(crate) fn read(datasets: Datasets, path: &Path, intake: &Intake) -> Result<Imported, RecordingError> {
    recording_of(&file_name(path), chosen(datasets, path, intake)?, intake)
}

/// A file's datasets with their channels.
pub(crate) fn list(datasets: Datasets, path: &Path, intake: &Intake) -> Result<Vec<ListedDataset>, RecordingError> {
    let file = file_name(path);
    let all = chosen(datasets, path, intake)?;
    Ok(all.iter().map(|dataset| ListedDataset::of_raw(&file, dataset, intake)).collect())
}

/// The datasets that are meant; the error of a name that is not there lists all.
fn chosen(datasets: Datasets, path: &Path, intake: &Intake) -> Result<Vec<RawDataset>, RecordingError> {
    let Some(wanted) = &intake.dataset else { return datasets(path, &|_| true) };
    match datasets(path, &|name| is_called(name, wanted)) {
        Ok(found) if found.iter().any(|dataset| is_called(&dataset.name, wanted)) => Ok(found),
        _ => {
            let names: Vec<String> = datasets(path, &|_| true)?.into_iter().map(|dataset| dataset.name).collect();
            Err(no_such_dataset(&file_name(path), wanted, &names))
        }
    }
}
