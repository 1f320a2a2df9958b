//! Units of time that name their zero: `seconds since 2024-03-05 15:00:00`, as netCDF writes them.

use crate::intake::stamps::{Form, Stamp};
#[cfg(feature = "foreign")]
use crate::texts::seconds_of;
use crate::units::unit_named;
use jiff::civil::{Date, DateTime, Time};

/// What a count of a clock is worth, and where it begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Since {
    /// Seconds of one count.
    pub count_s: f64,
    /// The zero \[ns since 1970\].
    origin_ns: i128,
}

impl Since {
    /// The clock that `text` describes: a unit of time, `since`, a date, a time of day and a zone.
    pub fn parse(text: &str) -> Option<Self> {
        let (unit, date) = text.trim().split_once(" since ")?;
        let unit = unit_named(unit.trim()).filter(|unit| unit.si == "s")?;
        let origin_ns = zero(date.trim())?;
        Some(Since { count_s: unit.to_si(1.0), origin_ns })
    }

    /// How the counts of a text are read; `None` of a zero that no stamp has.
    pub fn form(&self) -> Option<Form> {
        let day_ns = 86_400_000_000_000;
        let day = i64::try_from(self.origin_ns.div_euclid(day_ns)).ok()?;
        let within_ns = i64::try_from(self.origin_ns.rem_euclid(day_ns)).ok()?;
        let count_ns = Some((self.count_s * 1e9).round()).filter(|ns| (1.0..1e18).contains(ns))? as i64;
        Some(Form::Since(count_ns, Stamp { day, within_ns }))
    }

    /// A count \[s since 1970\], and what its `f64` does not hold; `rest` is that of the count.
    #[cfg(feature = "foreign")]
    pub fn seconds(&self, count: f64, rest: f64) -> (f64, f64) {
        let per_s = self.count_s.recip().round();
        if !count.is_finite() {
            return (f64::NAN, 0.0);
        }
        let ns = if count.fract() == 0.0 && count.abs() < 1e18 * 9.0 && per_s >= 1.0 && 1e9 % per_s == 0.0 {
            (count as i128 + rest as i128) * (1e9 / per_s) as i128 + self.origin_ns
        } else {
            ((((count + rest) * self.count_s) * 1e9).round() as i128).saturating_add(self.origin_ns)
        };
        seconds_of(ns)
    }
}

/// A date with or without a time of day and a zone \[ns since 1970\]; without a zone in UTC.
fn zero(text: &str) -> Option<i128> {
    let (date, rest) = text.split_once(['T', ' ']).unwrap_or((text, ""));
    let mut parts = date.split('-').map(str::parse::<i16>);
    let (Some(Ok(year)), Some(Ok(month)), Some(Ok(day)), None) =
        (parts.next(), parts.next(), parts.next(), parts.next())
    else {
        return None;
    };
    let date = Date::new(year, month.try_into().ok()?, day.try_into().ok()?).ok()?;
    let rest = rest.trim();
    let end = rest.find(|c: char| !(c.is_ascii_digit() || matches!(c, ':' | '.'))).unwrap_or(rest.len());
    let (time, zone) = rest.split_at(end);
    let time = DateTime::from_parts(date, time_of_day(time)?);
    let since = jiff::civil::date(1970, 1, 1).at(0, 0, 0, 0).duration_until(time);
    Some(since.as_nanos() - i128::from(offset_s(zone.trim())?) * 1_000_000_000)
}

/// Hours, minutes and seconds; what is not there is 0.
fn time_of_day(text: &str) -> Option<Time> {
    let mut parts = text.split(':').filter(|part| !part.is_empty());
    let mut whole = || parts.next().map_or(Some(0), |part| part.parse::<i8>().ok());
    let (hour, minute) = (whole()?, whole()?);
    let second: f64 = parts.next().map_or(Some(0.0), |part| part.parse().ok())?;
    let ns = ((second - second.floor()) * 1e9).round() as i32;
    Time::new(hour, minute, second.floor() as i8, ns.min(999_999_999)).ok()
}

/// What a zone is ahead of UTC \[s\]: `Z`, `UTC`, `+01:00`, `-5`.
fn offset_s(zone: &str) -> Option<i64> {
    if matches!(zone.to_ascii_uppercase().as_str(), "" | "Z" | "UTC" | "GMT") {
        return Some(0);
    }
    let sign = if zone.starts_with('-') { -1 } else { 1 };
    let digits = zone.strip_prefix(['+', '-'])?;
    let (hours, minutes) = digits.split_once(':').unwrap_or(if digits.len() > 2 {
        digits.split_at_checked(digits.len() - 2)?
    } else {
        (digits, "0")
    });
    Some(sign * (hours.parse::<i64>().ok()? * 3600 + minutes.parse::<i64>().ok()? * 60))
}

#[cfg(all(test, feature = "foreign"))]
mod tests {
    use super::*;
    use crate::intake::origin::split;

    #[test]
    fn counts_begin_at_the_date_that_their_unit_names() {
        let cases = [
            ("seconds since 2024-03-05 15:00:00", 1.5, 1_709_650_801.5),
            ("s since 2024-03-05T15:00:00Z", 0.0, 1_709_650_800.0),
            ("milliseconds since 1970-01-01", 1500.0, 1.5),
            ("minutes since 2024-3-5 15:00", 2.0, 1_709_650_920.0),
            ("hours since 2024-03-05 15:00:0.5 UTC", 1.0, 1_709_654_400.5),
            ("days since 2024-03-05 00:00:00 +01:00", 0.5, 1_709_636_400.0),
            ("days since 2024-03-05 00:00:00 -5", 0.0, 1_709_614_800.0),
        ];
        for (unit, count, seconds) in cases {
            let since = Since::parse(unit).unwrap_or_else(|| panic!("{unit}"));
            assert_eq!(since.seconds(count, 0.0).0, seconds, "{unit}");
        }
        for unit in ["s", "months since 2024-01-01", "seconds since start", "deg since 2024-01-01", "s since 1-2"] {
            assert_eq!(Since::parse(unit), None, "{unit}");
        }
    }

    #[test]
    fn nanoseconds_keep_their_digits() {
        let since = Since::parse("nanoseconds since 1970-01-01 00:00:00").unwrap();
        let (count, rest) = split(1_709_650_800_123_456_789);
        let (seconds, below) = since.seconds(count, rest);
        assert!(((seconds - 1_709_650_800.0) + below - 0.123_456_789).abs() < 1e-12);
    }
}
