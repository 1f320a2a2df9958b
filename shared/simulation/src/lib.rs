//! The truth: records of any plant that a description states, with noise and sensors.
//!
//! What it is: a closed-loop simulator, one control period at a time ([`Simulator`]), and whole
//! records of it ([`record`]).
//!
//! May import: `channels`, `dynamics`. Must never know: `identification`, `physics`, estimators,
//! files, a clock, a thread, a random generator with a running state. Noise is a function of (seed,
//! stream name, sample number). The simulator is rebuilt from its plant and carries its changing
//! part in a small serialisable state; equal plant, seed and state give equal bits.

#![forbid(unsafe_code)]

mod control;
mod error;
mod excitation;
pub mod fourier_reference;
mod history;
mod inputs;
mod integrator;
mod motion;
#[cfg(any(test, feature = "oracle"))]
pub mod oracle;
mod record;
mod sensing;
pub mod sensor;
mod simulator;
#[cfg(test)]
mod tests;

pub use error::SimulationError;
pub use record::{motion, record};
pub use sensing::Sample;
pub use simulator::{Row, Simulator, SimulatorState, Truth};
