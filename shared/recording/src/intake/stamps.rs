//! Date and time as text: ISO 8601, ordinal days, what spreadsheets, loggers and the C library of
//! different countries write, and counts that stand for a time.

mod reading;
mod words;

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
    /// Days and a time, since the beginning.
    Elapsed,
    /// A count of this many nanoseconds.
    Count(i64),
    /// As [`Form::Count`], in digits to base 16 behind `0x`.
    Hex(i64),
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
        times.into_iter().chain([Form::Elapsed, Form::Hex(1)]).chain(dates).find(all)
    }

    /// The form of numbers that are dates: `20240305145958000`, year to second or millisecond.
    pub fn of_digits<'a>(mut cells: impl Iterator<Item = &'a str> + Clone) -> Option<Self> {
        let is_date = |cell: &str| reading::of_digits(cell.trim()).is_some();
        (cells.clone().next().is_some() && cells.all(is_date)).then_some(Form::DateTime(Order::Stated))
    }

    /// The stamp that `cell` states in this form.
    pub fn read(self, cell: &str) -> Option<Stamp> {
        let cell = cell.trim();
        match self {
            Form::Count(ns) => counted(cell, ns),
            Form::Hex(ns) => of_hex(cell, ns),
            Form::DateTime(order) => {
                let reading = reading::of_digits(cell).or_else(|| Reading::of(cell, order))?;
                (reading.time.is_some() && reading.clock != Some(Clock::Minutes)).then(|| reading.stamp(true)).flatten()
            }
            Form::Date(order) => Reading::of(cell, order).filter(|reading| reading.time.is_none())?.stamp(true),
            Form::Time(clock) => Reading::of(cell, Order::Stated).filter(|of| of.clock == Some(clock))?.stamp(false),
            Form::Elapsed => Reading::of(cell, Order::Stated)?.since_beginning(),
        }
    }

    /// The order that is taken for the dates, where they do not say it.
    pub fn open_order(self) -> Option<Order> {
        match self {
            Form::DateTime(order) | Form::Date(order) if order != Order::Stated => Some(order),
            _ => None,
        }
    }

    /// The form with another order of its dates, where they do not say it.
    pub fn with_order(self, order: Order) -> Self {
        match self {
            Form::DateTime(Order::Stated) | Form::Date(Order::Stated) => self,
            Form::DateTime(_) => Form::DateTime(order),
            Form::Date(_) => Form::Date(order),
            _ => self,
        }
    }

    /// Whether the stamps are dates.
    pub fn has_day(self) -> bool {
        matches!(self, Form::DateTime(_) | Form::Date(_))
    }
}

const DAY_NS: i64 = 86_400_000_000_000;

/// A stamp of nanoseconds in total.
fn of_ns(ns: i128) -> Option<Stamp> {
    let day = ns.div_euclid(DAY_NS.into());
    Some(Stamp { day: i64::try_from(day).ok()?, within_ns: i64::try_from(ns.rem_euclid(DAY_NS.into())).ok()? })
}

fn counted(cell: &str, ns: i64) -> Option<Stamp> {
    let (whole, fraction) = cell.split_once(['.', ',']).unwrap_or((cell, "0"));
    let part: f64 = format!("0.{fraction}").parse().ok()?;
    let whole: i128 = whole.parse().ok()?;
    of_ns(whole.checked_mul(ns.into())? + (part * ns as f64) as i128)
}

fn of_hex(cell: &str, ns: i64) -> Option<Stamp> {
    let digits = cell.strip_prefix("0x").or_else(|| cell.strip_prefix("0X"))?;
    of_ns(i128::from(u64::from_str_radix(digits, 16).ok()?).checked_mul(ns.into())?)
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
        assert_eq!(Form::of_digits(["20240305145958000"].into_iter()), Some(Form::DateTime(Order::Stated)));
        assert_eq!(Form::of_digits(["20241305145958000"].into_iter()), None);
    }
}
