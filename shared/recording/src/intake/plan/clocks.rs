//! Which columns are the clock of a dataset: by what the user says, else by name, form and numbers.

use super::{Clock, Column, Heading, Kind, Source, unknown_unit};
use crate::error::RecordingError;
use crate::intake::Intake;
use crate::intake::clock::{self, TimeColumn};
use crate::intake::names::{cleaned, listed};
use crate::intake::stamps::{Form, Order};
use crate::rows::Axis;
use crate::text::printable;
use crate::units::{Unit, unit_named};

pub(super) fn axis_of(
    source: &Source<'_>,
    columns: &[Column<'_>],
    intake: &Intake,
    notes: &mut Vec<String>,
) -> Result<(Axis, Clock), RecordingError> {
    if let Some(said) = &intake.time_column {
        return said_clock(source, columns, said, notes).map(|clock| (Axis::Time, clock));
    }
    if let Some(clock) = clock_by_name(source, columns, notes)? {
        return Ok((Axis::Time, clock));
    }
    let lead = columns.first().filter(|first| is_frequency(&first.heading));
    match lead {
        Some(first) => {
            let text = first.heading.unit.as_deref().unwrap_or("Hz");
            let unit = unit_named(text).filter(|unit| unit.si == "Hz");
            let unit = unit.ok_or_else(|| unknown_unit(source.place(0, &first.seen.header), text, Some("Hz")))?;
            Ok((Axis::Frequency, Clock::Number { at: 0, unit }))
        }
        None => Err(no_time(source, columns)),
    }
}

fn is_frequency(heading: &Heading) -> bool {
    let name = heading.name.to_lowercase();
    let stated = heading.unit.as_deref().and_then(unit_named).is_some_and(|unit| unit.si == "Hz");
    let word = name.split(['_', ' ']).next().unwrap_or_default();
    name == "frequency" || (stated && matches!(word, "frequency" | "freq" | "f" | "frequenz"))
}

/// The clock that the user names.
fn said_clock(
    source: &Source<'_>,
    columns: &[Column<'_>],
    said: &TimeColumn,
    notes: &mut Vec<String>,
) -> Result<Clock, RecordingError> {
    if let Some(at) = position(columns, &said.name) {
        return clock_at(source, columns, at, said.unit, notes);
    }
    if let Some(unit) = said.unit.filter(|_| said.name == TimeColumn::ROWS) {
        return Ok(Clock::Rows { interval_s: unit.to_si(1.0) });
    }
    let names: Vec<String> = columns.iter().map(|column| column.heading.name.clone()).collect();
    let named = names.iter().map(String::as_str).filter(|name| !name.is_empty());
    let near = crate::error::nearest(&said.name, named);
    let meant = near.map_or(String::new(), |near| format!("did you mean `{near}`? "));
    Err(RecordingError::NoSuchChannel {
        said: format!("--time-column {}", said.name),
        file: source.file.into(),
        found: said.name.clone(),
        cure: format!("{meant}columns: {}", listed(&names)),
    })
}

/// The column called `name`, by header, name or number.
pub(super) fn position(columns: &[Column<'_>], name: &str) -> Option<usize> {
    let by = |f: &dyn Fn(&Column<'_>) -> bool| columns.iter().position(f);
    by(&|c| c.heading.name == name)
        .or_else(|| by(&|c| cleaned(&c.seen.header) == name))
        .or_else(|| by(&|c| c.heading.name.eq_ignore_ascii_case(name)))
        .or_else(|| name.parse::<usize>().ok().and_then(|n| n.checked_sub(1)).filter(|at| *at < columns.len()))
}

/// The column whose name says that it holds the times: the best name, of equals the first.
fn clock_by_name(
    source: &Source<'_>,
    columns: &[Column<'_>],
    notes: &mut Vec<String>,
) -> Result<Option<Clock>, RecordingError> {
    let usable = |column: &Column<'_>| matches!(column.seen.kind, Kind::Number | Kind::Stamp(_) | Kind::Empty);
    let is_of_time =
        |column: &Column<'_>| column.heading.unit.as_deref().and_then(unit_named).is_some_and(|unit| unit.si == "s");
    let rank = |at: usize, column: &Column<'_>| {
        clock::rank(&column.heading.name)
            // a date beside a time of day
            .or_else(|| matches!(column.seen.kind, Kind::Stamp(form) if !matches!(form, Form::Hex(_))).then_some(4))
            // whatever it is called
            .or_else(|| (at == 0 && is_of_time(column) && !is_frequency(&column.heading)).then_some(5))
    };
    let ranked = columns.iter().enumerate().filter(|(_, column)| usable(column));
    let best = ranked.filter_map(|(at, column)| Some((rank(at, column)?, at))).min();
    match best {
        Some((_, at)) => clock_at(source, columns, at, None, notes).map(Some),
        None => rising_clock(source, columns, notes),
    }
}

/// The one column with a word for time in its name whose numbers rise from row to row: `time_imu`.
fn rising_clock(
    source: &Source<'_>,
    columns: &[Column<'_>],
    notes: &mut Vec<String>,
) -> Result<Option<Clock>, RecordingError> {
    let rises = |column: &Column<'_>| {
        column.seen.sample.len() > 1 && column.seen.sample.is_sorted_by(|before, after| before < after)
    };
    let is_clock = |column: &Column<'_>| {
        column.seen.kind == Kind::Number && clock::has_word(&column.heading.name) && rises(column)
    };
    let mut clocks = columns.iter().enumerate().filter(|(_, column)| is_clock(column));
    let (Some((at, column)), None) = (clocks.next(), clocks.next()) else { return Ok(None) };
    let clock = clock_at(source, columns, at, None, notes)?;
    notes.push(format!("`{}` is taken for the times: its name and its rising numbers say so", column.heading.name));
    Ok(Some(clock))
}

fn clock_at(
    source: &Source<'_>,
    columns: &[Column<'_>],
    at: usize,
    said: Option<Unit>,
    notes: &mut Vec<String>,
) -> Result<Clock, RecordingError> {
    let column = &columns[at];
    match column.seen.kind {
        Kind::Stamp(Form::Hex(_)) => {}
        Kind::Stamp(form) => return Ok(stamps(columns, at, form, notes)),
        _ => {
            if let Some(parts) = said.is_none().then(|| second_and_parts(columns, at)).flatten() {
                notes.push(format!(
                    "time is `{}` and the part of a second in `{}`",
                    column.heading.name,
                    columns[at + 1].heading.name
                ));
                return Ok(Clock::Stamps(parts));
            }
        }
    }
    if let Some(found) = clock::hopeless(&column.seen.sample) {
        let cure = "export the file again with all digits of the time (a spreadsheet has rounded them)";
        return Err(RecordingError::BadClock {
            place: source.place(at, &column.seen.header),
            found,
            cure: cure.into(),
        });
    }
    let unit = match (said.or_else(|| ended(&column.heading)), &column.heading.unit) {
        (Some(unit), _) => unit,
        (None, Some(text)) => unit_named(text)
            .filter(|unit| unit.si == "s")
            .ok_or_else(|| unknown_unit(source.place(at, &column.seen.header), text, Some("s")))?,
        (None, None) if matches!(column.seen.kind, Kind::Stamp(_)) => {
            let name = &column.heading.name;
            return Err(RecordingError::BadClock {
                place: source.place(at, &column.seen.header),
                found: format!("`{name}` states no unit, and numbers to base 16 do not tell it"),
                cure: format!("say the unit: --time-column {name}:us (or s, ms, ns, 100Hz)"),
            });
        }
        (None, None) => {
            let (unit, note) = clock::guessed(&column.heading.name, &column.seen.sample).map_err(|(found, cure)| {
                RecordingError::BadClock { place: source.place(at, &column.seen.header), found, cure }
            })?;
            notes.push(note);
            unit
        }
    };
    if matches!(column.seen.kind, Kind::Stamp(Form::Hex(_))) {
        return Ok(Clock::Stamps(vec![(at, Form::Hex((unit.to_si(1.0) * 1e9).round() as i64))]));
    }
    Ok(Clock::Number { at, unit })
}

/// A column of whole seconds, and behind it one of the parts of a second: `sec`, `nanosec`.
fn second_and_parts(columns: &[Column<'_>], at: usize) -> Option<Vec<(usize, Form)>> {
    let (whole, part) = (&columns[at], columns.get(at + 1)?);
    let ns = clock::part_of_second(&part.heading.name, part.heading.unit.as_deref())?;
    let of_seconds = whole.heading.unit.as_deref().and_then(unit_named).is_none_or(|unit| unit.to_si(1.0) == 1.0);
    let is_whole = |column: &Column<'_>| {
        column.seen.kind == Kind::Number && column.seen.sample.iter().all(|value| value.fract() == 0.0 && *value >= 0.0)
    };
    let within = part.seen.sample.iter().all(|value| value * ns as f64 <= 1e9);
    (of_seconds && is_whole(whole) && is_whole(part) && within)
        .then(|| vec![(at, Form::Count(1_000_000_000)), (at + 1, Form::Count(ns))])
}

/// The unit in which the name of a clock ends, where no other is stated.
fn ended(heading: &Heading) -> Option<Unit> {
    if heading.unit.is_some() { None } else { clock::ending(&heading.name) }
}

/// A stamp alone, or a date joined with the time of day in another column.
fn stamps(columns: &[Column<'_>], at: usize, form: Form, notes: &mut Vec<String>) -> Clock {
    let other = |wanted: fn(Form) -> bool| {
        columns.iter().enumerate().find_map(|(other, column)| match column.seen.kind {
            Kind::Stamp(form) if other != at && wanted(form) => Some((other, form)),
            _ => None,
        })
    };
    let partner = match form {
        Form::DateTime(_) | Form::Elapsed | Form::Count(_) | Form::Hex(_) => None,
        Form::Date(_) => other(|form| matches!(form, Form::Time(_))),
        Form::Time(_) => other(|form| matches!(form, Form::Date(_))),
    };
    let order = form.open_order().or_else(|| partner.and_then(|(_, form)| form.open_order()));
    notes.extend(order.map(date_order_note));
    Clock::Stamps(core::iter::once((at, form)).chain(partner).collect())
}

/// Says in what order dates are read.
pub(crate) fn date_order_note(order: Order) -> String {
    format!("dates are read as {}", order.name())
}

fn no_time(source: &Source<'_>, columns: &[Column<'_>]) -> RecordingError {
    let names: Vec<String> = columns.iter().map(|column| column.heading.name.clone()).collect();
    let nameless = names.iter().all(String::is_empty);
    let first = columns.first().map_or("", |column| column.seen.header.as_str());
    let is_number = |at: &usize| columns[*at].seen.kind == Kind::Number;
    let example = (0..columns.len()).find(is_number).unwrap_or(0);
    let in_words =
        columns.iter().find(|column| column.seen.kind == Kind::Text && clock::rank(&column.heading.name).is_some());
    let cure = if let Some(column) = in_words {
        format!(
            "`{}` should be the clock, but its cells are no dates or times that are known: write them as 2024-03-05T14:59:58.000 or as seconds; or say the rate of the rows, --time-column row:100Hz",
            printable(&column.heading.name)
        )
    } else if nameless {
        format!(
            "the file has no header: name the columns by their numbers, as in --time-column {}:s --channel 'angle = {} [rad]'",
            example + 1,
            example + 2
        )
    } else {
        let called = names.get(example).filter(|name| !name.is_empty());
        format!(
            "say which column holds the times, as in --time-column {}:s, or the rate of the rows, --time-column row:100Hz; columns: {}",
            called.map_or_else(|| (example + 1).to_string(), |name| printable(name)),
            listed(&names)
        )
    };
    RecordingError::NoTimeColumn { place: source.place(0, first), cure }
}
