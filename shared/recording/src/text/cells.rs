//! Cells of a row as numbers in SI.

use super::dialect::{COLUMNS, Dialect, is_missing};
use super::encoding::text_of;
use super::number::{Marked, marked, number};
use super::printable;
use super::quantity::{number_in, quantity};
use super::signs::Signs;
use super::stamps::{self, Stamp};
use crate::error::{Place, RecordingError};
use crate::intake::clock::EPOCH_S;
use crate::intake::origin::{Origin, split_text};
use crate::intake::plan::{Clock, Plan};
use crate::rows::Axis;

/// Reads the cells of lines as a plan says.
pub(crate) struct Cells<'a> {
    file: &'a str,
    dialect: Dialect,
    plan: &'a Plan,
    /// Cells of a row.
    width: usize,
    header: &'a [String],
    record: ::csv::ByteRecord,
    /// Rows read so far, for a clock that counts them.
    rows: u64,
    /// Of a clock of numbers, from the first row on.
    origin: Option<Origin>,
    /// First day of a clock of stamps, and days that a time of day has passed midnight.
    day: Option<i64>,
    midnights: i64,
    last_ns: i64,
    /// Sum of the steps so far, for a clock that has them.
    elapsed_s: f64,
    /// What the cells of each channel were that are not plain numbers.
    pub counts: Vec<Counts>,
}

/// The cells of a channel by what they were.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    pub numbers: u64,
    /// Cells that say `inf`: no sample either.
    pub infinite: u64,
    /// Cells that are no number and no word for none.
    pub texts: u64,
    /// The first of them, as an error.
    pub first_text: Option<RecordingError>,
    /// Numbers with a mark or a remark, and the first of these cells with its line.
    pub marked: u64,
    pub first_marked: Option<(u64, String)>,
    /// Negative numbers in parentheses.
    pub in_parentheses: u64,
    has_minus: bool,
}

impl Counts {
    /// Most cells are numbers: the others are samples that are missing.
    pub fn is_of_numbers(&self) -> bool {
        self.texts == 0 || self.numbers > self.texts
    }

    /// The first text, and its place.
    pub fn text(&self) -> Option<(Box<Place>, String)> {
        match &self.first_text {
            Some(RecordingError::NotANumber { place, value }) => Some((place.clone(), value.clone())),
            _ => None,
        }
    }
}

impl<'a> Cells<'a> {
    pub fn new(file: &'a str, dialect: Dialect, plan: &'a Plan, width: usize, header: &'a [String]) -> Self {
        let counts = plan.columns.iter().map(|_| Counts::default()).collect();
        let record = ::csv::ByteRecord::new();
        Cells {
            file,
            dialect,
            plan,
            width,
            header,
            record,
            rows: 0,
            origin: None,
            day: None,
            midnights: 0,
            last_ns: i64::MIN,
            elapsed_s: 0.0,
            counts,
        }
    }

    /// The row on `line`, time first; `false` for a line without a value: separators alone, or the
    /// header once more.
    pub fn read(&mut self, text: &[u8], line: u64, row: &mut Vec<f64>) -> Result<bool, RecordingError> {
        self.split(text);
        let empty = self.record.iter().all(<[u8]>::is_empty);
        if empty || self.is_header() {
            return Ok(false);
        }
        let beyond = self.record.iter().skip(self.width).any(|cell| !cell.is_empty());
        if beyond || self.record.len() < self.width {
            return Err(self.ragged(line));
        }
        row.clear();
        let time = self.time(line)?;
        row.push(time);
        for k in 0..self.plan.columns.len() {
            row.push(self.value(k, line)?);
        }
        self.rows += 1;
        Ok(true)
    }

    /// Whether the line that was read last may be a row that a stopped program cut.
    pub fn is_short(&self) -> bool {
        self.record.len() < self.width
    }

    /// Whether the line that was read last has no time: it is no row, but a remark between the rows
    /// or behind them.
    pub fn is_without_time(&self) -> bool {
        let at = match &self.plan.clock {
            Clock::Number { at, .. } | Clock::Steps { at, .. } => *at,
            Clock::Stamps(parts) => parts[0].0,
            Clock::Rows { .. } => 0,
        };
        let lead = self.record.get(at).map(text_of).unwrap_or_default();
        let is_time = match &self.plan.clock {
            Clock::Stamps(parts) => parts[0].1.read(&lead).is_some(),
            Clock::Number { .. } | Clock::Steps { .. } => number(&lead, self.dialect.signs).is_some(),
            Clock::Rows { .. } => number(&lead, self.dialect.signs).is_some() || is_missing(&lead),
        };
        !is_time
    }

