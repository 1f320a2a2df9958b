//! The kernels of kinematics and forward dynamics where everything turns about z and moves in x and
//! y.
//!
//! The same algorithm on the same frames, with the products by zero left out: a rotation is a sine
//! and a cosine, an inertia `[n; f] = [I b; bᵀ C] [α; a]` has six numbers. Out of the plane only
//! reactions are left, of gravity along z and of wrenches; they are handed inwards beside the rest.
//! What is not written here keeps what [`Data::new`](super::Data::new) gave it.

use super::link_state::{Elimination, LinkState};
use super::model::{InternalConstants, Joint, LinkConstants};
use super::vector::V3;
use crate::real::Real;

/// The tree lies in the x–y plane: joints, offsets, centres of mass, couplings; z is a principal
/// axis of every link.
pub(super) fn lies_in_plane(links: &[LinkConstants], internals: &[InternalConstants]) -> bool {
    let along_z = |v: &V3<f64>| v.x == 0.0 && v.y == 0.0;
    let link_lies = |link: &LinkConstants| {
        let joint_lies = match &link.joint {
            Joint::FreeSpatial => false,
            Joint::FreePlanar => link.parent == 0,
            Joint::Fixed => true,
            Joint::Revolute { axis_in_parent, .. } => along_z(axis_in_parent),
            Joint::Prismatic { axis_in_parent } => axis_in_parent.z == 0.0,
        };
        let mounted = along_z(&link.rotation.rows[2]) && along_z(&link.rotation.column_z());
        let principal = link.inertia_origin.xz == 0.0 && link.inertia_origin.yz == 0.0;
        joint_lies
            && mounted
            && link.rotation.rows[2].z > 0.0
            && principal
            && link.position.z == 0.0
            && link.com.z == 0.0
    };
    links.iter().all(link_lies) && internals.iter().all(|one| along_z(&one.angular) && one.linear.z == 0.0)
}

/// A vector of the plane.
type V2<T> = (T, T);

/// `[cos −sin; sin cos]` by its first column.
#[inline(always)]
fn turn<T: Real>(frame: &LinkState<T>) -> V2<T> {
    (frame.rotation.rows[0].x, frame.rotation.rows[1].x)
}

#[inline(always)]
fn turned<T: Real>((cos, sin): V2<T>, (x, y): V2<T>) -> V2<T> {
    (cos * x - sin * y, sin * x + cos * y)
}

#[inline(always)]
fn turned_constant<T: Real>((cos, sin): V2<T>, v: &V3<f64>) -> V2<T> {
    (cos.scale(v.x) - sin.scale(v.y), sin.scale(v.x) + cos.scale(v.y))
}

/// Pose of one link from that of its parent.
#[inline(always)]
pub(super) fn pose<T: Real>(link: &LinkConstants, parent: &LinkState<T>, frame: &mut LinkState<T>, q: &[T]) {
    let base = turn(parent);
    let mut arm = turned_constant(base, &link.position);
    let mounted = link.rotation.column_x();
    let (cos, sin) = match &link.joint {
        Joint::Revolute { axis_in_parent, across, turned: sideways, .. } => {
            frame.axis.z = T::constant(axis_in_parent.z);
            let (sin, cos) = q[link.q].sin_cos();
            let entry = |c: f64, s: f64| cos.scale(c) + sin.scale(s);
            let (c, s) = (across.column_x(), sideways.column_x());
            turned(base, (entry(c.x, s.x), entry(c.y, s.y)))
        }
        Joint::FreePlanar => {
            let joint_frame = turned_constant(base, &mounted);
            let at = turned(joint_frame, (q[link.q], q[link.q + 1]));
            arm = (arm.0 + at.0, arm.1 + at.1);
            let (sin, cos) = q[link.q + 2].sin_cos();
            turned(joint_frame, (cos, sin))
        }
        Joint::Prismatic { axis_in_parent } => {
            let axis = turned_constant(base, axis_in_parent);
            (frame.axis.x, frame.axis.y) = axis;
            arm = (arm.0 + axis.0 * q[link.q], arm.1 + axis.1 * q[link.q]);
            turned_constant(base, &mounted)
        }
        Joint::Fixed | Joint::FreeSpatial => turned_constant(base, &mounted),
    };
    let [first, second, _] = &mut frame.rotation.rows;
    (first.x, first.y, second.x, second.y) = (cos, -sin, sin, cos);
    (frame.arm.x, frame.arm.y) = arm;
    (frame.origin.x, frame.origin.y) = (parent.origin.x + arm.0, parent.origin.y + arm.1);
}

