//! Experiments that tell more, within what the hardware allows.

pub mod inertial;
mod minimise;
pub mod slosh;
