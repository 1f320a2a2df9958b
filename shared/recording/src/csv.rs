//! Text tables, plain or gzipped: CSV and its kin as loggers, spreadsheets and analysers write
//! them.
//!
//! Separator, decimal sign, header, units and the column of times are found from the text
//! (`text`, [`crate::intake`]); what the text does not say, an [`Intake`] says. Written is
//! one form: header `name [unit]`, first column `time [s]` (`frequency [Hz]` of a spectrum). An
//! empty cell, `NaN` and `inf` mean that this channel has no sample at this time. A cell that is no
//! number and a row of another length are errors with their place, but for lines behind the last
//! row.

use crate::error::RecordingError;
use crate::intake::Intake;
use crate::intake::names::listed;
use crate::intake::plan::{Clock, Plan, Planned};
use crate::intake::second_clock::SecondClock;
use crate::rows::Rows;
use crate::table::Table;
use crate::text::at_most::{AtMost, unpacked_max};
use crate::text::cells::{Cells, Counts};
use crate::text::dialect::filled;
use crate::text::encoding::{Encoding, Returns, Utf16, text_of};
use crate::text::foreign::{Foreign, foreign};
use crate::text::lines::Lines;
use crate::text::printable;
use crate::text::seen::Layout;
use crate::{Format, Imported, file_name};
use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

mod date_order;
mod each_row;
mod planned;
mod tidy;
mod two_clocks;
mod written;

use each_row::{each_row, notes_of};
use planned::{planned, seen};
use tidy::Tidy;
pub use written::{write_csv, write_series_csv, write_spectrum_csv};

const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// The CSV format, plain or gzipped.
pub struct Csv;

