//! One stream's samples on their way out: kept until acknowledged, in bounded room.

use crate::message::{Mark, Message};
use crate::round_trip::RoundTrip;
use crate::{StreamId, WINDOW};
use std::collections::VecDeque;

struct Kept {
    mark: Mark,
    payload: Vec<u8>,
    /// How often it was sent, and when last \[ms\].
    times: u32,
    sent_ms: u64,
    /// It waits at the far end for one before it.
    has_arrived: bool,
}

/// Samples `first..first + kept.len()` of a stream.
pub struct Outbound {
    stream: StreamId,
    room: usize,
    kept: VecDeque<Kept>,
    first: u64,
    /// Mark of sample `first - 1`.
    before: Mark,
}

impl Outbound {
    pub fn new(stream: StreamId, room: usize) -> Self {
        Outbound { stream, room, kept: VecDeque::new(), first: 1, before: Mark::default() }
    }

    /// Takes a sample; gives up the oldest one where there is no room, and returns how many.
    pub fn offer(&mut self, mark: Mark, payload: Vec<u8>) -> u64 {
        self.kept.push_back(Kept { mark, payload, times: 0, sent_ms: 0, has_arrived: false });
        let surplus = self.kept.len().saturating_sub(self.room);
        (0..surplus).for_each(|_| self.forget_first());
        surplus as u64
    }

    fn forget_first(&mut self) {
        if let Some(first) = self.kept.pop_front() {
            self.before = first.mark;
            self.first += 1;
        }
    }

    /// Every sample through `through` has arrived, and those of `held` behind the next one.
    pub fn acknowledged(&mut self, through: u64, held: u32) {
        while self.first <= through && !self.kept.is_empty() {
            self.forget_first();
        }
        for (kept, number) in self.kept.iter_mut().zip(self.first..) {
            let bit = number.checked_sub(through.saturating_add(2)).filter(|bit| *bit < u64::from(u32::BITS));
            kept.has_arrived |= bit.is_some_and(|bit| held >> bit & 1 == 1);
        }
    }

    /// Everything was acknowledged.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// Hands what is due to `send`: what was never sent, and what was not acknowledged in time.
    pub fn tick(&mut self, life: u64, now_ms: u64, line: &RoundTrip, send: &mut impl FnMut(Message, bool)) {
        let (stream, first, before) = (self.stream, self.first, self.before);
        for (kept, number) in self.kept.iter_mut().zip(first..first + WINDOW) {
            let waits =
                kept.times > 0 && now_ms.saturating_sub(kept.sent_ms) < line.time_out_ms(kept.times, kept.sent_ms);
            if waits || kept.has_arrived {
                continue;
            }
            (kept.times, kept.sent_ms) = (kept.times + 1, now_ms);
            let payload = kept.payload.clone();
            send(
                Message::Data { life, stream, number, sent_ms: now_ms, first, before, mark: kept.mark, payload },
                kept.times > 1,
            );
        }
    }

    /// The far end is another one: nothing was sent to it yet.
    pub fn send_anew(&mut self) {
        self.kept.iter_mut().for_each(|kept| (kept.times, kept.has_arrived) = (0, false));
    }
}
