//! Forces and torques of each actuator from its input.

use super::System;
use super::effect_terms::body_state;
use super::sites::Coordinate;
use super::workspace::Workspace;
use crate::effect::{Action, Local, Pick};
use core::ops::Range;

/// How an input acts.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Acts {
    /// `gain × value` on a coordinate: a joint's torque, a motor's current, a wheel (gain −1: its
    /// torque is that on the body).
    Coordinate { coordinate: Coordinate, gain: f64 },
    /// `gain (value − back_emf × rate)` on a joint: a motor's voltage.
    Voltage { coordinate: Coordinate, gain: f64, back_emf: f64 },
    /// `value ×` this wrench (torque, force) on a body, its axes, at its origin; `force`: length of
    /// its force.
    Wrench { wrench: [f64; 6], force: f64 },
    /// The joint's position, rate and acceleration are the inputs.
    Joint { coordinate: Coordinate },
    /// Displacement, velocity and acceleration of everything along this direction.
    Base { direction: [f64; 3] },
}

/// One actuator.
#[derive(Clone, Debug)]
pub(super) struct Actuation {
    pub acts: Acts,
    /// Its first input.
    pub input: usize,
    /// The body it belongs to: of a joint's, the outboard one.
    pub link: usize,
    /// Its effects in `EffectTerms::actuators`.
    pub effects: Range<usize>,
    /// The part of the acting value that counts as firing: see [`fired`](crate::effect::fired).
    pub one_sided: bool,
    pub quiet: f64,
}

impl System {
    /// Efforts anew, adds wrenches, sets accelerations of prescribed joints and the motion of the
    /// base.
    #[inline]
    pub(super) fn apply_actuators<T: Pick>(&self, ws: &mut Workspace<T>, t_s: f64, x: &[T], u: &[T]) {
        ws.effort.fill(T::zero());
        if self.pushed {
            ws.thrust.fill(T::zero());
        }
        for actuator in &self.actuators {
            let value = if actuator.effects.is_empty() {
                u[actuator.input]
            } else {
                self.actuator_effects(ws, t_s, x, actuator, u[actuator.input])
            };
            match &actuator.acts {
                Acts::Coordinate { coordinate, gain } => ws.effort[coordinate.v] += value.scale(*gain),
                Acts::Voltage { coordinate, gain, back_emf } => {
                    let induced = ws.velocity[coordinate.v].scale(*back_emf);
                    ws.effort[coordinate.v] += (value - induced).scale(*gain);
                }
                Acts::Wrench { wrench, force } => {
                    let fired = crate::effect::fired(value, actuator.one_sided, actuator.quiet);
                    ws.thrust[actuator.link] += fired.scale(*force);
                    for (sum, part) in ws.wrench[actuator.link].iter_mut().zip(wrench) {
                        *sum += value.scale(*part);
                    }
                }
                Acts::Joint { coordinate } => ws.acceleration[coordinate.v] = u[actuator.input + 2],
                Acts::Base { .. } => {}
            }
        }
    }

    /// The acting value after all laws; their wrenches go to the actuator's body, their hidden
    /// rates to their places.
    fn actuator_effects<T: Pick>(
        &self,
        ws: &mut Workspace<T>,
        t_s: f64,
        x: &[T],
        actuator: &Actuation,
        command: T,
    ) -> T {
        let mut action = Action { value: command, ..Action::default() };
        for term in &self.effects.actuators[actuator.effects.clone()] {
            let body = body_state(ws, term.link);
            let local = Local { command, ..self.local(ws, t_s, x, term, &body) };
            (T::pick(&term.law))(&local, &term.values, &mut action);
            term.keep_hidden_rates(ws, &mut action);
        }
        for (sum, part) in ws.wrench[actuator.link].iter_mut().zip(action.wrench) {
            *sum += part;
        }
        action.value
    }
}
