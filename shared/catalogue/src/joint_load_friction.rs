//! Friction that the load on the gear makes.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Load-dependent friction: `F = −μ |u| tanh(q'/v0)`, u the joint's actuator effort.
pub static EFFECT: Effect = Effect {
    kind: "joint_load_friction",
    title: "Load-dependent friction in a joint",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("coefficient", "1", [0.0, 0.8], 0.05, "friction per applied force or torque").amplitude(),
        EffectParameter::new("smooth_rate", "*/s", [1e-6, 0.1], 1e-3, "rate v0 over which the sign turns").smoothing(),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Friction,
    what: "F = -mu |u| tanh(q'/v0), u what the joint's actuators apply; gear meshing losses (Waiboer, Aarts and Jonker 2005; Hamon, \
           Gautier and Garrec 2010).",
    signature: "Coulomb friction whose level follows the torque: large while accelerating or holding against gravity, small in cruise.",
    confounders: "joint_coulomb at one load; motor_constant_error where the joint only drives, never brakes.",
    experiment: "The same slew with and without a payload; compare driving and braking phases.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (mu, v_0) = (p[0], p[1]);
    action.force -= local.command.abs() * local.rate.scale(1.0 / v_0).tanh().scale(mu);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn friction_is_the_coefficient_times_the_load_whatever_the_load_s_sign() {
        let force = |command, rate| Trial { command, rate, ..Trial::default() }.force(&EFFECT, &[0.1, 1e-3]);
        assert_eq!(force(5.0, 1.0), -0.5);
        assert_eq!(force(-5.0, 1.0), -0.5);
        assert_eq!(force(5.0, -1.0), 0.5);
        assert_eq!(force(0.0, 1.0), 0.0);
    }

    #[test]
    fn friction_never_drives() {
        for k in 0..500 {
            let state = Trial::random(k);
            assert!(state.force(&EFFECT, &[0.5, 1e-3]) * state.rate <= 0.0);
        }
    }
}
