//! Universal files (UFF): functions at nodes, dataset 58 in text and in binary (58b), units of
//! dataset 164.
//!
//! What analysers and modal software of every make exchange: time responses become a table or
//! channels, frequency responses and spectra a [`Spectrum`], complex ones as pairs of columns
//! `NAME_real`, `NAME_imag`. A name is made of quantity, node and direction: `acceleration_12z`,
//! `accelerance_12z_3z` (response at 12 by force at 3). Datasets of other numbers (geometry,
//! shapes) are counted and left out. Read only: CSV holds the same with every digit.
//!
//! Source: University of Cincinnati SDRL, Universal File Datasets 58, 58b, 164.

use crate::error::RecordingError;
use crate::intake::Intake;
use crate::intake::join::applied;
use crate::rows::{Axis, Rows};
use crate::series::{SeriesSet, check};
use crate::table::Column;
use crate::uff_dataset::{Domain, Function, Quantity, read_function};
use crate::uff_lines::Text;
use crate::units::{Unit, unit_named};
use crate::{Format, Imported, file_name};
use channels::Channel;
use std::collections::BTreeMap;
use std::path::Path;

/// The universal file format.
pub struct Uff;

impl Format for Uff {
    fn name(&self) -> &'static str {
        "uff"
    }

    fn sniff(&self, head: &[u8]) -> bool {
        let mut lines = head.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii).skip_while(|line| line.is_empty());
        let dataset = |line: &[u8]| {
            let digits = line.iter().take_while(|byte| byte.is_ascii_digit()).count();
            (1..=4).contains(&digits) && line.get(digits).is_none_or(|next| *next == b'b' || *next == b' ')
        };
        lines.next() == Some(b"-1") && lines.next().is_some_and(dataset)
    }

    fn read(&self, path: &Path, intake: &Intake) -> Result<Imported, RecordingError> {
        let bytes = std::fs::read(path).map_err(|reason| RecordingError::Io {
            file: file_name(path),
            action: "read",
            reason,
        })?;
        applied(read_bytes(&file_name(path), &bytes)?, intake)
    }

    fn write(&self, imported: &Imported, path: &Path) -> Result<(), RecordingError> {
        let what = match imported {
            Imported::Table(_) => "a table (it is read only)",
            Imported::Run(_) => "a recorded run",
            Imported::Series(_) => "channels (it is read only)",
            Imported::Segments(_) => "several recordings",
            Imported::Spectrum(_) => "a spectrum (it is read only)",
        };
        Err(RecordingError::NotWritable { file: file_name(path), format: self.name(), what })
    }
}

/// Everything that was found in a file.
#[derive(Default)]
struct Contents {
    functions: Vec<Function>,
    /// Units of length and force over SI, where the file says so.
    units: Option<(f64, f64)>,
    /// How many datasets of each number were left out.
    others: BTreeMap<String, usize>,
}

fn read_bytes(file: &str, bytes: &[u8]) -> Result<Imported, RecordingError> {
    let contents = contents(Text::new(file, bytes))?;
    let (time, frequency): (Vec<_>, Vec<_>) = contents.functions.iter().partition(|f| f.domain == Domain::Time);
    let bad =
        |line, found: String, cure: &str| RecordingError::BadUff { file: file.into(), line, found, cure: cure.into() };
    let mut notes = Vec::new();
    if !contents.others.is_empty() {
        let listed: Vec<String> = contents.others.iter().map(|(number, count)| format!("{number} ({count})")).collect();
        notes.push(format!("datasets that are not 58 are left out: {}", listed.join(", ")));
    }
    let mut imported = match (time.first(), frequency.first()) {
        (None, None) => {
            let found = "no dataset 58 (function at a node) is in the file";
            return Err(bad(1, found.into(), "export time histories or frequency responses as dataset 58"));
        }
        (Some(time), Some(frequency)) => {
            let found = format!("functions of time (line {}) and of frequency (line {})", time.line, frequency.line);
            return Err(bad(time.line.max(frequency.line), found, "export them to a file of each kind"));
        }
        (Some(_), None) => of_time(file, &time, contents.units, &mut notes)?,
        (None, Some(_)) => of_frequency(file, &frequency, contents.units, &mut notes)?,
    };
    imported.notes_mut().append(&mut notes);
    Ok(imported)
}

fn contents(mut text: Text<'_>) -> Result<Contents, RecordingError> {
    let mut contents = Contents::default();
    while let Some(line) = text.next_line() {
        if line.trim().is_empty() {
            continue;
        }
        if line.trim() != "-1" {
            return Err(
                text.error(format!("`{}` stands where `-1` opens a dataset", line.trim()), "export the file again")
            );
        }
        let number = text.needed_line()?;
        let id = number.split_whitespace().next().unwrap_or_default().to_string();
        match id.as_str() {
            "58" | "58b" => {
                contents.functions.push(read_function(&mut text, &number)?);
                text.close_dataset()?;
            }
            _ => {
                let body = text.skip_dataset()?;
                match units(&id, &body) {
                    Some(units) => contents.units = Some(units),
                    None => *contents.others.entry(id).or_default() += 1,
                }
            }
        }
    }
    Ok(contents)
}

/// Of dataset 164: units of length and force, per SI unit.
fn units(id: &str, body: &[String]) -> Option<(f64, f64)> {
    let factors = body.get(1).filter(|_| id == "164")?.replace(['D', 'd'], "E");
    let mut factors = factors.split_whitespace().map_while(|word| word.parse::<f64>().ok());
    let (length, force) = (factors.next()?, factors.next()?);
    (length > 0.0 && force > 0.0).then_some((length, force))
}

