//! The header of a NumPy array: a Python dictionary written out.

use crate::bytes::Bytes;
use crate::error::RecordingError;

/// Brackets inside brackets.
const LITERAL_DEPTH_MAX: usize = 16;
const CURE: &str = "write the file again with numpy.save or numpy.savez";

/// A value of Python.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Literal {
    Text(String),
    Number(u64),
    Truth(bool),
    /// A tuple or a list.
    List(Vec<Literal>),
    Dictionary(Vec<(Literal, Literal)>),
}

impl Literal {
    /// The value of a key of a dictionary.
    pub fn get(&self, key: &str) -> Option<&Literal> {
        let Literal::Dictionary(pairs) = self else { return None };
        pairs.iter().find(|(name, _)| name.text() == Some(key)).map(|(_, value)| value)
    }

    pub fn text(&self) -> Option<&str> {
        if let Literal::Text(text) = self { Some(text) } else { None }
    }

    pub fn list(&self) -> Option<&[Literal]> {
        if let Literal::List(list) = self { Some(list) } else { None }
    }

    /// The numbers of a tuple, or one number alone.
    pub fn numbers(&self) -> Option<Vec<usize>> {
        let number = |literal: &Literal| match literal {
            Literal::Number(number) => usize::try_from(*number).ok(),
            _ => None,
        };
        match self {
            Literal::List(list) => list.iter().map(number).collect(),
            other => number(other).map(|number| vec![number]),
        }
    }
}

/// The one value that `bytes` are.
///
/// # Errors
/// Anything else than text, whole numbers, truths, tuples, lists and dictionaries of those.
pub(crate) fn read(bytes: &mut Bytes<'_>) -> Result<Literal, RecordingError> {
    value(bytes, LITERAL_DEPTH_MAX)
}

/// The next byte that is no blank, not taken.
fn next(bytes: &mut Bytes<'_>) -> Result<u8, RecordingError> {
    loop {
        let byte = bytes.clone().u8("the header")?;
        if !byte.is_ascii_whitespace() {
            return Ok(byte);
        }
        bytes.take(1, "a blank")?;
    }
}

fn value(bytes: &mut Bytes<'_>, depth: usize) -> Result<Literal, RecordingError> {
    if depth == 0 {
        return Err(bytes.error(format!("the header has more than {LITERAL_DEPTH_MAX} brackets in brackets"), CURE));
    }
    match next(bytes)? {
        quote @ (b'\'' | b'"') => text(bytes, quote),
        b'(' => list(bytes, b')', depth),
        b'[' => list(bytes, b']', depth),
        b'{' => dictionary(bytes, depth),
        first if first.is_ascii_alphanumeric() => word(bytes),
        other => Err(unexpected(bytes, other)),
    }
}

fn unexpected(bytes: &Bytes<'_>, found: u8) -> RecordingError {
    bytes.error(format!("`{}` stands in the header where a value is due", char::from(found).escape_default()), CURE)
}

fn text(bytes: &mut Bytes<'_>, quote: u8) -> Result<Literal, RecordingError> {
    bytes.take(1, "a quote")?;
    let mut text = Vec::new();
    loop {
        match bytes.u8("a text of the header")? {
            byte if byte == quote => return Ok(Literal::Text(String::from_utf8_lossy(&text).into_owned())),
            b'\\' => text.push(bytes.u8("a text of the header")?),
            byte => text.push(byte),
        }
    }
}

fn word(bytes: &mut Bytes<'_>) -> Result<Literal, RecordingError> {
    let mut word = String::new();
    while bytes.left() > 0 && next_is_alphanumeric(bytes) {
        word.push(char::from(bytes.u8("a word of the header")?));
    }
    match word.as_str() {
        "True" => Ok(Literal::Truth(true)),
        "False" => Ok(Literal::Truth(false)),
        // Python 2 wrote lengths with an `L` behind.
        number => number
            .trim_end_matches('L')
            .parse()
            .map(Literal::Number)
            .map_err(|_| bytes.error(format!("`{word}` stands in the header"), CURE)),
    }
}

fn next_is_alphanumeric(bytes: &Bytes<'_>) -> bool {
    bytes.clone().try_take(1).is_some_and(|byte| byte[0].is_ascii_alphanumeric())
}

fn list(bytes: &mut Bytes<'_>, close: u8, depth: usize) -> Result<Literal, RecordingError> {
    bytes.take(1, "a bracket")?;
    let mut list = Vec::new();
    while next(bytes)? != close {
        list.push(value(bytes, depth - 1)?);
        comma(bytes, close)?;
    }
    bytes.take(1, "a bracket")?;
    Ok(Literal::List(list))
}

fn dictionary(bytes: &mut Bytes<'_>, depth: usize) -> Result<Literal, RecordingError> {
    bytes.take(1, "a bracket")?;
    let mut pairs = Vec::new();
    while next(bytes)? != b'}' {
        let key = value(bytes, depth - 1)?;
        let colon = next(bytes)?;
        if colon != b':' {
            return Err(unexpected(bytes, colon));
        }
        bytes.take(1, "a colon")?;
        pairs.push((key, value(bytes, depth - 1)?));
        comma(bytes, b'}')?;
    }
    bytes.take(1, "a bracket")?;
    Ok(Literal::Dictionary(pairs))
}

fn comma(bytes: &mut Bytes<'_>, close: u8) -> Result<(), RecordingError> {
    match next(bytes)? {
        b',' => bytes.take(1, "a comma").map(|_| ()),
        byte if byte == close => Ok(()),
        other => Err(unexpected(bytes, other)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Literal, RecordingError> {
        read(&mut Bytes::new("file", "", text.as_bytes()))
    }

    #[test]
    fn the_header_of_an_array_is_read() {
        let header =
            parsed("{'descr': [('t', '<f8'), ('x', '<f4', (3,))], 'fortran_order': False, 'shape': (20L, 3), }")
                .unwrap();
        assert_eq!(header.get("shape").unwrap().numbers(), Some(vec![20, 3]));
        assert_eq!(header.get("fortran_order"), Some(&Literal::Truth(false)));
        let fields = header.get("descr").unwrap().list().unwrap();
        assert_eq!(fields[1].list().unwrap()[2].numbers(), Some(vec![3]));
    }

    #[test]
    fn what_is_no_dictionary_is_an_error_with_its_place() {
        for text in ["", "{", "{'a' 1}", "(1 2)", "nan", "{'a': 'b", "-1", &"(".repeat(40)] {
            let error = parsed(text).unwrap_err().explain();
            assert!(error.starts_with("file: byte ") && error.contains("cure: "), "{text}: {error}");
        }
    }
}
