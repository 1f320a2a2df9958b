//! Springs and viscous dampers of joints, tanks, modes and wheels: one list of coordinates.

use super::System;
use super::sites::Coordinate;
use super::workspace::Workspace;
use crate::effect::Pick;

/// Generalised force `−k (q − q₀) − d q̇`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Passive {
    pub coordinate: Coordinate,
    pub stiffness: f64,
    pub rest: f64,
    pub damping: f64,
}

impl Passive {
    /// Stiffness or damping is not zero.
    pub fn acts(&self) -> bool {
        self.stiffness != 0.0 || self.damping != 0.0
    }
}

impl System {
    /// Adds to `tau`.
    #[inline]
    pub(super) fn apply_passive<T: Pick>(&self, ws: &mut Workspace<T>) {
        for term in &self.springs {
            let v = term.coordinate.v;
            let mut force = -ws.velocity[v].scale(term.damping);
            if let (Some(q), true) = (term.coordinate.position, term.stiffness != 0.0) {
                force -= (ws.position[q] - T::constant(term.rest)).scale(term.stiffness);
            }
            ws.tau[v] += force;
        }
    }

    /// Energy of springs and modes after positions have been loaded.
    pub(super) fn spring_energy<T: Pick>(&self, ws: &Workspace<T>) -> T {
        let mut energy = T::zero();
        for term in &self.springs {
            if let Some(q) = term.coordinate.position {
                let stretch = ws.position[q] - T::constant(term.rest);
                energy += (stretch * stretch).scale(0.5 * term.stiffness);
            }
        }
        energy
    }

    /// Power that dampers take, at least zero.
    pub(super) fn damping_power<T: Pick>(&self, ws: &Workspace<T>) -> T {
        let mut power = T::zero();
        for term in &self.springs {
            let rate = ws.velocity[term.coordinate.v];
            power += (rate * rate).scale(term.damping);
        }
        power
    }
}
