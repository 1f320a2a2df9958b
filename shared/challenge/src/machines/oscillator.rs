//! Mass on a spring and a damper: `m q'' = u − k q − c q'`; displacement and acceleration are read.

use crate::equations::{Equations, Matrix, Numbers, Vector};

/// Mass, spring and damper of the plant `oscillator`.
pub struct Oscillator {
    mass_kg: f64,
    stiffness_n_m: f64,
    damping_n_s_m: f64,
}

impl Oscillator {
    /// Reads the parameters of the plant file by name.
    ///
    /// # Panics
    /// A parameter is not in `numbers`.
    pub fn new(numbers: &Numbers) -> Self {
        Self {
            mass_kg: numbers.get("carriage.mass"),
            stiffness_n_m: numbers.get("rail.stiffness"),
            damping_n_s_m: numbers.get("rail.friction"),
        }
    }
}

impl Equations for Oscillator {
    fn dof(&self) -> usize {
        1
    }

    fn mass(&self, _: &Vector) -> Matrix {
        let mut mass = Matrix::identity();
        mass[(0, 0)] = self.mass_kg;
        mass
    }

    fn force(&self, q: &Vector, v: &Vector, u: &[f64]) -> Vector {
        let mut force = Vector::zeros();
        force[0] = u[0] - self.stiffness_n_m * q[0] - self.damping_n_s_m * v[0];
        force
    }

    fn read(&self, q: &Vector, _: &Vector, a: &Vector, y: &mut [f64]) {
        (y[0], y[1]) = (q[0], a[0]);
    }
}
