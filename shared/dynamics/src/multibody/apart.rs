//! Trees whose coordinates do not feel each other: every link moves along or about one axis of its
//! own that the world holds.

use super::data::Data;
use super::mass_matrix::mass_matrix;
use super::model::{Joint, Model};
use nalgebra::DMatrix;

impl Model {
    /// Inertia of every coordinate where it is the same in every pose and the mass matrix is
    /// diagonal: then `q̈ = τ / m` and `q̇ = v`, gravity and wrenches apart. A drive on a bench, a
    /// carriage on a rail.
    pub fn inertias_apart(&self) -> Option<Vec<f64>> {
        let turns_or_slides = |joint: &Joint| matches!(joint, Joint::Revolute { .. } | Joint::Prismatic { .. });
        let apart = self.links.iter().all(|link| link.parent == 0 && turns_or_slides(&link.joint));
        if !apart || self.internals_len() > 0 {
            return None;
        }
        let mut mass = DMatrix::zeros(self.v_len(), self.v_len());
        mass_matrix(self, &mut Data::new(self), &vec![0.0; self.q_len()], &mut mass);
        Some(mass.diagonal().iter().copied().collect())
    }
}
