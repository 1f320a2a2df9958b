//! Drives one partition over one link: the same code in a process and in lockstep.
//!
//! A turn drains the link, runs every frame that is complete, sends outputs, checkpoints and
//! reports progress. It never waits: who calls it decides whether to sleep.

mod events;
mod faults;
mod figures;
mod orders;
mod out;
mod start;
mod timetable;
mod worker;

pub use orders::{TablePlaces, TableReport};
pub use timetable::Timetable;

use crate::checkpoint::{CheckpointError, Store};
use crate::config::{Fault, KillPoint};
use crate::events::{EventGate, EventLog};
use crate::inbox::Inbox;
use crate::latency::FrameTimes;
use crate::link::{Link, LinkError};
use crate::outbox::Outbox;
use crate::pacing::Pacing;
use crate::partition::{Frame, Outputs, Partition, StateError};
use crate::trace::{Mark, Trace};
use orders::Desk;
use telemetry::{
    COMMAND, Command, EVENT, Event, EventCode, Header, PROGRESS, PartitionId, Progress, TICK, TOPICS, TOPICS_MAX, Tick,
};
use worker::{Worker, WorkerEnded};

/// Why a partition cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The link between partitions failed.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The checkpoint cannot be read or written.
    #[error("checkpoint: {0}")]
    Checkpoint(#[from] CheckpointError),
    /// The partition's state cannot be encoded or decoded.
    #[error("state: {0}")]
    State(#[from] StateError),
    /// Lockstep only: a whole round without progress before the end of the run.
    #[error("no partition can go on: {0}")]
    Stalled(String),
}

/// Result of a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// Frames were processed.
    Worked(u64),
    /// No frame was complete.
    Idle,
    /// The last frame is done and checkpointed.
    Finished,
}

/// Of a checkpoint that a kill cuts, unless the drill says where.
const HALF_PERMILLE: u32 = 500;

/// A frame whose outputs have not been sent.
#[derive(Clone, Copy)]
struct Begun {
    tick: Tick,
    started_ns: u64,
    /// Send of its newest sample; 0 without one.
    newest_ns: u64,
    /// Mode that came into force with it.
    entered: Option<telemetry::ModeState>,
}

fn worker_ended(WorkerEnded: WorkerEnded) -> RunError {
    RunError::State(StateError::Other("the work that a frame left ended by a panic".into()))
}

/// Where a partition kills itself in a drill.
pub type FaultHook = fn(&Fault);

/// One partition, its link, its queues, its checkpoints.
pub struct Runner<L: Link> {
    id: PartitionId,
    /// None while it works on the worker's thread.
    partition: Option<Box<dyn Partition>>,
    worker: Option<Worker>,
    /// Stands in for those that are away.
    spare_outputs: Option<Outputs>,
    /// The frame whose work is not done.
    away: Option<Begun>,
    link: L,
    inbox: Inbox,
    outputs: Outputs,
    outbox: Outbox,
    /// Some for the source.
    pacing: Option<Pacing>,
    store: Option<Store>,
    /// The partition's own part of a checkpoint, as last written.
    state: Vec<u8>,
    seq: [u64; TOPICS_MAX],
    seq_checkpointed: [u64; TOPICS_MAX],
    epoch: u32,
    frames_done: u64,
    frames_checkpointed: u64,
    began_anew: bool,
    cycles: u64,
    progress_due: bool,
    finished: bool,
    desk: Desk,
    gate: EventGate,
    /// Of all partitions, for a supervisor with rules.
    heard_events: Vec<Event>,
    event_log: Option<EventLog>,
    /// In real time: between two frames \[ns\].
    interval_ns: Option<u64>,
    /// Whole periods by which the last frame began late.
    behind_cycles: u64,
    commands: Vec<Command>,
    urgent: Vec<Command>,
    times: FrameTimes,
    /// End of the first frame whose samples were sent in this life.
    fresh_ns: Option<u64>,
    started_ns: u64,
    deadline_ns: u64,
    /// Source at `--speed`: when its frames are due.
    timetable: Option<Timetable>,
    bytes_sent: u64,
    trace: Option<Trace>,
    period_ns: u64,
    checkpoint_frames: u64,
    faults: Vec<Fault>,
    fault_hook: Option<FaultHook>,
    /// By topic: its damaged copy was sent.
    corrupted: [bool; TOPICS_MAX],
    /// Progress of the others, for the caller (hang watch, end of run).
    heard: Vec<Progress>,
    heard_by_pacing: usize,
    mode: telemetry::ModeState,
    given_up: Vec<PartitionId>,
}

