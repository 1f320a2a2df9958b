//! The truth: records of any plant that a description states, with noise and sensors.
//!
//! What it is: a closed-loop simulator, one control period at a time ([`Simulator`]), and whole
//! records of it ([`record`]).
//!
//! May import: `channels`, `dynamics`. Must never know: `identification`, `physics`, estimators,
//! files, a clock, a thread, a random generator with a running state. Noise is a function of (seed,
//! stream name, sample number). The simulator is rebuilt from its plant and carries its changing
//! part in a small serialisable state; equal plant, seed and state give equal bits.
//!
//! ```
//! use simulation::{Simulator, record};
//!
//! # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../deploy/plants/pendulum.toml");
//! # let text = std::fs::read_to_string(file).unwrap();
//! # let plant = plant_file::parse(file, &text).unwrap().plant;
//! // a pendulum from its plant file, five seconds of it under seed 7
//! let recording = record(&plant, 7, 5.0, &mut |_| {})?;
//! assert_eq!(recording.channels, record(&plant, 7, 5.0, &mut |_| {})?.channels); // the same bits
//!
//! // the same, one control period at a time
//! let mut simulator = Simulator::new(&plant, 7, &plant.name)?;
//! let row = simulator.step();
//! println!("{} s: {} samples", row.time_s, row.samples.len());
//! # Ok::<(), simulation::SimulationError>(())
//! ```

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