/// Velocity and bias acceleration of one link whose pose is known.
#[inline(always)]
pub(super) fn motion<T: Real>(link: &LinkConstants, parent: &LinkState<T>, frame: &mut LinkState<T>, v: &[T]) {
    let omega = parent.omega.z;
    let swept = (-omega * frame.arm.y, omega * frame.arm.x);
    let mut own = omega;
    let mut velocity = (parent.velocity.x + swept.0, parent.velocity.y + swept.1);
    let mut bias = (-omega * swept.1, omega * swept.0);
    let mut slide = |relative: V2<T>, coriolis: T| {
        velocity = (velocity.0 + relative.0, velocity.1 + relative.1);
        bias = (bias.0 - coriolis * relative.1, bias.1 + coriolis * relative.0);
    };
    match link.joint {
        Joint::Revolute { .. } => own += frame.axis.z * v[link.v],
        Joint::FreePlanar => {
            own += v[link.v];
            slide(turned(turn(frame), (v[link.v + 1], v[link.v + 2])), omega + own);
        }
        Joint::Prismatic { .. } => {
            let rate = v[link.v];
            slide((frame.axis.x * rate, frame.axis.y * rate), omega + omega);
        }
        Joint::Fixed | Joint::FreeSpatial => {}
    }
    frame.omega.z = own;
    (frame.velocity.x, frame.velocity.y) = velocity;
    (frame.bias_linear.x, frame.bias_linear.y) = bias;
}

/// Inertia of the link alone and the force it needs at zero acceleration.
#[inline(always)]
pub(super) fn rigid_body<T: Real>(link: &LinkConstants, frame: &mut LinkState<T>) {
    let (mut x, mut y) = turned_constant(turn(frame), &link.first_moment);
    let (mut mass, mut turning) = (T::constant(link.mass), T::constant(link.inertia_origin.zz));
    if frame.carried.acts {
        let (carried, at) = (&frame.carried, &frame.carried.position);
        let m = carried.mass;
        let more = turned(turn(frame), (carried.shift.x + at.x * m, carried.shift.y + at.y * m));
        (x, y, mass) = (x + more.0, y + more.1, mass + m);
        turning += (at.x * at.x + at.y * at.y) * m;
    }
    let inertia = &mut frame.inertia;
    inertia.a.zz = turning;
    let [first, second, third] = &mut inertia.b.rows;
    (first.z, second.z, third.x, third.y) = (y, -x, -y, x);
    (inertia.c.xx, inertia.c.xy, inertia.c.yy, inertia.c.zz) = (mass, T::zero(), mass, mass);
    let square = frame.omega.z * frame.omega.z;
    (frame.moment, frame.force) = (V3::zero(), V3::new(-x * square, -y * square, T::zero()));
}

/// `[I b; bᵀ C]` of an articulated body.
struct Articulated<T> {
    i: T,
    b: V2<T>,
    c: (T, T, T),
}

impl<T: Real> Articulated<T> {
    /// `self − u uᵀ/d`, and the force that remains; `u` moment, then force.
    #[inline(always)]
    fn eliminate(&mut self, u: (T, T, T), d: T, effort: T, moment: &mut V3<T>, force: &mut V3<T>) -> Elimination<T> {
        let reciprocal = T::one() / d;
        let w = (u.0 * reciprocal, u.1 * reciprocal, u.2 * reciprocal);
        self.i -= u.0 * w.0;
        self.b = (self.b.0 - u.1 * w.0, self.b.1 - u.2 * w.0);
        self.c = (self.c.0 - u.1 * w.1, self.c.1 - u.1 * w.2, self.c.2 - u.2 * w.2);
        moment.z += w.0 * effort;
        force.x += w.1 * effort;
        force.y += w.2 * effort;
        Elimination {
            u_angular: V3::new(T::zero(), T::zero(), u.0),
            u_linear: V3::new(u.1, u.2, T::zero()),
            reciprocal,
            effort,
        }
    }
}

