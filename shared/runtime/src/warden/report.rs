//! Reports of the warden to the process that started it, one line each.

use crate::deaths::DeathRow;
use crate::health::HealthAct;
use crate::statistics::PartitionRow;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// One report; times are of `CLOCK_MONOTONIC`.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Report {
    /// The run's folder exists; `purged` folders of dead runs were removed.
    Started { folder: PathBuf, purged: usize, t_ns: u64 },
    /// Last frame of the supervisor and the state of the mode in effect.
    Status { frame: u64, mode: String },
    /// The warden lives.
    Beat { t_ns: u64 },
    /// A process was started.
    Spawn { partition: String, pid: u32, epoch: u32, t_ns: u64 },
    /// A process ended before its run was over; `cause` is its signal or exit code.
    Death { partition: String, pid: u32, cause: String, epoch: u32, t_ns: u64 },
    /// A partition runs again, for the `restarts`-th time.
    Restart { partition: String, restarts: u32 },
    /// The CPU window that a partition's process has, or why it has none.
    Window { partition: String, window: String },
    /// A partition's execution counter stood still for its limit: it is killed.
    Hang { partition: String },
    /// A partition's execution counter stood still because it got no processor: it is left alone.
    Starved { partition: String },
    /// No frame was done for a while, `waits` says who waits for whom; the services are made anew.
    Stall { waits: String, since_s: f64 },
    /// What was done about an error beyond a restart.
    Health(HealthAct),
    /// A partition died too often: the run goes on without it or ends.
    GivenUp { partition: String },
    /// The run is over; `reason` says why where it is not `ok`.
    End { ok: bool, reason: String, partitions: Vec<PartitionRow>, deaths: Vec<DeathRow> },
}
