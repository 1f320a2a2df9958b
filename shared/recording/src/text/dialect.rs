//! How a text file divides its rows: separator, decimal sign, where the header stands.
//!
//! The separator is the one under which most cells of most lines are numbers or stamps. The first
//! row is the first line whose cells are numbers wherever those of the later lines are; what stands
//! above it is header, units and remarks.

use super::encoding::text_of;
use super::stamps::Form;
use crate::intake::clock::rank;
use crate::intake::names::heading;
use crate::units::unit_named;

/// Separator and decimal sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Dialect {
    /// Blank stands for a run of blanks.
    pub separator: u8,
    pub decimal_comma: bool,
}

/// What was seen of a file before its first row was taken.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub dialect: Dialect,
    /// Texts of the header's cells; empty where the file has no header.
    pub header: Vec<String>,
    /// Texts of a line of units below the header.
    pub units: Vec<String>,
    /// Line of the header, else of the first row.
    pub header_line: u64,
    /// Line of the first row.
    pub first_line: u64,
    /// Cells of the rows that were seen, one inner vector a row.
    pub rows: Vec<Vec<String>>,
    /// Lines above the rows that are neither header nor units nor marked as remarks.
    pub remarks: usize,
}

const SEPARATORS: [u8; 5] = [b',', b';', b'\t', b'|', b' '];

/// Cells that say that there is no sample.
pub(crate) fn is_missing(cell: &str) -> bool {
    // `#N/A`, `#DIV/0!`, `#VALUE!`: a spreadsheet's errors
    cell.trim_start().starts_with('#') && cell.trim_end().ends_with(['!', '?', 'A'])
        || matches!(
            cell.trim().to_ascii_lowercase().as_str(),
            "" | "nan"
                | "-nan"
                | "+nan"
                | "nan(ind)"
                | "-nan(ind)"
                | "1.#qnan"
                | "-1.#ind"
                | "null"
                | "none"
                | "na"
                | "n/a"
                | "nil"
                | "-"
                | "--"
                | "inf"
                | "+inf"
                | "-inf"
                | "infinity"
                | "-infinity"
                | "1.#inf"
                | "-1.#inf"
        )
}

/// The number that a cell states.
pub(crate) fn number(cell: &str, decimal_comma: bool) -> Option<f64> {
    let cell = cell.trim();
    let unsigned = cell.strip_prefix(['-', '+']).unwrap_or(cell);
    // not `inf`, `nan`, `-inf`, which the parser takes
    if !unsigned.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | ',')) {
        return None;
    }
    if let Ok(number) = cell.parse() {
        return Some(number);
    }
    if decimal_comma && cell.contains(',') && !cell.contains('.') {
        return cell.replacen(',', ".", 1).parse().ok();
    }
    // Fortran's double precision
    let plain = cell.contains(['D', 'd']).then(|| cell.replace(['D', 'd'], "e"))?;
    plain.parse().ok()
}

impl Dialect {
    /// The cells of a line.
    pub fn split<'a>(&self, text: &'a str) -> Vec<&'a str> {
        match self.separator {
            b' ' => text.split_ascii_whitespace().collect(),
            separator => text.split(char::from(separator)).map(str::trim).collect(),
        }
    }

    /// The cells of a line with quotes, or without.
    pub fn split_quoted(&self, text: &str) -> Vec<String> {
        if !text.contains('"') {
            return self.split(text).into_iter().map(str::to_owned).collect();
        }
        let mut builder = ::csv::ReaderBuilder::new();
        let builder = builder.has_headers(false).flexible(true).trim(::csv::Trim::All).delimiter(self.separator);
        let mut record = ::csv::ByteRecord::new();
        match builder.from_reader(text.as_bytes()).read_byte_record(&mut record) {
            Ok(true) => record.iter().map(text_of).collect(),
            _ => Vec::new(),
        }
    }

    fn is_value(&self, cell: &str) -> bool {
        number(cell, self.decimal_comma).is_some()
            || (cell.contains([':', '-', '/']) && Form::of([cell].into_iter()).is_some())
    }
}

/// Whether a line is a remark of the program that wrote it.
pub(crate) fn is_remark(text: &str) -> bool {
    text.trim_start().starts_with(['#', '%'])
}

/// What is seen of the lines `ahead`; `None` where no separator gives a line of values.
pub(crate) fn layout(ahead: &[(u64, String)]) -> Option<Layout> {
    let mut best: Option<(f64, Dialect)> = None;
    for separator in SEPARATORS {
        for decimal_comma in [false, true] {
            if decimal_comma && separator == b',' && !has_decimals_in_quotes(ahead) {
                continue;
            }
            let dialect = Dialect { separator, decimal_comma };
            let score = score(ahead, dialect);
            if score > best.map_or(0.0, |(most, _)| most) {
                best = Some((score, dialect));
            }
        }
    }
    best.and_then(|(_, dialect)| laid_out(ahead, dialect))
}

/// Cells in quotes with a comma that divides no thousands: `"0,01"`.
fn has_decimals_in_quotes(ahead: &[(u64, String)]) -> bool {
    let decimal = |cell: &str| {
        let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        let parts = cell.split_once(',');
        parts.is_some_and(|(whole, part)| digits(whole.trim_start_matches('-')) && digits(part) && part.len() != 3)
    };
    ahead.iter().rev().take(60).any(|(_, text)| text.split('"').skip(1).step_by(2).any(decimal))
}

