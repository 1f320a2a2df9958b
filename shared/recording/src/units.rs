//! Units of channels: which SI unit a spelling is converted to.
//!
//! The spellings are those of [`units`]. Values are converted once, at this border:
//! `SI = value * multiply / divide + offset`. Powers of ten divide or multiply by an exact number,
//! so that 5 ms is the f64 nearest to 0.005.

use crate::error::nearest;
use std::sync::LazyLock;
use units::{Fault, Spelled, is_symbol, plain, spelled, spelled_with_gram, symbols};

/// A unit of a file's numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// As [`UNITS`] writes it, else its SI unit.
    pub symbol: &'static str,
    /// The SI unit it is converted to.
    pub si: &'static str,
    multiply: f64,
    divide: f64,
    offset: f64,
}

impl Unit {
    /// `value` in this unit, expressed in [`Unit::si`].
    #[must_use]
    pub fn to_si(&self, value: f64) -> f64 {
        let scaled = value * self.multiply / self.divide;
        // A sum with 0 would turn -0 into 0: what is SI already stays bit for bit what it is.
        if self.offset == 0.0 { scaled } else { scaled + self.offset }
    }

    fn of(symbol: &'static str, si: &'static str, unit: &units::Unit) -> Self {
        let [multiply, divide, offset] = unit.conversion();
        Unit { symbol, si, multiply, divide, offset }
    }

    /// A unit that is `multiply / divide` of the SI unit `si`.
    pub(crate) fn scaled(si: &'static str, multiply: f64, divide: f64) -> Self {
        Unit { symbol: si, si, multiply, divide, offset: 0.0 }
    }

    /// Of a number whose unit is not stated.
    pub(crate) fn not_stated() -> Self {
        Unit::scaled(NOT_STATED, 1.0, 1.0)
    }
}

/// Unit of a channel whose file states none: no unit of a plant equals it.
pub const NOT_STATED: &str = "?";

/// Alone, each may be two things; how either is spelled.
const AMBIGUOUS: &[(&[&str], &str)] = &[
    (&["G", "mG", "uG", "nG"], "[gauss] or [gn], a standard gravity"),
    (&["lb", "lbs"], "[lbm], a mass, or [lbf], a force"),
];

/// How the two things are spelled that the unit `text` may be.
#[must_use]
pub fn two_meanings(text: &str) -> Option<&'static str> {
    let plain = plain(text);
    AMBIGUOUS.iter().find(|(names, _)| names.contains(&plain.as_str())).map(|(_, spellings)| *spellings)
}

