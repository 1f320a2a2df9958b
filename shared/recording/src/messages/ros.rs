//! Messages of ROS 1, and of ROS 2 in CDR: bytes in the order of the definition.
//!
//! ROS 1 packs little-endian bytes. CDR (XCDR 1) begins with four bytes that say the byte order and
//! aligns every number to its size. Lengths are compared with the bytes that are left, and a
//! message may hold no more fields than its bytes allow.

use super::definition::{Count, Field, Kind, Layout, Layouts, Scalar};
use super::left_out::Reason;
use super::rows::{ELEMENTS_MAX, Rows, STAMPS_NS};

/// Arrays of text that name the elements of the arrays beside them.
const NAMES: [&str; 5] = ["name", "names", "joint_name", "joint_names", "interface_names"];
/// Bytes of a name of an element.
const ELEMENT_NAME_MAX: usize = 96;
/// Fields of a message: some, and some for every byte.
const ROS_STEPS: (usize, usize) = (1024, 16);

/// Puts the numbers of a ROS 1 message into the open row.
///
/// # Errors
/// Where the bytes do not fit the definition.
pub(crate) fn decode_ros1(layouts: &Layouts, message: &[u8], rows: &mut Rows) -> Result<(), String> {
    let input = Input { bytes: message, at: 0, is_big: false, is_cdr: false };
    decode(layouts, input, rows)
}

/// Puts the numbers of a message in CDR into the open row.
///
/// # Errors
/// Where the bytes do not fit the definition.
pub(crate) fn decode_cdr(layouts: &Layouts, message: &[u8], rows: &mut Rows) -> Result<(), String> {
    let Some((head, bytes)) = message.split_first_chunk::<4>() else {
        return Err(format!("{} bytes are no CDR", message.len()));
    };
    let is_big = match head {
        [0, 0, ..] => true,
        [0, 1, ..] => false,
        [a, b, ..] => return Err(format!("the encapsulation {a:02x}{b:02x} is not plain CDR (0000, 0001)")),
    };
    decode(layouts, Input { bytes, at: 0, is_big, is_cdr: true }, rows)
}

fn decode(layouts: &Layouts, input: Input<'_>, rows: &mut Rows) -> Result<(), String> {
    let steps = ROS_STEPS.0 + input.bytes.len().saturating_mul(ROS_STEPS.1);
    let mut walk = Walk { layouts, input, rows, steps };
    let root = layouts.list.get(layouts.root).ok_or("the definition is empty")?;
    walk.message(root, &Around { is_shown: true, is_root: true, unit: None, names: &[] })
}

struct Input<'a> {
    bytes: &'a [u8],
    at: usize,
    is_big: bool,
    is_cdr: bool,
}

