//! Laws of the compiled equations. Plants are built here in code.

mod appendages;
mod closed_forms;
mod conservation;
mod derivatives;
mod drives;
mod effects;
mod initial_states;
mod readings;

use super::{RungeKutta, System, Workspace};
use crate::description::{
    Actuator, ActuatorKind, Appendage, Body, Joint, JointKind, Mode, Orientation, Plant, Quantity, Sensor, SensorKind,
    Space, Tank, TankModel,
};
use crate::dual::Dual;
use crate::noise::Stream;

pub(super) fn known(value: f64) -> Quantity {
    Quantity::known(value)
}

pub(super) fn three(values: [f64; 3]) -> [Quantity; 3] {
    values.map(known)
}

pub(super) fn joint(name: &str, kind: JointKind, position_m: [f64; 3]) -> Joint {
    Joint {
        name: name.to_owned(),
        kind,
        position_m: three(position_m),
        orientation: Orientation::default(),
        viscous_friction: known(0.0),
        rotor_inertia: known(0.0),
        stiffness: known(0.0),
        rest: known(0.0),
    }
}

/// A body with inertia xx, yy, zz about its centre of mass.
pub(super) fn body(
    name: &str,
    parent: Option<&str>,
    joint: Joint,
    mass_kg: f64,
    com_m: [f64; 3],
    inertia: [f64; 3],
) -> Body {
    let [xx, yy, zz] = inertia;
    Body {
        name: name.to_owned(),
        parent: parent.map(str::to_owned),
        joint,
        mass_kg: known(mass_kg),
        com_m: three(com_m),
        inertia_com_kg_m2: [xx, yy, zz, 0.0, 0.0, 0.0].map(known),
    }
}

pub(super) fn free(name: &str, mass_kg: f64, com_m: [f64; 3], inertia: [f64; 3]) -> Body {
    body(name, None, joint(name, JointKind::Free, [0.0; 3]), mass_kg, com_m, inertia)
}

pub(super) const Z: [f64; 3] = [0.0, 0.0, 1.0];

pub(super) fn actuator(name: &str, kind: ActuatorKind) -> Actuator {
    Actuator { name: name.to_owned(), kind, command: Vec::new(), noise: known(0.0), range: None, recorded: false }
}

pub(super) fn sensor(name: &str, kind: SensorKind) -> Sensor {
    Sensor {
        name: name.to_owned(),
        kind,
        noise: crate::description::Noise::default(),
        bias: known(0.0),
        scale: known(0.0),
        misalignment: Orientation::default(),
        range: None,
        resolution: known(0.0),
        low_pass_hz: None,
        delay_s: known(0.0),
        period_s: None,
        reading: crate::description::Reading::Instant,
        source: None,
    }
}

pub(super) fn spring_tank(
    name: &str,
    body: &str,
    at: [f64; 3],
    mass_kg: f64,
    axes: &[[f64; 3]],
    k: f64,
    c: f64,
) -> Tank {
    Tank {
        name: name.to_owned(),
        body: body.to_owned(),
        position_m: three(at),
        mass_kg: known(mass_kg),
        model: TankModel::Spring {
            axes: axes.to_vec(),
            stiffness_n_m: vec![known(k); axes.len()],
            damping_n_s_m: vec![known(c); axes.len()],
        },
    }
}

pub(super) fn pendulum_tank(
    name: &str,
    body: &str,
    at: [f64; 3],
    mass_kg: f64,
    rest: [f64; 3],
    length: f64,
    d: f64,
) -> Tank {
    Tank {
        name: name.to_owned(),
        body: body.to_owned(),
        position_m: three(at),
        mass_kg: known(mass_kg),
        model: TankModel::Pendulum { rest, length_m: known(length), damping_n_m_s_rad: known(d) },
    }
}

pub(super) fn mode(name: &str, hz: f64, zeta: f64, translation: [f64; 3], rotation: [f64; 3], shape: [f64; 3]) -> Mode {
    Mode {
        name: name.to_owned(),
        frequency_hz: known(hz),
        damping_ratio: known(zeta),
        translation_sqrt_kg: three(translation),
        rotation_sqrt_kg_m: three(rotation),
        shape_per_sqrt_kg: vec![three(shape)],
    }
}

pub(super) fn appendage(name: &str, body: &str, tip: [f64; 3], modes: Vec<Mode>) -> Appendage {
    Appendage { name: name.to_owned(), body: body.to_owned(), points: vec![("tip".to_owned(), three(tip))], modes }
}

/// Free base and two links of Table II in a plane or in space, turning about z.
pub(super) fn arm(space: Space) -> Plant {
    let table = simulation::oracle::arm_parameters::ArmParameters::paper_table_ii();
    let revolute = JointKind::Revolute { axis: Z };
    let inertia = |zz: f64| if space == Space::Planar { [0.0, 0.0, zz] } else { [0.7 * zz, 0.8 * zz, zz] };
    let [x, y] = table.r0_m;
    let link = |i: usize, parent, at: [f64; 3]| {
        let name = format!("link{}", i + 1);
        let moment = inertia(table.link_inertia_com_kg_m2[i]);
        let hinge = joint(&format!("joint{}", i + 1), revolute, at);
        body(&name, Some(parent), hinge, table.link_mass_kg[i], [table.l_m[i], 0.0, 0.0], moment)
    };
    Plant {
        space,
        bodies: vec![
            free("base", table.base_mass_kg, [0.0; 3], inertia(table.base_inertia_com_kg_m2)),
            link(0, "base", [x, y, 0.0]),
            link(1, "link1", [table.l_m[0] + table.r_m[0], 0.0, 0.0]),
        ],
        actuators: ["joint1", "joint2"].map(torque_of).to_vec(),
        ..Plant::default()
    }
}

