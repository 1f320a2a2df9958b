//! MATLAB files of version 4: variables one behind another, each with a head of five whole numbers.

use crate::arrays::{Array, Arrays};
use crate::bytes::{Bytes, COPY};
use crate::error::RecordingError;
use crate::numbers::Number;

const VARIABLE_HEAD_BYTES: usize = 20;
/// Longer than a name in MATLAB can be.
const NAME_BYTES_MAX: usize = 256;
const RESAVE: &str = "save it again in MATLAB: `save('NAME.mat', ..., '-v7')`";

/// What precedes the name of a variable.
struct Head {
    big_endian: bool,
    number: Number,
    kind: Kind,
    rows: usize,
    columns: usize,
    is_complex: bool,
    name_bytes: usize,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Full,
    Text,
    Sparse,
}

impl Head {
    /// From the first bytes of a variable; `None` where they are no head.
    ///
    /// The first number is MOPT in decimal digits: machine (0 little-endian, 1 big-endian), 0,
    /// type of the numbers, kind of the matrix.
    fn of(bytes: &[u8]) -> Option<Head> {
        let bytes: &[u8; VARIABLE_HEAD_BYTES] = bytes.get(..VARIABLE_HEAD_BYTES)?.try_into().ok()?;
        let word = |k: usize| [bytes[4 * k], bytes[4 * k + 1], bytes[4 * k + 2], bytes[4 * k + 3]];
        let little = u32::from_le_bytes(word(0));
        let big_endian = little >= 1000;
        let at = |k: usize| if big_endian { u32::from_be_bytes(word(k)) } else { u32::from_le_bytes(word(k)) };
        let kinds = at(0).checked_sub(if big_endian { 1000 } else { 0 }).filter(|kinds| *kinds < 100)?;
        let number = match kinds / 10 {
            0 => Number::float(8),
            1 => Number::float(4),
            2 => Number::whole(4, true),
            3 => Number::whole(2, true),
            4 => Number::whole(2, false),
            5 => Number::whole(1, false),
            _ => None,
        }?;
        let kind = match kinds % 10 {
            0 => Kind::Full,
            1 => Kind::Text,
            2 => Kind::Sparse,
            _ => return None,
        };
        let length = |k: usize| usize::try_from(at(k)).ok().filter(|length| *length <= i32::MAX as usize);
        let (rows, columns, name_bytes) = (length(1)?, length(2)?, length(4)?);
        let is_complex = match at(3) {
            0 => false,
            1 => true,
            _ => return None,
        };
        let named = (2..=NAME_BYTES_MAX).contains(&name_bytes);
        named.then_some(Head { big_endian, number, kind, rows, columns, is_complex, name_bytes })
    }

    /// Bytes of the numbers.
    fn data_bytes(&self) -> Option<usize> {
        let count = self.rows.checked_mul(self.columns)?;
        count.checked_mul(self.number.width())?.checked_mul(if self.is_complex { 2 } else { 1 })
    }
}

/// Whether a file begins with a variable of version 4: a head, and a name of letters, digits and
/// underscores that a zero ends.
pub(crate) fn is_level4(head: &[u8]) -> bool {
    let Some(name) = Head::of(head).and_then(|of| head.get(VARIABLE_HEAD_BYTES..VARIABLE_HEAD_BYTES + of.name_bytes))
    else {
        return false;
    };
    let Some((0, name)) = name.split_last() else { return false };
    name.first().is_some_and(u8::is_ascii_alphabetic)
        && name.iter().all(|byte| byte.is_ascii_alphanumeric() || *byte == b'_')
}

/// The arrays of a file of version 4.
///
/// # Errors
/// A file that ends early; what is no variable.
pub(crate) fn arrays(file: &str, content: &[u8]) -> Result<Arrays, RecordingError> {
    let mut bytes = Bytes::new(file, "", content);
    let mut arrays = Arrays::default();
    while bytes.left() > 0 {
        let Some(head) = Head::of(&content[bytes.at()..]) else {
            return Err(bytes.error("no variable of version 4 of MATLAB stands here", RESAVE));
        };
        bytes.take(VARIABLE_HEAD_BYTES, "the head of a variable")?;
        let name = bytes.take(head.name_bytes, "the name of a variable")?;
        let name = String::from_utf8_lossy(name.split(|byte| *byte == 0).next().unwrap_or_default()).into_owned();
        let length = head.data_bytes().ok_or_else(|| bytes.error(format!("`{name}` is too large"), COPY))?;
        let data = bytes.take(length, &format!("`{name}`"))?;
        let reason = match head.kind {
            Kind::Text => Some("text"),
            Kind::Sparse => Some("a sparse matrix: save `full(x)`"),
            Kind::Full if head.is_complex => Some("complex: save `real(x)` and `imag(x)`"),
            Kind::Full => None,
        };
        if let Some(reason) = reason {
            arrays.leave_out(name, reason);
            continue;
        }
        let (shape, values) = (vec![head.rows, head.columns], head.number.values(data, head.big_endian));
        arrays.arrays.push(Array { name, shape, column_major: true, values, ..Array::default() });
    }
    Ok(arrays)
}
