//! `obsid icd`: the interface control document, generated from the samples themselves.

mod c_header;

use crate::{Failure, print};
use serde_json::{Value, json};
use std::fmt::Write;
use supervisor::mode::Event as ModeEvent;
use telemetry::{
    CODE_LISTS, Domain, Estimate, EventCode, FieldInfo, Header, IdentifiedMode, Innovation, PartitionId, Reason,
    Record, Stamps, TOPICS, TableId, TopicInfo,
};

/// The interface control document: every topic, field, unit and frame
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid icd                             the table of topics
  obsid icd --json > deploy/icd.json    the committed document
  obsid icd --md                        every field of every topic
  obsid icd --c-header > obsid.h        every sample as a C structure, for drivers (see obsid gateway)")]
pub struct Arguments {
    /// As JSON (what deploy/icd.json holds)
    #[arg(long, conflicts_with = "md")]
    json: bool,
    /// As Markdown
    #[arg(long)]
    md: bool,
    /// As a C header, with sizes and offsets asserted
    #[arg(long, conflicts_with_all = ["json", "md"])]
    c_header: bool,
}

/// Prints the interface control document: a table of topics, Markdown, JSON or a C header.
///
/// # Errors
/// None: the text is compiled into the program.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let text = if arguments.json {
        json_text()
    } else if arguments.md {
        markdown()
    } else if arguments.c_header {
        c_header::text()
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
        "records": [record::<Header>(), record::<Estimate>(), record::<Innovation>(), record::<IdentifiedMode>()],
        "topics": TOPICS.iter().map(topic).collect::<Vec<_>>(),
        "parameters": Domain::ALL.iter().map(|domain| parameters(*domain)).collect::<Vec<_>>(),
        "codes": code_lists().iter().map(CodeTable::json).collect::<Vec<_>>(),
        "events": EventCode::ALL.iter().map(|code| event(*code)).collect::<Vec<_>>(),
        "tables": TableId::ALL.iter().map(|id| table(*id)).collect::<Vec<_>>(),
        "between_computers": between_computers(),
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

/// What `obsid bridge` carries, and what a consumer of a mirror can rely on.
fn between_computers() -> Value {
    let carried = TOPICS.iter().enumerate().filter(|(topic, _)| telemetry::is_carried(*topic));
    json!({
        "topics": carried.map(|(_, info)| info.name).collect::<Vec<_>>(),
        "sample": "as on the computer of its producer: header, body, epoch and CRC-32; sent_ns is this computer's",
        "order": "of one topic and source: once each, by header.seq",
        "lost": "losses.jsonl of the mirror: topic, partition, from, to (header.seq), what",
        "commands": "datagrams to supervisor/ground of the mirror reach the port of the run",
    })
}

fn parameters(domain: Domain) -> Value {
    let rows = telemetry::parameters(domain).iter();
    let rows = rows.map(|row| json!({ "name": row.name, "unit": row.unit, "what": row.what }));
    json!({ "domain": domain.text(), "parameters": rows.collect::<Vec<_>>() })
}

fn event(code: EventCode) -> Value {
    let argument = |info: &telemetry::ArgumentInfo| json!({ "name": info.name, "unit": info.unit, "codes": info.codes.map(|list| list.name) });
    json!({
        "code": code.code(), "text": code.text(), "severity": code.severity().text(),
        "arguments": code.arguments().iter().map(argument).collect::<Vec<_>>(),
    })
}

/// A parameter table: whose it is, its fields with their ranges.
#[must_use]
pub fn table(id: TableId) -> Value {
    let field = |field: &telemetry::TableField| {
        json!({
            "name": field.name, "unit": field.unit, "lowest": field.lowest, "highest": field.highest,
            "whole": field.whole, "what": field.what,
        })
    };
    let partitions: Vec<&str> = PartitionId::ALL.iter().filter(|own| id.is_of(**own)).map(|own| own.text()).collect();
    json!({
        "code": id.code(), "table": id.text(), "partitions": partitions,
        "fields": id.fields().iter().map(field).collect::<Vec<_>>(),
    })
}

/// Every event with severity and arguments, as JSON or as lines.
#[must_use]
pub fn event_list(as_json: bool) -> String {
    if as_json {
        let codes: Vec<Value> = EventCode::ALL.iter().map(|code| event(*code)).collect();
        return format!("{}\n", json!({ "events": codes }));
    }
    let line = |code: &EventCode| {
        let arguments: Vec<&str> = code.arguments().iter().map(|info| info.name).collect();
        format!("{:>3}  {:<11} {}: {}\n", code.code(), code.severity(), code.text(), arguments.join(", "))
    };
    EventCode::ALL.iter().map(line).collect()
}

/// What the numbers of one field stand for.
struct CodeTable {
    name: &'static str,
    /// Code, text, and what `measured` and `limit` of the sample then are.
    rows: Vec<(u16, &'static str, Option<&'static str>)>,
}

impl CodeTable {
    fn json(&self) -> Value {
        let row = |&(code, text, figures): &(u16, &str, Option<&str>)| {
            let mut row = json!({ "code": code, "text": text });
            if let Some(figures) = figures {
                row["measured_and_limit"] = json!(figures);
            }
            row
        };
        json!({ "name": self.name, "codes": self.rows.iter().map(row).collect::<Vec<_>>() })
    }
}

fn code_lists() -> Vec<CodeTable> {
    let figures = |list: &str, code| (list == "Reason").then(|| Reason::from_code(code).map(Reason::figures)).flatten();
    let table = |list: &telemetry::CodeList| CodeTable {
        name: list.name,
        rows: list.codes.iter().map(|&(code, text)| (code, text, figures(list.name, code))).collect(),
    };
    let events = ModeEvent::ALL.iter().map(|event| (event.code(), event.text(), Some(event.figures())));
    let modes = CodeTable { name: "ModeEvent", rows: events.collect() };
    CODE_LISTS.iter().map(table).chain([modes]).collect()
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

/// The guide's topic table.
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
        let (name, record) = (info.name, info.record);
        let _ = writeln!(text, "\n## `{name}`: {record} ({} bytes, layout {:08x})\n", info.size, info.layout);
        field_table(&mut text, info.fields);
    }
    record_section::<Header>(&mut text);
    record_section::<Estimate>(&mut text);
    record_section::<Innovation>(&mut text);
    record_section::<IdentifiedMode>(&mut text);
    for &domain in Domain::ALL {
        let _ = writeln!(text, "\n## Parameters: {domain}\n\n| name | unit | what |\n|---|---|---|");
        for row in telemetry::parameters(domain) {
            let _ = writeln!(text, "| `{}` | {} | {} |", row.name, row.unit, row.what);
        }
    }
    for table in code_lists() {
        let has_figures = table.rows.iter().any(|row| row.2.is_some());
        let (head, rule) = if has_figures { (" measured and limit |", "---|") } else { ("", "") };
        let _ = writeln!(text, "\n## Codes: {}\n\n| code | text |{head}\n|---|---|{rule}", table.name);
        for (code, words, figures) in table.rows {
            let figures = figures.map(|figures| format!(" {figures} |")).unwrap_or_default();
            let _ = writeln!(text, "| {code} | {words} |{figures}");
        }
    }
    let _ = writeln!(text, "\n## Events\n\n```\n{}```", event_list(false));
    for id in TableId::ALL {
        table_section(&mut text, *id);
    }
    text
}

fn table_section(text: &mut String, id: TableId) {
    let head = "| field | unit | lowest | highest | what |\n|---|---|---|---|---|";
    let _ = writeln!(text, "\n## Parameter table: {id}\n\n{head}");
    for field in id.fields() {
        let (name, unit, lowest, highest) = (field.name, field.unit, field.lowest, field.highest);
        let _ = writeln!(text, "| `{name}` | {unit} | {lowest} | {highest} | {} |", field.what);
    }
}

/// A record that stands inside others.
fn record_section<T: Record>(text: &mut String) {
    let _ = writeln!(text, "\n## Record {} ({} bytes, layout {:08x})\n", T::NAME, size_of::<T>(), T::HASH);
    field_table(text, T::FIELDS);
}

fn field_table(text: &mut String, fields: &[FieldInfo]) {
    text.push_str("| offset | field | type | unit | frame | what |\n|---|---|---|---|---|---|\n");
    for field in fields {
        let (offset, name, ty) = (field.offset, field.name, type_text(field));
        let _ = writeln!(text, "| {offset} | `{name}` | {ty} | {} | {} | {} |", field.unit, field.frame, field.what);
    }
}
