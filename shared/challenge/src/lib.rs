//! The blind challenge: what a diagnosis is worth on truth that it cannot know.
//!
//! What it is: benches (deployed plants) whose equations of motion are written here once more, by Lagrange and by hand; an adaptive
//! integrator that locates sticking and slipping; noise of its own; cases drawn from a seed, hidden, hashed, diagnosed, opened, scored.
//!
//! May import: `plant` for the files the tool is given and for the catalogue's names, `discovery` for its public verdict. Must never know: how
//! the tool works, and `plant`'s equations, but in the one test that both describe the same nominal plant.
//!
//! Why not `plant`'s simulator with effects? Truth and filter would share every law, every integrator step and every mistake.

#![forbid(unsafe_code)]

pub mod answer;
pub mod bench;
pub mod campaign;
pub mod case;
pub mod disturb;
pub mod equations;
pub mod excite;
pub mod hidden;
pub mod machines;
pub mod motion;
pub mod random;
pub mod realised;
pub mod score;
pub mod simulate;
pub mod whiten;
