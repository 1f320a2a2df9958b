//! Workspace of the analytic derivatives of inverse dynamics.

use super::inertia::SpatialInertia;
use super::model::Model;

type Spatial = super::vector::Spatial<f64>;

/// Of one velocity coordinate.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Column {
    /// `J`, `ψ̇`, `ψ̈`, `φ`.
    pub motion: Spatial,
    pub psi_dot: Spatial,
    pub psi_ddot: Spatial,
    pub phi: Spatial,
    /// `I_c J` and `B_cᵀ J` of the links it carries.
    pub inertia: Spatial,
    pub velocity: Spatial,
    /// Derivatives of the force through its joint, by position (carried force included) and by
    /// velocity.
    pub by_position: Spatial,
    pub by_velocity: Spatial,
}

/// Of one link: composite inertia and `B`, velocity and acceleration about the common point.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Carried {
    pub inertia: SpatialInertia<f64>,
    pub velocity_product: [[f64; 6]; 6],
    pub velocity: Spatial,
    pub acceleration: Spatial,
    pub force: Spatial,
}

/// Workspace of the derivatives, part of [`Data`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Derivatives {
    pub columns: Vec<Column>,
    pub links: Vec<Carried>,
}

impl Derivatives {
    /// Memory for every coordinate and link of `model`; no later call allocates.
    pub fn new(model: &Model) -> Self {
        Self { columns: vec![Column::default(); model.v_len()], links: vec![Carried::default(); model.links_len() + 1] }
    }
}
