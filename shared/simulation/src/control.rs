//! Controllers: sampled PID on noisy readings, with a share of the nominal plant's inverse dynamics
//! fed forward.
//!
//! `u = kp (r − y) + ki Σ (r − y) T + kd (r' − y') + share · torque(r, r', r'')`. The sum includes
//! the present error; y' is a measured rate; a loop without reference rate takes r' = 0.

use super::SimulationError;
use super::excitation::ExcitedClock;
use dynamics::description::{Actuator, ActuatorKind, Controller, Drive, Plant};
use dynamics::signal::{SignalSum, SignalValue};
use dynamics::system::{JointReference, System, Workspace};

/// What a generalised force and a joint rate ask of the actuator.
#[derive(Clone, Copy, Debug)]
struct Effort {
    /// Index among the references.
    reference: usize,
    share: f64,
    /// Command per unit of force, and per unit of rate.
    per_force: f64,
    per_rate: f64,
}

#[derive(Clone, Debug)]
struct Loop {
    actuator: usize,
    position_sensor: Option<usize>,
    rate_sensor: Option<usize>,
    gains: [f64; 3],
    reference: SignalSum,
    follows_rate: bool,
    joint: Option<String>,
    feed_forward: Option<Effort>,
}

/// What the controllers believe the plant to be: as it is described, without its effects.
#[derive(Clone)]
struct Nominal {
    system: System,
    workspace: Workspace<f64>,
}

/// All controllers of a plant.
#[derive(Clone)]
pub(crate) struct Controllers {
    /// Where some loop feeds forward.
    nominal: Option<Nominal>,
    loops: Vec<Loop>,
    targets: Vec<SignalValue>,
    references: Vec<JointReference>,
    /// Loop that owns each reference.
    owners: Vec<usize>,
    forces: Vec<f64>,
    momentum_com_n_m_s: [f64; 3],
}

impl Controllers {
    /// The controllers of a plant; feed-forward works on the plant without its effects.
    ///
    /// # Errors
    /// [`SimulationError`] where the equations for feed-forward cannot be set up.
    pub fn new(plant: &Plant) -> Result<Self, SimulationError> {
        let feeds_forward = plant.controllers.iter().any(|controller| controller.feed_forward.value != 0.0);
        let nominal = if feeds_forward { Some(System::new(&plant.without_effects())?) } else { None };
        let mut controllers = Self {
            nominal: nominal.map(|system| Nominal { workspace: Workspace::new(&system), system }),
            loops: Vec::new(),
            targets: vec![SignalValue::default(); plant.controllers.len()],
            references: Vec::new(),
            owners: Vec::new(),
            forces: Vec::new(),
            momentum_com_n_m_s: plant.initial.momentum_com_n_m_s.map_or([0.0; 3], |h| h.map(|h| h.value)),
        };
        for description in &plant.controllers {
            let mut closed = Loop::new(plant, description)?;
            let reference = controllers.reference(&closed);
            closed.feed_forward = feed_forward(plant, description, closed.actuator, reference)?;
            controllers.loops.push(closed);
        }
        controllers.forces = vec![0.0; controllers.references.len()];
        Ok(controllers)
    }

    /// Index of the reference of the loop's joint, made where there is none.
    fn reference(&mut self, closed: &Loop) -> Option<usize> {
        let joint = self.nominal.as_ref()?.system.joint(closed.joint.as_deref()?)?;
        if let Some(known) = self.references.iter().position(|reference| reference.joint == joint) {
            return Some(known);
        }
        self.references.push(JointReference { joint, position: 0.0, rate: 0.0, acceleration: 0.0 });
        self.owners.push(self.loops.len());
        Some(self.references.len() - 1)
    }

    /// Controllers of the plant.
    pub fn len(&self) -> usize {
        self.loops.len()
    }

