//! Which columns are the clock of a dataset: by what the user says, else by name, form and numbers.

use super::in_parts::{of_calendar, of_gps, second_and_parts};
use super::{Clock, Column, Heading, Kind, Source, unknown_unit};
use crate::error::RecordingError;
use crate::intake::Intake;
use crate::intake::clock::{self, TimeColumn};
use crate::intake::day_counts::{DayCount, ticks};
use crate::intake::guessed_unit;
use crate::intake::names::{cleaned, listed};
use crate::intake::stamps::{Form, Order};
use crate::rows::Axis;
use crate::since::Since;
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

/// The columns whose names say that they hold the times: the best name, of equals the first; a
/// clock in several columns before the one of them that is called like a clock, too.
fn clock_by_name(
    source: &Source<'_>,
    columns: &[Column<'_>],
    notes: &mut Vec<String>,
) -> Result<Option<Clock>, RecordingError> {
    let usable = |column: &Column<'_>| matches!(column.seen.kind, Kind::Number | Kind::Stamp(_) | Kind::Empty);
    let rank = |column: &Column<'_>| {
        let is_stamp = matches!(column.seen.kind, Kind::Stamp(form) if !matches!(form, Form::Hex(_)));
        // a date beside a time of day
        let counts_ticks = column.seen.kind == Kind::Number && ticks(&column.seen.sample).is_some();
        clock::rank(&column.heading.name).or_else(|| (is_stamp || counts_ticks).then_some(4))
    };
    let ranked = columns.iter().enumerate().filter(|(_, column)| usable(column));
    // a clock that stands still gives way to one that goes
    let ranks = ranked.filter_map(|(at, column)| Some((column.seen.is_constant, rank(column)?, at)));
    let best = ranks.min().map(|(.., at)| at);
    for in_parts in [of_calendar(columns), of_gps(columns)].into_iter().flatten() {
        if best.is_none_or(|best| in_parts.parts.iter().any(|(at, _)| *at == best)) {
            return Ok(Some(in_parts.clock(notes)));
        }
    }
    let is_of_time =
        |column: &Column<'_>| column.heading.unit.as_deref().and_then(unit_named).is_some_and(|unit| unit.si == "s");
    let whatever = |first: &&Column<'_>| usable(first) && is_of_time(first) && !is_frequency(&first.heading);
    let first = || columns.first().filter(whatever).map(|_| 0);
    let best = best.or_else(|| columns.iter().position(holds_steps)).or_else(first);
    let long = || columns.first().filter(|first| counts_long_units(first)).map(|_| 0);
    if let Some(at) = best {
        return clock_at(source, columns, at, None, notes).map(Some);
    }
    match long().or_else(|| only_of_time(columns)) {
        Some(at) => {
            let name = printable(&columns[at].heading.name);
            notes.push(format!("`{name}` is taken for the times: its unit is one of time and its numbers rise"));
            clock_at(source, columns, at, None, notes).map(Some)
        }
        None => rising_clock(source, columns, notes),
    }
}

/// Whether a column has the time since the row before: its name says so and its numbers do not
/// rise.
fn holds_steps(column: &Column<'_>) -> bool {
    let sample = &column.seen.sample;
    let is_step = column.seen.kind == Kind::Number && clock::is_of_steps(&column.heading.name);
    is_step && sample.len() > 1 && sample.iter().all(|step| *step >= 0.0) && !sample.is_sorted_by(|a, b| a < b)
}

/// The only column in a unit of time, where its numbers rise: an index without a name.
fn only_of_time(columns: &[Column<'_>]) -> Option<usize> {
    let unit = |column: &Column<'_>| column.heading.unit.as_deref().and_then(unit_named);
    let mut of_time = (0..columns.len()).filter(|at| unit(&columns[*at]).is_some_and(|unit| unit.si == "s"));
    let only = of_time.next().filter(|_| of_time.next().is_none())?;
    let sample = &columns[only].seen.sample;
    let rises = sample.len() > 2 && sample.is_sorted_by(|before, after| before < after);
    (rises && columns[only].seen.kind == Kind::Number).then_some(only)
}

/// Whether a column is called by a unit of time alone, as `min`, and rises: a minimum does not.
fn counts_long_units(column: &Column<'_>) -> bool {
    let sample = &column.seen.sample;
    let rises = sample.len() > 1 && sample.is_sorted_by(|before, after| before < after);
    column.seen.kind == Kind::Number && rises && clock::long_unit(&column.heading.name).is_some()
}

/// The first column with a word for time in its name whose numbers rise from row to row:
/// `time_imu`.
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
    let Some((at, column)) = columns.iter().enumerate().find(|(_, column)| is_clock(column)) else { return Ok(None) };
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
        _ if said.is_none() => {
            if let Some(in_parts) = second_and_parts(columns, at) {
                return Ok(in_parts.clock(notes));
            }
            if let Some(form) = since_a_date(&column.heading) {
                return Ok(Clock::Stamps(vec![(at, form)]));
            }
        }
        _ => {}
    }
    if let Some(found) = guessed_unit::hopeless(&column.seen.sample) {
        let cure = "export the file again with all digits of the time (a spreadsheet has rounded them)";
        return Err(RecordingError::BadClock {
            place: source.place(at, &column.seen.header),
            found,
            cure: cure.into(),
        });
    }
    if holds_steps(column) {
        let unit = unit_at(source, column, at, said, notes)?;
        let name = &column.heading.name;
        notes.push(format!("`{name}` is the time since the row before: the times are its sums, from 0 on"));
        return Ok(Clock::Steps { at, unit });
    }
    let days = DayCount::of(&column.heading.name, &column.seen.sample);
    let unit = said.or_else(|| stated_unit(&column.heading));
    if let Some(days) = days.filter(|_| unit.is_none_or(|unit| unit.to_si(1.0) == DAY_S)) {
        notes.push(format!("the numbers of `{}` are days since {}", column.heading.name, days.since));
        return Ok(Clock::Stamps(vec![(at, days.form())]));
    }
    if let Some((form, since)) = ticks(&column.seen.sample).filter(|_| unit.is_none()) {
        notes.push(format!("the numbers of `{}` are ticks of 100 ns since {since}", column.heading.name));
        return Ok(Clock::Stamps(vec![(at, form)]));
    }
    let unit = unit_at(source, column, at, said, notes)?;
    if matches!(column.seen.kind, Kind::Stamp(Form::Hex(_))) {
        return Ok(Clock::Stamps(vec![(at, Form::Hex(count_ns(unit)))]));
    }
    Ok(Clock::Number { at, unit })
}

