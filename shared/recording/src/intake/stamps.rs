//! Date and time as text: ISO 8601, ordinal days, what spreadsheets, loggers and the C library of
//! different countries write, and counts that stand for a time.

mod counts;
mod durations;
mod reading;
mod words;

use super::clock;
pub(crate) use counts::sum;
use reading::Reading;

/// A stamp: whole days since 1970-01-01 and nanoseconds within the day.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stamp {
    pub day: i64,
    pub within_ns: i64,
}

/// The first number in a date of three numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// The date says it: a year of four digits first, or a month by name.
    Stated,
    Day,
    Month,
    Year,
}

impl Order {
    /// The orders that a date may have which does not say it, the likeliest first.
    pub const OPEN: [Order; 3] = [Order::Day, Order::Month, Order::Year];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Order::Day => "day/month/year",
            Order::Month => "month/day/year",
            Order::Stated | Order::Year => "year/month/day",
        }
    }
}

/// What a time of day has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Clock {
    /// Hours from 0.
    Hours,
    /// Hours from 1 to 12, and which half of the day.
    Halves,
    /// Minutes and seconds with their decimals: without them hours and minutes are as likely.
    Minutes,
}

/// What a cell's text says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// Date and time; in UTC where the text states a zone.
    DateTime(Order),
    /// A date alone: another column has the time.
    Date(Order),
    /// A time of day alone.
    Time(Clock),
    /// Days and a time, or a duration with its units, since the beginning.
    Elapsed,
    /// A count of this many nanoseconds.
    Count(i64),
    /// As [`Form::Count`], in digits to base 16 behind `0x`.
    Hex(i64),
    /// A count of this many nanoseconds from a date.
    Since(i64, Stamp),
    /// Parts of a second, of which there are so many.
    Part(i64),
    /// Hours of the day, which begin again at midnight.
    Hour,
    /// `145958.25`, a time of day.
    TimeOfDigits,
    /// `050324`, a date.
    DateOfDigits(Order),
    Year,
    /// Of the year, from 1.
    Month,
}

