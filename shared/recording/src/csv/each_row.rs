//! The rows of a text table one by one, and the lines between and behind them.

use super::is_remark;
use crate::error::RecordingError;
use crate::intake::origin::origin_note;
use crate::intake::plan::Plan;
use crate::text::cells::{Cells, Counts};
use crate::text::encoding::text_of;
use crate::text::lines::Lines;
use crate::text::printable;
use std::io::BufRead;

/// Lines that are no rows.
#[derive(Default)]
pub(super) struct Others {
    /// The first line behind the last row, and why it is not a row.
    footer: Option<(u64, RecordingError)>,
    /// Lines between rows that have no time.
    skipped: Vec<u64>,
    /// Text of the first of them, and why it is no row.
    first: Option<(String, RecordingError)>,
}

/// Takes a row and the line on which it stands; the cells are those of that line.
pub(super) type Push<'p> = dyn FnMut(&Cells<'_>, u64, &[f64]) -> Result<(), RecordingError> + 'p;

/// Gives every row to `push`, with its line. A line without a time is skipped, what follows the
/// last row is the footer.
pub(super) fn each_row(
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

pub(super) fn notes_of(
    cells: &Cells<'_>,
    plan: &Plan,
    others: Others,
    rows: usize,
) -> Result<Vec<String>, RecordingError> {
    let mut notes = Vec::new();
    match cells.first_day() {
        Some(day) => notes.push(format!("time counts from {day}T00:00:00")),
        None => notes.extend(origin_note(cells.origin_s())),
    }
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
