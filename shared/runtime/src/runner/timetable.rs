//! When frames are due by the clock.

/// When the frames of a source are due that follows the clock.
#[derive(Clone, Copy, Debug)]
pub struct Timetable {
    /// Due time of `first_frame` (`CLOCK_MONOTONIC`) \[ns\].
    pub begin_ns: u64,
    /// The first frame of this life.
    pub first_frame: u64,
    /// Wall time between two frames \[ns\].
    pub interval_ns: u64,
}

impl Timetable {
    /// When `frame` is due \[ns\].
    #[must_use]
    pub fn due_ns(&self, frame: u64) -> u64 {
        self.begin_ns.saturating_add(frame.saturating_sub(self.first_frame).saturating_mul(self.interval_ns))
    }

    /// How many frames behind the first are due at `now_ns`, the first included.
    #[must_use]
    pub fn frames_due(&self, now_ns: u64) -> u64 {
        now_ns.checked_sub(self.begin_ns).map_or(0, |since| since / self.interval_ns.max(1) + 1)
    }
}
