//! Message definitions of ROS 1 and ROS 2 as text: fields, arrays, messages inside messages.
//!
//! A definition is the text of the message, then those of the messages inside, each behind a line
//! of `=` and a line `MSG: package/Name`. What is missing is looked up in the standard messages.

use super::standard;
use super::standard_units::unit_of;
use crate::units::unit_named;
use std::collections::HashMap;

/// Which of the two languages a definition is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dialect {
    Ros1,
    Ros2,
}

/// A number or truth value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scalar {
    Bool,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    /// Bytes of one.
    pub fn size(self) -> usize {
        match self {
            Scalar::Bool | Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::I64 | Scalar::U64 | Scalar::F64 => 8,
        }
    }
}

/// What a field holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Scalar(Scalar),
    Text,
    Time,
    Duration,
    /// The number of a layout.
    Message(usize),
}

/// How many a field holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Count {
    One,
    Fixed(usize),
    Variable,
}

/// A field of a message.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    pub name: String,
    pub kind: Kind,
    pub count: Count,
    pub unit: Option<&'static str>,
}

/// The fields of a message in their order.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub fields: Vec<Field>,
    pub is_header: bool,
    /// Messages inside messages below this one.
    depth: usize,
}

/// A message and all messages inside it.
#[derive(Clone, Debug)]
pub(crate) struct Layouts {
    pub list: Vec<Layout>,
    pub root: usize,
}

/// Messages inside messages.
const DEFINITION_DEPTH_MAX: usize = 32;
/// Fields of all messages of a definition.
const DEFINITION_FIELDS_MAX: usize = 1 << 16;
const SEPARATOR: &str = "=====";

impl Layouts {
    /// Reads the definition `text` of the message `name`.
    ///
    /// # Errors
    /// What of the definition is not understood.
    pub fn new(name: &str, text: &str, dialect: Dialect) -> Result<Self, String> {
        let root = without_msg(name);
        let mut parser =
            Parser { texts: texts(&root, text)?, dialect, made: HashMap::new(), list: Vec::new(), fields: 0 };
        let root = parser.message(&root, 0)?;
        Ok(Layouts { list: parser.list, root })
    }
}

/// The texts of all messages by their name.
fn texts(root: &str, text: &str) -> Result<HashMap<String, String>, String> {
    let mut texts: HashMap<String, String> = HashMap::new();
    let mut name = root.to_string();
    let mut is_named = true;
    for line in text.lines().map(str::trim) {
        if line.starts_with(SEPARATOR) {
            is_named = false;
        } else if let Some(found) = line.strip_prefix("MSG:") {
            name = without_msg(found.trim());
            is_named = true;
            texts.entry(name.clone()).or_default();
        } else if line.starts_with("IDL:") {
            return Err("the definition is in OMG IDL, which is not read".into());
        } else if is_named {
            let body = texts.entry(name.clone()).or_default();
            body.push_str(line);
            body.push('\n');
        }
    }
    Ok(texts)
}

struct Parser {
    texts: HashMap<String, String>,
    dialect: Dialect,
    /// `None` while it is being made.
    made: HashMap<String, Option<usize>>,
    list: Vec<Layout>,
    /// Fields of all of `list`.
    fields: usize,
}

impl Parser {
    fn message(&mut self, name: &str, depth: usize) -> Result<usize, String> {
        match self.made.get(name) {
            Some(Some(index)) => return Ok(*index),
            Some(None) => return Err(format!("`{name}` contains itself")),
            None if depth > DEFINITION_DEPTH_MAX => {
                return Err(format!("more than {DEFINITION_DEPTH_MAX} messages inside each other"));
            }
            None => {}
        }
        let text = match self.texts.get(name) {
            Some(text) => text.clone(),
            None => standard::definition(name, self.dialect)
                .ok_or_else(|| format!("the file does not define `{name}` and it is not a standard message"))?
                .to_string(),
        };
        self.made.insert(name.into(), None);
        let mut fields = Vec::new();
        for line in text.lines() {
            fields.extend(self.field(name, line, depth)?);
        }
        let inside = |field: &Field| match field.kind {
            Kind::Message(index) => self.list[index].depth + 1,
            _ => 0,
        };
        let height = fields.iter().map(inside).max().unwrap_or(0);
        if height > DEFINITION_DEPTH_MAX {
            return Err(format!("more than {DEFINITION_DEPTH_MAX} messages inside each other"));
        }
        self.fields += fields.len();
        if self.fields > DEFINITION_FIELDS_MAX {
            return Err(format!("more than {DEFINITION_FIELDS_MAX} fields"));
        }
        self.list.push(Layout { fields, is_header: name == "std_msgs/Header", depth: height });
        self.made.insert(name.into(), Some(self.list.len() - 1));
        Ok(self.list.len() - 1)
    }

