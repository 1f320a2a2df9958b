//! State of one link while an algorithm walks the tree, common to all algorithms.

use super::inertia::SpatialInertia;
use super::vector::{M3, Spatial, V3};
use crate::real::Real;

/// State of one link in world axes; moments and linear quantities at the link's own origin.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LinkState<T> {
    /// Link → world.
    pub rotation: M3<T>,
    /// Parent's origin to this origin.
    pub arm: V3<T>,
    pub origin: V3<T>,
    pub omega: V3<T>,
    pub velocity: V3<T>,
    /// Axis of a revolute or prismatic joint.
    pub axis: V3<T>,
    /// Acceleration at zero joint acceleration and resting parent: centripetal and Coriolis.
    pub bias_angular: V3<T>,
    pub bias_linear: V3<T>,
    /// Articulated, composite or rigid inertia, as the algorithm needs.
    pub inertia: SpatialInertia<T>,
    /// Force of the articulated body at zero acceleration; after inverse dynamics the force through
    /// the joint.
    pub moment: V3<T>,
    pub force: V3<T>,
    /// Angular acceleration, and acceleration of the origin minus gravity.
    pub alpha: V3<T>,
    pub acceleration: V3<T>,
    /// Terms beyond the link's constants.
    pub carried: Carried<T>,
    /// Elimination of the joint: `U`, `1/D`, `u`.
    pub joint: [Elimination<T>; 3],
}

/// One eliminated joint coordinate.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Elimination<T> {
    pub u_angular: V3<T>,
    pub u_linear: V3<T>,
    pub reciprocal: T,
    pub effort: T,
}

impl<T: Real> Elimination<T> {
    #[inline(always)]
    pub fn of(u: Spatial<T>, d: T, effort: T) -> Self {
        Self { u_angular: u.0, u_linear: u.1, reciprocal: T::one() / d, effort }
    }

    /// Inertia and force that remain when this coordinate gives way.
    #[inline(always)]
    pub fn apply(&self, inertia: &mut SpatialInertia<T>, moment: &mut V3<T>, force: &mut V3<T>) {
        inertia.subtract_dyad(self.u_angular, self.u_linear, self.reciprocal);
        let yielding = self.effort * self.reciprocal;
        *moment += self.u_angular * yielding;
        *force += self.u_linear * yielding;
    }

    /// Acceleration of this coordinate when the link would otherwise accelerate by
    /// `(alpha, linear)`.
    #[inline(always)]
    pub fn acceleration(&self, alpha: V3<T>, linear: V3<T>) -> T {
        (self.effort - self.u_angular.dot(alpha) - self.u_linear.dot(linear)) * self.reciprocal
    }
}

/// Carried mass and motion of a link beyond its constants, link axes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Carried<T> {
    /// The positions of its internal coordinates are known.
    pub flexed: bool,
    /// There is something to add to its inertia.
    pub acts: bool,
    /// `Σ δ η`.
    pub shift: V3<T>,
    pub mass: T,
    pub position: V3<T>,
}
