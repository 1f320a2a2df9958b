//! The plant as a predictor of its own recording: extended Kalman filter, frozen gains, innovations.
//!
//! ```text
//! z = [δx | w | ℓ | x at the beginning of a mean | v]      state, actuator noise held between switches, lags of sensors, AR(1) noise
//! ν_k = y_k − h(x̂_k, u_k + ŵ_k),   z ← z ⊕ K_k ν_k,   x ← flow(x, u + ŵ)
//! ```
//!
//! An accelerometer feels what its actuators do; with the held noise w among the states this correlation needs no special form.
//! The nonlinear pass uses gains K that are frozen for a fit. [`Linear`] keeps what is linear about it: transitions and rows of
//! measurement by differences of the very functions of the pass. Noise of another size or colour then needs no nonlinear pass: the
//! [`Gains`] of any noise follow from a Riccati recursion on `Linear`, and [`whiten`] turns the innovations of the frozen filter
//! (and every column of sensitivities) into those of the new one, exactly as far as the plant is linear.
//!
//! Process noise: what the plant states of its actuators, and a disturbance at every joint and free body that nothing drives, at first
//! far below what the sensors see.

mod attitude;
mod equations;
mod gains;
mod gradient;
mod initial;
mod lagged;
mod linear;
mod machine;
mod noise_model;
mod transition;
mod whiten;
mod wide;

pub use equations::{crossed, products};
pub use gains::{Gains, gains};
pub use gradient::{Gradient, Slope, gradient};
pub use initial::Start;
pub use linear::{Linear, linearise};
pub(crate) use machine::step_s;
pub use machine::{Frozen, Machine};
pub use noise_model::NoiseModel;
pub use whiten::whiten;

use dynamics::description::{Actuator, ActuatorKind, Initial, JointKind, Plant, Quantity, TankModel};

/// Places of the parts of z.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// Numbers of a small change of state.
    pub tangent: usize,
    /// Noise inputs: index in `u` of each.
    pub noise_inputs: Vec<usize>,
    /// Per channel: place among lags, if it lags.
    pub lag_of: Vec<Option<usize>>,
    pub lags: usize,
    /// Numbers of the clone: `tangent` or none.
    pub clone: usize,
    /// Per channel: place among coloured noises.
    pub colour_of: Vec<Option<usize>>,
    pub colours: usize,
}

impl Layout {
    pub fn noise_at(&self) -> usize {
        self.tangent
    }

    pub fn lags_at(&self) -> usize {
        self.tangent + self.noise_inputs.len()
    }

    pub fn clone_at(&self) -> usize {
        self.lags_at() + self.lags
    }

    pub fn colours_at(&self) -> usize {
        self.clone_at() + self.clone
    }

    pub fn len(&self) -> usize {
        self.colours_at() + self.colours
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Places in z of the numbers of a row of measurement.
    fn places<'r>(&self, row: &'r [f64]) -> impl Iterator<Item = (usize, f64)> + use<'r> {
        let (before, clone_at) = (self.lags_at(), self.clone_at());
        row.iter().enumerate().map(move |(i, h)| (if i < before { i } else { clone_at + i - before }, *h))
    }
}

/// Prefix of the actuators that stand for disturbances.
pub const DISTURBANCE: &str = "disturbance_";

/// `plant` with an actuator for the disturbance of everything that moves and that no actuator drives.
#[must_use]
pub fn equip(plant: &Plant) -> Plant {
    let mut equipped = plant.clone();
    let drives = |name: &str| {
        plant.actuators.iter().any(|actuator| match &actuator.kind {
            ActuatorKind::JointTorque { joint } | ActuatorKind::Motor { joint, .. } => joint == name,
            ActuatorKind::PrescribedJoint { joint, .. } => joint == name,
            _ => false,
        })
    };
    let pushes = |name: &str| {
        plant.actuators.iter().any(|actuator| match &actuator.kind {
            ActuatorKind::BodyForce { body, .. } | ActuatorKind::BodyTorque { body, .. } => body == name,
            ActuatorKind::Thruster { body, .. } | ActuatorKind::Wheel { body, .. } => body == name,
            _ => false,
        })
    };
    let zero = Quantity::known(0.0);
    let mut add = |name: String, kind: ActuatorKind| {
        equipped.actuators.push(Actuator {
            name: format!("{DISTURBANCE}{name}"),
            kind,
            command: Vec::new(),
            noise: zero,
            range: None,
            recorded: false,
        })
    };
    let planar = plant.space == dynamics::description::Space::Planar;
    for body in &plant.bodies {
        match body.joint.kind {
            JointKind::Revolute { .. } | JointKind::Prismatic { .. } if !drives(&body.joint.name) => {
                add(body.joint.name.clone(), ActuatorKind::JointTorque { joint: body.joint.name.clone() });
            }
            JointKind::Free if !pushes(&body.name) => {
                let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                for (k, axis) in axes.into_iter().enumerate() {
                    let letter = ["x", "y", "z"][k];
                    if !planar || k < 2 {
                        let kind = ActuatorKind::BodyForce {
                            body: body.name.clone(),
                            position_m: body.com_m,
                            direction: axis,
                        };
                        add(format!("{}_force_{letter}", body.name), kind);
                    }
                    if !planar || k == 2 {
                        let kind = ActuatorKind::BodyTorque { body: body.name.clone(), direction: axis };
                        add(format!("{}_torque_{letter}", body.name), kind);
                    }
                }
            }
            _ => {}
        }
    }
    equipped
}

