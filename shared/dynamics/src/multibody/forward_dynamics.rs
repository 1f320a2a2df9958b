//! Forward dynamics by the articulated-body algorithm, also with part of the joints driven along a
//! given motion.
//!
//! Featherstone, Rigid Body Dynamics Algorithms, ch. 7 and 9.2, in world axes at each link's origin
//! (see [`kinematics`](super::kinematics)). A joint of several degrees of freedom is eliminated one
//! coordinate after the other, which is `L D Lᵀ` of its block; an internal coordinate is eliminated
//! inside its link before anything else.

use super::data::{Data, JointForce};
use super::inertia::{Factor3, SpatialInertia};
use super::internal_coordinates::{eliminate_internal, internal_effort};
use super::kinematics::kinematics;
use super::link_state::{Elimination, LinkState};
use super::model::{Joint, LinkConstants, Model};
use super::planar;
use super::vector::{Sym3, V3};
use crate::real::Real;

/// Accelerations `v̇` of the joints and internal coordinates under the efforts `tau` and the
/// external wrenches.
///
/// `wrench`: per link `[torque; force]` about its origin, link axes; may be empty. For a free joint
/// `v̇` is the rate of change of the components of `v` (not the acceleration of the origin).
///
/// Fails (not a number) only where the mass matrix is singular. Cost: O(links), no allocation.
pub fn forward_dynamics<T: Real>(
    model: &Model,
    data: &mut Data<T>,
    q: &[T],
    v: &[T],
    tau: &[T],
    wrench: &[[T; 6]],
    acceleration: &mut [T],
) {
    kinematics(model, data, q, v);
    forward_dynamics_after_kinematics(model, data, v, tau, wrench, acceleration);
}

/// [`forward_dynamics`] when [`kinematics`] of the same state is already in `data`: for efforts
/// that depend on poses.
pub fn forward_dynamics_after_kinematics<T: Real>(
    model: &Model,
    data: &mut Data<T>,
    v: &[T],
    tau: &[T],
    wrench: &[[T; 6]],
    acceleration: &mut [T],
) {
    articulated_body(model, data, v, tau, wrench, &[], acceleration);
}

/// Forward dynamics with some joints prescribed: `prescribed` has one flag per velocity coordinate,
/// equal within a joint.
///
/// Where free, `tau` is given and `acceleration` computed; where prescribed, `acceleration` is
/// given and `tau` computed: the effort that drives the motion. Internal coordinates may be
/// prescribed too.
#[allow(clippy::too_many_arguments)] // the state, both efforts and both unknowns
pub fn forward_dynamics_prescribed<T: Real>(
    model: &Model,
    data: &mut Data<T>,
    q: &[T],
    v: &[T],
    prescribed: &[bool],
    tau: &mut [T],
    wrench: &[[T; 6]],
    acceleration: &mut [T],
) {
    kinematics(model, data, q, v);
    forward_dynamics_prescribed_after_kinematics(model, data, v, prescribed, tau, wrench, acceleration);
}

/// [`forward_dynamics_prescribed`] when [`kinematics`] of the same state is already in `data`.
pub fn forward_dynamics_prescribed_after_kinematics<T: Real>(
    model: &Model,
    data: &mut Data<T>,
    v: &[T],
    prescribed: &[bool],
    tau: &mut [T],
    wrench: &[[T; 6]],
    acceleration: &mut [T],
) {
    assert!(prescribed.len() == model.v_len());
    articulated_body(model, data, v, tau, wrench, prescribed, acceleration);
    for (link, frame) in model.links.iter().zip(&data.frames[1..]) {
        if link.v_len == 0 || !prescribed[link.v] {
            continue;
        }
        let own = &mut tau[link.v..link.v + link.v_len];
        if !(data.plane && planar::effort(link, frame, own)) {
            let (moment, force) = frame.inertia.apply(frame.alpha, frame.acceleration);
            frame.joint_effort(&link.joint, moment + frame.moment, force + frame.force, own);
        }
        if link.armature != 0.0 {
            own[0] += acceleration[link.v].scale(link.armature);
        }
    }
    for internal in model.internals.iter().filter(|internal| prescribed[internal.v]) {
        tau[internal.v] = internal_effort(internal, data.link(internal.link), acceleration[internal.v]);
    }
}

#[inline(always)]
fn articulated_body<T: Real>(
    model: &Model,
    data: &mut Data<T>,
    v: &[T],
    tau: &[T],
    wrench: &[[T; 6]],
    prescribed: &[bool],
    acceleration: &mut [T],
) {
    if data.plane {
        articulated_body_by::<T, true>(model, data, v, tau, wrench, prescribed, acceleration);
    } else {
        articulated_body_by::<T, false>(model, data, v, tau, wrench, prescribed, acceleration);
    }
}

