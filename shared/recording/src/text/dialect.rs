//! How a text file divides its rows: separator, decimal sign, where the header stands.
//!
//! The separator is the one under which most cells of most lines are numbers or stamps. The first
//! row is the first line whose cells are numbers wherever those of the later lines are; what stands
//! above it is header, units and remarks.

use super::encoding::text_of;
use super::header::Above;
use super::quantity::quantity;
use super::stamps::Form;

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

/// The number that a cell states; of a truth value 1 or 0.
pub(crate) fn number(cell: &str, decimal_comma: bool) -> Option<f64> {
    // an apostrophe makes a number a text to a spreadsheet
    let cell = cell.trim().trim_matches('\'');
    let unsigned = cell.strip_prefix(['-', '+']).unwrap_or(cell);
    // not `inf`, `nan`, `-inf`, which the parser takes
    if !unsigned.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | ',')) {
        return truth(cell);
    }
    if let Ok(number) = cell.parse() {
        return Some(number);
    }
    let (point, group) = if decimal_comma { (',', '.') } else { ('.', ',') };
    if let Some(plain) = without_thousands(unsigned, point, group) {
        let sign = if cell.starts_with('-') { -1.0 } else { 1.0 };
        return plain.parse::<f64>().ok().map(|number| sign * number);
    }
    if decimal_comma && cell.contains(',') && !cell.contains('.') {
        return cell.replacen(',', ".", 1).parse().ok();
    }
    // Fortran's double precision
    let plain = cell.contains(['D', 'd']).then(|| cell.replace(['D', 'd'], "e"))?;
    plain.parse().ok()
}

fn truth(cell: &str) -> Option<f64> {
    let is = |word| cell.eq_ignore_ascii_case(word);
    if is("true") { Some(1.0) } else { is("false").then_some(0.0) }
}

/// A number whose thousands are divided by `group` or an apostrophe, with a decimal point. One
/// `group` without a point may be a decimal sign: that gives no number.
fn without_thousands(unsigned: &str, point: char, group: char) -> Option<String> {
    let (whole, part) = unsigned.split_once(point).unwrap_or((unsigned, ""));
    let divides = |c: char| c == group || matches!(c, '\'' | '’' | '\u{a0}' | '\u{202f}');
    let sign = whole.chars().find(|c| divides(*c))?;
    let groups: Vec<&str> = whole.split(sign).collect();
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let first = (1..=3).contains(&groups[0].len()) && digits(groups[0]) && !groups[0].starts_with('0');
    let others = groups[1..].iter().all(|group| group.len() == 3 && digits(group));
    let certain = sign != group || groups.len() > 2 || !part.is_empty();
    (first && others && digits(part) && certain).then(|| format!("{}.{part}", groups.concat()))
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
            || quantity(cell, self.decimal_comma).is_some()
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
    let header_line = above.names.as_ref().map_or(ahead[*first].0, |(line, _)| *line);
    let mut header = above.names.map(|(_, cells)| cells).unwrap_or_default();
    // a column of remarks of which there are none has no cells
    let widest = rows.iter().map(Vec::len).max().unwrap_or(0);
    if header.len() == widest + 1 && header.last().is_some_and(|name| is_of_remarks(name)) {
        header.pop();
    }
    if header.len() + 1 == widest && begins_with_row_names(&rows) {
        header.insert(0, String::new());
    }
    let (units, first_line, remarks) = (above.units, ahead[*first].0, above.remarks);
    Some(Layout { dialect, header_line, header, units, first_line, rows, remarks })
}

/// Whether a row begins with its name or its number from 1, for which R writes no header.
fn begins_with_row_names(rows: &[Vec<String>]) -> bool {
    let lead = |row: &Vec<String>| row.first().and_then(|cell| number(cell, false));
    rows.len() > 1 && rows.iter().enumerate().all(|(k, row)| lead(row).is_none_or(|number| number == (k + 1) as f64))
}

/// A column for what an operator writes beside a row.
fn is_of_remarks(name: &str) -> bool {
    matches!(name.trim().to_lowercase().as_str(), "comment" | "comments" | "remark" | "remarks" | "kommentar" | "note")
}
