//! Lines of a text file, plain or gzipped, with the numbers they stand under.

use crate::error::RecordingError;
use std::collections::VecDeque;
use std::io::{BufRead, ErrorKind, Read};

/// Longest line [bytes]: 400 000 cells, and a bound on what a file without line feeds can take.
const LINE_MAX: u64 = 8 << 20;
/// Lines and bytes that are looked at before the first row is taken.
const AHEAD_LINES: usize = 400;
const AHEAD_BYTES: usize = 1 << 20;

/// Lines of a source. A quoted cell ends with its line, as every cell of this format does.
pub(crate) struct Lines<R> {
    source: R,
    pub gzipped: bool,
    /// Looked at and not yet taken.
    ahead: VecDeque<(u64, Vec<u8>)>,
    /// Lines read from the source.
    read: u64,
    /// The line that was taken last, without its end.
    pub text: Vec<u8>,
    /// Its number, from 1.
    pub line: u64,
}

impl<R: BufRead> Lines<R> {
    /// Lines of `source`, the first counted as 1; `gzipped` words the errors of a damaged archive.
    pub fn new(source: R, gzipped: bool) -> Self {
        Lines { source, gzipped, ahead: VecDeque::new(), read: 0, text: Vec::new(), line: 0 }
    }

    /// Goes to the next line that is not blank; `false` at the end.
    pub fn next(&mut self, file: &str, rows: usize) -> Result<bool, RecordingError> {
        if let Some((line, text)) = self.ahead.pop_front() {
            (self.line, self.text) = (line, text);
            return Ok(true);
        }
        self.line = self.read;
        let more = self.load(file, rows)?;
        self.line = self.read;
        Ok(more)
    }

    /// The lines that come next, which stay to be taken.
    pub fn look_ahead(&mut self, file: &str) -> Result<&VecDeque<(u64, Vec<u8>)>, RecordingError> {
        let mut bytes = 0;
        while self.ahead.len() < AHEAD_LINES && bytes < AHEAD_BYTES && self.load(file, 0)? {
            bytes += self.text.len();
            self.ahead.push_back((self.read, core::mem::take(&mut self.text)));
        }
        Ok(&self.ahead)
    }

    fn load(&mut self, file: &str, rows: usize) -> Result<bool, RecordingError> {
        loop {
            self.text.clear();
            let taken = (&mut self.source).take(LINE_MAX).read_until(b'\n', &mut self.text);
            let taken = taken.map_err(|error| self.read_error(file, rows, error))?;
            if taken == 0 {
                return Ok(false);
            }
            self.read += 1;
            if taken as u64 == LINE_MAX {
                return Err(RecordingError::UnknownFormat {
                    file: file.into(),
                    found: format!("line {} is longer than {} MiB", self.read, LINE_MAX >> 20),
                    cure: "a text recording has a line per time; export it again".into(),
                });
            }
            while self.text.last().is_some_and(|byte| matches!(byte, b'\n' | b'\r' | 0)) {
                self.text.pop();
            }
            if !self.text.trim_ascii().is_empty() {
                return Ok(true);
            }
        }
    }

    /// The rest of a gzip stream is read for its CRC: behind a damaged byte the rows are nonsense
    /// before it is noticed.
    pub fn corruption(&mut self, file: &str) -> Option<RecordingError> {
        let line = self.line.saturating_sub(1);
        let end = if self.gzipped { std::io::copy(&mut self.source, &mut std::io::sink()) } else { Ok(0) };
        let error = end.err()?;
        if error.kind() == ErrorKind::FileTooLarge {
            return Some(self.read_error(file, 0, error));
        }
        let reason = error.to_string();
        Some(RecordingError::CorruptGzip { file: file.into(), line, reason })
    }

    fn read_error(&self, file: &str, rows: usize, error: std::io::Error) -> RecordingError {
        let (file, line) = (file.to_owned(), self.read);
        match error.kind() {
            ErrorKind::FileTooLarge => {
                let cure = "unpack it first (gunzip -k), if it is right: what is not packed is read at any length";
                crate::bytes::bad(&file, format!("line {line}"), error.to_string(), cure)
            }
            _ if !self.gzipped => RecordingError::Io { file, action: "read", reason: error },
            ErrorKind::UnexpectedEof => RecordingError::TruncatedGzip { file, line, rows },
            _ => RecordingError::CorruptGzip { file, line, reason: error.to_string() },
        }
    }
}