impl<L: Link> Runner<L> {
    /// When frames are due, of a source that follows the clock.
    #[must_use]
    pub fn timetable(&self) -> Option<Timetable> {
        self.timetable
    }
    /// For waits, which are the caller's.
    pub fn trace_mut(&mut self) -> Option<&mut Trace> {
        self.trace.as_mut()
    }
    /// For a caller that waits on the link between turns.
    pub fn link_mut(&mut self) -> &mut L {
        &mut self.link
    }
    /// Makes room for the next progress reports.
    pub fn forget_heard(&mut self) {
        self.heard_by_pacing = 0;
        self.heard.clear();
    }

    /// Drains, then runs at most `frames_max` frames.
    ///
    /// # Errors
    /// When the link, a checkpoint or the partition's own file fails.
    pub fn turn(&mut self, frames_max: u64) -> Result<Turn, RunError> {
        self.cycles += 1;
        self.drain()?;
        let mut frames = self.welcome_back()?;
        while self.away.is_none() && !self.finished && frames < frames_max {
            let frame = if self.pacing.is_some() { self.open_frame() } else { self.next_frame() };
            let Some(tick) = frame else { break };
            self.run_frame(&tick)?;
            frames += 1;
        }
        if self.progress_due {
            self.report_checkpoint()?;
        }
        match frames {
            _ if self.finished => Ok(Turn::Finished),
            0 => Ok(Turn::Idle),
            frames => Ok(Turn::Worked(frames)),
        }
    }

    /// Ends the partition's own business (files) in order.
    ///
    /// # Errors
    /// When the partition's own file cannot be completed.
    pub fn finish(&mut self) -> Result<(), RunError> {
        if self.away.take().is_some()
            && let Some((partition, _)) = self.worker.as_ref().and_then(|worker| worker.receive().ok())
        {
            self.partition = Some(partition);
        }
        Ok(self.partition.as_mut().map_or(Ok(()), |partition| partition.finish())?)
    }

    fn drain(&mut self) -> Result<(), RunError> {
        // The tick first: whatever it covers was sent before it, so it is there when its topic is
        // drained after it.
        for topic in core::iter::once(TICK.id).chain((0..TOPICS.len()).filter(|&topic| topic != TICK.id)) {
            let (inbox, heard, commands) = (&mut self.inbox, &mut self.heard, &mut self.commands);
            let events = &mut self.heard_events;
            self.link.drain(topic, &mut |stamps, payload| {
                if inbox.arrive(topic, stamps, payload) {
                    // Read from the inbox's copy, never again from shared memory: a peer may write
                    // in between.
                    heard.extend(inbox.newest(PROGRESS).filter(|_| topic == PROGRESS.id));
                    commands.extend(inbox.newest(COMMAND).filter(|_| topic == COMMAND.id));
                    events.extend(inbox.newest(EVENT).filter(|_| topic == EVENT.id));
                }
            })?;
        }
        self.obey();
        Ok(())
    }

    /// What reaches a partition outside its frames: progress of the others for the source, and who
    /// was given up.
    fn obey(&mut self) {
        if let Some(pacing) = &mut self.pacing {
            self.heard[self.heard_by_pacing..].iter().for_each(|progress| pacing.hear(progress));
            self.heard_by_pacing = self.heard.len();
            self.commands.iter().for_each(|command| pacing.obey(command));
        }
        for command in self.commands.drain(..) {
            // A restarted supervisor or a topic's history says it again: a partition is lost once.
            if let Some(id) = crate::pacing::given_up(&command).filter(|id| !self.given_up.contains(id)) {
                self.given_up.push(id);
                self.urgent.push(command);
            }
        }
    }

    /// Source: the next frame, if pacing and arrivals allow it.
    fn open_frame(&mut self) -> Option<Tick> {
        let pacing = self.pacing.as_ref()?;
        let number = self.frames_done;
        let last_seq = pacing.permit(number)?;
        let mut wanted = last_seq;
        wanted[TICK.id] = 0;
        if !self.inbox.has_all(&wanted) || !self.partition.as_mut().is_some_and(|source| source.is_ready(number)) {
            return None;
        }
        Some(Tick {
            header: Header::at(number * self.period_ns),
            frame: number,
            t_ns: number * self.period_ns,
            flags: 0,
            last_seq,
        })
    }

