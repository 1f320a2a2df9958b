//! At which sites of its kind an effect can sit.

use dynamics::description::{Actuator, ActuatorKind, Appendage, Body, JointKind, Plant, Sensor, SensorKind, Site};

/// At reaction wheels.
pub fn wheel(plant: &Plant, site: &Site) -> bool {
    actuator(plant, site).is_some_and(|actuator| matches!(actuator.kind, ActuatorKind::Wheel { .. }))
}

/// At thrusters, and at forces on a body, which are thrusters that push both ways.
pub fn thruster(plant: &Plant, site: &Site) -> bool {
    use ActuatorKind::{BodyForce, Thruster};
    actuator(plant, site).is_some_and(|actuator| matches!(actuator.kind, Thruster { .. } | BodyForce { .. }))
}

/// At bodies that a thruster pushes.
pub fn body_with_thruster(plant: &Plant, site: &Site) -> bool {
    use ActuatorKind::{BodyForce, Thruster};
    plant
        .actuators
        .iter()
        .any(|actuator| matches!(&actuator.kind, Thruster { body, .. } | BodyForce { body, .. } if *body == site.name))
}

/// A frame that falls freely, as orbits do: a plant that states a weight stands on a planet.
pub fn in_free_fall(plant: &Plant, _: &Site) -> bool {
    plant.environment.gravity_m_s2.iter().all(|gravity| gravity.value == 0.0)
}

/// At free bodies.
pub fn free_body(plant: &Plant, site: &Site) -> bool {
    body(plant, site).is_some_and(|body| body.joint.kind == JointKind::Free)
}

/// At bodies that turn, or that sit on one that does.
pub fn turning_body(plant: &Plant, site: &Site) -> bool {
    let mut at = body(plant, site);
    while let Some(body) = at {
        if matches!(body.joint.kind, JointKind::Free | JointKind::Revolute { .. }) {
            return true;
        }
        at = body.parent.as_ref().and_then(|name| plant.bodies.iter().find(|other| other.name == *name));
    }
    false
}

/// At inputs that apply a force or torque; a prescribed motion has no law of an actuator.
pub fn effort(plant: &Plant, site: &Site) -> bool {
    use ActuatorKind::{PrescribedBase, PrescribedJoint};
    actuator(plant, site).is_some_and(|a| !matches!(a.kind, PrescribedJoint { .. } | PrescribedBase { .. }))
}

/// At gyros.
pub fn gyro(plant: &Plant, site: &Site) -> bool {
    sensor(plant, site).is_some_and(|sensor| matches!(sensor.kind, SensorKind::Gyro { .. }))
}

/// At encoders.
pub fn encoder(plant: &Plant, site: &Site) -> bool {
    sensor(plant, site).is_some_and(|sensor| matches!(sensor.kind, SensorKind::Encoder { .. }))
}

/// The actuator that a site names; `None`: no such actuator.
pub fn actuator<'a>(plant: &'a Plant, site: &Site) -> Option<&'a Actuator> {
    plant.actuators.iter().find(|actuator| actuator.name == site.name)
}

/// The sensor that a site names; `None`: no such sensor.
pub fn sensor<'a>(plant: &'a Plant, site: &Site) -> Option<&'a Sensor> {
    plant.sensors.iter().find(|sensor| sensor.name == site.name)
}

/// The body that a site names; `None`: no such body.
pub fn body<'a>(plant: &'a Plant, site: &Site) -> Option<&'a Body> {
    plant.bodies.iter().find(|body| body.name == site.name)
}

/// The appendage of the mode that a site names, and the index of the mode in it.
pub fn mode<'a>(plant: &'a Plant, site: &Site) -> Option<(&'a Appendage, usize)> {
    let place = |appendage: &Appendage| appendage.modes.iter().position(|mode| mode.name == site.name);
    plant.appendages.iter().find_map(|appendage| Some((appendage, place(appendage)?)))
}

/// At the first of the sensors that one clock stamps: one site per clock.
pub fn first_of_its_clock(plant: &Plant, site: &Site) -> bool {
    let shares =
        |other: &&Sensor| other.source.is_some() && other.source == sensor(plant, site).and_then(|s| s.source.clone());
    plant.sensors.iter().find(shares).is_none_or(|first| first.name == site.name)
}
