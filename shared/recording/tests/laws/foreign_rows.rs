//! Rows of foreign topics: which time they have, their order, their columns and units.

use crate::foreign_messages::named;
use crate::scratch;
use recording::RawDataset;
use recording::foreign::mcap_datasets;
use std::collections::BTreeMap;
use std::fs::File;

/// What a channel is: topic, encoding of messages, name, encoding and text of the schema.
pub type Described<'a> = (&'a str, &'a str, &'a str, &'a str, &'a str);

/// Writes messages (channel, time of logging, bytes) as an MCAP file without chunks.
pub fn written(name: &str, channels: &[Described<'_>], messages: &[(usize, u64, Vec<u8>)]) -> std::path::PathBuf {
    let path = scratch(name);
    let mut writer = mcap::WriteOptions::new().use_chunks(false).create(File::create(&path).unwrap()).unwrap();
    let mut ids = Vec::new();
    for (topic, encoding, schema, described, text) in channels {
        let schema = writer.add_schema(schema, described, text.as_bytes()).unwrap();
        // A number of its own for every channel, also of one topic.
        let facts = BTreeMap::from([("number".to_string(), ids.len().to_string())]);
        ids.push(writer.add_channel(schema, topic, encoding, &facts).unwrap());
    }
    for (channel, log_time, data) in messages {
        let header = mcap::records::MessageHeader {
            channel_id: ids[*channel],
            sequence: 0,
            log_time: *log_time,
            publish_time: 0,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
    path
}

pub fn read(name: &str, channels: &[Described<'_>], messages: &[(usize, u64, Vec<u8>)]) -> Vec<RawDataset> {
    mcap_datasets(&written(name, channels, messages), &|_| true).unwrap_or_else(|error| panic!("{}", error.explain()))
}

const JSON: Described<'_> = ("/t", "json", "t", "jsonschema", "");
const TEMPERATURE: Described<'_> =
    ("/t", "ros1", "sensor_msgs/Temperature", "ros1msg", "Header header\nfloat64 temperature\nfloat64 variance\n");

fn json(log_s: u64, text: &str) -> (usize, u64, Vec<u8>) {
    (0, log_s * 1_000_000_000, text.as_bytes().to_vec())
}

/// A temperature with a stamp of `stamp_s`, logged at `log_s`.
fn temperature(stamp_s: u32, log_s: u64, value: f64) -> (usize, u64, Vec<u8>) {
    let mut bytes = Vec::new();
    for word in [7, stamp_s, 500_000_000, 0] {
        bytes.extend_from_slice(&u32::to_le_bytes(word));
    }
    bytes.extend_from_slice(&value.to_le_bytes());
    bytes.extend_from_slice(&0_f64.to_le_bytes());
    (0, log_s * 1_000_000_000, bytes)
}

#[test]
fn stamps_that_increase_are_the_time() {
    let found = read("stamps.mcap", &[TEMPERATURE], &[temperature(1, 90, 20.0), temperature(3, 91, 21.0)]);
    let columns = &named(&found, "/t").columns;
    assert_eq!((columns[0].name.as_str(), columns[0].values.as_slice()), ("header.stamp", [1.5, 3.5].as_slice()));
    assert_eq!(columns[1].unit.as_deref(), Some("degC"));
}

#[test]
fn stamps_that_do_not_increase_or_are_zero_give_way_to_the_time_of_logging() {
    let mut zero = temperature(0, 91, 21.0);
    zero.2[8..12].copy_from_slice(&[0; 4]);
    for (second, reason) in [(temperature(1, 91, 21.0), "not increasing"), (zero, "missing or 0")] {
        let found = read("no-stamps.mcap", &[TEMPERATURE], &[temperature(1, 90, 20.0), second]);
        let dataset = named(&found, "/t");
        assert_eq!(dataset.columns[0].name, "log_time");
        assert_eq!(dataset.columns[0].values, [90.0, 91.0]);
        assert!(dataset.notes[0].contains(reason) && dataset.notes[0].contains("header.stamp"), "{:?}", dataset.notes);
    }
}

#[test]
fn messages_are_put_in_the_order_of_their_time_of_logging() {
    let messages = [json(3, r#"{"a": 3}"#), json(1, r#"{"a": 1, "b": 5}"#), json(2, r#"{"a": 2}"#)];
    let found = read("order.mcap", &[JSON], &messages);
    let columns = &named(&found, "/t").columns;
    assert_eq!(columns[0].values, [1.0, 2.0, 3.0]);
    assert_eq!(columns[1].values, [1.0, 2.0, 3.0]);
    assert_eq!(columns[2].values[0], 5.0);
    assert!(columns[2].values[1..].iter().all(|value| value.is_nan()));
}

#[test]
fn channels_of_one_topic_are_one_dataset() {
    let messages = [json(1, r#"{"a": 1}"#), (1, 2_000_000_000, br#"{"a": 2}"#.to_vec())];
    let found = read("two-channels.mcap", &[JSON, JSON], &messages);
    assert_eq!((found.len(), found[0].rows()), (1, 2));
}

#[test]
fn a_message_that_is_not_read_leaves_nothing_behind_but_a_note() {
    let messages = [json(1, r#"{"a": 1}"#), json(2, r#"{"a": 2, "b": ["#), json(3, r#"{"a": 3}"#)];
    let found = read("broken-json.mcap", &[JSON], &messages);
    assert_eq!(found[0].columns.len(), 2);
    assert_eq!(found[0].columns[1].values, [1.0, 3.0]);
    assert!(found[0].notes[0].starts_with("1 messages are not read; the first: EOF"), "{:?}", found[0].notes);
}

#[test]
fn joints_that_two_programs_publish_are_columns_of_their_own() {
    let text = "string[] name\nfloat64[] position\n";
    let message = |log_s: u64, name: &str, position: f64| {
        let mut bytes = 1_u32.to_le_bytes().to_vec();
        bytes.extend_from_slice(&(name.len() as u32).to_le_bytes());
        bytes.extend_from_slice(name.as_bytes());
        bytes.extend_from_slice(&1_u32.to_le_bytes());
        bytes.extend_from_slice(&position.to_le_bytes());
        (0, log_s * 1_000_000_000, bytes)
    };
    let messages = [message(1, "arm", 0.1), message(2, "wheel", 0.2), message(3, "arm", 0.3)];
    let found = read("joints.mcap", &[("/j", "ros1", "own/Joints", "ros1msg", text)], &messages);
    let columns = &found[0].columns;
    assert_eq!((columns[1].name.as_str(), columns[2].name.as_str()), ("position.arm", "position.wheel"));
    assert_eq!((columns[1].values[0], columns[1].values[2], columns[2].values[1]), (0.1, 0.3, 0.2));
    assert!(columns[1].values[1].is_nan() && columns[2].values[0].is_nan());
}

#[test]
fn units_come_from_the_standard_from_comments_and_from_json_schemas() {
    let separator = "=".repeat(80);
    let text = format!(
        "uint8 MODE=3 # [m]\nfloat64 rate # body rate [rad/s]\ngeometry_msgs/Wrench load # no unit here\n{separator}\n\
         MSG: geometry_msgs/Wrench\nVector3 force\nVector3 torque\n{separator}\nMSG: geometry_msgs/Vector3\n\
         float64 x\nfloat64 y\nfloat64 z\n"
    );
    let bytes: Vec<u8> = (0..7).flat_map(|value| f64::from(value).to_le_bytes()).collect();
    let schema = r#"{"type": "object", "properties": {"v": {"type": "number", "description": "speed [m/s]"},
        "w": {"type": "array", "items": {"type": "number", "unit": "rad"}}, "n": {"type": "number"}}}"#;
    let found = read(
        "units.mcap",
        &[("/ros", "ros1", "own/Load", "ros1msg", &text), ("/json", "json", "own", "jsonschema", schema)],
        &[(0, 1, bytes), (1, 1, br#"{"v": 1, "w": [1, 2], "n": 3}"#.to_vec())],
    );
    let units = |name: &str| -> Vec<(String, Option<String>)> {
        named(&found, name).columns[1..].iter().map(|column| (column.name.clone(), column.unit.clone())).collect()
    };
    let said = |name: &str, unit: &str| (name.to_string(), Some(unit.to_string()));
    let ros = units("/ros");
    assert_eq!(ros[0], said("rate", "rad/s"));
    assert_eq!(ros[1], said("load.force.x", "N"));
    assert_eq!(ros[6], said("load.torque.z", "N*m"));
    let json = units("/json");
    assert_eq!(json, [said("v", "m/s"), said("w[0]", "rad"), said("w[1]", "rad"), ("n".to_string(), None)]);
}
