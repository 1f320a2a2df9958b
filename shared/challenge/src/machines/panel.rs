//! Hub on a bearing with a flexible panel, by its hub-locked modes.
//!
//! `J θ'' + Σ l_i η_i'' = u`, `l_i θ'' + η_i'' + 2 ζ_i ω_i η_i' + ω_i² η_i = 0`; a point at p with
//! shape φ_i feels `a_y = p θ'' + Σ φ_i η_i'' − θ'² Σ φ_i η_i`. A further mode has participation
//! and shapes of the last one times √ratio.

use crate::equations::{Equations, Extra, Matrix, Numbers, Vector};
use core::f64::consts::TAU;

/// Points that are read, and where they are [m].
pub const POINTS: [(&str, f64); 3] = [("a3", 2.0), ("a6", 3.5), ("a10", 5.5)];

/// Hub and hub-locked modes of the plant `hub_appendage`.
pub struct Panel {
    inertia_kg_m2: f64,
    modes: Vec<Mode>,
}

struct Mode {
    participation: f64,
    omega_rad_s: f64,
    zeta: f64,
    shape: [f64; 3],
}

impl Panel {
    /// Reads the parameters of the plant file by name; `extra.second` adds a bending mode.
    ///
    /// # Panics
    /// A parameter is not in `numbers`.
    pub fn new(numbers: &Numbers, extra: Extra) -> Self {
        let com = numbers.get("hub.com.x");
        let mode = |name: &str| Mode {
            participation: numbers.get(&format!("{name}.rotation.z")),
            omega_rad_s: TAU * numbers.get(&format!("{name}.frequency")),
            zeta: numbers.get(&format!("{name}.damping_ratio")),
            shape: POINTS.map(|(point, _)| numbers.get(&format!("{name}.shape.{point}.y"))),
        };
        let mut modes = vec![mode("bending_1"), mode("bending_2")];
        if let Some([ratio, frequency_hz, zeta]) = extra.second {
            let (root, last) = (ratio.sqrt(), mode("bending_2"));
            modes.push(Mode {
                participation: root * last.participation,
                omega_rad_s: TAU * frequency_hz,
                zeta,
                shape: last.shape.map(|phi| root * phi),
            });
        }
        Self { inertia_kg_m2: numbers.get("hub.inertia.zz") + numbers.get("hub.mass") * com * com, modes }
    }
}

impl Equations for Panel {
    fn dof(&self) -> usize {
        1 + self.modes.len()
    }

    fn mass(&self, _: &Vector) -> Matrix {
        let mut mass = Matrix::identity();
        mass[(0, 0)] = self.inertia_kg_m2;
        for (k, mode) in self.modes.iter().enumerate() {
            (mass[(0, 1 + k)], mass[(1 + k, 0)]) = (mode.participation, mode.participation);
        }
        mass
    }

    fn force(&self, q: &Vector, v: &Vector, u: &[f64]) -> Vector {
        let mut force = Vector::zeros();
        force[0] = u[0];
        for (k, mode) in self.modes.iter().enumerate() {
            let omega = mode.omega_rad_s;
            force[1 + k] = -omega * omega * q[1 + k] - 2.0 * mode.zeta * omega * v[1 + k];
        }
        force
    }

    fn read(&self, q: &Vector, v: &Vector, a: &Vector, y: &mut [f64]) {
        for (i, (_, place_m)) in POINTS.iter().enumerate() {
            let bend =
                |x: &Vector| self.modes.iter().enumerate().map(|(k, mode)| mode.shape[i] * x[1 + k]).sum::<f64>();
            y[i] = place_m * a[0] + bend(a) - v[0] * v[0] * bend(q);
        }
    }
}