impl Form {
    /// The first form that every one of `cells` has.
    pub fn of<'a>(cells: impl Iterator<Item = &'a str> + Clone) -> Option<Self> {
        cells.clone().next()?;
        // Numbers alone are no dates: 20250417 may count anything.
        if cells.clone().any(|cell| cell.trim().parse::<f64>().is_ok()) {
            return None;
        }
        let times = [Clock::Hours, Clock::Halves, Clock::Minutes].map(Form::Time);
        let orders = [Order::Stated, Order::Day, Order::Month, Order::Year];
        let dates = orders.map(Form::DateTime).into_iter().chain(orders.map(Form::Date));
        let all = |form: &Form| cells.clone().all(|cell| form.read(cell).is_some());
        if !are_milliseconds(cells.clone()) {
            return None;
        }
        times.into_iter().chain([Form::Elapsed, Form::Hex(1)]).chain(dates).find(all)
    }

    /// Whether a cell has any of the forms.
    pub fn is_of(cell: &str) -> bool {
        let orders = [Order::Stated, Order::Day, Order::Month, Order::Year];
        Form::of([cell].into_iter()).is_some() || orders.iter().any(|order| Reading::of(cell.trim(), *order).is_some())
    }

    /// The form of numbers alone that are dates and times, in a column called `name`:
    /// `20240305145958000`, year to second or millisecond; the time of day of satellite receivers,
    /// `145958.25`, and their date, `050324`.
    pub fn of_digits<'a>(name: &str, cells: impl Iterator<Item = &'a str> + Clone) -> Option<Self> {
        cells.clone().next()?;
        let all = |is: &dyn Fn(&str) -> bool| cells.clone().all(|cell| is(cell.trim()));
        if clock::rank(name).is_some() && all(&|cell| reading::of_digits(cell).is_some()) {
            return Some(Form::DateTime(Order::Stated));
        }
        let words = clock::words_of(name);
        let has = |of: &[&str]| words.split(' ').any(|word| of.contains(&word));
        let six = |cell: &str| cell.split_once('.').map_or(cell, |(whole, _)| whole).len() == 6;
        if has(&["utc", "gmt", "hhmmss"]) && all(&|cell| six(cell) && Form::TimeOfDigits.read(cell).is_some()) {
            return Some(Form::TimeOfDigits);
        }
        let is_time = |cell: &str| six(cell) && Form::TimeOfDigits.read(cell).is_some();
        if clock::rank(name).is_some() && all(&is_time) && counts::carries_at_60(cells.clone()) {
            return Some(Form::TimeOfDigits);
        }
        let orders = [Order::Stated, Order::Day, Order::Month, Order::Year].map(Form::DateOfDigits);
        let is_date = has(&["date", "datum", "fecha", "ddmmyy", "yyyymmdd", "yymmdd"]);
        orders.into_iter().find(|form| is_date && all(&|cell| form.read(cell).is_some()))
    }

    /// The stamp that `cell` states in this form.
    pub fn read(self, cell: &str) -> Option<Stamp> {
        let cell = cell.trim();
        match self {
            Form::DateTime(order) => {
                let reading = reading::of_digits(cell).or_else(|| Reading::of(cell, order))?;
                (reading.time.is_some() && reading.clock != Some(Clock::Minutes)).then(|| reading.stamp(true)).flatten()
            }
            Form::Date(order) => Reading::of(cell, order).filter(|reading| reading.time.is_none())?.stamp(true),
            Form::Time(clock) => Reading::of(cell, Order::Stated).filter(|of| of.clock == Some(clock))?.stamp(false),
            Form::Elapsed => {
                let days = Reading::of(cell, Order::Stated).and_then(Reading::since_beginning);
                days.or_else(|| durations::of(cell))
            }
            Form::DateOfDigits(order) => reading::date_of_digits(cell, order),
            _ => counts::of_cell(self, cell),
        }
    }

    /// The stamp that a number states in this form, `rest` being what its `f64` does not hold.
    pub fn of_value(self, value: f64, rest: f64) -> Option<Stamp> {
        counts::of_value(self, value, rest)
    }

    /// The order that is taken for the dates, where they do not say it.
    pub fn open_order(self) -> Option<Order> {
        match self {
            Form::DateTime(order) | Form::Date(order) | Form::DateOfDigits(order) if order != Order::Stated => {
                Some(order)
            }
            _ => None,
        }
    }

    /// The form with another order of its dates, where they do not say it.
    pub fn with_order(self, order: Order) -> Self {
        match self {
            Form::DateTime(Order::Stated) | Form::Date(Order::Stated) | Form::DateOfDigits(Order::Stated) => self,
            Form::DateTime(_) => Form::DateTime(order),
            Form::Date(_) => Form::Date(order),
            Form::DateOfDigits(_) => Form::DateOfDigits(order),
            _ => self,
        }
    }

    /// Whether the stamps are dates.
    pub fn has_day(self) -> bool {
        matches!(self, Form::DateTime(_) | Form::Date(_) | Form::DateOfDigits(_) | Form::Since(..) | Form::Year)
    }

    /// Whether the stamps are times of a day.
    pub fn is_of_a_day(self) -> bool {
        matches!(self, Form::Time(_) | Form::Hour | Form::TimeOfDigits)
    }
}

/// Whether digits behind a colon behind the seconds are milliseconds: three in some cell, where
/// others have fewer. One or two in every cell may as well be frames, or hundredths.
fn are_milliseconds<'a>(cells: impl Iterator<Item = &'a str>) -> bool {
    let orders = [Order::Stated, Order::Day, Order::Month, Order::Year];
    let digits = |cell: &str| orders.iter().find_map(|order| Reading::of(cell.trim(), *order)?.colon_digits);
    let (mut fewer, mut three) = (false, false);
    for digits in cells.filter(|cell| cell.matches(':').count() > 2).filter_map(digits) {
        fewer |= digits < 3;
        three |= digits == 3;
    }
    three || !fewer
}

const DAY_NS: i64 = 86_400_000_000_000;

/// A stamp of nanoseconds in total.
fn of_ns(ns: i128) -> Option<Stamp> {
    let day = ns.div_euclid(DAY_NS.into());
    Some(Stamp { day: i64::try_from(day).ok()?, within_ns: i64::try_from(ns.rem_euclid(DAY_NS.into())).ok()? })
}

impl Stamp {
    /// Seconds since the beginning of day `day`.
    pub fn since_s(self, day: i64) -> f64 {
        // below 2^53 ns (104 days) exactly one rounding
        ((self.day - day) as i128 * i128::from(DAY_NS) + i128::from(self.within_ns)) as f64 / 1e9
    }

    /// Nanoseconds since 1970; `None` before.
    pub fn since_1970_ns(self) -> Option<u64> {
        u64::try_from(self.day.checked_mul(DAY_NS)?.checked_add(self.within_ns)?).ok()
    }

