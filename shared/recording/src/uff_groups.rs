//! Groups of functions of a universal file: those of one kind over one abscissa, and which of them
//! is read.
//!
//! A whole test holds time histories, responses, coherences, spectra. Where nobody chose, the only
//! group of responses or time histories is read, of a file without them the only group of spectra;
//! the others are named and counted. Coherences, cross spectra and mode indicators are no
//! responses: they are refused by name. Where several groups could be meant, a name chooses.

use crate::Imported;
use crate::error::RecordingError;
use crate::function_kind::FunctionKind;
use crate::uff::{Contents, listed};
use crate::uff_columns::{of_frequency, of_time};
use crate::uff_dataset::{Domain, Function};
use std::collections::BTreeMap;

/// Names that an error lists.
const LISTED: usize = 20;
const EXPORT: &str = "export time histories or frequency responses as dataset 58";

/// Functions of a universal file that are read together.
#[derive(Debug)]
pub struct UffGroup {
    /// `responses`, `responses (401 lines)`, `time 2`: short, the same for the same file.
    pub name: String,
    pub imported: Imported,
    pub kind: FunctionKind,
}

/// A group before it is imported.
struct Group<'a> {
    name: String,
    kind: FunctionKind,
    domain: Domain,
    functions: Vec<&'a Function>,
}

/// Groups by rising line of their first functions; behind several groups of time histories one
/// that holds them all.
fn grouped(contents: &Contents) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for function in &contents.functions {
        let same = |group: &&mut Group<'_>| {
            let first = group.functions[0];
            (group.kind, group.domain) == (function.kind, function.domain) && first.abscissa == function.abscissa
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.functions.push(function),
            None => groups.push(Group {
                name: String::new(),
                kind: function.kind,
                domain: function.domain,
                functions: vec![function],
            }),
        }
    }
    let names: Vec<String> = (0..groups.len()).map(|k| name(&groups, k)).collect();
    groups.iter_mut().zip(names).for_each(|(group, name)| group.name = name);
    let times: Vec<&Group<'_>> = groups.iter().filter(|group| group.kind == FunctionKind::Time).collect();
    if times.len() > 1 {
        let functions = times.iter().flat_map(|group| group.functions.iter().copied()).collect();
        groups.push(Group { name: "time".into(), kind: FunctionKind::Time, domain: Domain::Time, functions });
    }
    groups
}

/// The class; where there are several of it the count of lines, and where these are equal a number.
fn name(groups: &[Group<'_>], k: usize) -> String {
    let class = |group: &Group<'_>| match group.kind {
        FunctionKind::Time => "time",
        kind => kind.words().1,
    };
    let word = class(&groups[k]);
    let alike: Vec<usize> = (0..groups.len()).filter(|other| class(&groups[*other]) == word).collect();
    let lines = |k: usize| groups[k].functions[0].abscissa.len();
    if alike.len() == 1 {
        return word.to_string();
    }
    if groups[k].domain == Domain::Frequency && alike.iter().filter(|other| lines(**other) == lines(k)).count() == 1 {
        return format!("{word} ({} lines)", lines(k));
    }
    format!("{word} {}", alike.iter().filter(|other| **other <= k).count())
}

/// Every group, imported.
///
/// # Errors
/// A file without functions, and what makes a number uncertain.
pub(crate) fn all(file: &str, contents: &Contents) -> Result<Vec<UffGroup>, RecordingError> {
    let groups = grouped(contents);
    if groups.is_empty() {
        return Err(no_function(file));
    }
    let import = |group: &Group<'_>| {
        let imported = imported(file, contents, group)?;
        Ok(UffGroup { name: group.name.clone(), imported, kind: group.kind })
    };
    groups.iter().map(import).collect()
}

/// The group `name`.
///
/// # Errors
/// Another name, what makes a number uncertain, and functions that hold no resonances.
pub(crate) fn named(file: &str, contents: &Contents, name: &str) -> Result<Imported, RecordingError> {
    let groups = grouped(contents);
    match groups.iter().find(|group| group.name == name) {
        Some(group) if group.kind.has_resonances() => imported(file, contents, group),
        Some(group) => Err(no_resonances(file, &[group])),
        None if groups.is_empty() => Err(no_function(file)),
        None => Err(several(file, &groups, &format!("no dataset is called '{}'; there are", name.escape_debug()))),
    }
}

