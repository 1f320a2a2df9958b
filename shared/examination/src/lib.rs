//! Examination of recordings on their own, and of two against each other.
//!
//! What it is: checks of a recording (`doctor`), comparison of a real and a simulated one
//! (`compare`), spectra (`spectrum`).
//!
//! May import: `channels`, `identification` (statistics), `estimation`, FFT. Must never know: a
//! plant's equations, files, processes, clocks.

#![forbid(unsafe_code)]

pub mod compare;
pub mod doctor;
#[cfg(test)]
#[path = "../../identification/src/noise.rs"]
mod noise;
pub mod spectrum;
