//! True minimal inertial parameters of a free-floating base with an arm of two links: what BP1 is
//! to find, read off the plant.
//!
//! About the centre of mass of the whole and in the absolute rates of base and links the inertia is
//!
//! ```text
//! D11 = a1,  D22 = a2,  D33 = a3,  D12 = a4 cos θ1 + a5 sin θ1,  D13 = a6 cos(θ1+θ2) + a7 sin(θ1+θ2),  D23 = a8 cos θ2 + a9 sin θ2
//! ```
//!
//! Each coefficient is read off the mass matrix of the bodies at a posture where its partner
//! vanishes, not computed from a formula for it: the estimators have such formulas. Without a body
//! beside the axis of link 2, a9 = 0 and eight parameters remain.

use core::f64::consts::FRAC_PI_2;
use dynamics::description::{JointKind, Plant, Space};
use dynamics::multibody::{Data, Model, mass_matrix};
use dynamics::system::System;
use nalgebra::{DMatrix, Matrix3};

/// Coordinates of a planar floating base and two joints.
const DOF: usize = 5;

/// a1..a9 [kg m²] of the arm that is simulated, effects on its masses included.
///
/// `None`: the plant is no planar free base with two revolute joints in a row, whatever is fixed to
/// its bodies; or has tanks or appendages, for which nine numbers are not enough. Rotors of motors
/// are no part of the bodies' momentum.
///
/// Cost: compiles the plant, three mass matrices.
pub fn minimal_parameters(plant: &Plant) -> Option<[f64; 9]> {
    if !is_floating_arm(plant) {
        return None;
    }
    let mut bodies = plant.clone();
    bodies.bodies.iter_mut().for_each(|body| body.joint.rotor_inertia.value = 0.0);
    let system = System::new(&bodies).ok().filter(|system| system.model().v_len() == DOF).or_else(|| {
        // an effect has added a coordinate: the parameters are those of the arm without it
        bodies.effects.clear();
        System::new(&bodies).ok()
    })?;
    let at = |joint_1_rad: f64, joint_2_rad: f64| absolute_rate_inertia(system.model(), joint_1_rad, joint_2_rad);
    let (stretched, joint_1_square, joint_2_square) = (at(0.0, 0.0), at(FRAC_PI_2, 0.0), at(0.0, FRAC_PI_2));
    Some([
        stretched[(0, 0)],
        stretched[(1, 1)],
        stretched[(2, 2)],
        stretched[(0, 1)],
        joint_1_square[(0, 1)],
        stretched[(0, 2)],
        joint_1_square[(0, 2)],
        stretched[(1, 2)],
        joint_2_square[(1, 2)],
    ])
}

fn is_floating_arm(plant: &Plant) -> bool {
    let Some((base, others)) = plant.bodies.split_first() else { return false };
    let moving: Vec<_> = others.iter().filter(|body| body.joint.kind != JointKind::Fixed).collect();
    let [link_1, link_2] = moving[..] else { return false };
    let turns = |kind: JointKind| matches!(kind, JointKind::Revolute { axis: [0.0, 0.0, 1.0] });
    plant.space == Space::Planar
        && base.joint.kind == JointKind::Free
        && turns(link_1.joint.kind)
        && turns(link_2.joint.kind)
        && is_carried_by(plant, link_2.parent.as_deref(), &link_1.name)
        && plant.tanks.is_empty()
        && plant.appendages.is_empty()
}

/// Whether `body` is `carrier`, or fixed to it through others.
fn is_carried_by(plant: &Plant, body: Option<&str>, carrier: &str) -> bool {
    let mut above = body;
    // parents come first, so a chain is no longer than the list
    for _ in 0..plant.bodies.len() {
        if above == Some(carrier) {
            return true;
        }
        let here = above.and_then(|name| plant.bodies.iter().find(|candidate| candidate.name == name));
        above = here.filter(|here| here.joint.kind == JointKind::Fixed).and_then(|here| here.parent.as_deref());
    }
    false
}

/// Inertia about the centre of mass of the whole in the absolute rates of the bodies at one
/// posture.
fn absolute_rate_inertia(model: &Model, joint_1_rad: f64, joint_2_rad: f64) -> Matrix3<f64> {
    let mut mass = DMatrix::zeros(DOF, DOF);
    mass_matrix(model, &mut Data::new(model), &[0.0, 0.0, 0.0, joint_1_rad, joint_2_rad], &mut mass);
    // rates are (ω, v_x, v_y, joints); the translations carry (total mass) · 1 and drop out with
    // the centre of mass at rest
    const TURNS: [usize; 3] = [0, 3, 4];
    let relative = Matrix3::from_fn(|row, column| {
        let (i, j) = (TURNS[row], TURNS[column]);
        mass[(i, j)] - (mass[(i, 1)] * mass[(1, j)] + mass[(i, 2)] * mass[(2, j)]) / mass[(1, 1)]
    });
    // relative rates = T · absolute rates
    let t = Matrix3::new(1.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0, -1.0, 1.0);
    t.transpose() * relative * t
}

#[cfg(test)]
mod tests;
