//! Numbers that stand for a time: counts from a zero, parts of a second, the fields of a calendar.

use super::{DAY_NS, Form, Stamp, of_ns};
use jiff::civil::date;

/// Days of a common year before each month.
const BEFORE_MONTH: [i64; 12] = [0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334];
const SECOND_NS: i64 = 1_000_000_000;
const HOUR_NS: i64 = 3_600_000_000_000;
/// Years that a stamp may have: `i64` nanoseconds since 1970 end in 2262.
const YEARS: core::ops::Range<i64> = 1900..2262;

/// The stamp of a cell that is a count in this form; `None` of forms that are texts.
pub(super) fn of_cell(form: Form, cell: &str) -> Option<Stamp> {
    if let Form::Hex(ns) = form {
        let digits = cell.strip_prefix("0x").or_else(|| cell.strip_prefix("0X"))?;
        return of_ns(i128::from(u64::from_str_radix(digits, 16).ok()?).checked_mul(ns.into())?);
    }
    let unsigned = cell.strip_prefix(['-', '+']).unwrap_or(cell);
    let (whole, fraction) = unsigned.split_once(['.', ',']).unwrap_or((unsigned, ""));
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if whole.len() > 30 || whole.is_empty() || !digits(whole) || !digits(fraction) {
        return of_value(form, cell.replace(',', ".").parse().ok()?, 0.0);
    }
    let sign = if cell.starts_with('-') { -1 } else { 1 };
    let part: f64 = format!("0.{fraction}0").parse().ok()?;
    of_count(form, sign * whole.parse::<i128>().ok()?, f64::from(sign as i8) * part)
}

/// The stamp of a number and of what its `f64` does not hold.
pub(super) fn of_value(form: Form, value: f64, rest: f64) -> Option<Stamp> {
    if !value.is_finite() || value.abs() > 1e19 {
        return None;
    }
    of_count(form, value.trunc() as i128 + rest.trunc() as i128, value.fract() + rest.fract())
}

fn of_count(form: Form, whole: i128, part: f64) -> Option<Stamp> {
    let counted = |ns: i64| Some(whole.checked_mul(ns.into())? + (part * ns as f64).round() as i128);
    let field = i64::try_from(whole).ok().filter(|_| part == 0.0);
    match form {
        Form::Count(ns) => of_ns(counted(ns)?),
        Form::Hour => of_ns(counted(HOUR_NS)?).filter(|stamp| matches!(stamp.day, 0 | 1)),
        Form::Since(ns, zero) => {
            let zero_ns = i128::from(zero.day) * i128::from(DAY_NS) + i128::from(zero.within_ns);
            of_ns(counted(ns)? + zero_ns)
        }
        Form::Part(of_second) => {
            let ns = (whole as f64 + part) / of_second as f64 * SECOND_NS as f64;
            (whole >= 0 && whole <= of_second.into()).then(|| of_ns(ns.round() as i128)).flatten()
        }
        Form::Year => {
            let first = date(i16::try_from(field.filter(|year| YEARS.contains(year))?).ok()?, 1, 1);
            Some(Stamp { day: super::reading::day_number(first), within_ns: 0 })
        }
        Form::Month => {
            let month = usize::try_from(field? - 1).ok()?;
            Some(Stamp { day: *BEFORE_MONTH.get(month)?, within_ns: 0 })
        }
        Form::TimeOfDigits => time_of_digits(field.or_else(|| i64::try_from(whole).ok())?, part),
        _ => None,
    }
}

/// `145958.25` is 14:59:58.25.
fn time_of_digits(whole: i64, part: f64) -> Option<Stamp> {
    let (hours, minutes, seconds) = (whole / 10_000, whole / 100 % 100, whole % 100);
    let is_time = whole >= 0 && hours < 24 && minutes < 60 && seconds < 61;
    let within_ns = ((hours * 60 + minutes) * 60 + seconds) * SECOND_NS + (part * SECOND_NS as f64).round() as i64;
    is_time.then_some(Stamp { day: 0, within_ns })
}

