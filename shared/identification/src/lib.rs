//! The likelihood of a plant with unknown parameters: linearised filter, fit, information, prediction of held-out data.
//!
//! What it is: recordings matched to a plant (`problem`), their innovations and gradients (`filter`), maximum a posteriori fits of
//! parameters and noise (`fit`), what an experiment would tell (`information`), prediction of data that were not fitted (`held_out`),
//! work counted alike on every machine (`work`).
//!
//! May import: `dynamics`, `catalogue`, `estimation`. Flight partitions may import it. Must never know: `simulation`, files, clocks,
//! threads' order, what is decided from it.

#![forbid(unsafe_code)]

pub mod dot;
pub mod filter;
pub mod fit;
pub mod held_out;
pub mod information;
#[cfg(test)]
mod noise;
pub mod problem;
pub mod series;
pub mod statistics;
#[cfg(test)]
mod synthetic;
pub mod work;
