//! Names and units of states.

use super::layout::{Layout, StateName};
use super::names::{Names, numbered};
use crate::description::{JointKind, Plant, Space, TankModel};
use crate::multibody::Model;

const MODAL: [&str; 2] = ["sqrt(kg)*m", "sqrt(kg)*m/s"];
const TURN: [&str; 2] = ["rad", "rad/s"];
const SLIDE: [&str; 2] = ["m", "m/s"];

/// Fills `layout.states` (but hidden ones) and `layout.quaternions`.
pub(super) fn name_states(plant: &Plant, names: &Names, model: &Model, layout: &mut Layout) {
    let empty = StateName { name: String::new(), unit: "1" };
    let mut position = vec![empty.clone(); layout.q_len + layout.modes];
    let mut velocity = vec![empty; layout.v_len];
    let mut both = |q: usize, v: usize, name: String, unit: [&'static str; 2]| {
        velocity[v] = StateName { name: format!("{name}.rate"), unit: unit[1] };
        position[q] = StateName { name, unit: unit[0] };
    };
    for joint in &names.joints {
        let q = joint.coordinate.position.expect("a joint has a position");
        both(q, joint.coordinate.v, format!("joint:{}", joint.name), if joint.rotary { TURN } else { SLIDE });
    }
    for (tank, coordinates) in plant.tanks.iter().zip(&names.tanks) {
        let unit = if matches!(tank.model, TankModel::Pendulum { .. }) { TURN } else { SLIDE };
        for (k, coordinate) in coordinates.iter().enumerate() {
            let q = coordinate.position.expect("a tank has a displacement");
            both(q, coordinate.v, numbered(&format!("tank:{}", tank.name), k), unit);
        }
    }
    for (mode, (_, coordinate)) in plant.appendages.iter().flat_map(|a| &a.modes).zip(&names.modes) {
        let q = coordinate.position.expect("a mode has a displacement");
        both(q, coordinate.v, format!("mode:{}", mode.name), MODAL);
    }
    for (link, body) in plant.bodies.iter().enumerate().filter(|(_, body)| body.joint.kind == JointKind::Free) {
        let (q, v) = (model.q_index(link), model.v_index(link));
        let name = format!("body:{}", body.name);
        name_free_body(plant.space, &name, &mut position[q..], &mut velocity[v..]);
        if plant.space == Space::Spatial {
            layout.quaternions.push(q + 3);
        }
    }
    for (index, v) in &names.wheels {
        velocity[*v] = StateName { name: format!("wheel:{}", plant.actuators[*index].name), unit: "rad/s" };
    }
    let positions = layout.free_positions.iter().map(|at| position[*at].clone());
    layout.states = positions.chain(layout.free_velocities.iter().map(|at| velocity[*at].clone())).collect();
    // quaternions are states of their own place among the free positions
    let free = &layout.free_positions;
    for first in &mut layout.quaternions {
        *first = free.iter().position(|at| at == first).expect("free joints are never prescribed");
    }
}

fn name_free_body(space: Space, name: &str, position: &mut [StateName], velocity: &mut [StateName]) {
    type List = &'static [(&'static str, &'static str)];
    let (q, v): (List, List) = match space {
        Space::Planar => (&[("x", "m"), ("y", "m"), ("rz", "rad")], &[("rz", "rad/s"), ("x", "m/s"), ("y", "m/s")]),
        Space::Spatial => (
            &[("x", "m"), ("y", "m"), ("z", "m"), ("qw", "1"), ("qx", "1"), ("qy", "1"), ("qz", "1")],
            &[("rx", "rad/s"), ("ry", "rad/s"), ("rz", "rad/s"), ("x", "m/s"), ("y", "m/s"), ("z", "m/s")],
        ),
    };
    for (slot, (part, unit)) in position.iter_mut().zip(q) {
        *slot = StateName { name: format!("{name}.{part}"), unit };
    }
    for (slot, (part, unit)) in velocity.iter_mut().zip(v) {
        *slot = StateName { name: format!("{name}.{part}.rate"), unit };
    }
}
