//! What a text file begins with: where header, units and remarks end and rows begin.
//!
//! The separator is the one under which most cells of most lines are numbers or stamps, and fewest
//! are pieces of them. The first row is the first line whose cells are numbers wherever those of
//! the later lines are, or the first of the lines right above it that begin as a row does; what is
//! above it is header, units and remarks.

use super::beside::beside;
use super::dialect::{COLUMNS, Dialect, filled, is_missing, is_of_remarks, is_remark, label};
use super::groups::groups;
use super::header::{Above, are_names_with_clock};
use super::interval::{Interval, stated_interval};
use super::motion_capture::motion_capture;
use super::number::number;
use super::seen::Layout;
use super::signs::{Evidences, Signs};
use super::stamps::Form;
use super::trajectories::trajectories;

const SEPARATORS: [u8; 5] = [b',', b';', b'\t', b'|', b' '];

/// What is seen of the lines `ahead`; `None` where no separator gives a line of values.
pub(crate) fn layout(ahead: &[(u64, String)]) -> Option<Layout> {
    let known = beside(ahead).or_else(|| motion_capture(ahead)).or_else(|| trajectories(ahead));
    if let Some(layout) = known.or_else(|| groups(ahead)) {
        return Some(layout);
    }
    let mut best: Option<(f64, Dialect, Option<String>)> = None;
    for separator in SEPARATORS {
        for (score, dialect, note) in readings(ahead, separator) {
            if score > best.as_ref().map_or(0.0, |(most, ..)| *most) {
                best = Some((score, dialect, note));
            }
        }
    }
    let (_, dialect, note) = best?;
    let dialect = if dialect.separator == b' ' { by_columns(ahead, dialect).unwrap_or(dialect) } else { dialect };
    let mut layout = laid_out(ahead, dialect)?;
    if let Some(names) = labels(ahead, dialect).filter(|_| dialect.labelled) {
        without_cut_line(&mut layout, ahead, names);
    }
    layout.notes.extend(note);
    Some(layout)
}

/// Name of the stamps before rows whose cells begin with their names.
const STAMPED: &str = "time";

/// The lines that tell a dialect: the last of those that are looked at.
const TELLING: usize = 60;

/// The dialects with a separator, what they make of the lines, and what is to be noted of them.
fn readings(ahead: &[(u64, String)], separator: u8) -> Vec<(f64, Dialect, Option<String>)> {
    let plain = Dialect { separator, signs: POINT, labelled: false };
    let labelled = labels(ahead, plain).is_some();
    let of = |decimal_comma| Dialect { signs: Signs { decimal_comma, grouped: false }, labelled, ..plain };
    let lines: Vec<Vec<String>> =
        ahead.iter().filter(|(_, text)| !is_remark(text)).map(|(_, text)| of(false).split_quoted(text)).collect();
    let last = &lines[lines.len().saturating_sub(TELLING)..];
    let width = usual(last.iter().map(Vec::len));
    let evidences = Evidences::of(&number_columns(&lines, last, width));
    let commas =
        [false, true].into_iter().filter(|comma| !comma || separator != b',' || evidences.has_decimal_commas());
    let reading = |comma| {
        let dialect = Dialect { signs: evidences.signs(comma), ..of(comma) };
        (score(last, width, dialect), dialect, evidences.note(dialect.signs, separator))
    };
    commas.map(reading).collect()
}

/// The names with which the cells of the last lines begin: a number behind each, no name twice, and
/// the same in every line.
fn labels(ahead: &[(u64, String)], dialect: Dialect) -> Option<Vec<String>> {
    let dialect = Dialect { labelled: false, ..dialect };
    let last = &ahead[ahead.len().saturating_sub(TELLING)..];
    let names_of = |(_, text): &(u64, String)| -> Option<Vec<String>> {
        let cells = dialect.split_quoted(text);
        let cells = cells.iter().filter(|cell| !cell.is_empty()).enumerate();
        let name_of = |(k, cell): (usize, &String)| match label(cell) {
            Some((name, value)) if dialect.is_value(value) => Some(name.to_owned()),
            // what a terminal writes before the line
            None if k == 0 && cell.contains(':') && Form::is_of(cell) => Some(STAMPED.to_owned()),
            _ => None,
        };
        cells.map(name_of).collect()
    };
    // the first line may be one that was cut
    let names = names_of(last.last()?).filter(|names| names.len() > 1 && last.len() > 2)?;
    let unlike = last.iter().filter(|line| names_of(line).as_ref() != Some(&names)).count();
    let are_distinct = names.iter().enumerate().all(|(k, name)| !names[..k].contains(name));
    (are_distinct && unlike <= 1).then_some(names)
}

