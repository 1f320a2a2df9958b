//! What the attributes of an array state of its numbers: unit, scale, offset, missing and valid
//! values, by the conventions of netCDF (CF), and factors of other programs where numbers are
//! whole.
//!
//! What is applied is noted, and so is what is not.

use crate::numbers::Number;
use crate::since::Since;

/// An attribute's value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Stated {
    Numbers(Vec<f64>),
    Text(String),
}

impl Stated {
    fn number(&self) -> Option<f64> {
        match self {
            Stated::Numbers(numbers) => numbers.first().copied().filter(|_| numbers.len() == 1),
            Stated::Text(text) => text.trim().parse().ok(),
        }
    }

    fn numbers(&self) -> Vec<f64> {
        match self {
            Stated::Numbers(numbers) => numbers.clone(),
            Stated::Text(text) => text.split([',', ' ']).filter_map(|part| part.trim().parse().ok()).collect(),
        }
    }
}

/// Names of a factor beside that of CF, without `_`: used by many programs for raw counts, and for
/// amplifiers.
const FACTORS: &[&str] = &[
    "scale",
    "scaling",
    "gain",
    "slope",
    "factor",
    "multiplier",
    "resolution",
    "lsb",
    "conversion",
    "conversionfactor",
    "scalingfactor",
    "calibrationfactor",
];
/// Names of a sum beside that of CF.
const OFFSETS: &[&str] = &["offset", "intercept"];
/// What netCDF writes where nobody has written a number in single or double precision.
const UNWRITTEN: f32 = 9.969_21e36;
/// Names of a unit.
const UNITS: &[&str] = &["units", "unit", "unitstring", "unitsymbol", "niunitdescription"];

/// Whether an attribute or a text with this name states a unit.
pub(crate) fn is_unit(name: &str) -> bool {
    UNITS.contains(&plain(name).as_str())
}

fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// A number that an attribute states, and its name.
type Named = (String, f64);

/// What the attributes of one array state.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Conventions {
    pub unit: Option<String>,
    /// By the convention.
    scale: Option<Named>,
    offset: Option<Named>,
    /// By name alone.
    factors: Vec<Named>,
    sums: Vec<Named>,
    missing: Vec<f64>,
    least: Option<f64>,
    most: Option<f64>,
    /// Days are not those of the calendar of everyday.
    other_calendar: Option<String>,
    /// Whole numbers are without sign, whatever their type.
    unsigned: bool,
}

/// How the numbers are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Storage {
    /// So many bytes.
    Whole(usize),
    Single,
    Double,
}

/// What became of an array.
#[derive(Debug, Default)]
pub(crate) struct Applied {
    pub unit: Option<String>,
    /// The values are seconds since 1970 now.
    pub is_date: bool,
    pub notes: Vec<String>,
}

impl Conventions {
    /// What `attributes` state.
    pub fn of(attributes: impl IntoIterator<Item = (String, Stated)>) -> Self {
        let mut found = Conventions::default();
        for (name, stated) in attributes {
            found.add(name, &stated);
        }
        found
    }

    fn add(&mut self, name: String, stated: &Stated) {
        let plain = plain(&name);
        let number = stated.number().filter(|number| number.is_finite());
        let named = |number: Option<f64>| number.map(|number| (name.clone(), number));
        match (plain.as_str(), stated) {
            (unit, Stated::Text(text)) if UNITS.contains(&unit) => {
                self.unit.get_or_insert_with(|| text.trim().to_owned());
            }
            ("calendar", Stated::Text(text)) => {
                let everyday = ["", "standard", "gregorian", "proleptic_gregorian"];
                self.other_calendar = Some(text.to_lowercase()).filter(|text| !everyday.contains(&text.as_str()));
            }
            ("unsigned", Stated::Text(text)) => self.unsigned = text.eq_ignore_ascii_case("true"),
            ("scalefactor", _) => self.scale = named(number),
            ("addoffset", _) => self.offset = named(number),
            ("fillvalue" | "missingvalue", _) => self.missing.extend(stated.numbers()),
            ("validmin", _) => self.least = number,
            ("validmax", _) => self.most = number,
            ("validrange", _) => {
                if let [least, most] = stated.numbers()[..] {
                    (self.least, self.most) = (Some(least), Some(most));
                }
            }
            (other, _) if FACTORS.contains(&other) => self.factors.extend(named(number)),
            (other, _) if OFFSETS.contains(&other) => self.sums.extend(named(number)),
            _ => {}
        }
    }

    /// What is stated of one field of a table, whose own unit is `unit`: the attributes of a table
    /// scale none of its fields.
    pub fn of_field(&self, is_table: bool, unit: Option<&String>) -> Self {
        let unit = unit.cloned().or_else(|| self.unit.clone());
        if is_table { Conventions { unit, ..Conventions::default() } } else { Conventions { unit, ..self.clone() } }
    }

