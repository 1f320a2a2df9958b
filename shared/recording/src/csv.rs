//! CSV and gzipped CSV: header row `name [unit]`, first column `time [s]` (`frequency [Hz]` of a
//! spectrum).
//!
//! Units of the table in [`crate::units`] are converted here and nowhere else. An empty cell means
//! that this channel has no sample at this time. Nothing is guessed: a cell that is no finite
//! number, a row of another length and a unit that is not known are errors with their place.

use crate::csv_cells::{parse_headers, parse_row};
use crate::csv_lines::Lines;
use crate::error::RecordingError;
use crate::function_kind::FunctionKind;
use crate::rows::Rows;
use crate::series::{check, for_each_time};
use crate::spectrum::Spectrum;
use crate::table::{Column, Table};
use crate::timing::check_extent;
use crate::whole_file::replace_stream;
use crate::{Format, Imported, file_name};
use channels::Recording;
use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Seek, SeekFrom, Write};
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
        let (rows, note) = read_rows(path)?;
        let mut imported = rows.finish()?;
        imported.notes_mut().extend(note);
        Ok(imported)
    }

    fn write(&self, imported: &Imported, path: &Path) -> Result<(), RecordingError> {
        let not_writable = |what| RecordingError::NotWritable { file: file_name(path), format: self.name(), what };
        match imported {
            Imported::Table(table) => write_csv(table, path),
            Imported::Series(set) => write_series_csv(&set.recording, path),
            Imported::Spectrum(spectrum) => write_spectrum_csv(spectrum, path),
            Imported::Run(_) => Err(not_writable("a recorded run")),
            Imported::Segments(_) => Err(not_writable("several recordings")),
        }
    }
}

/// Reads a CSV file as a table of one rate; gzip is recognised by content.
///
/// # Errors
/// Everything that would make a number uncertain, with line, column, value and cure; what is no
/// table: empty cells, more than one rate, time that starts again, a spectrum. [`crate::read`]
/// takes those too.
pub fn read_csv(path: &Path) -> Result<Table, RecordingError> {
    let (rows, note) = read_rows(path)?;
    let mut table = rows.finish_table()?;
    table.notes.extend(note);
    Ok(table)
}

/// The rows of a file, and a doubt about the last one.
fn read_rows(path: &Path) -> Result<(Rows, Option<String>), RecordingError> {
    let name = file_name(path);
    let io = |action| move |source| RecordingError::Io { file: file_name(path), action, reason: source };
    let mut file = File::open(path).map_err(io("open"))?;
    let mut head = Vec::new();
    (&mut file).take(2).read_to_end(&mut head).map_err(io("read"))?;
    let gzipped = head == GZIP_MAGIC;
    let unfinished_line = !gzipped && !head.is_empty() && last_byte(&mut file).map_err(io("read"))? != b'\n';
    file.seek(SeekFrom::Start(0)).map_err(io("read"))?;
    let rows = if gzipped {
        parse(&name, MultiGzDecoder::new(BufReader::new(file)), true)?
    } else {
        parse(&name, file, false)?
    };
    let note = "the last line is not ended by a line feed: its last number may be cut";
    Ok((rows, unfinished_line.then(|| note.into())))
}

fn last_byte(file: &mut File) -> std::io::Result<u8> {
    let mut byte = [0];
    file.seek(SeekFrom::End(-1))?;
    file.read_exact(&mut byte)?;
    Ok(byte[0])
}

/// Reads CSV text from any source.
fn parse(file: &str, source: impl Read, gzipped: bool) -> Result<Rows, RecordingError> {
    let mut lines = Lines::new(BufReader::with_capacity(1 << 16, source), gzipped);
    if !lines.next(file, 0)? {
        return Err(RecordingError::Empty { file: file.into() });
    }
    let (axis, headers) = parse_headers(file, &lines.cells, lines.line)?;
    let columns = headers[1..].iter().map(|header| Column {
        name: header.name.clone(),
        unit: header.unit.si,
        unit_in_file: header.unit_in_file.clone(),
        kind: FunctionKind::Unknown,
        values: Vec::new(),
    });
    let mut rows = Rows::new(file, axis, columns.collect());
    let mut row = Vec::with_capacity(headers.len());
    while lines.next(file, rows.count())? {
        let taken = parse_row(file, axis, &headers, &lines.cells, lines.line, &mut row);
        if let Err(error) = taken.and_then(|()| rows.push(lines.line, &row)) {
            return Err(lines.corruption(file).unwrap_or(error));
        }
    }
    Ok(rows)
}

