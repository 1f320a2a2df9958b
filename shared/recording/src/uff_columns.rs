//! Functions of a universal file as columns: their names, their SI units, and a table, channels or
//! a spectrum of them.

use crate::Imported;
use crate::error::RecordingError;
use crate::function_kind::FunctionKind;
use crate::rows::{Axis, Rows};
use crate::series::{SeriesSet, check};
use crate::table::Column;
use crate::uff_dataset::{Function, Quantity};
use crate::units::unit_named;
use channels::Channel;
use std::collections::BTreeMap;

/// Units of length and force over SI, where the file says so.
pub(crate) type FileUnits = Option<(f64, f64)>;

/// A function as a column: its SI unit, and what its values have to be multiplied with.
struct Named {
    name: String,
    kind: FunctionKind,
    unit: &'static str,
    unit_in_file: String,
    to_si: f64,
}

fn name_all(functions: &[&Function], units: FileUnits, notes: &mut Vec<String>) -> Vec<Named> {
    let mut taken: BTreeMap<String, usize> = BTreeMap::new();
    let mut without = Vec::new();
    let mut assumed = Vec::new();
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
        if units.is_none() && is_without_unit(function) {
            assumed.push(format!("{name} [{unit}]"));
        }
        all.push(Named { name, kind: function.kind, unit, unit_in_file, to_si });
    }
    let first = |of: &[String]| of[..of.len().min(4)].join(", ") + if of.len() > 4 { ", …" } else { "" };
    if !without.is_empty() {
        notes.push(format!("units that are not known or not given, values as in the file: {}", first(&without)));
    }
    if !assumed.is_empty() {
        notes.push(format!("neither labels nor a dataset 164 state units, SI is assumed: {}", first(&assumed)));
    }
    all
}

/// Whether the kind of a quantity alone says in what unit it may be.
fn is_without_unit(function: &Function) -> bool {
    let silent = |quantity: &Quantity| quantity.label().is_none() && quantity.si().is_some_and(|si| si != "-");
    silent(&function.ordinate) || function.denominator.as_ref().is_some_and(silent)
}

/// SI unit and factor from the labels; where a label is empty, from the kind of quantity and
/// dataset 164.
fn unit_of(function: &Function, units: FileUnits) -> Option<(&'static str, f64)> {
    let one = |quantity: &Quantity| -> Option<(&'static str, f64)> {
        let unit = match quantity.label() {
            Some(label) => unit_named(label)?,
            None => unit_named(quantity.si()?)?,
        };
        let file_unit = match (quantity.label(), units, quantity.si()?) {
            (None, Some((_, force)), "N") => 1.0 / force,
            (None, Some((length, _)), _) => 1.0 / length,
            _ => unit.to_si(1.0) - unit.to_si(0.0),
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

/// Time histories: a table where all have the same times, channels otherwise.
pub(crate) fn of_time(
    file: &str,
    functions: &[&Function],
    units: FileUnits,
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

/// Functions over the same lines: a spectrum.
pub(crate) fn of_frequency(
    file: &str,
    functions: &[&Function],
    units: FileUnits,
    notes: &mut Vec<String>,
) -> Result<Imported, RecordingError> {
    let first = functions[0];
    let named = name_all(functions, units, notes);
    let mut columns = Vec::new();
    for (function, named) in functions.iter().zip(&named) {
        let scaled = |values: &[f64]| values.iter().map(|y| y * named.to_si).collect();
        match parts(file, function, &named.name)? {
            (values, None) => columns.push(column(named, scaled(&values))),
            (real, Some(imaginary)) => {
                for (suffix, values) in [("real", &real), ("imag", &imaginary)] {
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
    let unit_in_file = named.unit_in_file.clone();
    Column { name: named.name.clone(), unit: named.unit, unit_in_file, kind: named.kind, values }
}

/// Values over the lines: real and imaginary parts, or one real number a line. Spectra of outputs
/// become magnitudes: the root of a power, the size of a complex number.
fn parts(file: &str, function: &Function, name: &str) -> Result<(Vec<f64>, Option<Vec<f64>>), RecordingError> {
    let real = function.real.clone();
    let complex = function.imaginary.clone();
    match function.kind {
        FunctionKind::Response => Ok((real, complex)),
        FunctionKind::AutoSpectrum { power: true } | FunctionKind::PowerSpectralDensity => {
            check_power(file, function, name)?;
            Ok((real.iter().map(|power| power.sqrt()).collect(), None))
        }
        FunctionKind::AutoSpectrum { power: false } | FunctionKind::Spectrum => {
            let size = |imaginary: &Vec<f64>| real.iter().zip(imaginary).map(|(re, im)| re.hypot(*im)).collect();
            Ok((complex.as_ref().map(size).unwrap_or(real), None))
        }
        // real functions that were coded as complex ones
        _ => Ok((real, complex.filter(|imaginary| imaginary.iter().any(|im| *im != 0.0)))),
    }
}

fn check_power(file: &str, function: &Function, name: &str) -> Result<(), RecordingError> {
    let (what, _) = function.kind.words();
    let imaginary = function.imaginary.iter().flatten().position(|im| *im != 0.0);
    let bad = match (function.real.iter().position(|power| *power < 0.0), imaginary) {
        (Some(at), _) => format!("{} at {} Hz, which is no power", function.real[at], function.abscissa[at]),
        (None, Some(at)) => format!("an imaginary part at {} Hz", function.abscissa[at]),
        (None, None) => return Ok(()),
    };
    Err(RecordingError::BadUff {
        file: file.into(),
        line: function.line,
        found: format!("the {what} `{name}` has {bad}"),
        cure: "export it as a linear power (no dB), or leave it out".into(),
    })
}
