//! Inverse dynamics of the nominal plant along the references of its joints.

use super::System;
use super::workspace::Workspace;
use crate::multibody::{JointKind, Model, float_at_momentum, forward_dynamics_prescribed_after_kinematics, kinematics};

/// Reference of one joint at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointReference {
    /// From [`System::joint`].
    pub joint: usize,
    /// \[rad\] or \[m\], and derivatives.
    pub position: f64,
    pub rate: f64,
    pub acceleration: f64,
}

impl System {
    /// Generalised forces (one per reference, into `out`) of the nominal plant along the references
    /// of its joints.
    ///
    /// The base floats: only gravity acts from outside, the centre of mass rests, the angular
    /// momentum about it is `momentum_com_n_m_s` (axes of the base). Tanks, modes and wheels are
    /// locked, joints without reference rest at zero; viscous friction and springs of the
    /// referenced joints are included, effects are not.
    ///
    /// Cost: two passes over velocities and a forward dynamics, no allocation.
    pub fn feed_forward(
        &self,
        ws: &mut Workspace<f64>,
        references: &[JointReference],
        momentum_com_n_m_s: [f64; 3],
        out: &mut [f64],
    ) {
        assert!(references.len() == out.len());
        let layout = &self.layout;
        ws.position.fill(0.0);
        self.level(&mut ws.position);
        ws.velocity.fill(0.0);
        ws.acceleration.fill(0.0);
        for reference in references {
            let coordinate = self.joints[reference.joint].coordinate;
            ws.position[coordinate.position.expect("a joint has a position")] = reference.position;
            ws.velocity[coordinate.v] = reference.rate;
            ws.acceleration[coordinate.v] = reference.acceleration;
        }
        self.bend(ws);
        self.lose_added_mass(ws);
        let (data, q) = (&mut ws.data, &ws.position[..layout.q_len]);
        if !float_at_momentum(&self.model, data, q, &mut ws.velocity, momentum_com_n_m_s) {
            kinematics(&self.model, data, q, &ws.velocity);
        }
        ws.tau.fill(0.0);
        let (data, flags) = (&mut ws.data, &self.all_but_base);
        let (tau, acceleration) = (&mut ws.tau, &mut ws.acceleration);
        forward_dynamics_prescribed_after_kinematics(&self.model, data, &ws.velocity, flags, tau, &[], acceleration);
        let drive: &mut [f64] = &mut ws.effort;
        drive.copy_from_slice(&ws.tau);
        ws.tau.fill(0.0);
        self.apply_passive(ws);
        for (reference, out) in references.iter().zip(out) {
            let v = self.joints[reference.joint].coordinate.v;
            *out = ws.effort[v] - ws.tau[v];
        }
    }

    /// Quaternions of a position to no turn.
    pub(super) fn level(&self, position: &mut [f64]) {
        for link in &self.spatial_bases {
            position[self.model.q_index(*link) + 3] = 1.0;
        }
    }
}

/// Every joint is prescribed but the free ones, which a feed-forward leaves free.
pub(super) fn all_but_base(model: &Model, kinds: impl Iterator<Item = JointKind>) -> Vec<bool> {
    let mut flags = vec![true; model.v_len()];
    for (link, kind) in kinds.enumerate() {
        if matches!(kind, JointKind::FreePlanar | JointKind::FreeSpatial) {
            let first = model.v_index(link);
            flags[first..first + model.joint_v_len(link)].fill(false);
        }
    }
    flags
}
