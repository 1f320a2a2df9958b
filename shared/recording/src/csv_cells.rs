//! Cells of a CSV file: the header row `name [unit]`, and numbers in SI.

use crate::canonical::default_channel;
use crate::error::{Place, RecordingError, nearest};
use crate::rows::Axis;
use crate::units::{UNITS, Unit, accepted_for, unit_named};

/// A column's header.
pub(crate) struct Header {
    pub name: String,
    pub unit: &'static Unit,
    pub unit_in_file: String,
    /// As it stands in the file.
    pub text: String,
}

/// The columns a header row names, and what the first of them counts.
pub(crate) fn parse_headers(
    file: &str,
    record: &::csv::ByteRecord,
    line: u64,
) -> Result<(Axis, Vec<Header>), RecordingError> {
    let mut axis = Axis::Time;
    let mut headers: Vec<Header> = Vec::with_capacity(record.len());
    for (i, cell) in record.iter().enumerate() {
        let text = String::from_utf8_lossy(cell);
        let text = text.trim_start_matches('\u{feff}').trim().trim_matches('"');
        let place = || Box::new(Place { file: file.into(), line, column: i + 1, name: abbreviated(text) });
        let (name, unit_text) = match text.strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) {
            Some((name, unit)) => (name.trim(), Some(unit.trim())),
            None => (text, None),
        };
        axis = match name {
            "frequency" if i == 0 => Axis::Frequency,
            name if i == 0 && name != "time" => {
                return Err(RecordingError::NoTimeColumn { place: place(), cure: no_time_cure(text, record) });
            }
            _ => axis,
        };
        if let Some(first) = headers.iter().position(|header| header.name == name) {
            return Err(RecordingError::DuplicateColumn { place: place(), first: first + 1 });
        }
        let Some(unit_text) = unit_text else { return Err(RecordingError::NoUnit { place: place() }) };
        let expected = match (i, axis) {
            (0, Axis::Time) => Some("s"),
            (0, Axis::Frequency) => Some("Hz"),
            _ => default_channel(name).map(|channel| channel.unit),
        };
        let unit = unit_named(unit_text).filter(|unit| i > 0 || Some(unit.si) == expected);
        let Some(unit) = unit else { return Err(unknown_unit(place(), unit_text, expected)) };
        headers.push(Header { name: name.into(), unit, unit_in_file: unit_text.into(), text: text.into() });
    }
    Ok((axis, headers))
}

fn unknown_unit(place: Box<Place>, found: &str, expected: Option<&str>) -> RecordingError {
    let accepted = match expected {
        Some(si) => accepted_for(si),
        None => UNITS.iter().map(|unit| unit.symbol).collect::<Vec<_>>().join(", "),
    };
    let near = nearest(found, UNITS.iter().filter(|u| expected.is_none_or(|si| u.si == si)).map(|u| u.symbol));
    let cure = match near {
        Some(near) => format!("if `{near}` is meant, write `[{near}]`; else convert the column, or delete it"),
        None => "convert the column to SI, or delete it".into(),
    };
    RecordingError::UnknownUnit { place, found: abbreviated(found), accepted, cure }
}

fn no_time_cure(first: &str, record: &::csv::ByteRecord) -> String {
    let is_time = |cell: &[u8]| String::from_utf8_lossy(cell).trim_start().starts_with("time");
    if record.len() == 1 && (first.contains(';') || first.contains('\t')) {
        "separate the columns by commas, with a point in decimal numbers".into()
    } else if let Some(at) = record.iter().position(is_time) {
        format!("put column {} first: time leads every row", at + 1)
    } else if first.parse::<f64>().is_ok() {
        "put a header row `time [s],name [unit],...` above the data".into()
    } else {
        "put a first column `time [s]` in (or ms, us, ns, min, h), made from the sample number if there is no clock"
            .into()
    }
}

/// The numbers of a row in SI; NaN where the cell of a time record is empty, which is a sample that
/// was not taken.
pub(crate) fn parse_row(
    file: &str,
    axis: Axis,
    headers: &[Header],
    record: &::csv::ByteRecord,
    line: u64,
    row: &mut Vec<f64>,
) -> Result<(), RecordingError> {
    if record.len() != headers.len() {
        let cells: Vec<_> = record.iter().map(String::from_utf8_lossy).collect();
        return Err(RecordingError::Ragged {
            file: file.into(),
            line,
            found: record.len(),
            expected: headers.len(),
            row: abbreviated(&cells.join(",")),
        });
    }
    row.clear();
    for (i, (cell, header)) in record.iter().zip(headers).enumerate() {
        let place = || Box::new(Place { file: file.into(), line, column: i + 1, name: header.text.clone() });
        if cell.is_empty() && i > 0 && axis == Axis::Time {
            row.push(f64::NAN);
            continue;
        }
        let text = String::from_utf8_lossy(cell);
        let value: f64 = match text.parse() {
            Ok(value) => value,
            Err(_) => return Err(RecordingError::NotANumber { place: place(), value: abbreviated(&text) }),
        };
        if !value.is_finite() {
            return Err(RecordingError::NotFinite { place: place(), value: abbreviated(&text) });
        }
        row.push(header.unit.to_si(value));
    }
    Ok(())
}

/// The first 60 characters: a binary file must not fill the operator's screen.
fn abbreviated(text: &str) -> String {
    let printable = text.chars().map(|c| if c.is_control() { '?' } else { c });
    if text.chars().count() <= 60 { printable.collect() } else { printable.take(60).chain("...".chars()).collect() }
}
