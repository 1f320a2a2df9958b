//! The parts of a date and time in a text, from its beginning to its end.

use super::words::Word;
use super::{Clock, DAY_NS, Order, Stamp, of_ns};
use jiff::civil::Date;

/// What has been read of a text.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reading {
    date: Option<Date>,
    /// Month by name, and numbers beside it with the count of their digits.
    month: Option<u8>,
    beside: [Option<(i64, usize)>; 2],
    /// Days since the beginning.
    days: Option<i64>,
    /// Nanoseconds of the day.
    pub time: Option<i64>,
    pub clock: Option<Clock>,
    afternoon: Option<bool>,
    /// Seconds ahead of UTC.
    zone_s: Option<i64>,
    /// Digits behind a colon behind the seconds.
    pub colon_digits: Option<usize>,
}

impl Reading {
    /// The parts of `text`; `None` where anything in it is no part of a date and time.
    pub fn of(text: &str, order: Order) -> Option<Self> {
        let mut reading = Reading::default();
        let mut rest = text;
        while let Some(first) = rest.chars().next() {
            rest = match first {
                '0'..='9' => reading.number(rest, order)?,
                ' ' | ',' | '_' | '@' => &rest[1..],
                '+' | '-' if reading.time.is_some() && reading.clock != Some(Clock::Minutes) => reading.offset(rest)?,
                '-' | '/' | '.' if reading.time.is_none() && (reading.month.is_some() || reading.has_beside()) => {
                    &rest[1..]
                }
                ':' | '-' | '/' | '.' if reading.time.is_none() && reading.date.is_some() => &rest[1..],
                '[' | '(' if reading.zone_s.is_some() => &rest[rest.find([']', ')'])? + 1..],
                _ if first.is_alphabetic() => reading.word(rest)?,
                _ => return None,
            };
        }
        reading.finished()
    }

    fn has_beside(&self) -> bool {
        self.beside[0].is_some()
    }

