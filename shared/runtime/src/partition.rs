//! What a partition is: a function of frames.
//!
//! A partition never sees a wake-up, a queue or a clock. The same body runs as a process over
//! shared memory, in lockstep in one thread, and offline over a recording.

use crate::config::RunConfig;
use crate::inbox::Inbox;
use telemetry::{
    Command, Mode, Opcode, PartitionId, Sample, Stamps, TELECOMMAND, TableId, TableValues, Topic, TopicId,
};
use zerocopy::IntoBytes;

/// One control period with the samples that belong to it, in an order that does not depend on
/// scheduling (architecture D1: `deploy/guide/architecture.md`).
pub struct Frame<'a> {
    /// Counted from 0.
    pub number: u64,
    /// Time at which it begins \[ns\].
    pub t_ns: u64,
    /// Its length \[ns\].
    pub period_ns: u64,
    /// The source has ended with this frame.
    pub ended: bool,
    /// Commands that are exempt from the pacing window (a partition was given up).
    pub urgent: &'a [Command],
    pub(crate) inbox: &'a Inbox,
}

impl Frame<'_> {
    /// The samples of `topic` that belong to this frame, oldest first.
    #[must_use]
    pub fn samples<T: Sample>(&self, topic: Topic<T>) -> &[T] {
        self.inbox.due(topic)
    }

    /// Stamps and payloads of any topic's samples of this frame, for a consumer that stores and
    /// does not read.
    pub fn raw(&self, topic: TopicId) -> impl Iterator<Item = (&Stamps, &[u8])> {
        self.inbox.due_raw(topic)
    }

    /// The newest mode that takes effect with this frame.
    #[must_use]
    pub fn new_mode(&self) -> Option<&Mode> {
        self.samples(telemetry::MODE).last()
    }

    /// Commands of the mode table that take effect with this frame; the runtime carries out all
    /// others.
    pub fn mode_commands(&self) -> impl Iterator<Item = Opcode> {
        let own = self.samples(TELECOMMAND).iter().filter(|one| one.is_for(PartitionId::Supervisor) && one.is_intact());
        own.filter_map(|one| Opcode::from_code(one.opcode)).filter(|opcode| opcode.is_of_mode())
    }
}

/// Samples that a partition sends with a frame. The runtime adds layout, source, sequence number,
/// CRC and time of send.
pub struct Outputs {
    words: Vec<u64>,
    items: Vec<(TopicId, usize)>,
    pub(crate) ended: bool,
}

impl Default for Outputs {
    fn default() -> Self {
        Outputs { words: Vec::with_capacity(16 * 1024), items: Vec::with_capacity(64), ended: false }
    }
}

impl Outputs {
    /// Sends `sample` on `topic` with this frame.
    pub fn publish<T: Sample>(&mut self, topic: Topic<T>, sample: &T) {
        let start = self.words.len();
        let words = size_of::<T>() / 8;
        self.words.resize(start + words, 0);
        self.words[start..].as_mut_bytes().copy_from_slice(sample.as_bytes());
        self.items.push((topic.id, start));
    }

    /// Stands in where the outputs of a partition are elsewhere for a moment.
    pub(crate) fn without_memory() -> Self {
        Outputs { words: Vec::new(), items: Vec::new(), ended: false }
    }

    /// Source only: this is the last frame.
    pub fn end(&mut self) {
        self.ended = true;
    }

    pub(crate) fn clear(&mut self) {
        self.words.clear();
        self.items.clear();
        self.ended = false;
    }

    pub(crate) fn for_each(&mut self, mut sink: impl FnMut(TopicId, &mut [u8])) {
        for &(topic, start) in &self.items {
            let words = telemetry::TOPICS[topic].size / 8;
            sink(topic, self.words[start..start + words].as_mut_bytes());
        }
    }
}

/// Why a partition cannot start.
#[derive(Debug, thiserror::Error)]
#[error("{partition} cannot start: {reason}")]
pub struct ConnectError {
    /// The one that cannot start.
    pub partition: PartitionId,
    /// Text of the cause.
    pub reason: String,
}

