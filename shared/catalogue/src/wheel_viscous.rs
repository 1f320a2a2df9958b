//! Bearing friction of a wheel in proportion to its speed.

use super::applies::wheel;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Viscous friction of a wheel: `−c W` on the rotor, its reaction on the body.
pub static EFFECT: Effect = Effect {
    kind: "wheel_viscous",
    title: "Viscous friction of a wheel",
    sites: &[SiteKind::Actuator],
    applies: wheel,
    parameters: &[EffectParameter::new("damping", "N m s/rad", [0.0, 0.01], 2e-5, "coefficient c").amplitude()],
    law: Law::Actuator(both!(law)),
    family: Family::Damping,
    what: "Friction -c W on the rotor turning at W relative to the body; the body takes +c W: torque on the body u + c W.",
    signature: "Body torque that follows wheel speed; the wheel runs down exponentially when unpowered.",
    confounders: "The wheel's own viscous friction where it has a prior (identical); wheel_coulomb in slews (cosine 0.94, below 0.85 in pulses); gravity_gradient in a multisine (0.93, below 0.85 in pulses).",
    experiment: "Pulses, or a spin-down through several speeds.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.value += local.rate.scale(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn friction_brakes_the_rotor_and_drags_the_body_along() {
        let state = Trial { command: 0.1, rate: 200.0, ..Trial::default() };
        assert_eq!(state.value(&EFFECT, &[0.001]), 0.1 + 0.2);
        for k in 0..200 {
            let state = Trial { command: 0.0, ..Trial::random(k) };
            let on_rotor = -state.value(&EFFECT, &[0.3]);
            assert!(on_rotor * state.rate <= 0.0);
        }
    }
}
