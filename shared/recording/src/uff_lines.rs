//! The text of a universal file: lines with their numbers, blocks of bytes between them, and
//! numbers in fixed columns.

use crate::error::RecordingError;

const CUT: &str = "copy or export the file again: it ends within a dataset";

/// A place in the file.
pub(crate) struct Text<'a> {
    file: &'a str,
    bytes: &'a [u8],
    at: usize,
    /// Of the line read last, from 1; bytes of binary datasets count as no line.
    pub line: u64,
}

impl<'a> Text<'a> {
    /// The lines of `bytes`; `file` is named in errors.
    pub fn new(file: &'a str, bytes: &'a [u8]) -> Self {
        Self { file, bytes, at: 0, line: 0 }
    }

    /// [`RecordingError::BadUff`] at the current line.
    pub fn error(&self, found: String, cure: &str) -> RecordingError {
        RecordingError::BadUff { file: self.file.into(), line: self.line, found, cure: cure.into() }
    }

    /// Bytes that were not read yet.
    pub fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    /// The next line without its end; columns are bytes, so that what is no ASCII becomes one `?` a
    /// byte.
    pub fn next_line(&mut self) -> Option<String> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        self.at += length + 1;
        self.line += 1;
        let ascii = rest[..length].iter().map(|byte| if byte.is_ascii() { char::from(*byte) } else { '?' });
        Some(ascii.collect::<String>().trim_end_matches('\r').to_string())
    }

    /// The next line.
    ///
    /// # Errors
    /// The file ends before it.
    pub fn needed_line(&mut self) -> Result<String, RecordingError> {
        let before = self.line;
        self.next_line().ok_or_else(|| self.error(format!("the file ends after line {before}"), CUT))
    }

    /// Whether the line `-1`, in its six columns, stands so many bytes further on; a line feed may
    /// stand between.
    pub fn closes_behind(&self, length: usize) -> bool {
        let Some(rest) = self.bytes.get(self.at.saturating_add(length)..) else { return false };
        let line = rest.strip_prefix(b"\r\n").or_else(|| rest.strip_prefix(b"\n")).unwrap_or(rest);
        line.starts_with(b"    -1")
    }

    /// The next `length` bytes of binary numbers.
    ///
    /// # Errors
    /// The file ends within them; the message counts what is left.
    pub fn block(&mut self, length: usize) -> Result<&'a [u8], RecordingError> {
        let found = self.bytes.len().saturating_sub(self.at);
        let block = self.bytes.get(self.at..self.at.saturating_add(length));
        let block = block
            .ok_or_else(|| self.error(format!("{length} bytes of numbers are announced, {found} are there"), CUT))?;
        self.at += length;
        Ok(block)
    }

    /// The line `-1` behind the numbers; a line feed may stand between.
    pub fn close_dataset(&mut self) -> Result<(), RecordingError> {
        loop {
            let line = self.needed_line()?;
            match line.trim() {
                "-1" => return Ok(()),
                "" => {}
                other => {
                    let found = format!("`{}` stands where `-1` closes the dataset", shortened(other));
                    return Err(
                        self.error(found, "the header announces fewer numbers than there are: export the file again")
                    );
                }
            }
        }
    }

    /// Number of the dataset that `line` opens, and the line that holds it.
    ///
    /// # Errors
    /// `line` is not `-1`; the file ends.
    pub fn open_dataset(&mut self, line: &str) -> Result<(String, String), RecordingError> {
        if line.trim() != "-1" {
            let found = format!("`{}` stands where `-1` opens a dataset", shortened(line.trim()));
            return Err(self.error(found, "export the file again"));
        }
        let number = self.needed_line()?;
        let id = number.split_whitespace().next().unwrap_or_default();
        Ok((shortened(id), number))
    }

    /// The next line of a dataset; `None` is the `-1` that closes it.
    ///
    /// # Errors
    /// The file ends before it.
    pub fn body_line(&mut self) -> Result<Option<String>, RecordingError> {
        self.needed_line().map(|line| Some(line).filter(|line| line.trim() != "-1"))
    }

    /// Reads over a dataset and its closing `-1`; gives its second line.
    ///
    /// # Errors
    /// The file ends before its `-1`.
    pub fn skip_dataset(&mut self) -> Result<String, RecordingError> {
        let (mut second, mut count) = (String::new(), 0_usize);
        while let Some(line) = self.body_line()? {
            count = count.saturating_add(1);
            if count == 2 {
                second = line;
            }
        }
        Ok(second)
    }
}

pub(crate) fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}

/// The columns of a line, counted from 0; what lies behind its end is empty.
pub(crate) fn cut(line: &str, from: usize, to: usize) -> &str {
    let end = to.min(line.len());
    line.get(from.min(end)..end).unwrap_or_default().trim()
}

/// A number as Fortran writes it: exponents by D, or by a bare sign where three digits leave no
/// room for the letter.
pub(crate) fn number(text: &str) -> Option<f64> {
    let plain = text.trim().replace(['D', 'd'], "E");
    if let Ok(number) = plain.parse() {
        return Some(number);
    }
    let sign = plain.rfind(['+', '-']).filter(|at| *at > 0)?;
    let (mantissa, exponent) = plain.split_at(sign);
    mantissa
        .ends_with(|c: char| c.is_ascii_digit() || c == '.')
        .then(|| format!("{mantissa}E{exponent}").parse().ok())?
}

/// The numbers of a line in fields of `widths`, again and again; of a line that was not written in
/// these fields, its words.
pub(crate) fn numbers(line: &str, widths: &[usize]) -> Option<Vec<f64>> {
    in_fields(line, widths).or_else(|| line.split_whitespace().map(number).collect())
}

fn in_fields(line: &str, widths: &[usize]) -> Option<Vec<f64>> {
    let line = line.trim_end();
    let (mut found, mut from) = (Vec::new(), 0);
    for width in widths.iter().cycle() {
        if from >= line.len() {
            return Some(found);
        }
        let to = (from + width).min(line.len());
        // A field begins with a blank or a sign, unless its digits fill it; a digit behind a digit
        // is one number cut in two.
        let digit = |at: usize| line.as_bytes().get(at).is_some_and(u8::is_ascii_digit);
        if from > 0 && digit(from) && digit(from - 1) {
            return None;
        }
        found.push(number(line.get(from..to)?)?);
        from = to;
    }
    None
}
