//! Text tables with one sample a row: time, the name of the channel, its value.
//!
//! A column of texts names the channels of its rows where its header says so (`channel`, `signal`)
//! and the only column of numbers is called `value`, or where rows of one time differ in it: most
//! times stand in several rows, no time twice under one name. With several columns of numbers the channels are called
//! `name.column`.

use super::{each_row, notes_of, places_of, seen};
use crate::error::RecordingError;
use crate::intake::Intake;
use crate::intake::join::renamed;
use crate::intake::names::heading;
use crate::intake::plan::{Clock, Kind, Plan, Planned, Seen, Source, plan};
use crate::rows::Rows;
use crate::series::{SeriesSet, check};
use crate::text::cells::Cells;
use crate::text::dialect::is_missing;
use crate::text::encoding::text_of;
use crate::text::layout::layout;
use crate::text::lines::Lines;
use crate::text::seen::Layout;
use crate::units::{Unit, unit_named};
use crate::{Imported, conversions};
use std::collections::{HashMap, HashSet};
use std::io::BufRead;

/// Rows for each time from which on a time stands in several rows: half of the times in two.
const ROWS_PER_TIME: f64 = 1.5;
/// Channels that a column may name.
const CHANNELS_MAX: usize = 1024;

/// How the rows of such a file are read.
pub(super) struct Tidy {
    layout: Layout,
    plan: Plan,
    /// Column of the names.
    names: usize,
    /// Column of the units, where there is one.
    units: Option<usize>,
}

impl Tidy {
    /// `None` where the file has a column for each channel.
    pub fn of(file: &str, lines: &mut Lines<impl BufRead>, intake: &Intake) -> Result<Option<Self>, RecordingError> {
        let ahead: Vec<(u64, String)> =
            lines.look_ahead(file)?.iter().map(|(line, text)| (*line, text_of(text))).collect();
        let Some(layout) = layout(&ahead) else { return Ok(None) };
        let columns = seen(&layout);
        let texts = || columns.iter().enumerate().filter(|(_, column)| column.kind == Kind::Text);
        if texts().next().is_none() {
            return Ok(None);
        }
        let source = Source { file, line: layout.header_line };
        let clock = Intake { time_column: intake.time_column.clone(), ..Intake::default() };
        let Ok(mut plan) = plan(&source, &columns, &clock) else { return Ok(None) };
        let of_units = |column: &Seen| matches!(word(column).as_str(), "unit" | "units" | "einheit" | "unité");
        let units = texts().find(|(_, column)| of_units(column)).map(|(at, _)| at);
        let mut others = texts().filter(|(at, _)| Some(*at) != units);
        let names = others.find(|(at, column)| {
            let of_values = plan.columns.iter().filter(|of| is_of_values(&columns[of.at])).count() == 1;
            let others = || plan.columns.iter().filter(|of| !is_of_values(&columns[of.at]));
            let numbered = of_values && others().all(|of| numbers_names(&layout, of.at, *at));
            (numbered && is_of_channels(column)) || divides_times(&layout, &plan.clock, *at)
        });
        let Some((names, column)) = names else { return Ok(None) };
        // what numbers the names is no channel
        let is_value = |of: &Planned| is_of_values(&columns[of.at]) || !numbers_names(&layout, of.at, names);
        if is_of_channels(column) && plan.columns.iter().any(|of| is_of_values(&columns[of.at])) {
            plan.columns.retain(is_value);
        }
        plan.notes.retain(|note| !note.starts_with("left out") && !note.starts_with("unit not stated"));
        Ok(Some(Tidy { names, units, plan, layout }))
    }

    /// The channels of the file.
    pub fn read(
        self,
        file: &str,
        lines: &mut Lines<impl BufRead>,
        intake: &Intake,
    ) -> Result<Imported, RecordingError> {
        let mut channels = Channels { file, of: &self, order: Vec::new(), by_name: HashMap::new(), nameless: 0 };
        let width = super::width_of(&self.layout);
        let mut cells = Cells::new(file, self.layout.dialect, &self.plan, width, &self.layout.header);
        let others = each_row(file, lines, self.layout.first_line, &mut cells, &mut |cells, line, row| {
            channels.push(cells, line, row)
        })?;
        let mut notes = self.plan.notes.clone();
        let rows = channels.order.iter().map(|one| one.rows.count()).sum();
        notes.extend(notes_of(&cells, &self.plan, others, rows)?);
        let origin_s = cells.origin_s();
        if let Some(error) =
            cells.counts.iter_mut().filter(|of| !of.is_of_numbers()).find_map(|of| of.first_text.take())
        {
            return Err(error);
        }
        let header = self.layout.header.get(self.names).map_or(String::new(), |header| heading(header).name);
        notes.push(format!("`{header}` names the channel of each row: {} channels", channels.order.len()));
        let mut set = channels.finish(&mut notes)?;
        (set.origin_s, set.notes) = (origin_s, notes);
        check(&set.recording)?;
        renamed(set, intake).map(Imported::Series)
    }
}

/// Whether the header of a column says that it names channels.
fn is_of_channels(column: &Seen) -> bool {
    matches!(
        word(column).as_str(),
        "channel"
            | "signal"
            | "variable"
            | "quantity"
            | "parameter"
            | "measurement"
            | "metric"
            | "series"
            | "field"
            | "sensor"
            | "topic"
            | "key"
            | "name"
            | "kanal"
            | "messgröße"
            | "größe"
    )
}

