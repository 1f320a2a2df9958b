//! Vectors and directions of the laws.

use dynamics::effect::Local;
use dynamics::real::Real;

/// Unit vector at `azimuth` from x towards y, raised by `elevation` towards z [rad].
pub fn direction(azimuth_rad: f64, elevation_rad: f64) -> [f64; 3] {
    let (sin_a, cos_a) = libm::sincos(azimuth_rad);
    let (sin_e, cos_e) = libm::sincos(elevation_rad);
    [cos_e * cos_a, cos_e * sin_a, sin_e]
}

/// Unit vector perpendicular to the unit vector `axis`, turned about it by `clock_rad`. At zero
/// clock it is z × axis, so that planar plants stay in their plane; for an axis along z it is x.
pub fn perpendicular(axis: [f64; 3], clock_rad: f64) -> [f64; 3] {
    // below 1e-6 rad from z the projection has lost ten digits, and the choice is free
    let length = libm::sqrt(axis[0] * axis[0] + axis[1] * axis[1]);
    let first = if length > 1e-6 { [-axis[1] / length, axis[0] / length, 0.0] } else { [1.0, 0.0, 0.0] };
    let second = cross_f64(axis, first);
    let (sin, cos) = libm::sincos(clock_rad);
    core::array::from_fn(|i| cos * first[i] + sin * second[i])
}

/// Two unit vectors perpendicular to the unit vector `axis` and to each other: t1 = z × axis (x for
/// an axis along z), t2 = axis × t1.
pub fn across(axis: [f64; 3]) -> [[f64; 3]; 2] {
    let first = perpendicular(axis, 0.0);
    [first, cross_f64(axis, first)]
}

/// `axis` turned by the angle `|tilt|` towards `tilt[0] t1 + tilt[1] t2`: regular at zero tilt.
pub fn tilted(axis: [f64; 3], [first, second]: [[f64; 3]; 2], tilt: [f64; 2]) -> [f64; 3] {
    let (cos, along) = tilt_factors(tilt);
    core::array::from_fn(|i| cos * axis[i] + along * (tilt[0] * first[i] + tilt[1] * second[i]))
}

/// `cos e` and `sin e / e` of a tilt of length e.
pub fn tilt_factors(tilt: [f64; 2]) -> (f64, f64) {
    let square = tilt[0] * tilt[0] + tilt[1] * tilt[1];
    let angle = libm::sqrt(square);
    // below 1e-4 rad the series is exact to rounding, and there is no division by zero
    if angle < 1e-4 { (1.0 - 0.5 * square, 1.0 - square / 6.0) } else { (libm::cos(angle), libm::sin(angle) / angle) }
}

/// `a × b` of constants.
pub fn cross_f64(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A constant vector as a vector of `T`, with zero derivative.
pub fn constant<T: Real>(a: [f64; 3]) -> [T; 3] {
    a.map(T::constant)
}

/// `a + b`.
pub fn add<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    core::array::from_fn(|i| a[i] + b[i])
}

/// `a · b`.
pub fn dot<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a × b`.
pub fn cross<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Euclidean length; at zero length its derivative is zero.
pub fn norm<T: Real>(a: [T; 3]) -> T {
    let square = dot(a, a);
    if square.value() > 0.0 { square.sqrt() } else { T::zero() }
}

/// `C_ibᵀ v`: a vector in inertial axes, expressed in body axes.
pub fn to_body<T: Real>(local: &Local<'_, T>, inertial: [T; 3]) -> [T; 3] {
    let c_ib = local.body.rotation;
    core::array::from_fn(|j| c_ib[0][j] * inertial[0] + c_ib[1][j] * inertial[1] + c_ib[2][j] * inertial[2])
}

/// Adds a force at the point `at_m` and a torque, both in body axes, to the wrench
/// `[moment; force]` at the body's origin.
pub fn push<T: Real>(wrench: &mut [T; 6], at_m: [f64; 3], force_n: [T; 3], torque_n_m: [T; 3]) {
    let moment = cross(constant(at_m), force_n);
    for i in 0..3 {
        wrench[i] += moment[i] + torque_n_m[i];
        wrench[i + 3] += force_n[i];
    }
}

/// Velocity of the body's centre of mass through the medium, body axes [m/s].
pub fn velocity_through_medium<T: Real>(local: &Local<'_, T>) -> [T; 3] {
    let com = constant(local.surroundings.body_com_m);
    let wind = to_body(local, constant(local.surroundings.wind_m_s));
    let velocity = add(local.body.velocity_m_s, cross(local.body.omega_rad_s, com));
    core::array::from_fn(|i| velocity[i] - wind[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_perpendicular_is_a_unit_vector_at_right_angles_and_stays_in_the_plane() {
        for k in 0..50 {
            let (azimuth, elevation) = (0.3 * f64::from(k), 0.06 * f64::from(k) - 1.5);
            let axis = direction(azimuth, elevation);
            let across = perpendicular(axis, 0.7 * f64::from(k));
            // rounding; near z the division by the short projection costs what its length says
            assert!(dot(axis, across).abs() < 1e-15, "{k}");
            assert!((dot(across, across) - 1.0).abs() < 1e-14, "{k}");
        }
        let across = perpendicular([0.6, 0.8, 0.0], 0.0);
        assert_eq!(across, [-0.8, 0.6, 0.0]);
        assert_eq!(perpendicular([0.0, 0.0, 1.0], 0.0), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_force_at_a_point_is_its_moment_and_itself_at_the_origin() {
        let mut wrench = [0.0; 6];
        push(&mut wrench, [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(wrench, [0.0, 0.0, 7.0, 0.0, 3.0, 0.0]);
    }
}
