//! How Parquet stores numbers: plainly, in runs, as differences, byte by byte.

use crate::bytes::{Bytes, COPY};
use crate::error::RecordingError;
use crate::numbers::Number;
use crate::parquet_schema::Physical;
use crate::parquet_thrift::{variable_length, zigzag};

/// Values of one block of differences.
const BLOCK_MAX: u64 = 1 << 20;
/// From the Julian day 0 to 1970.
const JULIAN_1970: i64 = 2_440_588;
const NANOSECONDS_A_DAY: i64 = 86_400_000_000_000;

/// `width` bits that begin `at` bits behind the front, the lowest first; missing bytes are zero.
fn bits(bytes: &[u8], at: usize, width: u32) -> u64 {
    let around = bytes.get(at / 8..).unwrap_or_default().iter().take(9);
    let value = around.rev().fold(0u128, |value, byte| value << 8 | u128::from(*byte));
    ((value >> (at % 8)) & ((1u128 << width) - 1)) as u64
}

/// `count` numbers in runs and packed groups of `width` bits.
///
/// # Errors
/// The bytes end before.
pub(crate) fn runs(bytes: &mut Bytes<'_>, width: u32, count: usize) -> Result<Vec<u64>, RecordingError> {
    if width > 32 {
        return Err(bytes.error(format!("numbers of {width} bits are in runs"), COPY));
    }
    let mut values = Vec::new();
    while values.len() < count {
        let head = variable_length(bytes)?;
        let left = count - values.len();
        if head & 1 == 1 {
            let groups = usize::try_from(head >> 1).unwrap_or(usize::MAX);
            let size = groups.saturating_mul(width as usize);
            // The last group may be cut.
            let packed = bytes.take(size.min(bytes.left()), "packed numbers")?;
            let number = groups.saturating_mul(8).min(left);
            if packed.len() < (number * width as usize).div_ceil(8) || number == 0 {
                return Err(bytes.error("packed numbers end before their count", COPY));
            }
            values.extend((0..number).map(|place| bits(packed, place * width as usize, width)));
        } else {
            let value = bytes.take(width.div_ceil(8) as usize, "a run")?;
            let length = usize::try_from(head >> 1).unwrap_or(usize::MAX).min(left);
            if length == 0 {
                return Err(bytes.error("a run of no numbers", COPY));
            }
            let value = value.iter().rev().fold(0, |value, byte| value << 8 | u64::from(*byte));
            values.extend(std::iter::repeat_n(value, length));
        }
    }
    Ok(values)
}

/// `count` numbers one after another.
///
/// # Errors
/// The bytes end before.
pub(crate) fn plain(bytes: &mut Bytes<'_>, physical: Physical, count: usize) -> Result<Vec<u64>, RecordingError> {
    if physical == Physical::Truth {
        let packed = bytes.take(count.div_ceil(8), "truths")?;
        return Ok((0..count).map(|place| bits(packed, place, 1)).collect());
    }
    let width = physical.width();
    let data = bytes.take(count.saturating_mul(width), "numbers")?;
    let of = |number: &[u8]| match physical {
        Physical::Date96 => nanoseconds(number),
        Physical::Decimal(_) => decimal(number).to_bits(),
        Physical::Half => Number::Float(2).value(number, false).to_bits(),
        _ => whole(number),
    };
    Ok(data.chunks_exact(width.max(1)).map(of).collect())
}

/// A whole number of two's complement, the most significant byte first.
fn decimal(bytes: &[u8]) -> f64 {
    let sign = if bytes.first().is_some_and(|byte| *byte > 127) { -1i128 } else { 0 };
    bytes.iter().fold(sign, |value, byte| value << 8 | i128::from(*byte)) as f64
}

/// `count` texts one after another, each with its length in front.
///
/// # Errors
/// The bytes end before.
pub(crate) fn texts<'a>(bytes: &mut Bytes<'a>, count: usize) -> Result<Vec<&'a [u8]>, RecordingError> {
    let mut texts = Vec::new();
    for _ in 0..count {
        let length = bytes.u32("the length of a text")? as usize;
        texts.push(bytes.take(length, "a text")?);
    }
    Ok(texts)
}

