//! Bodies and the joints that carry them.

use super::Quantity;

/// How a body moves relative to its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    /// Three degrees of freedom in a planar plant, six in a spatial one.
    Free,
    Fixed,
    /// About `axis`, unit vector.
    Revolute {
        axis: [f64; 3],
    },
    /// Along `axis`, unit vector.
    Prismatic {
        axis: [f64; 3],
    },
}

/// Orientation of a joint's (or sensor's) axes at zero angle: `angle` about the unit vector `axis`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orientation {
    pub axis: [f64; 3],
    pub angle_rad: Quantity,
}

impl Default for Orientation {
    fn default() -> Self {
        Self { axis: [0.0, 0.0, 1.0], angle_rad: Quantity::known(0.0) }
    }
}

/// A joint; at zero angle or displacement the body's axes are those of the joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name of the site; by default the name of the body.
    pub name: String,
    pub kind: JointKind,
    /// Where it is on the inboard body \[m\].
    pub position_m: [Quantity; 3],
    pub orientation: Orientation,
    /// Viscous friction [N m s/rad] or [N s/m].
    pub viscous_friction: Quantity,
    /// Rotor inertia reflected to the joint [kg m²], or moving mass of the drive \[kg\].
    pub rotor_inertia: Quantity,
    /// Spring to `rest` [N m/rad] or [N/m]; zero: none.
    pub stiffness: Quantity,
    /// Rest angle \[rad\] or displacement \[m\] of the spring.
    pub rest: Quantity,
}

/// A rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    pub name: String,
    /// Name of the inboard body; `None`: inertial space.
    pub parent: Option<String>,
    pub joint: Joint,
    /// Without slosh masses, with undeformed appendages and locked wheels.
    pub mass_kg: Quantity,
    pub com_m: [Quantity; 3],
    /// About the centre of mass in body axes: xx, yy, zz, xy, xz, yz (products as in the inertia
    /// matrix, i.e. negative integrals).
    pub inertia_com_kg_m2: [Quantity; 6],
}