/// Rows whose cells begin with these names, without a first line that was cut.
fn without_cut_line(layout: &mut Layout, ahead: &[(u64, String)], names: Vec<String>) {
    let whole = |(_, text): &&(u64, String)| layout.dialect.split_quoted(text).len() == names.len();
    if let Some((line, _)) = ahead.iter().find(whole).filter(|(line, _)| *line > layout.first_line) {
        layout.notes.push(format!("line {} is cut: left out", layout.first_line));
        layout.first_line = *line;
    }
    layout.rows.retain(|cells| cells.len() == names.len());
    layout.header = names;
}

/// The dialect whose cells stand in columns and may have blanks within, `5 Mar 2024 15:00:00.000`:
/// every cell is a value then, but not where every blank divides, or the names are as many as such
/// cells alone.
fn by_columns(ahead: &[(u64, String)], by_blanks: Dialect) -> Option<Dialect> {
    let dialect = Dialect { separator: COLUMNS, ..by_blanks };
    let lines: Vec<&str> = ahead.iter().filter(|(_, text)| !is_remark(text)).map(|(_, text)| text.as_str()).collect();
    let last = &lines[lines.len().saturating_sub(TELLING).max(lines.len().min(1))..];
    let width = |dialect: Dialect| usual(last.iter().map(|text| dialect.split(text).len()));
    let whole = |dialect: Dialect| {
        let alike = |text: &&&str| dialect.split(text).len() == width(dialect);
        let is_value = |cell: &str| dialect.is_value(cell) || is_missing(cell);
        last.iter().all(|text| alike(&text) && dialect.split(text).into_iter().all(is_value))
    };
    let (columns, blanks) = (width(dialect), width(by_blanks));
    if columns < 2 || columns == blanks || !whole(dialect) {
        return None;
    }
    let named = |dialect: Dialect, width: usize| lines.first().is_some_and(|text| dialect.split(text).len() == width);
    (!whole(by_blanks) || (named(dialect, columns) && !named(by_blanks, blanks))).then_some(dialect)
}

/// The cells by column of the lines that have as many numbers as the last ones: a preamble has
/// fewer.
fn number_columns<'a>(lines: &'a [Vec<String>], last: &[Vec<String>], width: usize) -> Vec<Vec<&'a str>> {
    let numbers = |cells: &Vec<String>| {
        cells
            .iter()
            .filter(|cell| {
                cell.trim_start_matches(['-', '+', '\u{2212}'])
                    .starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | ','))
            })
            .count()
    };
    let mut counts: Vec<usize> = last.iter().filter(|cells| cells.len() == width).map(numbers).collect();
    counts.sort_unstable();
    let most = counts.get(counts.len() / 2).copied().unwrap_or(0);
    let alike: Vec<&Vec<String>> =
        lines.iter().filter(|cells| cells.len() == width && numbers(cells) >= most).collect();
    (0..width).map(|column| alike.iter().map(|cells| cells[column].as_str()).collect()).collect()
}

