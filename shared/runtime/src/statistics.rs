//! Figures of a partition: what each life's process leaves for the warden, and their sum over all
//! lives.

use crate::hardening::Hardening;
use crate::inbox::Counters;
use crate::latency::FrameTimes;
use crate::life::Life;
use crate::link::Link;
use crate::runner::Runner;
use crate::sys;
use crate::usage::Usage;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::Duration;
use telemetry::{Header, Housekeeping, PartitionId};

/// Until then a process may take memory: connections are made, buffers find their size.
const START: Duration = Duration::from_secs(1);
/// Room for the figures as JSON \[bytes\]: four histograms of 320 buckets, ten characters each.
const FILE_BYTES: usize = 16 * 1024;

/// One row of the table that a run ends with: figures over all lives of a partition.
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
    /// Processor time over wall time [%].
    pub cpu_percent: f64,
    /// Samples dropped because they had been seen.
    pub duplicates: u64,
    /// Samples dropped for CRC, layout or a value that is not finite.
    pub bad: u64,
    /// Processor time behind the starts \[s\].
    pub cpu_s: f64,
    /// Processor time of the starts \[s\].
    #[serde(default)]
    pub start_cpu_s: f64,
    /// Wall time in which a process of it lived, behind the starts \[s\].
    pub wall_s: f64,
    /// Longest execution of a frame \[µs\].
    pub frame_us_max: f64,
    /// Frames done.
    pub frames: u64,
    /// The warden gave it up.
    #[serde(default)]
    pub given_up: bool,
    /// Times of its frames.
    pub times: FrameTimes,
    /// Allocations of its loop later than a second after each start.
    pub allocations_after_start: u64,
    /// Payload that it sent \[bytes\].
    pub bytes_sent: u64,
    /// Of the processor and the memory, as the kernel counts.
    pub usage: Usage,
    /// Barriers around its last life.
    #[serde(default)]
    pub hardening: Hardening,
    /// CPU window of its last life, or why it has none; empty where none was asked for.
    #[serde(default)]
    pub cpu_window: String,
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

/// What the process of one life leaves, or the sum over lives.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LifeFigures {
    /// How often the partition was started before.
    pub epoch: u32,
    /// Of samples, over all lives so far: the checkpoint carries them.
    pub counters: Counters,
    /// Frames done, over all lives so far.
    pub frames: u64,
    /// Processor time of this life behind its start \[s\].
    pub cpu_s: f64,
    /// Processor time of its start \[s\].
    #[serde(default)]
    pub start_cpu_s: f64,
    /// Length of this life behind its start \[s\].
    pub wall_s: f64,
    /// End of the first frame whose samples were sent in this life (`CLOCK_MONOTONIC`) \[ns\].
    pub fresh_ns: Option<u64>,
    /// Of this life.
    pub times: FrameTimes,
    /// Allocations of its loop later than a second after its start.
    pub allocations_after_start: u64,
    /// Payload that it sent \[bytes\].
    pub bytes_sent: u64,
    /// Barriers around it.
    #[serde(default)]
    pub hardening: Hardening,
}

impl LifeFigures {
    /// Adds a later life: what a checkpoint carries is taken from it, the rest is summed.
    pub fn add(&mut self, later: &Self) {
        self.epoch = later.epoch;
        (self.counters, self.frames) = (later.counters, later.frames);
        self.cpu_s += later.cpu_s;
        self.start_cpu_s += later.start_cpu_s;
        self.wall_s += later.wall_s;
        self.fresh_ns = later.fresh_ns;
        self.times.add(&later.times);
        self.allocations_after_start += later.allocations_after_start;
        self.bytes_sent += later.bytes_sent;
        self.hardening.clone_from(&later.hardening);
    }

    /// The figures in `file`, if a process has left some.
    #[must_use]
    pub fn read(file: &Path) -> Option<Self> {
        serde_json::from_str(&std::fs::read_to_string(file).ok()?).ok()
    }

    /// As a row of the table; restarts and `given_up` are the warden's knowledge.
    #[must_use]
    pub fn row(&self, name: &str, usage: Usage) -> PartitionRow {
        PartitionRow {
            name: name.into(),
            received: self.counters.received,
            lost: self.counters.lost,
            latency_us_p50: self.times.latency.percentile_us(0.50),
            latency_us_p99: self.times.latency.percentile_us(0.99),
            cpu_percent: 100.0 * self.cpu_s / self.wall_s.max(1e-3),
            duplicates: self.counters.duplicates,
            bad: self.counters.bad,
            cpu_s: self.cpu_s,
            start_cpu_s: self.start_cpu_s,
            wall_s: self.wall_s,
            frame_us_max: self.times.frame.max_us(),
            frames: self.frames,
            times: self.times.clone(),
            allocations_after_start: self.allocations_after_start,
            bytes_sent: self.bytes_sent,
            usage,
            hardening: self.hardening.clone(),
            ..PartitionRow::default()
        }
    }
}

