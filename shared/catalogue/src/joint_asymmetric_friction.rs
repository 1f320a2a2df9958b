//! Dry friction that differs with direction.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Friction that differs with direction: `F = −dF tanh²(q'/v0)`.
pub static EFFECT: Effect = Effect {
    kind: "joint_asymmetric_friction",
    title: "Friction that differs with direction",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("force", "J/*", [-1e5, 1e5], 0.01, "half the difference of the two Coulomb levels")
            .amplitude(),
        EffectParameter::new("smooth_rate", "*/s", [1e-6, 0.1], 1e-3, "rate v0 over which the sign turns").smoothing(),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Friction,
    what: "F = -dF tanh^2(q'/v0): with joint_coulomb the level is F_c + dF forwards and F_c - dF backwards; worm gears, seals, \
           brushes. By itself it brakes one way and drives the other.",
    signature: "Mean torque residual while moving, none at rest.",
    confounders: "joint_torque_bias (differs only at rest), gravity on a bench.",
    experiment: "Alternate slews and rests: a bias is there at rest, this is not.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let direction = local.rate.scale(1.0 / p[1]).tanh();
    action.force -= (direction * direction).scale(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_force_is_even_in_the_rate_full_when_moving_and_none_at_rest() {
        let force = |rate| Trial { rate, ..Trial::default() }.force(&EFFECT, &[0.3, 1e-3]);
        assert_eq!(force(0.0), 0.0);
        assert_eq!(force(0.5), -0.3);
        assert_eq!(force(-0.5), -0.3);
        assert!((force(1e-3) + 0.3 * libm::tanh(1.0) * libm::tanh(1.0)).abs() < 1e-16); // rounding
    }
}
