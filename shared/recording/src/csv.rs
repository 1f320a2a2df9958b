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
use crate::intake::clock::rank;
use crate::intake::names::{heading, listed};
use crate::intake::origin::origin_note;
use crate::intake::plan::{Clock, Kind, Plan, Planned, Seen, Source, plan};
use crate::intake::second_clock::SecondClock;
use crate::intake::{Intake, TimeColumn};
use crate::rows::Rows;
use crate::table::Table;
use crate::text::at_most::{AtMost, unpacked_max};
use crate::text::cells::{Cells, Counts};
use crate::text::dialect::{self, filled};
use crate::text::encoding::{Encoding, Returns, Utf16, text_of};
use crate::text::foreign::{Foreign, foreign};
use crate::text::interval::Interval;
use crate::text::layout::{Layout, layout};
use crate::text::lines::Lines;
use crate::text::number::number;
use crate::text::printable;
use crate::text::quantity::{number_in, quantity};
use crate::text::stamps::Form;
use crate::units::{Unit, unit_named};
use crate::{Format, Imported, file_name};
use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

mod date_order;
mod tidy;
mod written;

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

/// How the file is laid out, and what becomes of its columns.
fn planned(file: &str, lines: &mut Lines<impl BufRead>, intake: &Intake) -> Result<(Layout, Plan), RecordingError> {
    let ahead: Vec<(u64, String)> = lines.look_ahead(file)?.iter().map(|(line, text)| (*line, text_of(text))).collect();
    let Some((first_line, first)) = ahead.first() else {
        return Err(RecordingError::Empty { file: file.into() });
    };
    let Some(layout) = layout(&ahead) else {
        return Err(without_rows(file, *first_line, first, &ahead, intake));
    };
    if let Some(error) = comma_of_two_uses(file, &ahead, &layout) {
        return Err(error);
    }
    let columns = seen(&layout);
    let source = Source { file, line: layout.header_line };
    let mut plan = plan_with_interval(&source, &columns, &layout, intake)?;
    plan.notes.extend(layout.notes.iter().cloned());
    if layout.remarks > 0 {
        plan.notes.push(format!("{} line(s) above the header are left out", layout.remarks));
    }
    Ok((layout, plan))
}

/// What becomes of the columns. Where none holds times, the rows follow each other in the interval
/// that the lines above them state.
fn plan_with_interval(
    source: &Source<'_>,
    columns: &[Seen],
    layout: &Layout,
    intake: &Intake,
) -> Result<Plan, RecordingError> {
    let first = plan(source, columns, intake);
    let without_times = match &first {
        Ok(plan) => matches!(plan.clock, Clock::Number { at, .. } if columns[at].sample.is_empty()),
        Err(error) => matches!(error, RecordingError::NoTimeColumn { .. }),
    };
    // numbers above the rows are no names, but a row that is laid out otherwise
    let are_names = layout.header.iter().all(|name| name.parse::<f64>().is_err());
    let is_free = without_times && are_names && intake.time_column.is_none();
    let Some(interval) = layout.interval.as_ref().filter(|_| is_free) else {
        return first;
    };
    let unit = Some(Unit::scaled("s", interval.seconds, 1.0));
    let by_rows = Some(TimeColumn { name: TimeColumn::ROWS.into(), unit });
    let mut plan = plan(source, columns, &Intake { time_column: by_rows, ..intake.clone() })?;
    let Interval { seconds, stated, .. } = interval;
    plan.notes.push(format!("no column holds the times: the rows follow each other every {seconds} s ({stated})"));
    Ok(plan)
}

/// The error of a file whose comma divides cells and decimals: rows have more cells than the line
/// above them has names, and at least as many cells as there are too many are digits alone behind a
/// whole number, in every row. Which digits belong together cannot be known.
fn comma_of_two_uses(file: &str, ahead: &[(u64, String)], layout: &Layout) -> Option<RecordingError> {
    if layout.dialect.separator != b',' || layout.dialect.signs.decimal_comma {
        return None;
    }
    let above = ahead.iter().rev().find(|(line, _)| *line < layout.first_line)?;
    let names = layout.dialect.split_quoted(&above.1).len().max(layout.header.len());
    let width = layout.rows.iter().map(Vec::len).min()?;
    if names >= width || 2 * names < width {
        return None;
    }
    let digits = |cell: &str| !cell.is_empty() && cell.bytes().all(|byte| byte.is_ascii_digit());
    let whole = |cell: &str| digits(cell.trim_start_matches(['-', '+']));
    let is_part = |at: &usize| layout.rows.iter().all(|row| digits(&row[*at]) && whole(&row[at - 1]));
    let parts: Vec<usize> = (1..width).filter(is_part).collect();
    let last = parts.last().filter(|_| parts.len() >= width - names)?;
    Some(RecordingError::UnknownFormat {
        file: file.into(),
        found: format!(
            "line {} has {width} cells below {names} names; the comma divides them and seems to be the decimal sign, too",
            layout.first_line
        ),
        cure: format!(
            "write the file with `;` between cells, or with quotes around numbers; if column {} is one of its own, give it a name",
            last + 1
        ),
    })
}

