//! Base with three actuators (two forces, one torque) and a two-link arm: eight parameters, all
//! linear, mass among them (BP1B).
//!
//! Reference point **B** fixed in the base (where the accelerometer sits), joint 1 at `a` from B
//! and link length `L1` known geometry, the base's centre of mass `c0` from B unknown:
//!
//! `π = [M, m0 c0x + (m1+m2) ax, m0 c0y + (m1+m2) ay, I0 + m0|c0|² + (m1+m2)|a|², m1 l1 + m2 L1, I1 + m1 l1² + m2 L1², m2 l2, I2 + m2 l2²]`
//!
//! Rows (force x, force y, torque about B, τ1, τ2), page 1, section 4. Not identifiable: how the
//! masses divide.
//!
//! Frames: everything in the axes of the base; `a_B` is the inertial acceleration of B along them,
//! **not** the rate of change of its velocity's components (they differ by `w0 × v`). Units: SI.
//! Assumes the centres of mass of the links on their axes.

use crate::free_floating::PlanarArm;
use libm::sincos;
use nalgebra::{SMatrix, SVector, Vector2};
use serde::{Deserialize, Serialize};

/// `π` of the module's head.
pub type Pi = SVector<f64, 8>;

/// (force x, force y, torque about B, τ1, τ2), or the accelerations (a_Bx, a_By, w0dot, th1dd,
/// th2dd).
pub type Five = SVector<f64, 5>;

/// What is known of the arm before it moves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlyingGeometry {
    /// B to joint 1, base axes.
    pub joint_from_reference_m: [f64; 2],
    /// Joint 1 to joint 2.
    pub link_1_length_m: f64,
}

/// Motion of base and arm at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlyingMotion {
    /// Inertial acceleration of B, base axes.
    pub acceleration_m_s2: [f64; 2],
    pub joint_angle_rad: [f64; 2],
    /// (w0, d1, d2).
    pub rates_rad_s: [f64; 3],
    /// (w0dot, th1dd, th2dd).
    pub accelerations_rad_s2: [f64; 3],
}

/// Dynamic equation in integrable form: `wrench = d/dt(momentum π) + remainder π`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MomentumForm {
    pub momentum: SMatrix<f64, 5, 8>,
    pub remainder: SMatrix<f64, 5, 8>,
}

impl FlyingGeometry {
    /// Geometry of an arm whose base has its centre of mass at `base_com_m` from B.
    pub fn of(arm: &PlanarArm, base_com_m: [f64; 2]) -> Self {
        let ([cx, cy], [rx, ry]) = (base_com_m, arm.base_to_joint_m);
        Self { joint_from_reference_m: [cx + rx, cy + ry], link_1_length_m: arm.joint_to_com_m[0] + arm.com_to_next_m }
    }
}

/// `π` of an arm whose base has its centre of mass at `base_com_m` from B.
pub fn parameters(arm: &PlanarArm, base_com_m: [f64; 2]) -> Pi {
    let ([m0, m1, m2], [i0, i1, i2], [l1, l2]) = (arm.mass_kg, arm.inertia_com_kg_m2, arm.joint_to_com_m);
    let FlyingGeometry { joint_from_reference_m: [ax, ay], link_1_length_m: big_l1 } =
        FlyingGeometry::of(arm, base_com_m);
    let [cx, cy] = base_com_m;
    let carried = m1 + m2;
    SVector::from([
        m0 + carried,
        m0 * cx + carried * ax,
        m0 * cy + carried * ay,
        i0 + m0 * (cx * cx + cy * cy) + carried * (ax * ax + ay * ay),
        m1 * l1 + m2 * big_l1,
        i1 + m1 * l1 * l1 + m2 * big_l1 * big_l1,
        m2 * l2,
        i2 + m2 * l2 * l2,
    ])
}

/// Directions and couplings of a posture.
struct Posture {
    /// Along link 1 and link 2, base axes.
    e1: Vector2<f64>,
    e2: Vector2<f64>,
    /// `g = a · e`, `k = dg/dangle`.
    g1: f64,
    k1: f64,
    g2: f64,
    k2: f64,
    /// `L1 cos th2`, `L1 sin th2`.
    c: f64,
    s: f64,
}

