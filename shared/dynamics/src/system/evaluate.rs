//! One evaluation of the equations: forces, accelerations, rates of state.

use super::System;
use super::sensors::Reach;
use super::workspace::Workspace;
use crate::effect::Pick;
use crate::multibody::{
    forward_dynamics_after_kinematics, forward_dynamics_prescribed_after_kinematics, kinematics,
    position_rate_after_kinematics,
};

impl System {
    /// `x' = f(t, x, u)`.
    ///
    /// Cost: one articulated-body pass and a walk over springs, actuators and effects; no
    /// allocation.
    pub fn derivative<T: Pick>(&self, ws: &mut Workspace<T>, t_s: f64, x: &[T], u: &[T], x_dot: &mut [T]) {
        if let Some(lightness) = &self.lightness_apart {
            return self.derivative_apart(ws, lightness, (t_s, x, u), x_dot);
        }
        self.evaluate(ws, t_s, x, u);
        self.hidden_rates_of_sensors(ws, t_s, x);
        self.write_rates(ws, x_dot);
    }

    /// `y = h(t, x, u)`: the reading of every sensor at the instant, without noise, range,
    /// quantisation, filter and delay.
    ///
    /// Cost: as much of the equations as the sensors take; no allocation.
    pub fn read<T: Pick>(&self, ws: &mut Workspace<T>, t_s: f64, x: &[T], u: &[T], y: &mut [T]) {
        self.prepare(ws, t_s, x, u, self.reach);
        self.write_readings(ws, t_s, x, y);
    }

    /// [`read`](Self::read) of the sensors `outputs` alone; the others stay as they are in `y`.
    ///
    /// Cost: as much of the equations as these sensors take; no allocation.
    pub fn read_some<T: Pick>(
        &self,
        ws: &mut Workspace<T>,
        t_s: f64,
        x: &[T],
        u: &[T],
        outputs: &[usize],
        y: &mut [T],
    ) {
        let reach = |output: &usize| self.sensors[*output].reach(&self.layout.prescribed_flags);
        self.prepare(ws, t_s, x, u, outputs.iter().map(reach).fold(self.lowest_reach(), Reach::max));
        self.write_some(ws, t_s, x, outputs, y);
    }

    /// Laws of actuators look at links.
    fn lowest_reach(&self) -> Reach {
        if self.effects.actuators.is_empty() { Reach::State } else { Reach::Motion }
    }

    /// As much of the equations as a reading of this reach takes.
    fn prepare<T: Pick>(&self, ws: &mut Workspace<T>, t_s: f64, x: &[T], u: &[T], reach: Reach) {
        match reach {
            Reach::State => self.layout.scatter(x, u, &mut ws.position, &mut ws.velocity),
            Reach::Efforts => {
                self.layout.scatter(x, u, &mut ws.position, &mut ws.velocity);
                self.apply_actuators(ws, t_s, x, u);
            }
            Reach::Motion => {
                self.place(ws, x, u);
                self.apply_actuators(ws, t_s, x, u);
            }
            Reach::Accelerations => self.evaluate(ws, t_s, x, u),
        }
    }

    /// [`derivative`](Self::derivative) and [`read`](Self::read) at the cost of one.
    pub fn derivative_and_read<T: Pick>(
        &self,
        ws: &mut Workspace<T>,
        t_s: f64,
        x: &[T],
        u: &[T],
        x_dot: &mut [T],
        y: &mut [T],
    ) {
        self.evaluate(ws, t_s, x, u);
        self.write_readings(ws, t_s, x, y);
        self.write_rates(ws, x_dot);
    }

    /// Poses and velocities of all links.
    #[inline]
    pub(super) fn place<T: Pick>(&self, ws: &mut Workspace<T>, x: &[T], u: &[T]) {
        self.layout.scatter(x, u, &mut ws.position, &mut ws.velocity);
        self.move_base(ws, u);
        self.bend(ws);
        kinematics(&self.model, &mut ws.data, &ws.position[..self.layout.q_len], &ws.velocity);
    }

    /// Tells the links how modes shift their centre of mass.
    #[inline]
    pub(super) fn bend<T: Pick>(&self, ws: &mut Workspace<T>) {
        if self.layout.modes > 0 {
            ws.data.set_internal_positions(&self.model, &ws.position[self.layout.q_len..]);
        }
    }

    /// Everything up to accelerations.
    pub(super) fn evaluate<T: Pick>(&self, ws: &mut Workspace<T>, t_s: f64, x: &[T], u: &[T]) {
        self.place(ws, x, u);
        self.apply_forces(ws, t_s, x, u);
        let (model, flags) = (&self.model, &self.layout.prescribed_flags);
        let wrench = if self.pushed { ws.wrench.as_slice() } else { &[] };
        if self.layout.prescribed.is_empty() {
            let (data, acceleration) = (&mut ws.data, &mut ws.acceleration);
            forward_dynamics_after_kinematics(model, data, &ws.velocity, &ws.tau, wrench, acceleration);
            return;
        }
        for joint in &self.layout.prescribed {
            ws.effort[joint.v] = ws.tau[joint.v];
        }
        forward_dynamics_prescribed_after_kinematics(
            model,
            &mut ws.data,
            &ws.velocity,
            flags,
            &mut ws.tau,
            wrench,
            &mut ws.acceleration,
        );
        for joint in &self.layout.prescribed {
            // what the drive must add to springs, friction and effects
            ws.effort[joint.v] = ws.tau[joint.v] - ws.effort[joint.v];
        }
    }

    /// Efforts and wrenches of everything that acts, where the links are placed.
    #[inline]
    pub(super) fn apply_forces<T: Pick>(&self, ws: &mut Workspace<T>, t_s: f64, x: &[T], u: &[T]) {
        if self.pushed {
            ws.wrench.fill([T::zero(); 6]);
        }
        self.apply_actuators(ws, t_s, x, u);
        ws.tau.copy_from_slice(&ws.effort);
        self.apply_passive(ws);
        self.apply_environment(ws, t_s);
        self.apply_effects(ws, t_s, x);
    }

    #[inline]
    pub(super) fn write_rates<T: Pick>(&self, ws: &mut Workspace<T>, x_dot: &mut [T]) {
        let layout = &self.layout;
        assert!(x_dot.len() == layout.states_len());
        let q = &ws.position[..layout.q_len];
        let modal_rates = &ws.velocity[layout.mode_rate..layout.mode_rate + layout.modes];
        if layout.prescribed.is_empty() {
            let (joints, rest) = x_dot.split_at_mut(layout.q_len);
            position_rate_after_kinematics(&self.model, &ws.data, q, &ws.velocity, joints);
            if layout.modes > 0 {
                rest[..layout.modes].copy_from_slice(modal_rates);
            }
            rest[layout.modes..layout.modes + layout.v_len].copy_from_slice(&ws.acceleration);
        } else {
            let (joints, modes) = ws.position_rate.split_at_mut(layout.q_len);
            position_rate_after_kinematics(&self.model, &ws.data, q, &ws.velocity, joints);
            modes.copy_from_slice(modal_rates);
            layout.gather(&ws.position_rate, &ws.acceleration, x_dot);
        }
        if layout.hidden > 0 {
            x_dot[layout.hidden_at()..].copy_from_slice(&ws.hidden_rate);
        }
    }
}
