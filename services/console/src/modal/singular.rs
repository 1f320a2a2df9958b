//! Singular values over frequency, for the page and as a table (`--singular-values`).

use super::degree_of_freedom::{of_reference, of_response};
use super::preparation::between_gaps;
use crate::Failure;
use modal::c64;
use modal::record::Record;
use modal::singular_values::{SingularValues, of_outputs, of_responses};
use std::path::Path;

/// Of the outputs of a record between gaps.
pub(super) fn of_record(record: &Record, gaps: &[usize]) -> Option<SingularValues> {
    of_outputs(&between_gaps(record.clone(), gaps))
}

/// Of responses, a column for each force that the names tell apart; one column where some response
/// of the grid is missing or no names do.
pub(super) fn of_channels(names: &[String], frequency_hz: &[f64], responses: &[Vec<c64>]) -> Option<SingularValues> {
    let outputs = distinct(names.iter().map(|name| of_response(name).map(|f| f.name())));
    let inputs = distinct(names.iter().map(|name| of_reference(name).map(|f| f.name())));
    let find = |output: &Option<String>, input: &Option<String>| {
        names.iter().position(|name| {
            of_response(name).map(|f| f.name()) == *output && of_reference(name).map(|f| f.name()) == *input
        })
    };
    let grid: Option<Vec<Vec<&[c64]>>> = (outputs.len() * inputs.len() == names.len())
        .then(|| outputs.iter().map(|o| inputs.iter().map(|i| Some(&responses[find(o, i)?][..])).collect()).collect())
        .flatten();
    let column = || responses.iter().map(|response| vec![&response[..]]).collect();
    of_responses(frequency_hz, &grid.unwrap_or_else(column))
}

fn distinct(names: impl Iterator<Item = Option<String>>) -> Vec<Option<String>> {
    let mut all = Vec::new();
    names.for_each(|name| {
        if !all.contains(&name) {
            all.push(name)
        }
    });
    all
}

/// Writes a row for each line of frequency.
///
/// # Errors
/// [`Failure::Input`] where there are none, [`Failure::Run`] where the file cannot be written.
pub(super) fn write(found: Option<&SingularValues>, file: &Path) -> Result<(), Failure> {
    let Some(found) = found else {
        return Err(Failure::Input(miette::miette!(
            help = "they need a time record of sixteen averages of 64 samples, or complex responses",
            "--singular-values: this recording has no singular values"
        )));
    };
    let count = found.values.first().map_or(0, Vec::len);
    let header: Vec<String> =
        std::iter::once("frequency [Hz]".into()).chain((1..=count).map(|k| format!("singular_{k}"))).collect();
    let row = |(f, values): (&f64, &Vec<f64>)| {
        std::iter::once(f).chain(values).map(ToString::to_string).collect::<Vec<_>>().join(",")
    };
    let rows = found.frequency_hz.iter().zip(&found.values).map(row);
    let text: String = std::iter::once(header.join(",")).chain(rows).map(|line| line + "\n").collect();
    std::fs::write(file, text).map_err(|error| Failure::Run(format!("{}: {error}", file.display())))
}
