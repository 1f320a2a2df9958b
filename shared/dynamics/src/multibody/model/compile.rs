//! From the description of a tree to its constants; a tree without a positive mass matrix is
//! rejected.

use super::check::{ModelError, check_link};
use super::{InternalConstants, InternalCoordinate, Joint, JointKind, Link, LinkConstants, Model};
use crate::multibody::data::Data;
use crate::multibody::mass_matrix::mass_matrix;
use crate::multibody::planar::lies_in_plane;
use crate::multibody::vector::{M3, Sym3, V3};
use nalgebra::{DMatrix, Matrix3, Vector3};

impl Model {
    /// Compiles `links` (parents before children) and the internal coordinates that live in them.
    ///
    /// # Errors
    /// [`ModelError`]: the first thing found that makes it no mechanism. Whether an inertia belongs
    /// to a real body (triangle inequality) is not tested: planar descriptions need only one of its
    /// entries.
    pub fn new(
        links: &[Link],
        internals: &[InternalCoordinate],
        gravity_m_s2: Vector3<f64>,
    ) -> Result<Self, ModelError> {
        if links.is_empty() {
            return Err(ModelError::Empty);
        }
        let (mut q_len, mut v_joints) = (0, 0);
        let mut compiled: Vec<LinkConstants> = Vec::with_capacity(links.len());
        for (i, link) in links.iter().enumerate() {
            check_link(i, link)?;
            let root = link.parent.map_or(i, |parent| compiled[parent].root);
            compiled.push(LinkConstants { root, ..compile(link, q_len, v_joints) });
            q_len += link.joint.q_len();
            v_joints += link.joint.v_len();
        }
        for (i, internal) in internals.iter().enumerate() {
            if internal.link >= links.len() {
                return Err(ModelError::NoSuchLink { internal: i, link: internal.link });
            }
            if !(internal.mass > 0.0 && internal.mass.is_finite()) {
                return Err(ModelError::InternalMass { internal: i, mass: internal.mass });
            }
            if internal.coupling.iter().any(|d| !d.is_finite()) {
                return Err(ModelError::NotFinite { link: internal.link, field: "coupling of an internal coordinate" });
            }
        }
        let internals: Vec<_> = internals
            .iter()
            .enumerate()
            .map(|(i, internal)| {
                let [a, b, c, d, e, f] = internal.coupling;
                InternalConstants {
                    link: internal.link,
                    v: v_joints + i,
                    mass: internal.mass,
                    angular: V3::new(a, b, c),
                    linear: V3::new(d, e, f),
                }
            })
            .collect();
        let gravity = V3::from_vector(&gravity_m_s2);
        let plane = lies_in_plane(&compiled, &internals);
        let model = Self { links: compiled, internals, gravity, plane, q_len, v_joints };
        model.check_mass_matrix()?;
        Ok(model)
    }

    /// Cholesky of the mass matrix at the neutral position.
    fn check_mass_matrix(&self) -> Result<(), ModelError> {
        let n = self.v_len();
        let mut mass = DMatrix::zeros(n, n);
        let mut data = Data::new(self);
        mass_matrix(self, &mut data, &self.neutral_position(), &mut mass);
        let diagonal = mass.diagonal();
        for k in 0..n {
            let pivot = mass[(k, k)];
            // rounding of the elimination of n terms
            if pivot.is_nan() || pivot <= 1e-14 * n as f64 * diagonal[k] {
                return Err(ModelError::MassMatrixNotPositive { v_index: k, pivot });
            }
            for i in k + 1..n {
                let factor = mass[(i, k)] / pivot;
                for j in k + 1..n {
                    mass[(i, j)] -= factor * mass[(k, j)];
                }
            }
        }
        Ok(())
    }
}

fn compile(link: &Link, q: usize, v: usize) -> LinkConstants {
    let (m, c) = (link.mass_kg, link.com_m);
    // Steiner
    let inertia_origin = link.inertia_com_kg_m2 + (Matrix3::identity() * c.norm_squared() - c * c.transpose()) * m;
    let joint = match link.joint {
        JointKind::FreeSpatial => Joint::FreeSpatial,
        JointKind::FreePlanar => Joint::FreePlanar,
        JointKind::Fixed => Joint::Fixed,
        JointKind::Prismatic { axis } => Joint::Prismatic { axis_in_parent: V3::from_vector(&(link.rotation * axis)) },
        JointKind::Revolute { axis } => {
            let axis = axis.normalize();
            let along = axis * axis.transpose();
            Joint::Revolute {
                axis_in_parent: V3::from_vector(&(link.rotation * axis)),
                along: M3::from_matrix(&(link.rotation * along)),
                across: M3::from_matrix(&(link.rotation * (Matrix3::identity() - along))),
                turned: M3::from_matrix(&(link.rotation * axis.cross_matrix())),
            }
        }
    };
    LinkConstants {
        parent: link.parent.map_or(0, |parent| parent + 1),
        root: 0,
        joint,
        q,
        v,
        v_len: link.joint.v_len(),
        position: V3::from_vector(&link.position_m),
        rotation: M3::from_matrix(&link.rotation),
        along_world: link.parent.is_none() && link.rotation == Matrix3::identity(),
        mass: m,
        com: V3::from_vector(&c),
        first_moment: V3::from_vector(&(c * m)),
        inertia_origin: Sym3::from_matrix(&inertia_origin),
        armature: link.armature,
    }
}
