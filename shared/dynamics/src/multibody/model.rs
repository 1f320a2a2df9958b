//! Description of a tree of bodies, and its compiled constants.
//!
//! A link's frame is its joint's frame: the origin lies on the joint's axis, and at `q = 0` the
//! frame is turned by `rotation` against the parent's. Everything that does not depend on the state
//! is computed here once.

use super::vector::{M3, Sym3, V3};
use nalgebra::{Matrix3, Vector3};

mod check;
mod compile;

pub use check::ModelError;

/// How a link may move against its parent (or the world).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    /// `q = [x, y, z, qw, qx, qy, qz]` (link → joint frame at rest), `v = [ω, v]` of the link's
    /// origin, link axes.
    FreeSpatial,
    /// In the x–y plane of the joint frame: `q = [x, y, θ]`, `v = [ω_z, v_x, v_y]`, link axes.
    FreePlanar,
    Fixed,
    /// `axis`: unit vector, joint frame (= link frame).
    Revolute {
        axis: Vector3<f64>,
    },
    /// `axis`: unit vector, joint frame (= link frame).
    Prismatic {
        axis: Vector3<f64>,
    },
}

impl JointKind {
    /// Numbers in `q`.
    pub const fn q_len(&self) -> usize {
        match self {
            Self::FreeSpatial => 7,
            Self::FreePlanar => 3,
            Self::Fixed => 0,
            Self::Revolute { .. } | Self::Prismatic { .. } => 1,
        }
    }

    /// Numbers in `v`.
    pub const fn v_len(&self) -> usize {
        match self {
            Self::FreeSpatial => 6,
            Self::FreePlanar => 3,
            Self::Fixed => 0,
            Self::Revolute { .. } | Self::Prismatic { .. } => 1,
        }
    }
}

/// A rigid link and the joint that carries it.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Index of the carrying link; `None`: the world.
    pub parent: Option<usize>,
    pub joint: JointKind,
    /// Origin of the joint frame in the parent's frame.
    pub position_m: Vector3<f64>,
    /// Joint frame → parent frame at `q = 0`.
    pub rotation: Matrix3<f64>,
    pub mass_kg: f64,
    /// Centre of mass, link frame.
    pub com_m: Vector3<f64>,
    /// About the centre of mass, link axes.
    pub inertia_com_kg_m2: Matrix3<f64>,
    /// Inertia of the rotor reflected through its gear, on the joint's own diagonal [kg m², or kg
    /// for a prismatic joint].
    pub armature: f64,
}

/// A coordinate inside a link with constant coupling: `T = ½ vᵀ I v + vᵀ D η̇ + ½ m η̇²`.
///
/// A flexible mode: `mass = 1`, `D` its participation. A reaction wheel: `mass = J_w`,
/// `D = [axis J_w; 0]`, the link's inertia containing the wheel locked. The position `η` is the
/// caller's; stiffness and damping come in through `tau`.
///
/// The Lagrangian is left-invariant (it sees body velocities alone), so momentum and energy are
/// conserved exactly; it is not invariant against a uniform translation when `D` has a linear part,
/// since the shift of the centre of mass with `η` is neglected: the world must move along with the
/// spacecraft, not with the Earth.
/// [`Data::set_internal_positions`](super::Data::set_internal_positions) brings that shift in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InternalCoordinate {
    pub link: usize,
    pub mass: f64,
    /// `D`: [angular; linear], about the link's origin, link axes.
    pub coupling: [f64; 6],
}

/// A joint with the constants of its equations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // read in the inner loop: no indirection, and trees are small
pub(crate) enum Joint {
    FreeSpatial,
    FreePlanar,
    Fixed,
    /// Rotation to the parent: `along + across cos q + turned sin q`.
    Revolute {
        axis_in_parent: V3<f64>,
        along: M3<f64>,
        across: M3<f64>,
        turned: M3<f64>,
    },
    Prismatic {
        axis_in_parent: V3<f64>,
    },
}