    /// The day as text.
    pub fn day_text(self) -> String {
        let date = jiff::civil::date(1970, 1, 1).checked_add(jiff::Span::new().days(self.day));
        date.map_or_else(|_| format!("day {}", self.day), |date| date.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(cell: &str) -> (String, i64) {
        let form = Form::of([cell].into_iter()).unwrap_or_else(|| panic!("{cell}"));
        let stamp = form.read(cell).unwrap();
        (stamp.day_text(), stamp.within_ns / 1_000_000)
    }

    #[test]
    fn a_date_and_time_is_read_in_every_spelling() {
        let at = |h: i64, m: i64, s: i64, ms: i64| ((h * 60 + m) * 60 + s) * 1000 + ms;
        let afternoon = at(14, 59, 58, 250);
        for cell in [
            "2024-03-05T14:59:58.250",
            "2024-03-05 14:59:58,250",
            "2024-03-05 14:59:58.250 UTC",
            "2024-03-05T14:59:58.250Z",
            "2024-03-05T15:59:58.250+01:00",
            "2024-03-05 15:59:58.250 +0100",
            "2024-03-05 15:59:58.250 CET",
            "2024-03-05T15:59:58.250+01:00[Europe/Berlin]",
            "2024-03-05T09:59:58.250-05:00",
            "2024/03/05 14:59:58.250",
            "2024.03.05 14:59:58.250",
            "2024:03:05 14:59:58.250",
            "20240305 145958.250",
            "20240305T145958.250",
            "05-Mar-2024 14:59:58.250",
            "5 March 2024 14:59:58.250",
            "05-Mar-24 14:59:58.250",
            "Tue Mar  5 14:59:58.250 2024",
            "Mar 5, 2024, 02:59:58.250 PM",
            "Tue, 05 Mar 2024 14:59:58.250 GMT",
            "Tue Mar 05 2024 15:59:58.250 GMT+0100 (Central European Standard Time)",
            "2024-065T14:59:58.250",
            "2024:065:14:59:58.250",
            "2024-03-05 14:59:58:250",
        ] {
            assert_eq!(of(cell), ("2024-03-05".into(), afternoon), "{cell}");
        }
        assert_eq!(of("2024-03-05T01:00:00+05:30"), ("2024-03-04".into(), at(19, 30, 0, 0)));
        assert_eq!(of("2016-12-31T23:59:60.5Z"), ("2017-01-01".into(), 500));
        assert_eq!(of("14:59:58:250"), ("1970-01-01".into(), afternoon));
        assert_eq!(of("2:59:58.250 pm"), ("1970-01-01".into(), afternoon));
        assert_eq!(of("59:58.250"), ("1970-01-01".into(), at(0, 59, 58, 250)));
        assert_eq!(of("0 days 14:59:58.250000"), ("1970-01-01".into(), afternoon));
        assert_eq!(of("1 day, 14:59:58.25"), ("1970-01-02".into(), afternoon));
        assert_eq!(of("0x00002710"), ("1970-01-01".into(), 0));
    }

    #[test]
    fn a_date_that_does_not_say_its_order_has_every_order_that_fits() {
        let day = |cell: &str, order| Form::DateTime(order).read(cell).map(Stamp::day_text);
        let is = |text: &str| Some(text.to_owned());
        assert_eq!(day("03/05/2024 1:00:00", Order::Day), is("2024-05-03"));
        assert_eq!(day("03/05/2024 1:00:00", Order::Month), is("2024-03-05"));
        assert_eq!(day("03/25/2024 1:00:00", Order::Day), None);
        assert_eq!(day("24.03.05 1:00:00", Order::Year), is("2024-03-05"));
        assert_eq!(day("24.03.05 1:00:00", Order::Day), is("2005-03-24"));
        assert_eq!(day("24.03.05 1:00:00", Order::Stated), None);
    }

    #[test]
    fn what_is_no_stamp_has_no_form() {
        for cell in ["1.2.3", "10.0.0.1", "abc", "12", "2024-13-05 10:00:00", "1:2", "-", "", "12:30:61", "a-b", "may"]
        {
            assert_eq!(Form::of([cell].into_iter()), None, "{cell}");
        }
        let digits = |name: &str, cell: &'static str| Form::of_digits(name, [cell].into_iter());
        assert_eq!(digits("time", "20240305145958000"), Some(Form::DateTime(Order::Stated)));
        assert_eq!(digits("utc_time", "145958.25"), Some(Form::TimeOfDigits));
        assert_eq!(digits("date", "050324"), Some(Form::DateOfDigits(Order::Day)));
        assert_eq!(digits("Date", "20240305"), Some(Form::DateOfDigits(Order::Stated)));
        for (name, cell) in
            [("time", "20241305145958000"), ("time", "145958.25"), ("utc", "45958.25"), ("rate", "050324")]
        {
            assert_eq!(digits(name, cell), None, "{name} {cell}");
        }
    }
}
