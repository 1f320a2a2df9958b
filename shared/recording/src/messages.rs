//! Messages of other programs: from bytes and a schema to the numbers of one row.

mod definition;
mod json;
pub(crate) mod json_file;
mod json_list;
mod json_survey;
mod json_tokens;
mod left_out;
mod protobuf;
mod ros;
mod rows;
mod standard;
mod standard_units;

pub(crate) use rows::{Rows, STAMPS_NS};

use definition::{Dialect, Layouts};
use protobuf::Messages;

/// How a schema describes messages.
pub(crate) struct Schema<'a> {
    pub name: &'a str,
    pub encoding: &'a str,
    pub text: &'a [u8],
}

/// Reads the messages of one channel.
pub(crate) enum Decoder {
    Json(json::Units),
    Ros1(Layouts),
    Cdr(Layouts),
    Protobuf(Messages),
    /// Why nothing is read of this channel.
    Unreadable(String),
}

impl Decoder {
    /// The decoder of messages of `encoding` that `schema` describes.
    pub fn new(encoding: &str, schema: &Schema<'_>) -> Self {
        let made = match (encoding, schema.encoding) {
            ("json", _) => Ok(Decoder::Json(json::units(schema.text))),
            ("ros1", "ros1msg") => layouts(schema, Dialect::Ros1).map(Decoder::Ros1),
            ("cdr", "ros2msg" | "") => layouts(schema, Dialect::Ros2).map(Decoder::Cdr),
            ("protobuf", "protobuf") => Messages::new(schema.name, schema.text).map(Decoder::Protobuf),
            (encoding, described) => Err(format!(
                "messages in `{encoding}` with a schema in `{described}` are not read (json, ros1, cdr with ros2msg \
                 and protobuf are)"
            )),
        };
        made.unwrap_or_else(|reason| Decoder::Unreadable(format!("schema `{}`: {reason}", schema.name)))
    }

    /// Puts the numbers of one message into the row that `rows` has open.
    ///
    /// # Errors
    /// Why the message is not read.
    pub fn decode(&self, message: &[u8], rows: &mut Rows) -> Result<(), String> {
        match self {
            Decoder::Json(units) => json::decode(units, message, rows),
            Decoder::Ros1(layouts) => ros::decode_ros1(layouts, message, rows),
            Decoder::Cdr(layouts) => ros::decode_cdr(layouts, message, rows),
            Decoder::Protobuf(messages) => messages.decode(message, rows),
            Decoder::Unreadable(reason) => Err(reason.clone()),
        }
    }
}

fn layouts(schema: &Schema<'_>, dialect: Dialect) -> Result<Layouts, String> {
    let text = core::str::from_utf8(schema.text).map_err(|_| "the definition is not UTF-8".to_string())?;
    Layouts::new(schema.name, text, dialect)
}