/// Constants of one link. Index 0 of the frames is the world, so `parent` is one more than in
/// [`Link`].
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LinkConstants {
    pub parent: usize,
    /// The link of its tree that the world carries.
    pub root: usize,
    pub joint: Joint,
    pub q: usize,
    pub v: usize,
    pub v_len: usize,
    pub position: V3<f64>,
    pub rotation: M3<f64>,
    /// The parent is the world and `rotation` is I: no rotation is computed.
    pub along_world: bool,
    pub mass: f64,
    pub com: V3<f64>,
    /// `m c`.
    pub first_moment: V3<f64>,
    /// About the link's origin.
    pub inertia_origin: Sym3<f64>,
    pub armature: f64,
}

/// Constants of one internal coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct InternalConstants {
    pub link: usize,
    pub v: usize,
    pub mass: f64,
    pub angular: V3<f64>,
    pub linear: V3<f64>,
}

/// A compiled tree of bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    pub(crate) links: Vec<LinkConstants>,
    pub(crate) internals: Vec<InternalConstants>,
    pub(crate) gravity: V3<f64>,
    /// Everything turns about z and moves in x and y: the planar kernels serve.
    pub(crate) plane: bool,
    q_len: usize,
    v_joints: usize,
}

impl Model {
    /// Number of links.
    pub fn links_len(&self) -> usize {
        self.links.len()
    }

    /// Links of `other` have the same poses and velocities in every state, under the same gravity.
    pub(crate) fn is_posed_as(&self, other: &Self) -> bool {
        let same = |(a, b): (&LinkConstants, &LinkConstants)| {
            (a.parent, &a.joint, a.position, a.rotation) == (b.parent, &b.joint, b.position, b.rotation)
        };
        (self.links.len(), self.gravity) == (other.links.len(), other.gravity)
            && self.links.iter().zip(&other.links).all(same)
    }

    /// Number of internal coordinates: modes and wheels.
    pub fn internals_len(&self) -> usize {
        self.internals.len()
    }

    /// Numbers in `q` (joint positions).
    pub fn q_len(&self) -> usize {
        self.q_len
    }

    /// Numbers in `v`: joint velocities, then internal velocities.
    pub fn v_len(&self) -> usize {
        self.v_joints + self.internals.len()
    }

    /// First position coordinate of the joint of `link`.
    pub fn q_index(&self, link: usize) -> usize {
        self.links[link].q
    }

    /// First velocity coordinate of the joint of `link`.
    pub fn v_index(&self, link: usize) -> usize {
        self.links[link].v
    }

    /// Velocity coordinates of the joint of `link`: 0, 1, 3 or 6.
    pub fn joint_v_len(&self, link: usize) -> usize {
        self.links[link].v_len
    }

    /// Velocity coordinate of internal coordinate `internal`.
    pub fn v_index_internal(&self, internal: usize) -> usize {
        self.internals[internal].v
    }

    /// Index of the parent link; `None`: the link sits on the inertial base.
    pub fn parent(&self, link: usize) -> Option<usize> {
        self.links[link].parent.checked_sub(1)
    }

    /// Gravity in inertial axes [m/s²].
    pub fn gravity_m_s2(&self) -> [f64; 3] {
        self.gravity.array()
    }

    /// Mass of all links.
    pub fn mass_kg(&self) -> f64 {
        self.links.iter().map(|link| link.mass).sum()
    }

    /// All joints at zero; quaternions of unit length.
    pub fn neutral_position(&self) -> Vec<f64> {
        let mut q = vec![0.0; self.q_len];
        for link in self.links.iter().filter(|link| link.joint == Joint::FreeSpatial) {
            q[link.q + 3] = 1.0;
        }
        q
    }

    /// Standard inertial parameters, ten per link:
    /// `[m, mcx, mcy, mcz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz]`, the inertia about the link's origin: the
    /// order of the columns of the regressors.
    pub fn standard_parameters(&self) -> Vec<f64> {
        let ten = |link: &LinkConstants| {
            let (h, i) = (link.first_moment, link.inertia_origin);
            [link.mass, h.x, h.y, h.z, i.xx, i.xy, i.yy, i.xz, i.yz, i.zz]
        };
        self.links.iter().flat_map(ten).collect()
    }
}
