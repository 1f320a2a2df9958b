//! The equations as a residual at a given acceleration: what their derivatives are made of.
//!
//! ```text
//! r(x, u, a; θ) = M a + c − τ = 0   ⇒   ∂a/∂(x, u, θ) = −M⁻¹ ∂r/∂(x, u, θ) at the found a
//! ```
//!
//! r and the readings y are linear in a, and r is a polynomial in most numbers of a plant: one
//! factorisation of `M = ∂r/∂a` serves every derivative at a point, and a difference of residuals
//! costs an inverse dynamics, not a forward one.

use super::System;
use super::workspace::Workspace;
use crate::multibody::{inverse_dynamics_after_kinematics, mass_matrix};
use core::ops::Range;
use nalgebra::DMatrix;

/// What sets a plant apart from another one of the same parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Differs {
    /// How sensors read.
    InReadings,
    /// What moves the links, too; their poses and velocities in a state are the same.
    InForces,
    /// Poses and velocities of links, too.
    InPoses,
}

impl System {
    /// Where the accelerations stand in x'; `None` where they are not those of all coordinates, or
    /// a law is more than a smooth force that follows from state and commands: it bends what acts
    /// or what is read, has states of its own, or turns or begins at an instant, where slopes taken
    /// at readings do not show it.
    pub fn accelerations(&self) -> Option<Range<usize>> {
        let layout = &self.layout;
        let forces = self.effects.are_smooth_forces() && layout.hidden == 0;
        let plain = layout.prescribed.is_empty() && layout.quaternions.is_empty() && !self.environment.shaken;
        let at = layout.q_len + layout.modes;
        (forces && plain).then_some(at..at + layout.v_len)
    }

    /// `r` (accelerations) in state `x` at the acceleration `a`.
    ///
    /// Cost: about half of a [`derivative`](Self::derivative); no allocation.
    pub fn residual(&self, ws: &mut Workspace<f64>, t_s: f64, (x, u, a): (&[f64], &[f64], &[f64]), r: &mut [f64]) {
        self.place(ws, x, u);
        self.residual_in_place(ws, t_s, (x, u, a), r);
    }

    /// [`residual`](Self::residual) in the state that `ws` was last placed in, by this system or by
    /// one that does not differ from it in poses.
    pub fn residual_in_place(
        &self,
        ws: &mut Workspace<f64>,
        t_s: f64,
        (x, u, a): (&[f64], &[f64], &[f64]),
        r: &mut [f64],
    ) {
        self.bend(ws);
        self.apply_forces(ws, t_s, x, u);
        ws.acceleration.copy_from_slice(a);
        let wrench = if self.pushed { ws.wrench.as_slice() } else { &[] };
        inverse_dynamics_after_kinematics(&self.model, &mut ws.data, &ws.velocity, &ws.acceleration, wrench, r);
        r.iter_mut().zip(&ws.tau).for_each(|(r, tau)| *r -= tau);
    }

    /// Mass matrix `∂r/∂a` (accelerations × accelerations) in state `x`; `ws` is placed nowhere
    /// behind it.
    pub fn mass(&self, ws: &mut Workspace<f64>, x: &[f64], u: &[f64], mass: &mut DMatrix<f64>) {
        self.layout.scatter(x, u, &mut ws.position, &mut ws.velocity);
        self.bend(ws);
        mass_matrix(&self.model, &mut ws.data, &ws.position[..self.layout.q_len], mass);
    }

    /// Where the velocities stand in a small change of state, and the row of the mass matrix of
    /// each.
    pub fn velocities(&self) -> (Range<usize>, &[usize]) {
        let end = self.tangent_len() - self.layout.hidden;
        (end - self.layout.velocities()..end, &self.layout.free_velocities)
    }

    /// Rates of state where `ws` was last placed, at the acceleration of its last residual.
    pub fn rates_in_place(&self, ws: &mut Workspace<f64>, x_dot: &mut [f64]) {
        self.write_rates(ws, x_dot);
    }

    /// Readings `y` behind a residual: of this plant, or of one that differs from it in readings
    /// alone.
    pub fn readings_in_place(&self, ws: &mut Workspace<f64>, t_s: f64, x: &[f64], y: &mut [f64]) {
        self.write_readings(ws, t_s, x, y);
    }

    /// What sets `other` apart; `None` where its parts are others.
    pub fn differs(&self, other: &Self) -> Option<Differs> {
        let (a, b) = (&self.layout, &other.layout);
        let same_parts = (&a.states, &a.inputs, &a.outputs) == (&b.states, &b.inputs, &b.outputs)
            && self.model.links_len() == other.model.links_len()
            && self.model.internals_len() == other.model.internals_len()
            && self.effects.are_laws_of(&other.effects);
        if !same_parts {
            return None;
        }
        if !self.model.is_posed_as(&other.model) {
            return Some(Differs::InPoses);
        }
        let acts = self.actuators.iter().zip(&other.actuators);
        let moves_alike = self.model == other.model
            && self.springs == other.springs
            && self.environment == other.environment
            && self.effects.act_as(&other.effects)
            && acts.clone().all(|(a, b)| a.acts == b.acts);
        Some(if moves_alike { Differs::InReadings } else { Differs::InForces })
    }

    /// A mean reading follows from the poses and velocities at the ends of its interval alone.
    pub fn means_are_kinematic(&self) -> bool {
        !self.sensors.iter().any(super::sensors::SensorTerm::mean_needs_dynamics)
    }
}
