//! Momentum and energy of the whole tree, internal coordinates included.

use super::data::Data;
use super::kinematics::kinematics;
use super::model::Model;
use super::vector::V3;
use crate::real::Real;

/// Momentum of the system, world axes. Rotor inertias (`armature`) carry none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Momentum<T> {
    pub angular_about_origin: [T; 3],
    /// About the system's centre of mass; the centre of mass is that of the links, internal
    /// coordinates at zero.
    pub angular_about_com: [T; 3],
    pub linear: [T; 3],
    /// Position of the centre of mass.
    pub com: [T; 3],
    pub mass: f64,
}

/// Momentum and centre of mass.
///
/// Cost: [`kinematics`] and a sum over the links, no allocation.
pub fn momentum<T: Real>(model: &Model, data: &mut Data<T>, q: &[T], v: &[T]) -> Momentum<T> {
    kinematics(model, data, q, v);
    momentum_after_kinematics(model, data, v)
}

/// [`momentum`] when [`kinematics`] of the same state is already in `data`.
pub fn momentum_after_kinematics<T: Real>(model: &Model, data: &Data<T>, v: &[T]) -> Momentum<T> {
    let (mut angular, mut linear, mut first_moment, mut mass) = (V3::zero(), V3::zero(), V3::zero(), 0.0);
    let mut added = T::zero();
    for (i, link) in model.links.iter().enumerate() {
        let frame = data.link(i);
        let (h, p) = rigid_momentum(model, data, i);
        angular += h + frame.origin.cross(p);
        linear += p;
        first_moment += frame.origin.scale(link.mass) + frame.rotation.apply_constant(&link.first_moment);
        mass += link.mass;
        if frame.carried.acts {
            let (moment, carried) = frame.carried_moment();
            first_moment += moment + frame.origin * carried;
            added += carried;
        }
    }
    for internal in &model.internals {
        let frame = data.link(internal.link);
        let p = frame.rotation.apply_constant(&internal.linear) * v[internal.v];
        angular += frame.rotation.apply_constant(&internal.angular) * v[internal.v] + frame.origin.cross(p);
        linear += p;
    }
    let com = first_moment * (T::one() / (T::constant(mass) + added));
    Momentum {
        angular_about_origin: angular.array(),
        angular_about_com: (angular - com.cross(linear)).array(),
        linear: linear.array(),
        com: com.array(),
        mass: mass + added.value(),
    }
}

/// (angular momentum about its origin, linear momentum) of one link, world axes.
fn rigid_momentum<T: Real>(model: &Model, data: &Data<T>, i: usize) -> (V3<T>, V3<T>) {
    let (link, frame) = (&model.links[i], data.link(i));
    let inertia = frame.rotation.congruence(&link.inertia_origin);
    let first_moment = frame.rotation.apply_constant(&link.first_moment);
    let angular = inertia.apply(frame.omega) + first_moment.cross(frame.velocity);
    let linear = frame.velocity.scale(link.mass) + frame.omega.cross(first_moment);
    if !frame.carried.acts {
        return (angular, linear);
    }
    let (more_angular, more_linear) = frame.carried_momentum();
    (angular + more_angular, linear + more_linear)
}

/// `½ vᵀ M v`: links, rotor inertias and internal coordinates.
pub fn kinetic_energy<T: Real>(model: &Model, data: &mut Data<T>, q: &[T], v: &[T]) -> T {
    kinematics(model, data, q, v);
    let mut twice = T::zero();
    for (i, link) in model.links.iter().enumerate() {
        let frame = data.link(i);
        let (h, p) = rigid_momentum(model, data, i);
        twice += frame.omega.dot(h) + frame.velocity.dot(p);
        if link.armature != 0.0 {
            twice += (v[link.v] * v[link.v]).scale(link.armature);
        }
    }
    for internal in &model.internals {
        let frame = data.link(internal.link);
        let angular = frame.rotation.apply_constant(&internal.angular).dot(frame.omega);
        let coupling = angular + frame.rotation.apply_constant(&internal.linear).dot(frame.velocity);
        let rate = v[internal.v];
        twice += rate * (coupling + coupling + rate.scale(internal.mass));
    }
    twice.scale(0.5)
}

/// Energy of the links in the uniform gravity, zero at the world's origin, carried masses included.
/// Springs are the caller's, and so is the work of gravity on internal coordinates, `−η Dᵀ g`,
/// unless their positions are known ([`Data::set_internal_positions`]).
pub fn potential_energy<T: Real>(model: &Model, data: &mut Data<T>, q: &[T], v: &[T]) -> T {
    kinematics(model, data, q, v);
    let mut energy = T::zero();
    for (i, link) in model.links.iter().enumerate() {
        let frame = data.link(i);
        let weighted = frame.origin.scale(link.mass) + frame.rotation.apply_constant(&link.first_moment);
        energy -= weighted.dot(data.gravity);
        if frame.carried.acts {
            let (moment, carried) = frame.carried_moment();
            energy -= (moment + frame.origin * carried).dot(data.gravity);
        }
    }
    energy
}
