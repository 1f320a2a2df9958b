//! The begin of a life: at the last checkpoint, with room for all that a life needs.

use super::{Desk, FaultHook, RunError, Runner, Timetable, Worker};
use crate::checkpoint::{Checkpoint, Store};
use crate::config::{RunConfig, Sabotage};
use crate::events::EventGate;
use crate::inbox::Inbox;
use crate::latency::FrameTimes;
use crate::link::Link;
use crate::outbox::Outbox;
use crate::pacing::Pacing;
use crate::partition::{Outputs, Partition};
use crate::trace::Trace;
use telemetry::{COMMAND, EVENT, MODE, PROGRESS, PartitionId, TELECOMMAND, TICK, TOPICS, TOPICS_MAX, TopicId};

/// Room for a partition's state in a checkpoint; more is taken when it is needed.
const STATE_BYTES: usize = 1 << 18;

/// Gives the partition back what `store` keeps of it; `None` without a checkpoint.
fn restored(partition: &mut dyn Partition, store: Option<&mut Store>) -> Result<Option<Checkpoint>, RunError> {
    let Some(store) = store else { return Ok(None) };
    let Some(checkpoint) = store.load()? else { return Ok(None) };
    partition.restore(&checkpoint.state)?;
    partition.take_journal(&store.journal(&checkpoint)?);
    Ok(Some(checkpoint))
}

/// Topics that a partition hears: its own, and those of every partition of its kind.
fn heard_topics(partition: &dyn Partition, run: &RunConfig) -> Vec<TopicId> {
    let mut topics = vec![MODE.id, PROGRESS.id, COMMAND.id, TELECOMMAND.id];
    if partition.id() != PartitionId::SensorSim {
        topics.push(TICK.id);
    }
    if partition.id() == PartitionId::Supervisor && !run.limits.rules.is_empty() {
        topics.push(EVENT.id);
    }
    topics.extend_from_slice(partition.inputs());
    topics.sort_unstable();
    topics.dedup();
    topics
}

impl<L: Link> Runner<L> {
    /// Takes the partition up at its last checkpoint, if `store` has one, and sends its last
    /// outputs again.
    ///
    /// # Errors
    /// When the checkpoint cannot be read or decoded, or the link cannot send the last outputs.
    pub fn start(
        mut partition: Box<dyn Partition>,
        link: L,
        run: &RunConfig,
        epoch: u32,
        mut store: Option<Store>,
    ) -> Result<Self, RunError> {
        let checkpoint = restored(&mut *partition, store.as_mut())?;
        let is_fresh = checkpoint.is_none();
        let mut checkpoint = checkpoint.unwrap_or_default();
        let orders = core::mem::take(&mut checkpoint.orders);
        let mut runner = Self::at(checkpoint, partition, link, run, epoch);
        runner.store = store;
        runner.begin_orders(run, orders, is_fresh);
        runner.outbox.reserve(runner.id);
        let bytes = runner.outbox.reserved_bytes() + STATE_BYTES;
        runner.store.iter_mut().for_each(|store| store.reserve(bytes));
        if let Some(pacing) = &mut runner.pacing {
            runner.given_up.iter().for_each(|&id| pacing.lose(id));
        }
        if run.sabotage != Sabotage::NoOutbox {
            runner.resend()?;
        }
        Ok(runner)
    }

    /// As it stands behind `checkpoint`: without store, orders, timetable, trace or threads.
    fn at(checkpoint: Checkpoint, partition: Box<dyn Partition>, link: L, run: &RunConfig, epoch: u32) -> Self {
        let id = partition.id();
        let topics = heard_topics(&*partition, run);
        Runner {
            inbox: Inbox::new(&topics, checkpoint.cursors, run.window_frames, run.sabotage),
            outputs: Outputs::default(),
            outbox: Outbox::from_entries(checkpoint.outbox, run.window_frames),
            pacing: (id == PartitionId::SensorSim).then(|| Pacing::new(run)),
            store: None,
            state: Vec::with_capacity(STATE_BYTES),
            seq: checkpoint.seq,
            seq_checkpointed: checkpoint.seq,
            epoch,
            frames_done: checkpoint.frames,
            frames_checkpointed: checkpoint.frames,
            began_anew: false,
            cycles: 0,
            progress_due: true,
            finished: checkpoint.ended,
            desk: Desk::default(),
            gate: EventGate::default(),
            heard_events: Vec::with_capacity(TOPICS[EVENT.id].depth),
            event_log: None,
            interval_ns: run.speed.map(|speed| ((run.period_ns as f64 / speed) as u64).max(1)),
            behind_cycles: 0,
            commands: Vec::with_capacity(8),
            urgent: Vec::with_capacity(8),
            times: FrameTimes::default(),
            fresh_ns: None,
            started_ns: link.now_ns(),
            deadline_ns: run.limits.deadline_ns(id),
            timetable: None,
            bytes_sent: 0,
            trace: None,
            period_ns: run.period_ns,
            checkpoint_frames: run.checkpoint_frames,
            faults: run.faults.clone(),
            fault_hook: None,
            corrupted: [false; TOPICS_MAX],
            heard: Vec::with_capacity(64),
            heard_by_pacing: 0,
            mode: telemetry::ModeState::Standby,
            given_up: checkpoint.given_up,
            id,
            partition: Some(partition),
            worker: None,
            spare_outputs: Some(Outputs::default()),
            away: None,
            link,
        }
    }

    /// Lets drills act: called at every point where a fault of this run may strike.
    pub fn with_fault_hook(mut self, hook: FaultHook) -> Self {
        self.fault_hook = Some(hook);
        self
    }

    /// Work that a frame leaves is done on a thread of its own from now on; the partition starts
    /// its own ones.
    pub fn work_beside(&mut self) {
        if let Some(partition) = &mut self.partition {
            partition.start_threads();
        }
        self.worker = Some(Worker::start());
    }

    /// Source: frames are due by the clock.
    pub fn keep_time(&mut self, timetable: Timetable) {
        self.timetable = Some(timetable);
    }

    /// Notes frames, sends and checkpoints from now on.
    pub fn trace_to(&mut self, trace: Trace) {
        self.trace = Some(trace);
    }
}
