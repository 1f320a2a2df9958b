//! Vectors, rotations and rotation vectors as arrays of a [`Real`].

use crate::description::{Orientation, Quantity};
use crate::real::Real;
use nalgebra::{Matrix3, Vector3};

pub(super) type Rotation<T> = [[T; 3]; 3];

#[inline]
pub(super) fn dot<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Component of `a` along the constant `axis`.
#[inline]
pub(super) fn along<T: Real>(a: [T; 3], axis: &[f64; 3]) -> T {
    a[0].scale(axis[0]) + a[1].scale(axis[1]) + a[2].scale(axis[2])
}

#[inline]
pub(super) fn cross<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline]
pub(super) fn add<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline]
pub(super) fn subtract<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
pub(super) fn times<T: Real>(a: [T; 3], factor: T) -> [T; 3] {
    a.map(|x| x * factor)
}

/// `R a`.
#[inline]
pub(super) fn turn<T: Real>(r: &Rotation<T>, a: [T; 3]) -> [T; 3] {
    [dot(r[0], a), dot(r[1], a), dot(r[2], a)]
}

/// `Rᵀ a`.
#[inline]
pub(super) fn turn_back<T: Real>(r: &Rotation<T>, a: [T; 3]) -> [T; 3] {
    let column = |j: usize| r[0][j] * a[0] + r[1][j] * a[1] + r[2][j] * a[2];
    [column(0), column(1), column(2)]
}

/// `Aᵀ B`.
pub(super) fn transposed_product<T: Real>(a: &Rotation<T>, b: &Rotation<T>) -> Rotation<T> {
    let entry = |i: usize, j: usize| a[0][i] * b[0][j] + a[1][i] * b[1][j] + a[2][i] * b[2][j];
    core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j)))
}

/// Rotation by the vector `phi` applied to `a` (Rodrigues); series below 0.01 rad, where its error
/// is under rounding.
pub(super) fn rotate_by_vector<T: Real>(phi: [T; 3], a: [T; 3]) -> [T; 3] {
    let square = dot(phi, phi);
    let (first, second) = if square.value() < 1e-4 {
        // sin θ/θ and (1 − cos θ)/θ² to θ⁶
        let first = T::one() - (square - (square * square).scale(1.0 / 20.0)).scale(1.0 / 6.0);
        let second = T::constant(0.5) - (square - (square * square).scale(1.0 / 30.0)).scale(1.0 / 24.0);
        (first - square.powi(3).scale(1.0 / 5040.0), second - square.powi(3).scale(1.0 / 40320.0))
    } else {
        let angle = square.sqrt();
        let (sin, cos) = angle.sin_cos();
        (sin / angle, (T::one() - cos) / square)
    };
    let turned = cross(phi, a);
    add(a, add(times(turned, first), times(cross(phi, turned), second)))
}

/// Quaternion `[w, x, y, z]` of a rotation, w ≥ 0 (Shepperd: the largest component first).
pub(super) fn quaternion_of<T: Real>(r: &Rotation<T>) -> [T; 4] {
    let one = T::one();
    let squares = [
        one + r[0][0] + r[1][1] + r[2][2],
        one + r[0][0] - r[1][1] - r[2][2],
        one - r[0][0] + r[1][1] - r[2][2],
        one - r[0][0] - r[1][1] + r[2][2],
    ];
    let largest = (1..4).fold(0, |best, k| if squares[k] > squares[best] { k } else { best });
    let size = squares[largest].sqrt();
    let half = T::constant(0.5) / size;
    let (a, b, c) = (r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]);
    let (xy, xz, yz) = (r[0][1] + r[1][0], r[0][2] + r[2][0], r[1][2] + r[2][1]);
    let own = size.scale(0.5);
    let quaternion = match largest {
        0 => [own, a * half, b * half, c * half],
        1 => [a * half, own, xy * half, xz * half],
        2 => [b * half, xy * half, own, yz * half],
        _ => [c * half, xz * half, yz * half, own],
    };
    if quaternion[0] < T::zero() { quaternion.map(|x| -x) } else { quaternion }
}

/// Rotation vector of a unit quaternion with w ≥ 0; at most π long.
pub(super) fn rotation_vector_of_quaternion<T: Real>(q: [T; 4]) -> [T; 3] {
    let vector = [q[1], q[2], q[3]];
    let square = dot(vector, vector);
    let factor = if square.value() < 1e-4 {
        // 2 atan(r)/(r w), r = |v|/w
        let r = square / (q[0] * q[0]);
        let series = T::one() - r * (T::constant(1.0 / 3.0) - r * (T::constant(0.2) - r.scale(1.0 / 7.0)));
        (series + r.powi(4).scale(1.0 / 9.0)).scale(2.0) / q[0]
    } else {
        let size = square.sqrt();
        size.atan2(q[0]).scale(2.0) / size
    };
    times(vector, factor)
}

/// Rotation vector of a rotation.
pub(super) fn rotation_vector<T: Real>(r: &Rotation<T>) -> [T; 3] {
    rotation_vector_of_quaternion(quaternion_of(r))
}

/// Unit quaternion of a rotation vector.
pub(super) fn quaternion_of_vector(phi: [f64; 3]) -> [f64; 4] {
    let angle = dot(phi, phi).sqrt();
    let (sin, cos) = libm::sincos(0.5 * angle);
    let factor = if angle < 1e-8 { 0.5 } else { sin / angle };
    [cos, factor * phi[0], factor * phi[1], factor * phi[2]]
}

/// Hamilton product.
pub(super) fn quaternion_product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let (u, v) = ([a[1], a[2], a[3]], [b[1], b[2], b[3]]);
    let w = cross(u, v);
    let part = |k: usize| a[0] * v[k] + b[0] * u[k] + w[k];
    [a[0] * b[0] - dot(u, v), part(0), part(1), part(2)]
}

/// `angle` about the unit vector `axis`.
pub(super) fn rotation_about(axis: &[f64; 3], angle_rad: f64) -> Matrix3<f64> {
    let k = Vector3::from(*axis).cross_matrix();
    let (sin, cos) = libm::sincos(angle_rad);
    Matrix3::identity() + k * sin + k * k * (1.0 - cos)
}

pub(super) fn rotation_of(orientation: &Orientation) -> Matrix3<f64> {
    rotation_about(&orientation.axis, orientation.angle_rad.value)
}

/// `axis` turned by `orientation`.
pub(super) fn turned_axis(axis: &[f64; 3], orientation: &Orientation) -> [f64; 3] {
    (rotation_of(orientation) * Vector3::from(*axis)).into()
}

pub(super) fn values(vector: &[Quantity; 3]) -> [f64; 3] {
    vector.map(|quantity| quantity.value)
}
