//! Foreign recordings that claim more than they hold: lengths, sizes, definitions without end.

use crate::foreign_messages::data;
use crate::foreign_rows::{Described, read, written};
use crate::scratch;
use recording::RecordingError;
use recording::foreign::{bag_datasets, mcap_datasets, rosbag2_datasets};
use std::path::Path;

/// The error of an MCAP file with one channel and one message.
fn refused(name: &str, channel: Described<'_>, message: &[u8]) -> String {
    let path = written(name, &[channel], &[(0, 1, message.to_vec())]);
    match mcap_datasets(&path, &|_| true) {
        Ok(found) => panic!("{name} is read: {found:?}"),
        Err(error) => {
            assert!(matches!(error, RecordingError::BadContainer { .. }), "{error}");
            error.explain()
        }
    }
}

fn ros1<'a>(text: &'a str) -> Described<'a> {
    ("/t", "ros1", "a/A", "ros1msg", text)
}

#[test]
fn an_array_longer_than_its_message_is_refused() {
    let explained = refused("long-array.mcap", ros1("float64[] x\n"), &u32::MAX.to_le_bytes());
    assert!(explained.contains("topic `/t`") && explained.contains("bytes are needed at byte 4"), "{explained}");
    refused("long-text.mcap", ros1("string[] name\n"), &u32::MAX.to_le_bytes());
    refused("long-messages.mcap", ros1("B[] b\n=====\nMSG: a/B\nuint8 X=1\n"), &u32::MAX.to_le_bytes());
    refused("long-fixed.mcap", ros1("B[4294967295] b\n=====\nMSG: a/B\nuint8 X=1\n"), &[]);
    refused("longest-fixed.mcap", ros1("float64[18446744073709551615] b\n"), &[]);
}

#[test]
fn definitions_without_end_are_refused() {
    let explained = refused("recursion.mcap", ros1("A a\n"), &[]);
    assert!(explained.contains("`a/A` contains itself"), "{explained}");
    let chain = |links: usize, twice: &str| -> String {
        (0..links)
            .map(|i| format!("L{} a\n{}=====\nMSG: a/L{0}\n", i + 1, twice.replace('#', &(i + 1).to_string())))
            .collect()
    };
    let deep = chain(1000, "");
    assert!(refused("deep.mcap", ros1(&deep), &[]).contains("more than 32 messages"), "{deep}");
    let wide = chain(30, "L# b\n");
    assert!(refused("wide.mcap", ros1(&wide), &[0; 8]).contains("more fields than bytes"));
}

#[test]
fn what_is_not_read_is_named() {
    let explained = refused("idl.mcap", ("/t", "cdr", "a/msg/A", "ros2idl", "module a {};"), &[0; 8]);
    assert!(explained.contains("`cdr`") && explained.contains("`ros2idl`"), "{explained}");
    let explained =
        refused("xcdr2.mcap", ("/t", "cdr", "std_msgs/msg/Float64", "ros2msg", "float64 data"), &[0, 7, 0, 0]);
    assert!(explained.contains("encapsulation 0007"), "{explained}");
    let explained = refused("unknown.mcap", ("/t", "cdr", "own_msgs/msg/State", "ros2msg", ""), &[0; 8]);
    assert!(explained.contains("does not define `own_msgs/State`"), "{explained}");
}

#[test]
fn objects_inside_objects_end_at_a_depth() {
    let deep = "[".repeat(100_000);
    let explained = refused("deep-json.mcap", ("/t", "json", "", "", ""), deep.as_bytes());
    assert!(explained.contains("recursion limit"), "{explained}");
}