impl Posture {
    fn new(geometry: &FlyingGeometry, joint_angle_rad: [f64; 2]) -> Self {
        let ((s1, c1), (s2, c2)) = (sincos(joint_angle_rad[0]), sincos(joint_angle_rad[1]));
        let (e1, e2) = (Vector2::new(c1, s1), Vector2::new(c1 * c2 - s1 * s2, s1 * c2 + c1 * s2));
        let (a, l) = (Vector2::from(geometry.joint_from_reference_m), geometry.link_1_length_m);
        let (k1, k2) = (a.dot(&across(e1)), a.dot(&across(e2)));
        Self { e1, e2, g1: a.dot(&e1), k1, g2: a.dot(&e2), k2, c: l * c2, s: l * s2 }
    }
}

/// A quarter turn about z.
fn across(v: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-v.y, v.x)
}

/// Columns that bodies 0, 1, 2 bring to (force; E0, E1, E2), as rows (force; E0 + E1 + E2; E1 + E2;
/// E2).
fn rows(columns: [([f64; 2], [f64; 3]); 8]) -> SMatrix<f64, 5, 8> {
    SMatrix::from_fn(|row, column| {
        let (force, moments) = &columns[column];
        if row < 2 { force[row] } else { moments[row - 2..].iter().sum() }
    })
}

/// `Y` (5 × 8) with `Y π = (force x, force y, torque about B, τ1, τ2)` (page 1, section 4).
///
/// With `b_i` the inertial angular accelerations and `w_i` the rates of base and links,
/// `s = (π2, π3)`, `e1`, `e2` along the links:
/// `F = π1 a_B + b0 s⊥ − w0² s + π5 (b1 e1⊥ − w1² e1) + π7 (b2 e2⊥ − w2² e2)`, and so on as printed
/// there.
pub fn wrench_regressor(geometry: &FlyingGeometry, motion: &FlyingMotion) -> SMatrix<f64, 5, 8> {
    let Posture { e1, e2, g1, k1, g2, k2, c, s } = Posture::new(geometry, motion.joint_angle_rad);
    let ([w0, d1, d2], [b0, dd1, dd2]) = (motion.rates_rad_s, motion.accelerations_rad_s2);
    let (w1, b1) = (w0 + d1, b0 + dd1);
    let (w2, b2) = (w1 + d2, b1 + dd2);
    let (q0, q1, q2) = (w0 * w0, w1 * w1, w2 * w2);
    let a = Vector2::from(motion.acceleration_m_s2);
    let turned = |e: Vector2<f64>, b: f64, q: f64| (across(e) * b - e * q).into();
    rows([
        (a.into(), [0.0; 3]),
        ([-q0, b0], [a.y, 0.0, 0.0]),
        ([-b0, -q0], [-a.x, 0.0, 0.0]),
        ([0.0; 2], [b0, 0.0, 0.0]),
        (turned(e1, b1, q1), [g1 * b1 + k1 * q1, e1.perp(&a) + g1 * b0 - k1 * q0, 0.0]),
        ([0.0; 2], [0.0, b1, 0.0]),
        (turned(e2, b2, q2), [g2 * b2 + k2 * q2, c * b2 - s * q2, e2.perp(&a) + g2 * b0 - k2 * q0 + c * b1 + s * q1]),
        ([0.0; 2], [0.0, 0.0, b2]),
    ])
}

