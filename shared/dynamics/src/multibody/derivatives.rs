//! Analytic derivatives of inverse dynamics with respect to position and velocity.
//!
//! Carpentier & Mansard, Analytical derivatives of rigid body dynamics algorithms (RSS 2018), for
//! joints of several degrees of freedom and with internal coordinates. All spatial vectors are in
//! world axes about one point, the origin of link 0. For a motion `J_k` of joint j (parent p), seen
//! from the links that it carries, the parent moves the other way:
//!
//! ```text
//! ψ̇ = v_p × J,  ψ̈ = a_p × J + v_p × ψ̇,  φ = (v_p + v_j) × J
//! ∂f_i/∂q = I_i ψ̈ + B_i ψ̇,  ∂f_i/∂q̇ = I_i φ + B_i J
//! B x = −I (v × x) + x ×* h + v ×* I x,  h = I v + D η̇
//! ```
//!
//! and outside the subtree the force itself is carried along, `J ×* F_j`. `a` includes the upward
//! acceleration for gravity.

use super::data::Data;
use super::derivatives_workspace::{Column, Derivatives};
use super::inertia::SpatialInertia;
use super::inverse_dynamics::inverse_dynamics_after_kinematics;
use super::kinematics::kinematics;
use super::model::{InternalConstants, Model};
use super::vector::V3;
use nalgebra::DMatrix;

type Spatial = super::vector::Spatial<f64>;

/// `∂τ/∂q` in the tangent space (order of `v`) and `∂τ/∂v` of inverse dynamics without external
/// wrenches, v_len × v_len each.
///
/// A tangent direction of a free joint is a displacement in its own axes, as
/// [`integrate_position`](super::integrate_position) takes it. Columns of internal coordinates in
/// `dtau_dq` are zero: their positions are the caller's.
///
/// For the constants of the model alone: panics on a workspace with
/// [`Data::set_internal_positions`] or [`Data::set_added_mass`], whose terms it lacks; dual numbers
/// differentiate those.
///
/// Cost: O(v_len · depth), no allocation.
pub fn inverse_dynamics_derivatives(
    model: &Model,
    data: &mut Data<f64>,
    q: &[f64],
    v: &[f64],
    acceleration: &[f64],
    dtau_dq: &mut DMatrix<f64>,
    dtau_dv: &mut DMatrix<f64>,
) {
    let n = model.v_len();
    assert!(dtau_dq.shape() == (n, n));
    assert!(dtau_dv.shape() == (n, n));
    assert!(data.carries_nothing(), "analytic derivatives know constant inertias only");
    kinematics(model, data, q, v);
    let mut work = core::mem::take(&mut data.derivatives);
    let mut efforts = core::mem::take(&mut data.efforts);
    inverse_dynamics_after_kinematics(model, data, v, acceleration, &[], &mut efforts);
    data.efforts = efforts;
    carry(model, data, v, &mut work);
    fill_columns(model, data, &mut work);
    dtau_dq.fill(0.0);
    dtau_dv.fill(0.0);
    fill_joints(model, &work, dtau_dq, dtau_dv);
    for internal in &model.internals {
        fill_internal(model, data, internal, &work, dtau_dq, dtau_dv);
    }
    data.derivatives = work;
}

/// Velocity, acceleration, force, and composite `I` and `B` of every link.
fn carry(model: &Model, data: &Data<f64>, v: &[f64], work: &mut Derivatives) {
    let point = data.link(0).origin;
    for (frame, carried) in data.frames.iter().zip(&mut work.links) {
        let r = frame.origin - point;
        let linear = frame.acceleration - frame.omega.cross(frame.velocity);
        carried.velocity = (frame.omega, frame.velocity + r.cross(frame.omega));
        carried.acceleration = (frame.alpha, linear + r.cross(frame.alpha));
        carried.force = (frame.moment + r.cross(frame.force), frame.force);
    }
    for (i, link) in model.links.iter().enumerate() {
        let frame = data.link(i);
        let inertia = frame.rotation.congruence(&link.inertia_origin);
        let first_moment = frame.rotation.apply(link.first_moment);
        let rigid = SpatialInertia::rigid(inertia, first_moment, link.mass).translated(frame.origin - point);
        let carried = &mut work.links[i + 1];
        let mut momentum = rigid.apply(carried.velocity.0, carried.velocity.1);
        for internal in model.internals.iter().filter(|internal| internal.link == i) {
            momentum = add(momentum, scale(coupling(data, internal), v[internal.v]));
        }
        carried.inertia = rigid;
        for k in 0..6 {
            let x = unit(k);
            let turned = cross_motion(carried.velocity, x);
            let b = subtract(cross_force(x, momentum), rigid.apply(turned.0, turned.1));
            let b = add(b, cross_force(carried.velocity, rigid.apply(x.0, x.1)));
            for (row, value) in six(b).into_iter().enumerate() {
                carried.velocity_product[row][k] = value;
            }
        }
    }
    for (i, link) in model.links.iter().enumerate().rev().filter(|(_, link)| link.parent > 0) {
        let (before, rest) = work.links.split_at_mut(i + 1);
        let (parent, own) = (&mut before[link.parent], &rest[0]);
        parent.inertia.add(&own.inertia);
        for (row, more) in parent.velocity_product.iter_mut().flatten().zip(own.velocity_product.iter().flatten()) {
            *row += more;
        }
    }
}