/// Whether numbers are hours, minutes and seconds by more than their size: zeros lead them, or they
/// jump from second 59 to the next minute, where the times do not jump.
pub(super) fn carries_at_60<'a>(cells: impl Iterator<Item = &'a str> + Clone) -> bool {
    const JUMP: f64 = 40.0;
    if cells.clone().any(|cell| cell.trim().starts_with('0')) {
        return true;
    }
    let numbers: Vec<f64> = cells.clone().filter_map(|cell| cell.trim().parse().ok()).collect();
    let of_day = |cell: &str| of_cell(Form::TimeOfDigits, cell.trim()).map(|stamp| stamp.since_s(0));
    let times: Vec<f64> = cells.filter_map(of_day).collect();
    let steps = |of: &[f64]| of.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    steps(&numbers) > JUMP && steps(&times) < steps(&numbers) - 0.9 * JUMP
}

/// The stamp of a row whose time stands in several columns, day and nanoseconds not carried.
pub(crate) fn sum(parts: impl Iterator<Item = (Form, Stamp)>) -> Stamp {
    let (mut total, mut year, mut month) = (Stamp { day: 0, within_ns: 0 }, None, None);
    for (form, stamp) in parts {
        total = Stamp { day: total.day + stamp.day, within_ns: total.within_ns + stamp.within_ns };
        match form {
            Form::Year => year = Some(stamp.day),
            Form::Month => month = Some(stamp.day),
            _ => {}
        }
    }
    let is_leap = |first_day: i64| {
        let first = date(1970, 1, 1).checked_add(jiff::Span::new().days(first_day));
        first.is_ok_and(jiff::civil::Date::in_leap_year)
    };
    let behind_february = month.is_some_and(|days| days >= BEFORE_MONTH[2]) && year.is_some_and(is_leap);
    Stamp { day: total.day + i64::from(behind_february), ..total }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_keep_sign_exponent_and_every_digit() {
        let s = Form::Count(SECOND_NS);
        let ns = |cell: &str| of_cell(s, cell).map(|stamp| stamp.day * DAY_NS + stamp.within_ns);
        assert_eq!(ns("1.25"), Some(1_250_000_000));
        assert_eq!(ns("-0.25"), Some(-250_000_000));
        assert_eq!(ns("-1,5"), Some(-1_500_000_000));
        assert_eq!(ns("1.5e3"), Some(1_500_000_000_000));
        assert_eq!(ns("1709650800.123456789"), Some(1_709_650_800_123_456_789));
        assert_eq!([ns("abc"), ns(""), ns("inf"), ns("1.2.3")], [None; 4]);
    }

    #[test]
    fn the_fields_of_a_calendar_add_up_in_leap_years_and_others() {
        let day_of = |year: &str, month: &str, day: &str| {
            let forms = [Form::Year, Form::Month, Form::Since(DAY_NS, Stamp { day: -1, within_ns: 0 })];
            let cells = [year, month, day];
            let parts = forms.into_iter().zip(cells).map(|(form, cell)| (form, of_cell(form, cell).unwrap()));
            sum(parts).day_text()
        };
        for (year, month, day) in [("2024", "2", "29"), ("2024", "3", "5"), ("2023", "3", "1"), ("2000", "12", "31")] {
            let padded = format!("{year}-{:0>2}-{:0>2}", month, day);
            assert_eq!(day_of(year, month, day), padded);
        }
        assert_eq!(of_cell(Form::Month, "13"), None);
        assert_eq!(of_cell(Form::Month, "2.5"), None);
    }

    #[test]
    fn six_digits_are_hours_minutes_and_seconds() {
        let at = |cell: &str| of_cell(Form::TimeOfDigits, cell).map(|stamp| stamp.within_ns / 1_000_000);
        assert_eq!(at("145958.25"), Some(((14 * 60 + 59) * 60 + 58) * 1000 + 250));
        assert_eq!(at("000001.5"), Some(1500));
        assert_eq!([at("146058"), at("250000"), at("-1")], [None; 3]);
    }
}
