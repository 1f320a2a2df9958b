//! What only the whole plant shows: whether it has equations. Errors of the compiler, at the place
//! that causes them.

use super::{At, Fault, participation::overload};
use dynamics::description::{ActuatorKind, Body, JointKind, Plant};
use dynamics::multibody::ModelError;
use dynamics::system::{System, SystemError};

/// Sections that the mechanism is made of.
const MECHANISM: [&str; 5] = ["plant", "body", "tank", "appendage", "actuator"];

/// `parts` and what the equations add to it: of the mechanism alone where something else is at
/// fault.
pub(crate) fn with_faults_of_equations(plant: &Plant, mut parts: Vec<Fault>) -> Vec<Fault> {
    let errors = || parts.iter().filter(|fault| !fault.warning);
    let compiled = if errors().next().is_none() {
        System::new(plant)
    } else if errors().any(|fault| MECHANISM.contains(&fault.place.section)) {
        return parts;
    } else {
        System::new(&mechanism(plant))
    };
    if let Err(error) = compiled {
        let found = placed(plant, &error);
        parts.retain(|fault| fault.message != found.message);
        parts.push(found);
    }
    parts
}

/// Bodies, tanks, modes and wheels.
fn mechanism(plant: &Plant) -> Plant {
    let wheel = |kind: &ActuatorKind| matches!(kind, ActuatorKind::Wheel { .. });
    Plant {
        space: plant.space,
        environment: plant.environment.clone(),
        bodies: plant.bodies.clone(),
        tanks: plant.tanks.clone(),
        appendages: plant.appendages.clone(),
        actuators: plant.actuators.iter().filter(|actuator| wheel(&actuator.kind)).cloned().collect(),
        ..Plant::default()
    }
}

fn placed(plant: &Plant, error: &SystemError) -> Fault {
    match error {
        SystemError::Mechanism { name, error: ModelError::MassMatrixNotPositive { .. } } => {
            without_inertia(plant, name)
        }
        SystemError::Effect { effect, site, .. } => {
            let here = |used: &dynamics::description::EffectUse| used.kind == *effect && used.site.to_string() == *site;
            let index = plant.effects.iter().position(here).unwrap_or_default();
            error_at(&At::new("effect", index, effect), "kind", error.to_string(), "")
        }
        SystemError::Mechanism { name, error } => {
            let index = plant.bodies.iter().position(|body| *name == format!("body '{}'", body.name));
            let at = index.map_or(At::new("plant", 0, ""), |index| At::new("body", index, ""));
            error_at(&at, "", format!("{name}: {error}"), "")
        }
        _ => error_at(&At::new("plant", 0, ""), "", error.to_string(), ""),
    }
}

/// Some coordinate moves no inertia: the overloaded body, the empty body at or inboard of `name`,
/// or `name` itplant.
fn without_inertia(plant: &Plant, name: &str) -> Fault {
    let overloaded = plant.bodies.iter().enumerate().find_map(|(i, body)| overload(plant, i, body));
    if let Some(warning) = overloaded {
        return Fault { warning: false, ..warning };
    }
    let called = |kind: &str, of: &str| name == format!("{kind} '{of}'");
    let tank = plant.tanks.iter().find(|tank| called("tank", &tank.name));
    let body =
        plant.bodies.iter().position(|body| called("body", &body.name) || tank.is_some_and(|t| t.body == body.name));
    let Some(body) = body else {
        return error_at(&At::new("plant", 0, ""), "", format!("{name} moves no inertia"), "");
    };
    let index = lightest(plant, body);
    let Body { name, mass_kg, joint, .. } = &plant.bodies[index];
    let at = At::new("body", index, name);
    let motion = match joint.kind {
        JointKind::Free => "floats free".to_owned(),
        JointKind::Fixed => "carries what moves".to_owned(),
        JointKind::Revolute { .. } => format!("turns in joint '{}'", joint.name),
        JointKind::Prismatic { .. } => format!("slides in joint '{}'", joint.name),
    };
    let message = format!("{} {motion}, and no inertia moves with it", at.what);
    if mass_kg.value == 0.0 {
        return error_at(&at, "mass", message, "give it mass and inertia, or fix it to a body that has them");
    }
    error_at(&at, "inertia", message, "of a thin rod or a point mass: give a small value about its axis")
}

/// The body at `index`, or the nearest inboard of it, that lacks mass or a principal inertia.
fn lightest(plant: &Plant, index: usize) -> usize {
    let empty = |body: &Body| {
        let [xx, yy, zz, ..] = body.inertia_com_kg_m2.map(|q| q.value);
        let planar = plant.space == dynamics::description::Space::Planar;
        body.mass_kg.value == 0.0 || zz == 0.0 || (!planar && (xx == 0.0 || yy == 0.0))
    };
    let mut at = index;
    while !empty(&plant.bodies[at]) {
        let parent = plant.bodies[at].parent.as_ref();
        match parent.and_then(|parent| plant.bodies.iter().position(|body| body.name == *parent)) {
            Some(parent) => at = parent,
            None => return index,
        }
    }
    at
}

fn error_at(at: &At, key: &str, message: String, cure: &str) -> Fault {
    Fault { place: at.place(key), message, cure: cure.to_owned(), warning: false, because_of: Vec::new() }
}