/// The error of a file in which no line has a number: its header's, where it has a fault too.
fn without_rows(file: &str, line: u64, first: &str, ahead: &[(u64, String)], intake: &Intake) -> RecordingError {
    let header = first.trim_start_matches('\u{feff}');
    let cells: Vec<&str> = header.split([',', ';', '\t']).map(str::trim).collect();
    let columns: Vec<Seen> = cells
        .iter()
        .map(|cell| Seen { header: (*cell).into(), unit: None, kind: Kind::Number, sample: Vec::new() })
        .collect();
    if let Err(error) = plan(&Source { file, line }, &columns, intake) {
        return error;
    }
    match ahead.get(1) {
        None => RecordingError::TooFewRows { file: file.into(), line, rows: 0 },
        Some((line, text)) => RecordingError::UnknownFormat {
            file: file.into(),
            found: format!("line {line} has no number: `{}`", printable(text)),
            cure: "give rows of numbers, one per time, below one header row".into(),
        },
    }
}

/// What was seen of the columns.
fn seen(layout: &Layout) -> Vec<Seen> {
    let width = layout.rows.iter().map(Vec::len).max().unwrap_or(0).max(layout.header.len());
    let signs = layout.dialect.signs;
    let column = |at: usize| {
        let cells: Vec<&str> = layout.rows.iter().filter_map(|row| row.get(at)).map(String::as_str).collect();
        let given: Vec<&str> = cells.iter().copied().filter(|cell| !dialect::is_missing(cell)).collect();
        let header = layout.header.get(at).cloned().unwrap_or_default();
        let unit = unit_stated(layout, at, &header, &given);
        let own = unit.clone().or_else(|| heading(&header).unit).as_deref().and_then(unit_named);
        let value = |cell: &&str| own.map_or(number(cell, signs), |own| number_in(own, cell, signs));
        let numbers: Vec<f64> = given.iter().filter_map(value).collect();
        let digits = || Form::of_digits(given.iter().copied()).filter(|_| rank(&heading(&header).name).is_some());
        let kind = if let Some(form) = digits() {
            Kind::Stamp(form)
        } else if given.is_empty() {
            // what has a name may have samples later
            let nameless = layout.header.get(at).is_none_or(String::is_empty);
            if nameless { Kind::Empty } else { Kind::Number }
        } else if 2 * numbers.len() >= given.len() {
            // a text among numbers is an error with its place
            Kind::Number
        } else {
            Form::of(given.iter().copied()).map_or(Kind::Text, Kind::Stamp)
        };
        Seen { header, unit, kind, sample: numbers }
    };
    (0..width).map(column).collect()
}

/// The unit that stands apart from a column's name: in a line of units, else, where the name has
/// none, in its cells.
fn unit_stated(layout: &Layout, at: usize, header: &str, given: &[&str]) -> Option<String> {
    let in_line = layout.units.get(at).filter(|unit| !unit.trim().is_empty());
    let signs = layout.dialect.signs;
    let in_cells = || given.iter().find_map(|cell| quantity(cell, signs)).map(|stated| stated.unit.to_owned());
    in_line.cloned().or_else(|| if heading(header).unit.is_some() { None } else { in_cells() })
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

/// Lines that are no rows.
#[derive(Default)]
struct Others {
    /// The first line behind the last row, and why it is not a row.
    footer: Option<(u64, RecordingError)>,
    /// Lines between rows that have no time.
    skipped: Vec<u64>,
    /// Text of the first of them, and why it is no row.
    first: Option<(String, RecordingError)>,
}

/// Takes a row and the line on which it stands; the cells are those of that line.
type Push<'p> = dyn FnMut(&Cells<'_>, u64, &[f64]) -> Result<(), RecordingError> + 'p;

