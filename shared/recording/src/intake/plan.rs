//! What becomes of each column of a dataset: clock, channel, or left out with the reason.

use super::names::{Heading, heading, headings, listed};
use super::quantities::in_view_of;
use super::second_clock::{self, SecondClock};
use super::stamps::Form;
use super::{Assignment, Intake, assignment};
use crate::canonical::default_channel;
use crate::error::{Place, RecordingError};
use crate::function_kind::FunctionKind;
use crate::rows::Axis;
use crate::text::printable;
use crate::units::{UNITS, Unit, accepted_for, unit_named};
use std::collections::{HashMap, HashSet};

mod clocks;
mod in_parts;

pub(crate) use clocks::date_order_note;
use clocks::{axis_of, position};

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
    /// All cells that were seen are the same.
    pub is_constant: bool,
}

/// How the time of a row is read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Clock {
    Number {
        at: usize,
        unit: Unit,
    },
    /// A stamp, or parts of one, whose sum is the time.
    Stamps(Vec<(usize, Form)>),
    /// The time since the row before.
    Steps {
        at: usize,
        unit: Unit,
    },
    Rows {
        interval_s: f64,
    },
}

impl Clock {
    /// Whether the times have a date.
    pub fn has_day(&self) -> bool {
        matches!(self, Clock::Stamps(parts) if parts.iter().any(|(_, form)| form.has_day()))
    }

    /// Whether the times are of a day without a date, which begin again at midnight.
    pub fn is_of_a_day(&self) -> bool {
        matches!(self, Clock::Stamps(parts) if parts.iter().any(|(_, form)| form.is_of_a_day())) && !self.has_day()
    }
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
    /// Day since 1970-01-01 of a clock that has the time of day alone; 0 where none is stated.
    pub day: i64,
    pub notes: Vec<String>,
}

/// Where the dataset stands, for errors.
pub(crate) struct Source<'a> {
    pub file: &'a str,
    /// Line of the header; 0 where there are no lines.
    pub line: u64,
}

impl Source<'_> {
    pub fn place(&self, at: usize, name: &str) -> Box<Place> {
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
        Clock::Number { at, .. } | Clock::Steps { at, .. } => vec![*at],
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
    Ok(Plan { axis, clock, clock_header, columns: planned, second_clocks, day: 0, notes })
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
        own.unit = Some(in_view_of(&own.name, without_brackets(&unit)));
    }
    own
}

/// The text in a pair of brackets around all of it: `m/(s^2)` has none.
fn without_brackets(text: &str) -> &str {
    let within = |open, close| text.strip_prefix(open).and_then(|rest| rest.strip_suffix(close));
    within('[', ']').or_else(|| within('(', ')').filter(|rest| !rest.contains(['(', ')']))).unwrap_or(text)
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