fn whole(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |value, byte| value << 8 | u64::from(*byte))
}

/// A date of 96 bits: nanoseconds of the day, then the Julian day. As nanoseconds since 1970.
fn nanoseconds(bytes: &[u8]) -> u64 {
    let (time, day) = (whole(&bytes[..8]) as i64, whole(&bytes[8..]) as i64);
    (day - JULIAN_1970).wrapping_mul(NANOSECONDS_A_DAY).wrapping_add(time) as u64
}

/// `count` numbers of which first all first bytes are stored, then all second ones.
///
/// # Errors
/// The bytes end before.
pub(crate) fn split_bytes(bytes: &mut Bytes<'_>, physical: Physical, count: usize) -> Result<Vec<u64>, RecordingError> {
    let width = physical.width();
    let data = bytes.take(count.saturating_mul(width), "numbers")?;
    let number =
        |place: usize| (0..width).rev().fold(0, |value, byte| value << 8 | u64::from(data[byte * count + place]));
    Ok((0..count).map(number).collect())
}

/// `count` numbers as differences, packed in blocks.
///
/// # Errors
/// The bytes end before, or are no blocks.
pub(crate) fn differences(bytes: &mut Bytes<'_>, count: usize) -> Result<Vec<u64>, RecordingError> {
    let (block, parts) = (variable_length(bytes)?, variable_length(bytes)?);
    let total = variable_length(bytes)?;
    let mut value = zigzag(bytes)?;
    let each = block.checked_div(parts).unwrap_or(0);
    if block > BLOCK_MAX || each == 0 || each % 8 != 0 || total != count as u64 {
        let found = format!("{total} differences for {count} numbers, in blocks of {block} in {parts} parts");
        return Err(bytes.error(found, COPY));
    }
    let each = each as usize;
    let mut values = Vec::new();
    if count > 0 {
        values.push(value as u64);
    }
    while values.len() < count {
        let least = zigzag(bytes)?;
        let widths = bytes.take(parts as usize, "the widths of a block")?;
        for width in widths {
            let left = (count - values.len()).min(each);
            if left == 0 {
                break;
            }
            let width = u32::from(*width);
            if width > 64 {
                return Err(bytes.error(format!("differences of {width} bits"), COPY));
            }
            let packed = bytes.take(each / 8 * width as usize, "packed differences")?;
            for place in 0..left {
                let difference = bits(packed, place * width as usize, width) as i64;
                value = value.wrapping_add(least).wrapping_add(difference);
                values.push(value as u64);
            }
        }
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_and_packed_groups_follow_each_other() {
        // Three times 5, then the numbers 0 to 7 in three bits each.
        let data = [6, 5, 3, 0x88, 0xc6, 0xfa];
        let read = runs(&mut Bytes::new("file", "", &data), 3, 9).unwrap();
        assert_eq!(read, [5, 5, 5, 0, 1, 2, 3, 4, 5]);
        for data in [&[0, 0][..], &[1], &[7, 1], &[]] {
            assert!(runs(&mut Bytes::new("file", "", data), 3, 9).is_err(), "{data:?}");
        }
    }

    #[test]
    fn differences_are_added_up() {
        // 7, 5, 3, 1, 2: one block of 8 in one part, least difference -2, two bits each.
        let data = [8, 1, 5, 14, 3, 2, 0b1100_0000, 0];
        assert_eq!(differences(&mut Bytes::new("file", "", &data), 5).unwrap(), [7, 5, 3, 1, 2]);
        assert!(differences(&mut Bytes::new("file", "", &data), 6).is_err());
        assert!(differences(&mut Bytes::new("file", "", &[8, 0, 5, 14]), 5).is_err());
    }

    #[test]
    fn a_date_of_96_bits_counts_from_1970() {
        let mut date = 5u64.to_le_bytes().to_vec();
        date.extend(2_440_589u32.to_le_bytes());
        assert_eq!(nanoseconds(&date), 86_400_000_000_005);
    }
}