#[test]
fn keys_that_never_repeat_do_not_make_a_table_of_nothing() {
    let messages: Vec<_> = (0..20_000).map(|k| (0, k, format!(r#"{{"always": 1, "k{k}": 2}}"#).into_bytes())).collect();
    let found = read("keys.mcap", &[("/t", "json", "", "", "")], &messages);
    let dataset = &found[0];
    assert_eq!(dataset.rows(), 20_000);
    assert!(dataset.columns.len() <= 17, "{}", dataset.columns.len());
    assert_eq!(dataset.columns[1].name, "always");
    assert!(dataset.notes[0].contains("few values"), "{:?}", dataset.notes);
}

/// An MCAP file with one chunk.
fn chunk(name: &str, compression: &str, stated: u64, packed: &[u8]) -> std::path::PathBuf {
    let mut body = [0; 16].to_vec();
    body.extend_from_slice(&stated.to_le_bytes());
    body.extend_from_slice(&0_u32.to_le_bytes());
    body.extend_from_slice(&(compression.len() as u32).to_le_bytes());
    body.extend_from_slice(compression.as_bytes());
    body.extend_from_slice(&(packed.len() as u64).to_le_bytes());
    body.extend_from_slice(packed);
    let mut file = mcap::MAGIC.to_vec();
    file.push(mcap::records::op::CHUNK);
    file.extend_from_slice(&(body.len() as u64).to_le_bytes());
    file.extend_from_slice(&body);
    let path = scratch(name);
    std::fs::write(&path, file).unwrap();
    path
}

fn explained(path: &Path) -> String {
    mcap_datasets(path, &|_| true).unwrap_err().explain()
}

#[test]
fn chunks_unpack_to_what_they_state_and_not_more() {
    let zeros = vec![0; 80 << 20];
    let zstd = zstd::encode_all(zeros.as_slice(), 1).unwrap();
    let mut lz4 = lz4_flex::frame::FrameEncoder::new(Vec::new());
    std::io::Write::write_all(&mut lz4, &zeros[..1 << 20]).unwrap();
    let lz4 = lz4.finish().unwrap();
    for (compression, packed) in [("zstd", &zstd), ("lz4", &lz4)] {
        let found = explained(&chunk("bomb-small.mcap", compression, 1000, packed));
        assert!(found.contains("a chunk of 1001 bytes states 1000"), "{found}");
        let found = explained(&chunk("bomb-large.mcap", compression, 1 << 40, packed));
        assert!(found.contains("state to unpack to 1099511627776"), "{found}");
    }
    let found = explained(&chunk("bomb-honest.mcap", "zstd", zeros.len() as u64, &zstd));
    assert!(found.contains("which no recording does"), "{found}");
    let found = explained(&chunk("unknown-compression.mcap", "xz", 10, &[]));
    assert!(found.contains("compressed by `xz`"), "{found}");
}

#[test]
fn a_bag_unpacks_to_what_its_chunks_state_and_not_more() {
    let mut bytes = std::fs::read(data("ros1_bz2.bag")).unwrap();
    let mut at = 0;
    while let Some(found) = bytes[at..].windows(5).position(|window| window == b"size=") {
        at += found + 5;
        bytes[at..at + 4].copy_from_slice(&100_u32.to_le_bytes());
    }
    let path = scratch("bomb.bag");
    std::fs::write(&path, bytes).unwrap();
    let found = bag_datasets(&path, &|_| true).unwrap_err().explain();
    assert!(found.contains("more than the stated 100 bytes"), "{found}");
}

#[test]
fn a_database_that_computes_its_messages_is_refused() {
    let path = scratch("computed.db3");
    let _ = std::fs::remove_file(&path);
    let database = rusqlite::Connection::open(&path).unwrap();
    let text = "CREATE TABLE topics(id INTEGER, name TEXT, type TEXT, serialization_format TEXT);
        CREATE VIEW messages AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)
        SELECT i AS id, 1 AS topic_id, i AS timestamp, zeroblob(1000000) AS data FROM n;";
    database.execute_batch(text).unwrap();
    drop(database);
    let found = rosbag2_datasets(&path, &|_| true).unwrap_err().explain();
    assert!(found.contains("there is no table `messages`"), "{found}");
}

#[test]
fn a_database_is_read_without_a_file_beside_it() {
    let folder = scratch("read only?#%41");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("a.db3");
    std::fs::copy(data("without_definitions.db3"), &path).unwrap();
    assert_eq!(rosbag2_datasets(&path, &|_| true).unwrap().len(), 4);
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
    let missing = rosbag2_datasets(&folder.join("b.db3"), &|_| true).unwrap_err();
    assert!(matches!(missing, RecordingError::Io { .. }), "{missing}");
    let other = bag_datasets(&path, &|_| true).unwrap_err().explain();
    assert!(other.contains("#ROSBAG V2.0"), "{other}");
}
