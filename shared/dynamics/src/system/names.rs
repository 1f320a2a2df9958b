//! Names of the description and their indices in the model.

use super::error::SystemError;
use super::geometry::values;
use super::mechanism::Mechanism;
use super::sensors::Flexure;
use super::sites::{Coordinate, InitialPlace, JointSite, NamedCoordinate};
use crate::description::{ActuatorKind, Appendage, JointKind, Plant, Space};
use crate::multibody::Model;

/// Every name with its place.
#[derive(Clone, Debug)]
pub(super) struct Names {
    pub bodies: Vec<String>,
    /// Name of each body's joint.
    joint_names: Vec<String>,
    /// Joints with one degree of freedom.
    pub joints: Vec<JointSite>,
    /// Per tank, per degree of freedom.
    pub tanks: Vec<Vec<Coordinate>>,
    /// Per mode: body and coordinate.
    pub modes: Vec<(usize, Coordinate)>,
    /// Per wheel: actuator and velocity coordinate.
    pub wheels: Vec<(usize, usize)>,
    wheel_names: Vec<String>,
    q_indices: Vec<usize>,
    v_indices: Vec<usize>,
}

impl Names {
    /// Names of a plant, with the indices of their coordinates in the model.
    pub fn new(plant: &Plant, mechanism: &Mechanism, model: &Model) -> Self {
        let joint = |link: usize| Coordinate { position: Some(model.q_index(link)), v: model.v_index(link) };
        let mode = |(k, link): (usize, &usize)| {
            (*link, Coordinate { position: Some(model.q_len() + k), v: model.v_index_internal(k) })
        };
        let first_wheel = mechanism.mode_links.len();
        let wheel = |(k, actuator): (usize, &usize)| (*actuator, model.v_index_internal(first_wheel + k));
        Self {
            bodies: plant.bodies.iter().map(|body| body.name.clone()).collect(),
            joint_names: plant.bodies.iter().map(|body| body.joint.name.clone()).collect(),
            joints: plant
                .bodies
                .iter()
                .enumerate()
                .filter_map(|(link, body)| {
                    let (rotary, axis) = match body.joint.kind {
                        JointKind::Revolute { axis } => (true, axis),
                        JointKind::Prismatic { axis } => (false, axis),
                        JointKind::Free | JointKind::Fixed => return None,
                    };
                    Some(JointSite { name: body.joint.name.clone(), link, coordinate: joint(link), rotary, axis })
                })
                .collect(),
            tanks: mechanism.tank_links.iter().map(|links| links.iter().map(|link| joint(*link)).collect()).collect(),
            modes: mechanism.mode_links.iter().enumerate().map(mode).collect(),
            wheels: mechanism.wheels.iter().enumerate().map(wheel).collect(),
            wheel_names: mechanism.wheels.iter().map(|actuator| plant.actuators[*actuator].name.clone()).collect(),
            q_indices: (0..plant.bodies.len()).map(|link| model.q_index(link)).collect(),
            v_indices: (0..plant.bodies.len()).map(|link| model.v_index(link)).collect(),
        }
    }

    /// Index of the link of a body.
    ///
    /// # Errors
    /// No body is called `name`; `what` is the part that refers to it.
    pub fn body(&self, name: &str, what: &str) -> Result<usize, SystemError> {
        self.bodies.iter().position(|body| body == name).ok_or_else(|| unknown(what, "body", name))
    }

    /// A joint with one degree of freedom.
    pub fn joint(&self, name: &str, what: &str) -> Result<&JointSite, SystemError> {
        let no_coordinate = || SystemError::NoCoordinate { what: what.to_owned(), joint: name.to_owned() };
        let known = self.joint_names.iter().any(|joint| joint == name);
        let missing = || if known { no_coordinate() } else { unknown(what, "joint", name) };
        self.joints.iter().find(|joint| joint.name == name).ok_or_else(missing)
    }

    /// The outboard body of any joint.
    pub fn outboard(&self, joint: &str, what: &str) -> Result<usize, SystemError> {
        self.joint_names.iter().position(|name| name == joint).ok_or_else(|| unknown(what, "joint", joint))
    }

