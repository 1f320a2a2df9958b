//! From a description to a [`System`]: names become indices, parameters become arrays.

use super::actuation::{Acts, Actuation};
use super::binding::Binding;
use super::environment::{Orbit, Surrounding};
use super::error::SystemError;
use super::feed_forward::all_but_base;
use super::geometry::{cross, values};
use super::layout::{InputName, InputRole, Layout, PrescribedJoint};
use super::mechanism::Mechanism;
use super::names::Names;
use super::passive::Passive;
use super::sensors::{Reach, output_name, sensor_term};
use super::sites::Coordinate;
use super::{System, state_names};
use crate::description::{Actuator, ActuatorKind, Base, Drive, JointKind, Plant, TankModel};
use crate::effect::{Surroundings, apply_structures};
use crate::multibody::Model;

/// Force beyond which a body force is firing, in standard deviations of its noise: noise alone is
/// beyond it once in 16 000 periods.
const QUIET_SIGMAS: f64 = 4.0;

/// Structure effects, mechanism, coordinates, inputs, sensors, effects: in this order.
pub(super) fn compile(plant: &Plant) -> Result<System, SystemError> {
    let plant = &with_structure_effects(plant)?;
    let mechanism = Mechanism::new(plant)?;
    let environment = surrounding(plant);
    let model = mechanism.compile(environment.constants.gravity_m_s2)?;
    let names = Names::new(plant, &mechanism, &model);
    let mut layout = Layout {
        q_len: model.q_len(),
        modes: mechanism.mode_links.len(),
        v_len: model.v_len(),
        mode_rate: model.v_len() - model.internals_len(),
        ..Layout::default()
    };
    let mut actuators = inputs_and_actuators(plant, &names, &mut layout)?;
    let mut sensors = Vec::with_capacity(plant.sensors.len());
    for sensor in &plant.sensors {
        sensors.push(sensor_term(plant, &names, sensor)?);
        layout.outputs.push(output_name(&names, sensor));
    }
    state_names::name_states(plant, &names, &model, &mut layout);
    let binding = Binding { plant, names: &names, environment: &environment };
    let (mut effects, filters) = binding.bind(&mut layout, &mut actuators, &mut sensors)?;
    effects.hidden_at = layout.hidden_at();
    let pushed = environment.pushes()
        || !effects.bodies.is_empty()
        || !effects.actuators.is_empty()
        || actuators.iter().any(|actuator| matches!(actuator.acts, Acts::Wrench { .. }));
    // laws of actuators look at links
    let lowest = if effects.actuators.is_empty() { Reach::State } else { Reach::Motion };
    let reach = sensors.iter().map(|sensor| sensor.reach(&layout.prescribed_flags)).fold(lowest, Reach::max);
    let mut system = System {
        lightness_apart: None,
        pushed,
        reach,
        space: plant.space,
        springs: springs(plant, &names, &model),
        coordinates: names.initial_places(plant),
        all_but_base: all_but_base(&model, mechanism.links.iter().map(|link| link.joint)),
        spatial_bases: spatial_bases(&mechanism),
        inertia_com: mechanism.links.iter().map(|link| link.inertia_com_kg_m2.transpose().into()).collect(),
        joints: names.joints,
        model,
        layout,
        actuators,
        environment,
        effects,
        sensors,
        filters,
    };
    system.lightness_apart = system.lightness_apart();
    Ok(system)
}

/// Copy of the plant with the parts and values that structural effects add.
fn with_structure_effects(plant: &Plant) -> Result<Plant, SystemError> {
    let mut plant = plant.clone();
    apply_structures(&mut plant)?;
    Ok(plant)
}

