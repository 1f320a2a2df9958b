//! When frames are due by the clock.

/// When the frames of a source are due that follows the clock: the first frame of a life when it
/// begins, because it waits until the others are ready; every other so many intervals behind it.
#[derive(Clone, Copy, Debug)]
pub struct Timetable {
    /// Wall time between two frames \[ns\].
    interval_ns: u64,
    first: Option<First>,
}

/// The first frame of a life.
#[derive(Clone, Copy, Debug)]
struct First {
    frame: u64,
    /// When it began (`CLOCK_MONOTONIC`) \[ns\].
    begun_ns: u64,
}

impl Timetable {
    /// Of frames `interval_ns` apart.
    #[must_use]
    pub fn new(interval_ns: u64) -> Self {
        Timetable { interval_ns: interval_ns.max(1), first: None }
    }

    /// `frame` begins at `now_ns`.
    pub fn begin(&mut self, frame: u64, now_ns: u64) {
        self.first.get_or_insert(First { frame, begun_ns: now_ns });
    }

    /// When `frame` is due \[ns\]; 0 before the first has begun.
    #[must_use]
    pub fn due_ns(&self, frame: u64) -> u64 {
        self.first.map_or(0, |first| {
            first.begun_ns.saturating_add(frame.saturating_sub(first.frame).saturating_mul(self.interval_ns))
        })
    }

    /// How many frames are due at `now_ns` where `frame` is the next; before the first has begun,
    /// that one.
    #[must_use]
    pub fn frames_due(&self, frame: u64, now_ns: u64) -> u64 {
        let due_ns = self.due_ns(frame);
        now_ns.checked_sub(due_ns).map_or(0, |late_ns| if due_ns == 0 { 1 } else { late_ns / self.interval_ns + 1 })
    }
}

#[cfg(test)]
mod tests {
    use super::Timetable;

    #[test]
    fn a_timetable_begins_with_the_first_frame_however_late_that_one_is() {
        let mut table = Timetable::new(10);
        assert_eq!([5, 500_000].map(|now_ns| table.frames_due(7, now_ns)), [1, 1], "one frame is due at any time");
        table.begin(7, 500_000);
        assert_eq!([7, 8, 10].map(|frame| table.due_ns(frame)), [500_000, 500_010, 500_030]);
        assert_eq!([500_009, 500_010, 500_035].map(|now_ns| table.frames_due(8, now_ns)), [0, 1, 3]);
        table.begin(8, 600_000);
        assert_eq!(table.due_ns(8), 500_010, "it begins once");
    }
}
