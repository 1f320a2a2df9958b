//! A file read from front to back: no length in it is believed beyond the file's own.

use crate::error::RecordingError;
use crate::file_name;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// The file and where it is read.
pub(super) struct Input<'p> {
    path: &'p Path,
    reader: BufReader<File>,
    pub offset: u64,
    pub size: u64,
}

impl<'p> Input<'p> {
    /// # Errors
    /// The device's.
    pub fn open(path: &'p Path) -> Result<Self, RecordingError> {
        let io = |action| move |source| RecordingError::Io { file: file_name(path), action, reason: source };
        let file = File::open(path).map_err(io("open"))?;
        let size = file.metadata().map_err(io("read"))?.len();
        Ok(Input { path, reader: BufReader::with_capacity(1 << 16, file), offset: 0, size })
    }

    /// Bytes behind the current place.
    pub fn left(&self) -> u64 {
        self.size.saturating_sub(self.offset)
    }

    /// The next `length` bytes; `None` when the file has fewer.
    ///
    /// # Errors
    /// The device's.
    pub fn take(&mut self, length: u64) -> Result<Option<Vec<u8>>, RecordingError> {
        let Some(length) = usize::try_from(length).ok().filter(|_| length <= self.left()) else { return Ok(None) };
        let mut bytes = vec![0; length];
        self.reader.read_exact(&mut bytes).map_err(|source| self.io(source))?;
        self.offset += length as u64;
        Ok(Some(bytes))
    }

    fn io(&self, source: std::io::Error) -> RecordingError {
        RecordingError::Io { file: file_name(self.path), action: "read", reason: source }
    }
}
