//! Numbers as other countries write them, and units that have no meaning here: what to write
//! instead.

use super::split;

/// Symbols that are no units here, and what one of them is.
static FOREIGN: &[(&[&str], &str)] = &[
    (&["t", "tonne"], "1 t is 1000 kg"),
    (&["degC", "°C", "℃", "degF", "°F", "celsius", "Celsius"], "temperatures are in K"),
    (&["ms2"], "milliseconds are 'ms', m/s^2 has its power"),
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
    foreign(split(text)?.1)
}

/// "10,5 kg" with a point; a comma between digits only.
fn pointed(text: &str) -> Option<String> {
    let at = text.find(',')?;
    let (before, after) = (text.as_bytes().get(at.checked_sub(1)?)?, text.as_bytes().get(at + 1)?);
    let digits = before.is_ascii_digit() && after.is_ascii_digit();
    let single = text.matches(',').count() == 1;
    (digits && single).then(|| text.replace(',', "."))
}

fn foreign(unit: &str) -> Option<String> {
    let letters = |word: &&str| !word.is_empty();
    let mut words = unit.split(|c: char| !(c.is_alphabetic() || c == '°')).filter(letters);
    words.find_map(|word| FOREIGN.iter().find(|(names, _)| names.contains(&word))).map(|(_, cure)| (*cure).to_owned())
}