/// Prior standard deviation of every number of a small change of the initial state: stated, else as `hardly_seen` has it, else wide by
/// its unit.
pub fn initial_sigmas(
    plant: &Plant,
    system: &dynamics::system::System,
    initial: &Initial,
    hardly_seen: &[(String, f64)],
) -> Vec<f64> {
    let names = tangent_names(system);
    let stated = |name: &str| {
        let (coordinate, rate) = name.strip_suffix(".rate").map_or((name, false), |n| (n, true));
        let value = initial.values.iter().find(|value| value.coordinate == coordinate)?;
        let quantity = if rate { value.rate } else { value.position };
        // an angle of a free body is stated as a rotation vector, its tangent is one too
        quantity.sigma
    };
    let unstated = |name: &str, unit: &str| {
        let hardly = hardly_seen.iter().find(|(own, _)| own == name);
        hardly.map_or_else(|| wide(plant, name, unit), |(_, sigma)| *sigma)
    };
    names.iter().map(|(name, unit)| stated(name).unwrap_or_else(|| unstated(name, unit))).collect()
}

/// Largest free motion of a slosh mass [m] or a mode [√kg m] that nobody stated.
const FREE_MOTION: f64 = 0.3;

fn wide(plant: &Plant, name: &str, unit: &str) -> f64 {
    match (name.split(':').next().unwrap_or(""), unit) {
        // as much kinetic as potential energy: a slow mass at the rate of a fast one would leave the linear model at once
        ("tank" | "mode", _) if name.ends_with(".rate") => FREE_MOTION * natural_rate_rad_s(plant, name).unwrap_or(1.0),
        ("tank" | "mode", _) => FREE_MOTION,
        ("wheel", _) => 100.0,
        (_, "m") => 10.0,
        (_, "m/s") => 5.0,
        ("joint" | "body", "rad") => 1.0,
        ("joint" | "body", "rad/s") => 3.0,
        // hidden states of effects start at zero
        _ => 1e-6,
    }
}

/// Natural frequency of the tank (its stiffest direction) or mode that a state belongs to.
fn natural_rate_rad_s(plant: &Plant, state: &str) -> Option<f64> {
    let site = state.split(':').nth(1)?.split('.').next()?;
    let of_mode = plant.appendages.iter().flat_map(|appendage| &appendage.modes).find(|mode| mode.name == site);
    let tank = || {
        let tank = plant.tanks.iter().find(|tank| tank.name == site)?;
        match &tank.model {
            TankModel::Spring { stiffness_n_m, .. } => {
                let stiffest = stiffness_n_m.iter().map(|k| k.value).fold(0.0, f64::max);
                Some((stiffest / tank.mass_kg.value).sqrt())
            }
            TankModel::Pendulum { .. } => None,
        }
    };
    of_mode.map(|mode| core::f64::consts::TAU * mode.frequency_hz.value).or_else(tank).filter(|rate| rate.is_finite())
}

/// Name and unit of each number of a small change of state: those of the state; a quaternion's three are turns.
pub fn tangent_names(system: &dynamics::system::System) -> Vec<(String, &'static str)> {
    let mut names = Vec::new();
    for state in system.states() {
        if state.name.ends_with(".qw") {
            continue;
        }
        match state.name.strip_suffix(".qx").or(state.name.strip_suffix(".qy")).or(state.name.strip_suffix(".qz")) {
            Some(body) => {
                let axis = state.name.chars().last().unwrap_or('x');
                names.push((format!("{body}.r{axis}"), "rad"));
            }
            None => names.push((state.name.clone(), state.unit)),
        }
    }
    names
}

#[cfg(test)]
mod tests;
