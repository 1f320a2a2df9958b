//! The runtime: links, frames, checkpoints, pacing, the warden. Only this crate touches the world.
//!
//! May import: `telemetry`, `iceoryx2`, operating-system crates. Must never know: equations, estimators, recordings.
//! Read first: [`partition`] (what a partition is), [`inbox`] (from arrivals to frames), [`runner`] (a turn).
// Unsafe stands in `sys/allocations.rs` alone.
#![deny(unsafe_code)]

pub mod checkpoint;
pub mod config;
pub mod experiment;
pub mod inbox;
pub mod latency;
pub mod link;
pub mod lockstep;
pub mod outbox;
pub mod pacing;
pub mod pairs;
pub mod partition;
pub mod process;
pub mod rundir;
pub mod runner;
pub mod shm;
pub mod statistics;
pub mod sys;
pub mod warden;
pub mod watch;

pub use config::RunConfig;
pub use partition::{Connect, ConnectError, Frame, Outputs, Partition, StateError, restore_state, save_state};
