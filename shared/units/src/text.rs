//! One spelling for signs: `*`, `/`, `^`, letters; outer brackets and points behind
//! abbreviations gone.

use crate::table::RUN_TOGETHER;

/// `text` with one spelling for signs, as [`crate::parse`] reads it.
#[must_use]
pub fn plain(text: &str) -> String {
    let mut plain = String::new();
    let mut raised = false;
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    // UTF-8 that was read as Latin-1: `Â°`
    let text = text.replace("Â", "");
    // what a meter says of a voltage or a current: `V DC`
    let text = [" DC", " AC", " RMS", " rms"].iter().find_map(|of| text.strip_suffix(of)).unwrap_or(&text);
    for c in without_brackets(text).chars() {
        let power = superscript(c);
        if power.is_some() && !raised {
            plain.push('^');
        }
        raised = power.is_some();
        match power.unwrap_or(c) {
            '°' | 'º' => plain.push_str("deg"),
            '℃' => plain.push_str("degC"),
            'µ' | 'μ' => plain.push('u'),
            'ε' => plain.push_str("strain"),
            'Ω' | '\u{2126}' => plain.push_str("ohm"),
            '·' | '⋅' | '×' | '•' | ' ' => plain.push('*'),
            '−' | '–' => plain.push('-'),
            other => plain.push(other),
        }
    }
    let mut plain = plain.replace("'s", "");
    for (from, to) in
        [("*per*", "/"), ("**", "^"), ("*/*", "/"), ("/*", "/"), ("*/", "/"), ("*^", "^"), ("^*", "^"), ("*)", ")")]
    {
        plain = plain.replace(from, to);
    }
    with_products(&plain)
}

fn without_brackets(text: &str) -> &str {
    let pairs = [('[', ']'), ('(', ')'), ('<', '>'), ('{', '}')];
    let inner = pairs.iter().find_map(|(open, close)| text.strip_prefix(*open)?.strip_suffix(*close));
    // `(m)/(s)` begins and ends with a bracket, too
    inner.filter(|inner| !inner.contains(['(', ')'])).map_or(text, str::trim)
}

fn superscript(c: char) -> Option<char> {
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    match c {
        '⁻' => Some('-'),
        _ => digits.iter().position(|digit| *digit == c).and_then(|k| char::from_digit(k as u32, 10)),
    }
}

/// A point or a hyphen between a letter or a power and a letter multiplies, a point behind a word
/// abbreviates it.
fn with_products(plain: &str) -> String {
    let all: Vec<char> = plain.chars().collect();
    let mut product = String::new();
    for (i, c) in all.iter().enumerate() {
        let before = i.checked_sub(1).and_then(|k| all.get(k));
        let behind = all.get(i + 1);
        let follows = before.is_some_and(|c| c.is_alphanumeric());
        match c {
            '.' | '-' if follows && behind.is_some_and(|c| c.is_alphabetic()) => product.push('*'),
            '.' if before.is_some_and(|c| c.is_alphabetic()) && !behind.is_some_and(|c| c.is_alphanumeric()) => {}
            other => product.push(*other),
        }
    }
    let apart = |part: &str| -> String {
        RUN_TOGETHER.iter().find(|(together, _)| *together == part).map_or(part, |(_, apart)| *apart).to_owned()
    };
    product.split('/').map(apart).collect::<Vec<_>>().join("/")
}
