//! Dry bearing friction of a wheel.

use super::applies::wheel;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Coulomb friction of a wheel: `−T tanh(W/v0)` on the rotor, its reaction on the body.
pub static EFFECT: Effect = Effect {
    kind: "wheel_coulomb",
    title: "Coulomb friction of a wheel",
    sites: &[SiteKind::Actuator],
    applies: wheel,
    parameters: &[
        EffectParameter::new("torque", "N m", [0.0, 0.1], 1e-3, "drag torque T").amplitude(),
        EffectParameter::new("smooth_rate", "rad/s", [1e-3, 10.0], 0.1, "speed v0 over which the sign turns")
            .smoothing(),
    ],
    law: Law::Actuator(both!(law)),
    family: Family::Friction,
    what: "Friction -T tanh(W/v0) on the rotor; the body takes +T tanh(W/v0). Bialke 1998.",
    signature: "A step of body rate each time the wheel passes zero speed.",
    confounders: "wheel_viscous in slews (cosine 0.94), actuator_dead_zone.",
    experiment: "Take the wheel through zero speed slowly, both ways.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (torque, v_0) = (p[0], p[1]);
    action.value += local.rate.scale(1.0 / v_0).tanh().scale(torque);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn friction_brakes_the_rotor_by_the_sign_of_its_speed() {
        let value = |rate| Trial { rate, ..Trial::default() }.value(&EFFECT, &[0.01, 0.1]);
        assert_eq!(value(200.0), 0.01);
        assert_eq!(value(-200.0), -0.01);
        assert_eq!(value(0.1), 0.01 * libm::tanh(1.0));
        for k in 0..200 {
            let state = Trial { command: 0.0, ..Trial::random(k) };
            assert!(-state.value(&EFFECT, &[0.3, 0.1]) * state.rate <= 0.0);
        }
    }
}
