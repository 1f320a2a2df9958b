//! What becomes of each column of a dataset: clock, channel, or left out with the reason.

use super::clock::{self, TimeColumn};
use super::names::{Heading, heading, headings, listed};
use super::quantities::in_view_of;
use super::second_clock::{self, SecondClock};
use super::stamps::{Form, Order};
use super::{Assignment, Intake, assignment};
use crate::canonical::default_channel;
use crate::error::{Place, RecordingError};
use crate::function_kind::FunctionKind;
use crate::rows::Axis;
use crate::text::printable;
use crate::units::{UNITS, Unit, accepted_for, unit_named};
use std::collections::{HashMap, HashSet};

/// What the cells of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Number,
    Stamp(Form),
    Text,
    Empty,
}

/// A column as it was seen.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    /// Text of the header; empty where there is none.
    pub header: String,
    /// Unit that stands apart from the name.
    pub unit: Option<String>,
    pub kind: Kind,
    /// First numbers of it.
    pub sample: Vec<f64>,
}

/// How the time of a row is read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Clock {
    Number {
        at: usize,
        unit: Unit,
    },
    /// A stamp, or a date and a time of day.
    Stamps(Vec<(usize, Form)>),
    Rows {
        interval_s: f64,
    },
}

/// A channel to be.
#[derive(Clone, Debug)]
pub(crate) struct Planned {
    /// Position of the column.
    pub at: usize,
    pub name: String,
    pub unit: Unit,
    /// Text of the unit in the file; empty: not stated.
    pub unit_in_file: String,
    pub scale: f64,
    /// Header text, for errors.
    pub header: String,
}

impl Planned {
    /// The column without values yet.
    pub fn column(&self) -> crate::table::Column {
        let (name, unit_in_file) = (self.name.clone(), self.unit_in_file.clone());
        let kind = FunctionKind::Unknown;
        crate::table::Column { name, unit: self.unit.si, unit_in_file, kind, values: Vec::new() }
    }
}

/// What becomes of a dataset.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub axis: Axis,
    pub clock: Clock,
    /// Header text of the clock.
    pub clock_header: String,
    pub columns: Vec<Planned>,
    /// Clocks of their own of some of the columns.
    pub second_clocks: Vec<SecondClock>,
    pub notes: Vec<String>,
}

/// Where the dataset stands, for errors.
pub(crate) struct Source<'a> {
    pub file: &'a str,
    /// Line of the header; 0 where there are no lines.
    pub line: u64,
}

impl Source<'_> {
    fn place(&self, at: usize, name: &str) -> Box<Place> {
        Box::new(Place { file: self.file.into(), line: self.line, column: at + 1, name: printable(name) })
    }
}

/// A column with its heading divided.
struct Column<'a> {
    seen: &'a Seen,
    heading: Heading,
}

/// What becomes of `columns`.
///
/// # Errors
/// No column of times, or one whose unit nobody states; a unit that is not known where a channel
/// was asked for; no channel that can be used.
pub(crate) fn plan(source: &Source<'_>, all: &[Seen], intake: &Intake) -> Result<Plan, RecordingError> {
    let columns = divided(all);
    let mut notes = Vec::new();
    let (axis, clock) = axis_of(source, &columns, intake, &mut notes)?;
    let taken: Vec<usize> = match &clock {
        Clock::Number { at, .. } => vec![*at],
        Clock::Stamps(parts) => parts.iter().map(|(at, _)| *at).collect(),
        Clock::Rows { .. } => Vec::new(),
    };
    let clock_header = taken.first().map_or("row".into(), |at| columns[*at].seen.header.clone());
    let of_column = assigned(source, &columns, intake)?;
    let mut chosen = Channels { source, intake, of_column, planned: Vec::new(), left_out: Vec::new(), error: None };
    for (at, column) in columns.iter().enumerate().filter(|(at, _)| !taken.contains(at)) {
        chosen.add(at, column)?;
    }
    chosen.give_up_names();
    let Channels { planned, left_out, error, .. } = chosen;
    if planned.is_empty() {
        let place = source.place(taken.first().copied().unwrap_or(0), &clock_header);
        return Err(error.unwrap_or(RecordingError::NoChannels { place, left_out: listed(&left_out) }));
    }
    notes.extend(repeated(&columns, &planned));
    notes.extend(remarks(&planned, &left_out));
    let second_clocks = second_clock::of(all, &clock, &planned);
    Ok(Plan { axis, clock, clock_header, columns: planned, second_clocks, notes })
}