fn fill_columns(model: &Model, data: &Data<f64>, work: &mut Derivatives) {
    let point = data.link(0).origin;
    for (i, link) in model.links.iter().enumerate() {
        let (own, parent) = (&work.links[i + 1], &work.links[link.parent]);
        let frame = data.link(i);
        for k in 0..link.v_len {
            let (angular, linear) = frame.subspace(&link.joint, k);
            let motion = (angular, linear + (frame.origin - point).cross(angular));
            let psi_dot = cross_motion(parent.velocity, motion);
            let psi_ddot = add(cross_motion(parent.acceleration, motion), cross_motion(parent.velocity, psi_dot));
            let phi = add(psi_dot, cross_motion(own.velocity, motion));
            let b = &own.velocity_product;
            let moved = add(own.inertia.apply(psi_ddot.0, psi_ddot.1), product(b, psi_dot));
            work.columns[link.v + k] = Column {
                motion,
                psi_dot,
                psi_ddot,
                phi,
                inertia: own.inertia.apply(motion.0, motion.1),
                velocity: product_transposed(b, motion),
                by_position: add(moved, cross_force(motion, own.force)),
                by_velocity: add(own.inertia.apply(phi.0, phi.1), product(b, motion)),
            };
        }
    }
}

/// Every pair of joints on a common chain.
fn fill_joints(model: &Model, work: &Derivatives, dtau_dq: &mut DMatrix<f64>, dtau_dv: &mut DMatrix<f64>) {
    for (i, outer) in model.links.iter().enumerate() {
        let mut at = i + 1;
        while at > 0 {
            let inner = &model.links[at - 1];
            for k in outer.v..outer.v + outer.v_len {
                let deep = &work.columns[k];
                for m in inner.v..inner.v + inner.v_len {
                    let shallow = &work.columns[m];
                    dtau_dq[(k, m)] = dot(deep.inertia, shallow.psi_ddot) + dot(deep.velocity, shallow.psi_dot);
                    dtau_dv[(k, m)] = dot(deep.inertia, shallow.phi) + dot(deep.velocity, shallow.motion);
                    if at != i + 1 {
                        dtau_dq[(m, k)] = dot(shallow.motion, deep.by_position);
                        dtau_dv[(m, k)] = dot(shallow.motion, deep.by_velocity);
                    }
                }
            }
            at = inner.parent;
        }
    }
}

/// Row and column of an internal coordinate: `τ_η = m η̈ + D · a`, `f = … + v ×* D η̇`.
fn fill_internal(
    model: &Model,
    data: &Data<f64>,
    internal: &InternalConstants,
    work: &Derivatives,
    dtau_dq: &mut DMatrix<f64>,
    dtau_dv: &mut DMatrix<f64>,
) {
    let coupling = coupling(data, internal);
    let velocity = work.links[internal.link + 1].velocity;
    let force = cross_force(velocity, coupling);
    let mut at = internal.link + 1;
    while at > 0 {
        let link = &model.links[at - 1];
        for k in link.v..link.v + link.v_len {
            let column = &work.columns[k];
            let by_position = subtract(column.psi_ddot, cross_motion(velocity, column.psi_dot));
            let by_velocity = subtract(column.phi, cross_motion(velocity, column.motion));
            dtau_dq[(internal.v, k)] = dot(coupling, by_position);
            dtau_dv[(internal.v, k)] = dot(coupling, by_velocity);
            dtau_dv[(k, internal.v)] = dot(column.motion, force);
        }
        at = link.parent;
    }
}

/// `D` in world axes about the common point.
fn coupling(data: &Data<f64>, internal: &InternalConstants) -> Spatial {
    let frame = data.link(internal.link);
    let linear = frame.rotation.apply(internal.linear);
    let r = frame.origin - data.link(0).origin;
    (frame.rotation.apply(internal.angular) + r.cross(linear), linear)
}

fn unit(k: usize) -> Spatial {
    let mut values = [0.0; 6];
    values[k] = 1.0;
    (V3::read(&values, 0), V3::read(&values, 3))
}

fn six(x: Spatial) -> [f64; 6] {
    super::data::six(x.0, x.1)
}

fn add(a: Spatial, b: Spatial) -> Spatial {
    (a.0 + b.0, a.1 + b.1)
}

fn subtract(a: Spatial, b: Spatial) -> Spatial {
    (a.0 - b.0, a.1 - b.1)
}

fn scale(a: Spatial, factor: f64) -> Spatial {
    (a.0 * factor, a.1 * factor)
}

fn dot(a: Spatial, b: Spatial) -> f64 {
    a.0.dot(b.0) + a.1.dot(b.1)
}

/// `a ×` on a motion.
fn cross_motion(a: Spatial, b: Spatial) -> Spatial {
    (a.0.cross(b.0), a.0.cross(b.1) + a.1.cross(b.0))
}

/// `a ×*` on a force.
fn cross_force(a: Spatial, f: Spatial) -> Spatial {
    (a.0.cross(f.0) + a.1.cross(f.1), a.0.cross(f.1))
}

fn product(b: &[[f64; 6]; 6], x: Spatial) -> Spatial {
    let x = six(x);
    let rows = b.map(|row| row.iter().zip(x).map(|(b, x)| b * x).sum::<f64>());
    (V3::read(&rows, 0), V3::read(&rows, 3))
}

fn product_transposed(b: &[[f64; 6]; 6], x: Spatial) -> Spatial {
    let mut sum = [0.0; 6];
    for (row, x) in b.iter().zip(six(x)) {
        for (sum, b) in sum.iter_mut().zip(row) {
            *sum += b * x;
        }
    }
    (V3::read(&sum, 0), V3::read(&sum, 3))
}
