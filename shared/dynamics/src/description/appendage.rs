//! Flexible appendages as modal coordinates of their hub-locked modes.

use super::Quantity;

/// A hub-locked mode, mass-normalised: `η'' + 2ζω η' + ω² η = −(δᵀ a + ρᵀ α)`, `f_hub −= δ η''`,
/// `τ_hub −= ρ η''`.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// Name of the site, unique in the plant.
    pub name: String,
    /// Hub locked \[Hz\].
    pub frequency_hz: Quantity,
    pub damping_ratio: Quantity,
    /// Participation of translation δ [√kg], body axes.
    pub translation_sqrt_kg: [Quantity; 3],
    /// Participation of rotation ρ about the origin of the body's axes [√kg m].
    pub rotation_sqrt_kg_m: [Quantity; 3],
    /// Displacement at each point of the appendage per unit of η [1/√kg], body axes; as many as
    /// `Appendage::points`.
    pub shape_per_sqrt_kg: Vec<[Quantity; 3]>,
}

/// An appendage clamped to a body, whose mass and inertia include it undeformed.
#[derive(Clone, Debug, PartialEq)]
pub struct Appendage {
    pub name: String,
    pub body: String,
    /// Points that sensors can sit at: name, undeformed position on the body \[m\].
    pub points: Vec<(String, [Quantity; 3])>,
    pub modes: Vec<Mode>,
}
