//! Real recordings that nobody made for this tool, whole: what their documentation says was left
//! out of the simple first model. Those with a held-out part are in the golden verdicts
//! (`tests/golden/laws.rs`), which diagnose them once for both.
//!
//! The recordings are not part of the repository: `OBSID_RECORDINGS` names their folder, else
//! `../shared/recordings` beside the workspace is taken. Without them a test says that it skips;
//! `OBSID_REQUIRE=recordings` makes that a failure. Every test prints what the diagnosis said
//! (`--nocapture`), so that what is not asserted can be read.

mod cubesat;
mod desk;
mod thrown_disc;
