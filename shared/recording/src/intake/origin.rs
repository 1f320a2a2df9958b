//! Where the clock of a recording begins: stamps since 1970 are counted from their first whole
//! second.
//!
//! An `f64` that counts seconds since 1970 steps by 0.24 µs, one that counts nanoseconds by 256 ns.
//! So what it cannot hold of a whole number is kept beside it ([`split`]), and the origin is
//! subtracted before the unit is converted: both subtractions are exact (the numbers are within a
//! factor of two), the conversion is rounded once.

use super::clock::EPOCH_S;
use crate::units::Unit;

/// The clock of one dataset.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Origin {
    unit: Unit,
    /// In counts of the clock; 0 for a clock that does not count from 1970.
    counts: f64,
    /// [s since 1970]
    pub second: i64,
}

impl Origin {
    /// Of a clock in `unit` whose first stamp is `first`.
    pub fn of(unit: Unit, first: f64) -> Self {
        let (first_s, counts_per_s) = (unit.to_si(first), unit.to_si(1.0).recip().round());
        let is_exact = counts_per_s >= 1.0 && unit.to_si(counts_per_s) == 1.0;
        let second = if EPOCH_S.contains(&first_s) && is_exact { first_s.floor() } else { 0.0 };
        Origin { unit, counts: second * counts_per_s, second: second as i64 }
    }

    /// Time of a stamp and what its `f64` does not hold [s since the origin].
    pub fn time_s(&self, stamp: f64, rest: f64) -> f64 {
        if self.second == 0 { self.unit.to_si(stamp) } else { self.unit.to_si((stamp - self.counts) + rest) }
    }
}

/// Says what times count from, where that is no zero of the file.
pub(crate) fn origin_note(second: i64) -> Option<String> {
    let at = jiff::Timestamp::from_second(second).ok().filter(|_| second != 0)?;
    Some(format!("time counts from {at}, {second} s since 1970"))
}

/// A whole number as the nearest `f64` and what that does not hold.
pub(crate) fn split(whole: i128) -> (f64, f64) {
    let nearest = whole as f64;
    (nearest, (whole - nearest as i128) as f64)
}

/// A number of a text likewise: whole digits and their fraction, with an exponent or without;
/// `None` in another notation.
pub(crate) fn split_text(text: &str) -> Option<(f64, f64)> {
    if let Some((mantissa, exponent)) = text.split_once(['e', 'E']) {
        return split_text(&without_exponent(mantissa, exponent.parse().ok()?)?);
    }
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || whole.len() > 30 || !digits(whole) || !digits(fraction) {
        return None;
    }
    let (nearest, rest) = split(whole.parse().ok()?);
    let fraction: f64 = if fraction.is_empty() { 0.0 } else { format!("0.{fraction}").parse().ok()? };
    Some((nearest, rest + fraction))
}

/// `1.70965`, 4 as `17096.5`; `None` where the point would move in front of the digits, or far.
fn without_exponent(mantissa: &str, exponent: i32) -> Option<String> {
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let moved = usize::try_from(exponent).ok().filter(|moved| *moved <= 30 && !whole.is_empty())?;
    let (ahead, behind) = fraction.split_at_checked(moved.min(fraction.len()))?;
    Some(format!("{whole}{ahead}{}.{behind}", "0".repeat(moved - ahead.len())))
}

/// What seconds as an `f64` do not hold of `count / per_s`.
pub(crate) fn rest_of_seconds(seconds: f64, count: i128, per_s: i128) -> f64 {
    let whole = seconds.floor();
    if !whole.is_finite() || whole.abs() > 1e18 {
        return 0.0;
    }
    (count - whole as i128 * per_s) as f64 / per_s as f64 - (seconds - whole)
}

/// What is left of numbers, or nothing where nothing is left of any.
pub(crate) fn if_any(rest: Vec<f64>) -> Vec<f64> {
    if rest.iter().all(|rest| *rest == 0.0) { Vec::new() } else { rest }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::unit_named;

    #[test]
    fn stamps_since_1970_keep_every_digit_in_every_unit() {
        let steps = [0_i128, 1, 20_000, 20_001, 999_999_999, 86_400_000_000_001];
        for start_ns in [1_700_000_000_123_456_789_i128, 946_684_800_000_000_000, 4_102_444_799_000_000_001] {
            let unit = unit_named("ns").unwrap();
            let origin = Origin::of(unit, start_ns as f64);
            for step in steps {
                let (stamp, rest) = split(start_ns + step);
                let exact = (start_ns + step - i128::from(origin.second) * 1_000_000_000) as f64 / 1e9;
                assert_eq!(origin.time_s(stamp, rest), exact);
                let seconds = (start_ns + step) as f64 / 1e9;
                let rest = rest_of_seconds(seconds, start_ns + step, 1_000_000_000);
                let of_seconds = Origin::of(unit_named("s").unwrap(), start_ns as f64 / 1e9);
                let exact = (start_ns + step - i128::from(of_seconds.second) * 1_000_000_000) as f64 / 1e9;
                // a rounding of the fraction and one of the sum
                assert!((of_seconds.time_s(seconds, rest) - exact).abs() <= 2e-16 * exact.max(1.0));
            }
        }
    }

    #[test]
    fn a_clock_that_does_not_count_from_1970_stays_bit_for_bit() {
        let unit = unit_named("us").unwrap();
        assert_eq!(Origin::of(unit, 12_345_678.0).time_s(12_345_679.0, 0.0), unit.to_si(12_345_679.0));
    }

    #[test]
    fn a_text_is_split_at_its_point() {
        assert_eq!(split_text("1700000000123456789"), Some((1.700_000_000_123_456_8e18, 21.0)));
        assert_eq!(split_text("1700000000.25"), Some((1.7e9, 0.25)));
        assert_eq!(split_text("1.70000000025E+9"), Some((1.7e9, 0.25)));
        assert_eq!(split_text("1.70965e12"), Some((1_709_650_000_000.0, 0.0)));
        for text in ["-3", "", "0x1", "1.7e-9", "e9", "1e99"] {
            assert_eq!(split_text(text), None, "{text}");
        }
    }
}
