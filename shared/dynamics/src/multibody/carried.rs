//! Carried mass and motion of a link beyond its constants, at an instant: mass that comes or goes,
//! and the first moment that modes shift.
//!
//! Both are inertia and weight without a history: the flux of momentum with which mass leaves is a
//! force of its own.

use super::data::Data;
use super::inertia::SpatialInertia;
use super::link_state::LinkState;
use super::model::Model;
use super::vector::{M3, Sym3, V3};
use crate::real::Real;

impl<T: Real> Data<T> {
    /// States the positions `η` of the first internal coordinates; from then on the centre of mass
    /// moves with them:
    ///
    /// `T = ½ vᵀ I v + vᵀ D η̇ + ½ m η̇² + v · (ω × δ η)`, `δ` the linear part of `D`.
    ///
    /// The last term makes the equations those of a body that bends: `m η̈ = τ − ρ·α − δ·a` with
    /// the acceleration `a` of the origin, whatever its velocity; momentum and energy are still
    /// conserved exactly, and weight acts on `η`. Without this call the coupling sees body
    /// velocities alone (see [`InternalCoordinate`](super::InternalCoordinate)).
    pub fn set_internal_positions(&mut self, model: &Model, eta: &[T]) {
        for internal in &model.internals {
            let carried = &mut self.frames[internal.link + 1].carried;
            (carried.flexed, carried.shift) = (true, V3::zero());
        }
        for (internal, eta) in model.internals.iter().zip(eta) {
            let carried = &mut self.frames[internal.link + 1].carried;
            carried.shift +=
                V3::new(eta.scale(internal.linear.x), eta.scale(internal.linear.y), eta.scale(internal.linear.z));
            carried.acts = true;
        }
    }

    /// A point mass (negative: mass that is gone) at `position_m` of a link, until it is set again.
    pub fn set_added_mass(&mut self, link: usize, mass_kg: T, position_m: [T; 3]) {
        self.plane &= position_m[2].value() == 0.0;
        let carried = &mut self.frames[link + 1].carried;
        (carried.mass, carried.position, carried.acts) = (mass_kg, position_m.into(), true);
    }

    /// Only constants of the model act.
    pub(crate) fn carries_nothing(&self) -> bool {
        !self.frames.iter().any(|frame| frame.carried.acts || frame.carried.flexed)
    }
}

impl<T: Real> LinkState<T> {
    /// The carried mass as a spatial inertia about the origin, world axes.
    pub fn carried_inertia(&self) -> SpatialInertia<T> {
        let r = self.rotation.apply(self.carried.position);
        let m = self.carried.mass;
        let first_moment = self.rotation.apply(self.carried.shift) + r * m;
        let mut about_origin = Sym3::diagonal(r.dot(r) * m);
        about_origin.subtract_dyad(r, m);
        SpatialInertia { a: about_origin, b: M3::skew(first_moment), c: Sym3::diagonal(m) }
    }

    /// First moment of the carried mass about the origin, world axes, and the mass.
    pub fn carried_moment(&self) -> (V3<T>, T) {
        let (carried, r) = (&self.carried, &self.rotation);
        (r.apply(carried.shift + carried.position * carried.mass), carried.mass)
    }

    /// Adds the carried mass to inertia and velocity forces.
    pub fn add_carried(&mut self) {
        let inertia = self.carried_inertia();
        self.moment += self.omega.cross(inertia.a.apply(self.omega));
        self.force += self.omega.cross_twice(self.carried_moment().0);
        self.inertia.add(&inertia);
    }

    /// Adds the force that accelerates the carried mass with the link.
    pub fn add_carried_force(&mut self) {
        let inertia = self.carried_inertia();
        let (moment, force) = inertia.apply(self.alpha, self.acceleration);
        self.moment += moment + self.omega.cross(inertia.a.apply(self.omega));
        self.force += force + self.omega.cross_twice(self.carried_moment().0);
    }

    /// Momentum of the carried mass, about the origin.
    pub fn carried_momentum(&self) -> (V3<T>, V3<T>) {
        self.carried_inertia().apply(self.omega, self.velocity)
    }
}