/// Names that stand more than once, and what the later columns are called.
fn repeated(columns: &[Column<'_>], planned: &[Planned]) -> Option<String> {
    let stated = |of: &Planned| heading(&columns[of.at].seen.header).name;
    let renamed = planned.iter().filter(|of| of.name == columns[of.at].heading.name && of.name != stated(of));
    let all: Vec<String> = renamed.map(|of| format!("column {} is `{}`", of.at + 1, of.name)).collect();
    (!all.is_empty()).then(|| format!("names stand more than once: {}", listed(&all)))
}

fn remarks(planned: &[Planned], left_out: &[String]) -> Vec<String> {
    let mut notes = Vec::new();
    if !left_out.is_empty() {
        notes.push(format!("left out: {}", listed(left_out)));
    }
    let silent: Vec<String> =
        planned.iter().filter(|of| of.unit_in_file.is_empty()).map(|of| of.name.clone()).collect();
    if let Some(first) = silent.first() {
        notes.push(format!(
            "unit not stated: {}; say it: --channel '{first} = {first} [UNIT]', as in [rad], [deg/s], [m/s^2], [N]",
            listed(&silent)
        ));
    }
    notes
}

/// Headers divided; a name that stood before gets the next number that makes no name of the file.
fn divided(all: &[Seen]) -> Vec<Column<'_>> {
    let headings = headings(all.iter().map(|seen| seen.header.as_str()));
    let mut columns: Vec<Column<'_>> =
        all.iter().zip(headings).map(|(seen, own)| Column { seen, heading: stated(seen, own) }).collect();
    let mut taken: HashSet<String> = columns.iter().map(|column| column.heading.name.clone()).collect();
    let mut turns: HashMap<String, usize> = HashMap::new();
    for column in columns.iter_mut().filter(|column| !column.heading.name.is_empty()) {
        let name = column.heading.name.clone();
        let turn = turns.entry(name.clone()).or_insert(0);
        *turn += 1;
        while *turn > 1 && !taken.insert(format!("{name}_{turn}")) {
            *turn += 1;
        }
        if *turn > 1 {
            column.heading.name = format!("{name}_{turn}");
        }
    }
    columns
}

/// Name and unit as the file states them.
fn stated(seen: &Seen, mut own: Heading) -> Heading {
    if let Some(unit) = seen.unit.as_deref().filter(|unit| !unit.trim().is_empty()) {
        let unit = super::names::cleaned(unit);
        own.unit = Some(in_view_of(&own.name, unit.trim_matches(['[', ']', '(', ')'])));
    }
    own
}