/// Collects the figures of one process; takes no memory after its construction.
pub struct Statistics {
    path: PathBuf,
    fresh_path: PathBuf,
    text: Vec<u8>,
    started_ns: u64,
    /// Processor time of the start.
    start_cpu_ns: u64,
    life: Life,
    /// Allocations when the start was over, and when the loop was.
    allocations_at_start: Option<u64>,
    allocations_at_end: Option<u64>,
    figures: LifeFigures,
}

impl Statistics {
    /// Counts processor and wall time from now; the figures of this life go to the file `path`.
    #[must_use]
    pub fn new(path: PathBuf, life: Life) -> Self {
        Statistics {
            fresh_path: path.with_extension("new"),
            path,
            text: Vec::with_capacity(FILE_BYTES),
            started_ns: sys::monotonic_ns(),
            start_cpu_ns: sys::cpu_ns(),
            life,
            allocations_at_start: None,
            allocations_at_end: None,
            figures: LifeFigures { epoch: life.epoch, ..LifeFigures::default() },
        }
    }

    /// Which barriers stand around this life.
    pub fn hardened(&mut self, hardening: Hardening) {
        self.figures.hardening = hardening;
    }

    /// The loop is over: what closing a file takes is not counted.
    pub fn end_loop(&mut self) {
        self.allocations_at_end = Some(sys::allocations_of_system());
    }

    /// The figures now, also as a telemetry sample.
    pub fn sample<L: Link>(&mut self, runner: &Runner<L>) -> Housekeeping {
        let age_ns = sys::monotonic_ns().saturating_sub(self.started_ns);
        if self.allocations_at_start.is_none() && age_ns >= START.as_nanos() as u64 {
            self.allocations_at_start = Some(sys::allocations_of_system());
        }
        let allocations = self.allocations_at_end.unwrap_or_else(sys::allocations_of_system);
        let allocations = self.allocations_at_start.map_or(0, |at_start| allocations.saturating_sub(at_start));
        let figures = &mut self.figures;
        figures.counters = runner.counters();
        figures.frames = runner.frames_done();
        figures.cpu_s = sys::cpu_ns().saturating_sub(self.start_cpu_ns) as f64 * 1e-9;
        figures.start_cpu_s = self.start_cpu_ns as f64 * 1e-9;
        figures.wall_s = age_ns as f64 * 1e-9;
        figures.fresh_ns = runner.fresh_ns();
        figures.times.copy_from(runner.times());
        figures.allocations_after_start = allocations;
        figures.bytes_sent = runner.bytes_sent();
        Housekeeping {
            header: Header::at(0),
            partition: runner.id().code().into(),
            restarts: self.life.epoch,
            restart_cause: self.life.cause,
            allocations: u32::try_from(allocations).unwrap_or(u32::MAX),
            received: figures.counters.received,
            lost: figures.counters.lost,
            duplicates: figures.counters.duplicates,
            bad: figures.counters.bad,
            latency_us_p50: figures.times.latency.percentile_us(0.50),
            latency_us_p99: figures.times.latency.percentile_us(0.99),
            frame_us_max: figures.times.frame.max_us(),
            cpu_percent: 100.0 * figures.cpu_s / figures.wall_s.max(1e-3),
            cpu_s: figures.cpu_s,
            wall_s: figures.wall_s,
            events_sent: runner.event_counts().sent,
            events_squelched: runner.event_counts().squelched,
            events_filtered: runner.event_counts().filtered,
            deadline_misses: figures.times.deadline_misses,
            cycle_slips: figures.times.cycle_slips,
            commands_executed: runner.command_counts().0,
            commands_refused: runner.command_counts().1,
        }
    }

    /// Leaves the figures where the warden collects them.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn write(&mut self) -> std::io::Result<()> {
        self.text.clear();
        serde_json::to_writer(&mut self.text, &self.figures).map_err(std::io::Error::other)?;
        std::fs::write(&self.fresh_path, &self.text)?;
        std::fs::rename(&self.fresh_path, &self.path)
    }
}

/// Of `partition`'s row in a run's folder; for readers outside the run.
#[must_use]
pub fn latest(folder: &crate::rundir::RunDir, partition: PartitionId) -> Option<LifeFigures> {
    LifeFigures::read(&folder.statistics(partition))
}

#[cfg(test)]
mod tests {
    use super::LifeFigures;

    #[test]
    fn figures_survive_a_restart_and_counters_that_a_checkpoint_carries_are_not_summed_twice() {
        let mut first = LifeFigures { frames: 100, cpu_s: 1.0, wall_s: 2.0, bytes_sent: 7, ..LifeFigures::default() };
        first.counters.received = 50;
        first.times.frame.record(9000);
        let mut second =
            LifeFigures { epoch: 1, frames: 250, cpu_s: 0.5, start_cpu_s: 0.25, wall_s: 3.0, ..LifeFigures::default() };
        second.counters.received = 90;
        second.times.frame.record(4000);
        first.add(&second);
        assert_eq!((first.epoch, first.frames, first.counters.received), (1, 250, 90));
        assert_eq!((first.cpu_s, first.wall_s, first.bytes_sent), (1.5, 5.0, 7));
        assert_eq!((first.times.frame.total(), first.times.frame.max_us()), (2, 9.0));
    }
}
