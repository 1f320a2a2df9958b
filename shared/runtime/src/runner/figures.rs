//! What a partition's life has come to, for housekeeping and for whoever drives it.

use super::{RunError, Runner};
use crate::inbox::Counters;
use crate::latency::FrameTimes;
use crate::link::Link;
use crate::trace::Mark;
use telemetry::{PartitionId, Progress};

impl<L: Link> Runner<L> {
    /// Of the partition that it drives.
    #[must_use]
    pub fn id(&self) -> PartitionId {
        self.id
    }

    /// How often the partition was started before in this run.
    #[must_use]
    pub fn epoch(&self) -> u32 {
        self.epoch
    }

    /// Frames processed since the run began, over all restarts; the last ones may not be in a
    /// checkpoint yet.
    #[must_use]
    pub fn frames_done(&self) -> u64 {
        self.frames_done
    }

    /// Execution counter: turns since this start. One that stands still is a hang.
    #[must_use]
    pub fn cycles(&self) -> u64 {
        self.cycles
    }

    /// Samples received and dropped, over all restarts.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.inbox.counters()
    }

    /// Times of frames since this start.
    #[must_use]
    pub fn times(&self) -> &FrameTimes {
        &self.times
    }

    /// End of the first frame whose samples were sent since this start \[ns\]: the partition is
    /// back. Of a source its first frame.
    #[must_use]
    pub fn fresh_ns(&self) -> Option<u64> {
        self.fresh_ns
    }

    /// Payload sent since this start \[bytes\].
    #[must_use]
    pub fn bytes_sent(&self) -> u64 {
        self.bytes_sent
    }

    /// Whether this life began behind the first frame without a checkpoint: what it knew is lost.
    #[must_use]
    pub fn began_anew(&self) -> bool {
        self.began_anew
    }

    /// Whether work is being done beside the loop.
    #[must_use]
    pub fn is_working(&self) -> bool {
        self.away.is_some()
    }

    /// State of the mode in effect.
    #[must_use]
    pub fn mode_text(&self) -> &'static str {
        self.mode.text()
    }

    /// Partitions that were given up in this run.
    #[must_use]
    pub fn given_up(&self) -> &[PartitionId] {
        &self.given_up
    }

    /// Progress reports received since they were forgotten.
    #[must_use]
    pub fn heard(&self) -> &[Progress] {
        &self.heard
    }

    /// Times of a frame that began at `started_ns` with samples of which the newest was sent at
    /// `newest_ns` (0: without).
    pub(super) fn note_times(&mut self, frame: u64, started_ns: u64, newest_ns: u64) -> Result<(), RunError> {
        let now_ns = self.link.now_ns();
        let is_source = self.pacing.is_some();
        let due_ns = match &mut self.timetable {
            Some(table) if is_source => {
                table.begin(frame, started_ns);
                table.due_ns(frame)
            }
            _ if is_source => 0,
            _ => newest_ns,
        };
        self.times.frame.record(now_ns.saturating_sub(started_ns));
        if due_ns > 0 {
            let since_due_ns = now_ns.saturating_sub(due_ns);
            self.times.jitter.record(started_ns.saturating_sub(due_ns));
            self.times.end_to_end.record(since_due_ns);
            self.times.deadline_misses += u64::from(since_due_ns > self.deadline_ns);
        }
        if self.fresh_ns.is_none() && (is_source || newest_ns > self.started_ns) {
            self.fresh_ns = Some(now_ns);
        }
        if let Some(trace) = &mut self.trace {
            trace.mark(Mark::Frame, frame, started_ns, now_ns);
        }
        self.watch_the_time(due_ns, started_ns, now_ns)
    }
}