/// Articulated inertia and force handed through the joint to the parent.
#[inline(always)]
pub(super) fn eliminate_joint<T: Real>(
    link: &LinkConstants,
    parent: &mut LinkState<T>,
    frame: &mut LinkState<T>,
    tau: &[T],
    acceleration: &[T],
    given: bool,
) {
    let whole = &frame.inertia;
    let mut body = Articulated {
        i: whole.a.zz,
        b: (whole.b.rows[2].x, whole.b.rows[2].y),
        c: (whole.c.xx, whole.c.xy, whole.c.yy),
    };
    let (mut moment, mut force) = (frame.moment, frame.force);
    let (mut alpha, mut linear) = (T::zero(), (frame.bias_linear.x, frame.bias_linear.y));
    match link.joint {
        Joint::Revolute { .. } if given => alpha = frame.axis.z * acceleration[link.v],
        Joint::Prismatic { .. } if given => {
            let along = acceleration[link.v];
            linear = (linear.0 + frame.axis.x * along, linear.1 + frame.axis.y * along);
        }
        Joint::Revolute { .. } => {
            let s = frame.axis.z;
            let u = (body.i * s, body.b.0 * s, body.b.1 * s);
            let (d, effort) = (s * u.0 + T::constant(link.armature), tau[link.v] - s * moment.z);
            frame.joint[0] = body.eliminate(u, d, effort, &mut moment, &mut force);
        }
        Joint::Prismatic { .. } => {
            let (x, y) = (frame.axis.x, frame.axis.y);
            let (xx, xy, yy) = body.c;
            let u = (body.b.0 * x + body.b.1 * y, xx * x + xy * y, xy * x + yy * y);
            let d = x * u.1 + y * u.2 + T::constant(link.armature);
            let effort = tau[link.v] - x * force.x - y * force.y;
            frame.joint[0] = body.eliminate(u, d, effort, &mut moment, &mut force);
        }
        Joint::FreePlanar if !given => root(link, frame, tau),
        Joint::FreePlanar | Joint::Fixed | Joint::FreeSpatial => {}
    }
    if link.parent == 0 {
        return;
    }
    let (b, (xx, xy, yy)) = (body.b, body.c);
    moment.z += body.i * alpha + b.0 * linear.0 + b.1 * linear.1;
    force.x += b.0 * alpha + xx * linear.0 + xy * linear.1;
    force.y += b.1 * alpha + xy * linear.0 + yy * linear.1;
    // to the parent's origin: B' = B + r× C, A' = A + r× Bᵀ − B' r×
    let (x, y) = (frame.arm.x, frame.arm.y);
    let moved = (b.0 + x * xy - y * xx, b.1 + x * yy - y * xy);
    let (mass, out) = (frame.inertia.c.zz, (frame.inertia.b.rows[0].z, frame.inertia.b.rows[1].z));
    let sum = &mut parent.inertia;
    sum.a.zz += body.i + x * (b.1 + moved.1) - y * (b.0 + moved.0);
    let [first, second, third] = &mut sum.b.rows;
    first.z += out.0 + y * mass;
    second.z += out.1 - x * mass;
    third.x += moved.0;
    third.y += moved.1;
    sum.c.xx += xx;
    sum.c.xy += xy;
    sum.c.yy += yy;
    sum.c.zz += mass;
    parent.moment += moment + frame.arm.cross(force);
    parent.force += force;
}

