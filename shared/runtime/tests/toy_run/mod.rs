//! A run of toys: the smallest configuration the runtime accepts.

use runtime::RunConfig;
use runtime::config::{Limits, Sabotage};
use runtime::recordings::RemovedRecordings;
use std::collections::BTreeMap;
use std::path::PathBuf;
use telemetry::PartitionId;

/// A run of `partitions` with a small pacing window, so that its edges are met often.
pub fn toy_run(partitions: &[PartitionId]) -> RunConfig {
    RunConfig {
        scenario: String::new(),
        files: BTreeMap::new(),
        name: "toy".into(),
        period_ns: 10_000_000,
        seed: 1,
        replay: None,
        feed: None,
        record: PathBuf::from("nowhere.mcap"),
        record_all: false,
        trace: None,
        results: None,
        windows: false,
        speed: None,
        window_frames: 20,
        checkpoint_frames: 5,
        partitions: partitions.to_vec(),
        limits: Limits::alike(5000),
        tables: Vec::new(),
        keep: None,
        removed: RemovedRecordings::default(),
        commands: Vec::new(),
        sabotage: Sabotage::None,
        faults: Vec::new(),
    }
}
