//! Planar serial chain on a free base, from the Jacobians of its bodies.
//!
//! Coordinates `q = (x, y, θ, joint angles…)`: position and attitude of the base frame in inertial
//! space, then each body's angle relative to the one before. For body i with centre of mass (CM) at
//! `p_i`,
//!
//! ```text
//! v_i = J_i q̇,   M = Σ m_i J_iᵀJ_i + I_i j_iᵀj_i,   b = Σ m_i J_iᵀ J̇_i q̇,   M q̈ + b = Q
//! ```
//!
//! (Kane's form of the equations of motion; Featherstone, Rigid Body Dynamics Algorithms, ch. 3).
//! Momentum is not used to reduce the state: it is computed, and its constancy is a test of the
//! equations.
//!
//! Assumes: rigid bodies in a plane, ideal revolute joints, no gravity. `DOF = BODIES + 2`.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use serde::{Deserialize, Serialize};

/// A rigid body of the chain, described in its own frame, whose origin is its inboard joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    pub mass_kg: f64,
    /// About the centre of mass.
    pub inertia_com_kg_m2: f64,
    /// Inboard joint (for the base: the base frame's origin) to centre of mass, body frame.
    pub com_m: [f64; 2],
    /// Inboard joint to the joint that carries the next body, body frame. Unused in the last body.
    pub outboard_joint_m: [f64; 2],
}

/// Position and velocity of the chain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion<const DOF: usize> {
    /// x, y [m], θ, joint angles [rad].
    pub q: SVector<f64, DOF>,
    /// Time derivative of `q`.
    pub q_dot: SVector<f64, DOF>,
}

/// Conserved quantities of a chain without external forces, and its kinetic energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Invariants {
    /// Of the system, inertial frame.
    pub linear_momentum_n_s: [f64; 2],
    /// Of the system about its own centre of mass.
    pub angular_momentum_com_nms: f64,
    /// Centre of mass of the system relative to the base frame's origin, inertial axes.
    pub com_from_base_m: [f64; 2],
    pub kinetic_energy_j: f64,
}

/// A serial chain; body 0 is the free base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chain<const BODIES: usize, const DOF: usize> {
    bodies: [Body; BODIES],
}

type Matrix<const DOF: usize> = SMatrix<f64, DOF, DOF>;

impl<const BODIES: usize, const DOF: usize> Chain<BODIES, DOF> {
    /// Chain of `bodies`, base first.
    pub fn new(bodies: [Body; BODIES]) -> Self {
        const { assert!(DOF == BODIES + 2) }
        for body in &bodies {
            assert!(body.mass_kg > 0.0);
            assert!(body.inertia_com_kg_m2 > 0.0);
        }
        Self { bodies }
    }

    /// Mass matrix `M(q)` and velocity term `b(q, q̇) = Σ m J ᵀ J̇ q̇`.
    ///
    /// Cost: O(BODIES · DOF²), no allocation.
    pub fn mass_and_bias(&self, motion: &Motion<DOF>) -> (Matrix<DOF>, SVector<f64, DOF>) {
        let mut mass = Matrix::<DOF>::zeros();
        let mut bias = SVector::<f64, DOF>::zeros();
        // Joint k turns bodies k.. ; "joint" 0 is the base frame's origin. All relative to that
        // origin.
        let mut joint = [[0.0; 2]; BODIES];
        let mut joint_velocity = [[0.0; 2]; BODIES];
        let (mut angle, mut rate) = (0.0, 0.0);
        for (i, body) in self.bodies.iter().enumerate() {
            angle += motion.q[2 + i];
            rate += motion.q_dot[2 + i];
            let (sin, cos) = libm::sincos(angle);
            let turn = |r: [f64; 2]| [cos * r[0] - sin * r[1], sin * r[0] + cos * r[1]];
            let offset = turn(body.com_m);
            let com = add(joint[i], offset);
            let com_velocity = add(joint_velocity[i], scale(rate, perp(offset)));

            let mut column = [[0.0; 2]; BODIES]; // of J_i, for the angles
            let mut centripetal = [0.0; 2]; // J̇_i q̇
            for k in 0..=i {
                column[k] = perp(sub(com, joint[k]));
                let column_rate = perp(sub(com_velocity, joint_velocity[k]));
                centripetal = add(centripetal, scale(motion.q_dot[2 + k], column_rate));
            }
            add_body(&mut mass, &mut bias, body, &column[..=i], centripetal);

            if i + 1 < BODIES {
                let reach = turn(body.outboard_joint_m);
                joint[i + 1] = add(joint[i], reach);
                joint_velocity[i + 1] = add(joint_velocity[i], scale(rate, perp(reach)));
            }
        }
        (mass, bias)
    }

    /// `q̈ = M⁻¹ (Q − b)` under the generalised force `Q` (force on the base, torque on the base,
    /// joint torques).
    pub fn acceleration(&self, motion: &Motion<DOF>, force: &SVector<f64, DOF>) -> SVector<f64, DOF> {
        let (mass, bias) = self.mass_and_bias(motion);
        mass.cholesky().expect("bodies have positive mass and inertia, so M > 0").solve(&(force - bias))
    }

