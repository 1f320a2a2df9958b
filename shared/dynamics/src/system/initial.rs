//! State at the beginning of a record or segment.

use super::System;
use super::error::SystemError;
use super::geometry::{quaternion_of_vector, rotation_vector_of_quaternion, turn, turn_back};
use super::sites::{Coordinate, InitialPlace, NamedCoordinate};
use super::workspace::Workspace;
use crate::description::{Initial, InitialValue, Quantity, Space};
use crate::multibody::{float_at_momentum, momentum};

impl System {
    /// State at the beginning.
    ///
    /// `references` gives (position, rate) of prescribed joints and, where `initial.on_reference`,
    /// of controlled ones, by name of the joint; stated values go first for the controlled ones.
    /// Coordinates without a value are zero; hidden states are zero.
    ///
    /// # Errors
    /// A coordinate that does not exist, or a stated momentum of a system that does not float.
    pub fn initial_state(
        &self,
        initial: &Initial,
        references: &dyn Fn(&str) -> Option<(f64, f64)>,
    ) -> Result<Vec<f64>, SystemError> {
        let mut ws = Workspace::<f64>::new(self);
        self.level(&mut ws.position);
        self.take_references(&mut ws, initial, references);
        for place in &self.coordinates {
            if let InitialPlace::Wheel { v, speed_rad_s } = place.what {
                ws.velocity[v] = speed_rad_s;
            }
        }
        let mut turns = vec![[0.0; 3]; self.model.links_len()];
        for value in &initial.values {
            let (position, rate) = (value.position.value, value.rate.value);
            self.take_value(&mut ws, &value.coordinate, position, rate, &mut turns)?;
        }
        self.turn_free_bodies(&mut ws, &turns);
        if let Some(wanted) = &initial.momentum_com_n_m_s {
            self.rest_centre_of_mass(&mut ws, wanted.map(|quantity| quantity.value))?;
        }
        let mut x = vec![0.0; self.states().len()];
        self.layout.gather(&ws.position, &ws.velocity, &mut x);
        Ok(x)
    }

    /// The values from which [`System::initial_state`] makes the state `x`, hidden states left out.
    pub fn initial_values(&self, x: &[f64]) -> Vec<InitialValue> {
        let mut ws = Workspace::<f64>::new(self);
        let u = vec![0.0; self.inputs().len()];
        self.layout.scatter(x, &u, &mut ws.position, &mut ws.velocity);
        crate::multibody::kinematics(&self.model, &mut ws.data, &ws.position[..self.layout.q_len], &ws.velocity);
        let of = |place: &NamedCoordinate| {
            let (position, rate) = match place.what {
                InitialPlace::Single(coordinate) if self.layout.prescribed_flags[coordinate.v] => return None,
                InitialPlace::Single(Coordinate { position, v }) => {
                    (position.map_or(0.0, |q| ws.position[q]), ws.velocity[v])
                }
                InitialPlace::Wheel { v, .. } => (0.0, ws.velocity[v]),
                InitialPlace::Free { link, axis } => self.of_free_body(&ws, link, axis),
            };
            let (position, rate) = (Quantity::known(position), Quantity::known(rate));
            Some(InitialValue { coordinate: place.name.clone(), position, rate })
        };
        self.coordinates.iter().filter_map(of).collect()
    }

    /// Position and rate of a free body along or about an axis, as an [`InitialValue`] states them.
    fn of_free_body(&self, ws: &Workspace<f64>, link: usize, axis: usize) -> (f64, f64) {
        let (q, v) = (self.model.q_index(link), self.model.v_index(link));
        let rotation = ws.data.link_pose(link).1;
        let planar = self.space == Space::Planar;
        let position = match axis {
            0..3 => ws.position[q + axis],
            _ if planar => ws.position[q + 2],
            _ => {
                let at = &ws.position[q + 3..q + 7];
                rotation_vector_of_quaternion([at[0], at[1], at[2], at[3]])[axis - 3]
            }
        };
        let rate = match axis {
            0..3 if planar => turn(&rotation, [ws.velocity[v + 1], ws.velocity[v + 2], 0.0])[axis],
            0..3 => turn(&rotation, [ws.velocity[v + 3], ws.velocity[v + 4], ws.velocity[v + 5]])[axis],
            _ => ws.velocity[v + self.free_rate(axis)],
        };
        (position, rate)
    }

