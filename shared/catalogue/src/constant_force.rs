//! A force that stays.

use super::geometry::{constant, push, to_body};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Constant force at a body's centre of mass, inertial axes.
pub static EFFECT: Effect = Effect {
    kind: "constant_force",
    title: "Constant force on a body",
    sites: &[SiteKind::Body],
    parameters: &[
        EffectParameter::new("force_x", "N", [-1e3, 1e3], 0.05, "force F, inertial x").amplitude(),
        EffectParameter::new("force_y", "N", [-1e3, 1e3], 0.0, "force F, inertial y").amplitude(),
        EffectParameter::new("force_z", "N", [-1e3, 1e3], 0.0, "force F, inertial z").amplitude().out_of_plane(),
    ],
    law: Law::Body(both!(law)),
    family: Family::Disturbance,
    what: "F fixed in inertial space, at the centre of mass; drag in orbit, a tow, a wind.",
    signature: "Velocity grows linearly, without torque.",
    confounders: "actuator_bias of a force at the same point at one attitude (identical); sensor_bias of the accelerometer on that axis (visible share 0.01), actuator_bias, thruster_leak, gravity_error.",
    experiment: "Turn the body: a bias turns with it, the force does not. A velocity or position sensor on that axis.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let force = to_body(local, constant([p[0], p[1], p[2]]));
    push(&mut action.wrench, local.surroundings.body_com_m, force, [T::zero(); 3]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_force_keeps_its_inertial_direction_and_has_no_moment_about_the_centre_of_mass() {
        let mut state = Trial::default();
        state.body.rotation = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        state.surroundings.body_com_m = [0.5, 0.0, 0.0];
        assert_eq!(state.wrench(&EFFECT, &[2.0, 0.0, 0.0]), [0.0, 0.0, -1.0, 0.0, -2.0, 0.0]);
    }
}
