//! The lines above the rows of a text file: names, descriptions, units, remarks.
//!
//! The line of the names is the nearest that names a clock, else the nearest at all. A line of
//! units stands below the names, or anywhere behind a word for units (`units_lines`). Either may be
//! divided otherwise than the rows are: `# t, w, u` above rows with blanks,
//! `time [s]  torque [N m]`.

use super::dialect::{COLUMNS, Dialect, is_remark};
use super::levels::{Levels, levels};
use super::stamps::Form;
use super::units_lines::{UnitsLine, is_bare, is_unit, labelled, matched, tabled};
use crate::intake::clock::rank;
use crate::intake::names::heading;

/// The lines above the first row.
pub(super) struct Above {
    /// Line and cells of the names.
    pub names: Option<(u64, Vec<String>)>,
    /// Cells of the line of units; empty where there is none.
    pub units: Vec<String>,
    /// Lines that are neither, and are not marked as remarks.
    pub remarks: usize,
    /// What was not used.
    pub notes: Vec<String>,
}

/// A line above the rows, as cells.
type Line = (u64, Vec<String>);

impl Above {
    /// Of `lines` above rows with `width` cells.
    pub fn of(lines: &[(u64, String)], dialect: Dialect, width: usize) -> Self {
        Above::with_cells(lines, dialect, width, |text| own_cells(without_mark(text, dialect), dialect, width))
    }

    /// Of `lines` above rows with `width` cells, without the cells beside the names.
    pub fn within(lines: &[(u64, String)], dialect: Dialect, width: usize) -> Self {
        let cells = |text: &str| own_cells(text, dialect, width).into_iter().take(width).collect();
        Above::with_cells(lines, dialect, width, cells)
    }

    fn with_cells(lines: &[(u64, String)], dialect: Dialect, width: usize, own: impl Fn(&str) -> Vec<String>) -> Self {
        let cells: Vec<Line> = lines.iter().map(|(line, text)| (*line, own(unmarked(text)))).collect();
        if let Some(Levels { line, names, units, note }) = levels(&cells, width) {
            let remarks = lines.iter().filter(|(other, text)| *other < line && !is_remark(text)).count();
            return Above { names: Some((line, names)), units, remarks, notes: vec![note.into()] };
        }
        let mut candidates = candidates(lines, width, &own);
        if candidates.is_empty() {
            candidates = self::candidates(lines, width, |text| other_cells(text, dialect, width));
        }
        let behind_a_word: Vec<UnitsLine> =
            lines.iter().filter_map(|(line, text)| labelled(*line, &own(unmarked(text)))).collect();
        let of_the_table = |(line, _): &Line| behind_a_word.iter().any(|of| of.line == *line && of.is_of_the_table());
        // units of a preamble say nothing of where the names stand
        candidates.retain(|line| of_the_table(line) || !behind_a_word.iter().any(|of| of.line == line.0));
        let not_marked = lines.iter().filter(|(_, text)| !is_remark(text)).count();
        let units_at =
            (0..candidates.len()).rev().find(|at| of_the_table(&candidates[*at]) || are_units(&candidates, *at));
        let under_names = units_at.map(|at| candidates[at].clone()).filter(|line| !of_the_table(line));
        let names = labelled_names(&candidates, dialect, width)
            .or_else(|| names_of(candidates, units_at))
            .map(|(line, cells)| (line, without_label(cells, width)))
            .map(|names| with_index(names, lines, &own));
        let called = names.as_ref().map_or_else(|| vec![String::new(); width], |(_, cells)| cells.clone());
        let all: Vec<Vec<String>> = lines
            .iter()
            .filter(|(line, _)| names.as_ref().is_none_or(|(at, _)| line != at))
            .map(|(_, text)| dialect.split_quoted(unmarked(text)))
            .collect();
        let (units, notes) = match (tabled(&all, &called), under_names) {
            (Some(units), _) => (units, Vec::new()),
            (None, Some((_, cells))) if cells.len() >= called.len().min(width) => (cells, Vec::new()),
            (None, Some((line, _))) => {
                (Vec::new(), vec![format!("line {line}: the units are fewer than the names and are not used")])
            }
            (None, None) => matched(&behind_a_word, &called),
        };
        let used = usize::from(names.is_some()) + usize::from(!units.is_empty());
        Above { names, units, remarks: not_marked.saturating_sub(used), notes }
    }
}