/// Mean number of values in the lines that have the most usual number of cells, times their share
/// of the lines and the share of the cells that are values or empty.
fn score(lines: &[Vec<String>], width: usize, dialect: Dialect) -> f64 {
    let alike: Vec<&Vec<String>> = lines.iter().filter(|cells| cells.len() == width).collect();
    let (mut values, mut missing) = (0, 0);
    for cell in alike.iter().flat_map(|cells| cells.iter()) {
        if dialect.is_value(cell) {
            values += 1;
        } else if is_missing(cell) {
            missing += 1;
        }
    }
    let whole = (values + missing) as f64 / (alike.len() * width).max(1) as f64;
    values as f64 / lines.len().max(1) as f64 * whole
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
    let width = usual(split.iter().rev().take(TELLING).map(|(_, cells)| cells.len()));
    let valued = valued_columns(&split, dialect, width);
    let cell = |cells: &Vec<String>, column: usize| cells.get(column).cloned().unwrap_or_default();
    let is_row = |cells: &Vec<String>| {
        let fits = |column: &usize| {
            let cell = cell(cells, *column);
            dialect.is_value(&cell) || is_missing(&cell)
        };
        valued.iter().all(fits) && valued.iter().any(|column| dialect.is_value(&cell(cells, *column)))
    };
    // a cell without a number is one cell, not the end of the rows
    let begins_as_row = |cells: &Vec<String>| {
        cells.len() == width && valued.first().is_some_and(|column| dialect.is_value(&cells[*column]))
    };
    // a line of numbers within the preamble has a line of texts below it, one of rates states units
    let states_units =
        |cells: &[String]| valued.iter().all(|at| cells.get(*at).is_some_and(|cell| dialect.is_quantity(cell)));
    let units_throughout = split.last().is_some_and(|(_, cells)| states_units(cells));
    let goes_on = |at: usize| split.get(at + 1).is_none_or(|(_, cells)| is_row(cells) || begins_as_row(cells));
    let below_names = |at: usize| at > 0 && are_names_with_clock(&split[at - 1].1);
    let is_first = |at: &usize| {
        let cells = &split[*at].1;
        is_row(cells) && (goes_on(*at) || below_names(*at)) && (units_throughout || !states_units(cells))
    };
    let whole = (0..split.len()).find(is_first).or_else(|| split.iter().position(|(_, cells)| is_row(cells)))?;
    let begins = |cells: &Vec<String>| begins_as_row(cells) && (units_throughout || !states_units(cells));
    let begun = split[..whole].iter().rev().take_while(|(_, cells)| begins(cells)).count();
    let first = split[whole - begun].0;
    let rows: Vec<Vec<String>> =
        split[whole..].iter().filter(|(_, cells)| is_row(cells)).map(|(_, cells)| cells.clone()).collect();
    let above = &ahead[..first];
    let interval = stated_interval(above, dialect);
    // a program may write the time between two rows beside the names
    let filled = rows.iter().map(|cells| filled(cells)).max().unwrap_or(width);
    let beside = interval.as_ref().is_some_and(|stated| stated.at >= filled);
    let above = if beside { Above::within(above, dialect, filled) } else { Above::of(above, dialect, width) };
    Some(with_header(above, interval, dialect, ahead[first].0, rows))
}

/// The columns whose cells are values in most of the last lines: what lies above the rows is no
/// part of these.
fn valued_columns(split: &[(usize, Vec<String>)], dialect: Dialect, width: usize) -> Vec<usize> {
    let later = (split.len().div_ceil(2)).min(TELLING);
    let alike: Vec<&Vec<String>> =
        split.iter().rev().take(later).map(|(_, cells)| cells).filter(|cells| cells.len() == width).collect();
    let fits = |cell: &str| dialect.is_value(cell) || is_missing(cell);
    let is_valued = |column: &usize| 2 * alike.iter().filter(|cells| fits(&cells[*column])).count() >= alike.len();
    if alike.is_empty() { Vec::new() } else { (0..width).filter(is_valued).collect() }
}

fn with_header(
    above: Above,
    interval: Option<Interval>,
    dialect: Dialect,
    first_line: u64,
    rows: Vec<Vec<String>>,
) -> Layout {
    let header_line = above.names.as_ref().map_or(first_line, |(line, _)| *line);
    let mut header = above.names.map(|(_, cells)| cells).unwrap_or_default();
    let mut units = above.units;
    // a column of remarks of which there are none has no cells
    let widest = rows.iter().map(Vec::len).max().unwrap_or(0);
    if header.len() == widest + 1 && header.last().is_some_and(|name| is_of_remarks(name)) {
        header.pop();
    }
    if header.len() + 1 == widest && begins_with_row_names(&rows) {
        if units.len() == header.len() {
            units.insert(0, String::new());
        }
        header.insert(0, String::new());
    }
    let (remarks, notes) = (above.remarks, above.notes);
    Layout { dialect, header_line, header, units, first_line, rows, remarks, interval, notes }
}

/// Signs of a whole number.
const POINT: Signs = Signs { decimal_comma: false, grouped: false };

/// Whether a row begins with its name or its number from 1, for which R writes no header.
fn begins_with_row_names(rows: &[Vec<String>]) -> bool {
    let lead = |row: &Vec<String>| row.first().and_then(|cell| number(cell, POINT));
    rows.len() > 1 && rows.iter().enumerate().all(|(k, row)| lead(row).is_none_or(|number| number == (k + 1) as f64))
}
