//! Disturbances of everything that moves and that no actuator drives.

use dynamics::description::{Actuator, ActuatorKind, JointKind, Plant, Quantity};

/// Prefix of the actuators that stand for disturbances.
pub const DISTURBANCE: &str = "disturbance_";

/// `plant` with an actuator for the disturbance of everything that moves and that no actuator
/// drives.
#[must_use]
pub fn equip(plant: &Plant) -> Plant {
    let mut equipped = plant.clone();
    let drives = |name: &str| {
        plant.actuators.iter().any(|actuator| match &actuator.kind {
            ActuatorKind::JointTorque { joint } | ActuatorKind::Motor { joint, .. } => joint == name,
            ActuatorKind::PrescribedJoint { joint, .. } => joint == name,
            _ => false,
        })
    };
    let pushes = |name: &str| {
        plant.actuators.iter().any(|actuator| match &actuator.kind {
            ActuatorKind::BodyForce { body, .. } | ActuatorKind::BodyTorque { body, .. } => body == name,
            ActuatorKind::Thruster { body, .. } | ActuatorKind::Wheel { body, .. } => body == name,
            _ => false,
        })
    };
    let zero = Quantity::known(0.0);
    let mut add = |name: String, kind: ActuatorKind| {
        equipped.actuators.push(Actuator {
            name: format!("{DISTURBANCE}{name}"),
            kind,
            command: Vec::new(),
            noise: zero,
            range: None,
            recorded: false,
        })
    };
    let planar = plant.space == dynamics::description::Space::Planar;
    for body in &plant.bodies {
        match body.joint.kind {
            JointKind::Revolute { .. } | JointKind::Prismatic { .. } if !drives(&body.joint.name) => {
                add(body.joint.name.clone(), ActuatorKind::JointTorque { joint: body.joint.name.clone() });
            }
            JointKind::Free if !pushes(&body.name) => {
                let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                for (k, axis) in axes.into_iter().enumerate() {
                    let letter = ["x", "y", "z"][k];
                    if !planar || k < 2 {
                        let kind = ActuatorKind::BodyForce {
                            body: body.name.clone(),
                            position_m: body.com_m,
                            direction: axis,
                        };
                        add(format!("{}_force_{letter}", body.name), kind);
                    }
                    if !planar || k == 2 {
                        let kind = ActuatorKind::BodyTorque { body: body.name.clone(), direction: axis };
                        add(format!("{}_torque_{letter}", body.name), kind);
                    }
                }
            }
            _ => {}
        }
    }
    equipped
}
