//! One NumPy array (`.npy`): a header that says the type and the shape, then the numbers.

use crate::array_texts::TextArray;
use crate::arrays::{Array, Arrays, joined};
use crate::bytes::Bytes;
use crate::error::RecordingError;
use crate::intake::origin::{if_any, rest_of_seconds};
use crate::numbers::Number;
use crate::python_literal::{self, Literal};
use crate::texts::Texts;

/// First bytes of a NumPy array.
pub(crate) const NPY_MAGIC: &[u8] = b"\x93NUMPY";
const CURE: &str = "write the file again with numpy.save or numpy.savez";

/// What one element, or one field of it, is.
#[derive(Clone, Debug, PartialEq)]
enum Kind {
    Number(Number),
    /// Counts of a unit with so many seconds; the lowest is no time.
    Time {
        seconds: f64,
        is_date: bool,
    },
    /// Letters of one or of four bytes.
    Text {
        is_wide: bool,
    },
    /// Not read, and why.
    Other(String),
}

/// A field of an element; an array without fields is one field without a name.
#[derive(Clone, Debug)]
struct Field {
    name: String,
    kind: Kind,
    big_endian: bool,
    /// Where it begins in the element, and how many bytes one value has.
    offset: usize,
    width: usize,
    /// Values of the field in one element.
    shape: Vec<usize>,
}

/// Adds the array with this name to `arrays`; the fields of a structured array are arrays in a
/// group with its name.
///
/// # Errors
/// A header that cannot be read, an array shorter than it announces.
pub(crate) fn read(mut bytes: Bytes<'_>, name: &str, arrays: &mut Arrays) -> Result<(), RecordingError> {
    if bytes.take(NPY_MAGIC.len(), "the first bytes of an array")? != NPY_MAGIC {
        bytes.go_to(0);
        return Err(bytes.error("this is no NumPy array", CURE));
    }
    let version = bytes.u8("the version")?;
    bytes.u8("the version")?;
    let length = match version {
        1 => usize::from(bytes.u16("the length of the header")?),
        2 | 3 => bytes.u32("the length of the header")? as usize,
        other => return Err(bytes.error(format!("version {other} of the format is not known"), CURE)),
    };
    let mut header = bytes.split(length, "the header")?;
    let header = python_literal::read(&mut header)?;
    let missing = |what: &str| bytes.error(format!("the header says no {what} that can be read"), CURE);
    let shape = header.get("shape").and_then(Literal::numbers).ok_or_else(|| missing("shape"))?;
    let column_major = header.get("fortran_order") == Some(&Literal::Truth(true));
    let kind = header.get("descr").ok_or_else(|| missing("type"))?;
    let (fields, width) = fields(kind).ok_or_else(|| missing("type"))?;
    if fields.iter().all(|field| matches!(field.kind, Kind::Other(_))) {
        // Numbers that are not read may be of any length: pickled objects are.
        let reason = fields.first().map_or("no fields".to_string(), |field| field.kind.reason());
        arrays.leave_out(name, reason);
        return Ok(());
    }
    let count = shape.iter().try_fold(1usize, |count, length| count.checked_mul(*length));
    let size = count.and_then(|count| count.checked_mul(width));
    let size = size.ok_or_else(|| bytes.error(format!("the shape {shape:?} has too many numbers"), CURE))?;
    let data = bytes.take(size, "the array")?;
    for field in fields {
        field.read(data, width, name, &shape, column_major, arrays);
    }
    Ok(())
}

impl Kind {
    fn reason(&self) -> String {
        if let Kind::Other(reason) = self { reason.clone() } else { String::new() }
    }
}

impl Field {
    fn read(self, data: &[u8], stride: usize, array: &str, shape: &[usize], column_major: bool, arrays: &mut Arrays) {
        // `imu/t` of an archive is in a group
        let path = array.replace('/', ".");
        let (group, name) = match path.rsplit_once('.') {
            _ if !self.name.is_empty() => (path, self.name.clone()),
            Some((group, name)) => (group.to_owned(), name.to_owned()),
            None => (String::new(), path),
        };
        if let Kind::Other(reason) = self.kind {
            arrays.leave_out(joined(&group, &name), reason);
            return;
        }
        if self.shape.len() + shape.len() > 2 && column_major && !self.shape.is_empty() {
            arrays.leave_out(joined(&group, &name), "an array of arrays in Fortran order");
            return;
        }
        if let Kind::Text { is_wide } = self.kind {
            if shape.len() + self.shape.len() > 1 {
                arrays.leave_out(joined(&group, &name), "text");
                return;
            }
            let mut texts = Texts::default();
            let element = |element: &[u8]| element.get(self.offset..self.offset + self.width).map(<[u8]>::to_vec);
            let all = data.chunks_exact(stride.max(1)).filter_map(element);
            all.for_each(|bytes| texts.push(&text(&bytes, is_wide, self.big_endian)));
            arrays.texts.push(TextArray { group, name, texts });
            return;
        }
        let each = self.shape.iter().product::<usize>();
        let (offset, width) = (self.offset, self.width);
        let at = |element: &[u8], place: usize| {
            let bytes = element.get(offset + place * width..).unwrap_or_default();
            self.kind.value(bytes, width, self.big_endian)
        };
        let values = data.chunks_exact(stride.max(1)).flat_map(|element| (0..each).map(move |place| (element, place)));
        let (values, rest): (Vec<f64>, Vec<f64>) = values.map(|(element, place)| at(element, place)).unzip();
        let rest = if_any(rest);
        let shape = [shape, &self.shape].concat();
        let (is_time, unit) = match self.kind {
            Kind::Time { is_date, .. } => (is_date, Some("s".to_string())),
            _ => (false, None),
        };
        arrays.arrays.push(Array { group, name, unit, shape, column_major, is_time, values, rest, ..Array::default() });
    }
}