    /// One classical Runge–Kutta step of fourth order with the generalised force held.
    pub fn advance(&self, motion: &mut Motion<DOF>, force: &SVector<f64, DOF>, step_s: f64) {
        let slope = |at: Motion<DOF>| Motion { q: at.q_dot, q_dot: self.acceleration(&at, force) };
        let from = *motion;
        let moved = |k: &Motion<DOF>, h: f64| Motion { q: from.q + k.q * h, q_dot: from.q_dot + k.q_dot * h };
        let k_1 = slope(from);
        let k_2 = slope(moved(&k_1, 0.5 * step_s));
        let k_3 = slope(moved(&k_2, 0.5 * step_s));
        let k_4 = slope(moved(&k_3, step_s));
        motion.q += (k_1.q + (k_2.q + k_3.q) * 2.0 + k_4.q) * (step_s / 6.0);
        motion.q_dot += (k_1.q_dot + (k_2.q_dot + k_3.q_dot) * 2.0 + k_4.q_dot) * (step_s / 6.0);
    }

    /// Momenta and energy of a motion.
    pub fn invariants(&self, motion: &Motion<DOF>) -> Invariants {
        let (mass, _) = self.mass_and_bias(motion);
        let momentum = mass * motion.q_dot;
        // column θ of M holds Σ m perp(r): the first moment of the system about the base frame's
        // origin
        let com = [mass[(1, 2)] / mass[(0, 0)], -mass[(0, 2)] / mass[(0, 0)]];
        Invariants {
            linear_momentum_n_s: [momentum[0], momentum[1]],
            angular_momentum_com_nms: momentum[2] - (com[0] * momentum[1] - com[1] * momentum[0]),
            com_from_base_m: com,
            kinetic_energy_j: 0.5 * motion.q_dot.dot(&momentum),
        }
    }

    /// Inertia of the system about its own centre of mass in the angles (θ, joints): the Schur
    /// complement of the translations in `M`. Angular momentum about the CM is its first row times
    /// the angle rates when the CM rests. Rows and columns 0 and 1 of the result are zero.
    pub fn inertia_about_com(&self, motion: &Motion<DOF>) -> Matrix<DOF> {
        let (mass, _) = self.mass_and_bias(motion);
        // the translation block is (total mass) · 1
        Matrix::<DOF>::from_fn(|row, column| {
            if row < 2 || column < 2 {
                return 0.0;
            }
            let coupled = mass[(row, 0)] * mass[(0, column)] + mass[(row, 1)] * mass[(1, column)];
            mass[(row, column)] - coupled / mass[(0, 0)]
        })
    }

    /// Sets the base velocity so that, with the joint rates of `motion`, linear momentum is zero
    /// and angular momentum `h_nms`.
    pub fn set_base_velocity_from_momentum(&self, motion: &mut Motion<DOF>, h_nms: f64) {
        let (mass, _) = self.mass_and_bias(motion);
        let joints = joint_part(&mass, &motion.q_dot);
        let base = solve_base_block(&mass, Vector3::new(0.0, 0.0, h_nms) - joints);
        motion.q_dot.fixed_rows_mut::<3>(0).copy_from(&base);
    }

    /// Joint torques that give the joint accelerations in `acceleration` while nothing acts on the
    /// base; its base entries are ignored on entry. Returns the generalised force, base entries
    /// zero.
    pub fn inverse_dynamics(&self, motion: &Motion<DOF>, mut acceleration: SVector<f64, DOF>) -> SVector<f64, DOF> {
        let (mass, bias) = self.mass_and_bias(motion);
        let load = joint_part(&mass, &acceleration) + bias.fixed_rows::<3>(0);
        acceleration.fixed_rows_mut::<3>(0).copy_from(&solve_base_block(&mass, -load));
        let mut force = mass * acceleration + bias;
        force.fixed_rows_mut::<3>(0).fill(0.0);
        force
    }
}

/// Adds one body to `M` and `b`; `column[k]` is the velocity of its CM per unit rate of angle k.
fn add_body<const DOF: usize>(
    mass: &mut Matrix<DOF>,
    bias: &mut SVector<f64, DOF>,
    body: &Body,
    column: &[[f64; 2]],
    centripetal: [f64; 2],
) {
    let m = body.mass_kg;
    for axis in 0..2 {
        mass[(axis, axis)] += m;
        bias[axis] += m * centripetal[axis];
    }
    for (k, c_k) in column.iter().enumerate() {
        for axis in 0..2 {
            mass[(axis, 2 + k)] += m * c_k[axis];
            mass[(2 + k, axis)] += m * c_k[axis];
        }
        for (l, c_l) in column.iter().enumerate() {
            mass[(2 + k, 2 + l)] += m * dot(*c_k, *c_l) + body.inertia_com_kg_m2;
        }
        bias[2 + k] += m * dot(*c_k, centripetal);
    }
}

/// Base rows of `M` times the joint entries of `v`.
fn joint_part<const DOF: usize>(mass: &Matrix<DOF>, v: &SVector<f64, DOF>) -> Vector3<f64> {
    let mut sum = Vector3::zeros();
    for j in 3..DOF {
        sum += mass.fixed_view::<3, 1>(0, j) * v[j];
    }
    sum
}

fn solve_base_block<const DOF: usize>(mass: &Matrix<DOF>, right_side: Vector3<f64>) -> Vector3<f64> {
    let block: Matrix3<f64> = mass.fixed_view::<3, 3>(0, 0).into_owned();
    block.cholesky().expect("a principal block of M > 0 is positive definite").solve(&right_side)
}

fn perp(r: [f64; 2]) -> [f64; 2] {
    [-r[1], r[0]]
}

fn add(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

fn sub(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn scale(s: f64, a: [f64; 2]) -> [f64; 2] {
    [s * a[0], s * a[1]]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

#[cfg(test)]
mod tests;
