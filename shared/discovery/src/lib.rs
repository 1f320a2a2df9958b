//! What physics a plant leaves out: hypotheses, screening, decision, prediction, the next experiment.
//!
//! May import: `channels`, `identification`, `examination`, `simulation`, `catalogue`,
//! `plant_file`, `estimation`. Must never know: files, processes, clocks, the desk. Channels come
//! in as numbers with names and SI units; findings go out as data.

#![forbid(unsafe_code)]

pub mod against_plant;
pub mod compete;
pub mod diagnose;
pub mod features;
pub mod mislabelled;
pub mod next_experiment;
pub mod omnibus;
pub mod score;
pub mod unknown_law;

#[cfg(test)]
#[path = "../../identification/src/noise.rs"]
mod noise;
#[cfg(test)]
#[path = "../../identification/src/synthetic.rs"]
mod synthetic;
// for `synthetic`, which names it as of its own crate
#[cfg(test)]
use identification::problem;
