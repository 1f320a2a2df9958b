//! Exhaust that hits the spacecraft.

use super::applies::thruster;
use super::geometry::{perpendicular, push};
use super::law::both;
use super::{Action, Effect, EffectParameter, Law, Local};
use crate::description::SiteKind;
use crate::real::Real;

pub static EFFECT: Effect = Effect {
    kind: "thruster_plume",
    title: "Plume impingement on the thruster's own body",
    sites: &[SiteKind::Actuator],
    applies: thruster,
    parameters: &[
        EffectParameter::new("fraction", "1", [0.0, 0.5], 0.03, "share c of the thrust that comes back"),
        EffectParameter::new("offset", "m", [-10.0, 10.0], 0.5, "distance of the surface aside of the thrust's line"),
        EffectParameter::new("clock", "rad", [-3.2, 3.2], 0.0, "side of the surface about the thrust; 0: z x thrust"),
    ],
    amplitudes: 1,
    hidden_states: 0,
    law: Law::Actuator(both!(law)),
    what: "A surface on the thruster's body takes the force -c F d at r + offset t; the distance along d does not matter. A surface on another \
           body (an arm in some pose) is a constant_force on that body while the thruster fires.",
    signature: "Less force and a torque in step with this thruster's command.",
    confounders: "motor_constant_error (its force), thruster_misalignment and com_shift (its torque).",
    experiment: "Fire with the appendage or arm in two poses; only impingement changes.",
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (fraction, offset) = (p[0], p[1]);
    let axis = local.surroundings.site_axis;
    let aside = perpendicular(axis, p[2]);
    let at = core::array::from_fn(|i| local.surroundings.site_position_m[i] + offset * aside[i]);
    let thrust = action.value;
    push(&mut action.wrench, at, axis.map(|d| thrust.scale(-fraction * d)), [T::zero(); 3]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::effects::trial::Trial;

    #[test]
    fn a_share_of_the_thrust_comes_back_on_its_arm() {
        let mut state = Trial { command: 10.0, ..Trial::default() };
        state.surroundings.site_axis = [1.0, 0.0, 0.0];
        state.surroundings.site_position_m = [-0.5, 0.2, 0.0];
        let w = state.wrench(&EFFECT, &[0.1, 2.0, 0.0]);
        // -1 N along x at y = 2.2 m: torque +2.2 N m about z
        assert_eq!(w, [0.0, 0.0, 2.2, -1.0, 0.0, 0.0].map(|x: f64| x + 0.0));
    }
}
