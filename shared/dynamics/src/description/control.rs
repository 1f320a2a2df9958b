//! Inputs: actuators with their commands, prescribed motions, and the controllers that close a
//! loop.

use super::{Quantity, Signal};

/// Source of a motor: current or voltage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Torque = constant × gear × current.
    Current,
    /// Torque = constant × gear × (voltage − back-emf constant × gear × rate) / resistance.
    Voltage { resistance_ohm: Quantity, back_emf_v_s_rad: Quantity },
}

/// Which derivative of a joint coordinate, or of the base, a signal states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prescribed {
    Position,
    Rate,
    Acceleration,
}

/// Motion of a shaken base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Base {
    /// Inertial space accelerates along this unit vector: all bodies feel the reaction.
    Translation { direction: [f64; 3] },
}

/// Kind of an input.
#[derive(Clone, Debug, PartialEq)]
pub enum ActuatorKind {
    /// Torque [N m] or force \[N\] in a joint.
    JointTorque { joint: String },
    /// Force \[N\] along `direction` (body axes) at `position_m`.
    BodyForce { body: String, position_m: [Quantity; 3], direction: [f64; 3] },
    /// Torque [N m] about `direction` (body axes).
    BodyTorque { body: String, direction: [f64; 3] },
    /// As a force, but commanded between zero and its range.
    Thruster { body: String, position_m: [Quantity; 3], direction: [f64; 3] },
    /// Torque [N m] on the body about `axis`, its reaction on a rotor of `inertia_kg_m2` (locked
    /// inertia is in the body's).
    Wheel {
        body: String,
        axis: [f64; 3],
        inertia_kg_m2: Quantity,
        viscous_friction_n_m_s_rad: Quantity,
        initial_speed_rad_s: Quantity,
    },
    /// Motor in a joint, commanded in ampere or volt.
    Motor { joint: String, constant_n_m_a: Quantity, gear: Quantity, drive: Drive },
    /// The joint's motion is imposed; its force follows.
    PrescribedJoint { joint: String, what: Prescribed },
    /// Acceleration [m/s²], velocity or displacement of inertial space.
    PrescribedBase { base: Base, what: Prescribed },
}

impl ActuatorKind {
    /// Imposes a motion; every other kind is an effort.
    pub const fn is_imposed(&self) -> bool {
        matches!(self, Self::PrescribedJoint { .. } | Self::PrescribedBase { .. })
    }
}

/// An input of the plant.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    pub name: String,
    pub kind: ActuatorKind,
    /// Sum of the terms; empty: zero, or the command of its controller. A pulse or step of unknown
    /// time and size is a term whose parameters have priors.
    pub command: Vec<Signal>,
    /// White noise of the acting value, per control period, of a thruster while it fires
    /// [SI unit of the input].
    pub noise: Quantity,
    /// Largest |command|; `None`: unlimited.
    pub range: Option<Quantity>,
    /// The recording holds the command.
    pub recorded: bool,
}

/// Closed loop on one actuator:
/// `u = kp (r − y) + ki ∫(r − y) + kd (r' − y') + share × inverse dynamics of the reference`.
#[derive(Clone, Debug, PartialEq)]
pub struct Controller {
    pub name: String,
    pub actuator: String,
    /// Sensor whose reading is y.
    pub position_sensor: Option<String>,
    /// Sensor whose reading is y'.
    pub rate_sensor: Option<String>,
    pub kp: Quantity,
    pub ki: Quantity,
    pub kd: Quantity,
    pub reference: Vec<Signal>,
    /// Share of the nominal plant's inverse dynamics along all references that is fed forward.
    pub feed_forward: Quantity,
    /// Reference rate enters the derivative term (else only −kd y').
    pub reference_rate: bool,
}
