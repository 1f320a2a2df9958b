//! What differs between a recording and a simulation, and what physics was left out.
//!
//! What it is: checks of a recording on its own, comparison of two recordings, and the search for missing physics.
//!
//! May import: `plant`, `modal`, `estimation`, FFT and statistics crates. Must never know: files, processes, clocks, the desk.
//! Channels come in as numbers with names and SI units; findings go out as data.

#![forbid(unsafe_code)]

pub mod compare;
pub mod doctor;
pub mod series;
pub mod spectrum;
pub mod statistics;

#[cfg(test)]
mod noise;
