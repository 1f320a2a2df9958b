//! Bodies, tanks, modes and wheels as links and internal coordinates.
//!
//! Link i is body i; the links of tanks follow. A slosh mass on springs is a chain of prismatic
//! links of which only the last has mass, a pendulum a revolute link with a point mass (in space
//! two, as a universal joint). Modes come before wheels.

use super::error::SystemError;
use super::geometry::{rotation_of, values};
use crate::description::{Actuator, ActuatorKind, Body, JointKind as Kind, Plant, Space, Tank, TankModel};
use crate::multibody::{InternalCoordinate, JointKind, Link, Model, ModelError};
use nalgebra::{Matrix3, Vector3};

/// Parts of the model before it is compiled.
#[derive(Clone, Debug, Default)]
pub(super) struct Mechanism {
    pub links: Vec<Link>,
    pub internals: Vec<InternalCoordinate>,
    /// Per tank: its links, one per degree of freedom.
    pub tank_links: Vec<Vec<usize>>,
    /// Body of each mode, in the order of the internal coordinates.
    pub mode_links: Vec<usize>,
    /// Actuator of each wheel, in the order of the internal coordinates after the modes.
    pub wheels: Vec<usize>,
    /// Who is at fault: of links, then of internal coordinates.
    link_names: Vec<String>,
    internal_names: Vec<String>,
}

impl Mechanism {
    /// Links and internal coordinates of a plant.
    ///
    /// # Errors
    /// A name without a part, or a joint that no link can represent.
    pub fn new(plant: &Plant) -> Result<Self, SystemError> {
        let mut mechanism = Self::default();
        for body in &plant.bodies {
            let link = body_link(plant, body)?;
            mechanism.push_link(link, format!("body '{}'", body.name));
        }
        for tank in &plant.tanks {
            mechanism.add_tank(plant, tank)?;
        }
        for appendage in &plant.appendages {
            let link = body_index(plant, &appendage.body, &format!("appendage '{}'", appendage.name))?;
            for mode in &appendage.modes {
                let ([d, e, f], [a, b, c]) = (values(&mode.translation_sqrt_kg), values(&mode.rotation_sqrt_kg_m));
                let internal = InternalCoordinate { link, mass: 1.0, coupling: [a, b, c, d, e, f] };
                mechanism.mode_links.push(link);
                mechanism.internals.push(internal);
                mechanism.internal_names.push(format!("mode '{}'", mode.name));
            }
        }
        for (index, actuator) in plant.actuators.iter().enumerate() {
            mechanism.add_wheel(plant, index, actuator)?;
        }
        Ok(mechanism)
    }

    /// The model of these links and internal coordinates under gravity in inertial axes.
    ///
    /// # Errors
    /// [`SystemError::Mechanism`]: the part that prevents a mechanism, by its name in the plant.
    pub fn compile(&self, gravity_m_s2: [f64; 3]) -> Result<Model, SystemError> {
        let compiled = Model::new(&self.links, &self.internals, Vector3::from(gravity_m_s2));
        compiled.map_err(|error| SystemError::Mechanism { name: self.at_fault(&error), error })
    }

    fn push_link(&mut self, link: Link, name: String) -> usize {
        self.links.push(link);
        self.link_names.push(name);
        self.links.len() - 1
    }

    fn add_tank(&mut self, plant: &Plant, tank: &Tank) -> Result<(), SystemError> {
        let what = format!("tank '{}'", tank.name);
        let body = body_index(plant, &tank.body, &what)?;
        let (joints, com_m) = tank_joints(plant.space, tank, &what)?;
        let last = joints.len() - 1;
        let mut links = Vec::with_capacity(joints.len());
        let mut parent = body;
        for (k, joint) in joints.into_iter().enumerate() {
            let mut link = massless(Some(parent), joint);
            if k == 0 {
                link.position_m = Vector3::from(values(&tank.position_m));
            }
            if k == last {
                (link.mass_kg, link.com_m) = (tank.mass_kg.value, com_m);
            }
            parent = self.push_link(link, what.clone());
            links.push(parent);
        }
        self.tank_links.push(links);
        Ok(())
    }

    fn add_wheel(&mut self, plant: &Plant, index: usize, actuator: &Actuator) -> Result<(), SystemError> {
        let ActuatorKind::Wheel { body, axis, inertia_kg_m2, .. } = &actuator.kind else { return Ok(()) };
        let name = format!("wheel '{}'", actuator.name);
        let [a, b, c] = axis.map(|x| x * inertia_kg_m2.value);
        if plant.space == Space::Planar && (axis[0] != 0.0 || axis[1] != 0.0) {
            return Err(SystemError::OutOfPlane { what: name, axis: *axis });
        }
        let link = body_index(plant, body, &name)?;
        self.internals.push(InternalCoordinate { link, mass: inertia_kg_m2.value, coupling: [a, b, c, 0.0, 0.0, 0.0] });
        self.internal_names.push(name);
        self.wheels.push(index);
        Ok(())
    }