    fn take_references(
        &self,
        ws: &mut Workspace<f64>,
        initial: &Initial,
        references: &dyn Fn(&str) -> Option<(f64, f64)>,
    ) {
        for joint in &self.joints {
            let Coordinate { position: Some(q), v } = joint.coordinate else { continue };
            if !(self.layout.prescribed_flags[v] || initial.on_reference) {
                continue;
            }
            if let Some((position, rate)) = references(&joint.name) {
                (ws.position[q], ws.velocity[v]) = (position, rate);
            }
        }
    }

    fn take_value(
        &self,
        ws: &mut Workspace<f64>,
        name: &str,
        position: f64,
        rate: f64,
        turns: &mut [[f64; 3]],
    ) -> Result<(), SystemError> {
        let failed = |reason| SystemError::Initial { coordinate: name.to_owned(), reason };
        let place = self.coordinates.iter().find(|place| place.name == name);
        match place.ok_or_else(|| failed("the plant has no such coordinate"))?.what {
            InitialPlace::Single(coordinate) if self.layout.prescribed_flags[coordinate.v] => {
                return Err(failed("its motion is prescribed"));
            }
            InitialPlace::Single(coordinate) => {
                if let Some(q) = coordinate.position {
                    ws.position[q] = position;
                }
                ws.velocity[coordinate.v] = rate;
            }
            InitialPlace::Wheel { v, .. } => ws.velocity[v] = rate,
            InitialPlace::Free { link, axis } if axis < 3 => {
                ws.position[self.model.q_index(link) + axis] = position;
                // inertial axes for now
                ws.velocity[self.model.v_index(link) + self.free_rate(axis)] = rate;
            }
            InitialPlace::Free { link, axis } => {
                turns[link][axis - 3] = position;
                ws.velocity[self.model.v_index(link) + self.free_rate(axis)] = rate;
            }
        }
        Ok(())
    }

    /// Place of x, y, z, rx, ry, rz in the velocity of a free body.
    fn free_rate(&self, axis: usize) -> usize {
        match self.space {
            Space::Planar => [1, 2, 0, 0, 0, 0][axis],
            Space::Spatial => (axis + 3) % 6,
        }
    }

    /// Attitudes from rotation vectors, and velocities from inertial to body axes.
    fn turn_free_bodies(&self, ws: &mut Workspace<f64>, turns: &[[f64; 3]]) {
        for (link, turn) in turns.iter().enumerate() {
            let (q, v) = (self.model.q_index(link), self.model.v_index(link));
            match self.model.joint_v_len(link) {
                3 => ws.position[q + 2] = turn[2],
                6 => ws.position[q + 3..q + 7].copy_from_slice(&quaternion_of_vector(*turn)),
                _ => continue,
            }
            let data = &mut ws.data;
            crate::multibody::kinematics(&self.model, data, &ws.position[..self.layout.q_len], &ws.velocity);
            let rotation = data.link_pose(link).1;
            if self.space == Space::Planar {
                let [x, y, _] = turn_back(&rotation, [ws.velocity[v + 1], ws.velocity[v + 2], 0.0]);
                (ws.velocity[v + 1], ws.velocity[v + 2]) = (x, y);
            } else {
                let body = turn_back(&rotation, [ws.velocity[v + 3], ws.velocity[v + 4], ws.velocity[v + 5]]);
                ws.velocity[v + 3..v + 6].copy_from_slice(&body);
            }
        }
    }

    /// Angular momentum about the centre of mass as wanted (inertial axes), the centre at rest in
    /// the origin.
    fn rest_centre_of_mass(&self, ws: &mut Workspace<f64>, wanted: [f64; 3]) -> Result<(), SystemError> {
        let q_len = self.layout.q_len;
        crate::multibody::kinematics(&self.model, &mut ws.data, &ws.position[..q_len], &ws.velocity);
        self.bend(ws);
        let base_axes = turn_back(&ws.data.link_pose(0).1, wanted);
        if !float_at_momentum(&self.model, &mut ws.data, &ws.position[..q_len], &mut ws.velocity, base_axes) {
            return Err(SystemError::NotFloating);
        }
        let com = momentum(&self.model, &mut ws.data, &ws.position[..q_len], &ws.velocity).com;
        let q = self.model.q_index(0);
        let axes = if self.space == Space::Planar { 2 } else { 3 };
        // the joint frame may be turned against inertial space
        let mounted = &self.model.links[0].rotation;
        let shift = mounted.apply_transposed(com.into()).array();
        for (at, shift) in ws.position[q..q + axes].iter_mut().zip(shift) {
            *at -= shift;
        }
        Ok(())
    }
}
