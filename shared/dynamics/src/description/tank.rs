//! Sloshing propellant: a mass on springs and dampers, or a pendulum.

use super::{Quantity, Space};
use nalgebra::Vector3;

/// Equivalent mechanical model of the first slosh mode.
#[derive(Clone, Debug, PartialEq)]
pub enum TankModel {
    /// Slosh mass free along each of 1 to 3 unit vectors of the body.
    Spring {
        axes: Vec<[f64; 3]>,
        /// Per axis [N/m].
        stiffness_n_m: Vec<Quantity>,
        /// Per axis [N s/m].
        damping_n_s_m: Vec<Quantity>,
    },
    /// Slosh mass on a rod: in the plane, or on a universal joint in space. Hangs along `rest` from
    /// the pivot.
    Pendulum {
        rest: [f64; 3],
        length_m: Quantity,
        /// [N m s/rad].
        damping_n_m_s_rad: Quantity,
    },
}

/// One slosh mass; a tank with two modes is two entries.
#[derive(Clone, Debug, PartialEq)]
pub struct Tank {
    pub name: String,
    pub body: String,
    /// Rest position of the mass (spring), or the pivot (pendulum) \[m\].
    pub position_m: [Quantity; 3],
    pub mass_kg: Quantity,
    pub model: TankModel,
}

impl Tank {
    /// Unit vector across all slosh axes, body axes: z × axis in the plane, axis 1 × axis 2 in
    /// space. A pendulum in the place of the springs hangs along it.
    ///
    /// # Errors
    /// The tank has a pendulum, another number of axes, or springs that are not alike.
    pub fn axial(&self, space: Space) -> Result<[f64; 3], String> {
        let TankModel::Spring { axes, stiffness_n_m, damping_n_s_m } = &self.model else {
            return Err(format!("{} is a pendulum already", self.name));
        };
        match (space, axes.as_slice()) {
            (Space::Planar, [axis]) => Ok([-axis[1], axis[0], 0.0]),
            (Space::Spatial, [first, second]) => {
                let equal = |list: &[Quantity]| list.iter().all(|quantity| quantity.value == list[0].value);
                let [first, second] = [first, second].map(|axis| Vector3::from(*axis));
                // axes are stated with some ten digits
                if first.dot(&second).abs() > 1e-9 || !equal(stiffness_n_m) || !equal(damping_n_s_m) {
                    return Err(format!("{} is not alike along its axes; a pendulum is", self.name));
                }
                Ok(first.cross(&second).normalize().into())
            }
            _ => Err(format!(
                "{} has {} slosh axes; a pendulum has one in the plane, two in space",
                self.name,
                axes.len()
            )),
        }
    }
}
