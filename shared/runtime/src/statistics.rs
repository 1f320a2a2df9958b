//! Housekeeping figures of a process: what it received, how late, at what cost.

use crate::link::Link;
use crate::process::Life;
use crate::runner::Runner;
use crate::sys;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use telemetry::{Header, Housekeeping, PartitionId};

/// One row of the table that a run ends with.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct PartitionRow {
    /// Of the partition, as in `PartitionId::text`.
    pub name: String,
    /// Samples delivered to frames.
    pub received: u64,
    /// Sequence numbers that never came.
    pub lost: u64,
    /// How often it was restarted.
    pub restarts: u32,
    /// Of the last restart: 0 none, 1 to 255 signal, 256 + exit code.
    pub restart_cause: u32,
    /// From send to frame, median \[µs\].
    pub latency_us_p50: f64,
    /// From send to frame, 99th percentile \[µs\].
    pub latency_us_p99: f64,
    /// Processor time over wall time since the last start [%].
    pub cpu_percent: f64,
    /// Samples dropped because they had been seen.
    pub duplicates: u64,
    /// Samples dropped for CRC, layout or a value that is not finite.
    pub bad: u64,
    /// Processor time since the last start \[s\].
    pub cpu_s: f64,
    /// Longest execution of a frame since the last start \[µs\].
    pub frame_us_max: f64,
    /// Frames done.
    pub frames: u64,
    /// The warden gave it up.
    #[serde(default)]
    pub given_up: bool,
}

impl PartitionRow {
    /// Counters of a partition that has no process of its own: no latency, no processor share.
    pub fn of<L: Link>(runner: &Runner<L>) -> Self {
        let counters = runner.counters();
        PartitionRow {
            name: runner.id().text().into(),
            received: counters.received,
            lost: counters.lost,
            restarts: runner.epoch(),
            duplicates: counters.duplicates,
            bad: counters.bad,
            frames: runner.frames_done(),
            ..PartitionRow::default()
        }
    }
}

/// Collects the figures of one process.
pub struct Statistics {
    path: PathBuf,
    started_ns: u64,
    row: PartitionRow,
}

impl Statistics {
    /// Counts processor and wall time from now; the figures of `id` go to the file `path`.
    #[must_use]
    pub fn new(path: PathBuf, id: PartitionId, life: Life) -> Self {
        let row = PartitionRow {
            name: id.text().into(),
            restarts: life.epoch,
            restart_cause: life.cause,
            ..PartitionRow::default()
        };
        Statistics { path, started_ns: sys::monotonic_ns(), row }
    }

    /// The figures now, also as a telemetry sample.
    pub fn sample<L: Link>(&mut self, runner: &Runner<L>) -> Housekeeping {
        let wall_s = sys::monotonic_ns().saturating_sub(self.started_ns) as f64 * 1e-9;
        let (counters, row) = (runner.counters(), &mut self.row);
        row.received = counters.received;
        row.lost = counters.lost;
        row.duplicates = counters.duplicates;
        row.bad = counters.bad;
        row.latency_us_p50 = runner.latency().percentile_us(0.50);
        row.latency_us_p99 = runner.latency().percentile_us(0.99);
        row.cpu_s = sys::cpu_ns() as f64 * 1e-9;
        row.cpu_percent = 100.0 * row.cpu_s / wall_s.max(1e-3);
        row.frame_us_max = runner.frame_us_max();
        row.frames = runner.frames_done();
        Housekeeping {
            header: Header::at(0),
            partition: runner.id().code().into(),
            restarts: row.restarts,
            restart_cause: row.restart_cause,
            reserved: 0,
            received: row.received,
            lost: row.lost,
            duplicates: row.duplicates,
            bad: row.bad,
            latency_us_p50: row.latency_us_p50,
            latency_us_p99: row.latency_us_p99,
            frame_us_max: row.frame_us_max,
            cpu_percent: row.cpu_percent,
            cpu_s: row.cpu_s,
            wall_s,
        }
    }

    /// Leaves the figures where the warden collects them.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn write(&self) -> std::io::Result<()> {
        let text = serde_json::to_string(&self.row).map_err(std::io::Error::other)?;
        let fresh = self.path.with_extension("new");
        std::fs::write(&fresh, text)?;
        std::fs::rename(fresh, &self.path)
    }
}
