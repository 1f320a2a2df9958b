//! Records with known truth for the modal tests and campaigns.
#![allow(dead_code)]

pub mod appendage;
pub mod noise;
pub mod random_system;

/// Known mode of a generated record.
pub struct TrueMode {
    pub frequency_hz: f64,
    pub damping_ratio: f64,
}