/// The same rows integrated by parts, for wrenches that are integrated: no angular acceleration is
/// needed (page 1, section 4).
///
/// `motion.accelerations_rad_s2` is not read.
pub fn momentum_form(geometry: &FlyingGeometry, motion: &FlyingMotion) -> MomentumForm {
    let Posture { e1, e2, g1, k1, g2, k2, c, s } = Posture::new(geometry, motion.joint_angle_rad);
    let [w0, d1, d2] = motion.rates_rad_s;
    let (w1, w2) = (w0 + d1, w0 + d1 + d2);
    let a = Vector2::from(motion.acceleration_m_s2);
    let swung = |e: Vector2<f64>, w: f64| -> [f64; 2] { (across(e) * w).into() };
    // w0 × v, v the velocity column above
    let carried = |e: Vector2<f64>, w: f64| -> [f64; 2] { (e * (-w0 * w)).into() };
    let momentum = rows([
        ([0.0; 2], [0.0; 3]),
        ([0.0, w0], [0.0; 3]),
        ([-w0, 0.0], [0.0; 3]),
        ([0.0; 2], [w0, 0.0, 0.0]),
        (swung(e1, w1), [g1 * w1, g1 * w0, 0.0]),
        ([0.0; 2], [0.0, w1, 0.0]),
        (swung(e2, w2), [g2 * w2, c * w2, g2 * w0 + c * w1]),
        ([0.0; 2], [0.0, 0.0, w2]),
    ]);
    let remainder = rows([
        (a.into(), [0.0; 3]),
        ([-w0 * w0, 0.0], [a.y, 0.0, 0.0]),
        ([0.0, -w0 * w0], [-a.x, 0.0, 0.0]),
        ([0.0; 2], [0.0; 3]),
        (carried(e1, w1), [k1 * w0 * w1, e1.perp(&a) - k1 * w0 * w1, 0.0]),
        ([0.0; 2], [0.0; 3]),
        (carried(e2, w2), [k2 * w0 * w2, -s * w1 * w2, e2.perp(&a) - k2 * w0 * w2 + s * w1 * w2]),
        ([0.0; 2], [0.0; 3]),
    ]);
    MomentumForm { momentum, remainder }
}

/// Mass matrix `H` for (a_Bx, a_By, w0dot, th1dd, th2dd) and vector `C` of `H q̈ + C = wrench`.
///
/// Written in absolute rates, where the kinetic energy is a plain quadratic form, and carried to
/// relative ones by `(b0, b1, b2) = T (w0dot, th1dd, th2dd)`.
pub fn dynamics(
    geometry: &FlyingGeometry,
    pi: &Pi,
    joint_angle_rad: [f64; 2],
    rates_rad_s: [f64; 3],
) -> (SMatrix<f64, 5, 5>, Five) {
    let Posture { e1, e2, g1, k1, g2, k2, c, s } = Posture::new(geometry, joint_angle_rad);
    let [p1, p2, p3, p4, p5, p6, p7, p8] = pi.data.0[0];
    let (first, n1, n2) = (across(Vector2::new(p2, p3)), across(e1) * p5, across(e2) * p7);
    let absolute = SMatrix::<f64, 5, 5>::from([
        [p1, 0.0, first.x, n1.x, n2.x],
        [0.0, p1, first.y, n1.y, n2.y],
        [first.x, first.y, p4, p5 * g1, p7 * g2],
        [n1.x, n1.y, p5 * g1, p6, p7 * c],
        [n2.x, n2.y, p7 * g2, p7 * c, p8],
    ]);
    let mut relative = SMatrix::<f64, 5, 5>::identity();
    (relative[(3, 2)], relative[(4, 2)], relative[(4, 3)]) = (1.0, 1.0, 1.0);
    let [w0, d1, d2] = rates_rad_s;
    let (q0, q1, q2) = (w0 * w0, (w0 + d1) * (w0 + d1), (w0 + d1 + d2) * (w0 + d1 + d2));
    let force = -(Vector2::new(p2, p3) * q0 + e1 * (p5 * q1) + e2 * (p7 * q2));
    let bias = Five::from([
        force.x,
        force.y,
        p5 * k1 * q1 + p7 * k2 * q2,
        -p5 * k1 * q0 - p7 * s * q2,
        p7 * (s * q1 - k2 * q0),
    ]);
    (relative.transpose() * absolute * relative, relative.transpose() * bias)
}

/// (a_Bx, a_By, w0dot, th1dd, th2dd) under (force x, force y, torque about B, τ1, τ2); `None` when
/// the parameters are not physical.
pub fn accelerations(
    geometry: &FlyingGeometry,
    pi: &Pi,
    joint_angle_rad: [f64; 2],
    rates_rad_s: [f64; 3],
    wrench: &Five,
) -> Option<Five> {
    let (mass, bias) = dynamics(geometry, pi, joint_angle_rad, rates_rad_s);
    Some(mass.cholesky()?.solve(&(wrench - bias)))
}

#[cfg(test)]
mod tests;
