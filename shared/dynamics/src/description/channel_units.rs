//! SI units of inputs, channels and sites: the `unit of the input` of each kind.

use super::{
    Actuator, ActuatorKind, Body, Drive, Joint, JointKind, Plant, Prescribed, Sensor, SensorKind, Site, SiteKind,
};
use super::{Tank, TankModel};

impl Joint {
    /// Moves along its axis.
    pub const fn is_prismatic(&self) -> bool {
        matches!(self.kind, JointKind::Prismatic { .. })
    }

    /// Unit of its coordinate.
    pub const fn unit(&self) -> &'static str {
        if self.is_prismatic() { "m" } else { "rad" }
    }

    /// Unit of its input.
    pub const fn effort_unit(&self) -> &'static str {
        if self.is_prismatic() { "N" } else { "N*m" }
    }
}

impl Tank {
    /// Unit of its coordinates.
    pub const fn unit(&self) -> &'static str {
        match self.model {
            TankModel::Spring { .. } => "m",
            TankModel::Pendulum { .. } => "rad",
        }
    }
}

impl Plant {
    /// The body called `name`.
    pub fn body(&self, name: &str) -> Option<&Body> {
        self.bodies.iter().find(|body| body.name == name)
    }

    /// The joint called `name`, whichever body it carries.
    pub fn joint(&self, name: &str) -> Option<&Joint> {
        self.bodies.iter().map(|body| &body.joint).find(|joint| joint.name == name)
    }

    /// The actuator called `name`.
    pub fn actuator(&self, name: &str) -> Option<&Actuator> {
        self.actuators.iter().find(|actuator| actuator.name == name)
    }

    /// The sensor called `name`.
    pub fn sensor(&self, name: &str) -> Option<&Sensor> {
        self.sensors.iter().find(|sensor| sensor.name == name)
    }

    /// SI unit of an input's command, noise and range. An unknown joint counts as revolute.
    pub fn actuator_unit(&self, actuator: &Actuator) -> &'static str {
        let joint = |name: &str| self.joint(name);
        match &actuator.kind {
            ActuatorKind::JointTorque { joint: name } => joint(name).map_or("N*m", Joint::effort_unit),
            ActuatorKind::BodyForce { .. } | ActuatorKind::Thruster { .. } => "N",
            ActuatorKind::BodyTorque { .. } | ActuatorKind::Wheel { .. } => "N*m",
            ActuatorKind::Motor { drive: Drive::Current, .. } => "A",
            ActuatorKind::Motor { drive: Drive::Voltage { .. }, .. } => "V",
            ActuatorKind::PrescribedJoint { joint: name, what } => {
                derivative(joint(name).is_some_and(Joint::is_prismatic), *what)
            }
            ActuatorKind::PrescribedBase { what, .. } => derivative(true, *what),
        }
    }

    /// SI unit of a channel.
    pub fn sensor_unit(&self, sensor: &Sensor) -> &'static str {
        let linear = |name: &str| self.joint(name).is_some_and(Joint::is_prismatic);
        match &sensor.kind {
            SensorKind::Gyro { .. } | SensorKind::WheelSpeed { .. } => "rad/s",
            SensorKind::Accelerometer { .. } => "m/s^2",
            SensorKind::Encoder { joint } => derivative(linear(joint), Prescribed::Position),
            SensorKind::JointRate { joint } => derivative(linear(joint), Prescribed::Rate),
            SensorKind::JointTorque { joint } => self.joint(joint).map_or("N*m", Joint::effort_unit),
            SensorKind::Force { .. } => "N",
            SensorKind::Torque { .. } => "N*m",
            SensorKind::Position { .. } => "m",
            SensorKind::Velocity { .. } => "m/s",
            SensorKind::Attitude { .. } => "rad",
        }
    }

    /// SI unit of a site: of its coordinate, its input, its channel; none at a body.
    pub fn site_unit(&self, site: &Site) -> &'static str {
        match site.kind {
            SiteKind::Joint => self.joint(&site.name).map_or("rad", Joint::unit),
            SiteKind::Body => "1",
            SiteKind::Tank => self.tanks.iter().find(|tank| tank.name == site.name).map_or("m", Tank::unit),
            SiteKind::Mode => "sqrt(kg)*m",
            SiteKind::Actuator => self.actuator(&site.name).map_or("N*m", |actuator| self.actuator_unit(actuator)),
            SiteKind::Sensor => self.sensor(&site.name).map_or("1", |sensor| self.sensor_unit(sensor)),
        }
    }
}

const fn derivative(linear: bool, what: Prescribed) -> &'static str {
    match (linear, what) {
        (false, Prescribed::Position) => "rad",
        (false, Prescribed::Rate) => "rad/s",
        (false, Prescribed::Acceleration) => "rad/s^2",
        (true, Prescribed::Position) => "m",
        (true, Prescribed::Rate) => "m/s",
        (true, Prescribed::Acceleration) => "m/s^2",
    }
}

/// Unit of the derivative.
pub fn per_second(unit: &str) -> String {
    match unit {
        "rad/s" => "rad/s^2".to_owned(),
        "m/s" => "m/s^2".to_owned(),
        _ => format!("{unit}/s"),
    }
}
