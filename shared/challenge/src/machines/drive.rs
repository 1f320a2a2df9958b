//! Motor drive: `(J_r + J_d) q'' = K N i − b q'`; with a compliant gear rotor and disc part: q the
//! rotor, x the wind-up.
//!
//! With the gear: `T = ½ J_r q'² + ½ J_d (q' + x')²`, `V = ½ k x²`, damper
//! `2 ζ √(k J_r J_d / (J_r + J_d))`.

use crate::equations::{Equations, Extra, Matrix, Numbers, Vector};

/// Motor with rotor, gear and disc of the plant `drive_rig`; with a compliant gear two degrees of
/// freedom.
pub struct Drive {
    rotor_kg_m2: f64,
    disc_kg_m2: f64,
    friction_n_m_s: f64,
    torque_per_a: f64,
    /// Stiffness and damping of the gear.
    gear: Option<[f64; 2]>,
}

impl Drive {
    /// Reads the parameters of the plant file by name; `extra.gear` makes the gear compliant.
    ///
    /// # Panics
    /// A parameter is not in `numbers`.
    pub fn new(numbers: &Numbers, extra: Extra) -> Self {
        let (rotor, disc) = (numbers.get("drive.rotor_inertia"), numbers.get("disc.inertia.zz"));
        let gear = extra.gear.map(|[compliance, zeta]| {
            let stiffness = 1.0 / compliance;
            [stiffness, 2.0 * zeta * (stiffness * rotor * disc / (rotor + disc)).sqrt()]
        });
        Self {
            rotor_kg_m2: rotor,
            disc_kg_m2: disc,
            friction_n_m_s: numbers.get("drive.friction"),
            torque_per_a: numbers.get("motor.constant") * numbers.get("motor.gear"),
            gear,
        }
    }
}

impl Equations for Drive {
    fn dof(&self) -> usize {
        if self.gear.is_some() { 2 } else { 1 }
    }

    fn mass(&self, _: &Vector) -> Matrix {
        let mut mass = Matrix::identity();
        mass[(0, 0)] = self.rotor_kg_m2 + self.disc_kg_m2;
        if self.gear.is_some() {
            (mass[(0, 1)], mass[(1, 0)], mass[(1, 1)]) = (self.disc_kg_m2, self.disc_kg_m2, self.disc_kg_m2);
        }
        mass
    }

    fn force(&self, q: &Vector, v: &Vector, u: &[f64]) -> Vector {
        let mut force = Vector::zeros();
        force[0] = self.torque_per_a * u[0] - self.friction_n_m_s * v[0];
        if let Some([stiffness, damping]) = self.gear {
            force[1] = -stiffness * q[1] - damping * v[1];
        }
        force
    }

    fn read(&self, q: &Vector, v: &Vector, _: &Vector, y: &mut [f64]) {
        (y[0], y[1]) = (q[0], v[0]);
    }
}
