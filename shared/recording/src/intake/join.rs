//! Datasets of a file as a recording: the one that is meant, or all that have a clock side by side.

use super::names::listed;
use super::origin::origin_note;
use super::plan::{Kind, Plan, Planned, Seen, Source, plan};
use super::times::Times;
use super::{Assignment, Intake};
use crate::Imported;
use crate::conversions::series;
use crate::dataset::{Axis, RawDataset};
use crate::error::RecordingError;
use crate::rows::Rows;
use crate::series::{SeriesSet, check};
use crate::table::Column;
use crate::units::{Unit, unit_named};
use channels::Channel;

/// A file's datasets as a recording.
///
/// # Errors
/// A dataset that is not there, none that has a clock, what [`plan`] rejects.
pub(crate) fn recording_of(file: &str, datasets: Vec<RawDataset>, intake: &Intake) -> Result<Imported, RecordingError> {
    let mut datasets = chosen(file, datasets, intake)?;
    if datasets.len() == 1 {
        let dataset = datasets.remove(0);
        let own = in_dataset(&dataset, intake, false);
        return one(file, &dataset, &own);
    }
    let mut all = SeriesSet::new(file);
    let (mut first_error, mut left_out) = (None, Vec::new());
    for dataset in &datasets {
        let own = in_dataset(dataset, intake, true);
        match one(file, dataset, &own).and_then(series) {
            Ok(set) => add(&mut all, dataset, &set),
            Err(error) => {
                left_out.push(format!("`{}` ({})", dataset.name, error.without_file(file)));
                first_error.get_or_insert(error);
            }
        }
    }
    if all.recording.channels.is_empty() {
        return Err(first_error.unwrap_or_else(|| RecordingError::Empty { file: file.into() }));
    }
    for assignment in &intake.channels {
        if all.recording.channel_named(&assignment.own).is_none() {
            let names: Vec<String> = all.recording.channels.iter().map(|channel| channel.name.clone()).collect();
            return Err(assignment.absent(file, &names));
        }
    }
    if !left_out.is_empty() {
        all.notes.push(format!("datasets left out: {}", listed(&left_out)));
    }
    check(&all.recording)?;
    Ok(Imported::Series(all))
}

/// The datasets that are meant: all, or the one whose name the intake says.
fn chosen(file: &str, datasets: Vec<RawDataset>, intake: &Intake) -> Result<Vec<RawDataset>, RecordingError> {
    let Some(wanted) = &intake.dataset else { return Ok(datasets) };
    let names: Vec<String> = datasets.iter().map(|dataset| dataset.name.clone()).collect();
    match datasets.into_iter().find(|dataset| is_called(&dataset.name, wanted)) {
        Some(dataset) => Ok(vec![dataset]),
        None => Err(no_such_dataset(file, wanted, &names)),
    }
}

/// Whether a dataset is meant by `wanted`: its name, whatever its case, with or without `/`.
pub(crate) fn is_called(name: &str, wanted: &str) -> bool {
    name.trim_start_matches('/').eq_ignore_ascii_case(wanted.trim_start_matches('/'))
}

pub(crate) fn no_such_dataset(file: &str, wanted: &str, names: &[String]) -> RecordingError {
    let near = crate::error::nearest(wanted, names.iter().map(String::as_str));
    let meant = near.map_or(String::new(), |near| format!("did you mean `{near}`? "));
    RecordingError::WhichDataset {
        file: file.into(),
        found: format!("no dataset is called `{wanted}`"),
        cure: format!("{meant}the file has {}", listed(names)),
    }
}

/// What is said of a dataset, names without the dataset's; among others what names a column of
/// another dataset is left out.
fn in_dataset(dataset: &RawDataset, intake: &Intake, among_others: bool) -> Intake {
    let prefix = format!("{}.", dataset.name);
    let bare = |name: &str| name.strip_prefix(&prefix).filter(|_| !dataset.name.is_empty()).unwrap_or(name).to_owned();
    let has = |name: &str| !among_others || dataset.columns.iter().any(|column| column.name.eq_ignore_ascii_case(name));
    let of = |assignment: &Assignment| {
        let theirs = bare(&assignment.theirs);
        has(&theirs).then(|| Assignment { theirs, ..assignment.clone() })
    };
    let clock = intake.time_column.as_ref().map(|clock| super::TimeColumn { name: bare(&clock.name), ..clock.clone() });
    let rows = |clock: &super::TimeColumn| clock.name == super::TimeColumn::ROWS;
    let time_column = clock.filter(|clock| has(&clock.name) || rows(clock));
    Intake { time_column, channels: intake.channels.iter().filter_map(of).collect(), ..Intake::default() }
}