/// Whether a cell is a word for the names behind it.
fn is_of_names(cell: &str) -> bool {
    let letters: String = cell.chars().filter(|c| c.is_alphabetic()).flat_map(char::to_lowercase).collect();
    matches!(
        letters.as_str(),
        "name"
            | "names"
            | "header"
            | "headers"
            | "tracename"
            | "channelname"
            | "channelnames"
            | "channeltitle"
            | "signalname"
            | "signalnames"
            | "columnnames"
    )
}

/// The names without a label before them, which the rows do not have: `*CHANNEL;TIME;ACC x`.
fn without_label(mut names: Vec<String>, width: usize) -> Vec<String> {
    let is_full = names.len() == width + 1 && names.iter().all(|name| !name.is_empty());
    if is_full && (names[0].starts_with('*') || is_of_names(&names[0])) {
        names.remove(0);
    }
    names
}

/// The names behind a word for them, `TraceName,CH1,CH2`, where no line names a clock.
fn labelled_names(candidates: &[Line], dialect: Dialect, width: usize) -> Option<Line> {
    if candidates.iter().any(names_a_clock) {
        return None;
    }
    let are_names = |(_, cells): &&Line| {
        // an empty column may stand behind the label
        let named = cells[1..].iter().skip_while(|cell| cell.is_empty());
        is_of_names(&cells[0])
            && named.clone().count() > 0
            && named.clone().all(|cell| !cell.is_empty() && !dialect.is_value(cell))
    };
    let (line, cells) = candidates.iter().rfind(are_names)?;
    let mut cells = cells.clone();
    if cells.len() > width {
        cells.remove(0);
    } else {
        cells[0].clear();
    }
    Some((*line, cells))
}

/// The line of the names among those that can be it, `units_at` being that of the units.
fn names_of(mut candidates: Vec<Line>, units_at: Option<usize>) -> Option<Line> {
    match units_at {
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
    }
}

/// The names with that of the index, which some programs write in a line of its own below them.
fn with_index((line, mut cells): Line, lines: &[(u64, String)], own: impl Fn(&str) -> Vec<String>) -> Line {
    let Some(empty) = cells.first().filter(|first| first.is_empty()).map(|_| 0) else { return (line, cells) };
    let below = lines.iter().filter(|(other, _)| *other > line).map(|(_, text)| own(unmarked(text)));
    let alone =
        |of: &Vec<String>| of.len() == cells.len() && !of[empty].is_empty() && of[1..].iter().all(String::is_empty);
    if let Some(name) = below.into_iter().find(alone) {
        cells[empty].clone_from(&name[empty]);
    }
    (line, cells)
}

/// The lines whose cells can stand above rows of `width` cells: with a trailing separator, or a
/// name less for a column without one.
fn candidates(lines: &[(u64, String)], width: usize, cells: impl Fn(&str) -> Vec<String>) -> Vec<Line> {
    let fits = |cells: &Vec<String>| {
        let named = cells.iter().filter(|cell| !cell.is_empty()).count();
        let is_name = |cell: &String| cell.contains(char::is_alphanumeric) && !is_stamp(cell);
        // neither lines of dashes nor of dates are names
        cells.iter().any(is_name)
            && cells.len() <= width + 1
            && cells.len() + 1 >= width
            && named > 0
            && (named > 1 || width <= 2)
            // the key of what stands below it
            && !(named == 1 && width > 1 && cells[0].ends_with(':'))
    };
    let all = lines.iter().map(|(line, text)| (*line, cells(unmarked(text))));
    let mut all: Vec<Line> = all.filter(|(_, cells)| fits(cells)).collect();
    if all.iter().any(|(_, cells)| !is_setting(cells) && !cells.iter().all(|cell| is_bare(cell) || is_unit(cell))) {
        all.retain(|(_, cells)| !is_setting(cells));
    }
    all
}

/// A line without the mark of a remark.
pub(super) fn unmarked(text: &str) -> &str {
    let text = text.trim_start().trim_start_matches('\u{feff}');
    if is_remark(text) { text.trim_start_matches(['#', '%', '/']).trim_start() } else { text }
}

/// A line without a mark that leads remarks in some files alone: `! t, w` and, where no semicolon
/// divides, `; t w`.
fn without_mark(text: &str, dialect: Dialect) -> &str {
    let mark = |c: char| c == '!' || (c == ';' && dialect.separator != b';');
    text.strip_prefix(mark).map_or(text, str::trim_start)
}

