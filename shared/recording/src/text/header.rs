//! The lines above the rows of a text file: names, descriptions, units, remarks.
//!
//! The line of the names is the nearest that names a clock, else the nearest at all. A line of
//! units stands below the names, or anywhere behind a word for units. Either may be divided
//! otherwise than the rows are: `# t, w, u` above rows with blanks, `time [s]  torque [N m]`.

use super::dialect::{Dialect, is_remark};
use crate::intake::clock::rank;
use crate::intake::names::heading;
use crate::units::unit_named;

/// The lines above the first row.
pub(super) struct Above {
    /// Line and cells of the names.
    pub names: Option<(u64, Vec<String>)>,
    /// Cells of the line of units; empty where there is none.
    pub units: Vec<String>,
    /// Lines that are neither, and are not marked as remarks.
    pub remarks: usize,
}

/// A line above the rows, as cells.
type Line = (u64, Vec<String>);

impl Above {
    /// Of `lines` above rows with `width` cells.
    pub fn of(lines: &[(u64, String)], dialect: Dialect, width: usize) -> Self {
        let mut candidates = candidates(lines, width, |text| own_cells(text, dialect, width));
        if candidates.is_empty() {
            candidates = self::candidates(lines, width, |text| other_cells(text, dialect.separator, width));
        }
        let unmarked = lines.iter().filter(|(_, text)| !is_remark(text)).count();
        let units_at = (0..candidates.len()).rev().find(|at| are_units(&candidates, *at));
        let units = units_at.map(|at| stated_units(&candidates[at].1, width)).unwrap_or_default();
        let names = match units_at {
            Some(at) => {
                let mut below = candidates.split_off(at + 1);
                candidates.truncate(at);
                let clock = below.iter().rposition(names_a_clock).map(|at| below.swap_remove(at));
                clock.or_else(|| best_named(candidates)).or_else(|| below.pop())
            }
            None => {
                let at = candidates.iter().rposition(names_a_clock).or(candidates.len().checked_sub(1));
                at.map(|at| candidates.swap_remove(at))
            }
        };
        let used = usize::from(names.is_some()) + usize::from(!units.is_empty());
        Above { names, units, remarks: unmarked.saturating_sub(used) }
    }
}

/// The lines whose cells can stand above rows of `width` cells: with a trailing separator, or a
/// name less for a column without one.
fn candidates(lines: &[(u64, String)], width: usize, cells: impl Fn(&str) -> Vec<String>) -> Vec<Line> {
    let fits = |cells: &Vec<String>| {
        let named = cells.iter().filter(|cell| !cell.is_empty()).count();
        cells.len() <= width + 1 && cells.len() + 1 >= width && named > 0 && (named > 1 || width <= 2)
    };
    lines.iter().map(|(line, text)| (*line, cells(unmarked(text)))).filter(|(_, cells)| fits(cells)).collect()
}

/// A line without the mark of a remark.
fn unmarked(text: &str) -> &str {
    let text = text.trim_start().trim_start_matches('\u{feff}');
    if is_remark(text) { text.trim_start_matches(['#', '%']).trim_start() } else { text }
}

/// The cells of a line that is divided as the rows are. A blank divides no bracket, and no unit in
/// a bracket from its name; where it divides the rows, the names may be divided by more.
fn own_cells(text: &str, dialect: Dialect, width: usize) -> Vec<String> {
    if dialect.separator != b' ' {
        return dialect.split_quoted(text);
    }
    let words = words(text);
    let divided = |cells: &[String]| !cells.iter().any(|cell| cell.ends_with([',', ';', '|']));
    if words.len() == width && divided(&words) {
        return words;
    }
    let other = other_cells(text, b' ', width);
    if other.len() == width { other } else { words }
}

