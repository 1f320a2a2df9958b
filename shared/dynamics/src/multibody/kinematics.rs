//! Pose and velocity of every link, from the world outwards.
//!
//! World axes throughout, with the *classical* acceleration of each origin (the second derivative
//! of its position): in these terms `α = α_p + b_α + S_α q̈` and
//! `a = a_p + α_p × r + b_a + S_a q̈`, and a rotation is paid once per link. (Featherstone, Rigid
//! Body Dynamics Algorithms, ch. 4, in other coordinates.)

use super::data::{Data, JointForce};
use super::link_state::LinkState;
use super::model::{Joint, LinkConstants, Model};
use super::planar;
use super::vector::{M3, V3};
use crate::real::Real;

/// Pose of every link in the world and its velocity.
///
/// Quaternions need not be of unit length: the rotation is divided by the squared norm.
///
/// Cost: about 25 ns per link, no allocation.
pub fn kinematics<T: Real>(model: &Model, data: &mut Data<T>, q: &[T], v: &[T]) {
    assert!(q.len() == model.q_len());
    assert!(v.len() == model.v_len());
    data.joint_force = JointForce::None;
    (data.frames[0].moment, data.frames[0].force) = (V3::zero(), V3::zero());
    if model.plane {
        walk(model, data, |link, parent, frame| {
            planar::pose(link, parent, frame, q);
            planar::motion(link, parent, frame, v);
        });
    } else {
        walk(model, data, |link, parent, frame| {
            pose(link, parent, frame, q);
            motion(link, parent, frame, v);
        });
    }
}

/// Velocities and bias accelerations at other rates `v`, the poses of the last [`kinematics`]
/// standing.
pub(crate) fn velocities<T: Real>(model: &Model, data: &mut Data<T>, v: &[T]) {
    assert!(v.len() == model.v_len());
    data.joint_force = JointForce::None;
    if model.plane {
        walk(model, data, |link, parent, frame| planar::motion(link, parent, frame, v));
    } else {
        walk(model, data, |link, parent, frame| motion(link, parent, frame, v));
    }
}

/// Visits (link, parent, own) outwards.
#[inline(always)]
fn walk<T: Real>(
    model: &Model,
    data: &mut Data<T>,
    mut visit: impl FnMut(&LinkConstants, &LinkState<T>, &mut LinkState<T>),
) {
    for (i, link) in model.links.iter().enumerate() {
        let (done, rest) = data.frames.split_at_mut(i + 1);
        visit(link, &done[link.parent], &mut rest[0]);
    }
}

/// Pose of one link from that of its parent.
#[inline(always)]
fn pose<T: Real>(link: &LinkConstants, parent: &LinkState<T>, frame: &mut LinkState<T>, q: &[T]) {
    frame.arm = parent.rotation.apply_constant(&link.position);
    match &link.joint {
        Joint::Fixed => frame.rotation = parent.rotation.product_constant(&link.rotation),
        Joint::Revolute { axis_in_parent, along, across, turned } => {
            frame.rotation = parent.rotation.product(&revolute(q[link.q], along, across, turned));
            frame.axis = parent.rotation.apply_constant(axis_in_parent);
        }
        Joint::Prismatic { axis_in_parent } => {
            frame.rotation = parent.rotation.product_constant(&link.rotation);
            frame.axis = parent.rotation.apply_constant(axis_in_parent);
            frame.arm += frame.axis * q[link.q];
        }
        Joint::FreePlanar => {
            free(link, parent, frame, V3::new(q[link.q], q[link.q + 1], T::zero()), about_z(q[link.q + 2]));
        }
        Joint::FreeSpatial => {
            let turn = rotation_of_quaternion(&q[link.q + 3..link.q + 7]);
            free(link, parent, frame, V3::read(q, link.q), turn);
        }
    }
    frame.origin = parent.origin + frame.arm;
}

/// A joint of several degrees of freedom: place and rotation of the link against the joint frame.
#[inline(always)]
fn free<T: Real>(link: &LinkConstants, parent: &LinkState<T>, frame: &mut LinkState<T>, at: V3<T>, turn: M3<T>) {
    if link.along_world {
        frame.arm += at;
        frame.rotation = turn;
    } else {
        let joint_frame = parent.rotation.product_constant(&link.rotation);
        frame.arm += joint_frame.apply(at);
        frame.rotation = joint_frame.product(&turn);
    }
}

/// Velocity and bias acceleration of one link whose pose is known.
#[inline(always)]
fn motion<T: Real>(link: &LinkConstants, parent: &LinkState<T>, frame: &mut LinkState<T>, v: &[T]) {
    let omega = parent.omega;
    let swept = omega.cross(frame.arm);
    frame.omega = omega;
    frame.velocity = parent.velocity + swept;
    frame.bias_angular = V3::zero();
    frame.bias_linear = omega.cross(swept);
    match &link.joint {
        Joint::Fixed => {}
        Joint::Revolute { .. } => {
            let relative = frame.axis * v[link.v];
            frame.omega += relative;
            frame.bias_angular = omega.cross(relative);
        }
        Joint::Prismatic { .. } => {
            let relative = frame.axis * v[link.v];
            frame.velocity += relative;
            let coriolis = omega.cross(relative);
            frame.bias_linear += coriolis + coriolis;
        }
        Joint::FreePlanar | Joint::FreeSpatial => {
            let (relative_omega, relative) = frame.joint_motion(&link.joint, &v[link.v..link.v + link.v_len]);
            frame.omega += relative_omega;
            frame.velocity += relative;
            frame.bias_angular = omega.cross(relative_omega);
            frame.bias_linear += (omega + frame.omega).cross(relative);
        }
    }
}