    /// Whether the line that was read last has two texts or more and no number: names once more.
    pub fn is_of_names(&self) -> bool {
        let is_number = |cell: &&[u8]| number(&text_of(cell), self.dialect.signs).is_some();
        let given = || self.record.iter().filter(|cell| !cell.is_empty());
        given().count() > 1 && !given().any(|cell| is_number(&cell))
    }

    /// A cell of the line that was read last; empty where the line is shorter.
    pub fn text_at(&self, at: usize) -> String {
        self.record.get(at).map(text_of).unwrap_or_default()
    }

    fn split(&mut self, text: &[u8]) {
        self.record.clear();
        // a tab at the beginning is the end of an empty cell, not a blank
        if text.contains(&b'"') {
            self.dialect.split_quoted(&text_of(text)).iter().for_each(|cell| self.record.push_field(cell.as_bytes()));
        } else if self.dialect.labelled
            || self.dialect.separator == COLUMNS
            || text.first() == Some(&b'[')
            || begins_with_arrow(text)
        {
            self.dialect.split(&text_of(text)).iter().for_each(|cell| self.record.push_field(cell.as_bytes()));
        } else if self.dialect.separator == b' ' {
            let cells = text.split(|byte| byte.is_ascii_whitespace()).filter(|cell| !cell.is_empty());
            cells.for_each(|cell| self.record.push_field(cell));
        } else {
            text.split(|byte| *byte == self.dialect.separator)
                .for_each(|cell| self.record.push_field(cell.trim_ascii()));
        }
    }

    fn is_header(&self) -> bool {
        !self.header.is_empty()
            && self.record.len() == self.header.len()
            && self.record.iter().zip(self.header).all(|(cell, header)| cell == header.as_bytes())
    }

    fn ragged(&self, line: u64) -> RecordingError {
        let cells: Vec<_> = self.record.iter().map(text_of).collect();
        let separator = char::from(self.dialect.separator).to_string();
        RecordingError::Ragged {
            file: self.file.into(),
            line,
            found: self.record.len(),
            expected: self.width,
            row: printable(&cells.join(&separator)),
        }
    }

    fn place(&self, line: u64, at: usize, header: &str) -> Box<Place> {
        Box::new(Place { file: self.file.into(), line, column: at + 1, name: printable(header) })
    }

    fn not_a_number(&self, line: u64, at: usize, header: &str, cell: &[u8]) -> RecordingError {
        RecordingError::NotANumber { place: self.place(line, at, header), value: printable(&text_of(cell)) }
    }

    fn time(&mut self, line: u64) -> Result<f64, RecordingError> {
        match &self.plan.clock {
            Clock::Rows { interval_s } => Ok(self.rows as f64 * interval_s),
            Clock::Number { at, unit } => {
                let cell = &self.record[*at];
                let text = core::str::from_utf8(cell).ok();
                let value = text.and_then(|text| number_in(*unit, text, self.dialect.signs));
                let value = value.ok_or_else(|| self.not_a_number(line, *at, &self.plan.clock_header, cell))?;
                let origin = *self.origin.get_or_insert_with(|| Origin::of(*unit, value));
                // a decimal comma is a point by then, or there is none
                let exact = text.filter(|_| origin.second != 0).and_then(|text| split_text(&text.replace(',', ".")));
                let (stamp, rest) = exact.unwrap_or((value, 0.0));
                self.finite(origin.time_s(stamp, rest), line, *at, &self.plan.clock_header)
            }
            Clock::Steps { at, unit } => {
                let cell = text_of(&self.record[*at]);
                let step = number_in(*unit, &cell, self.dialect.signs);
                // there is nothing before the first row
                let step = step.or_else(|| (self.rows == 0 && is_missing(&cell)).then_some(0.0));
                let missing = || self.not_a_number(line, *at, &self.plan.clock_header, &self.record[*at]);
                let step_s = unit.to_si(step.ok_or_else(missing)?);
                self.elapsed_s += if self.rows == 0 { 0.0 } else { step_s };
                self.finite(self.elapsed_s, line, *at, &self.plan.clock_header)
            }
            Clock::Stamps(parts) => {
                let mut stamps = Vec::with_capacity(parts.len());
                for (at, form) in parts {
                    let cell = &self.record[*at];
                    let stamp = form.read(&text_of(cell));
                    let header = self.header.get(*at).map_or(self.plan.clock_header.as_str(), String::as_str);
                    stamps.push((*form, stamp.ok_or_else(|| self.not_a_number(line, *at, header, cell))?));
                }
                Ok(self.since_first_day(stamps::sum(stamps.into_iter())))
            }
        }
    }

