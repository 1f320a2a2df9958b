//! Files that were damaged on the way: every reader answers or gives a reason, and none panics.
//!
//! The bodies are those of the fuzzer in `tests/fuzz`; here each gets the same seeded damage to a
//! good file on every machine.

#[path = "../fuzz/bodies.rs"]
mod bodies;

use channels::{Channel, Recording, Role};
use runtime::checkpoint::{Checkpoint, Store};
use std::path::Path;

/// Damaged copies of each good file.
const COPIES: u64 = 300;

/// SplitMix64.
struct Draw(u64);

impl Draw {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % limit.max(1) as u64) as usize
    }

    /// One to four of: a byte changed, a stretch lost, repeated, cut off or filled with one byte.
    fn damaged(&mut self, good: &[u8]) -> Vec<u8> {
        let mut bytes = good.to_vec();
        for _ in 0..1 + self.below(4) {
            let at = self.below(bytes.len());
            let end = (at + 1 + self.below(40)).min(bytes.len());
            match self.below(5) {
                0 if !bytes.is_empty() => bytes[at] = self.below(256) as u8,
                1 => drop(bytes.drain(at..end)),
                2 => {
                    let again = bytes[at..end].to_vec();
                    bytes.splice(at..at, again);
                }
                3 => bytes.truncate(at),
                _ => {
                    let byte = self.below(256) as u8;
                    bytes[at..end].fill(byte);
                }
            }
        }
        bytes
    }
}

/// A folder of this test, removed with it.
struct Folder(std::path::PathBuf);

impl Folder {
    fn new() -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("hostile-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A good file of each format.
fn good() -> Vec<(&'static str, Vec<u8>)> {
    let folder = Folder::new();
    let channel = Channel {
        name: "rate".to_owned(),
        unit: "rad/s".to_owned(),
        time_s: (0..50).map(|k| 0.01 * f64::from(k)).collect(),
        value: (0..50).map(|k| f64::from(k % 7)).collect(),
        role: Role::Unknown,
    };
    let (mcap, slots) = (folder.0.join("good.mcap"), folder.0.clone());
    let recording = Recording { name: "good".to_owned(), channels: vec![channel] };
    recording::write_series_mcap(&recording, &mcap).unwrap();
    let mut store = Store::new(&slots, "good");
    store.save(&Checkpoint { frames: 7, state: vec![3; 200], ..Checkpoint::default() }).unwrap();
    let slot = [0, 1].map(|slot| slots.join(format!("good.{slot}"))).into_iter().find(|path| path.exists()).unwrap();
    vec![
        ("csv", include_bytes!("swing.csv").to_vec()),
        ("mcap", std::fs::read(mcap).unwrap()),
        ("uff", include_bytes!("beam.uff").to_vec()),
        ("plant", include_bytes!("../../deploy/plants/study_case.toml").to_vec()),
        ("scenario", include_bytes!("../../deploy/scenarios/short.toml").to_vec()),
        ("checkpoint", std::fs::read(slot).unwrap()),
    ]
}

#[test]
fn every_reader_answers_or_gives_a_reason_whatever_happened_to_a_file() {
    let good = good();
    assert_eq!(good.len(), bodies::BODIES.len());
    for ((name, body), (of, bytes)) in bodies::BODIES.iter().zip(&good) {
        assert_eq!(name, of);
        let mut draw = Draw(34);
        body(bytes);
        for _ in 0..COPIES {
            body(&draw.damaged(bytes));
        }
    }
    bodies::clean_up();
}

#[test]
fn damage_is_damage_and_the_same_on_every_machine() {
    let bytes: Vec<u8> = (0..200).collect();
    let [one, other] = [1, 1].map(|seed| Draw(seed).damaged(&bytes));
    assert_eq!(one, other);
    let mut draw = Draw(2);
    let changed = (0..100).filter(|_| draw.damaged(&bytes) != bytes).count();
    assert!(changed > 90, "{changed}");
}
