//! Lines of units above the rows, and which columns they are of.
//!
//! A line without a word for units stands right under the names and is divided as they are. One
//! behind such a word (`Units;s;rad/s`, `Vertical Units,V,A`, `Y_Unit_Label`) may stand anywhere:
//! its units are those of columns only where they are matched one to one, by their number or by
//! name.

use super::dialect::is_of_remarks;
use super::printable;
use crate::intake::clock::rank;
use crate::intake::names::heading;
use crate::units::unit_named;

/// A line that a word for units leads.
#[derive(Clone, Debug)]
pub(super) struct UnitsLine {
    pub line: u64,
    /// The words beside that for units, in small letters.
    of: Vec<String>,
    /// Cells of the line, where the label is one of them.
    cells: Option<usize>,
    /// What follows the label, without empty cells at the end.
    entries: Vec<String>,
    text: String,
}

/// The line as one of units, where a word for units leads it and a unit that is known follows.
pub(super) fn labelled(line: u64, cells: &[String]) -> Option<UnitsLine> {
    if let Some(own) = labelled_each(line, cells) {
        return Some(own);
    }
    let first = cells.first()?;
    let (of, rest) = label(first)?;
    let mut entries: Vec<String> = Vec::new();
    entries.extend(Some(rest.to_owned()).filter(|rest| !rest.is_empty()));
    entries.extend(cells[1..].iter().cloned());
    let filled = entries.iter().rposition(|entry| !entry.trim().is_empty())? + 1;
    entries.truncate(filled);
    let known = entries.iter().filter(|entry| is_unit(&named(entry).1)).count();
    let alone = rest.is_empty().then_some(cells.len());
    (known > 0).then(|| UnitsLine { line, of, cells: alone, entries, text: cells.join(" ") })
}

/// The line as one of units, where each cell that is not empty has the word for units of its own:
/// `,Unit: rad/s,Unit: N*m`.
fn labelled_each(line: u64, cells: &[String]) -> Option<UnitsLine> {
    let entry = |cell: &String| match label(cell) {
        _ if cell.is_empty() => Some(String::new()),
        Some((of, rest)) if of.is_empty() && !rest.is_empty() => Some(rest.to_owned()),
        _ => None,
    };
    let entries: Vec<String> = cells.iter().map(entry).collect::<Option<_>>()?;
    let known = entries.iter().filter(|entry| is_unit(entry)).count();
    let is_each = cells.first().is_some_and(String::is_empty) && known > 0;
    is_each.then(|| UnitsLine { line, of: Vec::new(), cells: None, entries, text: cells.join(" ") })
}

impl UnitsLine {
    /// Nothing but the word for units leads it.
    pub fn is_of_the_table(&self) -> bool {
        self.of.is_empty()
    }

    /// It names the abscissa.
    fn is_of_the_clock(&self) -> bool {
        self.of.iter().any(|word| matches!(word.as_str(), "x" | "horizontal" | "time" | "h"))
    }

    /// No word of it names one quantity.
    fn is_of_all_columns(&self) -> bool {
        self.of.iter().all(|word| OF_ALL.contains(&word.as_str()))
    }

    /// The units by column, where there is one for each column of data, or for each column.
    fn by_column(&self, names: &[String]) -> Option<Vec<String>> {
        let clock = names.iter().position(|name| rank(&heading(name).name).is_some());
        let repeats = |at: &usize| clock.is_some_and(|clock| names[*at] == names[clock]);
        let of_data = |at: &usize| {
            Some(*at) != clock && !repeats(at) && !is_of_remarks(&names[*at]) && !names[*at].trim().is_empty()
        };
        let data: Vec<usize> = (0..names.len()).filter(of_data).collect();
        let places: Vec<usize> = match self.by_name(names) {
            Some(places) => places,
            None if self.entries.len() == data.len() && clock.is_none_or(|at| at == 0) => data,
            None if self.cells == Some(names.len()) && clock == Some(0) => (1..names.len()).collect(),
            // the line of the names is labelled, too: the clock stands behind the label
            None if self.cells == Some(names.len())
                && clock == Some(1)
                && self.entries.len() + 1 == names.len()
                && unit_named(&self.entries[0]).is_some_and(|unit| unit.si == "s") =>
            {
                (1..names.len()).collect()
            }
            // so it is without a clock, each entry below its name
            None if self.cells == Some(names.len())
                && clock.is_none()
                && self.entries.len() + 1 == names.len()
                && names[0].is_empty() =>
            {
                (1..names.len()).collect()
            }
            None if self.entries.len() == names.len() => (0..names.len()).collect(),
            None => return None,
        };
        let mut units = vec![String::new(); names.len()];
        for (at, entry) in places.iter().zip(&self.entries) {
            units[*at] = named(entry).1;
        }
        let fits = |at: usize| unit_named(&units[at]).is_none_or(|unit| unit.si == "s") || units[at].is_empty();
        clock.is_none_or(fits).then_some(units)
    }

