//! Texts that stand where numbers are due: numbers as texts, dates, words for what is missing.

use crate::intake::origin::rest_of_seconds;
use crate::text::stamps::Form;

/// Texts of a list that are kept as they are.
pub(crate) const NAMES_MAX: usize = 64;

/// What one text is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cell {
    Number(f64),
    /// \[ns since 1970\]
    Date(i64),
    Missing,
    Text,
}

/// What a text is; `form` is that of the dates before it. A date begins with its year: the order of
/// others is not known from one text.
pub(crate) fn cell(text: &str, form: &mut Option<Form>) -> Cell {
    let text = text.trim();
    if is_missing(text) {
        return Cell::Missing;
    }
    if let Ok(number) = text.parse::<f64>() {
        return if number.is_finite() { Cell::Number(number) } else { Cell::Missing };
    }
    if !text.bytes().take(4).all(|byte| byte.is_ascii_digit()) || text.len() < 16 {
        return Cell::Text;
    }
    let found = form.or_else(|| Form::of([text].into_iter()).filter(|form| matches!(form, Form::DateTime(_))));
    let ns = found.and_then(|form| form.read(text)).and_then(|stamp| i64::try_from(stamp.since_1970_ns()?).ok());
    *form = found;
    ns.map_or(Cell::Text, Cell::Date)
}

/// The number that a text is; NaN where it says that there is none.
pub(crate) fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    if is_missing(text) {
        return Some(f64::NAN);
    }
    text.parse().ok().map(|number: f64| if number.is_finite() { number } else { f64::NAN })
}

/// Whether a text says that there is no value.
fn is_missing(text: &str) -> bool {
    matches!(text.to_ascii_lowercase().as_str(), "" | "nan" | "null" | "none" | "na" | "n/a" | "-")
}

/// A date as seconds since 1970, and what their `f64` does not hold.
pub(crate) fn seconds_of(ns: i128) -> (f64, f64) {
    const A_SECOND: i128 = 1_000_000_000;
    // whole seconds and the rest are exact: their sum is rounded once
    let seconds = ns.div_euclid(A_SECOND) as f64 + ns.rem_euclid(A_SECOND) as f64 / A_SECOND as f64;
    (seconds, rest_of_seconds(seconds, ns, A_SECOND))
}

/// A column of texts, one after another.
#[derive(Debug, Default)]
pub(crate) struct Texts {
    /// The first texts.
    pub first: Vec<String>,
    count: usize,
    values: Vec<f64>,
    rest: Vec<f64>,
    form: Option<Form>,
    numbers: usize,
    dates: usize,
    others: usize,
}

/// What a column of texts is.
#[derive(Debug, PartialEq)]
pub(crate) enum Found {
    Numbers(Vec<f64>),
    /// Seconds since 1970, and what their `f64` does not hold.
    Dates(Vec<f64>, Vec<f64>),
    Text,
}

impl Texts {
    /// Adds a text.
    pub fn push(&mut self, text: &str) {
        self.count += 1;
        if self.first.len() < NAMES_MAX {
            self.first.push(text.into());
        }
        if self.others > 0 {
            return;
        }
        let (value, rest) = match cell(text, &mut self.form) {
            Cell::Number(number) => {
                self.numbers += 1;
                (number, 0.0)
            }
            Cell::Date(ns) => {
                self.dates += 1;
                seconds_of(ns.into())
            }
            Cell::Missing => (f64::NAN, 0.0),
            Cell::Text => {
                self.others += 1;
                (self.values, self.rest) = (Vec::new(), Vec::new());
                return;
            }
        };
        self.values.push(value);
        self.rest.push(rest);
    }

    /// Texts so far.
    pub fn count(&self) -> usize {
        self.count
    }

    /// What all texts are.
    pub fn finish(self) -> Found {
        match (self.numbers, self.dates, self.others) {
            (1.., 0, 0) => Found::Numbers(self.values),
            (0, 1.., 0) => Found::Dates(self.values, self.rest),
            _ => Found::Text,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(texts: &[&str]) -> Found {
        let mut found = Texts::default();
        texts.iter().for_each(|text| found.push(text));
        found.finish()
    }

    #[test]
    fn numbers_and_dates_are_read_where_all_texts_are_such() {
        assert_eq!(all(&["1.5", "-2e3"]), Found::Numbers(vec![1.5, -2000.0]));
        let Found::Numbers(values) = all(&["1", "NaN", "", "inf"]) else { panic!("no numbers") };
        assert!(values[1..].iter().all(|value| value.is_nan()));
        let Found::Dates(seconds, _) = all(&["2024-03-05T15:00:00Z", "2024-03-05 15:00:00.25"]) else {
            panic!("no dates")
        };
        assert_eq!(seconds, [1_709_650_800.0, 1_709_650_800.25]);
        for texts in [&["1", "on"][..], &["", "nan"], &["1", "2024-03-05T15:00:00Z"], &["05/03/2024 15:00:00"]] {
            assert_eq!(all(texts), Found::Text, "{texts:?}");
        }
    }
}
