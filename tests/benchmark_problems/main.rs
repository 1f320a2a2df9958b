//! The benchmark problems: truth from `plant` against models from `physics`, estimators against
//! their Cramér–Rao bound.
//!
//! `models` holds the simulated records against closed forms of the same physics. `campaigns` are
//! short seeded slices of what `obsid bench` runs in full. `faults` breaks one symbol at a time and
//! demands that a law turns red. `mission` reads back what the partition publishes.
#![forbid(unsafe_code)]

mod campaigns;
mod claims;
mod faults;
mod mission;
mod models;
mod slosh;
mod slosh_recordings;