    /// A number, and what it is the beginning of.
    fn number<'t>(&mut self, rest: &'t str, order: Order) -> Option<&'t str> {
        let digits = digits(rest);
        let next = rest[digits..].chars().next();
        let has_date = self.date.is_some() || self.month.is_some();
        if self.time.is_none() && next == Some(':') && digits <= 3 {
            return self.time_of_day(rest);
        }
        if self.time.is_none() && digits == 6 && has_date {
            return self.compact_time(rest);
        }
        if self.time.is_none()
            && self.date.is_some()
            && let Some(after) = self.divided_time(rest)
        {
            return Some(after);
        }
        let may_be_date = !has_date && self.time.is_none() && !self.has_beside();
        if let Some((date, after)) = may_be_date.then(|| date(rest, order)).flatten() {
            self.date = Some(date);
            return Some(after);
        }
        let free = self.beside.iter_mut().find(|beside| beside.is_none()).filter(|_| digits <= 4)?;
        *free = Some((rest[..digits].parse().ok()?, digits));
        Some(&rest[digits..])
    }

    /// `14:59`, `14:59:58`, with decimals, or with `:250` for milliseconds; `59:58.250`.
    fn time_of_day<'t>(&mut self, rest: &'t str) -> Option<&'t str> {
        let (first, after) = number(rest, 1..=3)?;
        let (second, after) = number(after.strip_prefix(':')?, 2..=2)?;
        let third = after.strip_prefix(':').and_then(|third| number(third, 2..=2));
        let (hours, minutes, seconds, after, clock) = match third {
            Some((third, after)) => (first, second, third, after, Clock::Hours),
            None if after.starts_with(['.', ',']) && self.date.is_none() && self.days.is_none() => {
                (0, first, second, after, Clock::Minutes)
            }
            None => (first, second, 0, after, Clock::Hours),
        };
        let behind_colon = after.strip_prefix(':').map(self::digits);
        let (fraction_ns, after) = fraction(after)?;
        if minutes > 59 || seconds > 60 {
            return None;
        }
        self.colon_digits = behind_colon;
        self.time = Some(((hours * 60 + minutes) * 60 + seconds) * 1_000_000_000 + fraction_ns);
        self.clock = Some(clock);
        Some(after)
    }

    /// `05.06.07.250` or `05-06-07` behind a date.
    fn divided_time<'t>(&mut self, rest: &'t str) -> Option<&'t str> {
        let sign = rest[digits(rest)..].chars().next().filter(|sign| matches!(sign, '.' | '-' | '_'))?;
        let (hours, after) = number(rest, 2..=2)?;
        let (minutes, after) = number(after.strip_prefix(sign)?, 2..=2)?;
        let (seconds, after) = number(after.strip_prefix(sign)?, 2..=2)?;
        let (fraction_ns, after) = fraction(after)?;
        if hours > 23 || minutes > 59 || seconds > 60 {
            return None;
        }
        self.time = Some(((hours * 60 + minutes) * 60 + seconds) * 1_000_000_000 + fraction_ns);
        self.clock = Some(Clock::Hours);
        Some(after)
    }

    /// `145958.250` behind a date.
    fn compact_time<'t>(&mut self, rest: &'t str) -> Option<&'t str> {
        let value: i64 = rest[..6].parse().ok()?;
        let (hours, minutes, seconds) = (value / 10_000, value / 100 % 100, value % 100);
        let (fraction_ns, after) = fraction(&rest[6..])?;
        if hours > 23 || minutes > 59 || seconds > 60 {
            return None;
        }
        self.time = Some(((hours * 60 + minutes) * 60 + seconds) * 1_000_000_000 + fraction_ns);
        self.clock = Some(Clock::Hours);
        Some(after)
    }

    /// `+01:00`, `-0530`, `+1`, also behind a zone's name.
    fn offset<'t>(&mut self, rest: &'t str) -> Option<&'t str> {
        let sign = if rest.starts_with('-') { -1 } else { 1 };
        let rest = &rest[1..];
        let length = digits(rest);
        let (value, after) = number(rest, 1..=4)?;
        let (hours, minutes, after) = match after.strip_prefix(':').filter(|_| length <= 2) {
            Some(after) => {
                let (minutes, after) = number(after, 2..=2)?;
                (value, minutes, after)
            }
            None if length <= 2 => (value, 0, after),
            None => (value / 100, value % 100, after),
        };
        let already = self.zone_s.unwrap_or(0);
        (hours <= 15 && minutes <= 59 && already == 0).then_some(())?;
        self.zone_s = Some(sign * (hours * 60 + minutes) * 60);
        Some(after)
    }

    fn word<'t>(&mut self, rest: &'t str) -> Option<&'t str> {
        let half = ["a.m.", "p.m.", "A.M.", "P.M."].into_iter().find(|half| rest.starts_with(half));
        let end = rest.find(|c: char| !c.is_alphabetic()).unwrap_or(rest.len());
        let (word, after) = match half {
            Some(half) => (Word::Afternoon(half.starts_with(['p', 'P'])), &rest[half.len()..]),
            None => (Word::of(&rest[..end])?, &rest[end..]),
        };
        match word {
            Word::Month(month) if self.month.is_none() && self.date.is_none() => {
                self.month = Some(month);
                return Some(after.strip_prefix('.').unwrap_or(after));
            }
            Word::Weekday => {}
            // before the time in Korea, China and Japan
            Word::Afternoon(is) if matches!(self.clock, None | Some(Clock::Hours)) => self.afternoon = Some(is),
            Word::Zone(seconds) if self.time.is_some() && self.zone_s.is_none() => self.zone_s = Some(seconds),
            Word::Time if self.date.is_some() && self.time.is_none() => {}
            Word::Days if self.month.is_none() && self.days.is_none() => {
                self.days = Some(self.beside[0].take()?.0);
            }
            _ => return None,
        }
        Some(after)
    }

    /// With the date of a named month, and the half of the day.
    fn finished(mut self) -> Option<Self> {
        if let Some(month) = self.month {
            let (first, second) = (self.beside[0].take()?, self.beside[1].take()?);
            let (year, day) = if first.1 == 4 { (first, second) } else { (second, first) };
            (day.1 <= 2 && matches!(year.1, 2 | 4)).then_some(())?;
            self.date = Some(date_of(full_year(year), month.into(), day.0)?);
        }
        if let (Some(afternoon), Some(time)) = (self.afternoon, self.time) {
            let hour = time / HOUR_NS;
            (1..=12).contains(&hour).then_some(())?;
            self.time = Some(time - hour * HOUR_NS + (hour % 12 + if afternoon { 12 } else { 0 }) * HOUR_NS);
            self.clock = Some(Clock::Halves);
        }
        let of_a_day = self.time.is_none_or(|time| time <= DAY_NS + 1_000_000_000);
        let whole = !self.has_beside() && (of_a_day || (self.date.is_none() && self.zone_s.is_none()));
        (whole && (self.date.is_some() || self.time.is_some())).then_some(self)
    }

    /// Days and a time since the beginning, of a text that has both.
    pub fn since_beginning(self) -> Option<Stamp> {
        let stamp = Reading { days: None, ..self }.stamp(false)?;
        Some(Stamp { day: stamp.day + self.days?, ..stamp })
    }

    /// The stamp, of a text that has a date or has none.
    pub fn stamp(self, dated: bool) -> Option<Stamp> {
        if self.date.is_some() != dated || self.days.is_some() {
            return None;
        }
        let day = self.date.map_or(0, day_number);
        let within_ns = self.time.unwrap_or(0) - self.zone_s.filter(|_| dated).unwrap_or(0) * 1_000_000_000;
        if dated {
            of_ns(i128::from(day) * i128::from(DAY_NS) + i128::from(within_ns))
        } else {
            Some(Stamp { day, within_ns })
        }
    }
}

