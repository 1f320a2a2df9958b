//! What differs between a recording and a simulation, and what physics was left out.
//!
//! What it is: checks of a recording on its own, comparison of two recordings, and the search for missing physics.
//!
//! May import: `plant`, `modal`, `estimation`, FFT and statistics crates. Must never know: files, processes, clocks, the desk.
//! Channels come in as numbers with names and SI units; findings go out as data.

#![forbid(unsafe_code)]

pub mod compare;
pub mod compete;
pub mod diagnose;
pub mod doctor;
pub mod features;
pub mod filter;
pub mod fit;
pub mod held_out;
pub mod next_experiment;
pub mod omnibus;
pub mod problem;
pub mod score;
pub mod series;
pub mod spectrum;
pub mod statistics;
pub mod unknown_law;
pub mod work;

#[cfg(test)]
mod noise;
#[cfg(test)]
mod synthetic;