impl<'a> Input<'a> {
    fn slice(&mut self, length: usize) -> Result<&'a [u8], String> {
        let found = self.at.checked_add(length).and_then(|end| self.bytes.get(self.at..end));
        let found = found.ok_or_else(|| {
            format!("{length} bytes are needed at byte {} of a message of {}", self.at, self.bytes.len())
        })?;
        self.at += length;
        Ok(found)
    }

    fn align(&mut self, size: usize) {
        if self.is_cdr {
            self.at = self.at.next_multiple_of(size);
        }
    }

    /// The bytes of a number, the lowest first.
    fn word<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.align(N);
        let mut word = [0; N];
        word.copy_from_slice(self.slice(N)?);
        if self.is_big {
            word.reverse();
        }
        Ok(word)
    }

    fn scalar(&mut self, scalar: Scalar) -> Result<f64, String> {
        Ok(match scalar {
            Scalar::Bool => f64::from(u8::from(self.word::<1>()?[0] != 0)),
            Scalar::I8 => f64::from(i8::from_le_bytes(self.word()?)),
            Scalar::U8 => f64::from(u8::from_le_bytes(self.word()?)),
            Scalar::I16 => f64::from(i16::from_le_bytes(self.word()?)),
            Scalar::U16 => f64::from(u16::from_le_bytes(self.word()?)),
            Scalar::I32 => f64::from(i32::from_le_bytes(self.word()?)),
            Scalar::U32 => f64::from(u32::from_le_bytes(self.word()?)),
            Scalar::I64 => i64::from_le_bytes(self.word()?) as f64,
            Scalar::U64 => u64::from_le_bytes(self.word()?) as f64,
            Scalar::F32 => f64::from(f32::from_le_bytes(self.word()?)),
            Scalar::F64 => f64::from_le_bytes(self.word()?),
        })
    }

    fn length(&mut self) -> Result<usize, String> {
        let length = u32::from_le_bytes(self.word()?);
        usize::try_from(length).map_err(|_| format!("an array of {length} elements"))
    }

    fn text(&mut self) -> Result<&'a [u8], String> {
        let length = self.length()?;
        let bytes = self.slice(length)?;
        Ok(if self.is_cdr { bytes.strip_suffix(&[0]).unwrap_or(bytes) } else { bytes })
    }

    /// Seconds (unsigned in ROS 1) and nanoseconds of a time.
    fn time(&mut self) -> Result<(i64, u32), String> {
        let seconds: [u8; 4] = self.word()?;
        let seconds =
            if self.is_cdr { i64::from(i32::from_le_bytes(seconds)) } else { i64::from(u32::from_le_bytes(seconds)) };
        Ok((seconds, u32::from_le_bytes(self.word()?)))
    }

    fn duration(&mut self) -> Result<f64, String> {
        let seconds = i32::from_le_bytes(self.word()?);
        let nanoseconds = i32::from_le_bytes(self.word()?);
        Ok(f64::from(seconds) + f64::from(nanoseconds) / STAMPS_NS as f64)
    }
}

/// What holds for all inside a field.
#[derive(Clone, Copy)]
struct Around<'n> {
    /// Whether its numbers give columns.
    is_shown: bool,
    is_root: bool,
    unit: Option<&'static str>,
    /// Names of elements.
    names: &'n [String],
}

struct Walk<'a, 'r> {
    layouts: &'a Layouts,
    input: Input<'a>,
    rows: &'r mut Rows,
    steps: usize,
}

