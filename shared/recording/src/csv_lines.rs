//! Lines of a CSV file, plain or gzipped, with the numbers they stand under.

use crate::error::RecordingError;
use std::io::{BufRead, ErrorKind};

/// Rows of a file with the lines they stand on.
///
/// Lines are taken here and only their cells by the `csv` crate, which (1.4) gives a row behind
/// blank lines the number of the first of them. A quoted cell therefore ends with its line, as
/// every cell of this format does.
pub(crate) struct Lines<R> {
    source: R,
    gzipped: bool,
    text: Vec<u8>,
    pub cells: ::csv::ByteRecord,
    pub line: u64,
}

impl<R: BufRead> Lines<R> {
    /// Lines of `source`, the first counted as 1; `gzipped` words the errors of a damaged archive.
    pub fn new(source: R, gzipped: bool) -> Self {
        Lines { source, gzipped, text: Vec::new(), cells: ::csv::ByteRecord::new(), line: 0 }
    }

    /// Goes to the next row that is not blank; `false` at the end.
    pub fn next(&mut self, file: &str, rows: usize) -> Result<bool, RecordingError> {
        loop {
            self.text.clear();
            let taken = self.source.read_until(b'\n', &mut self.text);
            if taken.map_err(|error| self.read_error(file, rows, error))? == 0 {
                return Ok(false);
            }
            self.line += 1;
            if !self.text.trim_ascii().is_empty() {
                self.split();
                return Ok(true);
            }
        }
    }

    fn split(&mut self) {
        let text = self.text.trim_ascii();
        self.cells.clear();
        if text.contains(&b'"') {
            let mut reader =
                ::csv::ReaderBuilder::new().has_headers(false).flexible(true).trim(::csv::Trim::All).from_reader(text);
            reader.read_byte_record(&mut self.cells).expect("a line in memory is read without fail");
        } else {
            text.split(|byte| *byte == b',').for_each(|cell| self.cells.push_field(cell.trim_ascii()));
        }
    }

    /// The rest of a gzip stream is read for its CRC: behind a damaged byte the rows are nonsense
    /// before it is noticed.
    pub fn corruption(&mut self, file: &str) -> Option<RecordingError> {
        let line = self.line.saturating_sub(1);
        let end = if self.gzipped { std::io::copy(&mut self.source, &mut std::io::sink()) } else { Ok(0) };
        let reason = end.err()?.to_string();
        Some(RecordingError::CorruptGzip { file: file.into(), line, reason })
    }

    fn read_error(&self, file: &str, rows: usize, error: std::io::Error) -> RecordingError {
        let (file, line) = (file.into(), self.line);
        match error.kind() {
            _ if !self.gzipped => RecordingError::Io { file, action: "read", reason: error },
            ErrorKind::UnexpectedEof => RecordingError::TruncatedGzip { file, line, rows },
            _ => RecordingError::CorruptGzip { file, line, reason: error.to_string() },
        }
    }
}
