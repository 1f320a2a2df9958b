//! Readings of sensors that average over an interval.
//!
//! A rate gyro returns the turn of its body divided by the interval, an accelerometer the increment
//! of inertial velocity (less that of free fall) divided by the interval, in body axes at the
//! attitude half way. Both follow from the states at the two ends alone. Other sensors return the
//! mean of both ends.

use super::System;
use super::geometry::{along, rotation_vector, subtract, times, transposed_product};
use super::sensors::{Measured, SensorTerm};
use super::workspace::{Begin, Workspace};
use crate::description::Reading;
use crate::effect::Pick;

impl System {
    /// Readings of sensors with [`Reading::Mean`] over `[t_s, t_s + dt_s]` from the states at both
    /// ends; the other numbers of `y` are left alone. `u_end` differs from `u` in prescribed
    /// motions only.
    ///
    /// Laws of effects on such sensors see the mean as reading and the state at the end of the
    /// interval.
    #[allow(clippy::too_many_arguments)] // two ends of an interval
    pub fn read_mean<T: Pick>(
        &self,
        ws: &mut Workspace<T>,
        t_s: f64,
        dt_s: f64,
        x: &[T],
        u: &[T],
        x_end: &[T],
        u_end: &[T],
        y: &mut [T],
    ) {
        assert!(dt_s > 0.0);
        assert!(y.len() == self.sensors.len());
        self.arrive(ws, t_s, x, u);
        for (k, sensor) in self.sensors.iter().enumerate().filter(|(_, sensor)| sensor.reading == Reading::Mean) {
            ws.begin[k] = self.instant(ws, sensor);
        }
        self.arrive(ws, t_s + dt_s, x_end, u_end);
        for (k, sensor) in self.sensors.iter().enumerate().filter(|(_, sensor)| sensor.reading == Reading::Mean) {
            let value = self.mean(ws, sensor, &ws.begin[k], dt_s);
            y[k] = self.disturbed_reading(ws, t_s + dt_s, x_end, sensor, value);
        }
    }

    /// Kinematics, and dynamics only where somebody needs accelerations.
    fn arrive<T: Pick>(&self, ws: &mut Workspace<T>, t_s: f64, x: &[T], u: &[T]) {
        if self.sensors.iter().any(SensorTerm::mean_needs_dynamics) {
            self.evaluate(ws, t_s, x, u);
        } else {
            self.place(ws, x, u);
        }
    }

    fn instant<T: Pick>(&self, ws: &Workspace<T>, sensor: &SensorTerm) -> Begin<T> {
        match &sensor.measured {
            Measured::Gyro { link, angle, .. } => Begin {
                rotation: ws.data.link_pose(*link).1,
                value: angle.as_ref().map_or(T::zero(), |angle| angle.value(&ws.position)),
                ..Begin::default()
            },
            Measured::Accelerometer { link, point, flexure, .. } => Begin {
                rotation: ws.data.link_pose(*link).1,
                velocity: self.inertial_velocity(ws, *link, point, flexure),
                ..Begin::default()
            },
            _ => Begin { value: self.measured(ws, sensor), ..Begin::default() },
        }
    }

    fn mean<T: Pick>(&self, ws: &Workspace<T>, sensor: &SensorTerm, begin: &Begin<T>, dt_s: f64) -> T {
        match &sensor.measured {
            Measured::Gyro { axis, angle: Some(angle), .. } => {
                (angle.value(&ws.position) - begin.value).scale(axis[2] / dt_s)
            }
            Measured::Gyro { link, axis, angle: None } => {
                let turned = transposed_product(&begin.rotation, &ws.data.link_pose(*link).1);
                along(rotation_vector(&turned), axis).scale(1.0 / dt_s)
            }
            Measured::Accelerometer { link, point, axis, flexure } => {
                let gained = subtract(self.inertial_velocity(ws, *link, point, flexure), begin.velocity);
                let fallen = self.environment.constants.gravity_m_s2.map(|g| T::constant(g * dt_s));
                let turned = transposed_product(&begin.rotation, &ws.data.link_pose(*link).1);
                let half = times(rotation_vector(&turned), T::constant(0.5));
                along(Self::seen_from(&begin.rotation, half, subtract(gained, fallen)), axis).scale(1.0 / dt_s)
            }
            _ => (begin.value + self.measured(ws, sensor)).scale(0.5),
        }
    }
}