    /// Sensors that some loop reads.
    pub fn sensors(&self) -> impl Iterator<Item = usize> + '_ {
        self.loops.iter().flat_map(|closed| closed.position_sensor.into_iter().chain(closed.rate_sensor))
    }

    /// Position and rate of the reference of joint `name` at the excited time `t_s`.
    pub fn joint_reference(&self, name: &str, t_s: f64) -> Option<(f64, f64)> {
        let closed = self.loops.iter().find(|closed| closed.joint.as_deref() == Some(name))?;
        let at = closed.reference.at(t_s);
        Some((at.value, at.rate))
    }

    /// Adds what every loop commands to `commands`, one per actuator.
    pub fn command(
        &mut self,
        clock: &ExcitedClock,
        period_s: f64,
        readings: &[f64],
        integrals: &mut [f64],
        commands: &mut [f64],
    ) {
        for (target, closed) in self.targets.iter_mut().zip(&self.loops) {
            *target = closed.reference.at(clock.excited_begin_s);
            if !clock.running {
                *target = SignalValue { value: target.value, rate: 0.0, acceleration: 0.0 };
            }
        }
        self.feed_forward();
        for ((closed, target), integral) in self.loops.iter().zip(&self.targets).zip(integrals) {
            let mut command = closed.feedback(target, period_s, readings, integral);
            if let Some(effort) = &closed.feed_forward {
                let force = self.forces[effort.reference];
                command += effort.share * (effort.per_force * force + effort.per_rate * target.rate);
            }
            commands[closed.actuator] += command;
        }
    }

    fn feed_forward(&mut self) {
        let Some(Nominal { system, workspace }) = &mut self.nominal else { return };
        for (reference, owner) in self.references.iter_mut().zip(&self.owners) {
            let target = &self.targets[*owner];
            (reference.position, reference.rate) = (target.value, target.rate);
            reference.acceleration = target.acceleration;
        }
        system.feed_forward(workspace, &self.references, self.momentum_com_n_m_s, &mut self.forces);
    }
}

impl Loop {
    fn new(plant: &Plant, description: &Controller) -> Result<Self, SimulationError> {
        let refuse = |why: String| SimulationError::Controller { controller: description.name.clone(), why };
        let actuator = plant.actuators.iter().position(|actuator| actuator.name == description.actuator);
        let actuator = actuator.ok_or_else(|| refuse(format!("there is no actuator '{}'", description.actuator)))?;
        let sensor = |name: &Option<String>| match name {
            None => Ok(None),
            Some(name) => {
                let found = plant.sensors.iter().position(|sensor| sensor.name == *name);
                found.map(Some).ok_or_else(|| refuse(format!("there is no sensor '{name}'")))
            }
        };
        let (position_sensor, rate_sensor) = (sensor(&description.position_sensor)?, sensor(&description.rate_sensor)?);
        let gains = [description.kp.value, description.ki.value, description.kd.value];
        if position_sensor.is_none() && (gains[0] != 0.0 || gains[1] != 0.0) {
            return Err(refuse("kp and ki need a position sensor".to_owned()));
        }
        if rate_sensor.is_none() && gains[2] != 0.0 {
            return Err(refuse("kd needs a rate sensor".to_owned()));
        }
        let of = format!("controller '{}'", description.name);
        Ok(Self {
            actuator,
            position_sensor,
            rate_sensor,
            gains,
            reference: SignalSum::new(&description.reference, plant.simulation.duration_s, &of)?,
            follows_rate: description.reference_rate,
            joint: joint(&plant.actuators[actuator]).map(str::to_owned),
            feed_forward: None,
        })
    }

    fn feedback(&self, target: &SignalValue, period_s: f64, readings: &[f64], integral: &mut f64) -> f64 {
        let [kp, ki, kd] = self.gains;
        let mut command = 0.0;
        if let Some(sensor) = self.position_sensor {
            let error = target.value - readings[sensor];
            *integral += error * period_s;
            command += kp * error + ki * *integral;
        }
        if let Some(sensor) = self.rate_sensor {
            let rate = if self.follows_rate { target.rate } else { 0.0 };
            command += kd * (rate - readings[sensor]);
        }
        command
    }
}

fn joint(actuator: &Actuator) -> Option<&str> {
    match &actuator.kind {
        ActuatorKind::JointTorque { joint } | ActuatorKind::Motor { joint, .. } => Some(joint),
        _ => None,
    }
}

/// How much of the inverse dynamics the loop commands, in the unit of its actuator.
fn feed_forward(
    plant: &Plant,
    description: &Controller,
    actuator: usize,
    reference: Option<usize>,
) -> Result<Option<Effort>, SimulationError> {
    let share = description.feed_forward.value;
    if share == 0.0 {
        return Ok(None);
    }
    let why = "feed-forward needs an actuator in a joint with one degree of freedom".to_owned();
    let reference = reference.ok_or(SimulationError::Controller { controller: description.name.clone(), why })?;
    let (per_force, per_rate) = match &plant.actuators[actuator].kind {
        ActuatorKind::Motor { constant_n_m_a, gear, drive, .. } => {
            let per_ampere = constant_n_m_a.value * gear.value;
            match drive {
                Drive::Current => (1.0 / per_ampere, 0.0),
                Drive::Voltage { resistance_ohm, back_emf_v_s_rad } => {
                    (resistance_ohm.value / per_ampere, back_emf_v_s_rad.value * gear.value)
                }
            }
        }
        _ => (1.0, 0.0),
    };
    Ok(Some(Effort { reference, share, per_force, per_rate }))
}