impl Kind {
    /// A value, and what its `f64` does not hold.
    fn value(&self, bytes: &[u8], width: usize, big_endian: bool) -> (f64, f64) {
        match self {
            Kind::Number(number) => (number.value(bytes, big_endian), number.rest(bytes, big_endian)),
            Kind::Time { seconds, .. } => {
                let fold = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
                let bytes = bytes.get(..width).unwrap_or_default();
                let count = if big_endian { bytes.iter().fold(0, fold) } else { bytes.iter().rev().fold(0, fold) };
                // The lowest count is "not a time". A division by a whole number is the nearest.
                let count = count as i64;
                match count {
                    i64::MIN => (f64::NAN, 0.0),
                    _ if *seconds < 1.0 => {
                        let per_s = (1.0 / seconds).round();
                        let value = count as f64 / per_s;
                        (value, rest_of_seconds(value, count.into(), per_s as i128))
                    }
                    _ => (count as f64 * seconds, 0.0),
                }
            }
            Kind::Text { .. } | Kind::Other(_) => (f64::NAN, 0.0),
        }
    }
}

/// A text up to its first zero.
fn text(bytes: &[u8], is_wide: bool, big_endian: bool) -> String {
    if !is_wide {
        let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
        return String::from_utf8_lossy(&bytes[..end]).into_owned();
    }
    let code = |bytes: &[u8]| Number::Unsigned(4).value(bytes, big_endian) as u32;
    let letters = bytes.chunks_exact(4).map(code).take_while(|code| *code != 0);
    letters.map(|code| char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

/// Fields of a type and the bytes of one element.
fn fields(kind: &Literal) -> Option<(Vec<Field>, usize)> {
    if let Some(text) = kind.text() {
        let (kind, width, big_endian) = simple(text)?;
        let field = Field { name: String::new(), kind, big_endian, offset: 0, width, shape: Vec::new() };
        return Some((vec![field], width));
    }
    let mut fields = Vec::new();
    let mut offset = 0usize;
    for field in kind.list()? {
        let [name, kind, shape @ ..] = field.list()? else { return None };
        // A name may be a pair of a title and a name.
        let name = name.text().or_else(|| name.list()?.get(1)?.text())?;
        let shape = shape.first().map_or(Some(Vec::new()), Literal::numbers)?;
        let count = shape.iter().try_fold(1usize, |count, length| count.checked_mul(*length))?;
        let (kind, width, big_endian) = match kind.text() {
            Some(text) => simple(text)?,
            None => (Kind::Other("fields of fields".into()), self::fields(kind)?.1, false),
        };
        let next = offset.checked_add(width.checked_mul(count)?)?;
        // What has no name fills the gap to the next field.
        if !name.is_empty() {
            fields.push(Field { name: name.into(), kind, big_endian, offset, width, shape });
        }
        offset = next;
    }
    Some((fields, offset))
}

/// A type such as `<f8`: what it is, its bytes, the order of the bytes.
fn simple(text: &str) -> Option<(Kind, usize, bool)> {
    let big_endian = text.starts_with('>');
    let text = text.trim_start_matches(['<', '>', '|', '=']);
    let letter = text.chars().next()?;
    let rest = &text[letter.len_utf8()..];
    let (digits, unit) = rest.find('[').map_or((rest, ""), |at| rest.split_at(at));
    let length: usize = if digits.is_empty() { 0 } else { digits.parse().ok()? };
    // Characters of numpy have four bytes each.
    let width = if letter == 'U' { length.checked_mul(4)? } else { length };
    let number = |number: Option<Number>| number.map(Kind::Number);
    let kind = match letter {
        'f' => number(Number::float(width)),
        'i' => number(Number::whole(width, true)),
        'u' => number(Number::whole(width, false)),
        'b' if width == 1 => number(Number::whole(1, false)),
        'U' => Some(Kind::Text { is_wide: true }),
        'S' | 'a' => Some(Kind::Text { is_wide: false }),
        'M' | 'm' if width == 8 => seconds_of(unit).map(|seconds| Kind::Time { seconds, is_date: letter == 'M' }),
        _ => None,
    };
    let other = match letter {
        'O' => "Python objects".to_string(),
        'c' => "complex numbers: save the real and the imaginary part".to_string(),
        _ => format!("type `{text}`"),
    };
    Some((kind.unwrap_or(Kind::Other(other)), width, big_endian))
}

/// Seconds of a unit such as `[ms]` or `[10us]`; months and years have no fixed length.
fn seconds_of(unit: &str) -> Option<f64> {
    let unit = unit.strip_prefix('[')?.strip_suffix(']')?;
    let letters = unit.trim_start_matches(|digit: char| digit.is_ascii_digit());
    let digits = &unit[..unit.len() - letters.len()];
    let times: u32 = if digits.is_empty() { 1 } else { digits.parse().ok()? };
    let seconds = match letters {
        "W" => 604_800.0,
        "D" => 86_400.0,
        "h" => 3600.0,
        "m" => 60.0,
        "s" => 1.0,
        "ms" => 1e-3,
        "us" | "μs" => 1e-6,
        "ns" => 1e-9,
        "ps" => 1e-12,
        "fs" => 1e-15,
        "as" => 1e-18,
        _ => return None,
    };
    Some(f64::from(times) * seconds)
}
