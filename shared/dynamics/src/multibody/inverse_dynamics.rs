//! Inverse dynamics by the recursive Newton–Euler algorithm.
//!
//! Featherstone, Rigid Body Dynamics Algorithms, ch. 5: accelerations outwards, forces inwards.
//! Gravity is an acceleration of the world upwards, for rigid masses and internal coordinates
//! alike.

use super::data::{Data, JointForce};
use super::internal_coordinates::{internal_coupling, internal_effort};
use super::kinematics::kinematics;
use super::model::Model;
use super::vector::V3;
use crate::real::Real;

/// Efforts `tau` that produce `acceleration` against the external wrenches; arguments as in
/// [`forward_dynamics`](super::forward_dynamics).
///
/// Cost: O(links), about half of forward dynamics, no allocation.
pub fn inverse_dynamics<T: Real>(
    model: &Model,
    data: &mut Data<T>,
    q: &[T],
    v: &[T],
    acceleration: &[T],
    wrench: &[[T; 6]],
    tau: &mut [T],
) {
    kinematics(model, data, q, v);
    inverse_dynamics_after_kinematics(model, data, v, acceleration, wrench, tau);
}

/// [`inverse_dynamics`] when [`kinematics`] of the same state is already in `data`.
pub fn inverse_dynamics_after_kinematics<T: Real>(
    model: &Model,
    data: &mut Data<T>,
    v: &[T],
    acceleration: &[T],
    wrench: &[[T; 6]],
    tau: &mut [T],
) {
    assert!(acceleration.len() == model.v_len());
    assert!(tau.len() == model.v_len());
    assert!(wrench.is_empty() || wrench.len() == model.links_len());
    accelerations(model, data, acceleration);
    data.joint_force = JointForce::Direct;
    for (link, frame) in model.links.iter().zip(&mut data.frames[1..]) {
        let r = &frame.rotation;
        // in link axes: the inertia is constant there
        let (omega, alpha) = (r.apply_transposed(frame.omega), r.apply_transposed(frame.alpha));
        let linear = r.apply_transposed(frame.acceleration);
        let h = V3::constant(&link.first_moment);
        let inertia = |x: V3<T>| super::vector::M3 { rows: link.inertia_origin.rows() }.apply_to(x);
        let moment = inertia(alpha) + h.cross(linear) + omega.cross(inertia(omega));
        let force = linear.scale(link.mass) + alpha.cross(h) + omega.cross_twice(h);
        (frame.moment, frame.force) = (r.apply(moment), r.apply(force));
        if frame.carried.acts {
            frame.add_carried_force();
        }
    }
    for (frame, wrench) in data.frames[1..].iter_mut().zip(wrench) {
        frame.moment -= frame.rotation.apply(V3::read(wrench, 0));
        frame.force -= frame.rotation.apply(V3::read(wrench, 3));
    }
    for internal in &model.internals {
        let frame = &mut data.frames[internal.link + 1];
        let eta = acceleration[internal.v];
        let ((angular, linear), (moment, force)) = internal_coupling(internal, frame, v[internal.v]);
        frame.moment += moment + angular * eta;
        frame.force += force + linear * eta;
        tau[internal.v] = internal_effort(internal, frame, eta);
    }
    for (i, link) in model.links.iter().enumerate().rev() {
        let (before, rest) = data.frames.split_at_mut(i + 1);
        let frame = &rest[0];
        let own = &mut tau[link.v..link.v + link.v_len];
        frame.joint_effort(&link.joint, frame.moment, frame.force, own);
        if link.armature != 0.0 {
            own[0] += acceleration[link.v].scale(link.armature);
        }
        let parent = &mut before[link.parent];
        parent.moment += frame.moment + frame.arm.cross(frame.force);
        parent.force += frame.force;
    }
}

/// Accelerations of all links (minus gravity) from those of the joints.
pub(crate) fn accelerations<T: Real>(model: &Model, data: &mut Data<T>, acceleration: &[T]) {
    for (i, link) in model.links.iter().enumerate() {
        let (before, rest) = data.frames.split_at_mut(i + 1);
        let (parent, frame) = (&before[link.parent], &mut rest[0]);
        let (angular, linear) = frame.joint_motion(&link.joint, &acceleration[link.v..link.v + link.v_len]);
        frame.alpha = parent.alpha + frame.bias_angular + angular;
        frame.acceleration = parent.acceleration + parent.alpha.cross(frame.arm) + frame.bias_linear + linear;
    }
}
