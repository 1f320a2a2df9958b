//! A plant as its file states it: bodies, joints, tanks, appendages, actuators, sensors and
//! effects, in SI.
//!
//! One description, four uses: simulation, identification, diagnosis, and a file with the
//! estimates. Nothing here computes; `system` compiles a description into equations, `file` reads
//! and writes it.
//!
//! Frames: every vector of a body is in that body's axes; a joint's placement is in the axes of the
//! inboard body. Planar plants move in x–y and turn about z; their vectors have z = 0, their
//! inertia is about z alone.

mod appendage;
mod body;
mod channel_units;
mod control;
mod effect_use;
mod nearest;
mod parameters;
mod planar_base;
mod quantity;
mod sensor;
mod signal;
mod simulation;
mod sites;
mod tank;

pub use appendage::{Appendage, Mode};
pub use body::{Body, Joint, JointKind, Orientation};
pub use channel_units::per_second;
pub use control::{Actuator, ActuatorKind, Base, Controller, Drive, Prescribed};
pub use effect_use::{check_site, implausible, in_catalogue_order, known_parameter, unit_at};
pub use nearest::{nearest, suggestion};
pub use parameters::{Parameter, ParameterError};
pub use planar_base::BaseValue;
pub use quantity::{Quantity, Scope};
pub use sensor::{Noise, Reading, Sensor, SensorKind, Source};
pub use signal::{Signal, SignalKind};
pub use simulation::{
    Atmosphere, Environment, GravityGradient, Initial, InitialValue, Integrator, MagneticField, Segment,
    SimulationSettings,
};
pub use sites::{Site, SiteKind};
pub use tank::{Tank, TankModel};

use crate::effect::Catalogue;

/// Planar plants have three degrees of freedom a free body, spatial ones six.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Space {
    #[default]
    Planar,
    Spatial,
}

/// An effect that the plant carries: catalogue entry `kind` at `site`, its parameters by name.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectUse {
    /// Name in the catalogue, snake case.
    pub kind: String,
    pub site: Site,
    /// In the order of the catalogue entry; absent ones have the entry's default.
    pub values: Vec<(String, Quantity)>,
}

/// A whole plant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plant {
    pub name: String,
    /// What it is, for `obsid plant describe`.
    pub about: String,
    pub space: Space,
    /// The effects it may carry.
    pub catalogue: Catalogue,
    pub environment: Environment,
    /// Parents before children.
    pub bodies: Vec<Body>,
    pub tanks: Vec<Tank>,
    pub appendages: Vec<Appendage>,
    pub actuators: Vec<Actuator>,
    pub controllers: Vec<Controller>,
    pub sources: Vec<Source>,
    pub sensors: Vec<Sensor>,
    pub effects: Vec<EffectUse>,
    pub initial: Initial,
    pub segments: Vec<Segment>,
    pub simulation: SimulationSettings,
}
