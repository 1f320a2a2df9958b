//! Numbers as other programs and other countries write them: what to write instead.

use super::{STANDARD_GRAVITY, UNITS, parse, power_of, split};

/// Symbols that are no units here, and what one of them is.
static FOREIGN: &[(&[&str], &str)] = &[
    (&["lb", "lbs", "lbm"], "1 lb is 0.45359237 kg"),
    (&["oz"], "1 oz is 0.028349523125 kg"),
    (&["slug", "slugs"], "1 slug is 14.5939 kg"),
    (&["t", "tonne"], "1 t is 1000 kg"),
    (&["in", "inch"], "1 in is 0.0254 m"),
    (&["ft"], "1 ft is 0.3048 m"),
    (&["nmi"], "1 nmi is 1852 m"),
    (&["psi"], "1 psi is 6894.757 Pa"),
    (&["bar"], "1 bar is 1e5 Pa"),
    (&["kn", "knot", "knots"], "1 kn is 0.514444 m/s"),
    (&["degC", "°C", "℃"], "temperatures are in K"),
    (&["sec", "secs", "second", "seconds"], "seconds are 's'"),
    (&["hr", "hour", "hours"], "hours are 'h'"),
    (&["minute", "minutes"], "minutes are 'min'"),
    (&["ms2", "msec"], "milliseconds are 'ms', m/s^2 has its power"),
    (&["degree", "degrees", "degs"], "degrees are 'deg'"),
    (&["radian", "radians"], "radians are 'rad'"),
    (&["newton", "newtons", "Newton"], "newtons are 'N'"),
    (&["meter", "meters", "metre", "metres"], "metres are 'm'"),
    (&["kilogram", "kilograms", "Kg", "KG", "kgs"], "kilograms are 'kg'"),
    (&["hz", "HZ"], "hertz are 'Hz'"),
    (&["RPM"], "turns per minute are 'rpm'"),
    (&["cycles", "turn", "turns", "revs"], "turns are 'rev'"),
];

/// The cure of a number with unit that cannot be read, where its mistake is a known one.
pub fn likely_cure(text: &str) -> Option<String> {
    let text = text.trim();
    let plain = text.replace(['\u{2212}', '\u{2013}', '\u{2012}', '\u{fe63}', '\u{ff0d}'], "-");
    if plain != text {
        return Some(format!("the minus sign is '-': \"{plain}\""));
    }
    if let Some(pointed) = pointed(text) {
        return Some(format!("the decimal sign is a point: \"{pointed}\""));
    }
    let (number, unit) = split(text)?;
    let written = |unit: String| parse(&unit).ok().map(|_| format!("\"{number} {unit}\""));
    if let Some(better) = unit.contains("**").then(|| written(unit.replace("**", "^"))).flatten() {
        return Some(format!("a power is written with '^': {better}"));
    }
    if let Some(better) = unit.contains('.').then(|| written(unit.replace('.', "*"))).flatten() {
        return Some(format!("units are multiplied with '*': {better}"));
    }
    if let Some(better) = with_powers(unit).and_then(written) {
        return Some(format!("a power is written with '^': {better}"));
    }
    foreign(unit)
}

/// "10,5 kg" with a point; a comma between digits only.
fn pointed(text: &str) -> Option<String> {
    let at = text.find(',')?;
    let (before, after) = (text.as_bytes().get(at.checked_sub(1)?)?, text.as_bytes().get(at + 1)?);
    let digits = before.is_ascii_digit() && after.is_ascii_digit();
    let single = text.matches(',').count() == 1;
    (digits && single).then(|| text.replace(',', "."))
}

/// `kg m2` and `kgm2` as `kg*m^2`.
fn with_powers(unit: &str) -> Option<String> {
    let mut result = String::new();
    let mut rest = unit;
    while let Some(first) = rest.chars().next() {
        let end = rest.find(|c: char| !c.is_alphabetic()).unwrap_or(rest.len());
        if end == 0 {
            result.push(first);
            rest = &rest[first.len_utf8()..];
            continue;
        }
        result.push_str(&symbols(&rest[..end])?);
        rest = &rest[end..];
        let power = rest.bytes().take_while(u8::is_ascii_digit).count();
        if power > 0 {
            result.push('^');
            result.push_str(&rest[..power]);
            rest = &rest[power..];
        }
    }
    (result != unit).then_some(result)
}

/// Letters as one known symbol, or as two that were run together.
fn symbols(letters: &str) -> Option<String> {
    if known(letters) || letters == "sqrt" {
        return Some(letters.to_owned());
    }
    let cut = |at: usize| letters.split_at(at);
    let mut cuts = letters.char_indices().map(|(at, _)| at).skip(1).map(cut);
    cuts.find(|(one, other)| known(one) && known(other)).map(|(one, other)| format!("{one}*{other}"))
}

fn known(symbol: &str) -> bool {
    let whole = UNITS.iter().any(|(known, ..)| *known == symbol);
    let prefixed = || {
        let prefix = symbol.chars().next()?;
        power_of(prefix)?;
        let base = &symbol[prefix.len_utf8()..];
        let found = UNITS.iter().find(|(known, _, prefixes)| *known == base && prefixes.contains(prefix))?;
        // a milli-g is rarely meant where letters run together
        (found.1 != STANDARD_GRAVITY).then_some(())
    };
    whole || prefixed().is_some()
}

fn foreign(unit: &str) -> Option<String> {
    let letters = |word: &&str| !word.is_empty();
    let mut words = unit.split(|c: char| !(c.is_alphabetic() || c == '°')).filter(letters);
    words.find_map(|word| FOREIGN.iter().find(|(names, _)| names.contains(&word))).map(|(_, cure)| (*cure).to_owned())
}