/// What is read where nobody chose.
///
/// # Errors
/// Several groups that could be meant, none at all, and what makes a number uncertain.
pub(crate) fn unasked(file: &str, contents: &Contents, clocks_of_their_own: bool) -> Result<Imported, RecordingError> {
    let groups = grouped(contents);
    if groups.is_empty() {
        return Err(no_function(file));
    }
    // the last group of time histories holds them all
    if let Some(time) = groups.iter().rev().find(|group| clocks_of_their_own && group.kind == FunctionKind::Time) {
        return imported(file, contents, time);
    }
    let best = groups.iter().filter_map(|group| group.kind.precedence()).min();
    let meant: Vec<&Group<'_>> =
        groups.iter().filter(|group| best.is_some_and(|best| group.kind.precedence() == Some(best))).collect();
    match &meant[..] {
        [one] => imported(file, contents, one),
        _ => Err(several(file, &groups, "the file holds several datasets")),
    }
}

fn imported(file: &str, contents: &Contents, group: &Group<'_>) -> Result<Imported, RecordingError> {
    let mut notes = Vec::new();
    if !contents.others.is_empty() {
        notes.push(format!("datasets that are not 58 are left out: {}", listed(&contents.others)));
    }
    notes.extend(left_out(contents, group));
    let functions = &group.functions;
    let mut imported = match group.domain {
        Domain::Time => of_time(file, functions, contents.units, &mut notes)?,
        Domain::Frequency => of_frequency(file, functions, contents.units, &mut notes)?,
    };
    imported.notes_mut().append(&mut notes);
    Ok(imported)
}

/// `2 coherence functions are no responses: left out`.
fn left_out(contents: &Contents, group: &Group<'_>) -> Option<String> {
    let mut counts: BTreeMap<FunctionKind, usize> = BTreeMap::new();
    for function in &contents.functions {
        *counts.entry(function.kind).or_default() += 1;
    }
    let taken = counts.entry(group.kind).or_default();
    *taken = taken.saturating_sub(group.functions.len());
    let more = counts.remove(&group.kind).filter(|more| *more > 0);
    let others: Vec<String> = counts.iter().map(|(kind, count)| kind.counted(*count)).collect();
    let (one, several) = group.kind.words();
    let are = if counts.values().sum::<usize>() == 1 { format!("is no {one}") } else { format!("are no {several}") };
    let others = (!others.is_empty()).then(|| format!("{} {are}: left out", others.join(", ")));
    let more = more.map(|more| format!("{} of other datasets: left out", group.kind.counted(more)));
    let all: Vec<String> = others.into_iter().chain(more).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

fn names(groups: &[&Group<'_>]) -> String {
    let all: Vec<String> = groups.iter().take(LISTED).map(|group| format!("'{}'", group.name)).collect();
    let more = groups.len().saturating_sub(LISTED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{more}", all.join(", "))
}

/// The error that lists what could be chosen.
fn several(file: &str, groups: &[Group<'_>], found: &str) -> RecordingError {
    let all: Vec<&Group<'_>> = groups.iter().filter(|group| group.kind.has_resonances()).collect();
    let [first, ..] = &all[..] else { return no_resonances(file, &groups.iter().collect::<Vec<_>>()) };
    let line = all.get(1).unwrap_or(first).functions[0].line;
    bad(file, line, format!("{found}: {}", names(&all)), &format!("choose one: --dataset '{}'", first.name))
}

fn no_resonances(file: &str, groups: &[&Group<'_>]) -> RecordingError {
    let mut counts: BTreeMap<FunctionKind, usize> = BTreeMap::new();
    for group in groups {
        *counts.entry(group.kind).or_default() += group.functions.len();
    }
    let line = groups.iter().map(|group| group.functions[0].line).min().unwrap_or(1);
    let all: Vec<String> = counts.iter().map(|(kind, count)| kind.counted(*count)).collect();
    let found = format!("{}: no time history, response or spectrum", all.join(", "));
    bad(file, line, found, "export the frequency responses or the time histories beside them")
}

fn no_function(file: &str) -> RecordingError {
    bad(file, 1, "no dataset 58 (function at a node) is in the file".into(), EXPORT)
}

fn bad(file: &str, line: u64, found: String, cure: &str) -> RecordingError {
    RecordingError::BadUff { file: file.into(), line, found, cure: cure.into() }
}
