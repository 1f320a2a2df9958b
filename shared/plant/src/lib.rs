//! The truth: simulated spacecraft that the identification is tested against.
//!
//! What it is: any spacecraft that a plant file describes (bodies in a tree, propellant, flexible appendages, actuators, loops, sensors,
//! left-out effects) as equations (`system`) and as records of its sensors (`simulation`); how much such a record can tell
//! (`information`); and what the benchmark problems are to find in it (`arm_parameters`, `beam`, `fourier_reference`).
//!
//! May import: `nalgebra`, `libm`, `num-traits`, `serde`, `toml`, `strsim`, `thiserror`. Nothing of this workspace.
//!
//! Must never know: `physics` and `estimation`. The flight estimators use minimal-parameter closed forms; everything here is written from
//! bodies, recursions and matrix exponentials instead, so that an error in one formulation cannot hide in the other. The tests of this
//! crate hold a third one, special to each benchmark problem (`oracle`). Never: a clock, a thread, a random generator with a running
//! state. Noise is a function of (seed, stream name, sample number).
//!
//! The simulator is rebuilt from its plant and carries its changing part in a small serialisable state (`state()`, `restore()`); equal
//! plant, seed and state give equal bits.

#![forbid(unsafe_code)]

pub mod arm_parameters;
pub mod beam;
pub mod description;
pub mod dual;
pub mod effect;
pub mod effects;
pub mod file;
pub mod filter;
pub mod fourier_reference;
pub mod information;
pub mod multibody;
pub mod noise;
#[cfg(test)]
mod oracle;
pub mod real;
pub mod sensor;
pub mod signal;
pub mod simulation;
pub mod system;
pub mod validate;
mod zero_order_hold;