#[inline(always)]
fn revolute<T: Real>(angle: T, along: &M3<f64>, across: &M3<f64>, turned: &M3<f64>) -> M3<T> {
    let (sin, cos) = angle.sin_cos();
    let entry = |a: f64, c: f64, s: f64| T::constant(a) + cos.scale(c) + sin.scale(s);
    let row = |i: usize| {
        let (a, c, s) = (&along.rows[i], &across.rows[i], &turned.rows[i]);
        V3::new(entry(a.x, c.x, s.x), entry(a.y, c.y, s.y), entry(a.z, c.z, s.z))
    };
    M3 { rows: [row(0), row(1), row(2)] }
}

#[inline(always)]
pub(crate) fn about_z<T: Real>(angle: T) -> M3<T> {
    let (sin, cos) = angle.sin_cos();
    let (zero, one) = (T::zero(), T::one());
    M3 { rows: [V3::new(cos, -sin, zero), V3::new(sin, cos, zero), V3::new(zero, zero, one)] }
}

/// Rotation of `[w, x, y, z]` divided by its squared norm.
#[inline(always)]
pub(crate) fn rotation_of_quaternion<T: Real>(quaternion: &[T]) -> M3<T> {
    let [w, x, y, z] = [quaternion[0], quaternion[1], quaternion[2], quaternion[3]];
    let one = T::one();
    let two = (one + one) / (w * w + x * x + y * y + z * z);
    let (tx, ty, tz) = (x * two, y * two, z * two);
    let (wx, wy, wz) = (w * tx, w * ty, w * tz);
    let (xx, xy, xz) = (x * tx, x * ty, x * tz);
    let (yy, yz, zz) = (y * ty, y * tz, z * tz);
    M3 {
        rows: [
            V3::new(one - yy - zz, xy - wz, xz + wy),
            V3::new(xy + wz, one - xx - zz, yz - wx),
            V3::new(xz - wy, yz + wx, one - xx - yy),
        ],
    }
}

impl<T: Real> LinkState<T> {
    /// Column `k` of the joint's motion subspace `S` in world axes at the link's origin: (angular,
    /// linear).
    #[inline(always)]
    pub(crate) fn subspace(&self, joint: &Joint, k: usize) -> (V3<T>, V3<T>) {
        let column = |k: usize| match k {
            0 => self.rotation.column_x(),
            1 => self.rotation.column_y(),
            _ => self.rotation.column_z(),
        };
        match joint {
            Joint::Fixed => (V3::zero(), V3::zero()),
            Joint::Revolute { .. } => (self.axis, V3::zero()),
            Joint::Prismatic { .. } => (V3::zero(), self.axis),
            Joint::FreePlanar if k == 0 => (column(2), V3::zero()),
            Joint::FreePlanar => (V3::zero(), column(k - 1)),
            Joint::FreeSpatial if k < 3 => (column(k), V3::zero()),
            Joint::FreeSpatial => (V3::zero(), column(k - 3)),
        }
    }

    /// `S x` for the joint's own coordinates `x`.
    #[inline(always)]
    pub(crate) fn joint_motion(&self, joint: &Joint, x: &[T]) -> (V3<T>, V3<T>) {
        match joint {
            Joint::Fixed => (V3::zero(), V3::zero()),
            Joint::Revolute { .. } => (self.axis * x[0], V3::zero()),
            Joint::Prismatic { .. } => (V3::zero(), self.axis * x[0]),
            Joint::FreePlanar => {
                (self.rotation.column_z() * x[0], self.rotation.column_x() * x[1] + self.rotation.column_y() * x[2])
            }
            Joint::FreeSpatial => (self.rotation.apply(V3::read(x, 0)), self.rotation.apply(V3::read(x, 3))),
        }
    }

    /// `Sᵀ (moment, force)` into the joint's own coordinates.
    #[inline(always)]
    pub(crate) fn joint_effort(&self, joint: &Joint, moment: V3<T>, force: V3<T>, out: &mut [T]) {
        match joint {
            Joint::Fixed => {}
            Joint::Revolute { .. } => out[0] = self.axis.dot(moment),
            Joint::Prismatic { .. } => out[0] = self.axis.dot(force),
            Joint::FreePlanar => {
                out[0] = self.rotation.column_z().dot(moment);
                out[1] = self.rotation.column_x().dot(force);
                out[2] = self.rotation.column_y().dot(force);
            }
            Joint::FreeSpatial => {
                self.rotation.apply_transposed(moment).write(out, 0);
                self.rotation.apply_transposed(force).write(out, 3);
            }
        }
    }
}