    /// The number as which the elements of the array are read.
    pub fn number(&self, number: Number) -> Number {
        match number {
            Number::Signed(width) if self.unsigned => Number::Unsigned(width),
            other => other,
        }
    }

    /// A number of an attribute as the elements are read: that of `_Unsigned` elements is stored
    /// with a sign, as they are.
    fn as_stored(&self, number: f64, width: usize) -> f64 {
        if self.unsigned && number < 0.0 { number + (8.0 * width as f64).exp2() } else { number }
    }

    /// Applies what is stated to the numbers of the array `name`.
    pub fn apply(&self, name: &str, storage: Storage, values: &mut [f64], rest: &mut [f64]) -> Applied {
        let mut applied = Applied { unit: self.unit.clone(), ..Applied::default() };
        let (scale, offset) = self.line(name, storage, &mut applied.notes);
        self.mark_missing(name, storage, (scale, offset), values, &mut applied.notes);
        if (scale, offset) != (1.0, 0.0) {
            values.iter_mut().for_each(|value| *value = *value * scale + offset);
            rest.iter_mut().for_each(|rest| *rest *= scale);
        }
        self.since(name, values, rest, &mut applied);
        applied
    }

    /// What is marked as missing, or lies outside of the valid values, is no sample. Valid values
    /// are those of stored numbers, but where they are in parts and the stored ones whole: then
    /// they are those behind scale and offset.
    fn mark_missing(
        &self,
        name: &str,
        storage: Storage,
        (scale, offset): (f64, f64),
        values: &mut [f64],
        notes: &mut Vec<String>,
    ) {
        let width = if let Storage::Whole(width) = storage { width } else { 0 };
        let marks: Vec<f64> = self.missing.iter().map(|mark| self.as_stored(*mark, width)).collect();
        let in_parts = |bound: Option<f64>| bound.is_some_and(|bound| bound.fract() != 0.0);
        let of_values = matches!(storage, Storage::Whole(_)) && (in_parts(self.least) || in_parts(self.most));
        let bound = |of: Option<f64>| of.map(|of| if of_values { of } else { self.as_stored(of, width) });
        let (least, most) = (bound(self.least), bound(self.most));
        let equals =
            |value: f64, mark: f64| value == mark || (storage == Storage::Single && value as f32 == mark as f32);
        let is_unwritten = |value: f64| !matches!(storage, Storage::Whole(_)) && value as f32 == UNWRITTEN;
        let (mut missing, mut invalid) = (0, 0);
        for value in values.iter_mut() {
            let is_missing = is_unwritten(*value) || marks.iter().any(|mark| equals(*value, *mark));
            let seen = if of_values { *value * scale + offset } else { *value };
            let is_invalid = least.is_some_and(|least| seen < least) || most.is_some_and(|most| seen > most);
            missing += usize::from(is_missing);
            invalid += usize::from(is_invalid && !is_missing);
            if is_missing || is_invalid {
                *value = f64::NAN;
            }
        }
        if missing > 0 {
            notes.push(format!("{missing} value(s) of `{name}` are marked as missing: no sample"));
        }
        if invalid > 0 {
            notes.push(format!("{invalid} value(s) of `{name}` are outside of its valid values: no sample"));
        }
    }

    /// Factor and sum of the straight line from stored numbers to values.
    fn line(&self, name: &str, storage: Storage, notes: &mut Vec<String>) -> (f64, f64) {
        let by_convention = self.scale.is_some() || self.offset.is_some();
        let others: Vec<&Named> = self
            .factors
            .iter()
            .chain(&self.sums)
            .filter(|(of, value)| {
                let without_effect = if OFFSETS.contains(&plain(of).as_str()) { 0.0 } else { 1.0 };
                *value != without_effect
            })
            .collect();
        let is_one_line = self.factors.len() <= 1 && self.sums.len() <= 1;
        let (scale, offset) = if by_convention {
            (self.scale.as_ref(), self.offset.as_ref())
        } else if matches!(storage, Storage::Whole(_)) && is_one_line {
            (self.factors.first(), self.sums.first())
        } else {
            (None, None)
        };
        let used: Vec<&Named> = scale.into_iter().chain(offset).collect();
        let unused: Vec<&Named> = others.into_iter().filter(|other| !used.contains(other)).collect();
        let listed = |all: &[&Named]| {
            all.iter().map(|(name, value)| format!("`{name}` = {value}")).collect::<Vec<_>>().join(", ")
        };
        if !unused.is_empty() {
            let which = listed(&unused);
            notes.push(format!("`{name}` states {which}: not applied, its values are as they are stored"));
        }
        let line = (scale.map_or(1.0, |of| of.1), offset.map_or(0.0, |of| of.1));
        if line != (1.0, 0.0) {
            notes.push(format!("`{name}` is {} times the stored number plus {}: {}", line.0, line.1, listed(&used)));
        }
        line
    }