fn surrounding(plant: &Plant) -> Surrounding {
    let outside = &plant.environment;
    let orbit = outside
        .gravity_gradient
        .map(|orbit| Orbit { rate_rad_s: orbit.orbit_rate_rad_s.value, phase_rad: orbit.phase_rad.value });
    let constants = Surroundings {
        gravity_m_s2: values(&outside.gravity_m_s2),
        orbit_rate_rad_s: orbit.map_or(0.0, |orbit| orbit.rate_rad_s),
        orbit_phase_rad: orbit.map_or(0.0, |orbit| orbit.phase_rad),
        density_kg_m3: outside.atmosphere.map_or(0.0, |air| air.density_kg_m3.value),
        wind_m_s: outside.atmosphere.map_or([0.0; 3], |air| values(&air.wind_m_s)),
        field_t: outside.magnetic_field.map_or([0.0; 3], |field| values(&field.field_t)),
        step_s: plant.simulation.step_s,
        ..Surroundings::default()
    };
    let free = plant.bodies.iter().position(|body| body.joint.kind == JointKind::Free);
    // the motor of a flexible joint is a body without mass
    let heavy = plant.bodies.iter().position(|body| body.mass_kg.value > 0.0);
    Surrounding {
        constants,
        force_n: values(&outside.constant_force_n),
        torque_n_m: values(&outside.constant_torque_n_m),
        disturbed: free.or(heavy).unwrap_or(0),
        orbit: orbit.filter(|orbit| orbit.rate_rad_s != 0.0),
        shaken: plant.actuators.iter().any(|a| matches!(a.kind, ActuatorKind::PrescribedBase { .. })),
    }
}

fn inputs_and_actuators(plant: &Plant, names: &Names, layout: &mut Layout) -> Result<Vec<Actuation>, SystemError> {
    let mut actuators = Vec::with_capacity(plant.actuators.len());
    layout.prescribed_flags = vec![false; layout.v_len];
    for (index, actuator) in plant.actuators.iter().enumerate() {
        let input = layout.inputs.len();
        let (acts, link) = acts(names, actuator)?;
        if let Acts::Joint { coordinate } = acts {
            prescribe(layout, coordinate, input, actuator)?;
        }
        add_inputs(names, actuator, index, layout);
        let one_sided = matches!(actuator.kind, ActuatorKind::Thruster { .. });
        let quiet = QUIET_SIGMAS * actuator.noise.value;
        actuators.push(Actuation { acts, input, link, effects: 0..0, one_sided, quiet });
    }
    let prescribed = &layout.prescribed;
    let free = |at: &usize| !prescribed.iter().any(|joint| joint.q == *at);
    layout.free_positions = (0..layout.q_len + layout.modes).filter(free).collect();
    layout.free_velocities = (0..layout.v_len).filter(|v| !layout.prescribed_flags[*v]).collect();
    Ok(actuators)
}

fn prescribe(
    layout: &mut Layout,
    coordinate: Coordinate,
    input: usize,
    actuator: &Actuator,
) -> Result<(), SystemError> {
    if core::mem::replace(&mut layout.prescribed_flags[coordinate.v], true) {
        let ActuatorKind::PrescribedJoint { joint, .. } = &actuator.kind else { unreachable!("it acts on a joint") };
        return Err(SystemError::PrescribedTwice { joint: joint.clone() });
    }
    let q = coordinate.position.expect("a joint has a position");
    layout.prescribed.push(PrescribedJoint { q, v: coordinate.v, input });
    Ok(())
}

/// How an actuator acts, and the body it belongs to.
fn acts(names: &Names, actuator: &Actuator) -> Result<(Acts, usize), SystemError> {
    let what = format!("actuator '{}'", actuator.name);
    Ok(match &actuator.kind {
        ActuatorKind::JointTorque { joint } => {
            let joint = names.joint(joint, &what)?;
            (Acts::Coordinate { coordinate: joint.coordinate, gain: 1.0 }, joint.link)
        }
        ActuatorKind::BodyForce { body, position_m, direction }
        | ActuatorKind::Thruster { body, position_m, direction } => {
            let [a, b, c] = cross(values(position_m), *direction);
            let [d, e, f] = *direction;
            (
                Acts::Wrench { wrench: [a, b, c, d, e, f], force: libm::sqrt(d * d + e * e + f * f) },
                names.body(body, &what)?,
            )
        }
        ActuatorKind::BodyTorque { body, direction } => {
            let [a, b, c] = *direction;
            (Acts::Wrench { wrench: [a, b, c, 0.0, 0.0, 0.0], force: 0.0 }, names.body(body, &what)?)
        }
        ActuatorKind::Wheel { body, .. } => {
            let coordinate = Coordinate { position: None, v: names.wheel(&actuator.name, &what)? };
            (Acts::Coordinate { coordinate, gain: -1.0 }, names.body(body, &what)?)
        }
        ActuatorKind::Motor { joint, constant_n_m_a, gear, drive } => {
            let joint = names.joint(joint, &what)?;
            let (coordinate, torque) = (joint.coordinate, constant_n_m_a.value * gear.value);
            let acts = match drive {
                Drive::Current => Acts::Coordinate { coordinate, gain: torque },
                Drive::Voltage { resistance_ohm, back_emf_v_s_rad } => Acts::Voltage {
                    coordinate,
                    gain: torque / resistance_ohm.value,
                    back_emf: back_emf_v_s_rad.value * gear.value,
                },
            };
            (acts, joint.link)
        }
        ActuatorKind::PrescribedJoint { joint, .. } => {
            let joint = names.joint(joint, &what)?;
            (Acts::Joint { coordinate: joint.coordinate }, joint.link)
        }
        ActuatorKind::PrescribedBase { base: Base::Translation { direction }, .. } => {
            (Acts::Base { direction: *direction }, 0)
        }
    })
}

