//! Joint-space mass matrix by the composite-rigid-body algorithm.
//!
//! Featherstone, Rigid Body Dynamics Algorithms, ch. 6: column by column, the force that moves
//! everything outboard of a joint.

use super::data::Data;
use super::kinematics::kinematics;
use super::model::Model;
use super::vector::V3;
use nalgebra::DMatrix;

/// Mass matrix `M(q)` (v_len × v_len) of joints and internal coordinates, rotor inertias included.
///
/// Cost: O(v_len · depth), no allocation.
pub fn mass_matrix(model: &Model, data: &mut Data<f64>, q: &[f64], mass: &mut DMatrix<f64>) {
    let n = model.v_len();
    assert!(mass.shape() == (n, n));
    poses(model, data, q);
    for (link, frame) in model.links.iter().zip(&mut data.frames[1..]) {
        super::forward_dynamics::rigid_body(link, frame);
    }
    for (i, link) in model.links.iter().enumerate().rev() {
        let (before, rest) = data.frames.split_at_mut(i + 1);
        if link.parent > 0 {
            before[link.parent].inertia.add(&rest[0].inertia.translated(rest[0].arm));
        }
    }
    mass.fill(0.0);
    for (i, link) in model.links.iter().enumerate() {
        for k in 0..link.v_len {
            let frame = data.link(i);
            let (angular, linear) = frame.subspace(&link.joint, k);
            let force = frame.inertia.apply(angular, linear);
            project_on_chain(model, data, i, force, |row, value| {
                mass[(row, link.v + k)] = value;
                mass[(link.v + k, row)] = value;
            });
        }
        if link.armature != 0.0 {
            mass[(link.v, link.v)] += link.armature;
        }
    }
    for internal in &model.internals {
        let frame = data.link(internal.link);
        let force = (frame.rotation.apply(internal.angular), frame.rotation.apply(internal.linear));
        project_on_chain(model, data, internal.link, force, |row, value| {
            mass[(row, internal.v)] = value;
            mass[(internal.v, row)] = value;
        });
        mass[(internal.v, internal.v)] = internal.mass;
    }
}

/// Poses alone: velocities zero.
fn poses(model: &Model, data: &mut Data<f64>, q: &[f64]) {
    let mut rest = core::mem::take(&mut data.efforts);
    rest.fill(0.0);
    kinematics(model, data, q, &rest);
    data.efforts = rest;
}

/// Generalised effort of a `(moment, force)` at the origin of `link` on every joint that carries
/// it.
#[inline]
pub(crate) fn project_on_chain(
    model: &Model,
    data: &Data<f64>,
    link: usize,
    wrench: (V3<f64>, V3<f64>),
    mut found: impl FnMut(usize, f64),
) {
    let (mut moment, force) = wrench;
    let mut at = link + 1;
    while at > 0 {
        let (constants, frame) = (&model.links[at - 1], &data.frames[at]);
        let mut effort = [0.0; 6];
        frame.joint_effort(&constants.joint, moment, force, &mut effort);
        for (k, value) in effort.into_iter().take(constants.v_len).enumerate() {
            found(constants.v + k, value);
        }
        moment += frame.arm.cross(force);
        at = constants.parent;
    }
}
