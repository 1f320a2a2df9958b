//! `obsid icd`: the interface control document, generated from the samples themselves.

use crate::{Failure, print};
use serde_json::{Value, json};
use std::fmt::Write;
use telemetry::{FieldInfo, Header, Innovation, Record, Stamps, TOPICS, TopicInfo};

/// The interface control document: every topic, field, unit and frame
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid icd                             the table of topics
  obsid icd --json > deploy/icd.json    the committed document
  obsid icd --md                        every field of every topic")]
pub struct Arguments {
    /// As JSON (what deploy/icd.json holds)
    #[arg(long, conflicts_with = "md")]
    json: bool,
    /// As Markdown
    #[arg(long)]
    md: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let text = if arguments.json {
        json_text()
    } else if arguments.md {
        markdown()
    } else {
        topic_table()
    };
    print(&text);
    Ok(())
}

/// The document as JSON; `deploy/icd.json` is this text.
#[must_use]
pub fn json_text() -> String {
    let document = json!({
        "format": 1,
        "byte_order": "little endian, no padding",
        "user_header": record::<Stamps>(),
        "records": [record::<Header>(), record::<Innovation>()],
        "topics": TOPICS.iter().map(topic).collect::<Vec<_>>(),
    });
    serde_json::to_string_pretty(&document).expect("text and numbers always serialise") + "\n"
}

fn record<T: Record>() -> Value {
    json!({ "name": T::NAME, "bytes": size_of::<T>(), "layout": format!("{:08x}", T::HASH), "fields": fields(T::FIELDS) })
}

fn topic(info: &TopicInfo) -> Value {
    json!({
        "topic": info.name,
        "record": info.record,
        "bytes": info.size,
        "layout": format!("{:08x}", info.layout),
        "depth": info.depth,
        "rate": info.rate,
        "producer": info.producers,
        "consumers": info.consumers,
        "fields": fields(info.fields),
    })
}

fn fields(fields: &[FieldInfo]) -> Vec<Value> {
    let row = |field: &FieldInfo| {
        json!({
            "field": field.name, "type": type_text(field), "unit": field.unit, "frame": field.frame,
            "offset": field.offset, "bytes": field.size, "what": field.what,
        })
    };
    fields.iter().map(row).collect()
}

fn type_text(field: &FieldInfo) -> String {
    if field.length == 0 { field.ros.to_string() } else { format!("{}[{}]", field.ros, field.length) }
}

/// The README's topic table.
#[must_use]
pub fn topic_table() -> String {
    let mut text = String::from(
        "| topic | sample | bytes | depth | rate | producer | consumers |\n|---|---|---|---|---|---|---|\n",
    );
    for info in TOPICS {
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} | {} | {} | {} |",
            info.name, info.record, info.size, info.depth, info.rate, info.producers, info.consumers
        );
    }
    text
}

fn markdown() -> String {
    let mut text = format!("# Interface control document\n\n{}", topic_table());
    for info in TOPICS {
        let _ =
            writeln!(text, "\n## `{}`: {} ({} bytes, layout {:08x})\n", info.name, info.record, info.size, info.layout);
        text.push_str("| offset | field | type | unit | frame | what |\n|---|---|---|---|---|---|\n");
        for field in info.fields {
            let _ = writeln!(
                text,
                "| {} | `{}` | {} | {} | {} | {} |",
                field.offset,
                field.name,
                type_text(field),
                field.unit,
                field.frame,
                field.what
            );
        }
    }
    text
}
