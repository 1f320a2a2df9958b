//! What many programs write as JSON although JSON has no such number: `NaN`, `Infinity`, `-inf`.

use std::borrow::Cow;

/// The text with `null` in place of every such word.
pub(crate) fn with_nulls(text: &[u8]) -> Cow<'_, [u8]> {
    let mut out: Option<Vec<u8>> = None;
    let (mut at, mut copied) = (0, 0);
    while at < text.len() {
        match text[at] {
            b'"' => at = end_of_text(text, at + 1),
            byte if is_of_word(byte) => {
                let length = text[at..].iter().position(|byte| !is_of_word(*byte)).unwrap_or(text.len() - at);
                if is_no_number(&text[at..at + length]) {
                    let out = out.get_or_insert_with(|| Vec::with_capacity(text.len() + text.len() / 8));
                    out.extend_from_slice(&text[copied..at]);
                    out.extend_from_slice(b"null");
                    copied = at + length;
                }
                at += length;
            }
            _ => at += 1,
        }
    }
    match out {
        None => Cow::Borrowed(text),
        Some(mut out) => {
            out.extend_from_slice(&text[copied..]);
            Cow::Owned(out)
        }
    }
}

fn is_of_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'-' | b'.')
}

fn is_no_number(word: &[u8]) -> bool {
    let word = word.strip_prefix(b"-").or(word.strip_prefix(b"+")).unwrap_or(word);
    [&b"nan"[..], b"inf", b"infinity"].iter().any(|none| word.eq_ignore_ascii_case(none))
}

/// The place behind the quote that ends a text.
fn end_of_text(text: &[u8], from: usize) -> usize {
    let mut at = from;
    while at < text.len() && text[at] != b'"' {
        at += if text[at] == b'\\' { 2 } else { 1 };
    }
    at + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_none_become_null_and_texts_stay() {
        let text = br#"{"a":NaN,"NaN":[-Infinity, inf,+INF],"b":"NaN\" -inf","c":-1e+5,"d":null,"e":true}"#;
        let expected = r#"{"a":null,"NaN":[null, null,null],"b":"NaN\" -inf","c":-1e+5,"d":null,"e":true}"#;
        assert_eq!(String::from_utf8_lossy(&with_nulls(text)), expected);
        for same in ["", "\"", "\"\\", "[1,2]", "nanx"] {
            assert!(matches!(with_nulls(same.as_bytes()), Cow::Borrowed(_)), "{same}");
        }
    }
}
