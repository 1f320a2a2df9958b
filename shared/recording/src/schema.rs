//! Schemas of recorded samples, as ROS 1 message text generated from the telemetry records.
//!
//! A padding-free little-endian `repr(C)` record of u16, u32, u64, f64, fixed arrays and nested
//! records is byte for byte its ROS 1 serialisation, so a recorded message is the stamps' bytes
//! followed by the sample's bytes, and any ROS 1 reader can decode it. Arrays of arrays appear
//! flat, row by row.

use core::fmt::Write;
use telemetry::{Estimate, FieldInfo, Header, IdentifiedMode, Innovation, Record, Stamps, TopicInfo};

// The identity of memory and wire holds on little-endian machines only.
const _: () = assert!(cfg!(target_endian = "little"), "recordings are written in the byte order of ROS 1");

/// Records that appear inside others.
const NESTED: [(&str, &[FieldInfo], usize); 5] = [
    (Stamps::NAME, Stamps::FIELDS, size_of::<Stamps>()),
    (Header::NAME, Header::FIELDS, size_of::<Header>()),
    (Estimate::NAME, Estimate::FIELDS, size_of::<Estimate>()),
    (Innovation::NAME, Innovation::FIELDS, size_of::<Innovation>()),
    (IdentifiedMode::NAME, IdentifiedMode::FIELDS, size_of::<IdentifiedMode>()),
];

/// A sample of one scalar channel; its unit stands in the channel's metadata under [`UNIT`].
pub(crate) const SCALAR_NAME: &str = "obsid_msgs/Scalar";
pub(crate) const SCALAR_TEXT: &str = "float64 value\n";
pub(crate) const UNIT: &str = "unit";

/// Name of the message that records samples of `topic`.
pub(crate) fn schema_name(topic: &TopicInfo) -> String {
    format!("obsid/Recorded{}", topic.record)
}

/// Message text: stamps, then the fields of the sample, then the nested definitions.
pub(crate) fn schema_text(topic: &TopicInfo) -> String {
    let mut text = String::from("obsid/Stamps stamps # transport: changes from run to run\n");
    let mut used = vec![Stamps::NAME];
    topic.fields.iter().for_each(|field| write_field(&mut text, field));
    note_records(topic.fields, &mut used);
    for (name, fields, _) in NESTED.iter().filter(|(name, ..)| used.contains(name)) {
        let _ = writeln!(text, "{}\nMSG: obsid/{name}", "=".repeat(80));
        fields.iter().for_each(|field| write_field(&mut text, field));
    }
    text
}

/// Adds the names of all records inside `fields`, and inside these.
fn note_records(fields: &[FieldInfo], used: &mut Vec<&'static str>) {
    for (name, inner, _) in NESTED.iter().filter(|(name, ..)| fields.iter().any(|field| field.ros == *name)) {
        if !used.contains(name) {
            used.push(name);
            note_records(inner, used);
        }
    }
}

fn write_field(text: &mut String, field: &FieldInfo) {
    let (ty, size) = match element_size(field.ros) {
        Some(size) => (field.ros.to_string(), size),
        None => (format!("obsid/{}", field.ros), nested_size(field.ros)),
    };
    // `length` is the outer one: rows of arrays count by their size.
    let array = if field.length == 0 { String::new() } else { format!("[{}]", field.size / size) };
    let _ = writeln!(text, "{ty}{array} {} # [{}] {}", field.name, field.unit, field.what);
}

fn element_size(ros: &str) -> Option<usize> {
    match ros {
        "uint16" => Some(2),
        "uint32" => Some(4),
        "uint64" | "float64" => Some(8),
        _ => None,
    }
}

fn nested_size(record: &str) -> usize {
    let nested = NESTED.iter().find(|(name, ..)| *name == record);
    nested.map(|(.., size)| *size).expect("every record inside a record is in NESTED: a test visits all topics")
}

#[cfg(test)]
mod tests {
    use super::*;
    use telemetry::TOPICS;

    /// Bytes that a ROS 1 reader would take for this text, by an independent reading of it.
    fn serialised_size(text: &str, message: &str) -> usize {
        let sections: Vec<&str> = text.split(&"=".repeat(80)).collect();
        let body = sections
            .iter()
            .find(|section| section.trim_start().starts_with(&format!("MSG: {message}")))
            .map_or(sections[0], |section| section.split_once("MSG:").unwrap().1.split_once('\n').unwrap().1);
        let size_of_line = |line: &str| {
            let ty = line.split_whitespace().next().unwrap();
            let (element, count) = match ty.strip_suffix(']').and_then(|rest| rest.split_once('[')) {
                Some((element, count)) => (element, count.parse().unwrap()),
                None => (ty, 1),
            };
            count * element_size(element).unwrap_or_else(|| serialised_size(text, element))
        };
        body.lines().filter(|line| !line.trim().is_empty()).map(size_of_line).sum()
    }

    #[test]
    fn every_schema_describes_exactly_the_bytes_of_stamps_and_sample() {
        for topic in TOPICS {
            let text = schema_text(topic);
            assert_eq!(serialised_size(&text, "-"), 16 + topic.size, "{}\n{text}", topic.name);
        }
    }
}
