//! Claims about the simulator, and the plants they are made about.

mod benchmarks;
mod continuation;
mod filters;
pub(crate) mod plants;
mod sampling;
