//! Conditions on a description of a mechanism, and the errors of each.

use super::{JointKind, Link};
use core::fmt;
use nalgebra::Matrix3;

/// Why a description is no mechanism.
#[derive(Clone, Debug, PartialEq)]
pub enum ModelError {
    /// No link at all.
    Empty,
    /// A parent must precede its children.
    ParentNotBefore {
        link: usize,
        parent: usize,
    },
    /// A number that is not finite.
    NotFinite {
        link: usize,
        field: &'static str,
    },
    /// The length of an axis differs from one.
    AxisNotUnit {
        link: usize,
        length: f64,
    },
    /// `rotation` is not orthogonal with determinant one: the largest entry of `RᵀR − 1` or
    /// `|det − 1|`.
    NotARotation {
        link: usize,
        error: f64,
    },
    NegativeMass {
        link: usize,
        mass_kg: f64,
    },
    /// The inertia about the centre of mass is not symmetric or has a negative principal value.
    InertiaNotPositive {
        link: usize,
        smallest_kg_m2: f64,
    },
    /// Negative, or given to a joint that is not revolute or prismatic.
    Armature {
        link: usize,
        armature: f64,
    },
    /// An internal coordinate on a link that does not exist.
    NoSuchLink {
        internal: usize,
        link: usize,
    },
    InternalMass {
        internal: usize,
        mass: f64,
    },
    /// Kinetic energy is not positive for a motion of this velocity coordinate: the mass that moves
    /// with it is too small.
    MassMatrixNotPositive {
        v_index: usize,
        pivot: f64,
    },
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "no link"),
            Self::ParentNotBefore { link, parent } => {
                write!(f, "link {link}: its parent {parent} does not come before it")
            }
            Self::NotFinite { link, field } => write!(f, "link {link}: {field} is not finite"),
            Self::AxisNotUnit { link, length } => write!(f, "link {link}: joint axis has length {length}, not 1"),
            Self::NotARotation { link, error } => write!(f, "link {link}: rotation is off orthogonal by {error:.1e}"),
            Self::NegativeMass { link, mass_kg } => write!(f, "link {link}: mass {mass_kg} kg is negative"),
            Self::InertiaNotPositive { link, smallest_kg_m2 } => {
                write!(f, "link {link}: smallest principal moment of inertia is {smallest_kg_m2} kg m²")
            }
            Self::Armature { link, armature } => {
                write!(
                    f,
                    "link {link}: rotor inertia {armature} needs a revolute or prismatic joint and a positive value"
                )
            }
            Self::NoSuchLink { internal, link } => write!(f, "internal coordinate {internal}: there is no link {link}"),
            Self::InternalMass { internal, mass } => {
                write!(f, "internal coordinate {internal}: mass {mass} is not positive")
            }
            Self::MassMatrixNotPositive { v_index, pivot } => write!(
                f,
                "velocity coordinate {v_index} moves no inertia (pivot {pivot:.1e}): give its link a mass or inertia, or a smaller modal participation"
            ),
        }
    }
}

impl core::error::Error for ModelError {}

/// The first thing that makes link `i` no link.
pub(super) fn check_link(i: usize, link: &Link) -> Result<(), ModelError> {
    if let Some(parent) = link.parent.filter(|parent| *parent >= i) {
        return Err(ModelError::ParentNotBefore { link: i, parent });
    }
    let finite = [
        ("position", link.position_m.iter().all(|x| x.is_finite())),
        ("rotation", link.rotation.iter().all(|x| x.is_finite())),
        ("mass", link.mass_kg.is_finite()),
        ("centre of mass", link.com_m.iter().all(|x| x.is_finite())),
        ("inertia", link.inertia_com_kg_m2.iter().all(|x| x.is_finite())),
        ("rotor inertia", link.armature.is_finite()),
    ];
    if let Some((field, _)) = finite.iter().find(|(_, finite)| !finite) {
        return Err(ModelError::NotFinite { link: i, field });
    }
    if let JointKind::Revolute { axis } | JointKind::Prismatic { axis } = link.joint {
        let length = axis.norm();
        // a description gives at least ten digits
        if length.is_nan() || (length - 1.0).abs() > 1e-9 {
            return Err(ModelError::AxisNotUnit { link: i, length });
        }
    }
    let error = (link.rotation.transpose() * link.rotation - Matrix3::identity()).amax();
    let error = error.max((link.rotation.determinant() - 1.0).abs());
    if error > 1e-9 {
        return Err(ModelError::NotARotation { link: i, error });
    }
    if link.mass_kg < 0.0 {
        return Err(ModelError::NegativeMass { link: i, mass_kg: link.mass_kg });
    }
    check_inertia(i, &link.inertia_com_kg_m2)?;
    let turns_or_slides = matches!(link.joint, JointKind::Revolute { .. } | JointKind::Prismatic { .. });
    if link.armature < 0.0 || (link.armature != 0.0 && !turns_or_slides) {
        return Err(ModelError::Armature { link: i, armature: link.armature });
    }
    Ok(())
}

fn check_inertia(link: usize, inertia: &Matrix3<f64>) -> Result<(), ModelError> {
    let tolerance = 1e-9 * inertia.amax(); // a description gives at least ten digits
    let asymmetry = (inertia - inertia.transpose()).amax();
    let smallest_kg_m2 = inertia.symmetric_eigenvalues().min();
    if asymmetry > tolerance || smallest_kg_m2 < -tolerance {
        return Err(ModelError::InertiaNotPositive { link, smallest_kg_m2 });
    }
    Ok(())
}
