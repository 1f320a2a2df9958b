//! Clocks that stand in several columns: the fields of a calendar, seconds and their parts, the
//! week and the second of GPS.

use super::{Clock, Column, Kind};
use crate::intake::clock::{part_of_second, words_of};
use crate::intake::stamps::{Form, Stamp};
use crate::units::unit_named;

const SECOND_NS: i64 = 1_000_000_000;
const DAY_NS: i64 = 86_400_000_000_000;
const WEEK_NS: i64 = 7 * DAY_NS;
/// Days from 1970-01-01 to the first of GPS, 1980-01-06, and weeks that its messages can count.
const GPS_DAY: i64 = 3657;
const GPS_WEEKS: f64 = 1024.0;
/// Days and months count from 1.
const FROM_ONE: Form = Form::Since(DAY_NS, Stamp { day: -1, within_ns: 0 });

/// A clock of several columns, the columns of its own, and what is to be noted.
pub(super) struct InParts {
    pub parts: Vec<(usize, Form)>,
    pub note: String,
}

impl InParts {
    fn of(columns: &[Column<'_>], parts: Vec<(usize, Form)>, what: &str) -> Self {
        let names: Vec<String> =
            parts.iter().map(|(at, _)| format!("`{}`", columns[*at].heading.name)).collect::<Vec<_>>();
        InParts { parts, note: format!("the time of a row is {what} {}", names.join(", ")) }
    }

    /// The clock of a plan.
    pub fn clock(self, notes: &mut Vec<String>) -> Clock {
        notes.push(self.note);
        Clock::Stamps(self.parts)
    }
}

/// A field of a calendar.
struct Field {
    names: &'static [&'static str],
    form: Form,
    /// Of whole numbers; the finest field may end in a part.
    least: f64,
    most: f64,
}

const fn field(names: &'static [&'static str], form: Form, least: f64, most: f64) -> Field {
    Field { names, form, least, most }
}

const YEAR: Field =
    field(&["year", "yyyy", "yr", "jahr", "ano", "año", "année", "annee", "anno"], Form::Year, 1900.0, 2261.0);
const MONTH: Field = field(&["month", "mon", "monat", "mes", "mois", "mese"], Form::Month, 1.0, 12.0);
const DAY: Field = field(&["day", "dd", "dom", "day of month", "tag", "dia", "día", "jour"], FROM_ONE, 1.0, 31.0);
const DAY_OF_YEAR: Field =
    field(&["doy", "day of year", "dayofyear", "yday", "jday", "ddd", "day"], FROM_ONE, 1.0, 366.0);
const HOUR: Field =
    field(&["hour", "hours", "hr", "hrs", "hh", "h", "stunde", "hora", "heure", "ora"], Form::Hour, 0.0, 24.0);
const MINUTE: Field =
    field(&["minute", "minutes", "min", "mins", "mn", "minuto"], Form::Count(60 * SECOND_NS), 0.0, 59.999_999_999);
const SECOND: Field = field(
    &["second", "seconds", "sec", "secs", "ss", "s", "sekunde", "segundo", "seconde"],
    Form::Count(SECOND_NS),
    0.0,
    60.999_999_999,
);
/// Thousandths, each field of the one before.
const PARTS: [Field; 3] = [
    field(&["millisecond", "milliseconds", "millis", "msec", "ms"], Form::Count(1_000_000), 0.0, 999.999_999_999),
    field(&["microsecond", "microseconds", "micros", "usec", "us"], Form::Count(1000), 0.0, 999_999.999),
    field(
        &["nanosecond", "nanoseconds", "nano", "nanos", "nanosec", "nsec", "ns"],
        Form::Count(1),
        -999_999_999.0,
        999_999_999.0,
    ),
];

