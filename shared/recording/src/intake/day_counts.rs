//! Numbers that count days: those of spreadsheets, of MATLAB and of astronomers.

use super::clock::words_of;
use super::stamps::{Form, Stamp};
use core::ops::Range;

const DAY_NS: i64 = 86_400_000_000_000;
const NOON: i64 = DAY_NS / 2;

/// From when a program counts days.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DayCount {
    /// The first days of 2000 and of 2100.
    days: (f64, f64),
    zero: Stamp,
    /// In words.
    pub since: &'static str,
}

const fn count(days: (f64, f64), day: i64, within_ns: i64, since: &'static str) -> DayCount {
    DayCount { days, zero: Stamp { day, within_ns }, since }
}

/// Known by their size alone.
const BY_SIZE: [DayCount; 3] = [
    count((36_526.0, 73_051.0), -25_569, 0, "1899-12-30, as spreadsheets count them"),
    count((730_486.0, 767_011.0), -719_529, 0, "the year 0, as MATLAB counts them"),
    count((2_451_544.5, 2_488_069.5), -2_440_588, NOON, "noon of -4712-01-01, as astronomers count them"),
];
/// Of columns that are called so: the modified Julian date, and that of GMAT, which has another
/// zero. The second ends where the first begins, in 2082.
const BY_NAME: [DayCount; 2] = [
    count((51_544.0, 88_069.0), -40_587, 0, "1858-11-17, as modified Julian dates count them"),
    count((21_544.5, 51_544.0), -10_588, NOON, "noon of 1941-01-05, as GMAT counts its modified Julian dates"),
];

/// Steps that numbers of days have [days]: a tenth of a microsecond to a day.
const STEPS: Range<f64> = 1e-12..1.0;

impl DayCount {
    /// From when `samples` of a column count days, if they do: numbers of this century in small
    /// parts of a day.
    pub fn of(name: &str, samples: &[f64]) -> Option<Self> {
        let first = *samples.first()?;
        let mut steps: Vec<f64> = samples.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
        steps.sort_unstable_by(f64::total_cmp);
        let step = steps.get(steps.len() / 2)?;
        let is_part = STEPS.contains(step) && samples.iter().any(|value| value.fract() != 0.0);
        let named: &[DayCount] = if is_modified(name) { &BY_NAME } else { &[] };
        let holds = |of: &&DayCount| of.days.0 <= first && first < of.days.1;
        named.iter().chain(&BY_SIZE).find(holds).copied().filter(|_| is_part)
    }

    /// How the numbers are read.
    pub fn form(self) -> Form {
        Form::Since(DAY_NS, self.zero)
    }
}

/// Ticks of 100 ns of programs for Windows: the first ticks of 2000 and of 2100, the first day, in
/// words. As nanoseconds since 1970 they would be of years before 1991.
const TICKS: [(Range<f64>, i64, &str); 2] = [
    (1.2591e17..1.5747e17, -134_774, "1601-01-01, as file times of Windows count them"),
    (6.3082e17..6.6239e17, -719_162, "0001-01-01, as .NET counts them"),
];

/// The form of whole numbers that count ticks, and from when.
pub(crate) fn ticks(samples: &[f64]) -> Option<(Form, &'static str)> {
    let of = TICKS.iter().find(|(range, ..)| samples.iter().all(|value| range.contains(value)))?;
    let whole = samples.len() > 1 && samples.iter().all(|value| value.fract() == 0.0);
    whole.then_some((Form::Since(100, Stamp { day: of.1, within_ns: 0 }), of.2))
}

/// Whether numbers may be times of a day as parts of it: within a day and not at its beginning, in
/// steps of whole milliseconds of a day that are no short number of seconds.
pub(crate) fn may_be_parts_of_a_day(samples: &[f64], step: f64) -> bool {
    const MS: f64 = 86_400_000.0;
    const LONGEST_STEP: f64 = 1e-4;
    let is_whole = |value: f64| value >= 0.5 && (value - value.round()).abs() < 2e-3 * value.max(1.0);
    let within = samples.iter().all(|value| (0.01..1.0).contains(value));
    within && step < LONGEST_STEP && is_whole(step * MS) && !is_whole(step * 1e6)
}

/// Whether a name is one of a count of days.
pub(crate) fn is_named(name: &str) -> bool {
    let words = words_of(name);
    let of_days = |word: &str| matches!(word, "datenum" | "mjd" | "jd" | "julian" | "julianday" | "juliandate");
    words.split(' ').any(of_days) || matches!(words.as_str(), "serial date" | "date number" | "date num")
}

fn is_modified(name: &str) -> bool {
    let words = words_of(name);
    words.split(' ').any(|word| word == "mjd" || word == "modjulian")
        || words.contains("julian") && words.contains("mod")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_of_windows_are_told_by_their_size() {
        for first in [133_541_246_980_000_000.0, 638_452_478_980_000_000.0] {
            let (form, _) = ticks(&[first, first + 1e5]).unwrap();
            assert_eq!(form.of_value(first, 0.0).unwrap().day_text(), "2024-03-05", "{first}");
        }
        assert_eq!(ticks(&[1.709e18, 1.709e18]), None);
        assert_eq!(ticks(&[]), None);
    }

    #[test]
    fn a_count_of_days_is_told_by_its_size_and_that_of_modified_julian_dates_by_its_name() {
        let cases = [
            ("Time", 45_356.625, "2024-03-05", 15),
            ("time", 739_316.625, "2024-03-05", 15),
            ("jd", 2_460_375.125, "2024-03-05", 15),
            ("MJD", 60_374.625, "2024-03-05", 15),
            ("Sat.A1ModJulian", 30_375.125, "2024-03-05", 15),
        ];
        for (name, days, date, hour) in cases {
            let samples: Vec<f64> = (0..10).map(|k| days + f64::from(k) / 1024.0).collect();
            let form = DayCount::of(name, &samples).unwrap_or_else(|| panic!("{name}")).form();
            let stamp = form.of_value(days, 0.0).unwrap();
            assert_eq!((stamp.day_text().as_str(), stamp.within_ns), (date, hour * 3_600_000_000_000), "{name}");
        }
        assert_eq!(DayCount::of("time", &[0.0, 0.01, 0.02]), None);
        assert_eq!(DayCount::of("count", &[40_000.0, 40_001.0]), None);
    }
}
