//! Date and time as text: ISO 8601 and what spreadsheets of different countries write.

use jiff::Timestamp;
use jiff::civil::{Date, DateTime, Time};

/// A stamp: whole days since 1970-01-01 and nanoseconds within the day.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stamp {
    pub day: i64,
    pub within_ns: i64,
}

/// What a cell's text tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// Date and time; in UTC where the text states an offset.
    DateTime(&'static str),
    /// A date alone: another column has the time.
    Date(&'static str),
    /// A time of day alone.
    Time(&'static str),
}

/// ISO 8601, which `jiff` parses without a pattern.
const ISO: &str = "";
const DATE_TIMES: &[&str] = &[
    ISO,
    "%d.%m.%Y %H:%M:%S%.f",
    "%d/%m/%Y %H:%M:%S%.f",
    "%m/%d/%Y %H:%M:%S%.f",
    "%Y/%m/%d %H:%M:%S%.f",
    "%d-%b-%Y %H:%M:%S%.f",
    "%d %b %Y %H:%M:%S%.f",
    "%m/%d/%Y %I:%M:%S%.f %p",
    "%Y%m%d %H%M%S%.f",
];
const DATES: &[&str] = &[ISO, "%d.%m.%Y", "%d/%m/%Y", "%m/%d/%Y", "%Y/%m/%d", "%d-%b-%Y"];
const TIMES: &[&str] = &[ISO, "%H:%M:%S%.f", "%I:%M:%S%.f %p", MINUTES];
/// Minutes and seconds with their decimals: without them hours and minutes are as likely.
const MINUTES: &str = "%M:%S%.f";

impl Form {
    /// The first form that every one of `cells` has.
    pub fn of<'a>(cells: impl Iterator<Item = &'a str> + Clone) -> Option<Self> {
        // Numbers alone are no dates: 20250417 may count anything.
        if cells.clone().any(|cell| !cell.contains([':', '-', '/', '.']) || cell.trim().parse::<f64>().is_ok()) {
            return None;
        }
        let all = |form: &Form| cells.clone().all(|cell| form.read(cell).is_some());
        let times = TIMES.iter().map(|pattern| Form::Time(pattern));
        let dates = DATES.iter().map(|pattern| Form::Date(pattern));
        let both = DATE_TIMES.iter().map(|pattern| Form::DateTime(pattern));
        times.chain(both).chain(dates).find(all).filter(|_| cells.clone().next().is_some())
    }

    /// The stamp that `cell` tells in this form.
    pub fn read(self, cell: &str) -> Option<Stamp> {
        let cell = cell.trim();
        match self {
            Form::DateTime(ISO) => iso(cell),
            Form::DateTime(pattern) => DateTime::strptime(pattern, pointed(cell)).ok().map(of_date_time),
            Form::Date(ISO) => cell.parse::<Date>().ok().filter(|_| cell.len() <= 10).map(|date| at(date, 0)),
            Form::Date(pattern) => Date::strptime(pattern, cell).ok().map(|date| at(date, 0)),
            Form::Time(ISO) => cell.parse::<Time>().ok().filter(|_| has_time_alone(cell)).map(of_time),
            Form::Time(MINUTES) => {
                let seconds = cell.split_once(':').map(|(_, seconds)| seconds).filter(|s| s.contains(['.', ',']))?;
                (!seconds.contains(':')).then(|| Form::Time("%H:%M:%S%.f").read(&format!("00:{cell}"))).flatten()
            }
            Form::Time(pattern) => Time::strptime(pattern, pointed(cell)).ok().map(of_time),
        }
    }

    /// Day and month cannot be told apart by this form.
    pub fn is_day_first(self) -> bool {
        matches!(self, Form::DateTime(pattern) | Form::Date(pattern) if pattern.starts_with("%d/%m"))
    }
}

fn has_time_alone(cell: &str) -> bool {
    cell.get(1..3).is_some_and(|start| start.contains(':')) && !cell.contains('-')
}

fn pointed(cell: &str) -> String {
    cell.replace(',', ".")
}

fn iso(cell: &str) -> Option<Stamp> {
    if cell.len() < 16 {
        return None;
    }
    if let Ok(civil) = cell.parse::<DateTime>() {
        return Some(of_date_time(civil));
    }
    let instant = cell.parse::<Timestamp>().ok()?;
    let ns = instant.as_nanosecond();
    let day = ns.div_euclid(DAY_NS.into());
    Some(Stamp { day: day as i64, within_ns: (ns - day * i128::from(DAY_NS)) as i64 })
}

const DAY_NS: i64 = 86_400_000_000_000;

fn at(date: Date, within_ns: i64) -> Stamp {
    let epoch = jiff::civil::date(1970, 1, 1);
    let day = epoch.until(date).map_or(0, |span| i64::from(span.get_days()));
    Stamp { day, within_ns }
}

fn of_time(time: Time) -> Stamp {
    let seconds = i64::from(time.hour()) * 3600 + i64::from(time.minute()) * 60 + i64::from(time.second());
    Stamp { day: 0, within_ns: seconds * 1_000_000_000 + i64::from(time.subsec_nanosecond()) }
}

fn of_date_time(stamp: DateTime) -> Stamp {
    at(stamp.date(), of_time(stamp.time()).within_ns)
}

impl Stamp {
    /// Seconds since the beginning of day `day`.
    pub fn since_s(self, day: i64) -> f64 {
        // below 2^53 ns (104 days) exactly one rounding
        ((self.day - day) * DAY_NS + self.within_ns) as f64 / 1e9
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
