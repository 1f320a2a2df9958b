//! The variables of a MATLAB file: arrays of numbers, and structures of them.

use crate::array_texts::TextArray;
use crate::arrays::{Array, Arrays, joined};
use crate::bytes::{Bytes, COPY};
use crate::error::RecordingError;
use crate::matlab_elements::{self as elements, Element};
use crate::numbers::Number;
use crate::texts::Texts;

/// Structures inside structures.
const VALUE_DEPTH_MAX: usize = 12;
/// Structures of an array of structures that become datasets.
const STRUCTURES_MAX: usize = 64;
const COMPLEX: u32 = 0x800;
const CELL: u32 = 1;
const STRUCTURE: u32 = 2;
const OBJECT: u32 = 3;
const TEXT: u32 = 4;
const SPARSE: u32 = 5;
const FIRST_NUMERIC: u32 = 6;
const LAST_NUMERIC: u32 = 15;
const OPAQUE: u32 = 17;

/// What precedes the values of a variable.
struct Head {
    class: u32,
    is_complex: bool,
    shape: Vec<usize>,
    name: String,
}

/// Adds the variable in `matrix` to `arrays`.
///
/// # Errors
/// A damaged variable.
pub(crate) fn read(matrix: Bytes<'_>, arrays: &mut Arrays) -> Result<(), RecordingError> {
    variable(matrix, "", None, VALUE_DEPTH_MAX, arrays)
}

/// A variable, or the field `name` of the structure `group`.
fn variable(
    mut matrix: Bytes<'_>,
    group: &str,
    name: Option<&str>,
    depth: usize,
    arrays: &mut Arrays,
) -> Result<(), RecordingError> {
    if matrix.left() == 0 {
        // A field that was never set.
        arrays.leave_out(joined(group, name.unwrap_or("?")), "empty");
        return Ok(());
    }
    let head = head(&mut matrix)?;
    let name = name.map_or(head.name.clone(), String::from);
    match head.class {
        FIRST_NUMERIC..=LAST_NUMERIC if head.is_complex => {
            arrays.leave_out(joined(group, &name), "complex: save `real(x)` and `imag(x)`");
        }
        FIRST_NUMERIC..=LAST_NUMERIC => {
            // A variable without a name is MATLAB's own, for the objects of the file.
            if !name.is_empty() {
                arrays.arrays.push(numeric(&mut matrix, group, name, head.shape)?);
            }
        }
        TEXT => {
            let mut texts = Texts::default();
            text_rows(&mut matrix, &head.shape)?.iter().for_each(|text| texts.push(text));
            arrays.texts.push(TextArray { group: group.to_owned(), name, texts });
        }
        CELL => return cells(matrix, (group, &name), &head.shape, depth, arrays),
        STRUCTURE => return structure(matrix, &joined(group, &name), &head.shape, depth, arrays),
        OPAQUE => {
            let class = opaque_class(&mut matrix);
            arrays.leave_out(joined(group, &name), object_reason(&class));
        }
        other => arrays.leave_out(joined(group, &name), reason(other)),
    }
    Ok(())
}

fn reason(class: u32) -> String {
    match class {
        OBJECT => "an object: save its arrays".into(),
        SPARSE => "a sparse matrix: save `full(x)`".into(),
        16 => "a function".into(),
        other => format!("class {other}"),
    }
}

/// Why an object is not read, and what to save in its place.
pub(crate) fn object_reason(class: &str) -> String {
    let save = match class {
        "timetable" => "`t = seconds(x.Properties.RowTimes - x.Properties.RowTimes(1))` and `d = x.Variables`",
        "timeseries" => "`t = x.Time` and `d = x.Data`",
        "table" => "`s = table2struct(x, 'ToScalar', true)`",
        "datetime" => "`t = posixtime(x)`",
        "duration" => "`t = seconds(x)`",
        "string" => "`c = cellstr(x)`",
        _ if class.starts_with("Simulink.") => "`t = x{1}.Values.Time` and `d = x{1}.Values.Data`",
        _ => "its arrays",
    };
    format!("an object of class `{class}`: save {save}")
}

/// The rows of an array of letters, blanks at their ends left out.
fn text_rows(matrix: &mut Bytes<'_>, shape: &[usize]) -> Result<Vec<String>, RecordingError> {
    let mut element = elements::next(matrix)?;
    let (left, big_endian) = (element.data.left(), element.data.big_endian);
    let bytes = element.data.take(left, "a text")?;
    let width = match element.kind {
        4 | 17 => 2,
        18 => 4,
        _ => 1,
    };
    let letters: Vec<char> = match Number::whole(width, false).filter(|_| width > 1) {
        Some(number) => {
            let letter = |code: f64| char::from_u32(code as u32).unwrap_or(char::REPLACEMENT_CHARACTER);
            number.values(bytes, big_endian).into_iter().map(letter).collect()
        }
        None => String::from_utf8_lossy(bytes).chars().collect(),
    };
    let rows = shape.first().copied().unwrap_or(1).clamp(1, letters.len().max(1));
    let row = |row: usize| letters.iter().skip(row).step_by(rows).collect::<String>().trim_end().to_owned();
    Ok((0..rows).map(row).collect())
}

