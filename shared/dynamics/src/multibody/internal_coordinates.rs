//! A coordinate inside a link (a flexible mode, a wheel): its coupling, its effort and its
//! elimination.

use super::link_state::LinkState;
use super::model::InternalConstants;
use super::vector::{Spatial, V3};
use crate::real::Real;

/// Coupling `D` of an internal coordinate in world axes, and the velocity force `v ×* D η̇` on its
/// link.
#[inline(always)]
pub(crate) fn internal_coupling<T: Real>(
    internal: &InternalConstants,
    frame: &LinkState<T>,
    rate: T,
) -> (Spatial<T>, Spatial<T>) {
    let angular = frame.rotation.apply_constant(&internal.angular);
    let linear = frame.rotation.apply_constant(&internal.linear);
    if frame.carried.flexed {
        let coriolis = frame.omega.cross(linear) * rate;
        return ((angular, linear), (frame.omega.cross(angular) * rate, coriolis + coriolis));
    }
    let moment = (frame.omega.cross(angular) + frame.velocity.cross(linear)) * rate;
    ((angular, linear), (moment, frame.omega.cross(linear) * rate))
}

/// `I −= D Dᵀ/m`, and the force of the coordinate at zero acceleration of the link; `known`: its
/// effort, or its acceleration.
pub(crate) fn eliminate_internal<T: Real>(
    internal: &InternalConstants,
    frame: &mut LinkState<T>,
    rate: T,
    known: T,
    given: bool,
) {
    let ((angular, linear), (moment, force)) = internal_coupling(internal, frame, rate);
    let reciprocal = 1.0 / internal.mass;
    let eta = if given {
        known
    } else {
        frame.inertia.subtract_dyad(angular, linear, T::constant(reciprocal));
        // η̈ at resting origin: Dᵀ v̇ there is −D·(ω × v)
        let swept = if frame.carried.flexed { T::zero() } else { linear.dot(frame.omega.cross(frame.velocity)) };
        (known + swept).scale(reciprocal)
    };
    frame.moment += moment + angular * eta;
    frame.force += force + linear * eta;
}

/// `τ_η = m η̈ + Dᵀ v̇` of an internal coordinate once its link's acceleration is known.
#[inline(always)]
pub(crate) fn internal_effort<T: Real>(internal: &InternalConstants, frame: &LinkState<T>, eta: T) -> T {
    let flexed = frame.carried.flexed;
    let linear = if flexed { frame.acceleration } else { frame.acceleration - frame.omega.cross(frame.velocity) };
    let angular = frame.rotation.apply_transposed(frame.alpha);
    let linear = frame.rotation.apply_transposed(linear);
    eta.scale(internal.mass) + angular.dot(V3::constant(&internal.angular)) + linear.dot(V3::constant(&internal.linear))
}
