//! One end of the line.

use crate::inbound::{Arrival, Inbound, Incoming};
use crate::message::{Mark, Message, Origin, PROTOCOL};
use crate::outbound::Outbound;
use crate::round_trip::RoundTrip;
use crate::{OWN_STREAMS, StreamId};
use std::collections::{BTreeMap, VecDeque};
use std::ops::RangeInclusive;

/// Between two greetings \[ms\].
const HELLO_EVERY_MS: u64 = 1000;
/// Lives of the far end that are over and known: a message of one that comes late is dropped.
const LIVES_KNOWN: usize = 16;
/// Streams of the far end that are followed.
const STREAMS_MAX: usize = 1024;

/// What both ends must agree on before a sample is believed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// One hash over everything.
    pub generation: u32,
    /// Of every kind of sample: names the one that differs.
    pub layouts: Vec<u32>,
}

/// Why the far end's samples cannot be taken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// It speaks another version of this protocol.
    Protocol { ours: u16, theirs: u16 },
    /// Its samples are laid out otherwise; `kind` is the first of [`Identity::layouts`] that
    /// differs, `None` where the lists of kinds do.
    Layout { ours: u32, theirs: u32, kind: Option<usize> },
}

/// Since the beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Samples taken for the far end.
    pub offered: u64,
    /// Messages with a sample that were sent.
    pub sent: u64,
    /// How many of them not for the first time.
    pub resent: u64,
    /// Samples given up without an acknowledgement: no room. The far end says which of them it
    /// lost.
    pub given_up: u64,
    /// Samples of the far end handed on.
    pub arrived: u64,
    /// Messages with a sample that had come before.
    pub repeated: u64,
    /// Numbers declared lost.
    pub lost: u64,
    /// Messages with a wrong checksum.
    pub damaged: u64,
    /// Messages of an earlier life of the far end, or before its greeting.
    pub stale: u64,
}

/// One end of the line between two computers.
pub struct Peer {
    life: u64,
    /// Of the samples that it sends.
    origin: Origin,
    identity: Identity,
    room: usize,
    out: BTreeMap<StreamId, Outbound>,
    inward: BTreeMap<StreamId, Inbound>,
    arrivals: VecDeque<Arrival>,
    line: RoundTrip,
    /// Life of the far end, and those before it.
    far: Option<u64>,
    far_origin: Option<Origin>,
    past: VecDeque<u64>,
    is_finished: bool,
    far_is_finished: bool,
    hello_ms: Option<u64>,
    heard_ms: Option<u64>,
    refusal: Option<Refusal>,
    counts: Counts,
}

impl Peer {
    /// An end whose `life` no other end has had, with samples of `origin`. It keeps `room`
    /// samples of a stream, at least one.
    #[must_use]
    pub fn new(life: u64, origin: Origin, identity: Identity, room: usize) -> Self {
        Peer {
            life,
            origin,
            identity,
            room: room.max(1),
            out: BTreeMap::new(),
            inward: BTreeMap::new(),
            arrivals: VecDeque::new(),
            line: RoundTrip::default(),
            far: None,
            far_origin: None,
            past: VecDeque::new(),
            is_finished: false,
            far_is_finished: false,
            hello_ms: None,
            heard_ms: None,
            refusal: None,
            counts: Counts::default(),
        }
    }

    /// Takes a sample for the far end. Marks of a stream grow.
    pub fn offer(&mut self, stream: StreamId, mark: Mark, payload: Vec<u8>) {
        self.counts.offered += 1;
        let out = self.out.entry(stream).or_insert_with(|| Outbound::new(stream, self.room));
        self.counts.given_up += out.offer(mark, payload);
    }

    /// Takes what came over the line at `now_ms`.
    pub fn hear(&mut self, bytes: &[u8], now_ms: u64) {
        let Some(message) = Message::from_bytes(bytes) else {
            self.counts.damaged += 1;
            return;
        };
        match message {
            Message::Hello { protocol, life, finished, origin, generation, layouts } => {
                if self.agrees(protocol, &Identity { generation, layouts }) && self.greet(life, origin, now_ms) {
                    self.far_is_finished = finished;
                }
            }
            Message::Data { life, stream, number, sent_ms, first, before, mark, payload }
                if self.takes(life, stream) =>
            {
                self.heard_ms = Some(now_ms);
                let inward = self.inward.entry(stream).or_insert_with(|| Inbound::new(stream));
                let (arrivals, counts) = (&mut self.arrivals, &mut self.counts);
                let mut out = |arrival: Arrival| {
                    match &arrival {
                        Arrival::Sample { .. } => counts.arrived += 1,
                        Arrival::Lost { from, to, .. } => counts.lost = counts.lost.saturating_add(to - from + 1),
                        Arrival::Begun(_) => {}
                    }
                    arrivals.insert(place_of(stream, arrivals), arrival);
                };
                let repeated = inward.take(Incoming { number, sent_ms, first, before, mark, payload }, &mut out);
                self.counts.repeated += repeated;
            }
            Message::Received { by, life, stream, through, held, echo_ms }
                if life == self.life && self.far == Some(by) =>
            {
                self.line.measure(echo_ms, now_ms);
                if let Some(out) = self.out.get_mut(&stream) {
                    out.acknowledged(through, held);
                }
            }
            Message::Data { .. } | Message::Received { .. } => self.counts.stale += 1,
        }
    }

