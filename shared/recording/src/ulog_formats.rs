//! The messages that a PX4 log defines, laid out as fields of numbers.

use crate::numbers::Number;
use std::collections::BTreeMap;

/// Messages inside messages.
const FORMAT_DEPTH_MAX: usize = 8;
/// Fields of a message, those of the messages in it included.
const FORMAT_FIELDS_MAX: usize = 2048;
/// Parts of a message that are looked at, those without bytes included.
const STEPS_MAX: usize = 20_000;

/// A field of one number.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Field {
    /// `inner.field[2]`: with the names of messages around it and its index.
    pub name: String,
    pub number: Number,
    /// Of its first byte in the message.
    pub offset: usize,
}

/// A message as it is stored.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Layout {
    pub fields: Vec<Field>,
    /// Names of the fields of text.
    pub texts: Vec<String>,
    /// Bytes up to the end of the last field that is read; padding behind it is not always stored.
    pub needed: usize,
    bytes: usize,
    steps: usize,
}

/// Definitions by the name of the message: `type name;type[3] name;`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Formats(BTreeMap<String, String>);

impl Formats {
    /// Keeps a definition `message:type name;type name;`.
    pub fn define(&mut self, text: &str) {
        if let Some((name, fields)) = text.split_once(':') {
            self.0.entry(name.to_string()).or_insert_with(|| fields.to_string());
        }
    }

    /// The layout of a message.
    ///
    /// # Errors
    /// What cannot be laid out, in words.
    pub fn layout(&self, message: &str) -> Result<Layout, String> {
        let mut layout = Layout::default();
        self.lay_out(message, "", FORMAT_DEPTH_MAX, &mut layout)?;
        Ok(layout)
    }

    fn lay_out(&self, message: &str, prefix: &str, depth: usize, layout: &mut Layout) -> Result<(), String> {
        let fields = self.0.get(message).ok_or_else(|| format!("the message `{message}` is not defined"))?;
        if depth == 0 {
            return Err(format!("`{message}` has more than {FORMAT_DEPTH_MAX} messages in messages"));
        }
        for field in fields.split(';').filter(|field| !field.is_empty()) {
            let (kind, name) = field.split_once(' ').ok_or_else(|| format!("`{field}` is no field"))?;
            let (kind, count) = split_count(kind).ok_or_else(|| format!("`{field}` has no length"))?;
            if kind == "char" {
                layout.texts.push(format!("{prefix}{name}"));
                layout.skip(count.unwrap_or(1))?;
                continue;
            }
            if name.starts_with("_padding") {
                layout.skip(count.unwrap_or(1))?;
                continue;
            }
            for place in 0..count.unwrap_or(1) {
                let index = count.map_or(String::new(), |_| format!("[{place}]"));
                let name = format!("{prefix}{name}{index}");
                match number(kind) {
                    Some(number) => layout.add(name, number)?,
                    None => self.lay_out(kind, &format!("{name}."), depth - 1, layout)?,
                }
                // Counts the messages that have no numbers too.
                layout.skip(0)?;
            }
        }
        Ok(())
    }
}

impl Layout {
    fn add(&mut self, name: String, number: Number) -> Result<(), String> {
        self.fields.push(Field { name, number, offset: self.bytes });
        self.skip(number.width())?;
        self.needed = self.bytes;
        Ok(())
    }

    /// A message has at most 65535 bytes.
    fn skip(&mut self, bytes: usize) -> Result<(), String> {
        self.bytes = self.bytes.saturating_add(bytes);
        self.steps += 1;
        if self.steps > STEPS_MAX {
            return Err(format!("more than {STEPS_MAX} parts are defined"));
        }
        if self.fields.len() > FORMAT_FIELDS_MAX
            || self.texts.len() > FORMAT_FIELDS_MAX
            || self.bytes > usize::from(u16::MAX)
        {
            return Err(format!("more than {FORMAT_FIELDS_MAX} fields or 65535 bytes are defined"));
        }
        Ok(())
    }
}

/// `float[3]` as its type and its length.
fn split_count(kind: &str) -> Option<(&str, Option<usize>)> {
    let Some((kind, rest)) = kind.split_once('[') else { return Some((kind, None)) };
    let count: usize = rest.strip_suffix(']')?.parse().ok()?;
    (count <= usize::from(u16::MAX)).then_some((kind, Some(count)))
}

fn number(kind: &str) -> Option<Number> {
    Some(match kind {
        "int8_t" => Number::Signed(1),
        "uint8_t" | "bool" => Number::Unsigned(1),
        "int16_t" => Number::Signed(2),
        "uint16_t" => Number::Unsigned(2),
        "int32_t" => Number::Signed(4),
        "uint32_t" => Number::Unsigned(4),
        "int64_t" => Number::Signed(8),
        "uint64_t" => Number::Unsigned(8),
        "float" => Number::Float(4),
        "double" => Number::Float(8),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formats(lines: &[&str]) -> Formats {
        let mut formats = Formats::default();
        lines.iter().for_each(|line| formats.define(line));
        formats
    }

    #[test]
    fn fields_arrays_and_messages_in_messages_have_their_places() {
        let formats = formats(&["esc:uint8_t id;float rpm;", "all:uint64_t timestamp;esc[2] esc;char[3] text;_x;"]);
        assert!(formats.layout("all").is_err(), "`_x` has no type");
        let formats = self::formats(&[
            "esc:uint8_t id;float rpm;",
            "all:uint64_t timestamp;esc[2] esc;char[3] text;bool on;uint8_t[5] _padding0;",
        ]);
        let layout = formats.layout("all").unwrap();
        let fields: Vec<_> = layout.fields.iter().map(|field| (field.name.as_str(), field.offset)).collect();
        let expected = [("timestamp", 0), ("esc[0].id", 8), ("esc[0].rpm", 9), ("esc[1].id", 13), ("esc[1].rpm", 14)];
        assert_eq!(fields[..5], expected);
        assert_eq!(fields[5], ("on", 21));
        assert_eq!((layout.needed, layout.texts), (22, vec!["text".to_string()]));
    }

    #[test]
    fn definitions_without_end_are_errors() {
        for lines in [
            &["a:a inner;"][..],
            &["a:b[60000] x;", "b:b2[60000] x;", "b2:char[0] c;"],
            &["a:float[70000] x;"],
            &["a:uint8_t[5000] x;"],
            &["a:missing x;"],
        ] {
            assert!(formats(lines).layout("a").is_err(), "{lines:?}");
        }
    }
}
