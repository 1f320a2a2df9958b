//! Forces and torques of actuators on the hub.

use dynamics::description::{ActuatorKind, JointKind, Plant};

/// What a unit of a command does to the hub.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    pub force_n: [f64; 3],
    pub torque_nm: [f64; 3],
}

/// The body that the samples of the inertial measurement unit and of the actuators speak of: the
/// first one.
pub fn is_hub(plant: &Plant, body: &str) -> bool {
    plant.bodies.first().is_some_and(|hub| hub.name == body)
}

/// What a unit of an actuator's command does to the hub, about the origin of its axes.
pub fn wrench(plant: &Plant, kind: &ActuatorKind) -> Option<Wrench> {
    let force = |position_m: [f64; 3], direction: [f64; 3]| Wrench {
        force_n: direction,
        torque_nm: core::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            position_m[j] * direction[k] - position_m[k] * direction[j]
        }),
    };
    let torque = |direction: [f64; 3]| Wrench { torque_nm: direction, ..Wrench::default() };
    match kind {
        ActuatorKind::BodyForce { body, position_m, direction }
        | ActuatorKind::Thruster { body, position_m, direction } => {
            is_hub(plant, body).then(|| force(position_m.map(|position| position.value), *direction))
        }
        ActuatorKind::BodyTorque { body, direction } => is_hub(plant, body).then(|| torque(*direction)),
        ActuatorKind::Wheel { body, axis, .. } => is_hub(plant, body).then(|| torque(*axis)),
        // A joint between inertial space and the hub drives the hub itself.
        ActuatorKind::JointTorque { joint } => {
            let hub = plant.bodies.first().filter(|hub| hub.parent.is_none() && hub.joint.name == *joint)?;
            match hub.joint.kind {
                JointKind::Revolute { axis } => Some(torque(axis)),
                JointKind::Prismatic { axis } => Some(force([0.0; 3], axis)),
                JointKind::Free | JointKind::Fixed => None,
            }
        }
        _ => None,
    }
}