    /// The field on a line; `None` for a constant or a comment.
    fn field(&mut self, message: &str, line: &str, depth: usize) -> Result<Option<Field>, String> {
        let (code, comment) = line.split_once('#').unwrap_or((line, ""));
        let mut words = code.split_whitespace();
        let (Some(kind), Some(name)) = (words.next(), words.next()) else {
            return match code.trim() {
                "" => Ok(None),
                other => Err(format!("`{message}`: the line `{}` is not a field", shown(other))),
            };
        };
        // `uint8 A=1`, `uint8 A = 1`: a constant; `float64 gain 1.0`: a default.
        if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
            return Ok(None);
        }
        let (kind, count) = counted(kind).ok_or_else(|| format!("`{}` is not a type", shown(kind)))?;
        let kind = match self.plain(kind) {
            Some(kind) => kind,
            None if kind == "wstring" => return Err(format!("`{message}` holds a wstring, which is not read")),
            None => Kind::Message(self.message(&self.full_name(message, kind), depth + 1)?),
        };
        let unit = unit_of(message, name).or_else(|| unit_in_brackets(comment));
        Ok(Some(Field { name: name.into(), kind, count, unit }))
    }

    fn plain(&self, kind: &str) -> Option<Kind> {
        let scalar = match (kind.split("<=").next().unwrap_or(kind), self.dialect) {
            ("bool", _) => Scalar::Bool,
            ("int8", _) | ("byte", Dialect::Ros1) => Scalar::I8,
            ("uint8" | "char", _) | ("byte", Dialect::Ros2) => Scalar::U8,
            ("int16", _) => Scalar::I16,
            ("uint16", _) => Scalar::U16,
            ("int32", _) => Scalar::I32,
            ("uint32", _) => Scalar::U32,
            ("int64", _) => Scalar::I64,
            ("uint64", _) => Scalar::U64,
            ("float32", _) => Scalar::F32,
            ("float64", _) => Scalar::F64,
            ("string", _) => return Some(Kind::Text),
            ("time", Dialect::Ros1) | ("builtin_interfaces/Time" | "builtin_interfaces/msg/Time", _) => {
                return Some(Kind::Time);
            }
            ("duration", Dialect::Ros1) | ("builtin_interfaces/Duration" | "builtin_interfaces/msg/Duration", _) => {
                return Some(Kind::Duration);
            }
            _ => return None,
        };
        Some(Kind::Scalar(scalar))
    }

    /// A type without a package is of the package of the message around it.
    fn full_name(&self, message: &str, kind: &str) -> String {
        if kind.contains('/') {
            return without_msg(kind);
        }
        let package = message.split_once('/').map_or("", |(package, _)| package);
        let sibling = format!("{package}/{kind}");
        if kind == "Header" && !self.texts.contains_key(&sibling) {
            return "std_msgs/Header".into();
        }
        sibling
    }
}

/// `package/msg/Name` and `package/Name` are the same message.
fn without_msg(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}

/// Splits `float64[9]`, `float64[]`, `float64[<=9]` into type and count.
fn counted(kind: &str) -> Option<(&str, Count)> {
    let Some((element, rest)) = kind.split_once('[') else {
        return Some((kind, Count::One));
    };
    let length = rest.strip_suffix(']')?;
    if length.is_empty() || length.starts_with("<=") {
        return Some((element, Count::Variable));
    }
    length.parse().ok().map(|length| (element, Count::Fixed(length)))
}

/// The unit in the brackets of a comment, as in `# body rate [rad/s]`.
pub(crate) fn unit_in_brackets(comment: &str) -> Option<&'static str> {
    let inside = comment.split('[').skip(1).filter_map(|rest| rest.split_once(']').map(|(inside, _)| inside));
    inside.filter(|text| !text.trim().is_empty()).find_map(unit_named).map(|unit| unit.symbol)
}

fn shown(text: &str) -> String {
    text.chars().take(60).collect()
}
