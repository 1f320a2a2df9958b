//! Meaning of every component of the state, input and output vectors.

use crate::real::Real;

/// A state's name: `joint:NAME`, `body:NAME.x`, `tank:NAME`, `mode:NAME`, with `.rate` for its
/// rate; `wheel:ACTUATOR`; `KIND@SITE.1` for a hidden state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateName {
    pub name: String,
    pub unit: &'static str,
}

/// Meaning of one component of `u`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputRole {
    /// Command of the actuator.
    Command,
    /// Of a prescribed coordinate: position, rate and acceleration are three inputs, in this order,
    /// and must belong together.
    Position,
    Rate,
    Acceleration,
}

/// One component of `u`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputName {
    /// Of the actuator; prescribed motions add `.position`, `.rate`, `.acceleration`.
    pub name: String,
    pub unit: &'static str,
    /// Index in `Plant::actuators`.
    pub actuator: usize,
    pub role: InputRole,
}

/// One component of `y`; one per sensor, in the order of the sensors.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputName {
    pub name: String,
    pub unit: &'static str,
}

/// A joint whose motion is an input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PrescribedJoint {
    /// In the model's position and velocity.
    pub q: usize,
    pub v: usize,
    /// First of its three inputs.
    pub input: usize,
}

/// Maps between the state vector and the model's coordinates.
#[derive(Clone, Debug, Default)]
pub(super) struct Layout {
    pub states: Vec<StateName>,
    pub inputs: Vec<InputName>,
    pub outputs: Vec<OutputName>,
    /// Numbers in the model's position, modal coordinates, and numbers in the model's velocity.
    pub q_len: usize,
    pub modes: usize,
    pub v_len: usize,
    pub hidden: usize,
    /// First modal rate in the velocity.
    pub mode_rate: usize,
    pub prescribed: Vec<PrescribedJoint>,
    /// Per velocity coordinate.
    pub prescribed_flags: Vec<bool>,
    /// Position (model's, then modal coordinates) of each position state, velocity of each velocity
    /// state; used where a joint is prescribed.
    pub free_positions: Vec<usize>,
    pub free_velocities: Vec<usize>,
    /// First state of each quaternion.
    pub quaternions: Vec<usize>,
}

impl Layout {
    /// Number of position coordinates in the state.
    pub fn positions(&self) -> usize {
        self.free_positions.len()
    }

    /// Number of velocity coordinates in the state.
    pub fn velocities(&self) -> usize {
        self.free_velocities.len()
    }

    /// First hidden state.
    pub fn hidden_at(&self) -> usize {
        self.positions() + self.velocities()
    }

    /// Length of the state vector, hidden states included.
    pub fn states_len(&self) -> usize {
        self.hidden_at() + self.hidden
    }

    /// Position and velocity of the model from state and input.
    #[inline]
    pub fn scatter<T: Real>(&self, x: &[T], u: &[T], position: &mut [T], velocity: &mut [T]) {
        assert!(x.len() == self.states_len());
        assert!(u.len() == self.inputs.len());
        let (positions, rest) = x.split_at(self.positions());
        let velocities = &rest[..self.velocities()];
        if self.prescribed.is_empty() {
            position.copy_from_slice(positions);
            velocity.copy_from_slice(velocities);
            return;
        }
        for (at, value) in self.free_positions.iter().zip(positions) {
            position[*at] = *value;
        }
        for (at, value) in self.free_velocities.iter().zip(velocities) {
            velocity[*at] = *value;
        }
        for joint in &self.prescribed {
            position[joint.q] = u[joint.input];
            velocity[joint.v] = u[joint.input + 1];
        }
    }

    /// Rates of state from rates of position and velocity.
    #[inline]
    pub fn gather<T: Real>(&self, position_rate: &[T], acceleration: &[T], x_dot: &mut [T]) {
        let (positions, velocities) = x_dot[..self.hidden_at()].split_at_mut(self.positions());
        if self.prescribed.is_empty() {
            positions.copy_from_slice(position_rate);
            velocities.copy_from_slice(acceleration);
            return;
        }
        for (at, value) in self.free_positions.iter().zip(positions) {
            *value = position_rate[*at];
        }
        for (at, value) in self.free_velocities.iter().zip(velocities) {
            *value = acceleration[*at];
        }
    }
}