    /// Samples are taken of the far end's present life, of a bounded number of streams.
    fn takes(&self, life: u64, stream: StreamId) -> bool {
        self.far == Some(life) && (self.inward.len() < STREAMS_MAX || self.inward.contains_key(&stream))
    }

    fn agrees(&mut self, protocol: u16, theirs: &Identity) -> bool {
        let ours = &self.identity;
        if protocol != PROTOCOL {
            self.refusal = Some(Refusal::Protocol { ours: PROTOCOL, theirs: protocol });
        } else if theirs != ours {
            let pairs = ours.layouts.iter().zip(&theirs.layouts);
            let kind = pairs.into_iter().position(|(ours, theirs)| ours != theirs);
            self.refusal = Some(Refusal::Layout { ours: ours.generation, theirs: theirs.generation, kind });
        } else {
            return true;
        }
        false
    }

    /// False for a greeting of a life that is over.
    fn greet(&mut self, life: u64, origin: Origin, now_ms: u64) -> bool {
        if self.past.contains(&life) {
            self.counts.stale += 1;
            return false;
        }
        self.heard_ms = Some(now_ms);
        if self.far != Some(life) {
            if let Some(over) = self.far.replace(life) {
                self.past.push_back(over);
                self.past.drain(..self.past.len().saturating_sub(LIVES_KNOWN));
            }
            // A message of the other life that is still on its way is none of this one's.
            self.inward.values_mut().for_each(Inbound::forget_line);
            self.out.values_mut().for_each(Outbound::send_anew);
        }
        if self.far_origin.as_ref() != Some(&origin) {
            self.inward.clear();
            self.arrivals.push_back(Arrival::Begun(origin.clone()));
            self.far_origin = Some(origin);
        }
        true
    }

    /// Hands every message that is due at `now_ms` to `send`.
    pub fn tick(&mut self, now_ms: u64, mut send: impl FnMut(Vec<u8>)) {
        if self.hello_ms.is_none_or(|last_ms| now_ms.saturating_sub(last_ms) >= HELLO_EVERY_MS) {
            self.hello_ms = Some(now_ms);
            let (Identity { generation, layouts }, origin) = (self.identity.clone(), self.origin.clone());
            let (protocol, life, finished) = (PROTOCOL, self.life, self.is_finished);
            send(Message::Hello { protocol, life, finished, origin, generation, layouts }.to_bytes());
        }
        let Some(far) = self.far.filter(|_| self.refusal.is_none()) else { return };
        // a full line drops what comes last
        for own in OWN_FIRST {
            for (&stream, inward) in self.inward.range_mut(own) {
                let Some(echo_ms) = inward.owes.take() else { continue };
                let (by, through, held) = (self.life, inward.through(), inward.held());
                send(Message::Received { by, life: far, stream, through, held, echo_ms }.to_bytes());
            }
        }
        let counts = &mut self.counts;
        let mut send = |message: Message, again: bool| {
            counts.sent += 1;
            counts.resent += u64::from(again);
            send(message.to_bytes());
        };
        for own in OWN_FIRST {
            let all = self.out.range_mut(own);
            all.for_each(|(_, out)| out.tick(self.life, now_ms, &self.line, &mut send));
        }
    }

    /// What has come out of the line and was not taken yet, in order for every stream; of the far
    /// end's own streams before what waits of its producers.
    pub fn next_arrival(&mut self) -> Option<Arrival> {
        self.arrivals.pop_front()
    }

    /// Whether this end has nothing more to say; its greetings say so.
    pub fn set_finished(&mut self, is_finished: bool) {
        self.is_finished = is_finished;
    }

    /// Whether the far end has said that it has nothing more to say.
    #[must_use]
    pub fn far_is_finished(&self) -> bool {
        self.far_is_finished
    }

    /// Everything that was offered was acknowledged or given up.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.out.values().all(Outbound::is_empty)
    }

    /// Why no sample passes; for good.
    #[must_use]
    pub fn refusal(&self) -> Option<&Refusal> {
        self.refusal.as_ref()
    }

    /// For how long the far end has said nothing \[ms\]; `None` before its first greeting.
    #[must_use]
    pub fn silent_ms(&self, now_ms: u64) -> Option<u64> {
        self.heard_ms.map(|heard_ms| now_ms.saturating_sub(heard_ms))
    }

    /// Totals since the beginning.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }
}

/// The ends' own streams, then those of producers.
const OWN_FIRST: [RangeInclusive<StreamId>; 2] = [OWN_STREAMS..=StreamId::MAX, 0..=OWN_STREAMS - 1];

/// Where the next arrival of `stream` stands among those that wait: of an own stream behind the
/// last one of these, and behind the beginning of its origin.
fn place_of(stream: StreamId, waiting: &VecDeque<Arrival>) -> usize {
    if stream < OWN_STREAMS {
        return waiting.len();
    }
    let goes_before = |arrival: &Arrival| match arrival {
        Arrival::Begun(_) => true,
        Arrival::Sample { stream, .. } | Arrival::Lost { stream, .. } => *stream >= OWN_STREAMS,
    };
    waiting.iter().rposition(goes_before).map_or(0, |last| last + 1)
}
