//! The derivative of plants with uncoupled coordinates: only the effort at its joint accelerates a
//! link, and poses need not be known.

use super::System;
use super::workspace::Workspace;
use crate::effect::Pick;

impl System {
    /// 1 / inertia of every coordinate; `None` if coordinates are coupled, if an inertia depends on
    /// the pose, if a force acts on a body, and if a law needs poses.
    pub(super) fn lightness_apart(&self) -> Option<Vec<f64>> {
        let weightless = self.environment.constants.gravity_m_s2 == [0.0; 3] && !self.environment.shaken;
        let poses_needed =
            self.effects.coordinates.iter().any(|term| term.carried) || self.sensors.iter().any(|sensor| sensor.hidden);
        if !weightless || poses_needed || self.pushed || !self.layout.prescribed.is_empty() {
            return None;
        }
        Some(self.model.inertias_apart()?.iter().map(|inertia| 1.0 / inertia).collect())
    }

    /// Coordinates do not feel each other: the derivative takes no articulated bodies.
    pub fn is_apart(&self) -> bool {
        self.lightness_apart.is_some()
    }

    /// [`derivative`](Self::derivative) at this `lightness` of the coordinates.
    ///
    /// Cost: a walk over springs, actuators and effects.
    pub(super) fn derivative_apart<T: Pick>(
        &self,
        ws: &mut Workspace<T>,
        lightness: &[f64],
        (t_s, x, u): (f64, &[T], &[T]),
        x_dot: &mut [T],
    ) {
        self.layout.scatter(x, u, &mut ws.position, &mut ws.velocity);
        self.apply_actuators(ws, t_s, x, u);
        ws.tau.copy_from_slice(&ws.effort);
        self.apply_passive(ws);
        self.apply_effects(ws, t_s, x);
        let (positions, rest) = x_dot.split_at_mut(lightness.len());
        positions.copy_from_slice(&ws.velocity);
        let (rates, hidden) = rest.split_at_mut(lightness.len());
        for (rate, (effort, lightness)) in rates.iter_mut().zip(ws.tau.iter().zip(lightness)) {
            *rate = effort.scale(*lightness);
        }
        hidden.copy_from_slice(&ws.hidden_rate);
    }
}