/// Mean number of values in the lines that have the most usual number of cells, times their share.
fn score(ahead: &[(u64, String)], dialect: Dialect) -> f64 {
    let lines: Vec<Vec<String>> = ahead
        .iter()
        .rev()
        .take(60)
        .filter(|(_, text)| !is_remark(text))
        .map(|(_, text)| dialect.split_quoted(text))
        .collect();
    let width = usual(lines.iter().map(Vec::len));
    let alike: Vec<&Vec<String>> = lines.iter().filter(|cells| cells.len() == width).collect();
    let values: usize = alike.iter().map(|cells| cells.iter().filter(|cell| dialect.is_value(cell)).count()).sum();
    values as f64 / lines.len().max(1) as f64
}

fn usual(widths: impl Iterator<Item = usize> + Clone) -> usize {
    let count = |width: usize| widths.clone().filter(|other| *other == width).count();
    widths.clone().max_by_key(|width| (count(*width), *width)).unwrap_or(0)
}

fn laid_out(ahead: &[(u64, String)], dialect: Dialect) -> Option<Layout> {
    let split: Vec<(usize, Vec<String>)> = ahead
        .iter()
        .enumerate()
        .filter(|(_, (_, text))| !is_remark(text))
        .map(|(at, (_, text))| (at, dialect.split_quoted(text)))
        .collect();
    let width = usual(split.iter().rev().take(60).map(|(_, cells)| cells.len()));
    // the later half of the lines: what stands above the rows is no part of it
    let later = (split.len().div_ceil(2)).min(60);
    let alike = || split.iter().rev().take(later).filter(|(_, cells)| cells.len() == width);
    let share = |column: usize| {
        let values =
            alike().filter(|(_, cells)| dialect.is_value(&cells[column]) || is_missing(&cells[column])).count();
        values as f64 / alike().count().max(1) as f64
    };
    let valued: Vec<usize> = (0..width).filter(|column| share(*column) >= 0.5).collect();
    let is_row = |cells: &Vec<String>| {
        let cell = |column: &usize| cells.get(*column).map_or("", String::as_str);
        let fits = valued.iter().all(|column| dialect.is_value(cell(column)) || is_missing(cell(column)));
        fits && valued.iter().any(|column| dialect.is_value(cell(column)))
    };
    let (first, _) = split.iter().find(|(_, cells)| is_row(cells))?;
    let rows: Vec<Vec<String>> =
        split.iter().filter(|(at, cells)| at >= first && is_row(cells)).map(|(_, cells)| cells.clone()).collect();
    let above = Above::of(&ahead[..*first], dialect, width);
    let header_line = above.header.as_ref().map_or(ahead[*first].0, |(line, _)| *line);
    let mut header = above.header.map(|(_, cells)| cells).unwrap_or_default();
    // a column of remarks of which there are none has no cells
    let widest = rows.iter().map(Vec::len).max().unwrap_or(0);
    if header.len() == widest + 1 && header.last().is_some_and(|name| is_of_remarks(name)) {
        header.pop();
    }
    let (units, first_line, remarks) = (above.units, ahead[*first].0, above.remarks);
    Some(Layout { dialect, header_line, header, units, first_line, rows, remarks })
}

/// A column for what an operator writes beside a row.
fn is_of_remarks(name: &str) -> bool {
    matches!(name.trim().to_lowercase().as_str(), "comment" | "comments" | "remark" | "remarks" | "kommentar" | "note")
}

/// What stands above the first row.
struct Above {
    header: Option<(u64, Vec<String>)>,
    units: Vec<String>,
    remarks: usize,
}

impl Above {
    fn of(lines: &[(u64, String)], dialect: Dialect, width: usize) -> Self {
        // a trailing separator, or a name less for a column without one
        let fits = |cells: &Vec<String>| {
            let named = cells.iter().filter(|cell| !cell.is_empty()).count();
            cells.len() <= width + 1 && cells.len() + 1 >= width && named > 0 && (named > 1 || width <= 2)
        };
        let cells_of = |text: &str| {
            let marked = text.trim_start().trim_start_matches('\u{feff}');
            dialect.split_quoted(if is_remark(marked) {
                marked.trim_start_matches(['#', '%']).trim_start()
            } else {
                marked
            })
        };
        let mut candidates: Vec<(u64, Vec<String>)> =
            lines.iter().map(|(line, text)| (*line, cells_of(text))).filter(|(_, cells)| fits(cells)).collect();
        let unmarked = lines.iter().filter(|(_, text)| !is_remark(text)).count();
        let last = candidates.pop();
        let units_below =
            (last.as_ref().zip(candidates.last())).is_some_and(|((_, below), (_, names))| are_units(below, names));
        let (header, units) = if units_below {
            (named(candidates), last.map(|(_, cells)| cells).unwrap_or_default())
        } else {
            (last, Vec::new())
        };
        let used = usize::from(header.is_some()) + usize::from(!units.is_empty());
        Above { header, units, remarks: unmarked.saturating_sub(used) }
    }
}

/// Of the lines above one of units that of the names: the one with the best name of a clock, of
/// equals the nearest. Loggers write names, descriptions and units, in this order.
fn named(lines: Vec<(u64, Vec<String>)>) -> Option<(u64, Vec<String>)> {
    let clock = |cells: &[String]| cells.iter().filter_map(|cell| rank(&heading(cell).name)).min().unwrap_or(u8::MAX);
    lines.into_iter().rev().min_by_key(|(_, cells)| clock(cells))
}

/// A line is one of units: half of its cells are units that are known, and more than of the line
/// above it. A unit that is not known costs its own column alone.
fn are_units(below: &[String], above: &[String]) -> bool {
    let stated = |cells: &[String]| cells.iter().filter(|cell| !cell.trim().is_empty()).count();
    let known =
        |cells: &[String]| cells.iter().filter(|cell| !cell.trim().is_empty() && unit_named(cell).is_some()).count();
    let units = known(below);
    units > 0 && 2 * units >= stated(below) && units > known(above)
}