/// A function as a column: its SI unit, and what its values have to be multiplied with.
struct Named {
    name: String,
    unit: &'static str,
    unit_in_file: String,
    to_si: f64,
}

fn name_all(functions: &[&Function], units: Option<(f64, f64)>, notes: &mut Vec<String>) -> Vec<Named> {
    let mut taken: BTreeMap<String, usize> = BTreeMap::new();
    let mut without = Vec::new();
    let mut all = Vec::new();
    for function in functions {
        let stem = function.name();
        let times = taken.entry(stem.clone()).or_default();
        *times += 1;
        let name = if *times == 1 { stem } else { format!("{stem}_{times}") };
        let unit_in_file = function.unit_in_words();
        let (unit, to_si) = unit_of(function, units).unwrap_or_else(|| {
            without.push(format!("{name} [{unit_in_file}]"));
            ("-", 1.0)
        });
        all.push(Named { name, unit, unit_in_file, to_si });
    }
    if !without.is_empty() {
        let some = without.iter().take(4).cloned().collect::<Vec<_>>().join(", ");
        let more = if without.len() > 4 { ", …" } else { "" };
        notes.push(format!("units that are not known or not given, values as in the file: {some}{more}"));
    }
    all
}

/// SI unit and factor from the labels; where a label is empty, from the kind of quantity and
/// dataset 164.
fn unit_of(function: &Function, units: Option<(f64, f64)>) -> Option<(&'static str, f64)> {
    let factor = |unit: &Unit| unit.to_si(1.0) - unit.to_si(0.0);
    let one = |quantity: &Quantity| -> Option<(&'static str, f64)> {
        let unit = match quantity.label() {
            Some(label) => unit_named(label)?,
            None => unit_named(quantity.si()?)?,
        };
        let file_unit = match (quantity.label(), units, quantity.si()?) {
            (None, Some((_, force)), "N") => 1.0 / force,
            (None, Some((length, _)), _) => 1.0 / length,
            _ => factor(&unit),
        };
        Some((unit.si, file_unit))
    };
    let (above, by) = one(&function.ordinate)?;
    match &function.denominator {
        None => Some((above, by)),
        Some(denominator) => {
            let (below, divide) = one(denominator)?;
            Some((unit_named(&format!("{above}/{below}"))?.si, by / divide))
        }
    }
}

fn of_time(
    file: &str,
    functions: &[&Function],
    units: Option<(f64, f64)>,
    notes: &mut Vec<String>,
) -> Result<Imported, RecordingError> {
    let named = name_all(functions, units, notes);
    let scaled = |(function, named): (&&Function, &Named)| -> Vec<f64> {
        function.real.iter().map(|y| y * named.to_si).collect()
    };
    if functions.iter().all(|function| function.abscissa == functions[0].abscissa) {
        let empty = named.iter().map(|named| column(named, Vec::new())).collect();
        let columns: Vec<Vec<f64>> = functions.iter().zip(&named).map(scaled).collect();
        let mut rows = Rows::new(file, Axis::Time, empty);
        let mut row = Vec::new();
        for (i, time) in functions[0].abscissa.iter().enumerate() {
            row.clear();
            row.push(*time);
            row.extend(columns.iter().map(|column| column[i]));
            rows.push_full(functions[0].line, &row)?;
        }
        return rows.finish();
    }
    let mut set = SeriesSet::new(file);
    for (function, named) in functions.iter().zip(&named) {
        let channel = Channel::new(&named.name, named.unit, function.abscissa.clone(), scaled((function, named)));
        set.push(channel, &named.unit_in_file);
    }
    check(&set.recording)?;
    Ok(Imported::Series(set))
}

fn of_frequency(
    file: &str,
    functions: &[&Function],
    units: Option<(f64, f64)>,
    notes: &mut Vec<String>,
) -> Result<Imported, RecordingError> {
    let first = functions[0];
    if let Some(other) = functions.iter().find(|function| function.abscissa != first.abscissa) {
        return Err(RecordingError::BadUff {
            file: file.into(),
            line: other.line,
            found: format!(
                "`{}` has other frequency lines than `{}` (line {})",
                other.name(),
                first.name(),
                first.line
            ),
            cure: "export functions with different lines to files of their own".into(),
        });
    }
    let named = name_all(functions, units, notes);
    let mut columns = Vec::new();
    for (function, named) in functions.iter().zip(&named) {
        let scaled = |values: &[f64]| values.iter().map(|y| y * named.to_si).collect();
        match &function.imaginary {
            None => columns.push(column(named, scaled(&function.real))),
            Some(imaginary) => {
                for (suffix, values) in [("real", &function.real), ("imag", imaginary)] {
                    let of_part = column(named, scaled(values));
                    columns.push(Column { name: format!("{}_{suffix}", named.name), ..of_part });
                }
            }
        }
    }
    let empty = columns.iter().map(|column| Column { values: Vec::new(), ..column.clone() }).collect();
    let mut rows = Rows::new(file, Axis::Frequency, empty);
    for (i, frequency_hz) in first.abscissa.iter().enumerate() {
        let row: Vec<f64> =
            core::iter::once(*frequency_hz).chain(columns.iter().map(|column| column.values[i])).collect();
        rows.push_full(first.line, &row)?;
    }
    rows.finish()
}

fn column(named: &Named, values: Vec<f64>) -> Column {
    Column { name: named.name.clone(), unit: named.unit, unit_in_file: named.unit_in_file.clone(), values }
}
