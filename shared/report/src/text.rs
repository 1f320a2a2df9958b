//! Escaped text of a known width, and numbers with their significant digits.

use std::fmt::Write;

/// Text as it may stand in an element or an attribute; control characters, which XML forbids,
/// become a replacement sign.
#[must_use]
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(c),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// A number for a sentence: four significant digits; NaN and infinity are a dash.
#[must_use]
pub fn short(x: f64) -> String {
    if !x.is_finite() {
        return "–".into();
    }
    if x == 0.0 {
        return "0".into();
    }
    let exponent = libm::floor(libm::log10(x.abs())) as i32;
    if (-3..5).contains(&exponent) {
        let text = format!("{:.*}", (3 - exponent).max(0) as usize, x);
        return if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text };
    }
    let text = format!("{x:.3e}");
    let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
    format!("{}e{power}", digits.trim_end_matches('0').trim_end_matches('.'))
}

/// Value and standard deviation with two digits of the deviation: `28.70`, `0.41`.
#[must_use]
pub fn with_sigma(value: f64, sigma: f64) -> (String, String) {
    if !(value.is_finite() && sigma.is_finite() && sigma > 0.0) {
        return (short(value), if sigma == 0.0 { "0".into() } else { short(sigma) });
    }
    let largest = libm::floor(libm::log10(value.abs().max(sigma))) as i32;
    let decimals = 1 - libm::floor(libm::log10(sigma)) as i32;
    // More digits than a reader takes in, or leading zeros without end: both as powers of ten.
    if !(-4..8).contains(&largest) || decimals > 9 || largest + decimals > 12 {
        let digits = (largest + decimals).clamp(1, 15) as usize;
        return (format!("{value:.digits$e}"), format!("{sigma:.1e}"));
    }
    let decimals = decimals.max(0) as usize;
    let text = format!("{value:.decimals$}");
    // what rounds to nothing has no sign
    let rounded = if text.bytes().any(|b| (b'1'..=b'9').contains(&b)) { &text } else { text.trim_start_matches('-') };
    (rounded.to_owned(), format!("{sigma:.decimals$}"))
}

/// `10ⁿ`.
#[must_use]
pub fn power_of_ten(n: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let mut out = String::from(if n < 0 { "10⁻" } else { "10" });
    for c in n.unsigned_abs().to_string().bytes() {
        out.push(DIGITS[(c - b'0') as usize]);
    }
    out
}

/// Width in em of a line of sans-serif text: an upper estimate over the usual fonts, since a page
/// cannot measure.
#[must_use]
pub fn width_em(text: &str) -> f64 {
    text.chars()
        .map(|c| match c {
            'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' | ' ' => 0.34,
            'f' | 't' | 'r' | '(' | ')' | '[' | ']' | '/' | '-' => 0.45,
            'm' | 'w' | 'M' | 'W' | '%' | '@' => 0.98,
            c if c.is_ascii_uppercase() => 0.74,
            c if c.is_ascii() => 0.64,
            '⁻' | '⁰' | '¹' | '²' | '³' | '⁴' | '⁵' | '⁶' | '⁷' | '⁸' | '⁹' | '·' => 0.48,
            c if c < '\u{2e80}' => 0.8,
            _ => 1.05,
        })
        .sum()
}

/// The text, cut in its middle where it is wider than `em_max`: names differ at both ends.
#[must_use]
pub fn fit(text: &str, em_max: f64) -> String {
    if width_em(text) <= em_max {
        return text.into();
    }
    let chars: Vec<char> = text.chars().collect();
    for kept in (1..chars.len()).rev() {
        let head = kept.div_ceil(2);
        let mut cut: String = chars[..head].iter().collect();
        cut.push('…');
        cut.extend(&chars[chars.len() - (kept - head)..]);
        if width_em(&cut) <= em_max {
            return cut;
        }
    }
    "…".into()
}

/// A coordinate of a drawing: tenths of a unit, without trailing zeros; NaN and values far outside
/// lie at the border of the drawing.
pub(crate) fn coordinate(out: &mut String, x: f64) {
    let tenths = (if x.is_nan() { 0.0 } else { x.clamp(-1e5, 1e5) } * 10.0).round() as i64;
    let (sign, size) = (if tenths < 0 { "-" } else { "" }, tenths.unsigned_abs());
    let _ = match size % 10 {
        0 => write!(out, "{sign}{}", size / 10),
        tenth => write!(out, "{sign}{}.{tenth}", size / 10),
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_carry_the_digits_that_their_sigma_gives_meaning_to() {
        assert_eq!(with_sigma(28.7012, 0.412), ("28.70".into(), "0.41".into()));
        assert_eq!(with_sigma(123_456.0, 4321.0), ("123456".into(), "4321".into()));
        assert_eq!(with_sigma(1.234_567e-7, 2.1e-9), ("1.235e-7".into(), "2.1e-9".into()));
        assert_eq!(with_sigma(f64::NAN, 1.0).0, "–");
        assert_eq!(with_sigma(-4.8e-7, 2.3e-3).0, "0.0000");
        assert_eq!(short(0.001_234_56), "0.001235");
        assert_eq!(short(-1.5e-9), "-1.5e-9");
        assert_eq!(short(100.0), "100");
        assert_eq!(power_of_ten(-12), "10⁻¹²");
    }

    #[test]
    fn a_cut_name_fits_and_keeps_both_ends() {
        let name = "joint_asymmetric_friction@joint:shoulder_pitch_left_arm";
        for em in [3.0, 8.0, 20.0, 60.0] {
            assert!(width_em(&fit(name, em)) <= em);
        }
        let cut = fit(name, 15.0);
        assert!(cut.starts_with("joint") && cut.ends_with("arm") && cut.contains('…'), "{cut}");
        assert_eq!(fit("short", 60.0), "short");
    }

    #[test]
    fn what_a_file_brings_along_cannot_leave_its_element() {
        assert_eq!(escape("<b a='1'>&\"\u{1}"), "&lt;b a=&#39;1&#39;&gt;&amp;&quot;\u{fffd}");
    }

    #[test]
    fn coordinates_are_short_and_always_numbers() {
        let text = |x| {
            let mut out = String::new();
            coordinate(&mut out, x);
            out
        };
        assert_eq!([1.25, -0.04, 30.0, -2.5].map(text), ["1.3", "0", "30", "-2.5"]);
        assert_eq!([f64::NAN, f64::INFINITY].map(text), ["0", "100000"]);
    }
}
