//! Laws of whole diagnoses through the public names alone.

mod an_effect_of_its_own;
mod progress;