#[inline(always)]
fn articulated_body_by<T: Real, const PLANE: bool>(
    model: &Model,
    data: &mut Data<T>,
    v: &[T],
    tau: &[T],
    wrench: &[[T; 6]],
    prescribed: &[bool],
    acceleration: &mut [T],
) {
    assert!(v.len() == model.v_len());
    assert!(tau.len() == model.v_len());
    assert!(acceleration.len() == model.v_len());
    assert!(wrench.is_empty() || wrench.len() == model.links_len());
    data.joint_force = JointForce::Articulated;
    for (link, frame) in model.links.iter().zip(&mut data.frames[1..]) {
        if PLANE { planar::rigid_body(link, frame) } else { rigid_body(link, frame) }
    }
    for (frame, wrench) in data.frames[1..].iter_mut().zip(wrench) {
        frame.moment -= frame.rotation.apply(V3::read(wrench, 0));
        frame.force -= frame.rotation.apply(V3::read(wrench, 3));
    }
    for internal in &model.internals {
        let given = prescribed.get(internal.v).is_some_and(|prescribed| *prescribed);
        let known = if given { acceleration[internal.v] } else { tau[internal.v] };
        eliminate_internal(internal, &mut data.frames[internal.link + 1], v[internal.v], known, given);
    }
    for (i, link) in model.links.iter().enumerate().rev() {
        let (before, rest) = data.frames.split_at_mut(i + 1);
        let given = prescribed.get(link.v).is_some_and(|prescribed| *prescribed);
        let (parent, own) = (&mut before[link.parent], &mut rest[0]);
        if PLANE {
            planar::eliminate_joint(link, parent, own, tau, acceleration, given);
        } else {
            eliminate_joint(link, parent, own, tau, acceleration, given);
        }
    }
    for (i, link) in model.links.iter().enumerate() {
        let (before, rest) = data.frames.split_at_mut(i + 1);
        let given = prescribed.get(link.v).is_some_and(|prescribed| *prescribed);
        let (parent, own) = (&before[link.parent], &mut rest[0]);
        if PLANE {
            planar::accelerate(link, parent, own, acceleration, given);
        } else {
            accelerate(link, parent, own, acceleration, given);
        }
    }
    for internal in &model.internals {
        if !prescribed.get(internal.v).is_some_and(|prescribed| *prescribed) {
            // zero acceleration of its own leaves what the link needs: the rest is its own
            let needed = internal_effort(internal, &data.frames[internal.link + 1], T::zero());
            acceleration[internal.v] = (tau[internal.v] - needed).scale(1.0 / internal.mass);
        }
    }
}

/// Inertia of the link alone and the force it needs at zero acceleration: `ω × I ω` and
/// `ω × (ω × m c)`.
#[inline(always)]
pub(crate) fn rigid_body<T: Real>(link: &LinkConstants, frame: &mut LinkState<T>) {
    let inertia = frame.rotation.congruence(&link.inertia_origin);
    let first_moment = frame.rotation.apply_constant(&link.first_moment);
    frame.moment = frame.omega.cross(inertia.apply(frame.omega));
    frame.force = frame.omega.cross_twice(first_moment);
    frame.inertia = SpatialInertia::rigid(inertia, first_moment, link.mass);
    if frame.carried.acts {
        frame.add_carried();
    }
}