/// Adds a dataset's channels; the first dataset's origin is that of all.
fn add(all: &mut SeriesSet, dataset: &RawDataset, set: &SeriesSet) {
    if all.recording.channels.is_empty() {
        all.origin_s = set.origin_s;
    }
    let later_s = (set.origin_s - all.origin_s) as f64;
    for of_set in &set.recording.channels {
        let mut channel = of_set.clone();
        if later_s != 0.0 {
            channel.time_s.iter_mut().for_each(|time| *time += later_s);
        }
        all.push(channel, set.unit_in_file(of_set));
    }
    let of = if dataset.name.is_empty() { String::new() } else { format!("{}: ", dataset.name) };
    all.notes.extend(set.notes.iter().map(|note| format!("{of}{note}")));
}

/// One dataset as a recording; its channels are called `dataset.channel`, those that the user named
/// as the user named them.
fn one(file: &str, dataset: &RawDataset, intake: &Intake) -> Result<Imported, RecordingError> {
    let mut plan = planned(file, dataset, intake)?;
    let assigned = |name: &str| intake.channels.iter().any(|of| of.own == name);
    for of in plan.columns.iter_mut().filter(|of| !dataset.name.is_empty() && !assigned(&of.name)) {
        let own = format!("{}.{}", dataset.name, of.name);
        plan.second_clocks.iter_mut().for_each(|second| second.rename(&of.name, &own));
        of.name = own;
    }
    let (imported, origin_s) = rows(file, dataset, &plan)?;
    let mut imported = plan.second_clocks.iter().try_fold(imported, |imported, second| second.given(imported))?;
    let notes = imported.notes_mut();
    notes.extend(plan.notes);
    notes.extend(origin_note(origin_s));
    notes.extend(dataset.notes.iter().cloned());
    Ok(imported)
}

/// What becomes of a dataset's columns; where its format says what leads the rows, that leads them.
pub(crate) fn planned(file: &str, dataset: &RawDataset, intake: &Intake) -> Result<Plan, RecordingError> {
    const SAMPLE: usize = 200;
    let columns: Vec<Seen> = dataset
        .columns
        .iter()
        .map(|column| {
            let sample: Vec<f64> =
                column.values.iter().copied().filter(|value| value.is_finite()).take(SAMPLE).collect();
            let kind = if sample.is_empty() { Kind::Empty } else { Kind::Number };
            let is_constant = sample.len() > 2 && sample.iter().all(|value| *value == sample[0]);
            Seen { header: column.name.clone(), unit: column.unit.clone(), kind, sample, is_constant }
        })
        .collect();
    let mut own = intake.clone();
    if own.time_column.is_none() {
        own.time_column = match dataset.axis {
            Axis::Time(at) => {
                let unit = dataset.columns[at].unit.as_deref().unwrap_or("s");
                Some(super::TimeColumn { name: (at + 1).to_string(), unit: unit_named(unit) })
            }
            Axis::Uniform { interval_s, .. } => {
                let unit = Unit::scaled("s", interval_s, 1.0);
                Some(super::TimeColumn { name: super::TimeColumn::ROWS.into(), unit: Some(unit) })
            }
            Axis::Unknown | Axis::Frequency(_) => None,
        };
    }
    plan(&Source { file, line: 0 }, &columns, &own)
}

/// The rows of a dataset, and what their times count from.
fn rows(file: &str, dataset: &RawDataset, plan: &Plan) -> Result<(Imported, i64), RecordingError> {
    let columns = plan.columns.iter().map(Planned::column);
    let mut rows = Rows::new(file, plan.axis, columns.collect());
    let mut times = Times::of(dataset, &plan.clock);
    let mut row = Vec::with_capacity(plan.columns.len() + 1);
    for i in 0..dataset.rows() {
        let at = |column: usize| dataset.columns[column].values.get(i).copied().unwrap_or(f64::NAN);
        let time = times.next(i);
        if time.is_nan() {
            continue;
        }
        row.clear();
        row.push(time);
        row.extend(plan.columns.iter().map(|of| of.unit.to_si(at(of.at)) * of.scale).map(finite));
        rows.push(i as u64 + 1, &row)?;
    }
    rows.origin_s = times.origin_s();
    rows.finish().map(|imported| (imported, times.origin_s()))
}

