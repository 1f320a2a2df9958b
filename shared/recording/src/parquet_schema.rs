//! What the end of a Parquet file says of its columns.

use crate::bytes::{COPY, bad};
use crate::conventions::Storage;
use crate::error::RecordingError;
use crate::intake::origin::rest_of_seconds;
use crate::numbers::signed;
use crate::parquet_thrift::Value;

/// Columns inside columns.
const SCHEMA_DEPTH_MAX: usize = 16;

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Physical {
    Truth,
    Whole32,
    Whole64,
    /// A date of an old writer.
    Date96,
    Float,
    Double,
    /// Texts, of dates or numbers.
    Text,
    /// Whole numbers of so many bytes, the most significant first.
    Decimal(usize),
    /// Floating point of two bytes.
    Half,
}

impl Physical {
    /// Bytes of one number.
    pub fn width(self) -> usize {
        match self {
            Physical::Truth => 1,
            Physical::Whole32 | Physical::Float => 4,
            Physical::Whole64 | Physical::Double => 8,
            Physical::Date96 => 12,
            Physical::Decimal(width) => width,
            Physical::Half => 2,
            Physical::Text => 0,
        }
    }
}

/// What the numbers of a column mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meaning {
    pub physical: Physical,
    is_unsigned: bool,
    /// Counts of one second, or of one; days are counted in days.
    divide: f64,
    multiply: f64,
    /// Seconds since 1970.
    pub is_date: bool,
    /// Seconds.
    pub is_time: bool,
}

impl Meaning {
    /// How the numbers are stored.
    pub fn storage(&self) -> Storage {
        match self.physical {
            Physical::Truth | Physical::Whole32 | Physical::Whole64 | Physical::Date96 if self.divide == 1.0 => {
                Storage::Whole(8)
            }
            Physical::Float | Physical::Half => Storage::Single,
            _ => Storage::Double,
        }
    }

    /// What [`Meaning::value`] does not hold of the number that the bits stand for.
    pub fn rest(&self, bits: u64) -> f64 {
        let count = match self.physical {
            Physical::Whole64 if self.is_unsigned => i128::from(bits),
            Physical::Whole64 | Physical::Date96 => i128::from(bits as i64),
            _ => return 0.0,
        };
        if self.multiply == 1.0 { rest_of_seconds(self.value(bits), count, self.divide as i128) } else { 0.0 }
    }

    /// The number that the bits stand for.
    pub fn value(&self, bits: u64) -> f64 {
        let number = match self.physical {
            Physical::Float => f64::from(f32::from_bits(bits as u32)),
            Physical::Double | Physical::Decimal(_) | Physical::Half | Physical::Text => f64::from_bits(bits),
            Physical::Truth => bits as f64,
            Physical::Whole32 if self.is_unsigned => f64::from(bits as u32),
            Physical::Whole64 if self.is_unsigned => bits as f64,
            Physical::Whole32 => f64::from(signed(bits, 4) as i32),
            Physical::Whole64 | Physical::Date96 => bits as i64 as f64,
        };
        number / self.divide * self.multiply
    }
}

/// A column that has no columns in it.
#[derive(Clone, Debug)]
pub(crate) struct Leaf {
    pub name: String,
    /// Why it is not read.
    pub meaning: Result<Meaning, String>,
    /// Level of a value that is there.
    pub level: u32,
    /// Every row has a list of values.
    pub is_list: bool,
}

impl Leaf {
    /// Whether it holds texts.
    pub fn is_text(&self) -> bool {
        self.meaning.as_ref().is_ok_and(|meaning| meaning.physical == Physical::Text)
    }

    /// Whether it is left out where it cannot be read: other programs would not miss it.
    pub fn is_optional(&self) -> bool {
        let rare = |meaning: &Meaning| matches!(meaning.physical, Physical::Decimal(_) | Physical::Half);
        self.is_list || self.meaning.as_ref().is_ok_and(rare)
    }
}

/// The leaves in the order of the columns of every row group.
///
/// # Errors
/// The elements are no tree.
pub(crate) fn leaves(file: &str, elements: &[Value]) -> Result<Vec<Leaf>, RecordingError> {
    let mut leaves = Vec::new();
    let mut rest = elements.iter();
    let children = rest.next().and_then(|root| root.size(5)).unwrap_or(0);
    for _ in 0..children {
        add_leaves(&mut rest, "", (0, 0), SCHEMA_DEPTH_MAX, &mut leaves)
            .ok_or_else(|| bad(file, "the schema", "the columns are no tree", COPY))?;
    }
    Ok(leaves)
}

