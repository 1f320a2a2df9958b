//! Rigid pendulum: `(I + m |c|²) q'' = −m g (c_x sin q + c_y cos q) − b q'`, q from where the bar's
//! x axis hangs.

use crate::equations::{Equations, Matrix, Numbers, Vector};

const GRAVITY_M_S2: f64 = 9.81;

/// Rigid bar on a pivot of the plant `pendulum`.
pub struct Pendulum {
    mass_kg: f64,
    com_m: [f64; 2],
    inertia_kg_m2: f64,
    friction_n_m_s: f64,
}

impl Pendulum {
    /// Reads the parameters of the plant file by name.
    ///
    /// # Panics
    /// A parameter is not in `numbers`.
    pub fn new(numbers: &Numbers) -> Self {
        Self {
            mass_kg: numbers.get("bar.mass"),
            com_m: [numbers.get("bar.com.x"), numbers.get("bar.com.y")],
            inertia_kg_m2: numbers.get("bar.inertia.zz"),
            friction_n_m_s: numbers.get("pivot.friction"),
        }
    }
}

impl Equations for Pendulum {
    fn dof(&self) -> usize {
        1
    }

    fn mass(&self, _: &Vector) -> Matrix {
        let mut mass = Matrix::identity();
        let [x, y] = self.com_m;
        mass[(0, 0)] = self.inertia_kg_m2 + self.mass_kg * (x * x + y * y);
        mass
    }

    fn force(&self, q: &Vector, v: &Vector, _: &[f64]) -> Vector {
        let [x, y] = self.com_m;
        let mut force = Vector::zeros();
        let arm = x * libm::sin(q[0]) + y * libm::cos(q[0]);
        force[0] = -self.mass_kg * GRAVITY_M_S2 * arm - self.friction_n_m_s * v[0];
        force
    }

    fn read(&self, q: &Vector, _: &Vector, _: &Vector, y: &mut [f64]) {
        y[0] = q[0];
    }
}
