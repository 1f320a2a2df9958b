//! Foreign recordings that are cut, damaged or made to mislead: what is whole is read, memory is
//! bounded by the file, and an error names place, what was found and the cure.

use crate::foreign_messages::{BAGS, DATABASES, MCAP_FILES, data, datasets, named};
use crate::{Numbers, scratch};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader};
use recording::RawDataset;
use std::path::Path;

/// A cut, flipped bits, overwritten bytes, or a length gone wild.
fn damaged(bytes: &[u8], numbers: &mut Numbers) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let at = numbers.below(bytes.len() - 8);
    match numbers.below(4) {
        0 => bytes.truncate(at),
        1 => bytes[at] ^= 1 << numbers.below(8),
        2 => (0..=numbers.below(8)).for_each(|i| bytes[at + i] = numbers.next() as u8),
        _ => {
            let wild = [u64::MAX, 1 << 60, 1 << 31, 0, 33][numbers.below(5)];
            bytes[at..at + 8].copy_from_slice(&wild.to_le_bytes());
        }
    }
    bytes
}

fn assert_bounded(file: &str, found: &[RawDataset], size: usize) {
    let cells: usize = found.iter().map(|dataset| dataset.columns.len() * dataset.rows()).sum();
    assert!(cells <= 1000 * size, "{file}: {cells} cells of {size} bytes");
    for dataset in found {
        assert!(dataset.columns.iter().all(|column| column.values.len() == dataset.rows()), "{file}");
    }
}

#[test]
fn no_damage_makes_a_panic() {
    let mut numbers = Numbers(77);
    for file in MCAP_FILES.iter().chain(&BAGS).chain(&DATABASES) {
        let whole = std::fs::read(data(file)).unwrap();
        let path = scratch(&format!("damaged-{}", file.replace('/', "-")));
        for _ in 0..300 {
            let bytes = damaged(&whole, &mut numbers);
            std::fs::write(&path, &bytes).unwrap();
            match datasets(&path) {
                Ok(found) => assert_bounded(file, &found, bytes.len()),
                Err(error) => assert!(error.explain().contains("cure: "), "{error}"),
            }
        }
    }
}

#[test]
fn no_damage_of_unpacked_messages_makes_a_panic() {
    // No chunk with a CRC stops the damage: it reaches definitions, descriptors and messages.
    let mut numbers = Numbers(78);
    for file in ["cdr_little.mcap", "ros1.mcap", "protobuf.mcap", "json_zstd.mcap"] {
        let whole = unpacked(&std::fs::read(data(file)).unwrap());
        let path = scratch(&format!("unpacked-{file}"));
        std::fs::write(&path, &whole).unwrap();
        // As text: what has no value is not equal to itself.
        let text = |path: &Path| format!("{:?}", datasets(path).unwrap());
        assert!(text(&path) == text(&data(file)), "{file}");
        for _ in 0..300 {
            let bytes = damaged(&whole, &mut numbers);
            std::fs::write(&path, &bytes).unwrap();
            match datasets(&path) {
                Ok(found) => assert_bounded(file, &found, bytes.len()),
                Err(error) => assert!(error.explain().contains("cure: "), "{error}"),
            }
        }
    }
}

/// The same records without chunks.
fn unpacked(bytes: &[u8]) -> Vec<u8> {
    let mut plain = bytes[..8].to_vec();
    let record = |plain: &mut Vec<u8>, opcode: u8, body: &[u8]| {
        plain.push(opcode);
        plain.extend_from_slice(&(body.len() as u64).to_le_bytes());
        plain.extend_from_slice(body);
    };
    let mut reader = LinearReader::new();
    let mut at = 0;
    while let Some(event) = reader.next_event() {
        match event.unwrap() {
            LinearReadEvent::ReadRequest(need) => {
                let got = need.min(bytes.len() - at);
                reader.insert(need)[..got].copy_from_slice(&bytes[at..at + got]);
                reader.notify_read(got);
                at += got;
            }
            // Header, footer, schema, channel, message.
            LinearReadEvent::Record { opcode: opcode @ 1..=5, data } => {
                record(&mut plain, opcode, data);
            }
            LinearReadEvent::Record { .. } => {}
        }
    }
    plain.extend_from_slice(&bytes[..8]);
    plain
}

#[test]
fn what_lies_before_a_cut_is_read_and_a_note_says_so() {
    for (file, topic) in [("json_unindexed.mcap", "/rig"), ("ros1_none.bag", "/load")] {
        let whole = std::fs::read(data(file)).unwrap();
        let path = scratch(&format!("cut-{file}"));
        std::fs::write(&path, &whole[..whole.len() * 6 / 10]).unwrap();
        match datasets(&path) {
            Ok(found) => {
                let dataset = named(&found, topic);
                assert!((5..24).contains(&dataset.rows()), "{file}: {}", dataset.rows());
                assert!(dataset.notes.iter().any(|note| note.contains("is cut at byte")), "{:?}", dataset.notes);
            }
            // One chunk holds the whole bag.
            Err(error) => assert!(error.explain().contains("is cut at byte"), "{error}"),
        }
    }
}
