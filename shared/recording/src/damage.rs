//! Damage for tests: cuts, flipped bits and random bytes, the same in every run.

use crate::dataset::RawDataset;
use crate::error::RecordingError;
use std::path::PathBuf;

/// A file of `tests/data`.
pub(crate) fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// SplitMix64.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound.max(1) as u64) as usize
    }
}

/// Reads a file of `tests/data` cut in some 100 places and with 300 random damages; a panic ends
/// the test. Every error names the file and a cure; whatever is read is read twice in the same way.
pub(crate) fn every_damage_is_read_or_refused(
    name: &str,
    read: impl Fn(&[u8]) -> Result<Vec<RawDataset>, RecordingError>,
) {
    let whole = std::fs::read(data(name)).unwrap();
    let mut numbers = Numbers(whole.len() as u64);
    let cuts = (0..whole.len()).step_by(whole.len() / 100 + 1).map(|length| whole[..length].to_vec());
    let mut cases: Vec<Vec<u8>> = cuts.collect();
    for case in 0..300 {
        let mut bytes = whole.clone();
        for _ in 0..1 + case % 4 {
            let at = numbers.below(bytes.len());
            match numbers.below(4) {
                0 => bytes[at] ^= 1 << numbers.below(8),
                1 => bytes[at] = numbers.next() as u8,
                2 => bytes[at] = [0, 0xff, 0x7f, 0x80][numbers.below(4)],
                _ => bytes.truncate(at.max(1)),
            }
        }
        cases.push(bytes);
    }
    for bytes in cases {
        let text = |found: &Result<Vec<RawDataset>, RecordingError>| format!("{found:?}");
        let found = read(&bytes);
        assert_eq!(text(&found), text(&read(&bytes)), "{name}");
        if let Err(error) = found {
            let error = error.explain();
            assert!(error.starts_with("file: ") && error.contains("\ncure: "), "{name}: {error}");
        }
    }
}