fn add_leaves<'a>(
    rest: &mut impl Iterator<Item = &'a Value>,
    prefix: &str,
    (level, lists): (u32, u32),
    depth: usize,
    leaves: &mut Vec<Leaf>,
) -> Option<()> {
    let element = rest.next().filter(|_| depth > 0)?;
    let name = format!("{prefix}{}", element.text(4)?);
    let repetition = element.whole(3).unwrap_or(0);
    let level = level + u32::from(repetition != 0);
    let lists = lists + u32::from(repetition == 2);
    match element.size(5).unwrap_or(0) {
        0 => {
            let meaning = if lists > 1 { Err("lists of lists".into()) } else { meaning(element) };
            let meaning = meaning.and_then(|meaning| {
                let is_list_of_texts = lists > 0 && meaning.physical == Physical::Text;
                if is_list_of_texts { Err("lists of texts".into()) } else { Ok(meaning) }
            });
            let name = [".list.element", ".list.item"].iter().find_map(|end| name.strip_suffix(end)).unwrap_or(&name);
            leaves.push(Leaf { name: name.to_owned(), meaning, level, is_list: lists > 0 });
        }
        children => {
            let prefix = format!("{name}.");
            for _ in 0..children {
                add_leaves(rest, &prefix, (level, lists), depth - 1, leaves)?;
            }
        }
    }
    Some(())
}

/// What a column means by its physical, its converted and its logical type.
fn meaning(element: &Value) -> Result<Meaning, String> {
    let physical = match element.whole(1) {
        Some(0) => Physical::Truth,
        Some(1) => Physical::Whole32,
        Some(2) => Physical::Whole64,
        Some(3) => Physical::Date96,
        Some(4) => Physical::Float,
        Some(5) => Physical::Double,
        Some(6) => Physical::Text,
        Some(7) => fixed(element)?,
        _ => return Err("bytes".into()),
    };
    let plain = Meaning { physical, is_unsigned: false, divide: 1.0, multiply: 1.0, is_date: false, is_time: false };
    let time = |divide: f64, is_date: bool| Meaning { divide, is_date, is_time: true, ..plain };
    if physical == Physical::Date96 {
        return Ok(time(1e9, true));
    }
    if let Some(logical) = element.get(10) {
        let unit = |kind: i16| logical.get(kind).and_then(|kind| kind.get(2)).and_then(counts_a_second);
        if let Some(divide) = unit(8) {
            return Ok(time(divide, true));
        }
        if let Some(divide) = unit(7) {
            return Ok(time(divide, false));
        }
        if let Some(stated) = logical.get(5) {
            return Ok(Meaning { divide: decimal(stated.whole(1)), ..plain });
        }
        if let Some(whole) = logical.get(10) {
            return Ok(Meaning { is_unsigned: whole.truth(2) == Some(false), ..plain });
        }
    }
    Ok(match element.whole(6) {
        Some(5) => Meaning { divide: decimal(element.whole(7)), ..plain },
        Some(6) => Meaning { multiply: 86_400.0, ..time(1.0, true) },
        Some(7) => time(1e3, false),
        Some(8) => time(1e6, false),
        Some(9) => time(1e3, true),
        Some(10) => time(1e6, true),
        Some(11..=14) => Meaning { is_unsigned: true, ..plain },
        _ => plain,
    })
}

/// What a whole number with so many decimals is divided by.
fn decimal(digits: Option<i64>) -> f64 {
    10f64.powi(digits.unwrap_or(0).clamp(0, 40) as i32)
}

/// What numbers of a fixed length in bytes are.
fn fixed(element: &Value) -> Result<Physical, String> {
    let is_logical = |kind: i16| element.get(10).is_some_and(|logical| logical.get(kind).is_some());
    match element.size(2) {
        Some(2) if is_logical(15) => Ok(Physical::Half),
        Some(width @ 1..=16) if element.whole(6) == Some(5) || is_logical(5) => Ok(Physical::Decimal(width)),
        _ => Err("bytes".into()),
    }
}

fn counts_a_second(unit: &Value) -> Option<f64> {
    [1e3, 1e6, 1e9].into_iter().zip(1i16..).find_map(|(counts, field)| unit.get(field).map(|_| counts))
}