/// What is infinite is no sample.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { f64::NAN }
}

/// Names, units and scales of a recording whose format has them.
pub(crate) fn applied(imported: Imported, intake: &Intake) -> Result<Imported, RecordingError> {
    if intake.channels.is_empty() {
        return Ok(imported);
    }
    match imported {
        Imported::Spectrum(mut spectrum) => {
            for assignment in &intake.channels {
                let names = || spectrum.columns.iter().map(|column| column.name.clone()).collect::<Vec<_>>();
                let at = spectrum.column_named(&assignment.theirs);
                let at = at.ok_or_else(|| assignment.absent(&spectrum.file, &names()))?;
                assign(&mut spectrum.columns[at], assignment);
            }
            Ok(Imported::Spectrum(spectrum))
        }
        Imported::Segments(mut segments) => {
            let parts = core::mem::take(&mut segments.parts);
            segments.parts = parts.into_iter().map(|part| renamed(part, intake)).collect::<Result<_, _>>()?;
            Ok(Imported::Segments(segments))
        }
        Imported::Table(table) => {
            let set = renamed(series(Imported::Table(table))?, intake)?;
            set.table().map(Imported::Table)
        }
        other => renamed(series(other)?, intake).map(Imported::Series),
    }
}

fn assign(column: &mut Column, assignment: &Assignment) {
    column.name.clone_from(&assignment.own);
    if let Some(unit) = assignment.unit {
        let of_file = unit_named(&column.unit_in_file).unwrap_or_else(Unit::not_stated);
        let (offset, slope) = (of_file.to_si(0.0), of_file.to_si(1.0) - of_file.to_si(0.0));
        column.values.iter_mut().for_each(|value| *value = unit.to_si((*value - offset) / slope));
        (column.unit, column.unit_in_file) = (unit.si, assignment.unit_text.clone());
    }
    column.values.iter_mut().for_each(|value| *value *= assignment.scale);
}

/// Applies names, units and scales to channels that came with their own units.
///
/// # Errors
/// An assignment whose channel is not there.
pub(crate) fn renamed(set: SeriesSet, intake: &Intake) -> Result<SeriesSet, RecordingError> {
    if intake.channels.is_empty() {
        return Ok(set);
    }
    let mut renamed = SeriesSet::new(&set.recording.name);
    renamed.notes.clone_from(&set.notes);
    renamed.origin_s = set.origin_s;
    for assignment in &intake.channels {
        let names = || set.recording.channels.iter().map(|channel| channel.name.clone()).collect::<Vec<_>>();
        let source = set.recording.channel_named(&assignment.theirs);
        let source = source.ok_or_else(|| assignment.absent(&set.recording.name, &names()))?;
        let (channel, unit) = converted(source, set.unit_in_file(source), assignment);
        renamed.push(channel, &unit);
    }
    let taken = |name: &str| intake.channels.iter().any(|of| of.theirs == name || of.own == name);
    for channel in set.recording.channels.iter().filter(|channel| !taken(&channel.name)) {
        renamed.push(channel.clone(), set.unit_in_file(channel));
    }
    Ok(renamed)
}

/// The channel under its own name, its numbers read in the assignment's unit and scaled.
fn converted(source: &Channel, unit_in_file: &str, assignment: &Assignment) -> (Channel, String) {
    let mut channel = Channel { name: assignment.own.clone(), ..source.clone() };
    let mut given_in = unit_in_file.to_owned();
    if let Some(unit) = assignment.unit {
        // back to the numbers of the file: units are straight lines
        let of_file = unit_named(unit_in_file).unwrap_or_else(Unit::not_stated);
        let (offset, slope) = (of_file.to_si(0.0), of_file.to_si(1.0) - of_file.to_si(0.0));
        channel.value.iter_mut().for_each(|value| *value = unit.to_si((*value - offset) / slope));
        (channel.unit, given_in) = (unit.si.to_owned(), assignment.unit_text.clone());
    }
    channel.value.iter_mut().for_each(|value| *value *= assignment.scale);
    (channel, given_in)
}
