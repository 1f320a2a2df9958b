//! The front door: what a user sees of `obsid`, through the binary itself.
//!
//! Every claim about a message, an exit code or a key of `--json` is tested on the program, with
//! files as a user has them. Processes over shared memory appear only where they are the point.
#![forbid(unsafe_code)]

mod bad_recordings;
mod bad_scenarios;
mod clocks;
mod command_line;
mod craft;
mod desk;
mod diagnose;
mod documents;
mod ends;
mod identify;
mod imports;
mod inputs;
mod interruptions;
mod modal;
mod modal_records;
mod modal_structure;
mod objects;
mod own_recordings;
mod plants;
mod readme;
mod real_recordings;
mod recordings_verbs;
mod runs;