fn axis_of(
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
fn position(columns: &[Column<'_>], name: &str) -> Option<usize> {
    let by = |f: &dyn Fn(&Column<'_>) -> bool| columns.iter().position(f);
    by(&|c| c.heading.name == name)
        .or_else(|| by(&|c| super::names::cleaned(&c.seen.header) == name))
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

pub(crate) fn unknown_unit(place: Box<Place>, found: &str, expected: Option<&str>) -> RecordingError {
    let accepted = match expected {
        Some(si) => accepted_for(si),
        None => UNITS.iter().map(|unit| unit.symbol).collect::<Vec<_>>().join(", "),
    };
    let fits = |near: &String| expected.is_none_or(|si| unit_named(near).is_some_and(|unit| unit.si == si));
    if let Some(spellings) = crate::units::two_meanings(found) {
        let cure = format!("it may be two things: write {spellings}, as in --channel 'name = name [UNIT]'");
        return RecordingError::UnknownUnit { place, found: printable(found), accepted, cure };
    }
    let cure = match crate::units::nearest_spelling(found).filter(fits) {
        Some(near) => format!("if `{near}` is meant, say it: --channel 'name = name [{near}]'"),
        None => "say what its numbers are, as in --channel 'name = name [m/s^2]', or convert the column to SI".into(),
    };
    RecordingError::UnknownUnit { place, found: printable(found), accepted, cure }
}

/// Channels as they are collected.
struct Channels<'a> {
    source: &'a Source<'a>,
    intake: &'a Intake,
    /// What is said of each column.
    of_column: Vec<Option<&'a Assignment>>,
    planned: Vec<Planned>,
    left_out: Vec<String>,
    /// Why the first column that could not be used could not be used.
    error: Option<RecordingError>,
}

impl Channels<'_> {
    fn add(&mut self, at: usize, column: &Column<'_>) -> Result<(), RecordingError> {
        let Column { seen, heading } = column;
        let number = (at + 1).to_string();
        let assigned = self.of_column[at];
        let called = if heading.name.is_empty() { format!("column {number}") } else { heading.name.clone() };
        let reason = match seen.kind {
            Kind::Number if heading.name.is_empty() && assigned.is_none() => Some("no name"),
            Kind::Number => None,
            Kind::Stamp(Form::Hex(_)) => Some("numbers to base 16"),
            Kind::Stamp(_) => Some("date or time"),
            Kind::Text => Some("text"),
            Kind::Empty if heading.name.is_empty() => return Ok(()),
            Kind::Empty => Some("empty"),
        };
        if let Some(reason) = reason {
            self.left_out.push(format!("`{called}` ({reason})"));
            return Ok(());
        }
        match self.unit_of(at, column, assigned) {
            Ok((unit, text)) => {
                let name = assigned.map_or(heading.name.clone(), |of| of.own.clone());
                let scale = assigned.map_or(1.0, |of| of.scale);
                let header = seen.header.clone();
                self.planned.push(Planned { at, name, unit, unit_in_file: text, scale, header });
                Ok(())
            }
            Err(error) if assigned.is_some() || default_channel(&heading.name).is_some() => Err(error),
            Err(error) => {
                let unit = heading.unit.as_deref().unwrap_or_default();
                self.left_out.push(format!("`{called}` ({})", assignment::unknown(&printable(unit))));
                self.error.get_or_insert(error);
                Ok(())
            }
        }
    }

    fn unit_of(
        &self,
        at: usize,
        column: &Column<'_>,
        assigned: Option<&Assignment>,
    ) -> Result<(Unit, String), RecordingError> {
        if let Some((unit, of)) = assigned.and_then(|of| Some((of.unit?, of))) {
            return Ok((unit, of.unit_text.clone()));
        }
        let expected = default_channel(&column.heading.name).map(|channel| channel.unit);
        match &column.heading.unit {
            None => Ok((Unit::not_stated(), String::new())),
            Some(text) => unit_named(text)
                .map(|unit| (unit, text.clone()))
                .ok_or_else(|| unknown_unit(self.source.place(at, &column.seen.header), text, expected)),
        }
    }

    /// A column whose own name was given to another is left out.
    fn give_up_names(&mut self) {
        let own: Vec<&str> = self.intake.channels.iter().map(|of| of.own.as_str()).collect();
        let replaced = |of: &Planned| own.contains(&of.name.as_str()) && self.of_column[of.at].is_none();
        let gone = self.planned.iter().filter(|of| replaced(of));
        let gone: Vec<String> = gone.map(|of| format!("`{}` (its name is given to another)", of.header)).collect();
        self.planned.retain(|of| !replaced(of));
        self.left_out.extend(gone);
    }
}

/// What is said of each column: an assignment is of one column.
fn assigned<'a>(
    source: &Source<'_>,
    columns: &[Column<'_>],
    intake: &'a Intake,
) -> Result<Vec<Option<&'a Assignment>>, RecordingError> {
    let mut of_column = vec![None; columns.len()];
    for assignment in &intake.channels {
        let Some(at) = position(columns, &assignment.theirs) else {
            let names: Vec<String> = columns.iter().map(|column| column.heading.name.clone()).collect();
            return Err(assignment.absent(source.file, &names));
        };
        of_column[at] = Some(assignment);
    }
    Ok(of_column)
}