const HOUR_NS: i64 = 3_600_000_000_000;

/// `20240305145958`, and three, six or nine digits of decimals, or decimals behind a point.
pub(super) fn of_digits(cell: &str) -> Option<Reading> {
    let length = digits(cell);
    let decimals = cell.get(14..).filter(|_| matches!(length, 14 | 17 | 20 | 23))?;
    let decimals = if length > 14 { decimals } else { decimals.strip_prefix('.').unwrap_or(decimals) };
    if !decimals.bytes().all(|byte| byte.is_ascii_digit()) || !cell.starts_with(['1', '2']) {
        return None;
    }
    Reading::of(&format!("{} {}.{decimals}0", &cell[..8], &cell[8..14]), Order::Stated)
}

/// `20240305`, or six digits whose order the date does not say.
pub(super) fn date_of_digits(cell: &str, order: Order) -> Option<Stamp> {
    let value: i64 = cell.parse().ok().filter(|_| digits(cell) == cell.len())?;
    let (first, second, third) = (value / 10_000, value / 100 % 100, value % 100);
    let (year, month, day) = match (cell.len(), order) {
        (8, Order::Stated) => (first, second, third),
        (5 | 6, Order::Day) => (full_year((third, 2)), second, first),
        (5 | 6, Order::Month) => (full_year((third, 2)), first, second),
        (5 | 6, Order::Year) => (full_year((first, 2)), second, third),
        _ => return None,
    };
    Some(Stamp { day: day_number(date_of(year, month, day)?), within_ns: 0 })
}