impl Format for Csv {
    fn name(&self) -> &'static str {
        "csv"
    }

    fn sniff(&self, head: &[u8]) -> bool {
        head.starts_with(&GZIP_MAGIC) || (!head.is_empty() && Encoding::of(head).is_some())
    }

    fn read(&self, path: &Path, intake: &Intake) -> Result<Imported, RecordingError> {
        let (file, mut lines) = lines_of(path)?;
        refuse_foreign(&file, &mut lines)?;
        if let Some(tidy) = Tidy::of(&file, &mut lines, intake)? {
            return tidy.read(&file, &mut lines, intake);
        }
        let (rows, notes, second_clocks) = rows_of(path, &mut lines, intake)?;
        let mut imported = rows.finish()?;
        imported.notes_mut().extend(notes);
        second_clocks.iter().try_fold(imported, |imported, second| second.given(imported))
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

/// The error of a text that is no table.
fn refuse_foreign(file: &str, lines: &mut Lines<impl BufRead>) -> Result<(), RecordingError> {
    let ahead: Vec<(u64, String)> = lines.look_ahead(file)?.iter().map(|(line, text)| (*line, text_of(text))).collect();
    let Some(Foreign { what, cure }) = foreign(&ahead) else { return Ok(()) };
    let found = format!("this is {what}, not a table");
    Err(RecordingError::UnknownFormat { file: file.into(), found, cure: cure.into() })
}

/// Reads a CSV file as a table of one rate; gzip is recognised by content.
///
/// # Errors
/// Everything that would make a number uncertain, with line, column, value and cure; what is no
/// table: empty cells, more than one rate, time that starts again, a spectrum. [`crate::read`]
/// takes those too.
pub fn read_csv(path: &Path) -> Result<Table, RecordingError> {
    let (_, mut lines) = lines_of(path)?;
    let (rows, notes, _) = rows_of(path, &mut lines, &Intake::default())?;
    let mut table = rows.finish_table()?;
    table.notes.extend(notes);
    Ok(table)
}

/// Opens a text table: its bytes as UTF-8 (or Latin-1), and whether they are packed.
fn open(path: &Path) -> Result<(Box<dyn BufRead>, bool), RecordingError> {
    let io = |reason| RecordingError::Io { file: file_name(path), action: "read", reason };
    let mut file =
        File::open(path).map_err(|reason| RecordingError::Io { file: file_name(path), action: "open", reason })?;
    let mut magic = Vec::new();
    (&mut file).take(2).read_to_end(&mut magic).map_err(io)?;
    file.seek(SeekFrom::Start(0)).map_err(io)?;
    let gzipped = magic == GZIP_MAGIC;
    let mut source: Box<dyn BufRead> = if gzipped {
        let most = unpacked_max(file.metadata().map_err(io)?.len());
        Box::new(BufReader::with_capacity(1 << 16, AtMost::new(MultiGzDecoder::new(BufReader::new(file)), most)))
    } else {
        Box::new(BufReader::with_capacity(1 << 16, file))
    };
    // What is wrong with an archive is worded where its lines are counted.
    let encoding = source.fill_buf().ok().and_then(Encoding::of).unwrap_or(Encoding::Bytes);
    if encoding != Encoding::Bytes {
        source = Box::new(BufReader::new(Utf16::new(source, encoding == Encoding::Utf16Little)));
    }
    if source.fill_buf().is_ok_and(Returns::<()>::are_in) {
        source = Box::new(BufReader::new(Returns(source)));
    }
    Ok((source, gzipped))
}

/// Name and lines of a file.
fn lines_of(path: &Path) -> Result<(String, Lines<Box<dyn BufRead>>), RecordingError> {
    let (source, gzipped) = open(path)?;
    Ok((file_name(path), Lines::new(source, gzipped)))
}

/// The rows of a file, what there is to note about them, and clocks of some of their columns.
fn rows_of(
    path: &Path,
    lines: &mut Lines<impl BufRead>,
    intake: &Intake,
) -> Result<(Rows, Vec<String>, Vec<SecondClock>), RecordingError> {
    let file = file_name(path);
    let (layout, mut plan) = match planned(&file, lines, intake) {
        Ok(planned) => planned,
        Err(error) => return Err(lines.corruption(&file).unwrap_or(error)),
    };
    date_order::settle(path, &layout, &mut plan);
    let (rows, mut notes) = taken(&file, lines, &layout, &plan)?;
    notes.splice(0..0, plan.notes);
    if !lines.gzipped && !ends_with_line_feed(path)? {
        notes.push("the last line is not ended by a line feed: its last number may be cut".into());
    }
    Ok((rows, notes, plan.second_clocks))
}

fn ends_with_line_feed(path: &Path) -> Result<bool, RecordingError> {
    let io = |reason| RecordingError::Io { file: file_name(path), action: "read", reason };
    let mut file = File::open(path).map_err(io)?;
    let mut end = [0; 2];
    let length = file.seek(SeekFrom::End(0)).map_err(io)?;
    file.seek(SeekFrom::Start(length.saturating_sub(2))).map_err(io)?;
    let n = file.read(&mut end).map_err(io)?;
    // UTF-16 ends in a line feed and a zero
    Ok(end[..n].contains(&b'\n'))
}

/// Takes every row of the file.
fn taken(
    file: &str,
    lines: &mut Lines<impl BufRead>,
    layout: &Layout,
    plan: &Plan,
) -> Result<(Rows, Vec<String>), RecordingError> {
    let columns = plan.columns.iter().map(Planned::column);
    let (header, positions) = places_of(plan);
    let mut rows = Rows::new(file, plan.axis, columns.collect()).with_places(header, positions).with_clock_of(plan);
    let mut cells = Cells::new(file, layout.dialect, plan, width_of(layout), &layout.header);
    let other = each_row(file, lines, layout.first_line, &mut cells, &mut |_, line, row| rows.push(line, row))?;
    rows.origin_s = cells.origin_s();
    let mut notes = notes_of(&cells, plan, other, rows.count())?;
    rows.texts = cells.counts.iter().filter_map(Counts::text).collect();
    notes.extend(without_texts(&mut rows, cells, plan)?);
    let empty = rows.leave_out_empty();
    if !empty.is_empty() {
        notes.push(format!("left out: {}", listed(&empty)));
    }
    Ok((rows, notes))
}

/// Leaves out the columns most of whose cells are no numbers.
///
/// # Errors
/// Of the first such cell, where no column is left.
fn without_texts(rows: &mut Rows, cells: Cells<'_>, plan: &Plan) -> Result<Option<String>, RecordingError> {
    let kept: Vec<bool> = cells.counts.iter().map(Counts::is_of_numbers).collect();
    if kept.iter().all(|kept| *kept) {
        return Ok(None);
    }
    let mut first = cells.counts.into_iter().zip(&kept).filter(|(_, kept)| !**kept).map(|(of, _)| of.first_text);
    if let (true, Some(error)) = (kept.iter().all(|kept| !kept), first.next().flatten()) {
        return Err(error);
    }
    rows.keep_columns(&kept);
    let gone = plan.columns.iter().zip(&kept).filter(|(_, kept)| !**kept);
    let gone: Vec<String> = gone.map(|(of, _)| format!("`{}` (most of its cells are no numbers)", of.name)).collect();
    Ok(Some(format!("left out: {}", listed(&gone))))
}

/// Header of the clock and positions of the columns, for errors.
fn places_of(plan: &Plan) -> (String, Vec<usize>) {
    let positions = core::iter::once(clock_position(plan)).chain(plan.columns.iter().map(|of| of.at));
    (printable(&plan.clock_header), positions.collect())
}

fn clock_position(plan: &Plan) -> usize {
    match &plan.clock {
        Clock::Number { at, .. } | Clock::Steps { at, .. } => *at,
        Clock::Stamps(parts) => parts[0].0,
        Clock::Rows { .. } => 0,
    }
}

/// Cells that a row must have: those of the header but for names of empty columns at its end.
fn width_of(layout: &Layout) -> usize {
    let shortest = layout.rows.iter().map(Vec::len).min().unwrap_or(0);
    let used = layout.rows.iter().map(|row| filled(row)).max().unwrap_or(0).max(filled(&layout.header));
    if layout.header.is_empty() { used } else { used.min(layout.header.len().max(shortest)) }
}

fn is_remark(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    matches!(line.first(), Some(b'#' | b'%')) || line.starts_with(b"//")
}
