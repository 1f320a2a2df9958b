//! What it is: delivery between two computers over a line that loses, delays, repeats and reorders:
//! of every stream each sample arrives once and in order, or is declared lost.
//!
//! One [`Peer`] stands at each end. It is a function of what it is offered, what it hears and the
//! time that it is given: it opens no socket and reads no clock. A sample is kept and sent again
//! until the other end acknowledges it; where the room for it ends, the oldest is given up, and the
//! other end declares it lost. [`Mark`]s are those of the producer, so that a loss before the
//! line, a restart of either end and a sample given up are all declared by one rule.
//!
//! ```
//! use delivery::{Arrival, Identity, Mark, Origin, Peer};
//!
//! let identity = Identity { generation: 7, layouts: vec![1, 2] };
//! let origin = Origin { number: 1, about: b"a run".to_vec() };
//! let mut near = Peer::new(11, origin.clone(), identity.clone(), 256);
//! let mut far = Peer::new(12, Origin::default(), identity, 256);
//! for seq in [1, 2, 4] {
//!     near.offer(0, Mark { epoch: 0, seq }, vec![seq as u8]);
//! }
//! let mut line = Vec::new();
//! for now_ms in [0, 10, 20] {
//!     near.tick(now_ms, |message| line.push(message));
//!     line.drain(..).for_each(|message| far.hear(&message, now_ms));
//!     far.tick(now_ms, |message| line.push(message));
//!     line.drain(..).for_each(|message| near.hear(&message, now_ms));
//! }
//! let mark = |seq| Mark { epoch: 0, seq };
//! let sample = |seq| Arrival::Sample { stream: 0, mark: mark(seq), payload: vec![seq as u8] };
//! let arrived: Vec<Arrival> = std::iter::from_fn(|| far.next_arrival()).collect();
//! let begun = Arrival::Begun(origin);
//! let lost = Arrival::Lost { stream: 0, from: 3, to: 3 };
//! assert_eq!(arrived, [begun, sample(1), sample(2), lost, sample(4)]);
//! assert!(near.is_idle(), "everything was acknowledged");
//! ```
//!
//! May import: a checksum and a codec.
//!
//! Must never know: sockets, clocks, what a sample is.
#![forbid(unsafe_code)]

mod inbound;
mod message;
mod outbound;
mod peer;
mod round_trip;

pub use inbound::Arrival;
pub use message::{Mark, Origin};
pub use peer::{Counts, Identity, Peer, Refusal};

/// Number of a stream of samples of one producer.
pub type StreamId = u16;

/// Streams from this number on are those of an end itself, not of a producer behind it: each life
/// of the end numbers them from 1 again. They go first on the line and come out of it first: a
/// command waits for no flood of samples.
pub const OWN_STREAMS: StreamId = 0x8000;

/// Samples of a stream that are on their way at a time: at most so many wait at the far end for
/// one that is missing.
const WINDOW: u64 = 32;