/// Gives every row to `push`, with its line. A line without a time is skipped, what follows the
/// last row is the footer.
fn each_row(
    file: &str,
    lines: &mut Lines<impl BufRead>,
    first_line: u64,
    cells: &mut Cells<'_>,
    push: &mut Push<'_>,
) -> Result<Others, RecordingError> {
    let (mut row, mut rows) = (Vec::new(), 0);
    let mut others = Others::default();
    while lines.next(file, rows)? {
        if lines.line < first_line || is_remark(&lines.text) {
            continue;
        }
        let result = match cells.read(&lines.text, lines.line, &mut row) {
            Ok(false) => continue,
            Err(error) if cells.is_short() || cells.is_without_time() => {
                others.add(lines, cells, error);
                continue;
            }
            Err(error) => Err(error),
            Ok(true) => others.row_follows().and_then(|()| push(cells, lines.line, &row)),
        };
        if let Err(error) = result {
            return Err(lines.corruption(file).unwrap_or(error));
        }
        rows += 1;
    }
    others.are_few(rows)
}

impl Others {
    fn add(&mut self, lines: &Lines<impl BufRead>, cells: &Cells<'_>, error: RecordingError) {
        if self.footer.is_none() && cells.is_without_time() && !cells.is_of_names() {
            self.skipped.push(lines.line);
            self.first.get_or_insert((printable(&text_of(&lines.text)), error));
        } else {
            self.footer.get_or_insert((lines.line, error));
        }
    }

    /// Behind what is no row and no remark no row can follow.
    fn row_follows(&mut self) -> Result<(), RecordingError> {
        self.footer.take().map_or(Ok(()), |(_, error)| Err(error))
    }

    /// Lines between the rows are few, or the file is something else than a table.
    fn are_few(mut self, rows: usize) -> Result<Self, RecordingError> {
        if 10 * self.skipped.len() > rows + 20 {
            let first = self.first.take().map(|(_, error)| error);
            return first.map_or(Ok(self), Err);
        }
        Ok(self)
    }
}

fn clock_position(plan: &Plan) -> usize {
    match &plan.clock {
        Clock::Number { at, .. } => *at,
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
    matches!(line.trim_ascii_start().first(), Some(b'#' | b'%'))
}

fn notes_of(cells: &Cells<'_>, plan: &Plan, others: Others, rows: usize) -> Result<Vec<String>, RecordingError> {
    let mut notes = Vec::new();
    // the day of a count that begins with the recording is none
    let has_day = matches!(&plan.clock, Clock::Stamps(parts) if parts.iter().any(|(_, form)| form.has_day()));
    if let Some(day) = cells.first_day().filter(|day| has_day || !day.starts_with("1970-01")) {
        notes.push(format!("time counts from {day}T00:00:00"));
    }
    notes.extend(origin_note(cells.origin_s()));
    notes.extend(plan.columns.iter().zip(&cells.counts).flat_map(|(of, counts)| notes_of_cells(&of.name, counts)));
    let Others { footer, skipped, first } = others;
    let (footer, skipped) = (footer.map(|(line, error)| (line, Some(error))), skipped);
    if rows < 2 {
        if let Some(error) = first.map(|(_, error)| error).or(footer.and_then(|(_, error)| error)) {
            return Err(error);
        }
        return Ok(notes);
    }
    if let (Some(line), Some((text, _))) = (skipped.first(), first) {
        notes
            .push(format!("{} line(s) without a time are left out, the first is line {line}: `{text}`", skipped.len()));
    }
    if let Some((line, _)) = footer {
        notes.push(format!("from line {line} on there are no whole rows: left out"));
    }
    Ok(notes)
}

/// What is to be noted of the cells of a column that are not plain numbers.
fn notes_of_cells(name: &str, counts: &Counts) -> Vec<String> {
    let mut notes = Vec::new();
    if counts.infinite > 0 {
        notes.push(format!("{} cell(s) of `{name}` are infinite: no sample", counts.infinite));
    }
    if let (Some(RecordingError::NotANumber { place, value }), true) = (&counts.first_text, counts.is_of_numbers()) {
        let (count, line) = (counts.texts, place.line);
        notes.push(format!("{count} cell(s) of `{name}` are no numbers: no sample (line {line}: `{value}`)"));
    }
    if let Some((line, text)) = &counts.first_marked {
        let count = counts.marked;
        notes.push(format!(
            "{count} cell(s) of `{name}` are read without the mark behind the number (line {line}: `{text}`)"
        ));
    }
    if counts.in_parentheses > 0 {
        notes.push(format!("{} number(s) of `{name}` in parentheses are read as negative", counts.in_parentheses));
    }
    notes
}