/// \[s\]
const DAY_S: f64 = 86_400.0;

fn count_ns(unit: Unit) -> i64 {
    (unit.to_si(1.0) * 1e9).round() as i64
}

/// A count since a date that the heading names: `time [seconds since 2024-03-05 15:00:00]`.
fn since_a_date(heading: &Heading) -> Option<Form> {
    Since::parse(heading.unit.as_deref()?)?.form()
}

/// The unit that a heading of a clock states: apart, at the end of the name, or as the name.
fn stated_unit(heading: &Heading) -> Option<Unit> {
    match &heading.unit {
        Some(text) => unit_named(text).filter(|unit| unit.si == "s"),
        None => clock::ending(&heading.name).or_else(|| clock::long_unit(&heading.name)),
    }
}

/// The unit of a clock: said, stated, or guessed from its numbers.
fn unit_at(
    source: &Source<'_>,
    column: &Column<'_>,
    at: usize,
    said: Option<Unit>,
    notes: &mut Vec<String>,
) -> Result<Unit, RecordingError> {
    if let Some(unit) = said.or_else(|| stated_unit(&column.heading)) {
        return Ok(unit);
    }
    let (name, place) = (&column.heading.name, || source.place(at, &column.seen.header));
    if let Some(text) = &column.heading.unit {
        // a zero that is no date: the times count from it, wherever it is
        let (count, zero) = text.split_once(" since ").unwrap_or((text, ""));
        let unit = unit_named(count).filter(|unit| unit.si == "s" && !zero.is_empty());
        let unit = unit.ok_or_else(|| unknown_unit(place(), text, Some("s")))?;
        notes.push(format!("`{name}` counts from `{}`, which is no date that is known", printable(zero)));
        return Ok(unit);
    }
    if matches!(column.seen.kind, Kind::Stamp(_)) {
        return Err(RecordingError::BadClock {
            place: place(),
            found: format!("`{name}` states no unit, and numbers to base 16 do not tell it"),
            cure: format!("say the unit: --time-column {name}:us (or s, ms, ns, 100Hz)"),
        });
    }
    let guessed = guessed_unit::guessed(name, &column.seen.sample);
    let (unit, note) = guessed.map_err(|(found, cure)| RecordingError::BadClock { place: place(), found, cure })?;
    notes.push(note);
    Ok(unit)
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
        Form::Date(_) | Form::DateOfDigits(_) => other(Form::is_of_a_day),
        Form::Time(_) | Form::TimeOfDigits => other(|form| matches!(form, Form::Date(_) | Form::DateOfDigits(_))),
        _ => None,
    };
    if let Some(part) = milliseconds_beside(columns, at).filter(|_| partner.is_none()) {
        notes.push(format!("`{}` are the milliseconds of `{}`", columns[part].heading.name, columns[at].heading.name));
        notes.extend(form.open_order().map(date_order_note));
        return Clock::Stamps(vec![(at, form), (part, Form::Count(1_000_000))]);
    }
    let order = form.open_order().or_else(|| partner.and_then(|(_, form)| form.open_order()));
    notes.extend(order.map(date_order_note));
    Clock::Stamps(core::iter::once((at, form)).chain(partner).collect())
}

/// The column right behind stamps that has the milliseconds of each: whole numbers below 1000 that
/// fall back.
fn milliseconds_beside(columns: &[Column<'_>], at: usize) -> Option<usize> {
    let beside = columns.get(at + 1)?;
    let sample = &beside.seen.sample;
    let is_called = clock::part_of_second(&beside.heading.name, beside.heading.unit.as_deref()) == Some(1_000_000);
    let fits = sample.iter().all(|value| value.fract() == 0.0 && (0.0..1000.0).contains(value));
    let falls = sample.windows(2).any(|pair| pair[1] < pair[0]);
    (beside.seen.kind == Kind::Number && is_called && fits && falls).then_some(at + 1)
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
