//! Markers of one life of a partition: frames, sends, waits, checkpoints, modes.
//!
//! A marker is four words in memory that was taken at the start; the file is written before the
//! partition sleeps, so that a kill loses what happened since then and no more. Without `--trace`
//! there is no [`Trace`], and a marker costs a comparison.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use telemetry::PartitionId;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Markers until the file is written although nobody sleeps: 160 kB.
const MARKERS_MAX: usize = 4096;

/// What a marker marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Mark {
    /// `argument`: epoch.
    Start = 0,
    /// `argument`: frame.
    Frame = 1,
    /// `argument`: topic.
    Send = 2,
    /// Asleep until somebody wakes it.
    Wait = 3,
    /// `argument`: frames done.
    Checkpoint = 4,
    /// `argument`: code of `ModeState`.
    Mode = 5,
}

impl Mark {
    /// The mark with this number; `None` for a file of another build.
    #[must_use]
    pub fn of_code(code: u64) -> Option<Self> {
        [Mark::Start, Mark::Frame, Mark::Send, Mark::Wait, Mark::Checkpoint, Mark::Mode]
            .into_iter()
            .find(|mark| *mark as u64 == code)
    }
}

/// One marker as the file holds it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C)]
pub struct Marker {
    /// Begin (`CLOCK_MONOTONIC`) \[ns\].
    pub begin_ns: u64,
    /// Length \[ns\]; 0 of a moment.
    pub length_ns: u64,
    /// Code of [`Mark`].
    pub mark: u64,
    /// See [`Mark`].
    pub argument: u64,
}

/// Where in `folder` life `epoch` of `partition` leaves its markers.
#[must_use]
pub fn path(folder: &Path, partition: PartitionId, epoch: u32) -> PathBuf {
    folder.join(format!("{partition}.{epoch}.trace"))
}

/// Markers on their way to a file.
pub struct Trace {
    file: File,
    markers: Vec<Marker>,
}

impl Trace {
    /// A new file.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn create(path: &Path) -> std::io::Result<Self> {
        Ok(Trace { file: File::create(path)?, markers: Vec::with_capacity(MARKERS_MAX) })
    }

    /// Notes one marker.
    pub fn mark(&mut self, mark: Mark, argument: u64, begin_ns: u64, end_ns: u64) {
        if self.markers.len() == MARKERS_MAX {
            self.flush();
        }
        let length_ns = end_ns.saturating_sub(begin_ns);
        self.markers.push(Marker { begin_ns, length_ns, mark: mark as u64, argument });
    }

    /// Writes what is noted. A trace that cannot be written is no reason to end a flight.
    pub fn flush(&mut self) {
        let _ = self.file.write_all(self.markers.as_bytes());
        self.markers.clear();
    }
}

/// The markers in the file `path`; half a marker at its end is dropped.
///
/// # Errors
/// When it cannot be read.
pub fn read(path: &Path) -> std::io::Result<Vec<Marker>> {
    let bytes = std::fs::read(path)?;
    let whole = bytes.chunks_exact(size_of::<Marker>());
    Ok(whole.filter_map(|bytes| Marker::read_from_bytes(bytes).ok()).collect())
}

#[cfg(test)]
mod tests {
    use super::{MARKERS_MAX, Mark, Trace, read};

    #[test]
    fn every_marker_comes_back_in_order_however_many_and_half_a_marker_is_dropped() {
        let path = std::env::temp_dir().join(format!("obsid-trace-{}", std::process::id()));
        let mut trace = Trace::create(&path).unwrap();
        let count = MARKERS_MAX as u64 + 10;
        (0..count).for_each(|k| trace.mark(Mark::Frame, k, 10 * k, 10 * k + 3));
        trace.flush();
        let mut bytes = std::fs::read(&path).unwrap();
        bytes.pop();
        std::fs::write(&path, bytes).unwrap();
        let found = read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(found.len() as u64, count - 1);
        assert!(found.iter().zip(0..).all(|(marker, k)| (marker.argument, marker.length_ns) == (k, 3)));
        assert_eq!(Mark::of_code(found[0].mark), Some(Mark::Frame));
        assert_eq!(Mark::of_code(99), None);
    }
}
