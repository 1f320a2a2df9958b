//! A link carries samples between partitions. Two exist, shared memory and lockstep; one
//! conformance suite tests both.

use telemetry::{PartitionId, Stamps, TopicId};

/// What went wrong between partitions.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// An operation of the transport failed.
    #[error("topic {topic}: {operation} failed: {reason}")]
    Transport { topic: &'static str, operation: &'static str, reason: String },
    /// No living process holds the service any more (or none has made it).
    #[error("topic {topic}: its service does not exist")]
    Vanished { topic: &'static str },
    /// Two builds with different layouts or topic tables met.
    #[error(
        "topic {topic}: this process was built with {what} {ours:08x}, the running system with {theirs}: \
         build every partition from one revision"
    )]
    Layout { topic: &'static str, what: &'static str, ours: u32, theirs: String },
    /// The process cannot join the shared memory.
    #[error("shared memory node: {0}")]
    Node(String),
}

/// Carries samples. Never blocks on a peer: a full buffer drops its oldest sample, and the gap
/// shows in `seq`.
pub trait Link {
    /// Sends one sample to the partitions that are connected, and to those that join while it is in
    /// the topic's history.
    ///
    /// # Errors
    /// When the transport cannot lend memory or send.
    fn publish(&mut self, topic: TopicId, stamps: &Stamps, payload: &[u8]) -> Result<(), LinkError>;

    /// Hands every sample that has arrived on `topic` to `sink`, oldest first.
    ///
    /// # Errors
    /// When the topic's service has vanished or the transport cannot receive.
    fn drain(&mut self, topic: TopicId, sink: &mut dyn FnMut(&Stamps, &[u8])) -> Result<(), LinkError>;

    /// Delivers history to partitions that joined since.
    ///
    /// # Errors
    /// When the transport cannot update its connections.
    fn refresh(&mut self) -> Result<(), LinkError>;

    /// Tells `partition` that something was sent.
    fn wake(&mut self, partition: PartitionId);

    /// Time of send for stamps \[ns\]; 0 where no clock exists.
    fn now_ns(&self) -> u64;
}
