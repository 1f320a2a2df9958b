//! Double pendulum, the second angle relative to the first bar.
//!
//! In absolute angles `θ1 = q1, θ2 = q1 + q2`, with `A11 = I1 + m1 |c1|² + m2 l²`,
//! `A22 = I2 + m2 |c2|²`, `A12 = m2 l (c2x cos q2 − c2y sin q2)`, `B = dA12/dq2`:
//! `A11 θ1'' + A12 θ2'' = −B θ2'² − ∂V/∂θ1`, `A12 θ1'' + A22 θ2'' = B θ1'² − ∂V/∂θ2`; then
//! `Tᵀ A T`, `Tᵀ f` to relative angles.

use crate::equations::{Equations, Matrix, Numbers, Vector};

const GRAVITY_M_S2: f64 = 9.81;

/// Two bars in a vertical plane; masses, centres of mass, inertias and friction of the plant
/// `double_pendulum`.
pub struct DoublePendulum {
    mass_kg: [f64; 2],
    com_m: [[f64; 2]; 2],
    inertia_kg_m2: [f64; 2],
    length_m: f64,
    friction_n_m_s: [f64; 2],
}

impl DoublePendulum {
    /// Reads the parameters of the plant file by name.
    ///
    /// # Panics
    /// A parameter is not in `numbers`.
    pub fn new(numbers: &Numbers) -> Self {
        let bars = ["upper", "lower"];
        Self {
            mass_kg: bars.map(|bar| numbers.get(&format!("{bar}.mass"))),
            com_m: bars.map(|bar| ["x", "y"].map(|axis| numbers.get(&format!("{bar}.com.{axis}")))),
            inertia_kg_m2: bars.map(|bar| numbers.get(&format!("{bar}.inertia.zz"))),
            length_m: numbers.get("pivot_2.position.x"),
            friction_n_m_s: ["pivot_1.friction", "pivot_2.friction"].map(|name| numbers.get(name)),
        }
    }

    /// A11, A22, A12 and B.
    fn inertias(&self, q2: f64) -> [f64; 4] {
        let [[x1, y1], [x2, y2]] = self.com_m;
        let ([m1, m2], [i1, i2], l) = (self.mass_kg, self.inertia_kg_m2, self.length_m);
        let (sin, cos) = (libm::sin(q2), libm::cos(q2));
        let coupling = m2 * l * (x2 * cos - y2 * sin);
        let turn = -m2 * l * (x2 * sin + y2 * cos);
        [i1 + m1 * (x1 * x1 + y1 * y1) + m2 * l * l, i2 + m2 * (x2 * x2 + y2 * y2), coupling, turn]
    }
}

impl Equations for DoublePendulum {
    fn dof(&self) -> usize {
        2
    }

    fn mass(&self, q: &Vector) -> Matrix {
        let [a11, a22, a12, _] = self.inertias(q[1]);
        let mut mass = Matrix::identity();
        mass[(0, 0)] = a11 + 2.0 * a12 + a22;
        (mass[(0, 1)], mass[(1, 0)], mass[(1, 1)]) = (a12 + a22, a12 + a22, a22);
        mass
    }

    fn force(&self, q: &Vector, v: &Vector, _: &[f64]) -> Vector {
        let [_, _, _, turn] = self.inertias(q[1]);
        let [[x1, y1], [x2, y2]] = self.com_m;
        let ([m1, m2], l) = (self.mass_kg, self.length_m);
        let (one, two) = (q[0], q[0] + q[1]);
        let (w1, w2) = (v[0], v[0] + v[1]);
        let weight_1 = GRAVITY_M_S2 * (m1 * (x1 * libm::sin(one) + y1 * libm::cos(one)) + m2 * l * libm::sin(one));
        let weight_2 = GRAVITY_M_S2 * m2 * (x2 * libm::sin(two) + y2 * libm::cos(two));
        let (f1, f2) = (-turn * w2 * w2 - weight_1, turn * w1 * w1 - weight_2);
        let mut force = Vector::zeros();
        force[0] = f1 + f2 - self.friction_n_m_s[0] * v[0];
        force[1] = f2 - self.friction_n_m_s[1] * v[1];
        force
    }

    fn read(&self, q: &Vector, _: &Vector, _: &Vector, y: &mut [f64]) {
        (y[0], y[1]) = (q[0], q[1]);
    }
}
