//! The date above rows whose clock has the time of day alone: `Date: 2024-03-05`,
//! `Start time;5.3.2024 14:59:58`.

use super::header::unmarked;
use crate::intake::stamps::{Form, Order};

/// Words of keys whose value is when the recording was made, and of those whose value is another
/// date.
const MADE: [&str; 9] = ["date", "datum", "fecha", "data", "start", "begin", "trigger", "acqui", "record"];
const ANOTHER: [&str; 9] = ["export", "creat", "print", "build", "version", "firmware", "calib", "stop", "modif"];
/// Longest key [bytes]: more is a sentence.
const KEY_MAX: usize = 40;

/// The day since 1970-01-01 that the lines above the rows state; `None` where they state none, two,
/// or one whose order of day and month is open.
pub(crate) fn stated_date(above: &[(u64, String)]) -> Option<i64> {
    let mut days = above.iter().filter_map(|(_, text)| day_of(unmarked(text)));
    let first = days.next()?;
    days.all(|day| day == first).then_some(first)
}

/// The day of a line with a key and a date.
fn day_of(text: &str) -> Option<i64> {
    let at = text.find(|c: char| c.is_ascii_digit()).filter(|at| *at > 0)?;
    let (key, value) = text.split_at(at);
    let key = key.to_lowercase();
    let has = |words: &[&str]| words.iter().any(|word| key.contains(word));
    if key.len() > KEY_MAX || !has(&MADE) || has(&ANOTHER) {
        return None;
    }
    let ends = |c: char| matches!(c, ',' | ';' | '\t' | '"' | '|');
    let cell = value.split(ends).next().unwrap_or_default().trim();
    let word = cell.split_whitespace().next().unwrap_or_default();
    [cell, word].into_iter().find_map(day)
}

/// The day of a date or of a date and time which can be read in one way alone.
fn day(cell: &str) -> Option<i64> {
    let read = |order| [Form::Date(order), Form::DateTime(order)].into_iter().find_map(|form| form.read(cell));
    if let Some(stamp) = read(Order::Stated) {
        return Some(stamp.day);
    }
    match [Order::Day, Order::Month].map(read) {
        [Some(one), None] | [None, Some(one)] => Some(one.day),
        [Some(one), Some(other)] if one.day == other.day => Some(one.day),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stated(lines: &[&str]) -> Option<String> {
        let above: Vec<(u64, String)> = lines.iter().map(|line| (1, (*line).to_owned())).collect();
        stated_date(&above).map(|day| crate::intake::stamps::Stamp { day, within_ns: 0 }.day_text())
    }

    #[test]
    fn a_date_that_can_be_read_in_one_way_is_taken_in_every_spelling() {
        for line in [
            "Date: 2024-03-25",
            "# Date,25/03/2024",
            "\"Date\";\"25.03.2024\"",
            "Datum; 25.03.2024",
            "Start time\t3/25/2024 14:59:58",
            "Recording start: 2024-03-25T14:59:58",
            "Acquisition Date: 25 Mar 2024",
            "Trigger date,2024/03/25,14:59:58",
        ] {
            assert_eq!(stated(&[line]).as_deref(), Some("2024-03-25"), "{line}");
        }
    }

    #[test]
    fn a_date_of_two_readings_two_dates_and_dates_of_something_else_are_not_taken() {
        assert_eq!(stated(&["Date: 03/05/2024"]), None);
        assert_eq!(stated(&["Date: 2024-03-25", "Start: 2024-03-26"]), None);
        assert_eq!(stated(&["Exported: 2024-03-25", "Build date 2020-01-01", "Serial 20240325"]), None);
        assert_eq!(stated(&["time,date", "Date of calibration: 2024-03-25"]), None);
    }
}
