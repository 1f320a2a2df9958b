//! Why a description has no equations.

use crate::effect::EffectError;
use crate::multibody::ModelError;

/// Why a description has no equations.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SystemError {
    /// A reference to something the plant lacks.
    #[error("{what} names {kind} '{name}', which does not exist")]
    Unknown { what: String, kind: &'static str, name: String },
    /// The tree of bodies is not a mechanism; `name`: body, tank, mode or wheel at fault, where
    /// there is one.
    #[error("{name}: {error}")]
    Mechanism { name: String, error: ModelError },
    /// A planar plant with an axis that leaves the plane, or turns about another axis than z.
    #[error("{what}: axis {axis:?} does not belong to a plane plant (turn about z, move in x and y)")]
    OutOfPlane { what: String, axis: [f64; 3] },
    /// A coordinate of a joint without a degree of freedom of its own is required.
    #[error("{what}: joint '{joint}' is free or fixed, it has no single coordinate")]
    NoCoordinate { what: String, joint: String },
    /// Two prescribed motions of one joint.
    #[error("joint '{joint}' is prescribed twice")]
    PrescribedTwice { joint: String },
    /// An effect that is not in the catalogue, cannot sit there, or cannot be applied.
    #[error("effect '{effect}' at {site}: {reason}")]
    Effect { effect: String, site: String, reason: String },
    /// An effect that is not in the catalogue, or a part of the structure that cannot be built.
    #[error(transparent)]
    Structure(#[from] EffectError),
    /// An initial value of something that has none.
    #[error("initial value '{coordinate}': {reason}")]
    Initial { coordinate: String, reason: &'static str },
    /// An angular momentum is stated for a system that does not float.
    #[error("an angular momentum about the centre of mass is stated, but the first body is not free")]
    NotFloating,
}
