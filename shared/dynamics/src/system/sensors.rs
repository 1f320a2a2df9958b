//! Sensors as the description states them, with every name resolved.

use super::error::SystemError;
use super::geometry::{turned_axis, values};
use super::layout::OutputName;
use super::names::Names;
use crate::description::{JointKind, Plant, Reading, Sensor, SensorKind, Space};
use crate::real::Real;
use core::ops::Range;

/// The measured quantity, without errors; axes are turned by the misalignment.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Measured {
    /// `angle`: of the body in a plane plant.
    Gyro {
        link: usize,
        axis: [f64; 3],
        angle: Option<PlaneAngle>,
    },
    Accelerometer {
        link: usize,
        point: [f64; 3],
        axis: [f64; 3],
        flexure: Vec<Flexure>,
    },
    Coordinate(usize),
    Rate(usize),
    Effort(usize),
    Force {
        link: usize,
        axis: [f64; 3],
    },
    Torque {
        link: usize,
        axis: [f64; 3],
    },
    Position {
        link: usize,
        point: [f64; 3],
        axis: [f64; 3],
    },
    Velocity {
        link: usize,
        point: [f64; 3],
        axis: [f64; 3],
    },
    Angle {
        axis_z: f64,
        angle: PlaneAngle,
    },
    Attitude {
        link: usize,
        axis: [f64; 3],
    },
}

/// Displacement of a point per unit of one mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Flexure {
    pub position: usize,
    pub v: usize,
    pub shape: [f64; 3],
}

/// Angle of a body in the plane, counted over all turns: a sum of coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct PlaneAngle {
    pub constant: f64,
    /// Position, velocity, sign.
    pub terms: Vec<(usize, usize, f64)>,
}

impl PlaneAngle {
    /// `constant + Σ ± q` [rad].
    pub fn value<T: Real>(&self, position: &[T]) -> T {
        self.terms.iter().fold(T::constant(self.constant), |sum, (q, _, sign)| sum + position[*q].scale(*sign))
    }

    /// `Σ ± v` [rad/s].
    pub fn rate<T: Real>(&self, velocity: &[T]) -> T {
        self.terms.iter().fold(T::zero(), |sum, (_, v, sign)| sum + velocity[*v].scale(*sign))
    }
}

/// How much of the equations a reading takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Reach {
    /// Positions and velocities as they are.
    State,
    /// Efforts of actuators without laws.
    Efforts,
    /// Poses and velocities of links.
    Motion,
    Accelerations,
}

/// One sensor.
#[derive(Clone, Debug)]
pub(super) struct SensorTerm {
    pub measured: Measured,
    pub scale: f64,
    pub bias: f64,
    pub reading: Reading,
    /// Its effects in `EffectTerms::sensors`.
    pub effects: Range<usize>,
    /// One of them has states.
    pub hidden: bool,
}

impl SensorTerm {
    /// Computations that its instantaneous reading requires; `given`: per velocity, a prescribed
    /// joint's effort comes from dynamics.
    pub fn reach(&self, given: &[bool]) -> Reach {
        if !self.effects.is_empty() {
            return Reach::Accelerations;
        }
        match &self.measured {
            Measured::Coordinate(_) | Measured::Rate(_) | Measured::Angle { .. } => Reach::State,
            Measured::Gyro { angle, .. } => {
                if angle.is_some() {
                    Reach::State
                } else {
                    Reach::Motion
                }
            }
            Measured::Effort(v) => {
                if given[*v] {
                    Reach::Accelerations
                } else {
                    Reach::Efforts
                }
            }
            Measured::Position { .. } | Measured::Velocity { .. } | Measured::Attitude { .. } => Reach::Motion,
            Measured::Accelerometer { .. } | Measured::Force { .. } | Measured::Torque { .. } => Reach::Accelerations,
        }
    }

    /// A mean of a quantity that only the dynamics give, or a reading through a law that may need
    /// accelerations.
    pub fn mean_needs_dynamics(&self) -> bool {
        let kinematic = matches!(
            self.measured,
            Measured::Gyro { .. }
                | Measured::Accelerometer { .. }
                | Measured::Coordinate(_)
                | Measured::Rate(_)
                | Measured::Position { .. }
                | Measured::Velocity { .. }
                | Measured::Angle { .. }
                | Measured::Attitude { .. }
        );
        self.reading == Reading::Mean && !(kinematic && self.effects.is_empty())
    }
}

/// Resolves the names of one sensor; effects are added later.
pub(super) fn sensor_term(plant: &Plant, names: &Names, sensor: &Sensor) -> Result<SensorTerm, SystemError> {
    Ok(SensorTerm {
        measured: measured(plant, names, sensor)?,
        scale: sensor.scale.value,
        bias: sensor.bias.value,
        reading: sensor.reading,
        effects: 0..0,
        hidden: false,
    })
}

