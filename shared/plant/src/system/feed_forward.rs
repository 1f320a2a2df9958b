//! Inverse dynamics of the nominal plant along the references of its joints.

use super::System;
use super::workspace::Workspace;
use crate::multibody::{JointKind, Model, forward_dynamics_prescribed_after_kinematics, kinematics, mass_matrix};
use nalgebra::{SMatrix, SVector};

/// Reference of one joint at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointReference {
    /// From [`System::joint`].
    pub joint: usize,
    /// [rad] or [m], and derivatives.
    pub position: f64,
    pub rate: f64,
    pub acceleration: f64,
}

impl System {
    /// Generalised forces (one per reference, into `out`) of the nominal plant along the references of its joints.
    ///
    /// The base floats: nothing acts from outside but gravity, the centre of mass rests, the angular momentum about it is
    /// `momentum_com_n_m_s` (axes of the base). Tanks, modes and wheels are locked, joints without reference rest at zero;
    /// viscous friction and springs of the referenced joints are included, effects are not.
    ///
    /// Cost: a mass matrix and a forward dynamics, no allocation.
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
        self.float_at_momentum(ws, momentum_com_n_m_s);
        kinematics(&self.model, &mut ws.data, &ws.position[..layout.q_len], &ws.velocity);
        ws.tau.fill(0.0);
        let (data, flags) = (&mut ws.data, &self.all_but_base);
        let (tau, acceleration) = (&mut ws.tau, &mut ws.acceleration);
        forward_dynamics_prescribed_after_kinematics(&self.model, data, &ws.velocity, flags, tau, &[], acceleration);
        let drive: &mut [f64] = &mut ws.effort;
        drive.copy_from_slice(&ws.tau);
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

    /// Sets the rates of the first body so that, with all other rates as they are, linear momentum is zero and angular momentum
    /// about the centre of mass is `momentum` (axes of the base). Returns false where the first body is not free.
    pub(super) fn float_at_momentum(&self, ws: &mut Workspace<f64>, momentum: [f64; 3]) -> bool {
        let base = self.model.joint_v_len(0);
        let mut mass = core::mem::take(&mut ws.mass);
        mass_matrix(&self.model, &mut ws.data, &ws.position[..self.layout.q_len], &mut mass);
        // base rows of M v: momentum about the base's origin, which is that about the centre of mass when that rests
        let [x, y, z] = momentum;
        match base {
            3 => set_base_rates::<3>(&mass, &mut ws.velocity, [z, 0.0, 0.0]),
            6 => set_base_rates::<6>(&mass, &mut ws.velocity, [x, y, z, 0.0, 0.0, 0.0]),
            _ => {}
        }
        ws.mass = mass;
        base >= 3
    }
}

fn set_base_rates<const N: usize>(mass: &nalgebra::DMatrix<f64>, velocity: &mut [f64], momentum: [f64; N]) {
    let mut right = SVector::<f64, N>::from(momentum);
    for (j, rate) in velocity.iter().enumerate().skip(N) {
        for i in 0..N {
            right[i] -= mass[(i, j)] * rate;
        }
    }
    let block = SMatrix::<f64, N, N>::from_fn(|i, j| mass[(i, j)]);
    let rates = block.cholesky().expect("the mass matrix of a compiled model is positive definite").solve(&right);
    velocity[..N].copy_from_slice(rates.as_slice());
}

/// Everything prescribed but free joints: what a feed-forward lets go.
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
