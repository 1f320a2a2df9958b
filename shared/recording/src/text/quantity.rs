//! Cells that state their unit: `1.25 rad/s`, `12.5°`, `3,1 mV`.

use super::number::number;
use super::signs::Signs;
use crate::units::{Unit, unit_named};

/// A number and the text of the unit behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quantity<'a> {
    pub value: f64,
    pub unit: &'a str,
}

/// What a cell states that is a number and a unit that is known; `None` for a plain number, too.
pub(crate) fn quantity(cell: &str, signs: Signs) -> Option<Quantity<'_>> {
    let cell = cell.trim();
    let (number_text, unit) = cell.split_at(length_of_number(cell));
    let unit = unit.trim();
    let value = number(number_text.trim_end(), signs).filter(|_| !unit.is_empty())?;
    unit_named(unit).map(|_| Quantity { value, unit })
}

/// The number that a cell states in `unit`: a plain one, or one with a unit of the same dimension.
pub(crate) fn number_in(unit: Unit, cell: &str, signs: Signs) -> Option<f64> {
    number(cell, signs).or_else(|| {
        let stated = quantity(cell, signs)?;
        let own = unit_named(stated.unit).filter(|own| own.si == unit.si)?;
        // units are straight lines, those of temperature with a zero of their own
        let (zero, one) = (unit.to_si(0.0), unit.to_si(1.0));
        Some((own.to_si(stated.value) - zero) / (one - zero))
    })
}

/// Bytes of the longest beginning that looks like a number: sign, digits with signs between them,
/// and an exponent.
fn length_of_number(cell: &str) -> usize {
    let bytes = cell.as_bytes();
    let signs = usize::from(bytes.first().is_some_and(|byte| matches!(byte, b'+' | b'-')));
    let digits = |from: usize, others: &[u8]| {
        let is_part = |byte: &&u8| byte.is_ascii_digit() || others.contains(byte);
        from + bytes[from..].iter().take_while(is_part).count()
    };
    let mantissa = digits(signs, b".,'");
    if !bytes.get(mantissa).is_some_and(|byte| matches!(byte, b'e' | b'E')) {
        return mantissa;
    }
    let signed = mantissa + 1 + usize::from(bytes.get(mantissa + 1).is_some_and(|byte| matches!(byte, b'+' | b'-')));
    let end = digits(signed, b"");
    if end > signed { end } else { mantissa }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINT: Signs = Signs { decimal_comma: false, grouped: false };
    const COMMA: Signs = Signs { decimal_comma: true, grouped: false };

    #[test]
    fn a_cell_is_a_number_and_a_unit_that_is_known() {
        let cases = [
            ("1.25 rad/s", POINT, 1.25, "rad/s"),
            ("-3e-2V", POINT, -0.03, "V"),
            ("12.5°", POINT, 12.5, "°"),
            ("3,1 mV", COMMA, 3.1, "mV"),
            ("9.81m/s2", POINT, 9.81, "m/s2"),
        ];
        for (cell, comma, value, unit) in cases {
            assert_eq!(quantity(cell, comma), Some(Quantity { value, unit }), "{cell}");
        }
        for cell in ["1.25", "12 apples", "rad/s", "", "-", "2026-11-27", "12:30:01", "1.2.3 V"] {
            assert_eq!(quantity(cell, POINT), None, "{cell}");
        }
    }

    #[test]
    fn a_number_in_a_unit_is_converted_from_its_own_and_only_within_the_dimension() {
        let volt = unit_named("V").unwrap();
        assert_eq!(number_in(volt, "250 mV", POINT), Some(0.25));
        assert_eq!(number_in(volt, "0.25", POINT), Some(0.25));
        assert_eq!(number_in(volt, "0.25 A", POINT), None);
        let celsius = unit_named("degC").unwrap();
        for (cell, degrees) in [("20.5 °C", 20.5), ("293.15 K", 20.0), ("68 °F", 20.0), ("20.5", 20.5)] {
            let found = number_in(celsius, cell, POINT).unwrap();
            assert!((found - degrees).abs() < 1e-9, "{cell}: {found}");
        }
    }
}