/// Whether the header of a column says no more than that it holds values.
fn is_of_values(column: &Seen) -> bool {
    matches!(word(column).as_str(), "value" | "values" | "val" | "reading" | "data" | "wert" | "valeur" | "valor")
}

/// The last word of a header in small letters: `channel_name` and `Signal name` are of a name.
fn word(column: &Seen) -> String {
    let name = heading(&column.header).name.to_lowercase();
    let last = name.split([' ', '_', '.']).rfind(|word| !matches!(*word, "name" | "id" | ""));
    last.unwrap_or(&name).to_owned()
}

/// Whether the column `at` is empty, or has one number for each name of the column `names`.
fn numbers_names(layout: &Layout, at: usize, names: usize) -> bool {
    let mut of_name: HashMap<&str, &str> = HashMap::new();
    let pairs = layout.rows.iter().filter_map(|row| Some((row.get(names)?.as_str(), row.get(at)?.as_str())));
    pairs.into_iter().all(|(name, number)| {
        let is_whole = number.is_empty() || number.parse::<i64>().is_ok();
        is_whole && *of_name.entry(name).or_insert(number) == number
    })
}

/// Whether rows of one time differ in the text at `names`, and none repeats it.
fn divides_times(layout: &Layout, clock: &Clock, names: usize) -> bool {
    let time_of = |row: &Vec<String>| -> Option<String> {
        match clock {
            Clock::Number { at, .. } | Clock::Steps { at, .. } => row.get(*at).cloned(),
            Clock::Stamps(parts) => Some(parts.iter().filter_map(|(at, _)| row.get(*at)).cloned().collect()),
            Clock::Rows { .. } => None,
        }
    };
    let mut times = HashSet::new();
    let mut samples = HashSet::new();
    for row in &layout.rows {
        let (Some(time), Some(name)) = (time_of(row), row.get(names)) else { return false };
        times.insert(time.clone());
        if !samples.insert((time, name)) {
            return false;
        }
    }
    samples.len() as f64 >= ROWS_PER_TIME * times.len() as f64
}

/// The rows of one name.
struct Channel {
    name: String,
    unit: String,
    rows: Rows,
}

/// Rows by name, in the order of the file.
struct Channels<'a> {
    file: &'a str,
    of: &'a Tidy,
    order: Vec<Channel>,
    by_name: HashMap<String, usize>,
    /// Rows without a name.
    nameless: u64,
}

impl Channels<'_> {
    fn push(&mut self, cells: &Cells<'_>, line: u64, row: &[f64]) -> Result<(), RecordingError> {
        let name = cells.text_at(self.of.names);
        if is_missing(&name) {
            self.nameless += 1;
            return Ok(());
        }
        let at = match self.by_name.get(&name) {
            Some(at) => *at,
            None => self.add(name, self.of.units.map(|at| cells.text_at(at)).unwrap_or_default())?,
        };
        self.order[at].rows.push(line, row)
    }

    fn add(&mut self, name: String, unit: String) -> Result<usize, RecordingError> {
        if self.order.len() == CHANNELS_MAX {
            let found = format!("column {} has more than {CHANNELS_MAX} names", self.of.names + 1);
            let cure = "write a column for each channel".into();
            return Err(RecordingError::UnknownFormat { file: self.file.into(), found, cure });
        }
        let Tidy { plan, .. } = self.of;
        let rows = Rows::new(self.file, plan.axis, plan.columns.iter().map(Planned::column).collect());
        let (header, positions) = places_of(plan);
        self.by_name.insert(name.clone(), self.order.len());
        self.order.push(Channel { name, unit, rows: rows.with_places(header, positions) });
        Ok(self.order.len() - 1)
    }

    fn finish(self, notes: &mut Vec<String>) -> Result<SeriesSet, RecordingError> {
        let mut all = SeriesSet::new(self.file);
        let mut silent = Vec::new();
        for Channel { name, unit, rows } in self.order {
            let set = conversions::series(rows.finish()?)?;
            let alone = self.of.plan.columns.len() == 1;
            notes.extend(set.notes.iter().map(|note| format!("{name}: {note}")));
            for own in set.recording.channels.iter().filter(|channel| !channel.value.is_empty()) {
                let mut channel = own.clone();
                let mut unit_in_file = set.unit_in_file(own).to_owned();
                let stated = heading(&name);
                channel.name = if alone { stated.name } else { format!("{name}.{}", own.name) };
                if own.unit == Unit::not_stated().si && alone {
                    let text = Some(unit.clone()).filter(|text| !text.is_empty()).or(stated.unit).unwrap_or_default();
                    match unit_named(&text).filter(|_| !text.is_empty()) {
                        Some(unit) => {
                            channel.value.iter_mut().for_each(|value| *value = unit.to_si(*value));
                            (channel.unit, unit_in_file) = (unit.si.into(), text);
                        }
                        None => silent.push(channel.name.clone()),
                    }
                }
                all.push(channel, &unit_in_file);
            }
        }
        if self.nameless > 0 {
            notes.push(format!("{} row(s) without a name are left out", self.nameless));
        }
        if let Some(first) = silent.first() {
            let listed = crate::intake::names::listed(&silent);
            notes.push(format!("unit not stated: {listed}; say it: --channel '{first} = {first} [UNIT]'"));
        }
        Ok(all)
    }
}
