//! Mode shapes of a universal file: data at nodes, dataset 55.
//!
//! Record 6 says of what kind the data are, records 7 and 8 hold the integers and the real numbers
//! that go with it (of a normal mode frequency and damping, of a complex one its eigenvalue), then
//! follow the nodes with their values. A shape keeps the scale that the file gives it.

use crate::error::RecordingError;
use crate::uff_lines::{Text, numbers, shortened};
use crate::uff_model::{NodeShape, UffMode};
use crate::uff_nodes::integers;
use core::f64::consts::TAU;

const EXPORT: &str = "export the mode shapes again as dataset 55";
/// Values at a node: a general tensor has nine.
const MOST_VALUES: i64 = 9;
/// Integers and real numbers of records 7 and 8.
const MOST_FIELDS: i64 = 1000;

/// What a dataset 55 holds.
pub(crate) enum Shape {
    Mode(UffMode),
    /// In words: a static shape, a response at one frequency, …
    NoMode(String),
}

/// What record 6 says of the data at the nodes.
struct Layout {
    analysis: i64,
    complex: bool,
    /// Values at a node.
    values: usize,
}

/// Reads a dataset 55 behind its number, its closing `-1` included.
pub(crate) fn read_shape(text: &mut Text<'_>) -> Result<Shape, RecordingError> {
    for _ in 0..5 {
        text.needed_line()?; // what people wrote about it
    }
    let fields = record(text, 6, "the kind of the data")?;
    let (analysis, characteristic) = (fields[1], fields[2]);
    if let Some(what) = no_mode(analysis, characteristic) {
        text.skip_dataset()?;
        return Ok(Shape::NoMode(what.into()));
    }
    let layout = layout(text, &fields)?;
    let counts = record(text, 2, "how many numbers describe the mode")?;
    let (whole, real) = (counts[0], counts[1]);
    if !(0..=MOST_FIELDS).contains(&whole) || !(0..=MOST_FIELDS).contains(&real) {
        return Err(text.error(format!("{whole} integers and {real} real numbers are announced"), EXPORT));
    }
    // Eight integers a line, the two counts among them.
    for _ in 0..((whole + 2).cast_unsigned().div_ceil(8) - 1) {
        text.needed_line()?;
    }
    let real = reals(text, real.unsigned_abs() as usize, "numbers of the mode")?;
    let (frequency_hz, damping_ratio) = mode(text, &layout, &real)?;
    Ok(Shape::Mode(UffMode { frequency_hz, damping_ratio, shape: nodes(text, &layout)? }))
}

/// Why the data are no mode shape.
fn no_mode(analysis: i64, characteristic: i64) -> Option<&'static str> {
    match (analysis, characteristic) {
        (2 | 3 | 7, 2 | 3) => None,
        (2 | 3 | 7, _) => Some("data that are no displacements"),
        (1, _) => Some("static"),
        (4, _) => Some("transient"),
        (5, _) => Some("response at one frequency"),
        (6, _) => Some("buckling"),
        _ => Some("unknown analysis"),
    }
}

fn layout(text: &Text<'_>, fields: &[i64]) -> Result<Layout, RecordingError> {
    let complex = match fields[4] {
        2 | 4 => false,
        5 | 6 => true,
        other => return Err(text.error(format!("data of type {other}; read are real (2) and complex (5)"), EXPORT)),
    };
    if !(1..=MOST_VALUES).contains(&fields[5]) {
        return Err(text.error(format!("{} values at a node are announced", fields[5]), EXPORT));
    }
    Ok(Layout { analysis: fields[1], complex, values: fields[5].unsigned_abs() as usize })
}

/// The integers of a line, `least` of them at least.
fn record(text: &mut Text<'_>, least: usize, what: &str) -> Result<Vec<i64>, RecordingError> {
    let line = text.needed_line()?;
    integers(&line)
        .filter(|fields| fields.len() >= least)
        .ok_or_else(|| text.error(format!("`{}` does not say {what}", shortened(line.trim())), EXPORT))
}

/// Undamped frequency and damping ratio.
fn mode(text: &Text<'_>, layout: &Layout, real: &[f64]) -> Result<(f64, f64), RecordingError> {
    let at = |k: usize| real.get(k).copied();
    let found = match layout.analysis {
        // frequency, modal mass, viscous and hysteretic damping
        2 => at(0).map(|hz| {
            let viscous = at(2).unwrap_or(0.0);
            (hz, if viscous == 0.0 { 0.5 * at(3).unwrap_or(0.0) } else { viscous })
        }),
        // real and imaginary part of the eigenvalue
        _ => at(0).zip(at(1)).map(|(re, im)| {
            let omega = re.hypot(im);
            (omega / TAU, if omega > 0.0 { -re / omega } else { 0.0 })
        }),
    };
    let (hz, zeta) = found.ok_or_else(|| text.error(format!("{} numbers describe the mode", real.len()), EXPORT))?;
    if hz < 0.0 || !hz.is_finite() {
        return Err(text.error(format!("the mode has a frequency of {hz} Hz"), EXPORT));
    }
    Ok((hz, zeta))
}

/// Labels and values up to the closing `-1`.
fn nodes(text: &mut Text<'_>, layout: &Layout) -> Result<Vec<NodeShape>, RecordingError> {
    let mut shape = Vec::new();
    while let Some(line) = text.body_line()? {
        if line.trim().is_empty() {
            continue;
        }
        let Some(&[node]) = integers(&line).as_deref() else {
            return Err(text.error(format!("`{}` is no label of a node", shortened(line.trim())), EXPORT));
        };
        let parts = if layout.complex { 2 } else { 1 };
        let values = reals(text, parts * layout.values, &format!("numbers of node {node}"))?;
        let component = |value: &[f64]| [value[0], value.get(1).copied().unwrap_or(0.0)];
        shape.push(NodeShape { node, components: values.chunks(parts).map(component).collect() });
    }
    Ok(shape)
}

/// So many numbers, in as many lines as they take; zeros that fill the last line up are dropped.
fn reals(text: &mut Text<'_>, count: usize, what: &str) -> Result<Vec<f64>, RecordingError> {
    let mut values = Vec::new();
    while values.len() < count {
        let Some(line) = text.body_line()? else {
            return Err(text.error(format!("{} {what} are there, {count} are announced", values.len()), EXPORT));
        };
        let found = numbers(&line, &[13]).filter(|found| found.iter().all(|value| value.is_finite()));
        let Some(found) = found else {
            return Err(text.error(format!("`{}` is no line of numbers", shortened(line.trim())), EXPORT));
        };
        // The label of the next node, where the header announces more values than there are.
        if count - values.len() > 1 && found.len() == 1 && integers(&line).is_some() {
            return Err(text.error(format!("{} {what} are there, {count} are announced", values.len()), EXPORT));
        }
        values.extend(found);
    }
    if values.iter().skip(count).any(|value| *value != 0.0) {
        return Err(text.error(format!("{} {what}, {count} are announced", values.len()), EXPORT));
    }
    values.truncate(count);
    Ok(values)
}
