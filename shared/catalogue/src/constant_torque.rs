//! A torque that stays.

use super::geometry::{constant, push, to_body};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Constant torque on a body, inertial axes.
pub static EFFECT: Effect = Effect {
    kind: "constant_torque",
    title: "Constant torque on a body",
    sites: &[SiteKind::Body],
    parameters: &[
        EffectParameter::new("torque_x", "N m", [-1e3, 1e3], 0.0, "torque T, inertial x").amplitude().out_of_plane(),
        EffectParameter::new("torque_y", "N m", [-1e3, 1e3], 0.0, "torque T, inertial y").amplitude().out_of_plane(),
        EffectParameter::new("torque_z", "N m", [-1e3, 1e3], 0.01, "torque T, inertial z").amplitude(),
    ],
    law: Law::Body(both!(law)),
    family: Family::Disturbance,
    what: "T fixed in inertial space; what is left of solar pressure, drag and magnetic torques over a short arc.",
    signature: "Rate grows linearly, or a wheel takes up momentum.",
    confounders: "actuator_bias, gravity_gradient and residual_dipole over a short arc, sensor_drift of the gyro.",
    experiment: "A longer arc; another attitude.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let torque = to_body(local, constant([p[0], p[1], p[2]]));
    push(&mut action.wrench, [0.0; 3], [T::zero(); 3], torque);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_torque_keeps_its_inertial_axis() {
        let mut state = Trial::default();
        state.body.rotation = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(state.wrench(&EFFECT, &[2.0, 0.0, 0.0]), [0.0, -2.0, 0.0, 0.0, 0.0, 0.0]);
        let up = state.wrench(&EFFECT, &[0.0, 0.0, 2.0]);
        assert!((up[2] - 2.0).abs() < 1e-15 && up[0].abs() < 1e-15 && up[1].abs() < 1e-15); // cos(π/2) = 6e-17
    }
}
