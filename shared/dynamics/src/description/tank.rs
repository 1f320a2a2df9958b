//! Sloshing propellant: a mass on springs and dampers, or a pendulum.

use super::Quantity;

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