    /// Velocity coordinate of a wheel's rotor.
    pub fn wheel(&self, actuator: &str, what: &str) -> Result<usize, SystemError> {
        let found = self.wheel_names.iter().position(|name| name == actuator);
        Ok(self.wheels[found.ok_or_else(|| unknown(what, "wheel", actuator))?].1)
    }

    /// First position coordinate of a body's joint.
    pub fn q_index(&self, body: usize) -> usize {
        self.q_indices[body]
    }

    /// First velocity coordinate of a body's joint.
    pub fn v_index(&self, body: usize) -> usize {
        self.v_indices[body]
    }

    /// Undeformed place of a point of an appendage, and how modes move it.
    pub fn point(
        &self,
        plant: &Plant,
        appendage: &str,
        point: &str,
        what: &str,
    ) -> Result<([f64; 3], Vec<Flexure>), SystemError> {
        let found = plant.appendages.iter().position(|a| a.name == appendage);
        let at = found.ok_or_else(|| unknown(what, "appendage", appendage))?;
        let Appendage { points, modes, .. } = &plant.appendages[at];
        let found = points.iter().position(|(name, _)| name == point);
        let index = found.ok_or_else(|| unknown(what, "point", point))?;
        let before: usize = plant.appendages[..at].iter().map(|a| a.modes.len()).sum();
        let flexure = modes.iter().zip(&self.modes[before..]).filter_map(|(mode, (_, coordinate))| {
            let position = coordinate.position.expect("a mode has a displacement");
            Some(Flexure { position, v: coordinate.v, shape: values(mode.shape_per_sqrt_kg.get(index)?) })
        });
        Ok((values(&points[index].1), flexure.collect()))
    }

    /// Everything that can have an initial value.
    pub fn initial_places(&self, plant: &Plant) -> Vec<NamedCoordinate> {
        let mut places = Vec::new();
        let mut add = |name: String, what| places.push(NamedCoordinate { name, what });
        let axes: &[(&str, usize)] = match plant.space {
            Space::Planar => &[("x", 0), ("y", 1), ("rz", 5)],
            Space::Spatial => &[("x", 0), ("y", 1), ("z", 2), ("rx", 3), ("ry", 4), ("rz", 5)],
        };
        for (link, body) in plant.bodies.iter().enumerate().filter(|(_, body)| body.joint.kind == JointKind::Free) {
            for (name, axis) in axes {
                add(format!("body:{}.{name}", body.name), InitialPlace::Free { link, axis: *axis });
            }
        }
        for joint in &self.joints {
            add(format!("joint:{}", joint.name), InitialPlace::Single(joint.coordinate));
        }
        for (tank, coordinates) in plant.tanks.iter().zip(&self.tanks) {
            for (k, coordinate) in coordinates.iter().enumerate() {
                add(numbered(&format!("tank:{}", tank.name), k), InitialPlace::Single(*coordinate));
            }
        }
        for (mode, (_, coordinate)) in plant.appendages.iter().flat_map(|a| &a.modes).zip(&self.modes) {
            add(format!("mode:{}", mode.name), InitialPlace::Single(*coordinate));
        }
        for (index, v) in &self.wheels {
            let actuator = &plant.actuators[*index];
            if let ActuatorKind::Wheel { initial_speed_rad_s, .. } = &actuator.kind {
                let place = InitialPlace::Wheel { v: *v, speed_rad_s: initial_speed_rad_s.value };
                add(format!("wheel:{}", actuator.name), place);
            }
        }
        places
    }
}

/// `name` for the first, `name.2`, `name.3` for the others.
pub(super) fn numbered(name: &str, index: usize) -> String {
    if index == 0 { name.to_owned() } else { format!("{name}.{}", index + 1) }
}

pub(super) fn unknown(what: &str, kind: &'static str, name: &str) -> SystemError {
    SystemError::Unknown { what: what.to_owned(), kind, name: name.to_owned() }
}