impl ConnectError {
    /// For `map_err`: an error of `partition` with the text of the cause.
    pub fn of<E: ToString>(partition: PartitionId) -> impl Fn(E) -> Self {
        move |error| ConnectError { partition, reason: error.to_string() }
    }
}

/// Why a checkpoint could not be written or taken up.
#[derive(Debug, thiserror::Error)]
pub enum StateError {
    /// The bytes are not a state of this build, or a value cannot be encoded.
    #[error("state does not decode: {0}")]
    Codec(#[from] postcard::Error),
    /// A file of the partition failed, or its state belongs to another scenario.
    #[error("{0}")]
    Other(String),
}

/// A partition: takes its memory where it is built ([`Connect`]), acts only in `frame` and in the
/// work that a frame leaves.
pub trait Partition: Send {
    /// Its name in the topic table; the same in every life.
    fn id(&self) -> PartitionId;
    /// Topics it consumes; `TICK` and `MODE` need not be named. The consumers in the topic table do
    /// not count.
    fn inputs(&self) -> &'static [TopicId];
    /// Source only: whether frame `number` can be opened. A source of real sensors waits for their
    /// samples.
    fn is_ready(&mut self, _number: u64) -> bool {
        true
    }
    /// Starts the threads that it computes on. A process calls it once, when files and capabilities
    /// are given up, which threads inherit, and before the right to start any is.
    fn start_threads(&mut self) {}
    /// The one place where estimator state changes.
    fn frame(&mut self, frame: &Frame<'_>, out: &mut Outputs);
    /// Whether the last frame left work that takes longer than a frame (a factorisation).
    fn has_work(&self) -> bool {
        false
    }
    /// Does the work that the last frame left; what it publishes belongs to that frame. In a
    /// process it runs on a thread of the runtime, and no frame begins before it is done.
    fn work(&mut self, _out: &mut Outputs) {}
    /// Appends everything that a restart needs to `state`.
    ///
    /// # Errors
    /// When the state cannot be encoded or a file cannot be flushed.
    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError>;
    /// Replaces its state by one that `save` wrote.
    ///
    /// # Errors
    /// When the bytes are not such a state.
    fn restore(&mut self, state: &[u8]) -> Result<(), StateError>;
    /// What a restart needs beside the state and that only grows (the rows of an experiment): a
    /// checkpoint appends what is new of it, and copies nothing.
    fn journal(&self) -> &[u8] {
        &[]
    }
    /// Takes back what [`Partition::journal`] was at the checkpoint; called behind `restore`.
    fn take_journal(&mut self, _journal: &[u8]) {}
    /// Supervisor only: whether it obeys [`Frame::mode_commands`].
    fn obeys_mode_commands(&self) -> bool {
        false
    }
    /// Values of `table` in force; `None`: it has no such table.
    fn table(&self, _table: TableId) -> Option<TableValues> {
        None
    }
    /// Takes values that were checked, between two frames; after a restart again, behind `restore`.
    fn activate(&mut self, _table: TableId, _values: &TableValues) {}
    /// Called once when the run ends or is stopped.
    ///
    /// # Errors
    /// When what it owns (a file) cannot be completed.
    fn finish(&mut self) -> Result<(), StateError> {
        Ok(())
    }
}

/// Builds a partition for a run.
pub type Connect = fn(&RunConfig) -> Result<Box<dyn Partition>, ConnectError>;

/// Appends `value` to a checkpoint.
///
/// # Errors
/// When `value` cannot be encoded.
pub fn save_state<T: serde::Serialize>(value: &T, state: &mut Vec<u8>) -> Result<(), StateError> {
    let buffer = core::mem::take(state);
    *state = postcard::to_extend(value, buffer)?;
    Ok(())
}

/// Reads a value that [`save_state`] wrote.
///
/// # Errors
/// When the bytes are not such a value.
pub fn restore_state<T: serde::de::DeserializeOwned>(state: &[u8]) -> Result<T, StateError> {
    Ok(postcard::from_bytes(state)?)
}