    /// Counts since a date become seconds since 1970.
    fn since(&self, name: &str, values: &mut [f64], rest: &mut [f64], applied: &mut Applied) {
        let Some(since) = self.unit.as_deref().and_then(Since::parse) else { return };
        applied.unit = Some("s".into());
        if let Some(calendar) = &self.other_calendar {
            values.iter_mut().chain(rest).for_each(|value| *value *= since.count_s);
            applied.notes.push(format!("`{name}` counts from its zero: its calendar `{calendar}` has other days"));
            return;
        }
        applied.is_date = true;
        for (value, rest) in values.iter_mut().zip(rest.iter_mut()) {
            (*value, *rest) = since.seconds(*value, *rest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(attributes: &[(&str, Stated)]) -> Conventions {
        Conventions::of(attributes.iter().map(|(name, stated)| ((*name).to_owned(), stated.clone())))
    }

    fn number(value: f64) -> Stated {
        Stated::Numbers(vec![value])
    }

    #[test]
    fn scale_offset_and_missing_values_are_those_of_stored_numbers() {
        let stated = [("scale_factor", number(0.5)), ("add_offset", number(10.0)), ("_FillValue", number(-1.0))];
        let stated = [&stated[..], &[("valid_max", number(100.0)), ("units", Stated::Text("deg/s".into()))]].concat();
        let mut values = [2.0, -1.0, 101.0, 4.0];
        let applied = of(&stated).apply("x", Storage::Whole(2), &mut values, &mut [0.0; 4]);
        assert_eq!((values[0], values[3], applied.unit.as_deref()), (11.0, 12.0, Some("deg/s")));
        assert!(values[1].is_nan() && values[2].is_nan());
        assert_eq!(applied.notes.len(), 3, "{:?}", applied.notes);
    }

    #[test]
    fn what_nobody_wrote_is_no_sample() {
        let mut values = [f64::from(9.969_21e36_f32), 9.969_209_968_386_869e36, 1.0];
        of(&[]).apply("x", Storage::Single, &mut values[..1], &mut [0.0]);
        of(&[]).apply("x", Storage::Double, &mut values[1..], &mut [0.0; 2]);
        assert!(values[0].is_nan() && values[1].is_nan() && values[2] == 1.0, "{values:?}");
    }

    #[test]
    fn numbers_stored_with_a_sign_may_have_none() {
        let stated =
            [("_Unsigned", Stated::Text("true".into())), ("_FillValue", number(-1.0)), ("valid_max", number(-6.0))];
        let conventions = of(&stated);
        assert_eq!(conventions.number(Number::Signed(1)), Number::Unsigned(1));
        let mut values = [128.0, 255.0, 251.0, 250.0];
        conventions.apply("x", Storage::Whole(1), &mut values, &mut [0.0; 4]);
        assert_eq!((values[0], values[3]), (128.0, 250.0));
        assert!(values[1].is_nan() && values[2].is_nan());
    }

    #[test]
    fn valid_values_in_parts_of_whole_numbers_are_those_behind_the_scale() {
        let stated = [("scale_factor", number(0.001)), ("valid_range", Stated::Numbers(vec![-0.9, 0.9]))];
        let mut values = [500.0, -950.0];
        of(&stated).apply("x", Storage::Whole(2), &mut values, &mut [0.0; 2]);
        assert!((values[0] - 0.5).abs() < 1e-12 && values[1].is_nan(), "{values:?}");
    }

    #[test]
    fn a_factor_by_name_is_of_whole_numbers_and_noted_elsewhere() {
        for (storage, expected, word) in [(Storage::Whole(2), 4.0, "times"), (Storage::Double, 2.0, "not applied")] {
            let mut values = [2.0];
            let applied = of(&[("gain", number(2.0))]).apply("x", storage, &mut values, &mut [0.0]);
            assert_eq!(values, [expected]);
            assert!(applied.notes[0].contains(word), "{:?}", applied.notes);
        }
        let two = of(&[("gain", number(2.0)), ("lsb", number(3.0))]);
        let mut values = [2.0];
        assert!(two.apply("x", Storage::Whole(2), &mut values, &mut [0.0]).notes[0].contains("not applied"));
        assert_eq!(values, [2.0]);
    }

    #[test]
    fn a_mark_in_double_precision_is_found_among_numbers_of_single() {
        let mut values = [f64::from(-9999.9f32), 1.0];
        of(&[("missing_value", number(-9999.9))]).apply("x", Storage::Single, &mut values, &mut [0.0; 2]);
        assert!(values[0].is_nan());
    }
}
