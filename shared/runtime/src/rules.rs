//! Rules by which an event becomes a command: so many of a code within a time, then an order, then
//! a pause.
//!
//! Events are of the wall clock, and so is what a rule makes of them. The command takes the same
//! way as one from the ground: it is stamped with a frame, and a repetition of the recording
//! repeats it.

use serde::{Deserialize, Serialize};
use telemetry::{EVERY_PARTITION, Event, EventCode, Opcode, PartitionId};

const NS_PER_S: f64 = 1e9;

/// A row `[[rule]]` of the table of limits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EventRule {
    /// Which event.
    pub event: EventCode,
    /// Reported by whom; without it by anybody.
    pub partition: Option<PartitionId>,
    /// So many of them ...
    pub count: u64,
    /// ... within this time \[s\], squelched ones included.
    pub within_s: f64,
    /// What is ordered then.
    pub order: Opcode,
    /// Addressee; without it every partition, or the supervisor for the mode table.
    pub to: Option<PartitionId>,
    /// Until the rule acts again \[s\].
    pub cool_down_s: f64,
}

impl EventRule {
    /// Why it cannot be used.
    ///
    /// # Errors
    /// Names key, value and range.
    pub fn check(&self) -> Result<(), String> {
        let event = self.event;
        if self.order.is_of_table() {
            return Err(format!("rule for '{event}': order '{}' needs a table: rules order none", self.order));
        }
        if self.order.is_of_mode() && self.to.is_some_and(|to| to != PartitionId::Supervisor) {
            return Err(format!("rule for '{event}': order '{}' is the supervisor's", self.order));
        }
        if self.count == 0 {
            return Err(format!("rule for '{event}': count = 0: must be 1 or more"));
        }
        for (name, value) in [("within_s", self.within_s), ("cool_down_s", self.cool_down_s)] {
            if !(value > 0.0 && value <= 1e6) {
                return Err(format!("rule for '{event}': {name} = {value}: must be above 0 and at most 1e6 s"));
            }
        }
        Ok(())
    }

    /// Opcode and addressee.
    #[must_use]
    pub fn order(&self) -> (Opcode, u16) {
        let otherwise = if self.order.is_of_mode() { PartitionId::Supervisor.code() } else { EVERY_PARTITION };
        (self.order, self.to.map_or(otherwise, PartitionId::code))
    }
}

/// A rule at work.
struct Watched {
    rule: EventRule,
    begin_ns: u64,
    count: u64,
    armed_ns: u64,
}

/// The rules of one life of the supervisor.
pub struct Rules(Vec<Watched>);

impl Rules {
    /// Nothing is counted yet.
    #[must_use]
    pub fn new(rules: &[EventRule]) -> Self {
        let watched = |rule: &EventRule| Watched { rule: rule.clone(), begin_ns: 0, count: 0, armed_ns: 0 };
        Rules(rules.iter().map(watched).collect())
    }

    /// Takes an event that was heard at `now_ns`, and hands what is ordered because of it to
    /// `sink`.
    ///
    /// # Errors
    /// Those of `sink`.
    pub fn hear<E>(
        &mut self,
        event: &Event,
        now_ns: u64,
        mut sink: impl FnMut(Opcode, u16) -> Result<(), E>,
    ) -> Result<(), E> {
        for watched in &mut self.0 {
            let rule = &watched.rule;
            let concerned = event.known_code() == Some(rule.event)
                && rule.partition.is_none_or(|id| id.code() == event.partition)
                && now_ns >= watched.armed_ns;
            if !concerned {
                continue;
            }
            if watched.count == 0 || now_ns.saturating_sub(watched.begin_ns) > (rule.within_s * NS_PER_S) as u64 {
                (watched.begin_ns, watched.count) = (now_ns, 0);
            }
            watched.count = watched.count.saturating_add(1).saturating_add(event.squelched);
            if watched.count >= rule.count {
                (watched.count, watched.armed_ns) = (0, now_ns + (rule.cool_down_s * NS_PER_S) as u64);
                let (opcode, to) = rule.order();
                sink(opcode, to)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    fn rule() -> EventRule {
        EventRule {
            event: EventCode::SamplesLost,
            partition: Some(PartitionId::SloshId),
            count: 3,
            within_s: 2.0,
            order: Opcode::Safe,
            to: None,
            cool_down_s: 10.0,
        }
    }

    /// Seconds at which the rule acts, of events at these.
    fn acts(at_s: &[u64], squelched: u64) -> Vec<u64> {
        let mut rules = Rules::new(&[rule()]);
        let event = Event { squelched, ..Event::new(EventCode::SamplesLost, PartitionId::SloshId, 0, &[]) };
        let mut acted = Vec::new();
        for &second in at_s {
            let mut act = |opcode: Opcode, to: u16| {
                assert_eq!((opcode, to), (Opcode::Safe, PartitionId::Supervisor.code()));
                acted.push(second);
                Ok::<(), ()>(())
            };
            rules.hear(&event, second * SECOND, &mut act).unwrap();
        }
        acted
    }

    #[test]
    fn so_many_within_the_time_give_one_order_and_then_a_pause() {
        assert_eq!(acts(&[1, 2, 3], 0), [3]);
        assert_eq!(acts(&[1, 2, 4, 5, 6], 0), [6], "three within two seconds");
        assert_eq!(acts(&[1, 1, 1, 2, 2, 2, 12, 12, 12], 0), [1, 12]);
        assert_eq!(acts(&[1], 2), [1], "squelched ones count");
    }

    #[test]
    fn other_events_and_other_partitions_do_not_count() {
        let mut rules = Rules::new(&[rule()]);
        for _ in 0..9 {
            for (code, id) in
                [(EventCode::BadSamples, PartitionId::SloshId), (EventCode::SamplesLost, PartitionId::ModalId)]
            {
                rules.hear(&Event::new(code, id, 0, &[]), 1, |_, _| Err(())).unwrap();
            }
        }
    }

    #[test]
    fn a_rule_that_cannot_work_is_refused_by_name_value_and_range() {
        assert_eq!(rule().check(), Ok(()));
        let wrong = [
            (EventRule { count: 0, ..rule() }, "count = 0"),
            (EventRule { within_s: f64::NAN, ..rule() }, "within_s = NaN"),
            (EventRule { cool_down_s: -1.0, ..rule() }, "cool_down_s = -1"),
            (EventRule { order: Opcode::LoadTable, ..rule() }, "load table"),
            (EventRule { to: Some(PartitionId::SloshId), ..rule() }, "is the supervisor's"),
        ];
        for (rule, says) in wrong {
            let refusal = rule.check().unwrap_err();
            assert!(refusal.contains(says), "{refusal}");
        }
    }
}
