//! The bytes of a binary file, read from front to back, and the place where something is wrong.

use crate::error::RecordingError;
use crate::file_name;
use std::io::Read;
use std::path::Path;

/// A compressed block may announce so many times the bytes of its file; more is taken as damage.
pub(crate) const EXPANSION_MAX: usize = 1000;

/// What to do when a file ends early or its parts disagree.
pub(crate) const COPY: &str = "copy the file again from its source, or export it again";

/// The whole file in memory.
///
/// # Errors
/// The device's; an empty file.
pub(crate) fn whole(path: &Path) -> Result<Vec<u8>, RecordingError> {
    let io = |reason| RecordingError::Io { file: file_name(path), action: "read", reason };
    let bytes = std::fs::read(path).map_err(io)?;
    if bytes.is_empty() { Err(RecordingError::Empty { file: file_name(path) }) } else { Ok(bytes) }
}

/// [`RecordingError::BadContainer`].
pub(crate) fn bad(file: &str, place: impl Into<String>, found: impl Into<String>, cure: &str) -> RecordingError {
    RecordingError::BadContainer { file: file.into(), place: place.into(), found: found.into(), cure: cure.into() }
}

/// A place in bytes.
#[derive(Clone, Debug)]
pub(crate) struct Bytes<'a> {
    file: &'a str,
    /// What the bytes belong to, where they are not the file itself; ends in a blank.
    part: &'a str,
    data: &'a [u8],
    /// Place of the front in what the bytes belong to.
    base: usize,
    at: usize,
    /// Numbers are stored with the most significant byte first.
    pub big_endian: bool,
}

impl<'a> Bytes<'a> {
    /// From the front of `data`; `part` says in errors what they are when they are not the file.
    pub fn new(file: &'a str, part: &'a str, data: &'a [u8]) -> Self {
        Self { file, part, data, base: 0, at: 0, big_endian: false }
    }

    /// Bytes from the front to this place.
    pub fn at(&self) -> usize {
        self.at
    }

    /// Bytes that were not read yet.
    pub fn left(&self) -> usize {
        self.data.len() - self.at
    }

    /// Goes to the place `at` bytes behind the front, or to the end.
    pub fn go_to(&mut self, at: usize) {
        self.at = at.min(self.data.len());
    }

    /// [`RecordingError::BadContainer`] at this place.
    pub fn error(&self, found: impl Into<String>, cure: &str) -> RecordingError {
        bad(self.file, format!("{}byte {}", self.part, self.base + self.at), found, cure)
    }

    /// The next bytes, where they are all there.
    pub fn try_take(&mut self, length: usize) -> Option<&'a [u8]> {
        let taken = self.data.get(self.at..self.at.checked_add(length)?)?;
        self.at += length;
        Some(taken)
    }

    /// The next bytes.
    ///
    /// # Errors
    /// The bytes end before.
    pub fn take(&mut self, length: usize, what: &str) -> Result<&'a [u8], RecordingError> {
        let left = self.left();
        self.try_take(length).ok_or_else(|| self.error(format!("{what} needs {length} bytes, {left} are there"), COPY))
    }

    /// The next bytes as a part of their own, with the same order of bytes.
    ///
    /// # Errors
    /// The bytes end before.
    pub fn split(&mut self, length: usize, what: &str) -> Result<Bytes<'a>, RecordingError> {
        let base = self.base + self.at;
        let data = self.take(length, what)?;
        Ok(Self { data, base, at: 0, ..self.clone() })
    }

    fn unsigned<const WIDTH: usize>(&mut self, what: &str) -> Result<u64, RecordingError> {
        let fold = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        let big_endian = self.big_endian;
        let taken = self.take(WIDTH, what)?;
        Ok(if big_endian { taken.iter().fold(0, fold) } else { taken.iter().rev().fold(0, fold) })
    }

    /// # Errors
    /// The bytes end before.
    pub fn u8(&mut self, what: &str) -> Result<u8, RecordingError> {
        Ok(self.take(1, what)?[0])
    }

    /// # Errors
    /// The bytes end before.
    pub fn u16(&mut self, what: &str) -> Result<u16, RecordingError> {
        self.unsigned::<2>(what).map(|value| value as u16)
    }

    /// # Errors
    /// The bytes end before.
    pub fn u32(&mut self, what: &str) -> Result<u32, RecordingError> {
        self.unsigned::<4>(what).map(|value| value as u32)
    }

    /// # Errors
    /// The bytes end before.
    pub fn u64(&mut self, what: &str) -> Result<u64, RecordingError> {
        self.unsigned::<8>(what)
    }
}

/// What a decompressor gives, up to `limit` bytes; a byte more is an error of kind `InvalidData`.
///
/// # Errors
/// The stream's, and too many bytes.
pub(crate) fn expanded(stream: impl Read, limit: usize) -> std::io::Result<Vec<u8>> {
    let mut out = Vec::new();
    stream.take(limit as u64 + 1).read_to_end(&mut out)?;
    if out.len() > limit {
        let reason = format!("it expands to more than the {limit} bytes that it may have");
        return Err(std::io::Error::new(std::io::ErrorKind::InvalidData, reason));
    }
    Ok(out)
}