/// Articulated inertia and force handed through the joint to the parent.
#[inline(always)]
fn eliminate_joint<T: Real>(
    link: &LinkConstants,
    parent: &mut LinkState<T>,
    frame: &mut LinkState<T>,
    tau: &[T],
    acceleration: &[T],
    given: bool,
) {
    let mut inertia = frame.inertia;
    let (mut moment, mut force) = (frame.moment, frame.force);
    let (mut bias_angular, mut bias_linear) = (frame.bias_angular, frame.bias_linear);
    if given {
        let own = &acceleration[link.v..link.v + link.v_len];
        let (angular, linear) = frame.joint_motion(&link.joint, own);
        bias_angular += angular;
        bias_linear += linear;
    } else {
        match link.joint {
            Joint::Fixed => {}
            Joint::Revolute { .. } => {
                let s = frame.axis;
                let effort = tau[link.v] - s.dot(moment);
                let u = inertia.apply_angular(s);
                let d = s.dot(u.0) + T::constant(link.armature);
                frame.joint[0] = Elimination::of(u, d, effort);
                frame.joint[0].apply(&mut inertia, &mut moment, &mut force);
            }
            Joint::Prismatic { .. } => {
                let s = frame.axis;
                let effort = tau[link.v] - s.dot(force);
                let u = (inertia.b.apply(s), inertia.c.apply(s));
                let d = s.dot(u.1) + T::constant(link.armature);
                frame.joint[0] = Elimination::of(u, d, effort);
                frame.joint[0].apply(&mut inertia, &mut moment, &mut force);
            }
            Joint::FreePlanar if link.parent == 0 => {
                frame.joint[0].u_angular = planar_root(link, frame, parent.acceleration, tau);
                return;
            }
            Joint::FreePlanar => {
                for k in 0..3 {
                    let (angular, linear) = frame.subspace(&link.joint, k);
                    let effort = tau[link.v + k] - angular.dot(moment) - linear.dot(force);
                    let u = inertia.apply(angular, linear);
                    frame.joint[k] = Elimination::of(u, angular.dot(u.0) + linear.dot(u.1), effort);
                    frame.joint[k].apply(&mut inertia, &mut moment, &mut force);
                }
            }
            Joint::FreeSpatial => {
                let drive = frame.joint_motion(&link.joint, &tau[link.v..link.v + 6]);
                let (alpha, linear) = inertia.solve(drive.0 - moment, drive.1 - force);
                (frame.alpha, frame.acceleration) = (alpha, linear);
                parent.moment += drive.0 + frame.arm.cross(drive.1);
                parent.force += drive.1;
                return;
            }
        }
    }
    if link.parent == 0 {
        return;
    }
    let (m, f) = inertia.apply(bias_angular, bias_linear);
    (moment, force) = (moment + m, force + f);
    parent.inertia.add(&inertia.translated(frame.arm));
    parent.moment += moment + frame.arm.cross(force);
    parent.force += force;
}

/// Joint acceleration of a planar root: `Sᵀ I S x = τ − Sᵀ (p + I a)`, `a` the acceleration of the
/// world and the bias.
#[inline(always)]
fn planar_root<T: Real>(link: &LinkConstants, frame: &LinkState<T>, world: V3<T>, tau: &[T]) -> V3<T> {
    let inertia = &frame.inertia;
    let (n, x, y) = (frame.rotation.column_z(), frame.rotation.column_x(), frame.rotation.column_y());
    let (moment, force) = inertia.apply(frame.bias_angular, world + frame.bias_linear);
    let turning = inertia.apply_angular(n);
    let (along_x, along_y) = (inertia.c.apply(x), inertia.c.apply(y));
    let d = Sym3 {
        xx: n.dot(turning.0),
        xy: x.dot(turning.1),
        xz: y.dot(turning.1),
        yy: x.dot(along_x),
        yz: x.dot(along_y),
        zz: y.dot(along_y),
    };
    let (moment, force) = (moment + frame.moment, force + frame.force);
    Factor3::of(&d).solve(V3::read(tau, link.v) - V3::new(n.dot(moment), x.dot(force), y.dot(force)))
}

/// Acceleration of the joint and the link from that of the parent.
#[inline(always)]
fn accelerate<T: Real>(
    link: &LinkConstants,
    parent: &LinkState<T>,
    frame: &mut LinkState<T>,
    acceleration: &mut [T],
    given: bool,
) {
    let mut alpha = parent.alpha + frame.bias_angular;
    let mut linear = parent.acceleration + parent.alpha.cross(frame.arm) + frame.bias_linear;
    let own = &mut acceleration[link.v..link.v + link.v_len];
    if given {
        let (angular, along) = frame.joint_motion(&link.joint, own);
        alpha += angular;
        linear += along;
    } else {
        match link.joint {
            Joint::Fixed => {}
            Joint::Revolute { .. } => {
                own[0] = frame.joint[0].acceleration(alpha, linear);
                alpha += frame.axis * own[0];
            }
            Joint::Prismatic { .. } => {
                own[0] = frame.joint[0].acceleration(alpha, linear);
                linear += frame.axis * own[0];
            }
            Joint::FreePlanar if link.parent == 0 => {
                frame.joint[0].u_angular.write(own, 0);
                let (angular, along) = frame.joint_motion(&link.joint, own);
                alpha += angular;
                linear += along;
            }
            Joint::FreePlanar => {
                for k in (0..3).rev() {
                    own[k] = frame.joint[k].acceleration(alpha, linear);
                    let (s_angular, s_linear) = frame.subspace(&link.joint, k);
                    alpha += s_angular * own[k];
                    linear += s_linear * own[k];
                }
            }
            Joint::FreeSpatial => {
                frame.rotation.apply_transposed(frame.alpha - alpha).write(own, 0);
                frame.rotation.apply_transposed(frame.acceleration - linear).write(own, 3);
                return;
            }
        }
    }
    frame.alpha = alpha;
    frame.acceleration = linear;
}
