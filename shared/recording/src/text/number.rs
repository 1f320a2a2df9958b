//! Numbers as cells state them: decimal sign, thousands, exponents of other languages, marks.

use super::signs::Signs;
use std::borrow::Cow;

/// The number that a cell states; of a truth value 1 or 0.
pub(crate) fn number(cell: &str, signs: Signs) -> Option<f64> {
    // most cells are plain
    let is_plain = |byte: u8| byte.is_ascii_digit() || matches!(byte, b'-' | b'+' | b'.' | b'e' | b'E');
    if !signs.grouped
        && cell.bytes().all(is_plain)
        && let Ok(number) = cell.parse()
    {
        return Some(number);
    }
    // an apostrophe makes a number a text to a spreadsheet
    let cell = with_plain_sign(cell.trim().trim_matches('\''));
    let unsigned = cell.strip_prefix(['-', '+']).unwrap_or(&cell);
    // not `inf`, `nan`, `-inf`, which the parser takes
    if !unsigned.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | ',')) {
        return truth(&cell);
    }
    let sign = if cell.starts_with('-') { -1.0 } else { 1.0 };
    let (point, group) = if signs.decimal_comma { (',', '.') } else { ('.', ',') };
    // a point that divides thousands is no decimal sign, whatever the parser takes it for
    if !(signs.grouped && cell.contains(group))
        && let Ok(number) = cell.parse()
    {
        return Some(number);
    }
    if let Some(plain) = without_thousands(unsigned, point, group, signs.grouped) {
        return plain.parse::<f64>().ok().map(|number| sign * number);
    }
    if signs.decimal_comma && cell.contains(',') && !cell.contains('.') {
        let plain = cell.replacen(',', ".", 1);
        return plain.parse().ok().or_else(|| of_fortran(&plain));
    }
    if signs.grouped && cell.contains(group) { None } else { of_fortran(&cell) }
}

/// A minus sign of typesetting is that of a computer, where a number follows.
fn with_plain_sign(cell: &str) -> Cow<'_, str> {
    match cell.strip_prefix(['\u{2212}', '\u{2013}']) {
        Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | ',')) => {
            Cow::Owned(format!("-{rest}"))
        }
        _ if cell.contains('\u{2212}') => Cow::Owned(cell.replace('\u{2212}', "-")),
        _ => Cow::Borrowed(cell),
    }
}

fn truth(cell: &str) -> Option<f64> {
    let is = |word| cell.eq_ignore_ascii_case(word);
    if is("true") { Some(1.0) } else { is("false").then_some(0.0) }
}

/// Fortran's double precision, `1.5D+02`, and its exponents of three digits, `1.5-003`.
fn of_fortran(cell: &str) -> Option<f64> {
    if cell.contains(['D', 'd']) {
        return cell.replace(['D', 'd'], "e").parse().ok();
    }
    let at = cell.rfind(['-', '+']).filter(|at| *at > 0)?;
    let (mantissa, exponent) = cell.split_at(at);
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let (whole, part) = mantissa.trim_start_matches(['-', '+']).split_once('.')?;
    let is_mantissa = (whole.is_empty() || digits(whole)) && digits(part);
    (is_mantissa && exponent.len() == 4 && digits(&exponent[1..]))
        .then(|| format!("{mantissa}e{exponent}"))?
        .parse()
        .ok()
}

/// A number whose thousands are divided by `group` or an apostrophe, with a decimal point. One
/// `group` without a point may be a decimal sign: that gives no number unless the table says that
/// it divides thousands.
fn without_thousands(unsigned: &str, point: char, group: char, grouped: bool) -> Option<String> {
    let (whole, part) = unsigned.split_once(point).unwrap_or((unsigned, ""));
    let divides = |c: char| c == group || matches!(c, '\'' | '’' | '\u{a0}' | '\u{202f}');
    let sign = whole.chars().find(|c| divides(*c))?;
    let groups: Vec<&str> = whole.split(sign).collect();
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let first = (1..=3).contains(&groups[0].len()) && digits(groups[0]) && !groups[0].starts_with('0');
    let others = groups[1..].iter().all(|group| group.len() == 3 && digits(group));
    let certain = grouped || sign != group || groups.len() > 2 || !part.is_empty();
    (first && others && digits(part) && certain).then(|| format!("{}.{part}", groups.concat()))
}

/// What a cell states that is a number and something more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Marked {
    /// A number with a mark or a remark behind it: `2.19*`, `0.5 # event`.
    Number(f64),
    /// A bookkeeper's negative number: `(0.013)`.
    InParentheses(f64),
}

/// The number of a cell that has a mark.
pub(crate) fn marked(cell: &str, signs: Signs) -> Option<Marked> {
    let cell = cell.trim();
    if let Some(inner) = cell.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')) {
        let unsigned = inner.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | ','));
        return number(inner, signs).filter(|_| unsigned).map(|value| Marked::InParentheses(-value));
    }
    let remarked = [" #", "\t#", " //", "\t//"].iter().find_map(|mark| cell.split_once(mark)).map(|(value, _)| value);
    let text = remarked.unwrap_or_else(|| cell.trim_end_matches(['*', '!', '†', '‡', '#', '~', '^', ' ']));
    let plain = |text: &&str| text.len() < cell.len() && text.ends_with(|c: char| c.is_ascii_digit());
    Some(text.trim()).filter(plain).and_then(|text| number(text, signs)).map(Marked::Number)
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINT: Signs = Signs { decimal_comma: false, grouped: false };
    const COMMA: Signs = Signs { decimal_comma: true, grouped: false };

    #[test]
    fn numbers_of_other_languages_are_numbers() {
        let cases = [
            ("\u{2212}0.5", POINT, -0.5),
            ("1.25-003", POINT, 0.00125),
            ("-1.25+002", POINT, -125.0),
            ("1.5D-02", POINT, 0.015),
            ("1e\u{2212}3", POINT, 1e-3),
            ("0,25", COMMA, 0.25),
            ("1.271", COMMA, 1.271),
            ("1.271", Signs { grouped: true, ..COMMA }, 1271.0),
            ("-1,271", Signs { grouped: true, ..POINT }, -1271.0),
            ("12", Signs { grouped: true, ..POINT }, 12.0),
        ];
        for (cell, signs, value) in cases {
            assert_eq!(number(cell, signs), Some(value), "{cell}");
        }
        for cell in ["1,271", "1-003", "1.2-03", "2024-03-05", "-", "\u{2212}", "1.2.3", "12-05-2024"] {
            assert_eq!(number(cell, POINT), None, "{cell}");
        }
        assert_eq!(number("0.271", Signs { grouped: true, ..COMMA }), None);
    }

    #[test]
    fn a_mark_is_told_from_the_number_before_it() {
        let cases = [
            ("2.193*", Marked::Number(2.193)),
            ("-0.5 # event", Marked::Number(-0.5)),
            ("(0.013)", Marked::InParentheses(-0.013)),
        ];
        for (cell, value) in cases {
            assert_eq!(marked(cell, POINT), Some(value), "{cell}");
        }
        for cell in ["<0.001", "ERR", "(A)", "*****", "(-1)", "1.2"] {
            assert_eq!(marked(cell, POINT), None, "{cell}");
        }
    }
}