    fn at_fault(&self, error: &ModelError) -> String {
        let name = match *error {
            ModelError::Empty => None,
            ModelError::ParentNotBefore { link, .. }
            | ModelError::NotFinite { link, .. }
            | ModelError::AxisNotUnit { link, .. }
            | ModelError::NotARotation { link, .. }
            | ModelError::NegativeMass { link, .. }
            | ModelError::InertiaNotPositive { link, .. }
            | ModelError::Armature { link, .. } => self.link_names.get(link),
            ModelError::NoSuchLink { internal, .. } | ModelError::InternalMass { internal, .. } => {
                self.internal_names.get(internal)
            }
            ModelError::MassMatrixNotPositive { v_index, .. } => self.velocity_name(v_index),
        };
        name.cloned().unwrap_or_else(|| "plant".to_owned())
    }

    fn velocity_name(&self, v_index: usize) -> Option<&String> {
        let mut first = 0;
        for (link, name) in self.links.iter().zip(&self.link_names) {
            first += link.joint.v_len();
            if v_index < first {
                return Some(name);
            }
        }
        self.internal_names.get(v_index - first)
    }
}

/// Index of a body, which is its link.
pub(super) fn body_index(plant: &Plant, name: &str, what: &str) -> Result<usize, SystemError> {
    let unknown = || SystemError::Unknown { what: what.to_owned(), kind: "body", name: name.to_owned() };
    plant.bodies.iter().position(|body| body.name == name).ok_or_else(unknown)
}

fn massless(parent: Option<usize>, joint: JointKind) -> Link {
    Link {
        parent,
        joint,
        position_m: Vector3::zeros(),
        rotation: Matrix3::identity(),
        mass_kg: 0.0,
        com_m: Vector3::zeros(),
        inertia_com_kg_m2: Matrix3::zeros(),
        armature: 0.0,
    }
}

fn body_link(plant: &Plant, body: &Body) -> Result<Link, SystemError> {
    let what = format!("body '{}'", body.name);
    let parent = body.parent.as_deref().map(|parent| body_index(plant, parent, &what)).transpose()?;
    let joint = match body.joint.kind {
        Kind::Free if plant.space == Space::Planar => JointKind::FreePlanar,
        Kind::Free => JointKind::FreeSpatial,
        Kind::Fixed => JointKind::Fixed,
        Kind::Revolute { axis } => JointKind::Revolute { axis: turning(plant.space, axis, &what)? },
        Kind::Prismatic { axis } => JointKind::Prismatic { axis: sliding(plant.space, axis, &what)? },
    };
    let moves = matches!(joint, JointKind::Revolute { .. } | JointKind::Prismatic { .. });
    let [xx, yy, zz, xy, xz, yz] = body.inertia_com_kg_m2.map(|quantity| quantity.value);
    Ok(Link {
        position_m: Vector3::from(values(&body.joint.position_m)),
        rotation: rotation_of(&body.joint.orientation),
        mass_kg: body.mass_kg.value,
        com_m: Vector3::from(values(&body.com_m)),
        inertia_com_kg_m2: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
        armature: if moves { body.joint.rotor_inertia.value } else { 0.0 },
        ..massless(parent, joint)
    })
}

/// Joints of a tank, inboard first, and the place of the mass on the last link.
fn tank_joints(space: Space, tank: &Tank, what: &str) -> Result<(Vec<JointKind>, Vector3<f64>), SystemError> {
    match &tank.model {
        TankModel::Spring { axes, .. } => {
            let slide = |axis: &[f64; 3]| Ok(JointKind::Prismatic { axis: sliding(space, *axis, what)? });
            let joints = axes.iter().map(slide).collect::<Result<Vec<_>, SystemError>>()?;
            let none = || SystemError::Unknown { what: what.to_owned(), kind: "axis", name: "1".to_owned() };
            if joints.is_empty() { Err(none()) } else { Ok((joints, Vector3::zeros())) }
        }
        TankModel::Pendulum { rest, length_m, .. } => {
            let direction = sliding(space, *rest, what)?;
            let mass_at = direction * length_m.value;
            if space == Space::Planar {
                return Ok((vec![JointKind::Revolute { axis: Vector3::z() }], mass_at));
            }
            let [first, second] = across(&direction);
            Ok((vec![JointKind::Revolute { axis: first }, JointKind::Revolute { axis: second }], mass_at))
        }
    }
}

/// Two unit vectors across `direction` and each other; the first across the coordinate axis that
/// `direction` is farthest from.
fn across(direction: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let farthest = (1..3).fold(0, |best, k| if direction[k].abs() < direction[best].abs() { k } else { best });
    let mut axis = Vector3::zeros();
    axis[farthest] = 1.0;
    let first = direction.cross(&axis).normalize();
    [first, first.cross(direction)]
}

fn turning(space: Space, axis: [f64; 3], what: &str) -> Result<Vector3<f64>, SystemError> {
    if space == Space::Planar && (axis[0] != 0.0 || axis[1] != 0.0) {
        return Err(SystemError::OutOfPlane { what: what.to_owned(), axis });
    }
    Ok(Vector3::from(axis))
}

fn sliding(space: Space, axis: [f64; 3], what: &str) -> Result<Vector3<f64>, SystemError> {
    if space == Space::Planar && axis[2] != 0.0 {
        return Err(SystemError::OutOfPlane { what: what.to_owned(), axis });
    }
    Ok(Vector3::from(axis))
}