    fn since_first_day(&mut self, Stamp { day, within_ns }: Stamp) -> f64 {
        const HALF_A_DAY_NS: i64 = 43_200_000_000_000;
        // a clock without a date that goes back by most of a day has passed midnight
        let is_back = self.last_ns.saturating_sub(within_ns) > HALF_A_DAY_NS && self.last_ns != i64::MIN;
        self.midnights += i64::from(is_back && self.plan.clock.is_of_a_day());
        self.last_ns = within_ns;
        let stamp = Stamp { day: day + self.midnights + self.plan.day, within_ns };
        stamp.since_s(*self.day.get_or_insert(stamp.day))
    }

    /// What the times count from [s since 1970]; 0: from where the file says.
    pub fn origin_s(&self) -> i64 {
        self.dated().map(|day| day * 86_400).or(self.origin.map(|origin| origin.second)).unwrap_or(0)
    }

    /// The day that the times of a clock of dates count from.
    pub fn first_day(&self) -> Option<String> {
        self.dated().map(|day| Stamp { day, within_ns: 0 }.day_text())
    }

    /// The first day, where it is one of a date: stated, or of seconds that count from 1970.
    fn dated(&self) -> Option<i64> {
        let is_date = |day: &i64| self.plan.clock.has_day() || EPOCH_S.contains(&(*day as f64 * 86_400.0));
        self.day.filter(is_date)
    }

    /// NaN where the cell of a time record says that no sample was taken.
    fn value(&mut self, k: usize, line: u64) -> Result<f64, RecordingError> {
        let column = &self.plan.columns[k];
        let cell = &self.record[column.at];
        let time = self.plan.axis == Axis::Time;
        if cell.is_empty() && time {
            return Ok(f64::NAN);
        }
        let text = core::str::from_utf8(cell).ok();
        match text.and_then(|text| number_in(column.unit, text, self.dialect.signs)) {
            Some(value) => {
                self.counts[k].numbers += 1;
                self.counts[k].has_minus |= value < 0.0;
                self.finite(column.unit.to_si(value) * column.scale, line, column.at, &column.header)
            }
            None if time && is_missing(&text_of(cell)) => {
                self.counts[k].infinite += u64::from(cell.iter().any(|byte| byte.eq_ignore_ascii_case(&b'f')));
                Ok(f64::NAN)
            }
            None if time => self.without_plain_number(k, line),
            None => Err(self.not_a_number(line, column.at, &column.header, cell)),
        }
    }

    /// A cell that is no number as it stands: a number with a mark, or a sample that is missing.
    fn without_plain_number(&mut self, k: usize, line: u64) -> Result<f64, RecordingError> {
        let column = &self.plan.columns[k];
        let cell = &self.record[column.at];
        let text = text_of(cell);
        let error = self.not_a_number(line, column.at, &column.header, cell);
        if self.has_two_readings(&text) {
            return Err(error);
        }
        let counts = &mut self.counts[k];
        let value = match marked(&text, self.dialect.signs) {
            Some(Marked::Number(value)) => {
                counts.marked += 1;
                counts.first_marked.get_or_insert((line, printable(&text)));
                value
            }
            Some(Marked::InParentheses(value)) if !counts.has_minus => {
                counts.in_parentheses += 1;
                value
            }
            _ => {
                counts.texts += 1;
                counts.first_text.get_or_insert(error);
                return Ok(f64::NAN);
            }
        };
        counts.numbers += 1;
        self.finite(column.unit.to_si(value) * column.scale, line, column.at, &column.header)
    }

    /// Whether a cell is a number under other signs, or one in a unit of another dimension.
    fn has_two_readings(&self, text: &str) -> bool {
        let either = [false, true].map(|comma| Signs { decimal_comma: comma, grouped: false });
        let grouped = either.map(|signs| Signs { grouped: true, ..signs });
        let mut others = either.into_iter().chain(grouped);
        others.any(|signs| number(text, signs).is_some()) || quantity(text, self.dialect.signs).is_some()
    }

    fn finite(&self, value: f64, line: u64, at: usize, header: &str) -> Result<f64, RecordingError> {
        if value.is_finite() {
            return Ok(value);
        }
        let cell = self.record.get(at).map(text_of).unwrap_or_default();
        Err(RecordingError::NotFinite { place: self.place(line, at, header), value: printable(&cell) })
    }
}

/// Whether an arrow may stand behind a stamp at the beginning of a line.
fn begins_with_arrow(text: &[u8]) -> bool {
    const STAMP_MAX: usize = 40;
    text.windows(4).take(STAMP_MAX).any(|four| four == b" -> ")
}