fn measured(plant: &Plant, names: &Names, sensor: &Sensor) -> Result<Measured, SystemError> {
    let what = format!("sensor '{}'", sensor.name);
    let turned = |axis: &[f64; 3]| turned_axis(axis, &sensor.misalignment);
    let body = |name: &str| names.body(name, &what);
    let planar = plant.space == Space::Planar;
    Ok(match &sensor.kind {
        SensorKind::Gyro { body: name, axis } => {
            let link = body(name)?;
            let angle = if planar { Some(plane_angle(plant, names, link, &what)?) } else { None };
            Measured::Gyro { link, axis: turned(axis), angle }
        }
        SensorKind::Accelerometer { body: name, position_m, axis, point } => {
            let (point, flexure) = match point {
                Some((appendage, point)) => names.point(plant, appendage, point, &what)?,
                None => (values(position_m), Vec::new()),
            };
            Measured::Accelerometer { link: body(name)?, point, axis: turned(axis), flexure }
        }
        SensorKind::Encoder { joint } => {
            let coordinate = names.joint(joint, &what)?.coordinate;
            Measured::Coordinate(coordinate.position.expect("a joint has a position"))
        }
        SensorKind::JointRate { joint } => Measured::Rate(names.joint(joint, &what)?.coordinate.v),
        SensorKind::JointTorque { joint } => Measured::Effort(names.joint(joint, &what)?.coordinate.v),
        SensorKind::Force { joint, axis } => {
            Measured::Force { link: names.outboard(joint, &what)?, axis: turned(axis) }
        }
        SensorKind::Torque { joint, axis } => {
            Measured::Torque { link: names.outboard(joint, &what)?, axis: turned(axis) }
        }
        SensorKind::Position { body: name, position_m, axis } => {
            Measured::Position { link: body(name)?, point: values(position_m), axis: turned(axis) }
        }
        SensorKind::Velocity { body: name, position_m, axis } => {
            Measured::Velocity { link: body(name)?, point: values(position_m), axis: turned(axis) }
        }
        SensorKind::Attitude { body: name, axis } if planar => {
            Measured::Angle { axis_z: turned(axis)[2], angle: plane_angle(plant, names, body(name)?, &what)? }
        }
        SensorKind::Attitude { body: name, axis } => Measured::Attitude { link: body(name)?, axis: turned(axis) },
        SensorKind::WheelSpeed { actuator } => Measured::Rate(names.wheel(actuator, &what)?),
    })
}

/// Sum of the angles from inertial space to a body.
fn plane_angle(plant: &Plant, names: &Names, link: usize, what: &str) -> Result<PlaneAngle, SystemError> {
    let mut angle = PlaneAngle::default();
    let mut at = Some(link);
    while let Some(index) = at {
        let body = &plant.bodies[index];
        let mounted = &body.joint.orientation;
        angle.constant += mounted.angle_rad.value * mounted.axis[2];
        match body.joint.kind {
            JointKind::Free => angle.terms.push((names.q_index(index) + 2, names.v_index(index), 1.0)),
            JointKind::Revolute { axis } => angle.terms.push((names.q_index(index), names.v_index(index), axis[2])),
            JointKind::Fixed | JointKind::Prismatic { .. } => {}
        }
        at = body.parent.as_deref().map(|parent| names.body(parent, what)).transpose()?;
    }
    Ok(angle)
}

/// Name and unit of a sensor's channel.
pub(super) fn output_name(names: &Names, sensor: &Sensor) -> OutputName {
    let rotary = |joint: &str| names.joint(joint, "").is_ok_and(|joint| joint.rotary);
    let unit = match &sensor.kind {
        SensorKind::Gyro { .. } | SensorKind::WheelSpeed { .. } => "rad/s",
        SensorKind::Accelerometer { .. } => "m/s^2",
        SensorKind::Encoder { joint } => {
            if rotary(joint) {
                "rad"
            } else {
                "m"
            }
        }
        SensorKind::JointRate { joint } => {
            if rotary(joint) {
                "rad/s"
            } else {
                "m/s"
            }
        }
        SensorKind::JointTorque { joint } => {
            if rotary(joint) {
                "N*m"
            } else {
                "N"
            }
        }
        SensorKind::Force { .. } => "N",
        SensorKind::Torque { .. } => "N*m",
        SensorKind::Position { .. } => "m",
        SensorKind::Velocity { .. } => "m/s",
        SensorKind::Attitude { .. } => "rad",
    };
    OutputName { name: sensor.name.clone(), unit }
}