    /// The columns that the entries name: `CH1:V`.
    fn by_name(&self, names: &[String]) -> Option<Vec<usize>> {
        let place = |entry: &String| {
            let of = named(entry).0?;
            names.iter().position(|name| heading(name).name.eq_ignore_ascii_case(of.trim()))
        };
        self.entries.iter().map(place).collect()
    }
}

/// Words that say no more than that the columns have units.
const OF_ALL: &[&str] = &[
    "y",
    "v",
    "vertical",
    "label",
    "labels",
    "channel",
    "channels",
    "ch",
    "data",
    "signal",
    "signals",
    "value",
    "values",
    "column",
    "columns",
    "physical",
    "engineering",
    "measurement",
    "axis",
    "name",
    "names",
    "string",
    "field",
    "fields",
    "variable",
    "variables",
    "of",
    "the",
];

/// The units of the columns called `names`, and notes on lines that are of none.
pub(super) fn matched(lines: &[UnitsLine], names: &[String]) -> (Vec<String>, Vec<String>) {
    let mut notes = Vec::new();
    let mut units: Vec<String> = Vec::new();
    let (of_clock, others): (Vec<&UnitsLine>, Vec<&UnitsLine>) = lines.iter().partition(|of| of.is_of_the_clock());
    for line in others {
        let found = line.by_column(names).filter(|_| line.is_of_all_columns());
        match found {
            Some(found) if units.is_empty() || units == found => units = found,
            _ => notes.push(format!(
                "line {}: the units `{}` are of no certain columns and are not used",
                line.line,
                printable(&line.text)
            )),
        }
    }
    let clock = names.iter().position(|name| rank(&heading(name).name).is_some() && heading(name).unit.is_none());
    if let (Some(at), [line]) = (clock, &of_clock[..]) {
        let unit = line.entries.first().filter(|unit| unit_named(unit).is_some_and(|unit| unit.si == "s"));
        if let Some(unit) = unit.filter(|_| line.entries.len() == 1) {
            units.resize(names.len(), String::new());
            units[at].clone_from(unit);
        }
    }
    (units, notes)
}

/// The units of the columns called `names` by a table of channels above the rows, a line for each
/// of them and a column of units: `Channel, Datatype, Unit, Length`. Every unit that it states is
/// that of the column with its name, or none is.
pub(super) fn tabled(lines: &[Vec<String>], names: &[String]) -> Option<Vec<String>> {
    let is_of_units = |cell: &String| label(cell).is_some_and(|(of, rest)| of.is_empty() && rest.is_empty());
    let (head, at) = lines.iter().enumerate().find_map(|(head, cells)| {
        let at = cells.iter().position(is_of_units).filter(|at| *at > 0)?;
        Some((head, at))
    })?;
    let place = |name: &String| names.iter().position(|other| !name.is_empty() && heading(other).name == *name);
    let mut units = vec![String::new(); names.len()];
    for cells in lines[head + 1..].iter().take_while(|cells| cells.len() > at) {
        // a number of the channel may lead the line
        let Some(column) = cells.iter().take(at).find_map(place) else { break };
        if !units[column].is_empty() {
            return None;
        }
        units[column].clone_from(&cells[at]);
    }
    units.iter().any(|unit| is_unit(unit)).then_some(units)
}

/// Name and unit of an entry: `CH1:V`.
fn named(entry: &str) -> (Option<&str>, String) {
    match entry.split_once([':', '=']) {
        Some((name, unit)) => (Some(name), unit.trim().to_owned()),
        None => (None, entry.trim().to_owned()),
    }
}

/// Whether a cell is a unit that is known, and no number.
pub(super) fn is_unit(cell: &str) -> bool {
    !is_bare(cell) && unit_named(cell).is_some()
}

/// Whether a cell is empty, a number or a dash: it states no unit, whatever units may be called.
pub(super) fn is_bare(cell: &str) -> bool {
    let cell = cell.trim();
    cell.is_empty()
        || !cell.contains(|c: char| c.is_alphabetic() || matches!(c, '%' | '°' | 'º'))
        || cell.parse::<f64>().is_ok()
}

/// The words beside one for units at the beginning of a cell, and what follows behind a colon:
/// `unit`, `Units: s`, `Y_Unit_Label`, `YUnits:`.
fn label(cell: &str) -> Option<(Vec<String>, &str)> {
    let (word, rest) = cell.split_once([':', '=']).unwrap_or((cell, ""));
    let letters: String = word.chars().map(|c| if c.is_alphabetic() { c } else { ' ' }).collect();
    let mut is_labelled = false;
    let mut of = Vec::new();
    for word in letters.split_whitespace().map(str::to_lowercase) {
        let (axis, word) = match word.strip_prefix(['x', 'y', 'h', 'v']).filter(|rest| rest.starts_with("unit")) {
            Some(rest) => (word.get(..1), rest),
            None => (None, word.as_str()),
        };
        of.extend(axis.map(str::to_owned));
        if matches!(word, "unit" | "units" | "einheit" | "einheiten" | "unité" | "unités") {
            is_labelled = true;
        } else {
            of.push(word.to_owned());
        }
    }
    is_labelled.then_some((of, rest.trim()))
}
