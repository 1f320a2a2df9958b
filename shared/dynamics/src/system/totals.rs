//! Momentum and energy of the whole plant.

use super::System;
use super::geometry::times;
use super::workspace::Workspace;
use crate::effect::Pick;
use crate::multibody::{kinetic_energy, momentum, potential_energy};

/// Quantities of conservation laws. Effects have no share in masses and energies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals<T> {
    pub mass_kg: f64,
    /// Of the frame of the base, inertial axes \[m\], [m/s].
    pub com_m: [T; 3],
    pub com_velocity_m_s: [T; 3],
    /// Inertial axes.
    pub linear_momentum_n_s: [T; 3],
    pub angular_momentum_com_n_m_s: [T; 3],
    pub angular_momentum_origin_n_m_s: [T; 3],
    pub kinetic_energy_j: T,
    /// Gravity, springs, modes.
    pub potential_energy_j: T,
    /// Power that viscous friction of joints, tanks, modes and wheels takes \[W\].
    pub dissipated_w: T,
}

impl System {
    /// Momentum and energy at a state.
    pub fn totals<T: Pick>(&self, ws: &mut Workspace<T>, x: &[T], u: &[T]) -> Totals<T> {
        self.place(ws, x, u);
        self.lose_added_mass(ws);
        let (model, q) = (&self.model, &ws.position[..self.layout.q_len]);
        let found = momentum(model, &mut ws.data, q, &ws.velocity);
        let kinetic_energy_j = kinetic_energy(model, &mut ws.data, q, &ws.velocity);
        let weight = potential_energy(model, &mut ws.data, q, &ws.velocity);
        Totals {
            mass_kg: found.mass,
            com_m: found.com,
            com_velocity_m_s: times(found.linear, T::constant(1.0 / found.mass)),
            linear_momentum_n_s: found.linear,
            angular_momentum_com_n_m_s: found.angular_about_com,
            angular_momentum_origin_n_m_s: found.angular_about_origin,
            kinetic_energy_j,
            potential_energy_j: weight + self.spring_energy(ws),
            dissipated_w: self.damping_power(ws),
        }
    }
}
