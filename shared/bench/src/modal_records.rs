//! Records as they are: structures drawn at random, recorded with every defect that real records
//! have, and read as a user's file is (intake, examination, identification).
//!
//! A mode counts as identifiable, and as missed if it is not found, where
//!
//! - its damping could be known to 22 %: `σ_ζ/ζ = (2πζfT)^(−1/2)`, T the time of the samples that
//!   exist, so that `2πζfT ≥ 20` (the identifier reports modes from three deviations on);
//! - it lies below 0.4 of the rate at which the sensors are updated;
//! - its half-power band overlaps no other mode's, where the record shows them: a mode above half
//!   the rate of the sensors folds.
//!
//! A mode that is found without being identifiable counts neither as missed nor as invented.

mod campaign;
pub mod defects;
pub mod generator;
pub mod known_input;
mod responding;
pub mod responses;
pub mod structure;

pub use campaign::{Figures, figures};

/// Names of all kinds of record, in the order of the rows.
#[must_use]
pub fn names() -> Vec<&'static str> {
    let defects = defects::Defect::ALL.into_iter().map(defects::Defect::name);
    let inputs = known_input::KINDS.iter().map(|(name, _)| *name);
    defects.chain(responses::KINDS.into_iter().map(responses::Kind::name)).chain(inputs).collect()
}