/// Writes a table in SI, gzipped when the name ends in `.gz`; every number reads back to the same
/// f64.
///
/// # Errors
/// The device's.
pub fn write_csv(table: &Table, path: &Path) -> Result<(), RecordingError> {
    let columns: Vec<_> = table.columns.iter().map(|column| (column.name.as_str(), column.unit)).collect();
    write_text(path, &mut |out| {
        write_header(out, "time [s]", &columns)?;
        write_columns(out, &table.time_s, &table.columns)
    })
}

/// Writes channels in SI, gzipped when the name ends in `.gz`: a row per time at which any channel
/// has a sample, an empty cell where a channel has none. Every number reads back to the same f64.
///
/// # Errors
/// [`RecordingError::BadChannel`] for what would not read back, times too few to read back, the
/// device's.
pub fn write_series_csv(recording: &Recording, path: &Path) -> Result<(), RecordingError> {
    check(recording)?;
    let mut times = Vec::new();
    let Ok(()) = for_each_time(recording, |time_s, _| {
        times.push(time_s);
        Ok::<(), core::convert::Infallible>(())
    });
    // The row of time i stands on line i + 2.
    check_extent(&file_name(path), &times, &(2..times.len() as u64 + 2).collect::<Vec<_>>())?;
    let columns: Vec<_> =
        recording.channels.iter().map(|channel| (channel.name.as_str(), channel.unit.as_str())).collect();
    write_text(path, &mut |out| {
        write_header(out, "time [s]", &columns)?;
        for_each_time(recording, |time_s, values| {
            write!(out, "{}", Shortest(time_s))?;
            for value in values {
                match value {
                    Some(value) => write!(out, ",{}", Shortest(*value))?,
                    None => write!(out, ",")?,
                }
            }
            writeln!(out)
        })
    })
}

/// Writes a spectrum in SI, gzipped when the name ends in `.gz`.
///
/// # Errors
/// The device's.
pub fn write_spectrum_csv(spectrum: &Spectrum, path: &Path) -> Result<(), RecordingError> {
    let columns: Vec<_> = spectrum.columns.iter().map(|column| (column.name.as_str(), column.unit)).collect();
    write_text(path, &mut |out| {
        write_header(out, "frequency [Hz]", &columns)?;
        write_columns(out, &spectrum.frequency_hz, &spectrum.columns)
    })
}

fn write_text(path: &Path, fill: &mut dyn FnMut(&mut dyn Write) -> std::io::Result<()>) -> Result<(), RecordingError> {
    let gzipped = path.extension().is_some_and(|extension| extension == "gz");
    replace_stream(path, |file| {
        if !gzipped {
            return fill(file);
        }
        // Cells one by one would cost a call of the compressor each.
        let mut text = BufWriter::with_capacity(1 << 16, GzEncoder::new(file, flate2::Compression::default()));
        fill(&mut text)?;
        text.into_inner().map_err(std::io::IntoInnerError::into_error)?.finish().map(|_| ())
    })
}

fn write_header(out: &mut dyn Write, first: &str, columns: &[(&str, &str)]) -> std::io::Result<()> {
    write!(out, "{first}")?;
    for (name, unit) in columns {
        // A name with a comma in it came out of quotes and goes back into them.
        let quote = if name.contains(',') { "\"" } else { "" };
        write!(out, ",{quote}{name} [{unit}]{quote}")?;
    }
    writeln!(out)
}

fn write_columns(out: &mut dyn Write, first: &[f64], columns: &[Column]) -> std::io::Result<()> {
    for (i, value) in first.iter().enumerate() {
        write!(out, "{}", Shortest(*value))?;
        for column in columns {
            write!(out, ",{}", Shortest(column.values[i]))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// The fewest digits that read back to the same f64, with an exponent where zeros would be longer.
struct Shortest(f64);

impl core::fmt::Display for Shortest {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let value = self.0;
        if value == 0.0 || (1e-5..1e16).contains(&value.abs()) { write!(f, "{value}") } else { write!(f, "{value:e}") }
    }
}
