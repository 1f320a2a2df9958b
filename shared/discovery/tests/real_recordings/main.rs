//! Real recordings that nobody made for this tool: what their documentation says was left out of
//! the simple first model.
//!
//! The recordings are not part of the repository: `OBSID_RECORDINGS` names their folder, else
//! `../shared/recordings` beside the workspace is taken. Without them a test says that it skips;
//! `OBSID_REQUIRE=recordings` makes that a failure. Every test prints what the diagnosis said
//! (`--nocapture`), so that what is not asserted can be read.

mod ball_drops;
mod cantilever;
mod cubesat;
mod desk;
mod friction_damper;
mod pendulum;
mod thrown_disc;