fn add_inputs(names: &Names, actuator: &Actuator, index: usize, layout: &mut Layout) {
    let rotary = |joint: &str| names.joint(joint, "").is_ok_and(|joint| joint.rotary);
    let mut add = |suffix: &str, unit, role| {
        layout.inputs.push(InputName { name: format!("{}{suffix}", actuator.name), unit, actuator: index, role });
    };
    let motion = match &actuator.kind {
        ActuatorKind::PrescribedJoint { joint, .. } if rotary(joint) => ["rad", "rad/s", "rad/s^2"],
        ActuatorKind::PrescribedJoint { .. } | ActuatorKind::PrescribedBase { .. } => ["m", "m/s", "m/s^2"],
        kind => {
            let unit = match kind {
                ActuatorKind::JointTorque { joint } if !rotary(joint) => "N",
                ActuatorKind::BodyForce { .. } | ActuatorKind::Thruster { .. } => "N",
                ActuatorKind::Motor { drive: Drive::Current, .. } => "A",
                ActuatorKind::Motor { .. } => "V",
                _ => "N*m",
            };
            return add("", unit, InputRole::Command);
        }
    };
    add(".position", motion[0], InputRole::Position);
    add(".rate", motion[1], InputRole::Rate);
    add(".acceleration", motion[2], InputRole::Acceleration);
}

/// Springs and dampers of joints, tanks, modes and wheels that do anything.
fn springs(plant: &Plant, names: &Names, model: &Model) -> Vec<Passive> {
    let mut springs = Vec::new();
    let mut add = |coordinate, stiffness: f64, rest: f64, damping: f64| {
        springs.push(Passive { coordinate, stiffness, rest, damping });
    };
    for (site, joint) in names.joints.iter().map(|site| (site, &plant.bodies[site.link].joint)) {
        add(site.coordinate, joint.stiffness.value, joint.rest.value, joint.viscous_friction.value);
    }
    for (tank, coordinates) in plant.tanks.iter().zip(&names.tanks) {
        for (k, coordinate) in coordinates.iter().enumerate() {
            match &tank.model {
                TankModel::Spring { stiffness_n_m, damping_n_s_m, .. } => {
                    let at = |list: &[crate::description::Quantity]| list.get(k).map_or(0.0, |quantity| quantity.value);
                    add(*coordinate, at(stiffness_n_m), 0.0, at(damping_n_s_m));
                }
                TankModel::Pendulum { damping_n_m_s_rad, .. } => add(*coordinate, 0.0, 0.0, damping_n_m_s_rad.value),
            }
        }
    }
    for (mode, (_, coordinate)) in plant.appendages.iter().flat_map(|a| &a.modes).zip(&names.modes) {
        let omega = core::f64::consts::TAU * mode.frequency_hz.value;
        add(*coordinate, omega * omega, 0.0, 2.0 * mode.damping_ratio.value * omega);
    }
    for (index, v) in &names.wheels {
        if let ActuatorKind::Wheel { viscous_friction_n_m_s_rad, .. } = &plant.actuators[*index].kind {
            add(Coordinate { position: None, v: *v }, 0.0, 0.0, viscous_friction_n_m_s_rad.value);
        }
    }
    debug_assert!(springs.iter().all(|term| term.coordinate.v < model.v_len()));
    springs.retain(Passive::acts);
    springs
}

fn spatial_bases(mechanism: &Mechanism) -> Vec<usize> {
    let turns = |link: &usize| mechanism.links[*link].joint == crate::multibody::JointKind::FreeSpatial;
    (0..mechanism.links.len()).filter(turns).collect()
}
