//! Benchmark problems and experiment design: what they are to find, every method against its bound.
//!
//! May import: everything but services.

#![forbid(unsafe_code)]

pub mod arm_parameters;
