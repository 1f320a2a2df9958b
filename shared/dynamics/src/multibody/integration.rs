//! Moving a position along a velocity: on the group in one step, and as a rate for Runge–Kutta.

use super::data::Data;
use super::kinematics::{about_z, rotation_of_quaternion};
use super::model::{Joint, LinkConstants, Model};
use super::vector::V3;
use crate::real::Real;

/// `q_out = q ⊞ v dt`: the position after `dt` at constant joint velocities, exact on the group
/// (screw motion of a free joint).
///
/// Also the retraction of estimators and optimisers (`dt = 1`, `v` the step in tangent space).
/// Quaternions come out with unit length. Internal velocities are ignored.
pub fn integrate_position<T: Real>(model: &Model, q: &[T], v: &[T], dt_s: T, q_out: &mut [T]) {
    assert!(q.len() == model.q_len());
    assert!(v.len() == model.v_len());
    assert!(q_out.len() == model.q_len());
    for link in &model.links {
        match link.joint {
            Joint::Fixed => {}
            Joint::Revolute { .. } | Joint::Prismatic { .. } => q_out[link.q] = q[link.q] + v[link.v] * dt_s,
            Joint::FreePlanar => {
                let turn = v[link.v] * dt_s;
                let (a, b, _) = exponential_series(turn * turn);
                let (dx, dy) = (v[link.v + 1] * dt_s, v[link.v + 2] * dt_s);
                // chord of the arc, body axes
                let (x, y) = (a * dx - b * turn * dy, b * turn * dx + a * dy);
                let (sin, cos) = q[link.q + 2].sin_cos();
                q_out[link.q] = q[link.q] + cos * x - sin * y;
                q_out[link.q + 1] = q[link.q + 1] + sin * x + cos * y;
                q_out[link.q + 2] = q[link.q + 2] + turn;
            }
            Joint::FreeSpatial => screw(link, q, v, dt_s, q_out),
        }
    }
}

/// Screw motion of a free joint: `p + R V(θ) v dt`, `q ⊗ exp(θ/2)`.
fn screw<T: Real>(link: &LinkConstants, q: &[T], v: &[T], dt_s: T, q_out: &mut [T]) {
    let turn = V3::read(v, link.v) * dt_s;
    let travel = V3::read(v, link.v + 3) * dt_s;
    let (_, b, c) = exponential_series(turn.dot(turn));
    let quaternion = &q[link.q + 3..link.q + 7];
    let rotation = rotation_of_quaternion(quaternion);
    // V = 1 + b θ× + c θ×θ×; sin(θ/2)/θ from the same series at half the angle
    let moved = travel + turn.cross(travel) * b + turn.cross_twice(travel) * c;
    (V3::read(q, link.q) + rotation.apply(moved)).write(q_out, link.q);
    let half = turn.scale(0.5);
    let half_square = half.dot(half);
    let (sinc, b_half, _) = exponential_series(half_square);
    let step = [T::one() - b_half * half_square, half.x * sinc, half.y * sinc, half.z * sinc];
    let product = quaternion_product(quaternion, step);
    let norm = product.iter().fold(T::zero(), |sum, x| sum + *x * *x).sqrt();
    for (out, value) in q_out[link.q + 3..link.q + 7].iter_mut().zip(product) {
        *out = value / norm;
    }
}

/// `(sin θ/θ, (1 − cos θ)/θ², (θ − sin θ)/θ³)` of `θ²`, smooth through zero.
fn exponential_series<T: Real>(square: T) -> (T, T, T) {
    let one = T::one();
    // below, six terms leave 0.25^6/15! of the leading one; above, 1 − cos θ keeps 14 digits
    if square.value() < 0.25 {
        let sum = |first: u32| {
            let mut term = one;
            let mut total = one;
            for k in 1..9 {
                let n = f64::from(first + 2 * k);
                term *= -square.scale(1.0 / (n * (n - 1.0)));
                total += term;
            }
            total
        };
        return (sum(1), sum(2).scale(0.5), sum(3).scale(1.0 / 6.0));
    }
    let angle = square.sqrt();
    let (sin, cos) = angle.sin_cos();
    let a = sin / angle;
    (a, (one - cos) / square, (one - a) / square)
}

fn quaternion_product<T: Real>(a: &[T], b: [T; 4]) -> [T; 4] {
    let (w, u) = (a[0], V3::new(a[1], a[2], a[3]));
    let t = V3::new(b[1], b[2], b[3]);
    let vector = t * w + u * b[0] + u.cross(t);
    [w * b[0] - u.dot(t), vector.x, vector.y, vector.z]
}

/// `q̇` of a position at velocities `v`: for a quaternion `½ q ⊗ ω`, which keeps its length.
pub fn position_rate<T: Real>(model: &Model, q: &[T], v: &[T], q_dot: &mut [T]) {
    assert!(q.len() == model.q_len());
    assert!(v.len() == model.v_len());
    assert!(q_dot.len() == model.q_len());
    for link in &model.links {
        match link.joint {
            Joint::Fixed => {}
            Joint::Revolute { .. } | Joint::Prismatic { .. } => q_dot[link.q] = v[link.v],
            Joint::FreePlanar | Joint::FreeSpatial => free_rate(link, relative_velocity(link, q, v), q, v, q_dot),
        }
    }
}

/// [`position_rate`] when [`kinematics`](super::kinematics) of the same state is in `data`:
/// rotations are known.
pub fn position_rate_after_kinematics<T: Real>(model: &Model, data: &Data<T>, q: &[T], v: &[T], q_dot: &mut [T]) {
    assert!(q.len() == model.q_len());
    assert!(v.len() == model.v_len());
    assert!(q_dot.len() == model.q_len());
    for (i, link) in model.links.iter().enumerate() {
        match link.joint {
            Joint::Fixed => {}
            Joint::Revolute { .. } | Joint::Prismatic { .. } => q_dot[link.q] = v[link.v],
            Joint::FreePlanar | Joint::FreeSpatial => {
                let along = if link.along_world { data.link(i).velocity } else { relative_velocity(link, q, v) };
                free_rate(link, along, q, v, q_dot);
            }
        }
    }
}

/// Velocity of the origin of a free link against its joint frame, axes of that frame.
#[inline(always)]
fn relative_velocity<T: Real>(link: &LinkConstants, q: &[T], v: &[T]) -> V3<T> {
    if link.v_len == 3 {
        return about_z(q[link.q + 2]).apply(V3::new(v[link.v + 1], v[link.v + 2], T::zero()));
    }
    rotation_of_quaternion(&q[link.q + 3..link.q + 7]).apply(V3::read(v, link.v + 3))
}

/// `q̇` of a free joint whose origin moves by `along`.
#[inline(always)]
fn free_rate<T: Real>(link: &LinkConstants, along: V3<T>, q: &[T], v: &[T], q_dot: &mut [T]) {
    if link.v_len == 3 {
        (q_dot[link.q], q_dot[link.q + 1], q_dot[link.q + 2]) = (along.x, along.y, v[link.v]);
        return;
    }
    along.write(q_dot, link.q);
    let half = V3::read(v, link.v).scale(0.5);
    let rate = quaternion_product(&q[link.q + 3..link.q + 7], [T::zero(), half.x, half.y, half.z]);
    q_dot[link.q + 3..link.q + 7].copy_from_slice(&rate);
}