/// A date of numbers at the beginning of a text, and what follows it.
fn date(rest: &str, order: Order) -> Option<(Date, &str)> {
    let length = digits(rest);
    if length == 8 {
        let value: i64 = rest[..8].parse().ok()?;
        return Some((date_of(value / 10_000, value / 100 % 100, value % 100)?, &rest[8..]));
    }
    let (first, after) = number(rest, 1..=4)?;
    let separator = after.chars().next().filter(|c| matches!(c, '-' | '/' | '.') || (*c == ':' && length == 4))?;
    let second_length = digits(&after[1..]);
    let (second, after) = number(&after[1..], 1..=3)?;
    if length == 4 && second_length == 3 {
        let start = date_of(first, 1, 1)?;
        let date = start.checked_add(jiff::Span::new().days(second - 1)).ok()?;
        return (second > 0 && date.year() == start.year()).then_some((date, after));
    }
    let after = after.strip_prefix(separator)?;
    let third_length = digits(after);
    let (third, after) = number(after, 1..=4)?;
    let lengths = (length, second_length, third_length);
    let (year, month, day) = match (lengths, order) {
        ((4, 1 | 2, 1 | 2), Order::Stated) => (first, second, third),
        ((1 | 2, 1 | 2, 4), Order::Day) => (third, second, first),
        ((1 | 2, 1 | 2, 4), Order::Month) => (third, first, second),
        ((1 | 2, 1 | 2, 2), Order::Day) if separator == '/' => (full_year((third, 2)), second, first),
        ((1 | 2, 1 | 2, 2), Order::Month) if separator == '/' => (full_year((third, 2)), first, second),
        ((2, 2, 2), Order::Day) => (full_year((third, 2)), second, first),
        ((2, 2, 2), Order::Month) => (full_year((third, 2)), first, second),
        ((2, 2, 2), Order::Year) => (full_year((first, 2)), second, third),
        _ => return None,
    };
    Some((date_of(year, month, day)?, after))
}

/// A year of two digits is one from 1970 to 2069.
fn full_year((year, length): (i64, usize)) -> i64 {
    match year {
        _ if length > 2 => year,
        0..70 => 2000 + year,
        _ => 1900 + year,
    }
}

fn date_of(year: i64, month: i64, day: i64) -> Option<Date> {
    Date::new(
        i16::try_from(year).ok().filter(|year| *year >= 1000)?,
        i8::try_from(month).ok()?,
        i8::try_from(day).ok()?,
    )
    .ok()
}

pub(super) fn day_number(date: Date) -> i64 {
    let epoch = jiff::civil::date(1970, 1, 1);
    epoch.until(date).map_or(0, |span| i64::from(span.get_days()))
}

/// Digits at the beginning of a text.
fn digits(text: &str) -> usize {
    text.bytes().take_while(u8::is_ascii_digit).count()
}

/// A number with so many digits, and what follows it.
fn number(text: &str, lengths: core::ops::RangeInclusive<usize>) -> Option<(i64, &str)> {
    let length = Some(digits(text)).filter(|length| lengths.contains(length))?;
    Some((text[..length].parse().ok()?, &text[length..]))
}

/// Decimals of a second [ns]: behind a point or a comma, or three, six or nine behind a colon; one
/// or two digits there are whole milliseconds.
fn fraction(text: &str) -> Option<(i64, &str)> {
    let Some(rest) = text.strip_prefix(['.', ',', ':']) else { return Some((0, text)) };
    let length = digits(rest);
    if length == 0 {
        // `14:59:58, 5 March 2024`
        return Some((0, text)).filter(|_| text.starts_with(','));
    }
    if text.starts_with(':') && length < 3 {
        return Some((rest[..length].parse::<i64>().ok()? * 1_000_000, &rest[length..]));
    }
    if text.starts_with(':') && !matches!(length, 3 | 6 | 9) {
        return None;
    }
    let ns = rest[..length].bytes().chain(core::iter::repeat(b'0')).take(9);
    Some((ns.fold(0, |ns, digit| 10 * ns + i64::from(digit - b'0')), &rest[length..]))
}
