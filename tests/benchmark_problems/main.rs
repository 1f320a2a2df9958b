//! The benchmark problems: truth from `plant` against models from `physics`, estimators against their Cramér–Rao bound.
//!
//! `models` compares two formulations of the same physics state by state. `campaigns` are short seeded slices of what
//! `obsid bench` runs in full. `faults` breaks one symbol at a time and demands that a law turns red.
#![forbid(unsafe_code)]

mod campaigns;
mod claims;
mod faults;
mod models;