pub(super) fn torque_of(name: &str) -> Actuator {
    actuator(&format!("{name}.torque"), ActuatorKind::JointTorque { joint: name.to_owned() })
}

/// A spatial hub with everything on it: two joints (one sliding, with spring, friction and rotor),
/// tanks of both kinds, an appendage with two modes on the hub and one on the arm, two wheels.
pub(super) fn everything(damped: bool) -> Plant {
    let d = if damped { 1.0 } else { 0.0 };
    let mut slider = joint("slide", JointKind::Prismatic { axis: [0.0, 0.6, 0.8] }, [0.2, 1.0, 0.1]);
    slider.orientation = Orientation { axis: [0.6, 0.0, 0.8], angle_rad: known(0.7) };
    (slider.stiffness, slider.rest, slider.viscous_friction) = (known(40.0), known(0.1), known(3.0 * d));
    slider.rotor_inertia = known(2.0);
    let mut hinge = joint("hinge", JointKind::Revolute { axis: [0.0, 0.8, 0.6] }, [0.9, -0.4, 0.3]);
    (hinge.viscous_friction, hinge.rotor_inertia) = (known(1.5 * d), known(0.4));
    let axes = [[1.0, 0.0, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]];
    let wheel = |name: &str, axis, speed: f64| {
        actuator(
            name,
            ActuatorKind::Wheel {
                body: "hub".to_owned(),
                axis,
                inertia_kg_m2: known(0.05),
                viscous_friction_n_m_s_rad: known(1e-3 * d),
                initial_speed_rad_s: known(speed),
            },
        )
    };
    let panel = vec![
        mode("bend", 0.4, 0.01 * d, [0.5, 1.5, -0.4], [0.3, -0.8, 4.0], [0.0, 0.6, 0.1]),
        mode("twist", 1.1, 0.02 * d, [0.0, -0.3, 0.2], [1.2, 0.4, 0.5], [0.1, 0.0, 0.3]),
    ];
    let boom = vec![mode("boom", 0.9, 0.015 * d, [0.4, 0.2, 0.1], [0.1, 0.2, 0.3], [0.2, 0.1, 0.0])];
    let mut hub = free("hub", 300.0, [0.1, -0.2, 0.05], [90.0, 110.0, 130.0]);
    hub.inertia_com_kg_m2[3] = known(-7.0);
    hub.inertia_com_kg_m2[5] = known(4.0);
    Plant {
        space: Space::Spatial,
        bodies: vec![
            hub,
            body("arm", Some("hub"), hinge, 20.0, [0.7, 0.1, 0.0], [3.0, 9.0, 10.0]),
            body("tool", Some("arm"), slider, 8.0, [0.0, 0.1, 0.2], [1.0, 1.2, 0.9]),
        ],
        tanks: vec![
            spring_tank("fuel", "hub", [0.3, 0.1, -0.5], 15.0, &axes, 20.0, 2.0 * d),
            pendulum_tank("oxidiser", "hub", [-0.4, 0.2, 0.3], 12.0, [0.0, 0.6, -0.8], 0.5, 0.3 * d),
        ],
        appendages: vec![appendage("panel", "hub", [2.0, 0.3, 0.1], panel), appendage("boom", "arm", [1.0; 3], boom)],
        actuators: vec![
            torque_of("hinge"),
            torque_of("slide"),
            wheel("wheel1", [0.0, 0.0, 1.0], 60.0),
            wheel("wheel2", [0.6, 0.8, 0.0], -90.0),
        ],
        ..Plant::default()
    }
}

/// State with every number drawn, positions and rates of order one; quaternions of unit length.
pub(super) fn random_state(system: &System, seed: u64) -> Vec<f64> {
    let stream = Stream::new(seed, "system");
    let mut x: Vec<f64> = (0..system.states().len()).map(|k| 2.0 * stream.uniform_pair(k as u64)[0] - 1.0).collect();
    system.normalise(&mut x);
    x
}

pub(super) fn rates(system: &System, x: &[f64], u: &[f64]) -> Vec<f64> {
    let mut x_dot = vec![0.0; x.len()];
    system.derivative(&mut Workspace::new(system), 0.0, x, u, &mut x_dot);
    x_dot
}

pub(super) fn readings(system: &System, x: &[f64], u: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; system.outputs().len()];
    system.read(&mut Workspace::new(system), 0.0, x, u, &mut y);
    y
}

/// `x` moving along its derivative, as dual numbers.
pub(super) fn moving(system: &System, x: &[f64], u: &[f64]) -> Vec<Dual> {
    x.iter().zip(rates(system, x, u)).map(|(x, rate)| Dual::new(*x, rate)).collect()
}

pub(super) fn index(system: &System, name: &str) -> usize {
    system.states().iter().position(|state| state.name == name).unwrap_or_else(|| panic!("no state {name}"))
}

/// Classical Runge–Kutta, inputs held.
pub(super) fn integrate(system: &System, x: &mut [f64], u: &[f64], step_s: f64, steps: usize) {
    let (mut ws, mut scratch) = (Workspace::new(system), RungeKutta::new(x.len()));
    for step in 0..steps {
        let t = step as f64 * step_s;
        scratch.step(step_s, x, |share, at, x_dot| system.derivative(&mut ws, t + share * step_s, at, u, x_dot));
        system.normalise(x);
    }
}