impl<'a> Walk<'a, '_> {
    fn step(&mut self) -> Result<(), String> {
        self.steps = self.steps.checked_sub(1).ok_or("it holds more fields than bytes")?;
        Ok(())
    }

    fn message(&mut self, layout: &'a Layout, around: &Around<'_>) -> Result<(), String> {
        if layout.fields.is_empty() && self.input.is_cdr {
            // A message without fields takes one byte in CDR.
            self.input.slice(1)?;
        }
        let mut own_names: Option<Vec<String>> = None;
        for field in &layout.fields {
            self.step()?;
            let names = own_names.as_deref().unwrap_or(around.names);
            let inside = Around { is_root: false, unit: field.unit.or(around.unit), names, ..*around };
            match field.kind {
                Kind::Message(index) if around.is_root && field.count == Count::One && self.is_header(index) => {
                    self.header(index)?;
                }
                Kind::Text if field.count == Count::Variable && NAMES.contains(&field.name.as_str()) => {
                    own_names = Some(self.names()?);
                }
                _ => self.field(field, &inside)?,
            }
        }
        Ok(())
    }

    fn is_header(&self, index: usize) -> bool {
        self.layouts.list.get(index).is_some_and(|layout| layout.is_header)
    }

    /// The header of the whole message: its stamp is the time of the row.
    fn header(&mut self, index: usize) -> Result<(), String> {
        let layouts = self.layouts;
        for field in &layouts.list[index].fields {
            if field.kind == Kind::Time && field.count == Count::One {
                let (seconds, nanoseconds) = self.input.time()?;
                // A time before 1970 is not one that a clock gave.
                let whole = u64::try_from(seconds).unwrap_or(0).saturating_mul(STAMPS_NS);
                self.rows.stamp("header.stamp", whole.saturating_add(u64::from(nanoseconds)));
            } else {
                self.field(field, &Around { is_shown: false, is_root: false, unit: None, names: &[] })?;
            }
        }
        Ok(())
    }

    /// Names of elements; empty when they do not name each element as one of its own.
    fn names(&mut self) -> Result<Vec<String>, String> {
        let length = self.input.length()?;
        let mut names = Vec::new();
        for index in 0..length {
            self.step()?;
            let text = self.input.text()?;
            if index < ELEMENTS_MAX && text.len() <= ELEMENT_NAME_MAX {
                names.push(String::from_utf8_lossy(text).into_owned());
            }
        }
        let is_ambiguous = (1..names.len()).any(|index| names[..index].contains(&names[index]));
        if names.len() < length || is_ambiguous || names.iter().any(String::is_empty) {
            names.clear();
        }
        Ok(names)
    }

    fn field(&mut self, field: &'a Field, inside: &Around<'_>) -> Result<(), String> {
        let mark = self.rows.enter(&field.name);
        match field.count {
            Count::One => self.value(field.kind, inside)?,
            Count::Fixed(length) => self.array(field.kind, length, false, inside)?,
            Count::Variable => {
                let length = self.input.length()?;
                self.array(field.kind, length, true, inside)?;
            }
        }
        self.rows.leave(mark);
        Ok(())
    }

    fn value(&mut self, kind: Kind, inside: &Around<'_>) -> Result<(), String> {
        let (value, unit) = match kind {
            Kind::Scalar(scalar) => (self.input.scalar(scalar)?, inside.unit),
            Kind::Duration => (self.input.duration()?, Some("s")),
            Kind::Time => {
                let (seconds, nanoseconds) = self.input.time()?;
                (seconds as f64 + f64::from(nanoseconds) / STAMPS_NS as f64, Some("s"))
            }
            Kind::Text => {
                self.input.text()?;
                if inside.is_shown {
                    self.rows.leave_out(Reason::Text);
                }
                return Ok(());
            }
            Kind::Message(index) => {
                let layout = self.layouts.list.get(index).ok_or("the definition is not complete")?;
                return self.message(layout, inside);
            }
        };
        if inside.is_shown {
            self.rows.number(value, unit);
        }
        Ok(())
    }

    fn array(&mut self, kind: Kind, length: usize, is_variable: bool, inside: &Around<'_>) -> Result<(), String> {
        if kind == Kind::Text {
            if inside.is_shown {
                self.rows.leave_out(Reason::Text);
            }
            return self.elements(kind, length, &Around { is_shown: false, ..*inside });
        }
        if inside.is_shown && is_variable && length > 0 && length == inside.names.len() {
            return self.named_elements(kind, inside);
        }
        let is_open = inside.is_shown && self.rows.open_array();
        if is_open && length <= ELEMENTS_MAX {
            self.elements(kind, length, inside)?;
        } else {
            self.elements(kind, length, &Around { is_shown: false, ..*inside })?;
        }
        if is_open {
            self.rows.close_array(length);
        }
        Ok(())
    }

    fn elements(&mut self, kind: Kind, length: usize, inside: &Around<'_>) -> Result<(), String> {
        if let (Kind::Scalar(scalar), false) = (kind, inside.is_shown) {
            if length > 0 {
                self.input.align(scalar.size());
                let bytes = length.checked_mul(scalar.size()).ok_or("an array longer than memory")?;
                self.input.slice(bytes)?;
            }
            return Ok(());
        }
        for index in 0..length {
            self.step()?;
            let mark = if inside.is_shown { Some(self.rows.enter_element(index)) } else { None };
            self.value(kind, inside)?;
            if let Some(mark) = mark {
                self.rows.leave(mark);
            }
        }
        Ok(())
    }

    fn named_elements(&mut self, kind: Kind, inside: &Around<'_>) -> Result<(), String> {
        for name in inside.names {
            self.step()?;
            let mark = self.rows.enter(name);
            self.value(kind, inside)?;
            self.rows.leave(mark);
        }
        Ok(())
    }
}
