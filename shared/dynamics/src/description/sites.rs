//! Places an effect can sit at: `joint:NAME`, `body:NAME`, `tank:NAME`, `mode:NAME`,
//! `actuator:NAME`, `sensor:NAME`.

use super::{ActuatorKind, JointKind, Plant, SensorKind};
use core::mem::{Discriminant, discriminant};

/// Kind of a site.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SiteKind {
    Joint,
    Body,
    Tank,
    Mode,
    Actuator,
    Sensor,
}

impl SiteKind {
    /// Every kind, in the order of the module's first line.
    pub const ALL: [Self; 6] = [Self::Joint, Self::Body, Self::Tank, Self::Mode, Self::Actuator, Self::Sensor];

    /// The word before the colon in the text of a site.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Joint => "joint",
            Self::Body => "body",
            Self::Tank => "tank",
            Self::Mode => "mode",
            Self::Actuator => "actuator",
            Self::Sensor => "sensor",
        }
    }
}

/// A named place in a plant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Site {
    pub kind: SiteKind,
    pub name: String,
}

impl core::fmt::Display for Site {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}:{}", self.kind.name(), self.name)
    }
}

impl core::str::FromStr for Site {
    type Err = String;

    /// # Errors
    /// The text is not `KIND:NAME` with a known kind.
    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, name) = text.split_once(':').ok_or_else(|| format!("'{text}' is not KIND:NAME"))?;
        let kind = SiteKind::ALL.into_iter().find(|candidate| candidate.name() == kind);
        let kind =
            kind.ok_or_else(|| format!("'{text}' begins with none of joint, body, tank, mode, actuator, sensor"))?;
        Ok(Self { kind, name: name.to_owned() })
    }
}

impl Plant {
    /// Every site of `kind`, in file order. Only joints with one degree of freedom are joint sites.
    pub fn sites(&self, kind: SiteKind) -> Vec<Site> {
        let site = |name: &String| Site { kind, name: name.clone() };
        let moves =
            |joint: &super::Joint| matches!(joint.kind, JointKind::Revolute { .. } | JointKind::Prismatic { .. });
        match kind {
            SiteKind::Joint => {
                self.bodies.iter().map(|body| &body.joint).filter(|j| moves(j)).map(|j| site(&j.name)).collect()
            }
            SiteKind::Body => self.bodies.iter().map(|body| site(&body.name)).collect(),
            SiteKind::Tank => self.tanks.iter().map(|tank| site(&tank.name)).collect(),
            SiteKind::Mode => self.appendages.iter().flat_map(|a| &a.modes).map(|mode| site(&mode.name)).collect(),
            SiteKind::Actuator => self.actuators.iter().map(|actuator| site(&actuator.name)).collect(),
            SiteKind::Sensor => self.sensors.iter().map(|sensor| site(&sensor.name)).collect(),
        }
    }

    /// The sites are machines of one kind: two wheels are, a wheel and a thruster are not.
    pub fn alike(&self, a: &Site, b: &Site) -> bool {
        let same = |kind: &dyn Fn(&Site) -> Option<Machine>| kind(a).is_some() && kind(a) == kind(b);
        let joint = |site: &Site| Some(Machine::Joint(discriminant(&self.joint(&site.name)?.kind)));
        let actuator = |site: &Site| Some(Machine::Actuator(discriminant(&self.actuator(&site.name)?.kind)));
        let sensor = |site: &Site| Some(Machine::Sensor(discriminant(&self.sensor(&site.name)?.kind)));
        a.kind == b.kind
            && match a.kind {
                SiteKind::Joint => same(&joint),
                SiteKind::Actuator => same(&actuator),
                SiteKind::Sensor => same(&sensor),
                SiteKind::Body | SiteKind::Tank | SiteKind::Mode => true,
            }
    }
}

/// What kind of machine stands at a site.
#[derive(PartialEq)]
enum Machine {
    Joint(Discriminant<JointKind>),
    Actuator(Discriminant<ActuatorKind>),
    Sensor(Discriminant<SensorKind>),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{Actuator, Quantity};

    #[test]
    fn two_wheels_are_alike_a_wheel_and_a_torque_are_not() {
        let body = || "hub".to_owned();
        let wheel = ActuatorKind::Wheel {
            body: body(),
            axis: [0.0, 0.0, 1.0],
            inertia_kg_m2: Quantity::known(0.01),
            viscous_friction_n_m_s_rad: Quantity::known(0.0),
            initial_speed_rad_s: Quantity::known(0.0),
        };
        let torque = ActuatorKind::BodyTorque { body: body(), direction: [0.0, 0.0, 1.0] };
        let actuator = |name: &str, kind: &ActuatorKind| Actuator {
            name: name.to_owned(),
            kind: kind.clone(),
            command: Vec::new(),
            noise: Quantity::known(0.0),
            range: None,
            recorded: true,
        };
        let actuators = vec![actuator("a", &wheel), actuator("b", &wheel), actuator("c", &torque)];
        let plant = Plant { actuators, ..Plant::default() };
        let site = |name: &str| Site { kind: SiteKind::Actuator, name: name.to_owned() };
        assert!(plant.alike(&site("a"), &site("b")));
        assert!(!plant.alike(&site("a"), &site("c")));
        assert!(!plant.alike(&site("a"), &Site { kind: SiteKind::Body, name: body() }));
    }
}
