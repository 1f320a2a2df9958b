//! No damaged file makes a panic, and none gives a number that was not written.

use crate::samples::{everything, listed};
use crate::{Numbers, scratch};
use channels::{Channel, Recording};
use flate2::write::GzEncoder;
use recording::{Imported, McapRecorder, ReplayFrames, write_mcap, write_series};
use std::io::Write;

/// Random truncations, byte flips and overwritten words of `bytes`.
fn damaged(bytes: &[u8], numbers: &mut Numbers) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    match numbers.below(4) {
        0 => bytes.truncate(numbers.below(bytes.len())),
        1 => {
            let at = numbers.below(bytes.len());
            bytes[at] ^= 1 << numbers.below(8);
        }
        2 => {
            for _ in 0..=numbers.below(8) {
                let at = numbers.below(bytes.len());
                bytes[at] = numbers.next() as u8;
            }
        }
        _ => {
            // A length field gone wild.
            let at = numbers.below(bytes.len() - 8);
            let wild = [u64::MAX, 1 << 60, 1 << 33, 0, 33][numbers.below(5)];
            bytes[at..at + 8].copy_from_slice(&wild.to_le_bytes());
        }
    }
    bytes
}

#[test]
fn a_damaged_mcap_is_refused_or_gives_exactly_the_samples_written() {
    let run = everything(3);
    let path = scratch("damage.mcap");
    write_mcap(&run, &path).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let expected = listed(&run);
    let mut numbers = Numbers(31);
    let mut refused = 0;
    for _ in 0..1000 {
        let bytes = damaged(&whole, &mut numbers);
        std::fs::write(&path, &bytes).unwrap();
        match recording::read(&path) {
            Ok(Imported::Run(read)) => assert!(listed(&read) == expected, "silently other samples"),
            Ok(_) => panic!("an MCAP of a run is a run"),
            Err(error) => {
                refused += 1;
                assert!(error.explain().contains("cure: "), "{error}");
            }
        }
    }
    // CRCs cover every byte of the file but indexes' padding; a flip that changes nothing is rare.
    assert!(refused > 960, "{refused}");
}

#[test]
fn a_damaged_mcap_of_channels_is_refused_or_gives_exactly_the_channels_written() {
    let mut numbers = Numbers(47);
    let mut channel = |name: &str, every: usize| {
        let time_s: Vec<f64> = (0..200).step_by(every).map(|i| f64::from(i) / 100.0).collect();
        let values = time_s.iter().map(|_| numbers.unit()).collect();
        Channel::new(name, "rad", time_s, values)
    };
    let written = Recording { name: "memory".into(), channels: vec![channel("a", 1), channel("b", 7)] };
    let path = scratch("damage-series.mcap");
    write_series(&written, &path).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let mut refused = 0;
    for _ in 0..1000 {
        std::fs::write(&path, damaged(&whole, &mut numbers)).unwrap();
        match recording::read(&path) {
            Ok(Imported::Series(read)) => {
                assert!(read.recording.channels == written.channels, "silently other samples")
            }
            Ok(_) => panic!("an MCAP of channels is a set of channels"),
            Err(error) => {
                refused += 1;
                assert!(error.explain().contains("cure: "), "{error}");
            }
        }
    }
    assert!(refused > 960, "{refused}");
}

#[test]
fn recovery_of_a_damaged_mcap_keeps_only_samples_that_were_written() {
    let run = everything(60);
    let path = scratch("damage-recover.mcap");
    // Several chunks, as a recorder flushes them.
    let mut recorder = McapRecorder::create(&path).unwrap();
    for (i, sample) in run.samples().enumerate() {
        recorder.write(sample.topic, sample.stamps, sample.payload).unwrap();
        if i % 100 == 99 {
            recorder.flush().unwrap();
        }
    }
    recorder.finish().unwrap();
    let whole = std::fs::read(&path).unwrap();
    let expected = listed(&run);
    let mut numbers = Numbers(37);
    for _ in 0..150 {
        std::fs::write(&path, damaged(&whole, &mut numbers)).unwrap();
        if let Ok((recorder, found)) = McapRecorder::recover(&path, |_, _, _| true) {
            recorder.finish().unwrap();
            let read = recording::read_mcap(&path).unwrap();
            assert_eq!(read.len() as u64, found.kept);
            assert!(expected.starts_with(&listed(&read)), "a prefix of what was written");
        }
    }
}

#[test]
fn a_damaged_gzip_is_refused_or_gives_exactly_the_rows_written() {
    let rows: String = (0..300).map(|i| format!("{},{}\n", f64::from(i) * 0.01, (i * 7919) % 10007)).collect();
    let mut encoder = GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(format!("time [s],rate [rad/s]\n{rows}").as_bytes()).unwrap();
    let whole = encoder.finish().unwrap();
    let path = scratch("damage.csv.gz");
    let load = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        recording::read(&path)
    };
    let Imported::Table(expected) = load(&whole).unwrap() else { panic!() };
    let mut numbers = Numbers(41);
    for _ in 0..1000 {
        match load(&damaged(&whole, &mut numbers)) {
            Ok(Imported::Table(read)) => assert_eq!(read, expected, "silently other numbers"),
            Ok(_) => panic!("a table is a table"),
            Err(error) => assert!(error.explain().contains("cure: "), "{error}"),
        }
    }
}

#[test]
fn a_damaged_plain_csv_never_panics_up_to_the_replay() {
    let rows: String = (0..100).map(|i| format!("{:.2},{},{}\n", f64::from(i) * 0.01, i * 3, 7 - i)).collect();
    let whole = format!("time [s],rate [rad/s],acceleration_x [g]\n{rows}").into_bytes();
    let path = scratch("damage.csv");
    let mut numbers = Numbers(43);
    for _ in 0..1000 {
        std::fs::write(&path, damaged(&whole, &mut numbers)).unwrap();
        if let Ok(imported) = recording::read(&path)
            && let Ok(frames) = ReplayFrames::new(&imported, None, 10_000_000)
        {
            for k in 0..frames.frame_count().min(200) {
                frames.frame(k, &mut |_| {});
            }
        }
    }
}
