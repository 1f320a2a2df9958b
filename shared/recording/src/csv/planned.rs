//! How a text table is laid out, and what becomes of its columns.

use super::two_clocks;
use crate::error::RecordingError;
use crate::intake::clock::words_of;
use crate::intake::names::heading;
use crate::intake::plan::{Clock, Kind, Plan, Seen, Source, plan};
use crate::intake::{Intake, TimeColumn};
use crate::text::dialect;
use crate::text::encoding::text_of;
use crate::text::interval::Interval;
use crate::text::layout::layout;
use crate::text::lines::Lines;
use crate::text::number::number;
use crate::text::printable;
use crate::text::quantity::{number_in, quantity};
use crate::text::seen::Layout;
use crate::text::stamps::Form;
use crate::text::stated_date::stated_date;
use crate::units::{Unit, unit_named};
use std::io::BufRead;

/// How the file is laid out, and what becomes of its columns.
pub(super) fn planned(
    file: &str,
    lines: &mut Lines<impl BufRead>,
    intake: &Intake,
) -> Result<(Layout, Plan), RecordingError> {
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
    two_clocks::agree(&source, &columns, &layout, &plan, intake)?;
    if plan.clock.is_of_a_day() {
        let above = ahead.iter().take_while(|(line, _)| *line < layout.first_line).cloned().collect::<Vec<_>>();
        plan.day = stated_date(&above).unwrap_or(0);
    }
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
    if let Some(whole) = layout.interval.as_ref().and_then(|interval| interval.without_unit) {
        return first.map_err(|error| asking_for_unit(error, layout, whole));
    }
    if let (Err(RecordingError::BadClock { place, .. }), Some(interval)) = (&first, &layout.interval)
        && let Some(counted) = counter_with_interval(source, columns, place.column, interval, intake)
    {
        return counted;
    }
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
    // rows may be missing: what counts them says which
    if let Some(counted) = columns.iter().position(counts_rows)
        && let Some(counted) = counter_with_interval(source, columns, counted + 1, interval, intake)
    {
        return counted;
    }
    // a column without a name whose numbers rise by the interval holds the times
    let steps_alike = |column: &Seen| {
        let step = |pair: &[f64]| (pair[1] - pair[0] - interval.seconds).abs() <= 1e-3 * interval.seconds;
        column.header.is_empty() && column.sample.len() > 2 && column.sample.windows(2).all(step)
    };
    if let Some(at) = columns.iter().position(steps_alike) {
        let said = Some(TimeColumn { name: (at + 1).to_string(), unit: unit_named("s") });
        let mut plan = plan(source, columns, &Intake { time_column: said, ..intake.clone() })?;
        let Interval { seconds, stated, .. } = interval;
        plan.notes.push(format!("column {} holds the times: it rises by {seconds} s ({stated})", at + 1));
        return Ok(plan);
    }
    let unit = Some(Unit::scaled("s", interval.seconds, 1.0));
    let by_rows = Some(TimeColumn { name: TimeColumn::ROWS.into(), unit });
    let mut plan = plan(source, columns, &Intake { time_column: by_rows, ..intake.clone() })?;
    let Interval { seconds, stated, .. } = interval;
    plan.notes.push(format!("no column holds the times: the rows follow each other every {seconds} s ({stated})"));
    Ok(plan)
}

/// The error of rows without times whose interval is stated as a whole number without a unit.
fn asking_for_unit(error: RecordingError, layout: &Layout, whole: u64) -> RecordingError {
    let RecordingError::NoTimeColumn { place, cure } = error else { return error };
    let stated = layout.interval.as_ref().map_or("", |interval| &interval.stated);
    let cure = match stated {
        "" => cure,
        _ => format!("{stated} has no unit: say it, --time-column row:{whole}ms, or row:{whole}s"),
    };
    RecordingError::NoTimeColumn { place, cure }
}

/// Whether a column numbers its rows: whole numbers that rise, but where a counter begins again.
fn counts_rows(column: &Seen) -> bool {
    let words = words_of(&heading(&column.header).name);
    let last = words.rsplit(' ').next().unwrap_or_default();
    let is_counter = ["frame", "counter", "packet", "sample", "index", "seq", "sequence"].contains(&last);
    let whole = column.sample.iter().all(|value| value.fract() == 0.0 && *value >= 0.0);
    let back = column.sample.windows(2).filter(|pair| pair[1] <= pair[0]).count();
    is_counter && whole && column.kind == Kind::Number && column.sample.len() > 2 && 100 * back <= column.sample.len()
}

/// What becomes of the columns where that of the times (its number from 1) counts in no unit: the
/// interval that the lines above the rows state is that of its usual step.
fn counter_with_interval(
    source: &Source<'_>,
    columns: &[Seen],
    number: usize,
    interval: &Interval,
    intake: &Intake,
) -> Option<Result<Plan, RecordingError>> {
    let sample = &columns.get(number - 1)?.sample;
    let mut steps: Vec<f64> = sample.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    steps.sort_unstable_by(f64::total_cmp);
    let step = *steps.get(steps.len() / 2).filter(|_| intake.time_column.is_none())?;
    let unit = Unit::scaled("s", interval.seconds / step, 1.0);
    let said = TimeColumn { name: number.to_string(), unit: Some(unit) };
    let mut plan = match plan(source, columns, &Intake { time_column: Some(said), ..intake.clone() }) {
        Ok(plan) => plan,
        Err(error) => return Some(Err(error)),
    };
    let (name, stated) = (printable(&heading(&columns[number - 1].header).name), &interval.stated);
    plan.notes.push(format!("`{name}` counts {step} from row to row, each {} s ({stated})", interval.seconds));
    Some(Ok(plan))
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
        .map(|cell| Seen {
            header: (*cell).into(),
            unit: None,
            kind: Kind::Number,
            sample: Vec::new(),
            is_constant: false,
        })
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
pub(super) fn seen(layout: &Layout) -> Vec<Seen> {
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
        let digits = || Form::of_digits(&heading(&header).name, given.iter().copied());
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
        let is_constant = given.len() > 2 && given.iter().all(|cell| *cell == given[0]);
        Seen { header, unit, kind, sample: numbers, is_constant }
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