/// The columns of a calendar: hours, minutes and what is finer, and a date where there is one.
pub(super) fn of_calendar(columns: &[Column<'_>]) -> Option<InParts> {
    let find = |field: &Field| {
        let is_of = |(_, column): &(usize, &Column<'_>)| {
            column.seen.kind == Kind::Number
                && field.names.contains(&words_of_field(&column.heading.name).as_str())
                && column.seen.sample.iter().all(|value| (field.least..=field.most).contains(value))
        };
        let (at, _) = columns.iter().enumerate().find(is_of)?;
        Some((at, field.form))
    };
    let (hour, minute) = (find(&HOUR)?, find(&MINUTE)?);
    let mut parts: Vec<(usize, Form)> = match (find(&YEAR), find(&MONTH), find(&DAY), find(&DAY_OF_YEAR)) {
        (Some(year), Some(month), Some(day), _) => vec![year, month, day],
        (Some(year), None, _, Some(day)) => vec![year, day],
        _ => Vec::new(),
    };
    parts.extend([hour, minute]);
    if let Some(second) = find(&SECOND) {
        parts.push(second);
        parts.extend(PARTS.iter().filter_map(find).next());
    }
    let (_, coarse) = parts.split_last()?;
    let is_whole = |(at, _): &(usize, Form)| columns[*at].seen.sample.iter().all(|value| value.fract() == 0.0);
    coarse.iter().all(is_whole).then(|| InParts::of(columns, parts, "the sum of"))
}

/// The words of a field without what says whose it is: `UTC hour`, `GPS_Year`.
fn words_of_field(name: &str) -> String {
    let words = words_of(name);
    let of_whom = |word: &&str| matches!(*word, "utc" | "gps" | "gmt" | "local" | "date" | "time");
    let own: Vec<&str> = words.split(' ').filter(|word| !of_whom(word)).collect();
    own.join(" ")
}

/// The week of GPS and the time within it, which begins again with the week.
pub(super) fn of_gps(columns: &[Column<'_>]) -> Option<InParts> {
    let named = |names: &[&str]| {
        let is_of = |column: &Column<'_>| {
            column.seen.kind == Kind::Number && names.contains(&words_of(&column.heading.name).as_str())
        };
        columns.iter().position(is_of)
    };
    let week = named(&["gps week", "gpsweek", "gps wk", "gwk", "week", "wn", "week number", "weeknumber", "gps wn"])?;
    let is_week = |value: &f64| value.fract() == 0.0 && (0.0..8192.0).contains(value);
    let weeks = &columns[week].seen.sample;
    let within = columns.iter().position(|column| column.seen.kind == Kind::Number && is_time_of_week(column))?;
    let seconds = count_ns(&columns[within])?;
    let is_within = |value: &f64| *value >= 0.0 && *value * seconds as f64 <= WEEK_NS as f64;
    if weeks.is_empty() || !weeks.iter().all(is_week) || !columns[within].seen.sample.iter().all(is_within) {
        return None;
    }
    let zero = Stamp { day: GPS_DAY, within_ns: 0 };
    let parts = vec![(week, Form::Since(WEEK_NS, zero)), (within, Form::Count(seconds))];
    let mut all = InParts::of(columns, parts, "GPS week and time of week, which is ahead of UTC by leap seconds:");
    if weeks[0] < GPS_WEEKS {
        all.note += "; a receiver that counts weeks modulo 1024 is 1024 or 2048 weeks later than its numbers";
    }
    Some(all)
}

fn is_time_of_week(column: &Column<'_>) -> bool {
    let words = words_of(&column.heading.name);
    let bare = match words.rsplit_once(' ') {
        Some((bare, "s" | "sec" | "ms" | "ns")) => bare,
        _ => &words,
    };
    matches!(
        bare,
        "tow"
            | "itow"
            | "i tow"
            | "gps tow"
            | "sow"
            | "gps sow"
            | "gms"
            | "time of week"
            | "gps time of week"
            | "second of week"
            | "seconds of week"
            | "gps second"
            | "gps seconds"
            | "gps time"
            | "gpstime"
            | "gps ms"
            | "week seconds"
            | "secs of week"
    )
}

/// Nanoseconds of one count: of the unit that is stated, else of whole numbers too large for the
/// seconds of a week milliseconds, as receivers count them.
fn count_ns(column: &Column<'_>) -> Option<i64> {
    let words = words_of(&column.heading.name);
    let last = words.rsplit(' ').next().unwrap_or_default();
    let stated = column.heading.unit.as_deref().or(Some(last)).and_then(unit_named).filter(|unit| unit.si == "s");
    if let Some(unit) = stated {
        return Some((unit.to_si(1.0) * 1e9).round() as i64);
    }
    let is_ms = column.seen.sample.iter().all(|value| value.fract() == 0.0) && matches!(last, "gms" | "itow");
    let beyond = column.seen.sample.iter().any(|value| *value > 604_800.0);
    Some(if is_ms || beyond { 1_000_000 } else { SECOND_NS })
}

/// A column of whole seconds, and behind it one of the parts of a second: `sec`, `nanosec`.
pub(super) fn second_and_parts(columns: &[Column<'_>], at: usize) -> Option<InParts> {
    let (whole, part) = (&columns[at], columns.get(at + 1)?);
    let of_seconds = whole.heading.unit.as_deref().and_then(unit_named).is_none_or(|unit| unit.to_si(1.0) == 1.0);
    let is_whole = |column: &Column<'_>| {
        column.seen.kind == Kind::Number && column.seen.sample.iter().all(|value| value.fract() == 0.0 && *value >= 0.0)
    };
    if !of_seconds || !is_whole(whole) || !is_whole(part) {
        return None;
    }
    let name = without_common(&whole.heading.name, &part.heading.name);
    let form = match part_of_second(&name, part.heading.unit.as_deref()) {
        _ if divisor(part).is_some() => Form::Part(divisor(part)?),
        Some(ns) => Form::Count(ns),
        None if is_of_parts(&part.heading.name) => Form::Part(parts_of_second(&whole.seen.sample, &part.seen.sample)?),
        None => return None,
    };
    let within = |value: &f64| form.of_value(*value, 0.0).is_some_and(|of| of.day == 0 && of.within_ns <= SECOND_NS);
    let parts = vec![(at, Form::Count(SECOND_NS)), (at + 1, form)];
    part.seen.sample.iter().all(within).then(|| InParts::of(columns, parts, "the second and its parts"))
}

/// The words of a name without those with which the other begins, too: `nsec` of `sim_time_nsec`
/// beside `sim_time_sec`.
fn without_common(other: &str, name: &str) -> String {
    let (other, name) = (words_of(other), words_of(name));
    let alike = other.split(' ').zip(name.split(' ')).take_while(|(a, b)| a == b).count();
    let rest: Vec<&str> = name.split(' ').skip(alike).collect();
    if rest.is_empty() { name } else { rest.join(" ") }
}

/// Into how many parts a unit such as `1/65536 s` divides a second.
fn divisor(part: &Column<'_>) -> Option<i64> {
    let (one, of) = part.heading.unit.as_deref()?.split_once('/')?;
    let digits = of.trim().trim_end_matches(['s', 'S']).trim();
    (one.trim() == "1").then(|| digits.parse().ok()).flatten().filter(|of| *of > 1)
}

fn is_of_parts(name: &str) -> bool {
    let words = words_of(name);
    let last = words.rsplit(' ').next().unwrap_or_default();
    matches!(last, "subseconds" | "subsecond" | "subsecs" | "subsec" | "subs" | "fraction" | "frac" | "ticks")
        || words.ends_with("sub seconds")
}

/// How many parts a second has whose numbers begin again with every second: of the usual divisions
/// that which the largest step back over a full second, and the usual step, make up.
fn parts_of_second(seconds: &[f64], parts: &[f64]) -> Option<i64> {
    const DIVISIONS: [i64; 8] = [100, 1000, 1_000_000, 1_000_000_000, 1 << 8, 1 << 16, 1 << 24, 1 << 32];
    let pairs = || seconds.windows(2).zip(parts.windows(2)).map(|(s, p)| (s[1] - s[0], p[1] - p[0]));
    let mut within: Vec<f64> = pairs().filter(|(second, _)| *second == 0.0).map(|(_, part)| part).collect();
    within.sort_unstable_by(f64::total_cmp);
    let usual = *within.get(within.len() / 2).filter(|step| **step > 0.0)?;
    let mut carried: Vec<f64> =
        pairs().filter(|(second, part)| *second == 1.0 && *part < 0.0).map(|(_, part)| usual - part).collect();
    carried.sort_unstable_by(f64::total_cmp);
    let found = *carried.get(carried.len() / 2)?;
    let near = |of: &i64| (*of as f64 - found).abs();
    let best = DIVISIONS.into_iter().min_by(|a, b| near(a).total_cmp(&near(b)))?;
    (near(&best) <= 0.5 * usual).then_some(best)
}