/// The SI units of channels and the usual units of each: what a hint lists.
const LISTED: &[(&str, &str)] = &[
    ("-", "-"),
    ("%", "-"),
    ("s", "s"),
    ("ms", "s"),
    ("us", "s"),
    ("ns", "s"),
    ("min", "s"),
    ("h", "s"),
    ("d", "s"),
    ("Hz", "Hz"),
    ("kHz", "Hz"),
    ("m", "m"),
    ("cm", "m"),
    ("mm", "m"),
    ("um", "m"),
    ("km", "m"),
    ("in", "m"),
    ("ft", "m"),
    ("m/s", "m/s"),
    ("mm/s", "m/s"),
    ("km/s", "m/s"),
    ("m/s^2", "m/s^2"),
    ("mm/s^2", "m/s^2"),
    ("g", "m/s^2"),
    ("mg", "m/s^2"),
    ("ug", "m/s^2"),
    ("m/s^3", "m/s^3"),
    ("m^2", "m^2"),
    ("m^3", "m^3"),
    ("m^3/s", "m^3/s"),
    ("l/min", "m^3/s"),
    ("1/s", "1/s"),
    // Frequency responses: receptance, mobility, accelerance, and those of a torque.
    ("m/N", "m/N"),
    ("m/s/N", "m/s/N"),
    ("m/s^2/N", "m/s^2/N"),
    ("rad/N/m", "rad/N/m"),
    ("rad/s/N/m", "rad/s/N/m"),
    ("rad/s^2/N/m", "rad/s^2/N/m"),
    ("rad", "rad"),
    ("mrad", "rad"),
    ("deg", "rad"),
    ("rev", "rad"),
    ("rad/s", "rad/s"),
    ("mrad/s", "rad/s"),
    ("deg/s", "rad/s"),
    ("deg/h", "rad/s"),
    ("rpm", "rad/s"),
    ("rad/s^2", "rad/s^2"),
    ("deg/s^2", "rad/s^2"),
    ("mrad/s^2", "rad/s^2"),
    ("rpm/s", "rad/s^2"),
    ("kg", "kg"),
    ("kg/s", "kg/s"),
    ("g/s", "kg/s"),
    ("kg*m", "kg*m"),
    ("kg*m^2", "kg*m^2"),
    ("kg/m^3", "kg/m^3"),
    ("N", "N"),
    ("mN", "N"),
    ("kN", "N"),
    ("uN", "N"),
    ("lbf", "N"),
    ("N*s", "N*s"),
    ("N/m", "N/m"),
    ("N/mm", "N/m"),
    ("kN/m", "N/m"),
    ("N*s/m", "N*s/m"),
    ("N*m", "N*m"),
    ("mN*m", "N*m"),
    ("uN*m", "N*m"),
    ("kN*m", "N*m"),
    ("N*m/rad", "N*m/rad"),
    ("N*m/deg", "N*m/rad"),
    ("N*m*s/rad", "N*m*s/rad"),
    ("N*m/A", "N*m/A"),
    ("mN*m/A", "N*m/A"),
    ("N*m*s", "N*m*s"),
    ("mN*m*s", "N*m*s"),
    ("Pa", "Pa"),
    ("hPa", "Pa"),
    ("kPa", "Pa"),
    ("MPa", "Pa"),
    ("bar", "Pa"),
    ("T", "T"),
    ("mT", "T"),
    ("uT", "T"),
    ("nT", "T"),
    ("K", "K"),
    ("degC", "K"),
    ("V", "V"),
    ("mV", "V"),
    ("A", "A"),
    ("mA", "A"),
    ("uA", "A"),
    ("ohm", "ohm"),
    ("H", "H"),
    ("mH", "H"),
    ("V*s/rad", "V*s/rad"),
    ("A*m^2", "A*m^2"),
    ("W", "W"),
    ("mW", "W"),
    ("J", "J"),
];

/// The listed units.
pub static UNITS: LazyLock<Vec<Unit>> = LazyLock::new(|| {
    let unit = |(symbol, si): &(&'static str, &'static str)| Some(Unit::of(symbol, si, &spelled(symbol).ok()?.unit));
    LISTED.iter().filter_map(unit).collect()
});

/// SI units with their dimensions, in the order of the list.
static SI: LazyLock<Vec<(&str, Spelled)>> = LazyLock::new(|| {
    let si = LISTED.iter().filter(|(symbol, si)| symbol == si);
    si.filter_map(|(symbol, _)| Some((*symbol, spelled(symbol).ok()?))).collect()
});

/// The unit spelled `text`: an entry of [`UNITS`], or a product of powers of units as files write
/// them (`m s^-2`, `N·m`, `deg/sec`, `dps`, `in/s`), where its dimension is one of a channel.
///
/// ```
/// use recording::units::unit_named;
///
/// for spelling in ["m/s^2", "m/s2", "m s-2", "m·s⁻²", "meters/sec^2", "(m/s/s)"] {
///     assert_eq!(unit_named(spelling).unwrap().si, "m/s^2", "{spelling}");
/// }
/// assert_eq!(unit_named("dps").unwrap().to_si(180.0), core::f64::consts::PI);
/// assert_eq!(unit_named("N/n"), None);
/// ```
#[must_use]
pub fn unit_named(text: &str) -> Option<Unit> {
    let plain = plain(text);
    let plain = if matches!(plain.as_str(), "" | "1") { "-" } else { plain.as_str() };
    if two_meanings(plain).is_some() {
        return None;
    }
    let listed = UNITS.iter().find(|unit| unit.symbol == plain).copied();
    let product = |plain: &str| [spelled(plain), spelled_with_gram(plain)].iter().find_map(of_channels);
    listed.or_else(|| product(plain)).or_else(|| in_usual_case(plain).and_then(|plain| product(&plain)))
}

