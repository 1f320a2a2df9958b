//! The numbers of a dataset 58 or 58b, in fixed columns or as bytes.

use crate::error::RecordingError;
use crate::uff_dataset::EXPORT;
use crate::uff_lines::{Text, numbers, shortened};

/// Layout of the numbers, record 7.
pub(crate) struct Layout {
    pub complex: bool,
    pub double: bool,
    pub values: usize,
    pub even: bool,
    pub first: f64,
    pub step: f64,
}

/// What the line with the number of a 58b says.
pub(crate) struct Binary {
    pub little_endian: bool,
    pub bytes: usize,
}

/// Numbers of one value.
fn parts(layout: &Layout) -> usize {
    usize::from(!layout.even) + 1 + usize::from(layout.complex)
}

pub(crate) fn from_text(text: &mut Text<'_>, layout: &Layout) -> Result<Vec<f64>, RecordingError> {
    let (widths, in_a_row): (&[usize], usize) = match (layout.double, layout.even, layout.complex) {
        (false, ..) => (&[13], 6),
        (true, true, _) => (&[20], 4),
        (true, false, false) => (&[13, 20], 4),
        (true, false, true) => (&[13, 20, 20], 3),
    };
    let need = layout.values * parts(layout);
    let mut values = Vec::new();
    while values.len() < need {
        let line = text.needed_line()?;
        if line.trim() == "-1" {
            let found = format!("{} numbers of {need} are there", values.len());
            return Err(text.error(found, "the header announces more than there is: export the file again"));
        }
        let Some(found) = numbers(&line, widths) else {
            return Err(text.error(format!("`{}` is no line of numbers", shortened(line.trim())), EXPORT));
        };
        if let Some(bad) = found.iter().find(|value| !value.is_finite()) {
            return Err(text.error(format!("{bad} is not finite"), "leave the function out, or export it again"));
        }
        values.extend(found);
    }
    // Some writers fill the last row up with zeros.
    let surplus = values.get(need..).unwrap_or_default();
    if surplus.len() < in_a_row && surplus.iter().all(|value| *value == 0.0) {
        values.truncate(need);
    }
    if values.len() > need {
        return Err(text.error(format!("{} numbers, {need} are announced", values.len()), EXPORT));
    }
    Ok(values)
}

pub(crate) fn from_bytes(text: &mut Text<'_>, layout: &Layout, binary: &Binary) -> Result<Vec<f64>, RecordingError> {
    let width = if layout.double { 8 } else { 4 };
    let need = layout.values * parts(layout) * width;
    // An uneven abscissa of doubles is written in single precision by the letter of the format, in
    // double by most. What the header announces is not asked: a common writer counts complex values
    // as real ones.
    let short = need - if layout.double && !layout.even { 4 * layout.values } else { 0 };
    let length = [need, short].into_iter().find(|length| text.closes_behind(*length));
    if length.is_none() && binary.bytes == need {
        text.block(need)?; // too few, then
    }
    let Some(length) = length else {
        let found = format!("{} bytes of numbers, {need} would hold the {} values", binary.bytes, layout.values);
        return Err(text.error(found, EXPORT));
    };
    let (block, short_abscissa) = (text.block(length)?, length < need);
    let mut values = Vec::with_capacity(layout.values * parts(layout));
    let mut at = 0;
    for k in 0..layout.values * parts(layout) {
        let width = if short_abscissa && k % parts(layout) == 0 { 4 } else { width };
        let value = decode(&block[at..at + width], binary.little_endian);
        if !value.is_finite() {
            return Err(text.error(
                format!("number {} of the block is {value}", k + 1),
                "leave the function out, or export it again",
            ));
        }
        values.push(value);
        at += width;
    }
    Ok(values)
}

fn decode(bytes: &[u8], little_endian: bool) -> f64 {
    match (<[u8; 4]>::try_from(bytes), <[u8; 8]>::try_from(bytes)) {
        (Ok(four), _) => f64::from(if little_endian { f32::from_le_bytes(four) } else { f32::from_be_bytes(four) }),
        (_, Ok(eight)) if little_endian => f64::from_le_bytes(eight),
        (_, Ok(eight)) => f64::from_be_bytes(eight),
        _ => f64::NAN,
    }
}

/// Abscissa, real and imaginary parts.
pub(crate) fn columns(layout: &Layout, values: &[f64]) -> (Vec<f64>, Vec<f64>, Option<Vec<f64>>) {
    let parts = parts(layout);
    let column = |k: usize| values.iter().skip(k).step_by(parts).copied().collect::<Vec<f64>>();
    let first = usize::from(!layout.even);
    let x = if layout.even {
        (0..layout.values).map(|k| layout.first + k as f64 * layout.step).collect()
    } else {
        column(0)
    };
    (x, column(first), layout.complex.then(|| column(first + 1)))
}