/// The cells of a line that is not divided by `separator` as the rows are: by what gives `width` of
/// them.
fn other_cells(text: &str, separator: u8, width: usize) -> Vec<String> {
    let others = [b',', b';', b'\t', b'|'].into_iter().filter(|other| *other != separator);
    let split = |separator| Dialect { separator, decimal_comma: false }.split_quoted(text);
    let by_blanks = || [words(text), with_units(words(text)), columns(text)].into_iter();
    let full = |cells: &Vec<String>| cells.len() == width && cells.iter().all(|cell| !cell.is_empty());
    others.map(split).chain(by_blanks()).find(full).unwrap_or_default()
}

/// Words between blanks; what is in brackets is one.
fn words(text: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut open = 0_usize;
    for word in text.split_whitespace() {
        match words.last_mut().filter(|_| open > 0) {
            Some(last) => last.extend([" ", word]),
            None => words.push(word.to_owned()),
        }
        let count = |of: [char; 2]| word.matches(of).count();
        open = (open + count(['[', '('])).saturating_sub(count([']', ')']));
    }
    words
}

/// Words with the units in brackets that follow them: `omega [rad/s]`.
fn with_units(words: Vec<String>) -> Vec<String> {
    let mut joined: Vec<String> = Vec::new();
    for word in words {
        match joined.last_mut().filter(|last| word.starts_with(['[', '(']) && !last.ends_with([']', ')'])) {
            Some(last) => last.extend([" ", &word]),
            None => joined.push(word),
        }
    }
    joined
}

/// Cells between runs of two blanks or more.
fn columns(text: &str) -> Vec<String> {
    text.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).map(str::to_owned).collect()
}

fn names_a_clock((_, cells): &Line) -> bool {
    cells.iter().any(|cell| rank(&heading(cell).name).is_some())
}

/// Of the lines above one of units that of the names: the one with the best name of a clock, of
/// equals the nearest. Loggers write names, descriptions and units, in this order.
fn best_named(lines: Vec<Line>) -> Option<Line> {
    let clock = |cells: &[String]| cells.iter().filter_map(|cell| rank(&heading(cell).name)).min().unwrap_or(u8::MAX);
    lines.into_iter().rev().min_by_key(|(_, cells)| clock(cells))
}

/// Whether a line is one of units: half of its cells are units that are known, and more than of the
/// line above it. A unit that is not known costs its own column alone. Without a line above it a
/// word for units leads it.
fn are_units(lines: &[Line], at: usize) -> bool {
    let cells = &lines[at].1;
    let labelled = cells.first().is_some_and(|cell| label(cell).is_some());
    let of_above = at.checked_sub(1).map(|above| known(&lines[above].1));
    let stated = cells.iter().map(|cell| without_label(cell)).filter(|cell| !cell.trim().is_empty()).count();
    let units = known(cells);
    units > 0 && 2 * units >= stated && (labelled || of_above.is_some_and(|above| units > above))
}

/// How many cells are units that are known.
fn known(cells: &[String]) -> usize {
    let cells = cells.iter().map(|cell| without_label(cell)).filter(|cell| !cell.trim().is_empty());
    cells.filter(|cell| unit_named(cell).is_some()).count()
}

/// The units of the columns, without the word that leads them: it is a cell of its own before them
/// or in the place of the first, or stands before the first with a colon.
fn stated_units(cells: &[String], width: usize) -> Vec<String> {
    let own_cell = cells.len() > width && cells.first().is_some_and(|cell| label(cell) == Some(""));
    cells[usize::from(own_cell)..].iter().map(|cell| without_label(cell).to_owned()).collect()
}

fn without_label(cell: &str) -> &str {
    label(cell).unwrap_or(cell)
}

/// What follows a word for units at the beginning of a cell: `unit`, `Units: s`, `Y_Unit_Label`.
fn label(cell: &str) -> Option<&str> {
    let (word, rest) = cell.split_once([':', '=']).unwrap_or((cell, ""));
    let letters = |c: char| if c.is_alphabetic() { c.to_ascii_lowercase() } else { ' ' };
    let word: String = word.chars().map(letters).collect();
    let is_word = |word: &str| matches!(word, "unit" | "units" | "einheit" | "einheiten" | "unité" | "unités");
    word.split_whitespace().any(is_word).then_some(rest.trim())
}
