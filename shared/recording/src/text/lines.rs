//! Lines of a text file, plain or gzipped, with the numbers they stand under.

use crate::error::RecordingError;
use std::collections::VecDeque;
use std::io::{BufRead, ErrorKind, Read};

/// Longest line [bytes]: 400 000 cells, and a bound on what a file without line feeds can take.
const LINE_MAX: u64 = 8 << 20;
/// Lines and bytes that are looked at before the first row is taken.
const AHEAD_LINES: usize = 400;
const AHEAD_BYTES: usize = 1 << 20;

/// Lines of a source. A quoted cell ends with its line, but for those of a header.
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
        join_quoted(&mut self.ahead);
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
            // a file system fills with zeros what was not written when power was lost
            let zeros = self.text.iter().take_while(|byte| **byte == 0).count();
            self.text.drain(..zeros);
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

/// Lines that a quoted cell of a header may have.
const QUOTED_LINES: usize = 8;
/// Lines in which the header ends.
const HEADER_LINES: usize = 50;

/// Joins the lines of a header that one cell in quotes holds together, with a blank for the break.
fn join_quoted(ahead: &mut VecDeque<(u64, Vec<u8>)>) {
    let mut at = 0;
    while at < ahead.len().min(HEADER_LINES) {
        let mut joined = ahead[at].1.clone();
        let mut more = 0;
        while ends_in_quotes(&joined) && more < QUOTED_LINES && at + more + 1 < ahead.len() {
            more += 1;
            joined.push(b' ');
            joined.extend_from_slice(&ahead[at + more].1);
        }
        if more > 0 && !ends_in_quotes(&joined) {
            ahead.drain(at + 1..=at + more);
            ahead[at].1 = joined;
        }
        at += 1;
    }
}

/// Whether a cell that begins with a quote is not ended within the line. A quote within a cell, the
/// sign of an inch, is none.
fn ends_in_quotes(line: &[u8]) -> bool {
    let is_separator = |byte: &u8| matches!(byte, b',' | b';' | b'\t' | b'|');
    let mut open = false;
    let mut begins = true;
    let mut bytes = line.iter().peekable();
    while let Some(byte) = bytes.next() {
        if open && *byte == b'"' && bytes.peek() == Some(&&b'"') {
            bytes.next();
        } else if open && *byte == b'"' {
            open = false;
        } else if !open && begins && *byte == b'"' {
            open = true;
        }
        begins = !open && (is_separator(byte) || (begins && byte.is_ascii_whitespace()));
    }
    open
}
