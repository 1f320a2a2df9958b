//! CSV and gzipped CSV: header row `name [unit]`, first column `time [s]`.
//!
//! Units of the table in [`crate::units`] are converted here and nowhere else. Nothing is guessed: a cell that is no
//! finite number, a row of another length and a unit that is not known are errors with their place.

use crate::channels::default_channel;
use crate::error::{Place, RecordingError, nearest};
use crate::table::{Column, Table, TableBuilder};
use crate::units::{UNITS, Unit, accepted_for, unit_named};
use crate::{Format, Imported, file_name};
use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::Path;

const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// The CSV format, plain or gzipped.
pub struct Csv;

impl Format for Csv {
    fn name(&self) -> &'static str {
        "csv"
    }

    fn sniff(&self, head: &[u8]) -> bool {
        head.starts_with(&GZIP_MAGIC) || (!head.is_empty() && !head.contains(&0))
    }

    fn read(&self, path: &Path) -> Result<Imported, RecordingError> {
        read_csv(path).map(Imported::Table)
    }

    fn write(&self, imported: &Imported, path: &Path) -> Result<(), RecordingError> {
        match imported {
            Imported::Table(table) => write_csv(table, path),
            Imported::Run(_) => {
                Err(RecordingError::NotWritable { file: file_name(path), format: self.name(), what: "a recorded run" })
            }
        }
    }
}

/// Reads a CSV file; gzip is recognised by content.
///
/// # Errors
/// Everything that would make a number uncertain, with line, column, value and cure.
pub fn read_csv(path: &Path) -> Result<Table, RecordingError> {
    let name = file_name(path);
    let io = |action| move |source| RecordingError::Io { file: file_name(path), action, reason: source };
    let mut file = File::open(path).map_err(io("open"))?;
    let mut head = Vec::new();
    (&mut file).take(2).read_to_end(&mut head).map_err(io("read"))?;
    let gzipped = head == GZIP_MAGIC;
    let unfinished_line = !gzipped && !head.is_empty() && last_byte(&mut file).map_err(io("read"))? != b'\n';
    file.seek(SeekFrom::Start(0)).map_err(io("read"))?;
    let mut table = if gzipped {
        parse(&name, MultiGzDecoder::new(BufReader::new(file)), true)?
    } else {
        parse(&name, file, false)?
    };
    if unfinished_line {
        table.notes.push("the last line is not ended by a line feed: its last number may be cut".into());
    }
    Ok(table)
}

fn last_byte(file: &mut File) -> std::io::Result<u8> {
    let mut byte = [0];
    file.seek(SeekFrom::End(-1))?;
    file.read_exact(&mut byte)?;
    Ok(byte[0])
}

/// Reads CSV text from any source.
fn parse(file: &str, source: impl Read, gzipped: bool) -> Result<Table, RecordingError> {
    let mut rows = Rows::new(BufReader::with_capacity(1 << 16, source), gzipped);
    if !rows.next(file, 0)? {
        return Err(RecordingError::Empty { file: file.into() });
    }
    let headers = parse_headers(file, &rows.cells, rows.line)?;
    let columns = headers[1..].iter().map(|header| Column {
        name: header.name.clone(),
        unit: header.unit.si,
        unit_in_file: header.unit_in_file.clone(),
        values: Vec::new(),
    });
    let mut builder = TableBuilder::new(file, columns.collect());
    let mut row = Vec::with_capacity(headers.len());
    while rows.next(file, builder.rows())? {
        let taken = parse_row(file, &headers, &rows.cells, rows.line, &mut row);
        if let Err(error) = taken.and_then(|()| builder.push(rows.line, &row)) {
            return Err(rows.corruption(file).unwrap_or(error));
        }
    }
    builder.finish()
}

/// Rows of a file with the lines they stand on.
///
/// Lines are taken here and only their cells by the `csv` crate, which (1.4) gives a row behind blank lines the number
/// of the first of them. A quoted cell therefore ends with its line, as every cell of this format does.
struct Rows<R> {
    source: R,
    gzipped: bool,
    text: Vec<u8>,
    cells: ::csv::ByteRecord,
    line: u64,
}

impl<R: BufRead> Rows<R> {
    fn new(source: R, gzipped: bool) -> Self {
        Rows { source, gzipped, text: Vec::new(), cells: ::csv::ByteRecord::new(), line: 0 }
    }