/// The cells of an array of cells: a list of texts, or each as a variable `name[k]`.
fn cells(
    mut matrix: Bytes<'_>,
    (group, name): (&str, &str),
    shape: &[usize],
    depth: usize,
    arrays: &mut Arrays,
) -> Result<(), RecordingError> {
    let count: usize = shape.iter().product();
    let mut cells = Vec::new();
    while cells.len() < count && matrix.left() > 0 {
        cells.push(elements::next(&mut matrix)?.data);
    }
    let is_text = |cell: &Bytes<'_>| cell.left() > 0 && head(&mut cell.clone()).is_ok_and(|head| head.class == TEXT);
    if count > 1 && cells.iter().all(is_text) {
        let mut texts = Texts::default();
        for mut cell in cells {
            let head = head(&mut cell)?;
            texts.push(text_rows(&mut cell, &head.shape)?.first().map_or("", String::as_str));
        }
        arrays.texts.push(TextArray { group: group.to_owned(), name: name.to_owned(), texts });
        return Ok(());
    }
    if depth == 0 || count > STRUCTURES_MAX {
        arrays.leave_out(joined(group, name), format!("an array of {count} cells"));
        return Ok(());
    }
    for (place, cell) in cells.into_iter().enumerate() {
        variable(cell, group, Some(&format!("{name}[{place}]")), depth - 1, arrays)?;
    }
    Ok(())
}

fn head(matrix: &mut Bytes<'_>) -> Result<Head, RecordingError> {
    let flags = elements::next(matrix)?.data.u32("the flags of a variable")?;
    let class = flags & 0xff;
    // An opaque object has no dimensions.
    let shape = if class == OPAQUE { Vec::new() } else { shape(elements::next(matrix)?)? };
    let name = elements::next(matrix)?.text()?;
    Ok(Head { class, is_complex: flags & COMPLEX != 0, shape, name })
}

fn shape(dimensions: Element<'_>) -> Result<Vec<usize>, RecordingError> {
    let place = dimensions.data.clone();
    let shape: Vec<usize> = dimensions.numbers()?.into_iter().map(|length| length.max(0.0) as usize).collect();
    let count = shape.iter().try_fold(1usize, |count, length| count.checked_mul(*length));
    if shape.is_empty() || count.is_none() {
        return Err(place.error(format!("the dimensions {shape:?} are none of an array"), COPY));
    }
    Ok(shape)
}

fn numeric(matrix: &mut Bytes<'_>, group: &str, name: String, shape: Vec<usize>) -> Result<Array, RecordingError> {
    let values = elements::next(matrix)?.numbers()?;
    let count: usize = shape.iter().product();
    if values.len() != count {
        let found = format!("`{}` has {} numbers for {shape:?}", joined(group, &name), values.len());
        return Err(matrix.error(found, COPY));
    }
    Ok(Array { group: group.into(), name, shape, column_major: true, values, ..Array::default() })
}

/// The fields of a structure, or of each one of an array of structures.
fn structure(
    mut matrix: Bytes<'_>,
    name: &str,
    shape: &[usize],
    depth: usize,
    arrays: &mut Arrays,
) -> Result<(), RecordingError> {
    let count: usize = shape.iter().product();
    if depth == 0 || count > STRUCTURES_MAX {
        let reason = if depth == 0 { "too deep".to_string() } else { format!("{count} structures") };
        arrays.leave_out(name, reason);
        return Ok(());
    }
    let length = elements::next(&mut matrix)?.numbers()?.first().map_or(0, |length| length.max(1.0) as usize);
    let mut names = elements::next(&mut matrix)?.data;
    let mut fields = Vec::new();
    while length > 0 && names.left() >= length {
        let text = names.take(length, "a field name")?;
        let end = text.iter().position(|byte| *byte == 0).unwrap_or(length);
        fields.push(String::from_utf8_lossy(&text[..end]).into_owned());
    }
    for place in 0..count {
        let group = if count == 1 { name.to_string() } else { format!("{name}[{place}]") };
        for field in &fields {
            let element = elements::next(&mut matrix)?;
            variable(element.data, &group, Some(field), depth - 1, arrays)?;
        }
    }
    Ok(())
}

/// The class of an object that only MATLAB can read.
fn opaque_class(matrix: &mut Bytes<'_>) -> String {
    let mut text = || elements::next(matrix).and_then(Element::text).unwrap_or_default();
    let _system = text();
    text()
}
