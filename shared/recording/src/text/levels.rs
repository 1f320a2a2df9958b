//! Names in several rows, one above the other, as tables of several levels have them.
//!
//! A program writes such a table with the levels' own names, or nothing, in the first column, and
//! the name of the index in a line of its own below the levels. A spreadsheet has the groups above
//! the names: the upper row then repeats its texts, and the lower one has nothing below the clock.
//! The lowest row has the names where it repeats none, else all rows have them together.

use super::units_lines::{is_bare, is_unit};
use crate::intake::clock::rank;
use crate::intake::names::heading;

/// The names of the columns, and the cells of a level of units.
pub(super) struct Levels {
    pub line: u64,
    pub names: Vec<String>,
    pub units: Vec<String>,
    pub note: &'static str,
}

/// The lines above the rows as names in levels; `None` where they are anything else.
pub(super) fn levels(lines: &[(u64, Vec<String>)], width: usize) -> Option<Levels> {
    by_index(lines, width).or_else(|| by_groups(lines, width))
}

fn is_clock(cell: &str) -> bool {
    rank(&heading(cell).name).is_some()
}

fn are_texts(cells: &[String]) -> bool {
    cells.iter().all(|cell| !is_bare(cell))
}

/// Levels above a line that names the index alone.
fn by_index(lines: &[(u64, Vec<String>)], width: usize) -> Option<Levels> {
    let ((_, index), above) = lines.split_last()?;
    let is_index = index.len() == width && width > 1 && is_clock(&index[0]) && index[1..].iter().all(String::is_empty);
    if !is_index {
        return None;
    }
    let is_level = |(_, cells): &&(u64, Vec<String>)| cells.len() == width && !cells[1..].iter().all(|c| is_bare(c));
    let count = above.iter().rev().take_while(is_level).count();
    let levels = &above[above.len() - count..];
    let are_units = |cells: &[String]| cells[1..].iter().all(|cell| is_bare(cell) || is_unit(cell));
    let (units, named): (Vec<_>, Vec<_>) = levels.iter().partition(|(_, cells)| are_units(cells));
    let (line, _) = named.first()?;
    let units = units.first().map_or_else(Vec::new, |(_, cells)| without_first(cells));
    let rows: Vec<&[String]> = named.iter().map(|(_, cells)| cells.as_slice()).collect();
    (named.len() > 1).then(|| of_rows(*line, &rows, &index[0], units))
}

/// A row with the clock and repeated groups, above one of names with nothing below the clock.
fn by_groups(lines: &[(u64, Vec<String>)], width: usize) -> Option<Levels> {
    let at = lines.windows(2).position(|pair| {
        let (groups, names) = (&pair[0].1, &pair[1].1);
        groups.len() == width
            && names.len() == width
            && width > 2
            && is_clock(&groups[0])
            && names[0].is_empty()
            && are_texts(&groups[1..])
            && are_texts(&names[1..])
            && repeat(&groups[1..])
            && !names[1..].iter().any(|name| is_unit(name) || name.contains(':'))
    })?;
    let pair = [lines[at].1.as_slice(), lines[at + 1].1.as_slice()];
    let below = lines.get(at + 2).map(|(_, cells)| cells);
    let units = below.filter(|cells| cells.len() == width && cells[1..].iter().any(|cell| is_unit(cell)));
    Some(of_rows(lines[at].0, &pair, &pair[0][0], units.cloned().unwrap_or_default()))
}

fn repeat(cells: &[String]) -> bool {
    (1..cells.len()).any(|at| cells[..at].contains(&cells[at]))
}

/// Names of the rows of them, the lowest last.
fn of_rows(line: u64, rows: &[&[String]], clock: &str, units: Vec<String>) -> Levels {
    let lowest = rows[rows.len() - 1];
    if !repeat(&lowest[1..]) {
        let mut names = lowest.to_vec();
        names[0] = clock.to_owned();
        return Levels { line, names, units, note: "of several rows of names the lowest is taken: it repeats none" };
    }
    Levels { line, names: joined(rows, clock), units, note: "the names are joined of several rows above each other" }
}

/// The texts of a column above each other, but for those that repeat the one above.
fn joined(levels: &[&[String]], clock: &str) -> Vec<String> {
    let name = |at: usize| {
        let mut parts: Vec<&str> =
            levels.iter().map(|cells| cells[at].as_str()).filter(|part| !part.is_empty()).collect();
        parts.dedup();
        parts.join(".")
    };
    (0..levels[0].len()).map(|at| if at == 0 { clock.to_owned() } else { name(at) }).collect()
}

/// Cells without the name of the level in front of them.
fn without_first(cells: &[String]) -> Vec<String> {
    let mut cells = cells.to_vec();
    cells[0].clear();
    cells
}