    /// Consumer: the next frame, if its tick and all that it covers have arrived.
    fn next_frame(&mut self) -> Option<Tick> {
        let tick = self.inbox.next_tick()?;
        self.inbox.has_all(&tick.last_seq).then_some(tick)
    }

    fn run_frame(&mut self, tick: &Tick) -> Result<(), RunError> {
        self.strike(KillPoint::Frame, tick.frame);
        // Without a checkpoint a life begins with frame 0, unless the others are far beyond it.
        self.began_anew |= self.frames_done == 0 && tick.frame > 0;
        let started_ns = self.link.now_ns();
        self.inbox.collect(tick.frame, &tick.last_seq);
        self.carry_out_commands(tick.frame)?;
        let mut newest_ns = 0;
        for sent_ns in self.inbox.sent_ns() {
            self.times.latency.record(started_ns.saturating_sub(sent_ns));
            newest_ns = newest_ns.max(sent_ns);
        }
        self.outputs.clear();
        let mut entered = None;
        let frame = Frame {
            number: tick.frame,
            t_ns: tick.t_ns,
            period_ns: self.period_ns,
            ended: tick.flags & 1 == 1,
            urgent: &self.urgent,
            inbox: &self.inbox,
        };
        if let Some(state) = frame.new_mode().and_then(|mode| telemetry::ModeState::from_code(mode.state)) {
            entered = (state != self.mode).then_some(state);
            self.mode = state;
            if let Some(trace) = &mut self.trace {
                trace.mark(Mark::Mode, state.code().into(), started_ns, started_ns);
            }
        }
        let partition = self.partition.as_mut().expect("at home while no work is away");
        partition.frame(&frame, &mut self.outputs);
        self.urgent.clear();
        let begun = Begun { tick: *tick, started_ns, newest_ns, entered };
        if partition.has_work() {
            let Some(worker) = &self.worker else {
                partition.work(&mut self.outputs);
                return self.complete(&begun);
            };
            let partition = self.partition.take().expect("at home while no work is away");
            let outputs = core::mem::replace(&mut self.outputs, self.spare_outputs.take().unwrap_or_default());
            worker.send(partition, outputs).map_err(worker_ended)?;
            self.away = Some(begun);
            return Ok(());
        }
        self.complete(&begun)
    }

    /// One partition says it for all.
    fn note_mode(&mut self, entered: Option<telemetry::ModeState>) -> Result<(), RunError> {
        match entered.filter(|_| self.id == PartitionId::Supervisor) {
            Some(state) => self.event(EventCode::ModeEntered, &[state.code().into()]),
            None => Ok(()),
        }
    }

    /// Takes the partition back when its work is done; the number of frames that are complete now.
    fn welcome_back(&mut self) -> Result<u64, RunError> {
        let (Some(begun), Some(worker)) = (self.away, &self.worker) else { return Ok(0) };
        let Some((partition, outputs)) = worker.try_receive().map_err(worker_ended)? else { return Ok(0) };
        self.spare_outputs = Some(core::mem::replace(&mut self.outputs, outputs));
        (self.partition, self.away) = (Some(partition), None);
        self.complete(&begun)?;
        Ok(1)
    }

    /// Sends what the frame published, and closes it.
    fn complete(&mut self, begun: &Begun) -> Result<(), RunError> {
        let Begun { tick, started_ns, newest_ns, entered } = begun;
        let ended = if self.pacing.is_some() { self.outputs.ended } else { tick.flags & 1 == 1 };
        self.send_outputs(tick, ended)?;
        self.note_times(tick.frame, *started_ns, *newest_ns)?;
        self.release_commands(tick.frame);
        self.note_mode(*entered)?;
        self.flood()?;
        self.strike(KillPoint::Publish, tick.frame);
        self.frames_done = tick.frame.saturating_add(1);
        self.outbox.forget_before(self.frames_done);
        self.finished = ended;
        if ended || self.frames_done.is_multiple_of(self.checkpoint_frames) {
            self.checkpoint()?;
        }
        Ok(())
    }
}
