//! Readings of sensors at an instant.

use super::System;
use super::effect_terms::{accelerated, body_state};
use super::geometry::{add, along, cross, rotation_vector, times, turn, turn_back};
use super::sensors::{Flexure, Measured, SensorTerm};
use super::workspace::Workspace;
use crate::effect::{Action, Local, Pick};

impl System {
    /// Every reading, after [`evaluate`](Self::evaluate).
    pub(super) fn write_readings<T: Pick>(&self, ws: &mut Workspace<T>, t_s: f64, x: &[T], y: &mut [T]) {
        assert!(y.len() == self.sensors.len());
        for (sensor, y) in self.sensors.iter().zip(y) {
            let value = self.measured(ws, sensor);
            *y = self.disturbed_reading(ws, t_s, x, sensor, value);
        }
    }

    /// The readings `outputs` alone.
    pub(super) fn write_some<T: Pick>(&self, ws: &mut Workspace<T>, t_s: f64, x: &[T], outputs: &[usize], y: &mut [T]) {
        for output in outputs {
            let sensor = &self.sensors[*output];
            let value = self.measured(ws, sensor);
            y[*output] = self.disturbed_reading(ws, t_s, x, sensor, value);
        }
    }

    /// Rates of the hidden states that sensors own.
    #[inline]
    pub(super) fn hidden_rates_of_sensors<T: Pick>(&self, ws: &mut Workspace<T>, t_s: f64, x: &[T]) {
        for sensor in self.sensors.iter().filter(|sensor| sensor.hidden) {
            let value = self.measured(ws, sensor);
            self.disturbed_reading(ws, t_s, x, sensor, value);
        }
    }

    /// Scale, bias and effects on a true value.
    #[inline(always)]
    pub(super) fn disturbed_reading<T: Pick>(
        &self,
        ws: &mut Workspace<T>,
        t_s: f64,
        x: &[T],
        sensor: &SensorTerm,
        value: T,
    ) -> T {
        let reading = value.scale(1.0 + sensor.scale) + T::constant(sensor.bias);
        if sensor.effects.is_empty() { reading } else { self.with_effects(ws, t_s, x, sensor, reading) }
    }

    #[inline(never)]
    fn with_effects<T: Pick>(&self, ws: &mut Workspace<T>, t_s: f64, x: &[T], sensor: &SensorTerm, reading: T) -> T {
        let mut action = Action { value: reading, ..Action::default() };
        for term in &self.effects.sensors[sensor.effects.clone()] {
            let body = accelerated(ws, term.link, body_state(ws, term.link));
            let local = Local { reading: action.value, ..self.local(ws, t_s, x, term, &body) };
            (T::pick(&term.law))(&local, &term.values, &mut action);
            term.keep_hidden_rates(ws, &mut action);
        }
        action.value
    }

    /// The true value.
    pub(super) fn measured<T: Pick>(&self, ws: &Workspace<T>, sensor: &SensorTerm) -> T {
        match &sensor.measured {
            Measured::Gyro { axis, angle: Some(angle), .. } => angle.rate(&ws.velocity).scale(axis[2]),
            Measured::Gyro { link, axis, angle: None } => {
                let [x, y, z, ..] = ws.data.link_velocity(*link);
                along([x, y, z], axis)
            }
            Measured::Accelerometer { link, point, axis, flexure } => {
                along(self.specific_force(ws, *link, point, flexure), axis)
            }
            Measured::Coordinate(q) => ws.position[*q],
            Measured::Rate(v) => ws.velocity[*v],
            Measured::Effort(v) => ws.effort[*v],
            Measured::Force { link, axis } => {
                let [.., x, y, z] = ws.data.joint_wrench(*link);
                along([x, y, z], axis)
            }
            Measured::Torque { link, axis } => {
                let [x, y, z, ..] = ws.data.joint_wrench(*link);
                along([x, y, z], axis)
            }
            Measured::Position { link, point, axis } => {
                let position = ws.data.point_position(*link, point.map(T::constant));
                along(add(position, ws.base.position), axis)
            }
            Measured::Velocity { link, point, axis } => {
                let velocity = ws.data.point_velocity(*link, point.map(T::constant));
                along(add(turn(&ws.data.link_pose(*link).1, velocity), ws.base.velocity), axis)
            }
            Measured::Angle { axis_z, angle } => angle.value(&ws.position).scale(*axis_z),
            Measured::Attitude { link, axis } => along(rotation_vector(&ws.data.link_pose(*link).1), axis),
        }
    }

    /// Acceleration minus gravity of a point, body axes; a point of an appendage moves on it:
    /// `a + r'' + 2 ω × r'` at `p + r`.
    fn specific_force<T: Pick>(&self, ws: &Workspace<T>, link: usize, point: &[f64; 3], flexure: &[Flexure]) -> [T; 3] {
        if flexure.is_empty() {
            return ws.data.specific_force(link, point.map(T::constant));
        }
        let [x, y, z, ..] = ws.data.link_velocity(link);
        let (at, moving) = self.flexed(ws, point, flexure);
        let mut acceleration = ws.data.specific_force(link, at);
        for part in flexure {
            acceleration = add(acceleration, part.shape.map(|s| ws.acceleration[part.v].scale(s)));
        }
        add(acceleration, times(cross([x, y, z], moving), T::constant(2.0)))
    }

    /// Place and velocity on the body of a point of an appendage.
    pub(super) fn flexed<T: Pick>(&self, ws: &Workspace<T>, point: &[f64; 3], flexure: &[Flexure]) -> ([T; 3], [T; 3]) {
        let (mut at, mut moving) = (point.map(T::constant), [T::zero(); 3]);
        for part in flexure {
            at = add(at, part.shape.map(|s| ws.position[part.position].scale(s)));
            moving = add(moving, part.shape.map(|s| ws.velocity[part.v].scale(s)));
        }
        (at, moving)
    }

    /// Velocity of a point against inertial space, inertial axes.
    pub(super) fn inertial_velocity<T: Pick>(
        &self,
        ws: &Workspace<T>,
        link: usize,
        point: &[f64; 3],
        flexure: &[Flexure],
    ) -> [T; 3] {
        let rotation = ws.data.link_pose(link).1;
        let (at, moving) = self.flexed(ws, point, flexure);
        let velocity = add(ws.data.point_velocity(link, at), moving);
        add(turn(&rotation, velocity), ws.base.velocity)
    }

    /// An inertial vector in body axes at attitude `rotation` turned on by `phi` (body axes).
    pub(super) fn seen_from<T: Pick>(rotation: &[[T; 3]; 3], phi: [T; 3], vector: [T; 3]) -> [T; 3] {
        super::geometry::rotate_by_vector(phi.map(|p| -p), turn_back(rotation, vector))
    }
}
