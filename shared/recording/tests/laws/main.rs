//! Laws of the recording crate: what comes out is what went in, or an error that names place, value
//! and cure.

mod bad_channels;
mod bad_tables;
mod cells;
mod channel_maps;
mod clocks;
mod clocks_in_parts;
mod damage;
mod dialects;
mod digests;
mod field;
mod foreign_bounds;
mod foreign_claims;
mod foreign_messages;
mod foreign_rows;
mod further_loggers;
mod intake;
mod loggers;
mod mcap_bytes;
mod mcap_files;
mod netcdf;
mod other_shapes;
mod other_texts;
mod others;
mod preambles;
mod real_recordings;
mod recognised;
mod replay_runs;
mod replay_tables;
mod replayed_clocks;
mod run_channels;
mod samples;
mod series;
mod shapes;
mod spectra_and_segments;
mod stamps;
mod stamps_and_headers;
mod strangers;
mod structured;
mod tables;
mod uff_models;
mod uff_types;
mod units_of_names;
mod universal_files;

use std::path::PathBuf;

/// A file of this test run's own.
fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("recording");
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

/// Writes `text` under `name` and returns its path.
fn file(name: &str, text: &str) -> PathBuf {
    let path = scratch(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// SplitMix64: positions and values for the tests, the same in every run.
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
        (self.next() % bound as u64) as usize
    }

    /// In [-1, 1).
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
