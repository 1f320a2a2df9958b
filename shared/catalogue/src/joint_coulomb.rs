//! Dry friction in a joint.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Coulomb friction: `F = −F_c tanh(q'/v0)`.
pub static EFFECT: Effect = Effect {
    kind: "joint_coulomb",
    title: "Coulomb friction in a joint",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("force", "J/*", [0.0, 1e5], 0.02, "friction force or torque F_c while moving").amplitude(),
        EffectParameter::new("smooth_rate", "*/s", [1e-6, 0.1], 1e-3, "rate v0 over which the sign turns").smoothing(),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Friction,
    what: "F = -F_c tanh(q'/v0); Coulomb 1785, smoothed so that a Jacobian exists (Andersson, Soederberg and Bjoerklund, 2007). \
           Sticking becomes creep slower than v0.",
    signature: "Joint torque residual jumps by 2 F_c where the joint rate changes sign; odd harmonics of a sinusoidal motion. Free \
                motion decays linearly, not exponentially, and stops.",
    confounders: "joint_viscous where all motion has one speed; joint_stribeck and joint_lugre at low rate; joint_torque_bias where the \
                  joint moves one way only.",
    experiment: "Slews at two speed levels in both directions: the Coulomb level stays, the viscous one doubles.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (force_c, v_0) = (p[0], p[1]);
    action.force -= local.rate.scale(1.0 / v_0).tanh().scale(force_c);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    #[test]
    fn friction_is_odd_tends_to_the_sign_of_the_rate_and_takes_four_amplitudes_of_work_a_cycle() {
        let force = |rate| Trial { rate, ..Trial::default() }.force(&EFFECT, &[0.3, 1e-3]);
        assert_eq!(force(1e-3), -0.3 * libm::tanh(1.0));
        assert_eq!(force(-0.2), -force(0.2));
        assert_eq!(force(0.1), -0.3); // tanh(100) is one
        // Dry friction takes 4 F a per cycle; the smoothing lacks less than 4 F a (v0 / a ω)² π²/12
        // of it
        let work = work_of_a_cycle(&EFFECT, &[0.3, 1e-3], 0.5, 2.0);
        assert!((work + 4.0 * 0.3 * 0.5).abs() < 4.0 * 0.3 * 0.5 * 1e-6, "{work}");
    }

    #[test]
    fn friction_never_drives() {
        for k in 0..500 {
            let state = Trial::random(k);
            assert!(state.force(&EFFECT, &[2.0, 1e-3]) * state.rate <= 0.0);
        }
    }
}