/// `DEG/S`, `M/S^2`, `Rad/Sec`, `KPA` in small letters where the table has them so; `None` for words
/// that are something else in capitals, too.
fn in_usual_case(plain: &str) -> Option<String> {
    const LABELS: &[&str] = &["IN", "MIN", "M", "S", "A", "NM"];
    if LABELS.contains(&plain) || !plain.contains(char::is_uppercase) {
        return None;
    }
    let letters = |c: char| c.is_alphabetic();
    let mut usual = String::new();
    let mut rest = plain;
    while !rest.is_empty() {
        let end = rest.find(|c| !letters(c)).unwrap_or(rest.len());
        let (word, behind) = rest.split_at(end);
        let sign = behind.find(letters).unwrap_or(behind.len());
        usual.push_str(&if word.is_empty() { String::new() } else { word_in_usual_case(word)? });
        usual.push_str(&behind[..sign]);
        rest = &behind[sign..];
    }
    Some(usual)
}

fn word_in_usual_case(word: &str) -> Option<String> {
    const SHORT: &[(&str, &str)] = &[
        ("M", "m"),
        ("S", "s"),
        ("MM", "mm"),
        ("CM", "cm"),
        ("KM", "km"),
        ("FT", "ft"),
        ("IN", "in"),
        ("LB", "lb"),
        ("MS", "ms"),
        ("US", "us"),
        ("KN", "kN"),
        ("NM", "Nm"),
        ("KNM", "kNm"),
        ("PA", "Pa"),
        ("HPA", "hPa"),
        ("KPA", "kPa"),
        ("MPA", "MPa"),
        ("KHZ", "kHz"),
        ("MHZ", "MHz"),
        ("GHZ", "GHz"),
        ("KW", "kW"),
        ("KV", "kV"),
    ];
    if let Some((_, usual)) = SHORT.iter().find(|(capitals, _)| *capitals == word) {
        return Some((*usual).into());
    }
    if is_symbol(word) {
        return Some(word.into());
    }
    let small = word.to_lowercase();
    (word.chars().count() > 2 && is_symbol(&small)).then_some(small)
}

/// A unit whose dimension is that of an SI unit of the list: of several (N m and J, kg/s and
/// N s/m) the one that counts the same cycles and shares most symbols with the text.
fn of_channels(read: &Result<Spelled, Fault>) -> Option<Unit> {
    let Spelled { unit, symbols } = read.as_ref().ok()?;
    let mut best: Option<((bool, usize), &'static str)> = None;
    for (si, of) in SI.iter().filter(|(_, of)| (of.unit.dimension, of.unit.radian) == (unit.dimension, unit.radian)) {
        let shared = of.symbols.iter().filter(|name| symbols.contains(name)).count();
        let key = (of.unit.hertz == unit.hertz, shared);
        if best.is_none_or(|(most, _)| key > most) {
            best = Some((key, si));
        }
    }
    best.map(|(_, si)| Unit::of(si, si, unit))
}

/// A spelling that is known in place of `text`, which is not: the one symbol of it that is unknown
/// replaced by the nearest, everything else left as it stands, so that the dimension stays what the
/// file means.
#[must_use]
pub fn nearest_spelling(text: &str) -> Option<String> {
    let text = text.trim().trim_start_matches(['[', '(', '<', '{']).trim_end_matches([']', ')', '>', '}']).trim();
    let letter = |c: char| c.is_alphabetic() || matches!(c, '%' | '_');
    let words = text.split(|c: char| !letter(c)).filter(|word| !word.is_empty());
    let mut unknown = words.filter(|word| !is_symbol(word));
    let (word, None) = (unknown.next()?, unknown.next()) else { return None };
    let names = || symbols().flatten().copied();
    let begun = |name: &&str| word.len() > 2 && name.to_lowercase().starts_with(&word.to_lowercase());
    let near = names().find(begun).or_else(|| nearest(word, names()))?;
    let better = text.replacen(word, near, 1);
    unit_named(&better).map(|_| better)
}

/// `text` as it stands in the list, where it is an SI unit there.
pub(crate) fn si_unit(text: &str) -> Option<&'static str> {
    if text == NOT_STATED {
        return Some(NOT_STATED);
    }
    LISTED.iter().find(|(symbol, si)| *symbol == text && *si == text).map(|(_, si)| *si)
}

/// The spellings that are converted to `si`, as a list for a reader.
#[must_use]
pub fn accepted_for(si: &str) -> String {
    LISTED.iter().filter(|(_, of)| *of == si).map(|(symbol, _)| *symbol).collect::<Vec<_>>().join(", ")
}