/// The cells of a line that is divided as the rows are. A blank divides no bracket, and no unit in
/// a bracket from its name; where it divides the rows, the names may be divided by more.
fn own_cells(text: &str, dialect: Dialect, width: usize) -> Vec<String> {
    if dialect.separator == COLUMNS {
        let cells = columns(text);
        return if cells.len() == width { cells } else { other_cells(text, dialect, width) };
    }
    if dialect.separator != b' ' {
        return dialect.split_quoted(text);
    }
    let words = if text.contains('"') { dialect.split_quoted(text) } else { words(text) };
    let divided = |cells: &[String]| !cells.iter().any(|cell| cell.ends_with([',', ';', '|']));
    if words.len() == width && divided(&words) {
        return words;
    }
    let other = other_cells(text, dialect, width);
    if other.len() == width { other } else { words }
}

/// The cells of a line that is not divided as the rows are: by what gives `width` of
/// them.
fn other_cells(text: &str, dialect: Dialect, width: usize) -> Vec<String> {
    let others = [b',', b';', b'\t', b'|'].into_iter().filter(|other| *other != dialect.separator);
    let split = |separator| Dialect { separator, ..dialect }.split_quoted(text);
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

/// Whether a line has keys and numbers, `HOffset, 0.0, 0.0`. Columns may be called by different
/// whole numbers, behind a clock.
fn is_setting(cells: &[String]) -> bool {
    let is_number = |cell: &&String| cell.parse::<f64>().is_ok() || is_stamp(cell);
    let numbers: Vec<&String> = cells.iter().filter(is_number).collect();
    let is_name =
        |(at, cell): (usize, &&String)| cell.bytes().all(|byte| byte.is_ascii_digit()) && !numbers[..at].contains(cell);
    let called = is_clock(&cells[0]) && numbers.iter().enumerate().all(is_name);
    !numbers.is_empty() && 2 * numbers.len() >= cells.len() && !called
}

fn is_stamp(cell: &str) -> bool {
    cell.contains([':', '/', '-', '.']) && cell.contains(|c: char| c.is_ascii_digit()) && Form::is_of(cell)
}

fn is_clock(cell: &str) -> bool {
    rank(&heading(cell).name).is_some()
}

/// Whether a cell names a clock and none is a value, as that of `Time:,14:59:58` is. A property of
/// every channel, `xname,Time,Time`, is no name of one.
fn names_a_clock((_, cells): &Line) -> bool {
    let is_property = cells.len() > 2
        && !is_clock(&cells[0])
        && is_clock(&cells[1])
        && !cells[0].is_empty()
        && cells[2..].iter().all(|cell| *cell == cells[1]);
    !is_property && are_names_with_clock(cells)
}

/// As [`names_a_clock`], of cells.
pub(super) fn are_names_with_clock(cells: &[String]) -> bool {
    let is_value = |cell: &String| {
        let of_signs = cell.contains([':', '/', '.']) && cell.contains(|c: char| c.is_ascii_digit());
        (of_signs && is_bare(cell)) || is_stamp(cell)
    };
    !cells.iter().any(is_value) && cells.iter().any(|cell| is_clock(cell))
}

/// Of the lines above one of units that of the names: the one with the best name of a clock, of
/// equals the nearest. Loggers write names, descriptions and units, in this order.
fn best_named(lines: Vec<Line>) -> Option<Line> {
    let clock = |cells: &[String]| cells.iter().filter_map(|cell| rank(&heading(cell).name)).min().unwrap_or(u8::MAX);
    lines.into_iter().rev().min_by_key(|(_, cells)| clock(cells))
}

/// Whether a line is one of units: half of its cells are units that are known, and more than of the
/// line above it. A unit that is not known costs its own column alone.
fn are_units(lines: &[Line], at: usize) -> bool {
    let cells = &lines[at].1;
    let known = |cells: &[String]| cells.iter().filter(|cell| is_unit(cell)).count();
    let stated = cells.iter().filter(|cell| !is_bare(cell)).count();
    let units = known(cells);
    let of_above = at.checked_sub(1).map(|above| known(&lines[above].1));
    let names = cells.iter().any(|cell| !is_unit(cell) && heading(cell).unit.is_some_and(|unit| is_unit(&unit)));
    // `Sample Rate, 0.1, kHz`
    let is_other_number = |cell: &String| cell.parse::<f64>().is_ok_and(|number| number != 1.0);
    units > 0
        && !names
        && !cells.iter().any(is_other_number)
        && 2 * units >= stated
        && of_above.is_some_and(|above| units > above)
}
