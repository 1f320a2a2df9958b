//! Events of a partition: through the gate, onto the topic, into the ring file.

use super::{RunError, Runner};
use crate::events::{EventCounts, EventLog};
use crate::link::Link;
use telemetry::{EVENT, Event, EventCode, Severity, TableValues};
use zerocopy::FromBytes;

/// A deadline that is never missed, in the table.
const DEADLINE_MAX_MS: f64 = 1e9;
const NS_PER_MS: f64 = 1e6;

impl<L: Link> Runner<L> {
    /// Reports an event of this partition, as grave as its code.
    ///
    /// # Errors
    /// When the link refuses.
    pub fn event(&mut self, code: EventCode, arguments: &[f64]) -> Result<(), RunError> {
        self.event_as(code.severity(), code, arguments)
    }

    /// As [`Runner::event`], of another severity.
    ///
    /// # Errors
    /// When the link refuses.
    pub fn event_as(&mut self, severity: Severity, code: EventCode, arguments: &[f64]) -> Result<(), RunError> {
        let event = Event::new(code, self.id, self.frames_done, arguments);
        self.offer_event(Event { severity: severity.code(), ..event })
    }

    /// An event that the partition published with its frame takes the same way.
    pub(super) fn offer_published(&mut self, payload: &[u8]) -> Result<(), RunError> {
        let Ok(event) = Event::read_from_bytes(payload) else { return Ok(()) };
        self.offer_event(Event { partition: self.id.code(), frame: self.frames_done, ..event })
    }

    fn offer_event(&mut self, event: Event) -> Result<(), RunError> {
        let Some(code) = event.known_code() else { return Ok(()) };
        let now_ns = self.event_clock_ns();
        let Some(squelched) = self.gate.admit(code, event.known_severity(), now_ns) else { return Ok(()) };
        self.publish_status(EVENT, &Event { squelched, ..event })
    }

    /// Says what was squelched in windows that are over; at the end of a life (`is_last`) in all.
    ///
    /// # Errors
    /// When the link refuses.
    pub fn say_squelched(&mut self, is_last: bool) -> Result<(), RunError> {
        let now_ns = if is_last { u64::MAX } else { self.event_clock_ns() };
        while let Some((code, count)) = self.gate.summary(now_ns) {
            let numbers = [code.code().into(), count as f64];
            let event = Event::new(EventCode::Squelched, self.id, self.frames_done, &numbers);
            self.publish_status(EVENT, &event)?;
        }
        Ok(())
    }

    /// The clock, or the frames' time where there is none.
    fn event_clock_ns(&self) -> u64 {
        match self.link.now_ns() {
            0 => self.frames_done * self.period_ns,
            now_ns => now_ns,
        }
    }

    /// The oldest event that was heard and not taken; only of a supervisor with rules.
    pub fn take_heard_event(&mut self) -> Option<Event> {
        (!self.heard_events.is_empty()).then(|| self.heard_events.remove(0))
    }

    /// Keeps the newest events in a ring file from now on.
    pub fn log_events_to(&mut self, log: EventLog) {
        self.event_log = Some(log);
    }

    /// Events sent, squelched, filtered.
    #[must_use]
    pub fn event_counts(&self) -> EventCounts {
        self.gate.counts()
    }

    /// Commands carried out and refused since the start or since they were cleared.
    #[must_use]
    pub fn command_counts(&self) -> (u32, u32) {
        (self.desk.executed, self.desk.refused)
    }

    pub(super) fn monitor_table(&self) -> Option<TableValues> {
        self.gate.table((self.deadline_ns as f64 / NS_PER_MS).min(DEADLINE_MAX_MS))
    }

    pub(super) fn configure_monitor(&mut self, values: &TableValues) {
        self.gate.configure(values);
        let deadline_ms = values.as_slice()[0];
        self.deadline_ns = if deadline_ms < DEADLINE_MAX_MS { (deadline_ms * NS_PER_MS) as u64 } else { u64::MAX };
    }

    /// In real time: a frame that was late is an event, and so are whole periods by which it began
    /// late.
    pub(super) fn watch_the_time(&mut self, due_ns: u64, started_ns: u64, done_ns: u64) -> Result<(), RunError> {
        let Some(interval_ns) = self.interval_ns.filter(|_| due_ns > 0) else { return Ok(()) };
        let cycles = started_ns.saturating_sub(due_ns) / interval_ns;
        if cycles > self.behind_cycles {
            // Each cycle is counted once, however long it takes to catch up with it.
            let slipped = cycles - self.behind_cycles;
            self.times.cycle_slips += slipped;
            self.event(EventCode::CycleSlip, &[slipped as f64, self.times.cycle_slips as f64])?;
        }
        self.behind_cycles = cycles;
        let late_ns = done_ns.saturating_sub(due_ns);
        if late_ns > self.deadline_ns {
            let misses = self.times.deadline_misses as f64;
            self.event(EventCode::DeadlineMissed, &[(late_ns / 1000) as f64, misses])?;
        }
        Ok(())
    }
}
