//! One stream's samples as they come in: put in order, repetitions dropped, losses declared.

use crate::message::{Mark, Origin};
use crate::{OWN_STREAMS, StreamId, WINDOW};
use std::collections::BTreeMap;

/// What came out of the line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// The far end sends samples of another origin than before (or the first): their numbers begin
    /// anew.
    Begun(Origin),
    /// The next sample of its stream.
    Sample { stream: StreamId, mark: Mark, payload: Vec<u8> },
    /// Numbers ([`Mark::seq`]) of a stream that have not come and will not come.
    Lost { stream: StreamId, from: u64, to: u64 },
}

/// A sample on its way in.
pub struct Incoming {
    pub number: u64,
    pub sent_ms: u64,
    pub first: u64,
    pub before: Mark,
    pub mark: Mark,
    pub payload: Vec<u8>,
}

/// Of one stream.
pub struct Inbound {
    stream: StreamId,
    /// Number on the line of the next sample; `None` until the sender's life is known by one.
    expected: Option<u64>,
    /// Came before one that is missing.
    held: BTreeMap<u64, (Mark, Vec<u8>)>,
    /// Of the last sample that was handed on or declared lost: it outlives the sender.
    last: Mark,
    /// An acknowledgement is due, of a sample that was sent then \[ms\].
    pub owes: Option<u64>,
}

impl Inbound {
    pub fn new(stream: StreamId) -> Self {
        Inbound { stream, expected: None, held: BTreeMap::new(), last: Mark::default(), owes: None }
    }

    /// The sender begins a new life: its numbers on the line begin anew, and those of its own
    /// streams.
    pub fn forget_line(&mut self) {
        (self.expected, self.owes) = (None, None);
        self.held.clear();
        if self.stream >= OWN_STREAMS {
            self.last = Mark::default();
        }
    }

    /// What the sender need not keep any more.
    pub fn through(&self) -> u64 {
        self.expected.map_or(0, |expected| expected - 1)
    }

    /// Which samples behind the next one are here, a bit each.
    pub fn held(&self) -> u32 {
        let behind = self.through().saturating_add(2);
        let bits = self.held.keys().filter_map(|number| number.checked_sub(behind));
        bits.filter(|bit| *bit < u64::from(u32::BITS)).fold(0, |held, bit| held | 1 << bit)
    }

    /// Takes a sample; hands on what is in order, and declares what will not come. Returns how many
    /// samples were dropped because they had come before.
    pub fn take(&mut self, incoming: Incoming, out: &mut impl FnMut(Arrival)) -> u64 {
        let Incoming { number, sent_ms, first, before, mark, payload } = incoming;
        self.owes = Some(sent_ms);
        let mut expected = *self.expected.get_or_insert(first.max(1));
        let mut repeated = 0;
        if first > expected {
            // The sender has given up what is missing below `first`.
            while let Some(entry) = self.held.first_entry().filter(|entry| *entry.key() < first) {
                let (mark, payload) = entry.remove();
                repeated += u64::from(!self.hand_on(mark, payload, out));
            }
            self.declare_through(before.seq, out);
            self.last = self.last.max(before);
            expected = first;
        }
        let is_wanted = (expected..expected.saturating_add(WINDOW)).contains(&number);
        if !is_wanted || self.held.contains_key(&number) {
            repeated += 1;
        } else {
            self.held.insert(number, (mark, payload));
        }
        while let Some((mark, payload)) = self.held.remove(&expected) {
            repeated += u64::from(!self.hand_on(mark, payload, out));
            expected += 1;
        }
        self.expected = Some(expected);
        repeated
    }

    /// A sample in the order of the line; false for one that an earlier life of the sender brought.
    fn hand_on(&mut self, mark: Mark, payload: Vec<u8>, out: &mut impl FnMut(Arrival)) -> bool {
        let is_new = mark > self.last;
        if is_new {
            self.declare_through(mark.seq.saturating_sub(1), out);
            self.last = mark;
            out(Arrival::Sample { stream: self.stream, mark, payload });
        }
        is_new
    }

    fn declare_through(&mut self, to: u64, out: &mut impl FnMut(Arrival)) {
        let from = self.last.seq.saturating_add(1);
        if from <= to {
            out(Arrival::Lost { stream: self.stream, from, to });
        }
    }
}