    /// Goes to the next row that is not blank; `false` at the end.
    fn next(&mut self, file: &str, rows: usize) -> Result<bool, RecordingError> {
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

    /// The rest of a gzip stream is read for its CRC: behind a damaged byte the rows are nonsense before it is noticed.
    fn corruption(&mut self, file: &str) -> Option<RecordingError> {
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

struct Header {
    name: String,
    unit: &'static Unit,
    unit_in_file: String,
    text: String,
}

fn parse_headers(file: &str, record: &::csv::ByteRecord, line: u64) -> Result<Vec<Header>, RecordingError> {
    let mut headers: Vec<Header> = Vec::with_capacity(record.len());
    for (i, cell) in record.iter().enumerate() {
        let text = String::from_utf8_lossy(cell);
        let text = text.trim_start_matches('\u{feff}').trim().trim_matches('"');
        let place = || Box::new(Place { file: file.into(), line, column: i + 1, name: abbreviated(text) });
        let (name, unit_text) = match text.strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) {
            Some((name, unit)) => (name.trim(), Some(unit.trim())),
            None => (text, None),
        };
        if i == 0 && name != "time" {
            return Err(RecordingError::NoTimeColumn { place: place(), cure: no_time_cure(text, record) });
        }
        if let Some(first) = headers.iter().position(|header| header.name == name) {
            return Err(RecordingError::DuplicateColumn { place: place(), first: first + 1 });
        }
        let Some(unit_text) = unit_text else { return Err(RecordingError::NoUnit { place: place() }) };
        let expected = if i == 0 { Some("s") } else { default_channel(name).map(|channel| channel.unit) };
        let unit = unit_named(unit_text).filter(|unit| i > 0 || unit.si == "s");
        let Some(unit) = unit else { return Err(unknown_unit(place(), unit_text, expected)) };
        headers.push(Header { name: name.into(), unit, unit_in_file: unit_text.into(), text: text.into() });
    }
    Ok(headers)
}

fn unknown_unit(place: Box<Place>, found: &str, expected: Option<&str>) -> RecordingError {
    let accepted = match expected {
        Some(si) => accepted_for(si),
        None => UNITS.iter().map(|unit| unit.symbol).collect::<Vec<_>>().join(", "),
    };
    let near = nearest(found, UNITS.iter().filter(|u| expected.is_none_or(|si| u.si == si)).map(|u| u.symbol));
    let cure = match near {
        Some(near) => format!("if `{near}` is meant, write `[{near}]`; else convert the column, or delete it"),
        None => "convert the column to SI, or delete it".into(),
    };
    RecordingError::UnknownUnit { place, found: abbreviated(found), accepted, cure }
}

fn no_time_cure(first: &str, record: &::csv::ByteRecord) -> String {
    let is_time = |cell: &[u8]| String::from_utf8_lossy(cell).trim_start().starts_with("time");
    if first.starts_with("frequency") {
        "this is a spectrum, not a time record: nothing can be replayed from it; give the recording it was computed from".into()
    } else if record.len() == 1 && (first.contains(';') || first.contains('\t')) {
        "separate the columns by commas, with a point in decimal numbers".into()
    } else if let Some(at) = record.iter().position(is_time) {
        format!("put column {} first: time leads every row", at + 1)
    } else if first.parse::<f64>().is_ok() {
        "put a header row `time [s],name [unit],...` above the data".into()
    } else {
        "put a first column `time [s]` in (or ms, us, ns, min, h), made from the sample number if there is no clock"
            .into()
    }
}

fn parse_row(
    file: &str,
    headers: &[Header],
    record: &::csv::ByteRecord,
    line: u64,
    row: &mut Vec<f64>,
) -> Result<(), RecordingError> {
    if record.len() != headers.len() {
        let cells: Vec<_> = record.iter().map(String::from_utf8_lossy).collect();
        return Err(RecordingError::Ragged {
            file: file.into(),
            line,
            found: record.len(),
            expected: headers.len(),
            row: abbreviated(&cells.join(",")),
        });
    }
    row.clear();
    for (i, (cell, header)) in record.iter().zip(headers).enumerate() {
        let place = || Box::new(Place { file: file.into(), line, column: i + 1, name: header.text.clone() });
        let text = String::from_utf8_lossy(cell);
        let value: f64 = match text.parse() {
            Ok(value) => value,
            Err(_) => return Err(RecordingError::NotANumber { place: place(), value: abbreviated(&text) }),
        };
        if !value.is_finite() {
            return Err(RecordingError::NotFinite { place: place(), value: abbreviated(&text) });
        }
        row.push(header.unit.to_si(value));
    }
    Ok(())
}

/// The first 60 characters: a binary file must not fill the operator's screen.
fn abbreviated(text: &str) -> String {
    let printable = text.chars().map(|c| if c.is_control() { '?' } else { c });
    if text.chars().count() <= 60 { printable.collect() } else { printable.take(60).chain("...".chars()).collect() }
}

/// Writes a table in SI, gzipped when the name ends in `.gz`; every number reads back to the same f64.
///
/// # Errors
/// The device's.
pub fn write_csv(table: &Table, path: &Path) -> Result<(), RecordingError> {
    let io = |action| move |source| RecordingError::Io { file: file_name(path), action, reason: source };
    let file = BufWriter::new(File::create(path).map_err(io("create"))?);
    if path.extension().is_some_and(|extension| extension == "gz") {
        let mut encoder = GzEncoder::new(file, flate2::Compression::default());
        write_rows(table, &mut encoder).map_err(io("write"))?;
        encoder.finish().and_then(|mut file| file.flush()).map_err(io("write"))
    } else {
        let mut file = file;
        write_rows(table, &mut file).and_then(|()| file.flush()).map_err(io("write"))
    }
}

fn write_rows(table: &Table, out: &mut impl Write) -> std::io::Result<()> {
    write!(out, "time [s]")?;
    for column in &table.columns {
        // A name with a comma in it came out of quotes and goes back into them.
        let quote = if column.name.contains(',') { "\"" } else { "" };
        write!(out, ",{quote}{} [{}]{quote}", column.name, column.unit)?;
    }
    writeln!(out)?;
    for (i, time) in table.time_s.iter().enumerate() {
        write!(out, "{time}")?;
        for column in &table.columns {
            write!(out, ",{}", column.values[i])?;
        }
        writeln!(out)?;
    }
    Ok(())
}