/// Accelerations of a free root.
#[inline(always)]
fn root<T: Real>(link: &LinkConstants, frame: &mut LinkState<T>, tau: &[T]) {
    let (inertia, b) = (&frame.inertia, frame.inertia.b.rows[2]);
    let (x, y) = turned(turn(frame), (tau[link.v + 1], tau[link.v + 2]));
    let (moment, fx, fy) = (tau[link.v] - frame.moment.z, x - frame.force.x, y - frame.force.y);
    // translation first, by its 2 × 2 inverse: two divisions one after the other instead of three
    let c = &inertia.c;
    let scale = T::one() / (c.xx * c.yy - c.xy * c.xy);
    let solve = |x: T, y: T| ((c.yy * x - c.xy * y) * scale, (c.xx * y - c.xy * x) * scale);
    let (px, py) = solve(b.x, b.y);
    let (gx, gy) = solve(fx, fy);
    let alpha = (moment - px * fx - py * fy) / (inertia.a.zz - px * b.x - py * b.y);
    frame.alpha.z = alpha;
    (frame.acceleration.x, frame.acceleration.y) = (gx - px * alpha, gy - py * alpha);
}

/// Acceleration of the joint and the link from that of the parent.
#[inline(always)]
pub(super) fn accelerate<T: Real>(
    link: &LinkConstants,
    parent: &LinkState<T>,
    frame: &mut LinkState<T>,
    acceleration: &mut [T],
    given: bool,
) {
    let mut alpha = parent.alpha.z;
    let mut x = parent.acceleration.x - alpha * frame.arm.y + frame.bias_linear.x;
    let mut y = parent.acceleration.y + alpha * frame.arm.x + frame.bias_linear.y;
    frame.acceleration.z = parent.acceleration.z;
    let yielding = |alpha: T, x: T, y: T| {
        let joint = &frame.joint[0];
        (joint.effort - joint.u_angular.z * alpha - joint.u_linear.x * x - joint.u_linear.y * y) * joint.reciprocal
    };
    match link.joint {
        Joint::Revolute { .. } => {
            if !given {
                acceleration[link.v] = yielding(alpha, x, y);
            }
            alpha += frame.axis.z * acceleration[link.v];
        }
        Joint::Prismatic { .. } => {
            if !given {
                acceleration[link.v] = yielding(alpha, x, y);
            }
            x += frame.axis.x * acceleration[link.v];
            y += frame.axis.y * acceleration[link.v];
        }
        Joint::FreePlanar if given => {
            alpha += acceleration[link.v];
            let along = turned(turn(frame), (acceleration[link.v + 1], acceleration[link.v + 2]));
            (x, y) = (x + along.0, y + along.1);
        }
        Joint::FreePlanar => {
            let (cos, sin) = turn(frame);
            acceleration[link.v] = frame.alpha.z - alpha;
            let own = turned((cos, -sin), (frame.acceleration.x - x, frame.acceleration.y - y));
            (acceleration[link.v + 1], acceleration[link.v + 2]) = own;
            return;
        }
        Joint::Fixed | Joint::FreeSpatial => {}
    }
    frame.alpha.z = alpha;
    (frame.acceleration.x, frame.acceleration.y) = (x, y);
}

/// Effort of a joint with one degree of freedom whose link's acceleration is known; `false` where
/// it has others.
#[inline(always)]
pub(super) fn effort<T: Real>(link: &LinkConstants, frame: &LinkState<T>, tau: &mut [T]) -> bool {
    let (b, c) = (frame.inertia.b.rows[2], &frame.inertia.c);
    let (alpha, x, y) = (frame.alpha.z, frame.acceleration.x, frame.acceleration.y);
    match link.joint {
        Joint::Revolute { .. } => {
            tau[0] = frame.axis.z * (frame.inertia.a.zz * alpha + b.x * x + b.y * y + frame.moment.z);
        }
        Joint::Prismatic { .. } => {
            let along_x = b.x * alpha + c.xx * x + c.xy * y + frame.force.x;
            tau[0] = frame.axis.x * along_x + frame.axis.y * (b.y * alpha + c.xy * x + c.yy * y + frame.force.y);
        }
        Joint::Fixed | Joint::FreePlanar | Joint::FreeSpatial => return false,
    }
    true
}
