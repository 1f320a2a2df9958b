//! How a row of a text file is divided and what its cells are: separator, signs of numbers.

use super::number::number;
use super::quantity::quantity;
use super::signs::Signs;
use super::stamps::Form;

/// Separator and signs of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Dialect {
    /// Blank stands for a run of blanks, [`COLUMNS`] for one of two or more.
    pub separator: u8,
    pub signs: Signs,
    /// Each cell begins with its name: `gyro_z:0.01`, `gyro_z=0.01`.
    pub labelled: bool,
}

/// Separator of tables whose cells may have blanks within.
pub(crate) const COLUMNS: u8 = 0x1f;

/// Name and value of a cell that begins with its name.
pub(super) fn label(cell: &str) -> Option<(&str, &str)> {
    let (name, value) = cell.split_once([':', '='])?;
    let is_name = name.starts_with(|c: char| c.is_alphabetic() || c == '_');
    is_name.then_some((name.trim(), value.trim())).filter(|(_, value)| !value.is_empty())
}

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

/// A cell that may have quotes, as it is read.
#[derive(Default)]
struct Quoted {
    text: String,
    /// Within the quotes.
    open: bool,
    /// It has quotes.
    quoted: bool,
}

/// No number and no stamp is longer [bytes].
const VALUE_MAX: usize = 64;

impl Dialect {
    /// The cells of a line. A stamp that a terminal writes before it, `14:59:58.250 -> 1.5` or
    /// `[14:59:58.250] 1.5`, is one.
    pub fn split<'a>(&self, text: &'a str) -> Vec<&'a str> {
        let is_stamp = |stamp: &&str| stamp.contains(':') && Form::is_of(stamp);
        let bracket = text.strip_prefix('[').and_then(|text| text.split_once(']'));
        if let Some((stamp, rest)) = bracket.filter(|(stamp, _)| stamp.len() < VALUE_MAX && is_stamp(stamp)) {
            let rest = rest.trim_start_matches([' ', ':']);
            let rest = rest.strip_prefix(char::from(self.separator)).unwrap_or(rest);
            return core::iter::once(stamp).chain(self.divided(rest)).collect();
        }
        let arrow = text.split_once(" -> ").filter(|_| text.starts_with(|c: char| c.is_ascii_digit()));
        match arrow.filter(|(stamp, _)| is_stamp(stamp)) {
            Some((stamp, rest)) => core::iter::once(stamp).chain(self.divided(rest)).collect(),
            None => self.divided(text),
        }
    }

    fn divided<'a>(&self, text: &'a str) -> Vec<&'a str> {
        let bare = |cell: &'a str| if self.labelled { label(cell).map_or(cell, |(_, value)| value) } else { cell };
        match self.separator {
            b' ' => text.split_ascii_whitespace().map(bare).collect(),
            COLUMNS => text.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).map(bare).collect(),
            separator => text.split(char::from(separator)).map(|cell| bare(cell.trim())).collect(),
        }
    }

    /// The cells of a line with quotes, or without.
    pub fn split_quoted(&self, text: &str) -> Vec<String> {
        if !text.contains('"') {
            return self.split(text).into_iter().map(str::to_owned).collect();
        }
        let mut cells = Vec::new();
        let mut cell = Quoted::default();
        let mut letters = text.chars().peekable();
        while let Some(c) = letters.next() {
            let ends = c == char::from(self.separator);
            match c {
                '"' if cell.open && letters.peek() == Some(&'"') => {
                    letters.next();
                    cell.text.push(c);
                }
                '"' if cell.open => cell.open = false,
                '"' if cell.text.trim().is_empty() && !cell.quoted => {
                    cell = Quoted { open: true, quoted: true, ..Quoted::default() }
                }
                _ if ends && !cell.open => cells.push(core::mem::take(&mut cell)),
                _ => cell.text.push(c),
            }
        }
        cells.push(cell);
        // a run of blanks is one separator
        let is_cell = |cell: &Quoted| self.separator != b' ' || cell.quoted || !cell.text.is_empty();
        cells.into_iter().filter(is_cell).map(|cell| cell.text.trim().to_owned()).collect()
    }

    /// A number, a quantity or a stamp.
    pub fn is_value(&self, cell: &str) -> bool {
        if cell.len() > VALUE_MAX {
            return false;
        }
        number(cell, self.signs).is_some()
            || quantity(cell, self.signs).is_some()
            || ((cell.contains([':', '-', '/', 'P']) || cell.matches('.').count() > 3) && Form::is_of(cell))
    }

    /// A number with a unit, and no number alone.
    pub fn is_quantity(&self, cell: &str) -> bool {
        number(cell, self.signs).is_none() && quantity(cell, self.signs).is_some()
    }
}

/// Whether a line is a remark of the program that wrote it.
pub(crate) fn is_remark(text: &str) -> bool {
    let text = text.trim_start();
    text.starts_with(['#', '%']) || text.starts_with("//")
}

/// How many cells stand up to the last that is not empty.
pub(crate) fn filled(cells: &[String]) -> usize {
    cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |at| at + 1)
}

/// A column for what an operator writes beside a row.
pub(super) fn is_of_remarks(name: &str) -> bool {
    matches!(name.trim().to_lowercase().as_str(), "comment" | "comments" | "remark" | "remarks" | "kommentar" | "note")
}
