//! What it is: execution of partitions in frames: links, checkpoints, pacing, and the process
//! supervisor, `warden`. Shared memory, processes, clocks and signals are used in this crate alone.
//!
//! A partition is a function of frames. Its state goes into a checkpoint and comes back from it:
//!
//! ```
//! use runtime::{Frame, Outputs, Partition, StateError, restore_state, save_state};
//! use telemetry::{IMU, PartitionId, TopicId};
//!
//! struct ImuCounter(u64);
//!
//! impl Partition for ImuCounter {
//!     fn id(&self) -> PartitionId { PartitionId::InertialId }
//!     fn inputs(&self) -> &'static [TopicId] { &[IMU.id] }
//!     fn frame(&mut self, frame: &Frame<'_>, _: &mut Outputs) {
//!         self.0 += frame.samples(IMU).len() as u64;
//!     }
//!     fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
//!         save_state(&self.0, state)
//!     }
//!     fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
//!         self.0 = restore_state(state)?;
//!         Ok(())
//!     }
//! }
//!
//! let (mut checkpoint, mut restarted) = (Vec::new(), ImuCounter(0));
//! ImuCounter(1234).save(&mut checkpoint)?;
//! restarted.restore(&checkpoint)?;
//! assert_eq!(restarted.0, 1234);
//! # Ok::<(), StateError>(())
//! ```
//!
//! May import: `telemetry`, `iceoryx2`, operating-system crates.
//!
//! Must never know: equations, estimators, recordings.
//!
//! Read first: [`partition`] (what a partition is), [`inbox`] (from arrivals to frames), [`runner`]
//! (a turn).
// Unsafe code is in `sys/allocations.rs`, `sys/schedule.rs` and `sys/probes.rs` alone.
#![deny(unsafe_code)]

pub mod checkpoint;
pub mod config;
pub mod deaths;
pub mod events;
pub mod experiment;
pub mod feed;
pub mod ground;
pub mod hardening;
pub mod health;
pub mod inbox;
pub mod latency;
pub mod life;
pub mod link;
pub mod lockstep;
pub mod orders;
pub mod outbox;
pub mod pacing;
pub mod pairs;
pub mod partition;
pub mod process;
pub mod recordings;
pub mod resets;
pub mod rules;
pub mod rundir;
pub mod runner;
pub mod shm;
pub mod statistics;
pub mod sys;
pub mod table_store;
pub mod trace;
pub mod usage;
pub mod warden;
pub mod watch;

pub use config::RunConfig;
pub use partition::{Connect, ConnectError, Frame, Outputs, Partition, StateError, restore_state, save_state};
