//! Numbers as binary files store them.

use crate::intake::origin::split;

/// One number in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Number {
    /// IEEE 754 with 2, 4 or 8 bytes.
    Float(usize),
    /// Two's complement with 1, 2, 4 or 8 bytes.
    Signed(usize),
    /// With 1, 2, 4 or 8 bytes.
    Unsigned(usize),
}

impl Number {
    /// A number with a width that can be read.
    pub fn float(width: usize) -> Option<Self> {
        matches!(width, 2 | 4 | 8).then_some(Number::Float(width))
    }

    /// A whole number with a width that can be read.
    pub fn whole(width: usize, signed: bool) -> Option<Self> {
        let number = if signed { Number::Signed(width) } else { Number::Unsigned(width) };
        matches!(width, 1 | 2 | 4 | 8).then_some(number)
    }

    /// Bytes of one number.
    pub fn width(self) -> usize {
        match self {
            Number::Float(width) | Number::Signed(width) | Number::Unsigned(width) => width,
        }
    }

    /// The number in the first bytes of `bytes`; NaN where they are too few. A whole number above
    /// 2^53 is rounded to the nearest that `f64` holds.
    pub fn value(self, bytes: &[u8], big_endian: bool) -> f64 {
        let width = self.width();
        let Some(bytes) = bytes.get(..width) else { return f64::NAN };
        let fold = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        let bits = if big_endian { bytes.iter().fold(0, fold) } else { bytes.iter().rev().fold(0, fold) };
        match self {
            Number::Float(2) => half(bits as u16),
            Number::Float(4) => f64::from(f32::from_bits(bits as u32)),
            Number::Float(_) => f64::from_bits(bits),
            Number::Signed(_) => signed(bits, width) as f64,
            Number::Unsigned(_) => bits as f64,
        }
    }

    /// What `value` does not hold of the number in the first bytes of `bytes`.
    pub fn rest(self, bytes: &[u8], big_endian: bool) -> f64 {
        let width = self.width();
        let Some(bytes) = bytes.get(..width).filter(|_| width == 8) else { return 0.0 };
        let fold = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        let bits = if big_endian { bytes.iter().fold(0, fold) } else { bytes.iter().rev().fold(0, fold) };
        match self {
            Number::Float(_) => 0.0,
            Number::Signed(_) => split((bits as i64).into()).1,
            Number::Unsigned(_) => split(bits.into()).1,
        }
    }

    /// The values of a block of numbers without gaps; what is left of the last one counts for none.
    pub fn values(self, bytes: &[u8], big_endian: bool) -> Vec<f64> {
        bytes.chunks_exact(self.width()).map(|number| self.value(number, big_endian)).collect()
    }
}

/// A whole number with a sign from its bits.
pub(crate) fn signed(bits: u64, width: usize) -> i64 {
    let shift = 64 - 8 * width as u32;
    ((bits << shift) as i64) >> shift
}

/// IEEE 754 half precision.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff));
    match exponent {
        0 => sign * fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => sign * f64::INFINITY,
        31 => f64::NAN,
        _ => sign * (1.0 + fraction / 1024.0) * 2f64.powi(exponent - 15),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_in_both_orders_of_bytes() {
        assert_eq!(Number::Signed(2).value(&[0xfe, 0xff], false), -2.0);
        assert_eq!(Number::Signed(2).value(&[0xff, 0xfe], true), -2.0);
        assert_eq!(Number::Unsigned(4).value(&[1, 0, 0, 0x80], false), 2_147_483_649.0);
        assert_eq!(Number::Float(8).value(&1.5f64.to_be_bytes(), true), 1.5);
        assert_eq!(Number::Float(4).value(&(-0.25f32).to_le_bytes(), false), -0.25);
        assert!(Number::Float(8).value(&[0; 7], false).is_nan());
    }

    #[test]
    fn half_precision_has_its_subnormals_and_infinities() {
        let cases = [(0x3c00, 1.0), (0xc000, -2.0), (0x7bff, 65504.0), (1, 2f64.powi(-24)), (0x7c00, f64::INFINITY)];
        for (bits, value) in cases {
            assert_eq!(half(bits), value, "{bits:#x}");
        }
        assert!(half(0x7e00).is_nan());
    }
}
