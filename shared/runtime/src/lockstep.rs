//! The lockstep link: partitions of one thread, one after the other; no clock, no waiting.
//!
//! Keeps the same promises as shared memory: buffers of the topic's depth that drop their oldest
//! sample, history for late joiners. A hold-back hook delays topics at random, for the chunk law
//! (architecture D2).

use crate::link::{Link, LinkError};
use crate::runner::{RunError, Runner, Turn};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use telemetry::{PartitionId, Stamps, TOPICS, TopicId};

/// Member number of a link, in the order of joining.
type Member = usize;
type Message = (Member, Stamps, Rc<[u8]>);

/// Samples of one topic in the order of arrival; each producer has the topic's depth for itself, as
/// in shared memory.
#[derive(Clone, Default)]
struct Buffer {
    messages: VecDeque<Message>,
    held: Vec<(Member, usize)>,
}

impl Buffer {
    fn push_overwriting(&mut self, message: Message, depth: usize) {
        let producer = message.0;
        let held = self.count(producer);
        if *held == depth {
            let oldest =
                self.messages.iter().position(|(of, ..)| *of == producer).expect("as many are held as were counted");
            self.messages.remove(oldest);
        } else {
            *held += 1;
        }
        self.messages.push_back(message);
    }

    fn pop(&mut self) -> Option<Message> {
        let message = self.messages.pop_front()?;
        *self.count(message.0) -= 1;
        Some(message)
    }

    fn count(&mut self, producer: Member) -> &mut usize {
        let at = self.held.iter().position(|(of, _)| *of == producer).unwrap_or_else(|| {
            self.held.push((producer, 0));
            self.held.len() - 1
        });
        &mut self.held[at].1
    }

    fn forget(&mut self, producer: Member) {
        self.messages.retain(|(of, ..)| *of != producer);
        self.held.retain(|(of, _)| *of != producer);
    }
}

#[derive(Default)]
struct Broker {
    /// Per member its buffer of each topic; empty when it has left.
    subscribers: Vec<Vec<Buffer>>,
    /// Last samples of each topic, for who joins later.
    history: Vec<Buffer>,
}

/// The medium that lockstep links share.
#[derive(Clone)]
pub struct LockstepBus(Rc<RefCell<Broker>>);

impl Default for LockstepBus {
    fn default() -> Self {
        let history = TOPICS.iter().map(|_| Buffer::default()).collect();
        LockstepBus(Rc::new(RefCell::new(Broker { subscribers: Vec::new(), history })))
    }
}

impl LockstepBus {
    /// A link of a new partition; it finds the history of every topic.
    #[must_use]
    pub fn join(&self) -> LockstepLink {
        let mut broker = self.0.borrow_mut();
        let buffers = broker.history.clone();
        broker.subscribers.push(buffers);
        LockstepLink { bus: self.clone(), member: broker.subscribers.len() - 1, hold_back: None }
    }
}

/// Decides how many samples of a topic a drain may see.
pub type HoldBack = Box<dyn FnMut(TopicId, usize) -> usize>;

/// One partition's end of the bus.
pub struct LockstepLink {
    bus: LockstepBus,
    member: Member,
    hold_back: Option<HoldBack>,
}

impl LockstepLink {
    /// Delays samples: a drain of a topic with n waiting samples sees the first
    /// `hold_back(topic, n)` of them.
    #[must_use]
    pub fn with_hold_back(mut self, hold_back: HoldBack) -> Self {
        self.hold_back = Some(hold_back);
        self
    }
}

impl Drop for LockstepLink {
    /// As with a process that dies: what was delivered stays with who got it, history goes.
    fn drop(&mut self) {
        let mut broker = self.bus.0.borrow_mut();
        broker.subscribers[self.member].clear();
        for history in &mut broker.history {
            history.forget(self.member);
        }
    }
}

impl Link for LockstepLink {
    fn publish(&mut self, topic: TopicId, stamps: &Stamps, payload: &[u8]) -> Result<(), LinkError> {
        let mut broker = self.bus.0.borrow_mut();
        let message: Message = (self.member, *stamps, Rc::from(payload));
        let depth = TOPICS[topic].depth;
        for buffers in broker.subscribers.iter_mut().filter(|buffers| !buffers.is_empty()) {
            buffers[topic].push_overwriting(message.clone(), depth);
        }
        broker.history[topic].push_overwriting(message, depth);
        Ok(())
    }

    fn drain(&mut self, topic: TopicId, sink: &mut dyn FnMut(&Stamps, &[u8])) -> Result<(), LinkError> {
        let waiting = {
            let mut broker = self.bus.0.borrow_mut();
            let buffer = &mut broker.subscribers[self.member][topic];
            let held = buffer.messages.len();
            let count = self.hold_back.as_mut().map_or(held, |hold_back| hold_back(topic, held).min(held));
            (0..count).map_while(|_| buffer.pop()).collect::<Vec<_>>()
        };
        for (_, stamps, payload) in &waiting {
            sink(stamps, payload);
        }
        Ok(())
    }

    fn refresh(&mut self) -> Result<(), LinkError> {
        Ok(())
    }

    fn wake(&mut self, _partition: PartitionId) {}

    fn now_ns(&self) -> u64 {
        0
    }
}

/// How a run in lockstep ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Every partition has finished.
    Complete,
    /// `stop` said so.
    Stopped,
}

/// Turns every partition until all have finished or `stop()` says true; `chunk(partition index)`
/// bounds the frames of each turn. However it ends, every partition completes its files.
///
/// # Errors
/// What a partition reports; [`RunError::Stalled`] when none can go on, with how far each of them
/// is.
pub fn run_to_end(
    runners: &mut [Runner<LockstepLink>],
    chunk: impl FnMut(usize) -> u64,
    stop: impl FnMut() -> bool,
) -> Result<Ending, RunError> {
    let ending = turn_all(runners, chunk, stop);
    let files = runners.iter_mut().map(Runner::finish).fold(Ok(()), Result::and);
    ending.and_then(|ending| files.map(|()| ending))
}

fn turn_all(
    runners: &mut [Runner<LockstepLink>],
    mut chunk: impl FnMut(usize) -> u64,
    mut stop: impl FnMut() -> bool,
) -> Result<Ending, RunError> {
    let mut idle_rounds = 0;
    while !stop() {
        let (mut finished, mut worked) = (0, false);
        for (index, runner) in runners.iter_mut().enumerate() {
            let turn = runner.turn(chunk(index))?;
            // Nobody watches for hangs here.
            runner.forget_heard();
            match turn {
                Turn::Finished => finished += 1,
                Turn::Worked(_) => worked = true,
                Turn::Idle => {}
            }
        }
        if finished == runners.len() {
            return Ok(Ending::Complete);
        }
        idle_rounds = if worked { 0 } else { idle_rounds + 1 };
        if idle_rounds > IDLE_ROUNDS_MAX {
            let state: Vec<String> =
                runners.iter().map(|r| format!("{} after frame {}", r.id(), r.frames_done())).collect();
            return Err(RunError::Stalled(state.join(", ")));
        }
    }
    Ok(Ending::Stopped)
}

/// A hold-back hook may starve a round; not this many in a row.
const IDLE_ROUNDS_MAX: u32 = 1000;
